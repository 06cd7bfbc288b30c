// Delays, gains, offsets and noise found by the innovations of recordings in which they are known.
#include "apps/evaluation/calibrate.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "apps/evaluation/judge.h"
#include "apps/recordings/import_car_park.h"
#include "apps/support/usage_error.h"
#include "leadline/core/angle.h"
#include "leadline/core/se2.h"
#include "tests/support/public_recording.h"
#include "tests/support/random.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr std::string_view kConfig = R"(
sensors:
  - {name: laser, kind: range_bearing, max_range_m: 30, range_sigma_m: 0.05, bearing_sigma_deg: 1}
vehicle:
  model: velocity
  initial: {x_sigma_m: 0.01, y_sigma_m: 0.01, heading_sigma_deg: 0.5}
  noise: {input_speed_sigma_mps: 0.05, input_yaw_rate_sigma_deg: 2}
map: {mode: global}
)";

/// What is said of the motion is wrong in known ways.
struct Wrong {
  double delay = 0.0;         // [s], of inputs
  double speed_gain = 1.0;    // true over said
  double turn_offset = 0.0;   // [rad/s], true less said
  double mount = 0.0;         // [rad], of the laser
  double range_offset = 0.0;  // [m], true less said
};

/// A vehicle winds its way among poles at 1 m/s; its speed changes as well.
Recording wind(const Wrong& wrong, std::uint64_t seed) {
  constexpr double kInputPeriod = 0.1, kDuration = 40.0;
  Random random(seed);
  Recording recording;
  std::vector<Eigen::Vector2d> poles;
  for (int i = 0; i < 6; ++i) poles.emplace_back(8.0 * std::cos(1.1 * i) + 2.0 * i, 9.0 * std::sin(1.1 * i));
  Pose2 X_WB;
  for (int k = 0; k * kInputPeriod < kDuration; ++k) {
    const double t = k * kInputPeriod;
    const VelocityInput is{1.0 + 0.4 * std::sin(0.9 * t), 0.5 * std::sin(0.6 * t) + 0.1};
    const auto utime = static_cast<std::int64_t>(std::llround(1e6 * t));
    Instant input;
    input.utime = utime + std::llround(1e6 * wrong.delay);
    input.input = VelocityInput{(is.speed + 0.05 * random.normal()) / wrong.speed_gain,
                                is.yaw_rate + from_degrees(2.0) * random.normal() - wrong.turn_offset};
    recording.instants.push_back(input);
    if (k % 4 == 0) {
      Instant scan;
      scan.utime = utime + 3;  // never that of an input
      for (std::size_t i = 0; i < poles.size(); ++i) {
        const Eigen::Vector2d seen = rotation(-X_WB.heading) * (poles[i] - X_WB.position());
        scan.sightings.push_back(
            {0, seen.norm() + 0.05 * random.normal() - wrong.range_offset,
             wrap_angle(std::atan2(seen.y(), seen.x()) - wrong.mount + from_degrees(1.0) * random.normal()),
             static_cast<int>(i)});
      }
      recording.instants.push_back(scan);
    }
    const double turn = is.yaw_rate * kInputPeriod, way = is.speed * kInputPeriod;
    X_WB = oplus(X_WB, {way * std::cos(0.5 * turn), way * std::sin(0.5 * turn), turn});
  }
  std::ranges::stable_sort(recording.instants, {}, &Instant::utime);
  return recording;
}

class CalibrateTest : public testing::Test {
 protected:
  std::map<std::string, Found> look(const Recording& recording, const std::vector<std::string>& sets = {}) {
    std::vector<Setting> settings;
    for (const std::string& text : sets) settings.push_back(Setting::parse(text));
    const Config config = read_config(path_, settings);
    const std::vector<Unknown> unknowns = unknowns_of(config, recording);
    calibration_ = calibrate(path_, settings, recording, unknowns, {.sweeps = 2, .jobs = 2, .progress = {}});
    std::map<std::string, Found> by_key;
    for (const Found& found : calibration_.found) by_key[found.unknown.key] = found;
    return by_key;
  }
  std::string yaml(bool noise) { return calibration_yaml(calibration_, read_config(path_), noise); }

  ScratchFolder folder_;
  std::filesystem::path path_ = folder_.write("c.yaml", kConfig);
  Calibration calibration_;
};

TEST_F(CalibrateTest, FindsWhatIsWrong) {
  const Wrong wrong{.delay = 0.25,
                    .speed_gain = 1.08,
                    .turn_offset = from_degrees(2.0),
                    .mount = from_degrees(3.0),
                    .range_offset = 0.12};
  auto found = look(wind(wrong, 1));
  EXPECT_NEAR(found["vehicle.corrections.input_delay_s"].value, 0.25, 0.03);
  EXPECT_NEAR(found["vehicle.speed_gain"].value, 1.08, 0.02);
  EXPECT_NEAR(found["vehicle.yaw_rate_offset_deg"].value, 2.0, 0.3);
  EXPECT_NEAR(found["sensors.0.yaw_deg"].value, 3.0, 0.5);
  EXPECT_NEAR(found["sensors.0.range_offset_m"].value, 0.12, 0.03);
  for (const char* key : {"vehicle.corrections.input_delay_s", "vehicle.speed_gain",
                          "vehicle.yaw_rate_offset_deg", "sensors.0.yaw_deg", "sensors.0.range_offset_m"})
    EXPECT_TRUE(found[key].is_news()) << key;
  EXPECT_GT(calibration_.after, calibration_.before + 100.0);

  EXPECT_THAT(yaml(false), AllOf(HasSubstr("sensors:\n  - name: laser\n"), HasSubstr("vehicle:\n"),
                                 HasSubstr("  corrections:\n    input_delay_s: 0.2")));
}

// One recording in which nothing is wrong may say so by chance in one of ten thousand keys.
TEST_F(CalibrateTest, LeavesAloneWhatIsRight) {
  look(wind({}, 2));
  EXPECT_EQ(yaml(false), "");
  EXPECT_EQ(yaml(true), "");
}

TEST_F(CalibrateTest, FindsTheNoiseByTheInnovations) {
  auto found = look(wind({}, 4), {"sensors.0.range_sigma_m=0.2", "vehicle.noise.input_yaw_rate_sigma_deg=8"});
  EXPECT_NEAR(found["sensors.0.range_sigma_m"].value, 0.05, 0.01);
  EXPECT_NEAR(found["vehicle.noise.input_yaw_rate_sigma_deg"].value, 2.0, 0.5);
  EXPECT_NEAR(found["sensors.0.bearing_sigma_deg"].value, 1.0, 0.2);
  EXPECT_THAT(yaml(true), HasSubstr("  noise:\n    input_yaw_rate_sigma_deg: "));
}

TEST_F(CalibrateTest, IsTheSameOnAnyNumberOfThreads) {
  const Recording recording = wind({.delay = 0.2}, 5);
  const std::vector<Unknown> unknowns{Unknown::of(read_config(path_), "vehicle.corrections.input_delay_s")};
  const auto found = [&](std::size_t jobs) {
    return calibrate(path_, {}, recording, unknowns, {.sweeps = 1, .jobs = jobs, .progress = {}}).found[0];
  };
  EXPECT_EQ(found(1).value, found(3).value);
  EXPECT_EQ(found(1).gain, found(3).gain);
}

std::vector<std::string> keys_of(const std::vector<Unknown>& unknowns) {
  std::vector<std::string> keys;
  for (const Unknown& unknown : unknowns) keys.push_back(unknown.key);
  return keys;
}

TEST_F(CalibrateTest, LooksForWhatTheRecordingTellsOf) {
  const Config config = read_config(path_);
  EXPECT_THAT(
      keys_of(unknowns_of(config, wind({}, 1))),
      AllOf(Contains("vehicle.corrections.input_delay_s"), Contains("sensors.0.yaw_deg"),
            Not(Contains("sensors.0.delay_s")), Not(Contains("vehicle.corrections.heading_delay_s"))));
  EXPECT_EQ(reference_delay(config, wind({}, 1)), "sensors.0.delay_s");
  EXPECT_THROW(Unknown::of(config, "vehicle.model"), UsageError);
  EXPECT_THROW(Unknown::of(config, "vehicle.nothing"), UsageError);
}

// Three sonars on one driver are late together.
TEST_F(CalibrateTest, SensorsOfOneKindAreWrongAlike) {
  const Config tank = read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs/tank_0p3.yaml");
  Recording recording;
  recording.instants.resize(1);
  recording.instants[0].heading = Reading{};
  recording.instants[0].sightings = {{0, 1.0}, {1, 1.0}, {2, 1.0}};
  EXPECT_THAT(keys_of(unknowns_of(tank, recording)),
              AllOf(Contains("sensors.*.delay_s"), Contains("sensors.*.range_offset_m"),
                    Not(Contains("vehicle.corrections.heading_delay_s"))));
  EXPECT_EQ(reference_delay(tank, recording), "vehicle.corrections.heading_delay_s");
}

// A recording that was not made here, calibrated from the innovations: all poles and no other, whatever the
// inputs' noise is believed to be.
class CalibratedCarParkTest : public testing::TestWithParam<double> {};

TEST_P(CalibratedCarParkTest, FindsAllPolesAtAnyNoise) {
  const auto source = public_recording("car_park");
  if (!source) GTEST_SKIP() << kNoRecordings;
  const std::filesystem::path path = std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs/car_park.yaml";
  const auto scaled = [](const char* key, double value) {
    return Setting::parse(fmt::format("vehicle.noise.{}={}", key, GetParam() * value));
  };
  const Config config =
      read_config(path, {scaled("input_speed_sigma_mps", 1.0), scaled("input_steering_sigma_deg", 8.0),
                         scaled("sway_sigma_m", 0.02)});
  Recording recording = import_car_park(*source).recording;
  std::erase_if(recording.instants, [&](const Instant& instant) {
    return instant.utime > recording.instants.front().utime + std::llround(1e6 * config.log_duration);
  });
  correct(recording.instants, config.corrections);
  const Judgement judgement = judge(run(config.slam, recording), recording, config.truth_frame);
  EXPECT_LT(judgement.value("ate_se2_m"), 0.06);
  EXPECT_EQ(judgement.value("landmarks_found"), 15.0);
  EXPECT_EQ(judgement.value("landmarks_spurious"), 0.0);
}

INSTANTIATE_TEST_SUITE_P(TimesTheShipped, CalibratedCarParkTest, testing::Values(0.2, 0.5, 1.0, 2.0));

}  // namespace
}  // namespace leadline::app
