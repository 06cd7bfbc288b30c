#include "leadline/submap/aliases.h"

#include <algorithm>

namespace leadline {

Aliases::Aliases() { entries_.reserve(kMost); }

void Aliases::join(int lost, int kept) {
  const int from = resolve(lost);
  int to = resolve(kept);
  if (to == lost) {  // the other way round before: the name goes back
    to = kept;
    std::erase_if(entries_, [&](const Alias& entry) { return entry.lost == kept; });
  }
  if (from == to) return;
  for (Alias& entry : entries_)
    if (entry.kept == from) entry.kept = to;
  if (std::ssize(entries_) == kMost) entries_.erase(entries_.begin());
  entries_.push_back({from, to});
}

int Aliases::resolve(int id) const {
  const auto entry = std::ranges::find(entries_, id, &Alias::lost);
  return entry == entries_.end() ? id : entry->kept;
}

}  // namespace leadline
