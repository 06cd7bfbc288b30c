// The configuration for recordings of beacons, on one of the format that it names.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "apps/config/config.h"
#include "apps/recordings/import_csv.h"
#include "leadline/submap/slam.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

/// Round a square of 20 m, beacons 5 and 9 heard in turn, without noise but with a false range now and then.
void write_recording(const ScratchFolder& folder) {
  std::string odometry = "t,dx,dy,dheading\n", ranges = "t,channel,range,label\n";
  Pose2 X_WB;
  for (int step = 0; step < 400; ++step) {
    const Pose2 motion{step > 0 ? 0.2 : 0.0, 0.0, step > 0 && step % 100 == 0 ? kPi / 2.0 : 0.0};
    X_WB = oplus(X_WB, motion);
    odometry += fmt::format("{:.1f},{},0,{}\n", 0.5 * step, motion.x, motion.heading);
    const Eigen::Vector2d beacon = step % 2 == 0 ? Eigen::Vector2d(10.0, 30.0) : Eigen::Vector2d(-8.0, 5.0);
    const double range = step % 31 == 30 ? 3.0 : (beacon - X_WB.position()).norm();
    ranges += fmt::format("{:.1f},beacons,{:.4f},{}\n", 0.5 * step, range, step % 2 == 0 ? 5 : 9);
  }
  folder.write("odometry.csv", odometry);
  folder.write("range_sonar.csv", ranges);
}

TEST(BeaconRecording, BeaconsAreFoundWithTheShippedConfiguration) {
  const ScratchFolder folder;
  write_recording(folder);
  const Import import = import_csv(folder.path());
  const Config config =
      read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "beacons.yaml", {});
  Slam slam(config.slam);
  for (const Instant& instant : import.recording.instants) ASSERT_TRUE(slam.step(instant));
  ASSERT_EQ(slam.features().size(), 2U);
  for (const Feature& feature : slam.features()) {
    const Eigen::Vector2d beacon =
        feature.label == 5 ? Eigen::Vector2d(10.0, 30.0) : Eigen::Vector2d(-8.0, 5.0);
    EXPECT_LT((slam.belief().position(feature.point_slot) - beacon).norm(), 0.3) << feature.label;
  }
}

}  // namespace
}  // namespace leadline::app
