// A range that stays while the vehicle moves is of the sonar, one beside a wall is of the wall.
#include "leadline/submap/range_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

#include "tests/support/random.h"

namespace leadline {
namespace {

/// A sonar that pings five times a second.
class RangeWatchTest : public testing::Test {
 protected:
  static constexpr double kSigma = 0.05, kWall = 4.0;

  void ping(std::optional<double> range, double speed = 0.3) {
    here_.utime += 200'000;
    here_.position.x() += 0.2 * speed;
    ++here_.next_feature;
    if (range)
      watch_.note(*range, kSigma, here_);
    else
      watch_.note_silence(here_);
  }
  /// @return of how many pings the sonar was suspect.
  int go(int pings, const std::function<std::optional<double>()>& hear, double speed = 0.3) {
    int suspect = 0;
    for (int i = 0; i < pings; ++i) {
      ping(hear(), speed);
      suspect += watch_.is_suspect() || watch_.is_quiet();
    }
    return suspect;
  }
  double beside_wall() { return kWall + random_.normal(kSigma); }

  RangeWatch watch_;
  RangeWatch::Ping here_;
  Random random_{3};
};

TEST_F(RangeWatchTest, AWallAlongsideStaysToNoise) {
  EXPECT_EQ(go(20'000, [&] { return beside_wall(); }), 0);
}

TEST_F(RangeWatchTest, OneThatStaysExactlyIsSuspectAtOnceAndSoonStuck) {
  go(100, [&] { return beside_wall(); });
  const int first = here_.next_feature + 1;
  ping(3.0);
  EXPECT_FALSE(watch_.is_suspect());
  ping(3.0);
  EXPECT_TRUE(watch_.is_suspect());
  EXPECT_FALSE(watch_.is_stuck());
  ping(3.0);
  ping(3.0);
  EXPECT_TRUE(watch_.is_stuck());
  EXPECT_EQ(watch_.range(), 3.0);
  EXPECT_EQ(watch_.first_feature(), first);
  ping(beside_wall());
  EXPECT_FALSE(watch_.is_suspect());
}

TEST_F(RangeWatchTest, AStuckSonarIsNeverSilent) {
  go(100, [&] { return beside_wall(); });
  go(10, [] { return std::optional(3.0); });
  go(2, [] { return std::nullopt; });
  EXPECT_TRUE(watch_.is_stuck());
  ping(std::nullopt);
  EXPECT_FALSE(watch_.is_stuck());
  EXPECT_FALSE(watch_.is_suspect());
}

TEST_F(RangeWatchTest, OfAVehicleAtRestNothingIsLearnt) {
  go(100, [&] { return beside_wall(); });
  EXPECT_EQ(go(
                5000, [] { return 3.0; }, 0.0),
            0);
  EXPECT_EQ(go(
                5000, [] { return 3.0; }, 0.01),
            0)
      << "adrift";
  go(10, [] { return 3.0; });
  EXPECT_TRUE(watch_.is_stuck()) << "it has gone on";
}

TEST_F(RangeWatchTest, RoundedRangesRepeatByChance) {
  const auto rounded = [&] { return 0.05 * std::round(beside_wall() / 0.05); };
  EXPECT_EQ(go(5000, rounded), 0);
  go(200, [] { return 3.0; });
  EXPECT_TRUE(watch_.is_stuck());
}

// Few objects have been met: their ranges are no steps of a coarse scale.
TEST_F(RangeWatchTest, OneThatHasSaidLittleIsSuspectSoonAndStuckLater) {
  for (const double range : {5.0, 7.0, 6.0}) ping(range);
  EXPECT_LE(3, go(5, [] { return 3.0; }));
  EXPECT_FALSE(watch_.is_stuck());
  go(20, [] { return 3.0; });
  EXPECT_TRUE(watch_.is_stuck());
}

// It may be a coarse one.
TEST_F(RangeWatchTest, OneThatHasSaidNothingElseIsNotKnownToBeStuck) {
  EXPECT_EQ(go(1000, [] { return 3.0; }), 0);
}

TEST_F(RangeWatchTest, OneThatHasHeardNothingBeforeIsSuspectSoonAndStuckLater) {
  go(100, [] { return std::nullopt; });
  EXPECT_LE(17, go(20, [] { return 3.0; }));
  EXPECT_FALSE(watch_.is_stuck());
  go(1, [] { return 3.0; });
  EXPECT_TRUE(watch_.is_stuck());
}

TEST_F(RangeWatchTest, SilenceIsNewsOfOneThatHasAlwaysHeard) {
  go(150, [&] { return beside_wall(); });
  EXPECT_EQ(go(45, [] { return std::nullopt; }), 0) << "2.7 m";
  go(15, [] { return std::nullopt; });
  EXPECT_TRUE(watch_.is_quiet());
  EXPECT_EQ(watch_.silent(), 60);
  ping(beside_wall());
  EXPECT_FALSE(watch_.is_quiet());
  EXPECT_EQ(watch_.silent(), 0);
}

TEST_F(RangeWatchTest, SilenceIsNoNewsOfOneThatHasHeardLittle) {
  go(130, [&] { return beside_wall(); });  // 7.8 m
  EXPECT_EQ(go(1000, [] { return std::nullopt; }), 0);
}

TEST_F(RangeWatchTest, SilenceIsNoNewsAtRestNorAmongFewObjects) {
  go(150, [&] { return beside_wall(); });
  EXPECT_EQ(go(
                500, [] { return std::nullopt; }, 0.0),
            0);
  for (int i = 0; i < 5; ++i) {
    go(10, [&] { return beside_wall(); });
    EXPECT_EQ(go(40, [] { return std::nullopt; }), 0);
  }
  EXPECT_EQ(go(1000, [] { return std::nullopt; }), 0);
}

TEST_F(RangeWatchTest, ItsFirstPlaceIsNoWay) {
  here_.position.x() = -7.5;
  go(100, [&] { return beside_wall(); });
  EXPECT_EQ(go(1000, [] { return std::nullopt; }), 0) << "6 m on which it heard";
}

TEST_F(RangeWatchTest, AnotherFrameIsNoWay) {
  go(300, [&] { return beside_wall(); });
  go(20, [] { return std::nullopt; });
  here_.position.x() -= 5.0;
  EXPECT_EQ(go(5, [] { return std::nullopt; }), 0);
}

TEST_F(RangeWatchTest, AClockThatIsSetIsNoTime) {
  go(100, [&] { return beside_wall(); });
  ping(3.0);
  here_.utime += 3600 * 1'000'000LL;
  watch_.shift_clock(3600 * 1'000'000LL);
  ping(3.0);
  EXPECT_TRUE(watch_.is_suspect());
}

}  // namespace
}  // namespace leadline
