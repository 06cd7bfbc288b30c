// What a search for a place costs, against the size of the map and of what was heard: CPU time of a whole
// search. Points strewn at one density, a fifth of what is heard new; worlds of the map and of another place.

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "leadline/submap/relocalizer.h"
#include "tests/submap/place_worlds.h"

namespace leadline {
namespace {

constexpr double kDensity = 0.05;  // [1/m^2]
constexpr double kReach = 10.0;    // [m]

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

void row(int landmarks, std::size_t heard_most, bool in_map) {
  constexpr int kSearches = 50;
  std::vector<double> times;
  int found = 0, wrong = 0, complete = 0;
  const double width = std::sqrt(landmarks / kDensity);
  for (int k = 1; k <= kSearches; ++k) {
    Random random(static_cast<std::uint64_t>(k));
    const std::vector<Landmark> map = strewn(landmarks, width, width, random);
    const std::vector<Landmark> world = in_map ? map : strewn(landmarks, width, width, random);
    Hearer hearer{.X_WV = {random.uniform(0.1, 0.9) * width, random.uniform(0.1, 0.9) * width,
                           random.uniform(-kPi, kPi)},
                  .X_WL = {}};
    std::vector<Landmark> heard = within(world, hearer.X_WV.position(), kReach);
    shuffle(heard, random);
    if (heard.size() > heard_most) heard.resize(heard_most);
    for (Landmark& landmark : heard)
      if (random.uniform(0.0, 1.0) < 0.2)
        landmark.value.head<2>() = hearer.X_WV.position() + Eigen::Vector2d(random.vector(2, 0.5 * kReach));
    Relocalizer relocalizer({}, map);
    const LocalPicture picture = hearer.picture(heard, random);
    const double begin = cpu_ms();
    const PlaceAnswer answer = relocalizer.search(picture);
    times.push_back(cpu_ms() - begin);
    complete += answer.complete;
    if (answer.verdict != PlaceAnswer::Verdict::found) continue;
    ++(in_map && is_near(answer.places.front().X_WV.X, hearer.X_WV) ? found : wrong);
  }
  std::ranges::sort(times);
  fmt::print("{:9} {:6} {:>10} {:9.1f} {:9.1f} {:7} {:7} {:9}\n", landmarks, heard_most,
             in_map ? "the map's" : "another", times[times.size() / 2], times.back(), found, wrong, complete);
}

}  // namespace
}  // namespace leadline

int main() {
  fmt::print("A search [ms of CPU], of 50\n{:>9} {:>6} {:>10} {:>9} {:>9} {:>7} {:>7} {:>9}\n", "landmarks",
             "heard", "place", "median", "most", "found", "wrong", "complete");
  for (const int landmarks : {15, 100, 1000, 5000})
    for (const std::size_t heard : {8, 16})
      for (const bool in_map : {true, false}) leadline::row(landmarks, heard, in_map);
}
