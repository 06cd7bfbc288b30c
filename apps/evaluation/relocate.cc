#include "apps/evaluation/relocate.h"

#include <optional>
#include <utility>

#include "leadline/submap/place_search.h"

namespace leadline::app {

Relocation relocate(const SlamOptions& options, std::vector<Landmark> map, RecordingSource& source,
                    const std::function<void()>& progress) {
  validate(options);
  Relocation outcome;
  std::optional<Instant> instant = source.next_instant();
  if (!instant) return outcome;
  const std::int64_t begin = instant->utime;
  LocalSlam own(options);
  own.set_clock(begin);
  const Reading any{0.0, kPi};
  own.lose_place(pose_in_own_frame(options, instant->heading.value_or(any)));
  PlaceSearch search(std::move(own), std::move(map), {});
  for (; instant && !search.found(); instant = source.next_instant()) {
    if (progress) progress();
    search.step(*instant);
    if (search.searches() == outcome.searches) continue;
    outcome = {search.found() != nullptr, search.answer(), search.own().utime(), 0.0, search.searches()};
    outcome.after = 1e-6 * static_cast<double>(outcome.utime - begin);
  }
  return outcome;
}

}  // namespace leadline::app
