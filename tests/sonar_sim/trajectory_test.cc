#include "leadline/sonar_sim/trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "leadline/sonar_sim/path.h"
#include "statistics.h"

namespace leadline {
namespace {

constexpr double kAmplitude = from_degrees(20.0);

TrajectoryOptions carriage(double speed = 0.3) {
  TrajectoryOptions options;
  options.programme = MotionProgramme::carriage;
  options.speed = speed;
  return options;
}

TrajectoryOptions quiet(double speed = 0.3) {
  TrajectoryOptions options;
  options.speed = speed;
  options.yaw_rate_sigma = options.acceleration_sigma = 0.0;
  return options;
}

TrajectoryOptions circuit(double length, double width, double corner_radius) {
  TrajectoryOptions options;
  options.programme = MotionProgramme::circuit;
  options.speed = 0.3;
  options.start_y = -width / 2.0;
  options.circuit_length = length;
  options.circuit_width = width;
  options.corner_radius = corner_radius;
  options.zigzag_amplitude = from_degrees(10.0);
  options.centring_gain = from_degrees(20.0);
  return options;
}

Path path_of(const TrajectoryOptions& o) {
  return rounded_rectangle({o.start_x, o.start_y, 0.0}, o.circuit_length, o.circuit_width, o.corner_radius);
}

// How far the vehicle comes along the path [m], and how far from it.
struct Following {
  double progress = 0.0, farthest = 0.0;
};

Following follow(const TrajectoryOptions& options, double duration, std::uint64_t seed) {
  const Path path = path_of(options);
  const Trajectory trajectory(options, duration, seed);
  Following result;
  for (const BodyState& state : trajectory.states()) {
    result.progress = path.follow(state.X_WB.position(), result.progress);
    const double distance = (path.at(result.progress).position() - state.X_WB.position()).norm();
    result.farthest = std::max(result.farthest, distance);
  }
  return result;
}

TEST(ZigzagTest, HandComputed) {
  EXPECT_DOUBLE_EQ(zigzag(20.0, 60.0, 0.0), 0.0);
  EXPECT_NEAR(zigzag(20.0, 60.0, 7.5), 10.0, 1e-12);
  EXPECT_NEAR(zigzag(20.0, 60.0, 15.0), 20.0, 1e-12);
  EXPECT_NEAR(zigzag(20.0, 60.0, 30.0), 0.0, 1e-12);
  EXPECT_NEAR(zigzag(20.0, 60.0, 45.0), -20.0, 1e-12);
  EXPECT_NEAR(zigzag(20.0, 60.0, 60.0 * 7 + 52.5), -10.0, 1e-11);
}

TEST(TrajectoryTest, CarriageGoesStraightWhileTheHeadingTurns) {
  TrajectoryOptions options = carriage();
  options.start_x = 1.0;
  options.start_y = -0.5;
  const Trajectory trajectory(options, 120.0, 1);
  double largest = 0.0;
  for (double t = 0.0; t <= 120.0; t += 0.25) {
    const auto [X_WB, surge, course] = trajectory.at(t);
    EXPECT_NEAR(X_WB.x, 1.0 + 0.3 * t, 1e-9);
    EXPECT_EQ(X_WB.y, -0.5);
    EXPECT_EQ(course, 0.0);
    EXPECT_NEAR(X_WB.heading, zigzag(kAmplitude, 60.0, t), 1e-9);
    EXPECT_NEAR(surge, 0.3 * std::cos(X_WB.heading), 1e-6);
    largest = std::max(largest, X_WB.heading);
  }
  EXPECT_NEAR(largest, kAmplitude, 1e-9) << "the heading is not the course, which is 0";
}

TEST(TrajectoryTest, FreeVehicleFollowsTheZigzag) {
  const TrajectoryOptions options = quiet();
  const Trajectory trajectory(options, 120.0, 1);
  // The command turns by 80 degrees in 60 s, and with y.
  const double command_rate = from_degrees(80.0 / 60.0) + options.centring_gain * 0.3 * std::sin(kAmplitude);
  for (double t = 0.0; t <= 120.0; t += 0.5) {
    const auto [X_WB, surge, course] = trajectory.at(t);
    const double command = zigzag(kAmplitude, 60.0, t) - options.centring_gain * X_WB.y;
    EXPECT_NEAR(X_WB.heading, command, command_rate * options.heading_time);
    EXPECT_DOUBLE_EQ(surge, 0.3);
    EXPECT_EQ(course, 0.0);
  }
}

TEST(TrajectoryTest, FreeVehicleGoesWhereItHeads) {
  const Trajectory trajectory(quiet(), 120.0, 1);
  for (double t = 0.0; t < 119.0; t += 1.0) {
    const Pose2 a = trajectory.at(t).X_WB, b = trajectory.at(t + 0.1).X_WB;
    EXPECT_NEAR(std::atan2(b.y - a.y, b.x - a.x), trajectory.at(t + 0.05).X_WB.heading, 1e-4);
  }
}

TEST(TrajectoryTest, FiniteDifferencesAgreeWithSurge) {
  for (const MotionProgramme programme : {MotionProgramme::carriage, MotionProgramme::free}) {
    TrajectoryOptions options;
    options.programme = programme;
    const Trajectory trajectory(options, 120.0, 3);
    for (double t = 0.0; t < 119.0; t += 0.5) {
      const BodyState a = trajectory.at(t), b = trajectory.at(t + 0.1), middle = trajectory.at(t + 0.05);
      const double c = std::cos(middle.X_WB.heading), s = std::sin(middle.X_WB.heading);
      const double forward = (c * (b.X_WB.x - a.X_WB.x) + s * (b.X_WB.y - a.X_WB.y)) / 0.1;
      EXPECT_NEAR(forward, (a.surge + b.surge) / 2.0, 0.002) << t;
    }
  }
}

// Also with a current, and where the heading is not the course.
TEST(TrajectoryTest, FiniteDifferencesAgreeWithTheVelocityOverGround) {
  for (const MotionProgramme programme : {MotionProgramme::carriage, MotionProgramme::free}) {
    TrajectoryOptions options;
    options.programme = programme;
    options.current_sigma = 0.1;
    const Trajectory trajectory(options, 120.0, 3);
    double farthest = 0.0;
    for (double t = 0.0; t < 119.0; t += 0.5) {
      const BodyState a = trajectory.at(t), b = trajectory.at(t + 0.1), middle = trajectory.at(t + 0.05);
      const Eigen::Vector2d v_W = (b.X_WB.position() - a.X_WB.position()) / 0.1;
      const Eigen::Vector2d v_B = Eigen::Rotation2Dd(-middle.X_WB.heading) * v_W;
      // The current changes within a tenth of a second by its gusts.
      EXPECT_LT((v_B - trajectory.rates_at(t + 0.05).v_B).norm(), 0.03) << t;
      farthest = std::max(farthest, std::abs(v_B.y()));
    }
    EXPECT_GT(farthest, 0.03);
  }
}

TEST(TrajectoryTest, FiniteDifferencesAgreeWithTheYawRate) {
  for (const MotionProgramme programme : {MotionProgramme::carriage, MotionProgramme::free}) {
    TrajectoryOptions options = quiet();
    options.programme = programme;
    const Trajectory trajectory(options, 120.0, 3);
    for (double t = 0.0; t < 119.0; t += 0.5) {
      const double turn =
          angle_difference(trajectory.at(t + 0.1).X_WB.heading, trajectory.at(t).X_WB.heading);
      const double turning = std::abs(std::remainder(t - 15.0, 30.0));  // [s], from where the wave turns
      if (turning < 0.2) continue;
      EXPECT_NEAR(trajectory.rates_at(t + 0.05).yaw_rate, turn / 0.1, 1e-3) << t;
    }
  }
}

// An integration with half the step goes the same way.
TEST(TrajectoryTest, PhysicsStepIsFineEnough) {
  TrajectoryOptions fine = quiet(), coarse = quiet();
  fine.physics_step = coarse.physics_step / 2.0;
  const Trajectory a(coarse, 120.0, 1), b(fine, 120.0, 1);
  for (double t = 0.0; t <= 120.0; t += 1.0) {
    EXPECT_NEAR(a.at(t).X_WB.x, b.at(t).X_WB.x, 2e-3);
    EXPECT_NEAR(a.at(t).X_WB.y, b.at(t).X_WB.y, 2e-3);
  }
}

TEST(TrajectoryTest, IsLinearBetweenStepsAndHeldAtTheEnds) {
  const Trajectory trajectory(TrajectoryOptions{}, 10.0, 1);
  ASSERT_EQ(trajectory.states().size(), 501U);
  const BodyState a = trajectory.states()[100], b = trajectory.states()[101];
  EXPECT_NEAR(trajectory.at(2.015).X_WB.x, 0.25 * a.X_WB.x + 0.75 * b.X_WB.x, 1e-12);
  EXPECT_NEAR(trajectory.at(2.015).surge, 0.25 * a.surge + 0.75 * b.surge, 1e-12);
  EXPECT_EQ(trajectory.at(-1.0).X_WB.x, trajectory.states().front().X_WB.x);
  EXPECT_EQ(trajectory.at(11.0).X_WB.x, trajectory.states().back().X_WB.x);
}

TEST(TrajectoryTest, CentringLeadsBackToTheMiddle) {
  TrajectoryOptions options = quiet();
  options.zigzag_amplitude = 0.0;
  options.start_y = 2.0;
  const Trajectory trajectory(options, 300.0, 1);
  EXPECT_NEAR(trajectory.at(300.0).X_WB.y, 0.0, 0.01);
  double steepest = 0.0;
  for (const BodyState& state : trajectory.states())
    steepest = std::max(steepest, std::abs(state.X_WB.heading));
  EXPECT_LE(steepest, 2.0 * options.centring_gain) << "gently";
}

TEST(TrajectoryTest, QuietCircuitClosesItsLaps) {
  for (TrajectoryOptions options : {circuit(30.0, 15.0, 3.0), circuit(102.0, 2.0, 1.0)}) {
    options.zigzag_amplitude = options.yaw_rate_sigma = options.acceleration_sigma = 0.0;
    const Path path = path_of(options);
    const double lap = path.length() / options.speed;
    for (const double laps : {1.0, 2.0, 3.0}) {
      const auto [progress, farthest] = follow(options, laps * lap, 1);
      EXPECT_NEAR(progress / path.length(), laps, 0.01 * laps) << "a corner is cut by little";
    }
  }
}

TEST(TrajectoryTest, CourseIsTheHeadingOfThePathBesideTheVehicle) {
  const TrajectoryOptions options = circuit(30.0, 15.0, 3.0);
  const Path path = path_of(options);
  const Trajectory trajectory(options, 600.0, 1);
  double progress = 0.0;
  for (const BodyState& state : trajectory.states()) {
    progress = path.follow(state.X_WB.position(), progress);
    EXPECT_NEAR(angle_difference(state.course, path.at(progress).heading), 0.0, 1e-12);
  }
}

TEST(TrajectoryTest, CircuitStaysNearThePath) {
  for (TrajectoryOptions options : {circuit(30.0, 15.0, 3.0), circuit(102.0, 2.0, 1.0)}) {
    options.sway_sigma = 0.005;
    for (const double current : {0.0, 0.01, 0.03}) {
      options.current_sigma = current;
      const double lap = path_of(options).length() / options.speed;
      for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const auto [progress, farthest] = follow(options, 3.0 * lap, seed);
        EXPECT_NEAR(progress, 3.0 * path_of(options).length(), 30.0) << "goes round and round";
      }
    }
  }
}

// The same programme along a straight line.
TEST(TrajectoryTest, FreeIsTheFirstSideOfACircuit) {
  TrajectoryOptions along_circuit = circuit(300.0, 50.0, 10.0);
  along_circuit.start_y = 0.0;
  along_circuit.current_sigma = 0.01;
  TrajectoryOptions along_line = along_circuit;
  along_line.programme = MotionProgramme::free;
  const Trajectory a(along_circuit, 300.0, 1), b(along_line, 300.0, 1);
  for (std::size_t k = 0; k < a.states().size(); ++k) {
    EXPECT_EQ(a.states()[k].X_WB.x, b.states()[k].X_WB.x);
    EXPECT_EQ(a.states()[k].X_WB.y, b.states()[k].X_WB.y);
    EXPECT_EQ(a.states()[k].X_WB.heading, b.states()[k].X_WB.heading);
  }
}

// Differences over one second, long against the correlation that the loops bring in only by their time
// constants.
struct Differences {
  std::vector<double> turn, gain, sideways;
};

Differences one_second_differences(TrajectoryOptions options) {
  options.zigzag_amplitude = options.centring_gain = 0.0;
  options.heading_time = options.speed_time = 1e6;  // open loop: the disturbance alone
  const Trajectory trajectory(options, 4000.0, 5);
  Differences result;
  for (double t = 0.0; t < 4000.0; t += 1.0) {
    const BodyState a = trajectory.at(t), b = trajectory.at(t + 1.0);
    result.turn.push_back(angle_difference(b.X_WB.heading, a.X_WB.heading));
    result.gain.push_back(b.surge - a.surge);
    result.sideways.push_back(oplus(inverse(a.X_WB), b.X_WB).y);
  }
  return result;
}

TEST(TrajectoryTest, DisturbancesHaveTheirDensities) {
  TrajectoryOptions yaw = quiet(), acceleration = quiet(), sway = quiet();
  yaw.yaw_rate_sigma = 0.03;
  acceleration.acceleration_sigma = 0.01;
  sway.sway_sigma = 0.05;
  EXPECT_THAT(one_second_differences(yaw).turn, HasMoments(0.0, 0.03));
  EXPECT_THAT(one_second_differences(acceleration).gain, HasMoments(0.0, 0.01));
  EXPECT_THAT(one_second_differences(sway).sideways, HasMoments(0.0, 0.05));
}

// The yaw rate's differences over a second; neighbours overlap by half a second, hence 4/6 of the variance.
TEST(TrajectoryTest, YawDriftIsARandomWalkOfTheYawRate) {
  TrajectoryOptions options = quiet();
  options.yaw_drift_sigma = 0.01;
  const std::vector<double> turn = one_second_differences(options).turn;
  std::vector<double> change;
  for (std::size_t i = 2; i < turn.size(); i += 2) change.push_back(turn[i] - turn[i - 1]);
  EXPECT_THAT(change, HasMoments(0.0, 0.01 * std::sqrt(2.0 / 3.0)));
}

// Of many seeds the current at 0 s and after its time constant, of a vehicle that otherwise goes straight.
struct Currents {
  std::vector<double> x, y, later_x, later_y;
};

constexpr double kCurrentTime = 20.0, kCurrentSigma = 0.02;

Currents currents() {
  TrajectoryOptions options = quiet();
  options.zigzag_amplitude = options.centring_gain = 0.0;
  options.physics_step = 0.1;
  options.current_sigma = kCurrentSigma;
  options.current_time = kCurrentTime;
  Currents result;
  for (std::uint64_t seed = 1; seed <= 4000; ++seed) {
    const Trajectory trajectory(options, kCurrentTime + 0.1, seed);
    const auto velocity = [&](std::size_t k) -> Eigen::Vector2d {
      const BodyState &a = trajectory.states()[k], &b = trajectory.states()[k + 1];
      return (b.X_WB.position() - a.X_WB.position()) / options.physics_step -
             Eigen::Vector2d(options.speed, 0.0);
    };
    const Eigen::Vector2d first = velocity(0), later = velocity(200);
    result.x.push_back(first.x());
    result.y.push_back(first.y());
    result.later_x.push_back(later.x());
    result.later_y.push_back(later.y());
  }
  return result;
}

MATCHER_P2(CorrelatesWith, other, expected, "") {
  double sum = 0.0;
  for (std::size_t i = 0; i < arg.size(); ++i) sum += (arg[i] - mean(arg)) * (other[i] - mean(other));
  const auto n = static_cast<double>(arg.size());
  const double correlation = sum / ((n - 1.0) * standard_deviation(arg) * standard_deviation(other));
  *result_listener << "correlation " << correlation;
  return std::abs(std::atanh(correlation) - std::atanh(expected)) <= kStandardErrors / std::sqrt(n - 3.0);
}

TEST(TrajectoryTest, CurrentHasItsSigmaAndItsTime) {
  const Currents c = currents();
  for (const auto& component : {c.x, c.y, c.later_x, c.later_y})
    EXPECT_THAT(component, HasMoments(0.0, kCurrentSigma));
  EXPECT_THAT(c.x, CorrelatesWith(c.later_x, std::exp(-1.0)));
  EXPECT_THAT(c.y, CorrelatesWith(c.later_y, std::exp(-1.0)));
  EXPECT_THAT(c.x, CorrelatesWith(c.y, 0.0));
}

TEST(TrajectoryTest, CurrentMovesTheVehicleButNotItsHeadingNorItsSpeedThroughTheWater) {
  TrajectoryOptions still;
  still.centring_gain = 0.0;
  TrajectoryOptions flowing = still;
  flowing.current_sigma = 0.05;
  const Trajectory a(still, 60.0, 1), b(flowing, 60.0, 1);
  for (std::size_t k = 0; k < a.states().size(); ++k) {
    EXPECT_EQ(a.states()[k].surge, b.states()[k].surge);
    EXPECT_EQ(a.states()[k].X_WB.heading, b.states()[k].X_WB.heading);
  }
  EXPECT_GT((a.at(60.0).X_WB.position() - b.at(60.0).X_WB.position()).norm(), 0.1);
}

TEST(TrajectoryTest, DisturbancesAreIndependent) {
  TrajectoryOptions plain = quiet();
  plain.acceleration_sigma = 0.01;
  TrajectoryOptions swaying = plain;
  swaying.sway_sigma = 0.05;
  const Trajectory a(plain, 10.0, 1), b(swaying, 10.0, 1);
  for (std::size_t k = 0; k < a.states().size(); ++k) EXPECT_EQ(a.states()[k].surge, b.states()[k].surge);
}

}  // namespace
}  // namespace leadline
