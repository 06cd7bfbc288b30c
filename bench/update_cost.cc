// What a prediction and an update cost in the size n of the state: the filters of Belief beside the
// whole-state UKF and the least that any such update must do, the rank-2 change of an n x n covariance.
//
// Compare within one run: update_cost --benchmark_repetitions=9 --benchmark_report_aggregates_only

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>

#include "leadline/vehicle/motion/constant_velocity.h"
#include "leadline/vehicle/sensor/wall_sighting.h"
#include "tests/core/whole_state_ukf.h"

namespace leadline {
namespace {

constexpr int kVehicle = 4;

const Linearizer kEkf{.kind = Linearizer::Kind::taylor};
const Linearizer kUkf{.kind = Linearizer::Kind::sigma_points};

Sensor laser() {
  Sensor sensor;
  sensor.range_sigma = 0.1;
  return sensor;
}

void require(Status status) {
  if (status != Status::ok) std::abort();
}

/// A vehicle amid n / 2 - 2 points, all of whose errors are correlated.
struct World {
  Sensor sensor = laser();
  ConstantVelocity motion{{}, 0.1};
  int targets;

  explicit World(int n) : targets((n - kVehicle) / 2) {}

  /// What the sensor reads of a target from the origin.
  Sighting sighting(int target) const {
    const double around = 2.0 * kPi * target / targets;
    return {0, 5.0 + 2.0 * std::sin(3.0 * around), wrap_angle(around)};
  }
  Vector<2> reading(int target) const { return {sighting(target).range, sighting(target).bearing}; }

  Belief belief(ErrorKind error) const {
    const Vector<kVehicle> sigma(0.3, 0.2, 0.05, 0.1);
    Belief belief(error, Vector<kVehicle>::Zero(),
                  Matrix<kVehicle, kVehicle>(sigma.array().square().matrix().asDiagonal()), targets);
    for (int target = 0; target < targets; ++target) {
      int slot = 0;
      const Sighting seen = sighting(target);
      require(belief.add(PointFromSighting{sensor, seen}, kEkf, slot));
    }
    for (int target = 0; target < targets; ++target) {
      require(belief.predict(motion, kEkf));
      correct(belief, kEkf, target);
    }
    return belief;
  }

  WholeStateUkf whole_state_ukf() const {
    const Belief start = belief(ErrorKind::additive);
    Eigen::VectorXd x(start.size());
    x.head<kVehicle>() = start.vehicle();
    for (int slot = 0; slot < targets; ++slot) x.segment<2>(start.row(slot)) = start.position(slot);
    return {x, start.covariance()};
  }

  void correct(Belief& belief, const Linearizer& linearizer, int target) const {
    Innovation<2, 5> innovation;
    require(belief.innovate(PointSighting{sensor}, target, reading(target), linearizer, innovation));
    require(belief.correct(innovation));
  }
};

void update(benchmark::State& state, ErrorKind error, const Linearizer& linearizer) {
  const World world(static_cast<int>(state.range(0)));
  Belief belief = world.belief(error);
  int target = 0;
  for (auto _ : state) {
    world.correct(belief, linearizer, target);
    target = (target + 1) % world.targets;
  }
}

void update_whole_state_ukf(benchmark::State& state) {
  const World world(static_cast<int>(state.range(0)));
  WholeStateUkf ukf = world.whole_state_ukf();
  int target = 0;
  for (auto _ : state) {
    require(ukf.correct(PointSighting{world.sensor}, kVehicle + 2 * target, world.reading(target)));
    target = (target + 1) % world.targets;
  }
}

/// P -= W W' alone.
void update_rank_two(benchmark::State& state) {
  const Eigen::Index n = state.range(0);
  Eigen::MatrixXd P = Eigen::MatrixXd::Identity(n, n);
  const Eigen::MatrixXd W = Eigen::MatrixXd::Constant(n, 2, 1e-9);
  for (auto _ : state) {
    for (Eigen::Index j = 0; j < n; ++j) P.col(j) -= W(j, 0) * W.col(0) + W(j, 1) * W.col(1);
    benchmark::DoNotOptimize(P.data());
    benchmark::ClobberMemory();
  }
}

void predict(benchmark::State& state, ErrorKind error, const Linearizer& linearizer) {
  const World world(static_cast<int>(state.range(0)));
  Belief belief = world.belief(error);
  for (auto _ : state) require(belief.predict(world.motion, linearizer));
}

void predict_whole_state_ukf(benchmark::State& state) {
  const World world(static_cast<int>(state.range(0)));
  WholeStateUkf ukf = world.whole_state_ukf();
  for (auto _ : state) require(ukf.predict(world.motion));
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  for (int n : {10, 20, 50, 100, 150, 200}) benchmark->Arg(n);
}

BENCHMARK_CAPTURE(update, marginal_ukf, ErrorKind::invariant, kUkf)->Apply(sizes);
BENCHMARK_CAPTURE(update, marginal_ukf_additive, ErrorKind::additive, kUkf)->Apply(sizes);
BENCHMARK_CAPTURE(update, ekf, ErrorKind::invariant, kEkf)->Apply(sizes);
BENCHMARK_CAPTURE(update, ekf_additive, ErrorKind::additive, kEkf)->Apply(sizes);
BENCHMARK(update_rank_two)->Apply(sizes);
BENCHMARK(update_whole_state_ukf)->Apply(sizes);

BENCHMARK_CAPTURE(predict, ukf_invariant, ErrorKind::invariant, kUkf)->Apply(sizes);
BENCHMARK_CAPTURE(predict, ukf_additive, ErrorKind::additive, kUkf)->Apply(sizes);
BENCHMARK_CAPTURE(predict, ekf_invariant, ErrorKind::invariant, kEkf)->Apply(sizes);
BENCHMARK_CAPTURE(predict, ekf_additive, ErrorKind::additive, kEkf)->Apply(sizes);
BENCHMARK(predict_whole_state_ukf)->Apply(sizes);

}  // namespace
}  // namespace leadline
