#include "leadline/sonar_sim/world_change.h"

#include <string>

namespace leadline {

void visit(OptionVisitor& visitor, std::vector<WorldChange>& changes, int objects) {
  constexpr Limits kTime{0.001, 1e6}, kCount{0, 1000};
  double before = 0.0;
  visitor.sections(
      "changes", "Objects taken away and added during the run, in the order of time.", changes.size(),
      [&](std::size_t size) { changes.assign(size, {}); },
      [&](std::size_t i) {
        WorldChange& change = changes[i];
        visitor.number("at_s", change.time, kTime, {"s", "since the beginning"});
        visitor.require(change.time > before, "at_s", "later than that of the change before");
        visitor.integer("removed", change.removed, kCount, {"", "taken away, drawn from those there"});
        visitor.require(change.removed <= objects, "removed",
                        "at most " + std::to_string(objects) + ", the objects there by then");
        visitor.integer("added", change.added, kCount, {"", "put where objects may be"});
        before = change.time;
        objects += change.added - change.removed;
      });
}

std::vector<std::size_t> draw(Noise& noise, std::vector<std::size_t> among, int count) {
  std::vector<std::size_t> drawn;
  for (int k = 0; k < count; ++k) {
    const auto i = static_cast<std::ptrdiff_t>(noise.uniform(0.0, static_cast<double>(among.size())));
    drawn.push_back(among[static_cast<std::size_t>(i)]);
    among.erase(among.begin() + i);
  }
  return drawn;
}

}  // namespace leadline
