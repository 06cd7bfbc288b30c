// What association says of its own decisions is so: of the matches said to be right with a probability, that
// share is.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string_view>
#include <vector>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/run.h"

namespace leadline::app {
namespace {

/// Matches within a range of stated probabilities.
struct Bin {
  double from;
  int matches = 0, right = 0;
  double stated = 0.0;  // sum

  double share() const { return static_cast<double>(right) / matches; }
  double mean() const { return stated / matches; }
};

/// The object that began each feature, by the true labels, which the estimator has not used.
std::map<int, int> objects(const RunTrace& trace) {
  std::map<int, int> object;
  for (const Return& r : trace.returns)
    if (r.association.decision == Decision::fresh) object.emplace(r.association.feature, r.sighting.label);
  return object;
}

using Bins = std::array<Bin, 5>;

Bins calibrate(const char* file, bool learn) {
  Bins bins{{{0.0}, {0.8}, {0.9}, {0.97}, {0.99}}};
  std::vector<Setting> settings;
  if (std::string_view(file).starts_with("field")) settings = {{"simulation.field.steps", "2000", "--set"}};
  Config config = read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / file, settings);
  config.slam.association.method = AssociationMethod::joint;
  config.slam.association.learn = learn;
  for (std::uint64_t seed = 1; seed <= 1; ++seed) {
    const RunTrace trace = run(config.slam, simulate(config, seed));
    const std::map<int, int> object = objects(trace);
    for (const Return& r : trace.returns) {
      const bool is_match =
          r.association.decision == Decision::matched || r.association.decision == Decision::root;
      if (!is_match || !object.contains(r.association.feature)) continue;
      std::size_t k = bins.size() - 1;
      while (r.association.posterior < bins[k].from) --k;
      ++bins[k].matches;
      bins[k].stated += r.association.posterior;
      bins[k].right += object.at(r.association.feature) == r.sighting.label;
    }
  }
  return bins;
}

constexpr int kEnough = 300;  // matches, to tell a share

// The densities that are given by default are high, for a wrong match costs more than a missed one.
TEST(Calibration, NoMatchIsLessSureThanItIsSaidToBe) {
  for (const char* file : {"harbour_loops.yaml", "field_50.yaml"})
    for (const Bin& bin : calibrate(file, false))
      EXPECT_TRUE(bin.matches < kEnough || bin.share() > bin.mean() - 0.02) << file << " from " << bin.from;
}

TEST(Calibration, WithLearntDensitiesTheStatedShareIsRight) {
  for (const Bin& bin : calibrate("field_50.yaml", true)) {
    const double sampling = 3.0 * std::sqrt(bin.mean() * (1.0 - bin.mean()) / bin.matches);
    if (bin.from < 0.8) continue;
    EXPECT_NEAR(bin.share(), bin.mean(), 0.02 + sampling) << "from " << bin.from;
  }
}

}  // namespace
}  // namespace leadline::app
