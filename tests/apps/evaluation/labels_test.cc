// Labels of a harbour that are wrong of themselves are found out; those that are wrong now and then are not
// taken for such.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/run.h"

namespace leadline::app {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr int kSpare = 1000;  // a label that no target has

class HarbourLabels : public testing::Test {
 protected:
  HarbourLabels()
      : config_(read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "harbour_loops.yaml",
                            {{"simulation.sonars.wrong_label", "0.02", "--set"}})) {}

  /// @param relabel what becomes of every sighting.
  template <class Relabel>
  RunTrace run_with(std::uint64_t seed, Relabel relabel) {
    recording_ = simulate(config_, seed);
    for (Instant& instant : recording_.instants)
      for (Sighting& sighting : instant.sightings) relabel(sighting);
    return run(config_.slam, recording_);
  }
  static std::vector<std::string> of_labels(const RunTrace& trace) {
    std::vector<std::string> complaints;
    for (const std::string& complaint : trace.complaints)
      if (complaint.starts_with("label")) complaints.push_back(complaint);
    return complaints;
  }

  Config config_;
  Recording recording_;
};

TEST_F(HarbourLabels, ErrorsAtRandomAreCountedAndNothingElse) {
  for (const std::uint64_t seed : {1U, 2U}) {
    const RunTrace trace = run_with(seed, [](Sighting&) {});
    EXPECT_THAT(of_labels(trace), IsEmpty()) << seed;
    EXPECT_GT(trace.health.labels_refused, 10) << seed;
    std::int64_t refused = 0;
    for (const auto& of : trace.refused_labels) refused += of.count;
    EXPECT_LE(refused, trace.health.labels_refused) << seed;
    EXPECT_EQ(judge(trace, recording_, config_.truth_frame).value("labels_refused"),
              static_cast<double>(trace.health.labels_refused));
  }
}

TEST_F(HarbourLabels, AnObjectOfTwoLabelsIsNamed) {
  int returns = 0;
  const RunTrace trace = run_with(1, [&](Sighting& sighting) {
    if (sighting.label == 2 && ++returns % 2 == 0) sighting.label = kSpare;
  });
  EXPECT_THAT(of_labels(trace), Contains("labels 2 and 1000 are one place"));
}

TEST_F(HarbourLabels, ALabelOnTwoObjectsIsNamed) {
  const RunTrace trace = run_with(1, [](Sighting& sighting) {
    if (sighting.label == 67) sighting.label = 48;  // 3 m away
  });
  EXPECT_THAT(of_labels(trace), ElementsAre("label 48 names two places"));
}

}  // namespace
}  // namespace leadline::app
