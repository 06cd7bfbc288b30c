#include "leadline/sonar_sim/field_simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "statistics.h"
#include "tests/sonar_sim/expect_refused.h"

namespace leadline {
namespace {

Pose2 pose(const Truth& truth) { return {truth.x, truth.y, *truth.heading}; }

FieldOptions short_run(std::int64_t steps) {
  FieldOptions options;
  options.steps = steps;
  return options;
}

TEST(FieldSimulatorTest, FieldHasItsDensity) {
  FieldOptions options = short_run(0);
  options.landmarks = 5000;
  const Recording run = record(options, 1);
  ASSERT_EQ(run.map.size(), 5000U);
  const double side = std::sqrt(5000.0 / 0.12);
  double quarter = 0.0;
  for (std::size_t i = 0; i < run.map.size(); ++i) {
    const TrueFeature& landmark = run.map[i];
    EXPECT_EQ(landmark.label, static_cast<int>(i));
    EXPECT_EQ(landmark.kind, TargetKind::point);
    EXPECT_GE(landmark.x, -3.0);
    EXPECT_LE(landmark.x, side - 3.0);
    EXPECT_GE(landmark.y, -2.0);
    EXPECT_LE(landmark.y, side - 2.0);
    quarter += landmark.x < side / 2 - 3.0 && landmark.y < side / 2 - 2.0 ? 1.0 : 0.0;
  }
  EXPECT_THAT(quarter, IsBinomial(5000, 0.25));
}

TEST(FieldSimulatorTest, StartsAtTheOriginWithoutIncrement) {
  FieldSimulator simulator(short_run(10), 1);
  const auto first = simulator.next();
  ASSERT_TRUE(first);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(first->instant.input));
  EXPECT_EQ(first->truth.x, 0.0);
  EXPECT_EQ(first->truth.y, 0.0);
  EXPECT_EQ(*first->truth.heading, 0.0);
  int increments = 0;
  while (const auto step = simulator.next()) {
    EXPECT_TRUE(std::holds_alternative<OdometryInput>(step->instant.input));
    EXPECT_EQ(step->instant.utime, ++increments * 1000000);
    EXPECT_FALSE(step->instant.heading || step->instant.speed) << "no absolute reference";
    EXPECT_EQ(*step->truth.speed, 0.5);
  }
  EXPECT_EQ(increments, 10);
}

TEST(FieldSimulatorTest, OdometryIsTheTrueIncrementWithNoise) {
  const Recording run = record(short_run(3000), 1);
  std::vector<double> dx, dy, dheading;
  for (std::size_t k = 1; k < run.truth.size(); ++k) {
    const Pose2 motion = oplus(inverse(pose(run.truth[k - 1])), pose(run.truth[k]));
    EXPECT_NEAR(motion.position().norm(), 0.5, 0.01) << "shorter in turns: a chord";
    const auto& odometry = std::get<OdometryInput>(run.instants[k].input);
    dx.push_back(odometry.dx - motion.x);
    dy.push_back(odometry.dy - motion.y);
    dheading.push_back(angle_difference(odometry.dheading, motion.heading));
  }
  EXPECT_THAT(dx, HasMoments(0.0, 0.02));
  EXPECT_THAT(dy, HasMoments(0.0, 0.02));
  EXPECT_THAT(dheading, HasMoments(0.0, from_degrees(0.5)));
}

TEST(FieldSimulatorTest, HeadingSensorReadsAtEveryStep) {
  FieldOptions options = short_run(3000);
  options.heading.rate = 1.0;
  const Recording run = record(options, 1), plain = record(short_run(3000), 1);
  std::vector<double> errors;
  for (std::size_t k = 0; k < run.truth.size(); ++k) {
    ASSERT_TRUE(run.instants[k].heading);
    errors.push_back(angle_difference(run.instants[k].heading->value, *run.truth[k].heading));
    EXPECT_EQ(run.instants[k].sightings.size(), plain.instants[k].sightings.size());
  }
  EXPECT_THAT(errors, HasMoments(0.0, from_degrees(1.0)));
}

TEST(FieldSimulatorTest, HeadingDriftsPerSecondWhateverTheStep) {
  FieldOptions options = short_run(3000);
  options.step_time = 4.0;
  options.heading = {.rate = 1.0, .sigma = 0.0, .drift_sigma = from_degrees(0.1)};
  const Recording run = record(options, 1);
  std::vector<double> errors, drift;
  for (std::size_t k = 0; k < run.truth.size(); ++k)
    errors.push_back(angle_difference(run.instants[k].heading->value, *run.truth[k].heading));
  for (std::size_t k = 1; k < errors.size(); ++k) drift.push_back(angle_difference(errors[k], errors[k - 1]));
  EXPECT_THAT(drift, HasMoments(0.0, from_degrees(0.2)));
}

TEST(FieldSimulatorTest, FaultsOfTheSensorLeaveWhatItSeesAsItWas) {
  FieldOptions options = short_run(1000);
  const Recording clean = record(options, 1);
  options.dropout = 0.2;
  options.clutter = 3.0;
  options.wrong_label = 0.1;
  const Recording faulty = record(options, 1);
  double seen = 0, kept = 0, wrong = 0, nothing = 0;
  std::vector<double> square_ranges;
  for (std::size_t k = 0; k < clean.instants.size(); ++k) {
    std::map<double, int> labels;  // by range
    for (const Sighting& sighting : clean.instants[k].sightings) labels[sighting.range] = sighting.label;
    seen += static_cast<double>(labels.size());
    for (const Sighting& sighting : faulty.instants[k].sightings) {
      const auto original = labels.find(sighting.range);
      if (sighting.label == Sighting::kUnknown) {
        ++nothing;
        square_ranges.push_back(sighting.range * sighting.range);
        EXPECT_LE(sighting.range, options.max_range);
        continue;
      }
      ASSERT_NE(original, labels.end());
      ++kept;
      wrong += sighting.label != original->second;
    }
  }
  EXPECT_NEAR(kept / seen, 0.8, 0.03);
  EXPECT_NEAR(wrong / kept, 0.1, 0.03);
  EXPECT_NEAR(nothing / 1001.0, 3.0, 0.3);
  // Even over the disc: the mean square is half the largest.
  EXPECT_NEAR(std::accumulate(square_ranges.begin(), square_ranges.end(), 0.0) / nothing, 8.0, 0.5);
}

TEST(FieldSimulatorTest, SightingsAreTheTrueRangesAndBearingsWithNoise) {
  FieldOptions options = short_run(1000);
  options.landmarks = 1000;
  const Recording run = record(options, 1);
  std::vector<double> range_errors, bearing_errors;
  for (std::size_t k = 0; k < run.truth.size(); ++k) {
    const Pose2 X_BW = inverse(pose(run.truth[k]));
    std::set<int> expected, seen;
    for (const TrueFeature& landmark : run.map) {
      const double range = transform(X_BW, {landmark.x, landmark.y}).norm();
      if (range >= options.min_range && range <= options.max_range) expected.insert(landmark.label);
    }
    for (const Sighting& sighting : run.instants[k].sightings) {
      seen.insert(sighting.label);
      const TrueFeature& landmark = run.map[static_cast<std::size_t>(sighting.label)];
      const Eigen::Vector2d p_BL = transform(X_BW, {landmark.x, landmark.y});
      range_errors.push_back(sighting.range - p_BL.norm());
      bearing_errors.push_back(angle_difference(sighting.bearing, std::atan2(p_BL.y(), p_BL.x())));
      EXPECT_GT(sighting.range, 0.0);
      EXPECT_LE(std::abs(sighting.bearing), kPi);
      EXPECT_EQ(sighting.sensor, 0);
    }
    EXPECT_EQ(seen, expected);
    EXPECT_TRUE(std::ranges::is_sorted(run.instants[k].sightings, {}, &Sighting::label));
  }
  EXPECT_THAT(range_errors, HasMoments(0.0, 0.1));
  EXPECT_THAT(bearing_errors, HasMoments(0.0, from_degrees(1.5)));
}

// The density times the part of the field that is in range, on average along the path.
TEST(FieldSimulatorTest, AboutFiveSightingsAStep) {
  const FieldOptions options = short_run(250);
  const double side = std::sqrt(options.landmarks / options.density), cell = 0.1;
  const Path path = FieldSimulator(options, 1).path();
  std::vector<double> in_range;
  for (double s = 0.0; s < path.length(); s += 1.0) {
    int cells = 0;
    for (double x = cell / 2; x < side; x += cell) {
      for (double y = cell / 2; y < side; y += cell) {
        const double range = (path.at(s).position() - Eigen::Vector2d(x - 3.0, y - 2.0)).norm();
        cells += range >= options.min_range && range <= options.max_range ? 1 : 0;
      }
    }
    in_range.push_back(options.density * cells * cell * cell);
  }
  std::vector<double> sightings;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    double count = 0.0;
    for (const Instant& instant : record(options, seed).instants) {
      count += static_cast<double>(instant.sightings.size());
    }
    sightings.push_back(count / 251.0);
  }
  EXPECT_NEAR(mean(sightings), mean(in_range),
              kStandardErrors * standard_deviation(sightings) / std::sqrt(50.0));
  EXPECT_NEAR(mean(sightings), 5.0, 0.5);
}

TEST(FieldSimulatorTest, EveryLandmarkIsSeenOnEveryLoop) {
  FieldSimulator simulator(short_run(600), 1);
  std::set<int> first, second;
  double travelled = 0.0;
  while (const auto step = simulator.next()) {
    std::set<int>& loop = travelled < simulator.path().length() ? first : second;
    if (travelled < 2.0 * simulator.path().length()) {
      for (const Sighting& sighting : step->instant.sightings) loop.insert(sighting.label);
    }
    travelled += 0.5;
  }
  EXPECT_GE(travelled, 2.0 * simulator.path().length());
  EXPECT_EQ(first.size(), 50U);
  EXPECT_EQ(second.size(), 50U);
}

TEST(FieldSimulatorTest, FieldOfView) {
  FieldOptions options = short_run(300);
  options.field_of_view = from_degrees(90.0);
  options.bearing_sigma = 0.0;
  double all_round = 0.0, ahead = 0.0;
  for (const Instant& instant : record(options, 1).instants) {
    for (const Sighting& sighting : instant.sightings) {
      EXPECT_LE(std::abs(sighting.bearing), from_degrees(45.0) + 1e-12);
      ++ahead;
    }
  }
  options.field_of_view = 2.0 * kPi;
  for (const Instant& instant : record(options, 1).instants)
    all_round += static_cast<double>(instant.sightings.size());
  EXPECT_NEAR(ahead / all_round, 0.25, 0.05);
}

TEST(FieldSimulatorTest, EqualSeedsGiveEqualRecordings) {
  const auto digest = [](std::uint64_t seed) {
    std::vector<double> values;
    for (const Instant& instant : record(short_run(100), seed).instants) {
      if (const auto* odometry = std::get_if<OdometryInput>(&instant.input)) values.push_back(odometry->dx);
      for (const Sighting& sighting : instant.sightings) {
        values.insert(values.end(), {sighting.range, sighting.bearing, static_cast<double>(sighting.label)});
      }
    }
    return values;
  };
  EXPECT_EQ(digest(3), digest(3));
  EXPECT_NE(digest(3), digest(4));
}

TEST(FieldOptionsTest, MessagesNameOptionValueAndWhatIsAllowed) {
  const Refusal<FieldOptions> cases[] = {
      {[](FieldOptions& o) { o.steps = -1; }, "field.steps is -1, must be from 0 to"},
      {[](FieldOptions& o) { o.density = 0.0; }, "field.density_per_m2 is 0, must be from 0.001"},
      {[](FieldOptions& o) { o.landmarks = 3; }, "field.landmarks is 3, must be enough"},
      {[](FieldOptions& o) { o.lane_spacing = 1.0; },
       "field.lane_spacing_m is 1, must be at least 2 turn_radius_m"},
      {[](FieldOptions& o) {
         o.lane_spacing = 3.2;
         o.turn_radius = 1.6;
       },
       "field.turn_radius_m is 1.6, must be at most"},
      {[](FieldOptions& o) { o.max_range = 0.1; },
       "sensor.max_range_m is 0.1, must be greater than min_range_m"},
      {[](FieldOptions& o) { o.range_sigma = std::nan(""); }, "sensor.range_sigma_m is nan, must be from 0"},
      {[](FieldOptions& o) { o.heading.rate = 1e-9; },
       "heading.rate_hz is 1e-09, must be 0 or at least 0.001"},
  };
  expect_refused(cases);
}

TEST(FieldSimulatorTest, LandmarksAreSeenWhileTheyAreThere) {
  FieldOptions options = short_run(2000);
  const Recording still = record(options, 3);
  options.epoch = 7'000'000;
  options.changes = {{.time = 1000.0, .removed = 20, .added = 10}};
  const Recording run = record(options, 3);
  ASSERT_EQ(run.map.size(), 60U);
  const std::int64_t change = options.epoch + 1'000'000'000;
  std::map<int, int> before, after;
  for (const Instant& instant : run.instants)
    for (const Sighting& s : instant.sightings) ++(instant.utime < change ? before : after)[s.label];
  int gone = 0;
  for (const TrueFeature& landmark : run.map) {
    const auto i = static_cast<std::size_t>(landmark.label);
    if (i < still.map.size()) {
      EXPECT_EQ(landmark.x, still.map[i].x);
    }
    if (i >= still.map.size()) {
      EXPECT_EQ(landmark.life.from, change);
    }
    gone += landmark.life.until == change ? 1 : 0;
    if (landmark.life.from == change) {
      EXPECT_EQ(before[landmark.label], 0);
    }
    if (landmark.life.until == change) {
      EXPECT_EQ(after[landmark.label], 0);
    }
  }
  EXPECT_EQ(gone, 20);
  EXPECT_GT(
      std::ranges::count_if(after, [](const auto& seen) { return seen.first >= 50 && seen.second > 0; }), 5);
}

}  // namespace
}  // namespace leadline
