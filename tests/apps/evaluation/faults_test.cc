// What goes wrong on a vehicle costs little, and nobody is told a lie.
#include "apps/evaluation/faults.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "apps/config/config.h"
#include "apps/config/health_words.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/run.h"
#include "tests/support/constants.h"

namespace leadline::app {
namespace {

constexpr std::uint64_t kFaultSeeds = 20;

Config shipped_config(std::string_view name) {
  return read_config(fmt::format("{}/configs/{}.yaml", LEADLINE_SOURCE_DIR, name));
}

Config faulty_tank() { return shipped_config("tank_0p3"); }

struct FaultSums {
  double square = 0.0, nees = 0.0, not_above = 0.0;

  void add(const Config& config, const Recording& recording) {
    const Judgement judgement = judge(run(config.slam, recording), recording, config.truth_frame);
    square += std::pow(*judgement.value("rmse_position_m"), 2);
    nees += *judgement.value("nees_mean") / kFaultSeeds;
    not_above += *judgement.value("nees_not_above_95") / kFaultSeeds;
  }
};

struct FaultCase {
  std::string_view fault;
  double error;  // times that of the clean runs
};

class Faults : public testing::TestWithParam<FaultCase> {};

TEST_P(Faults, CostLittleAndTheCovarianceKnows) {
  const Config config = faulty_tank();
  FaultSums clean, faulty;
  for (std::uint64_t seed = 1; seed <= kFaultSeeds; ++seed) {
    Recording recording = simulate(config, seed);
    clean.add(config, recording);
    fault(GetParam().fault).put_into(recording, seed);
    faulty.add(config, recording);
  }
  EXPECT_LE(std::sqrt(faulty.square / clean.square), GetParam().error);
  EXPECT_LE(faulty.nees, 4.0);
  EXPECT_GE(faulty.not_above, 0.94);
}

// Of a speed that is not known any more is known what the sonars tell of it.
INSTANTIATE_TEST_SUITE_P(All, Faults,
                         testing::Values(FaultCase{"one_speed", 1.05}, FaultCase{"one_heading", 1.05},
                                         FaultCase{"speed_zero", 2.0}, FaultCase{"speed_frozen", 2.0},
                                         FaultCase{"heading_frozen", 1.3}, FaultCase{"heading_off", 1.1},
                                         FaultCase{"heading_silent", 1.1}, FaultCase{"heading_sigma", 1.001}),
                         [](const auto& tested) { return std::string(tested.param.fault); });

TEST(TinySigma, IsSaidAndNotBelieved) {
  const Config config = faulty_tank();
  Recording recording = simulate(config, 1);
  for (Instant& instant : recording.instants) {
    if (instant.heading) instant.heading->sigma = 1e-12;
    if (instant.speed) instant.speed->sigma = 0.011 * config.slam.readings.speed;  // small, but may be
    for (Sighting& sighting : instant.sightings) sighting.sigma = sighting.sensor == 1 ? 1e-9 : 0.03;
  }
  const RunTrace trace = run(config.slam, recording);
  const auto is_tiny = [](const Trouble& trouble) {
    return trouble.finding.kind == Finding::Kind::tiny_sigma;
  };
  ASSERT_EQ(std::ranges::count_if(trace.troubles, is_tiny), 2);
  const auto is_of_sonar = [&](const Trouble& trouble) {
    return is_tiny(trouble) && trouble.finding.channel == static_cast<int>(kReadingChannels) + 1;
  };
  EXPECT_TRUE(std::ranges::any_of(trace.troubles, is_of_sonar));
  const Trouble& tiny = *std::ranges::find_if(trace.troubles, is_tiny);
  EXPECT_EQ(tiny.finding.channel, static_cast<int>(ReadingChannel::heading));
  EXPECT_THAT(sentence(tiny.finding, config.slam.sensors, "AUV_"),
              testing::StartsWith("AUV_HEADING: brings a standard deviation of 5.73e-11 deg, not believed"));
  EXPECT_EQ(trace.states.back().standing, Standing::degraded);
}

// A turn by 90 degrees within the step that was lost is not always found again; all else is.
TEST(CountedLosses, CostLittleUnlessACornerIsLost) {
  const Config config = read_config(LEADLINE_SOURCE_DIR "/configs/field_50.yaml",
                                    {Setting::parse("simulation.field.steps=2000")});
  int good = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Recording recording = simulate(config, seed);
    FaultSums clean, lossy;
    clean.add(config, recording);
    fault("counted_lost").put_into(recording, seed);
    lossy.add(config, recording);
    good += std::sqrt(lossy.square / clean.square) <= 1.3;
  }
  EXPECT_GE(good, 5);
}

double seconds_from(std::int64_t from, std::int64_t to) { return 1e-6 * static_cast<double>(to - from); }

class SaidFaults : public testing::TestWithParam<std::string_view> {};

TEST_P(SaidFaults, AreSaidSoonAndNotForLongAfter) {
  const Config config = faulty_tank();
  for (std::uint64_t seed = 1; seed <= kFaultSeeds; ++seed) {
    Recording recording = simulate(config, seed);
    const Lifetime time = fault(GetParam()).put_into(recording, seed);
    const RunTrace trace = run(config.slam, recording);
    EXPECT_FALSE(trace.troubles.empty());
    for (const VehicleState& state : trace.states) {
      const bool is_before = state.utime<time.from, is_over = seconds_from(time.until, state.utime)> 15.0;
      const bool is_known = time.contains(state.utime) && seconds_from(time.from, state.utime) > 9.0;
      const bool is_ok = state.standing == Standing::ok;
      EXPECT_FALSE((is_before || is_over) && !is_ok) << seed << " at " << state.utime;
      EXPECT_FALSE(is_known && is_ok) << seed << " at " << state.utime;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, SaidFaults,
                         testing::Values("speed_zero", "heading_frozen", "heading_off", "heading_silent"),
                         [](const auto& tested) { return std::string(tested.param); });

constexpr std::uint64_t kMissions = 3;  // the fault is of each sonar once

Config harbour(AssociationMethod method) {
  Config config = read_config(LEADLINE_SOURCE_DIR "/configs/harbour_loops.yaml");
  config.slam.association.method = method;
  return config;
}

/// [s] from @p begin to the first finding of a sensor; nothing: there was none.
std::optional<double> named_after(const RunTrace& trace, int sensor, std::int64_t begin) {
  std::optional<double> after;
  for (const Trouble& trouble : trace.troubles)
    if (trouble.finding.channel == static_cast<int>(kReadingChannels) + sensor)
      after = std::min(after.value_or(kInfinity), trouble.from);
  if (after) *after -= seconds_from(trace.states.front().utime, begin);
  return after;
}

class StuckSonars : public testing::TestWithParam<AssociationMethod> {};

// Without that every second of these missions is lost.
TEST_P(StuckSonars, AreNamedAndCostLittle) {
  const Config config = harbour(GetParam());
  for (std::uint64_t seed = 1; seed <= kMissions; ++seed) {
    const Recording recording = simulate(config, seed);
    const RunTrace clean = run(config.slam, recording);
    const double error = *judge(clean, recording, config.truth_frame).value("rmse_position_m");
    EXPECT_TRUE(clean.troubles.empty());
    for (const std::string_view name : {"sonar_stuck", "sonar_stuck_for_good", "sonar_stuck_at_random"}) {
      Recording faulty = recording;
      const Lifetime time = fault(name).put_into(faulty, seed);
      const RunTrace trace = run(config.slam, faulty);
      EXPECT_LT(*judge(trace, faulty, config.truth_frame).value("rmse_position_m"), 1.3 * error + 0.05)
          << name << ", seed " << seed;
      const std::optional<double> named = named_after(trace, sensor_at_fault(faulty, seed), time.from);
      ASSERT_TRUE(named) << name << ", seed " << seed;
      EXPECT_GE(*named, 0.0);
      EXPECT_LE(*named, 10.0) << name << ", seed " << seed;
      for (const VehicleState& state : trace.states)
        EXPECT_FALSE(seconds_from(time.until, state.utime) > 5.0 && state.standing != Standing::ok)
            << name << ", seed " << seed << " at " << state.utime;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, StuckSonars,
                         testing::Values(AssociationMethod::known, AssociationMethod::joint),
                         [](const auto& tested) {
                           return tested.param == AssociationMethod::known ? "labelled" : "unlabelled";
                         });

// Two of the three: ahead there is nothing to hear.
TEST(DeadSonars, OfATankAreNamedAndNothingIsLost) {
  const Config config = faulty_tank();
  for (std::uint64_t seed = 1; seed <= kFaultSeeds; ++seed) {
    Recording recording = simulate(config, seed);
    const Lifetime time = fault("sonar_dead_for_good").put_into(recording, seed);
    const int sensor = sensor_at_fault(recording, seed);
    const RunTrace trace = run(config.slam, recording);
    const std::optional<double> named = named_after(trace, sensor, time.from);
    EXPECT_EQ(named.has_value(), sensor != 1) << seed;
    EXPECT_LE(named.value_or(0.0), 30.0) << seed;
    for (const VehicleState& state : trace.states) EXPECT_NE(state.standing, Standing::lost) << seed;
  }
}

TEST(WrongUnits, AreSaidFromTheBeginning) {
  const Config config = faulty_tank();
  for (const std::string_view unit : {"heading_degrees", "heading_clockwise", "speed_centimetres"}) {
    Recording recording = simulate(config, 1);
    fault(unit).put_into(recording, 1);
    const RunTrace trace = run(config.slam, recording);
    for (const VehicleState& state : trace.states) {
      const bool is_known = seconds_from(trace.states.front().utime, state.utime) > 20.0;
      EXPECT_FALSE(is_known && state.standing == Standing::ok) << unit << " at " << state.utime;
    }
  }
}

class HeadingThatIsAnInput : public testing::TestWithParam<const char*> {};

// It is that of the compass, whatever the map says.
TEST_P(HeadingThatIsAnInput, CostsLittleWhereItIsWrongForAMoment) {
  const Config config = shipped_config(GetParam());
  FaultSums clean, one, frozen;
  for (std::uint64_t seed = 1; seed <= kFaultSeeds; ++seed) {
    const Recording recording = simulate(config, seed);
    Recording with_one = recording, with_frozen = recording;
    fault("one_heading").put_into(with_one, seed);
    fault("heading_frozen").put_into(with_frozen, seed);
    clean.add(config, recording);
    one.add(config, with_one);
    frozen.add(config, with_frozen);
  }
  EXPECT_LE(std::sqrt(one.square / clean.square), 1.05);
  EXPECT_LE(one.nees, 1.05 * clean.nees);
  EXPECT_LE(std::sqrt(frozen.square / clean.square), 1.3);
}

TEST_P(HeadingThatIsAnInput, IsSaidWhereItIsWrongForLong) {
  constexpr double kSoon = 5.0;  // [s]
  const Config config = shipped_config(GetParam());
  for (const std::string_view wrong : {"heading_off", "heading_degrees", "heading_clockwise"}) {
    for (std::uint64_t seed = 1; seed <= kFaultSeeds; ++seed) {
      Recording recording = simulate(config, seed);
      const Lifetime time = fault(wrong).put_into(recording, seed);
      const RunTrace trace = run(config.slam, recording);
      const std::int64_t begin = std::max(time.from, trace.states.front().utime);
      EXPECT_TRUE(std::ranges::any_of(trace.states,
                                      [&](const VehicleState& state) {
                                        const double after = seconds_from(begin, state.utime);
                                        return state.standing != Standing::ok && after >= 0.0 &&
                                               after <= kSoon;
                                      }))
          << wrong << ", seed " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Paper, HeadingThatIsAnInput, testing::Values("tank_paper_0p1", "tank_paper_0p3"),
                         [](const auto& tested) { return std::string(tested.param); });

// One alarm in a million windows is what the thresholds are made for.
TEST(CleanRuns, AreWell) {
  for (const char* name :
       {"tank_0p1", "tank_0p3", "tank_no_speed", "tank_cone", "tank_paper_0p1", "tank_paper_0p3"}) {
    const Config config = read_config(fmt::format("{}/configs/{}.yaml", LEADLINE_SOURCE_DIR, name));
    std::size_t steps = 0, not_ok = 0;
    for (std::uint64_t seed = 1; seed <= kFaultSeeds; ++seed) {
      const RunTrace trace = run(config.slam, simulate(config, seed));
      steps += trace.states.size();
      for (const VehicleState& state : trace.states) not_ok += state.standing != Standing::ok;
    }
    EXPECT_LE(100 * not_ok, steps) << name;
  }
}

}  // namespace
}  // namespace leadline::app
