// On a linear problem, estimated with the noise that there is, NEES and NIS are chi-square; with half that
// noise they are not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "leadline/core/consistency.h"
#include "tests/core/linear_models.h"
#include "tests/core/whole_state.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

using Motion = LinearMotion<3, 2>;
using Sighting = LinearSighting<TargetShape::point, 2, 0>;
using Placing = LinearInitialization<TargetShape::point>;

constexpr int kRuns = 100, kSteps = 20, kTargets = 2, kEntries = 3 + 2 * kTargets;

struct Figures {
  double nees = 0.0;  ///< of the whole state at the end, mean over runs
  double nis = 0.0;   ///< mean over runs of the sum over all sightings
};

/// @param claimed variance of a sighting that the filter is told, relative to the true one.
Figures run(double claimed) {
  Random models(51);
  const Motion motion = Motion::any(models);
  const Sighting sighting = Sighting::any(models);
  const Placing placing[kTargets] = {Placing::any(models), Placing::any(models)};
  const Matrix<3, 3> P0 = models.covariance(3, 0.1);
  Sighting told = sighting;
  told.R *= claimed;

  Figures figures;
  for (int seed = 1; seed <= kRuns; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    Belief belief(ErrorKind::additive, Vector<3>::Zero(), P0, kTargets);
    Eigen::VectorXd truth(kEntries);
    truth.head<3>() = random.sample(P0);
    for (int slot = 0; slot < kTargets; ++slot) {
      int placed = -1;
      EXPECT_EQ(belief.add(placing[slot], Linearizer{}, placed), Status::ok);
      truth.segment<2>(belief.row(placed)) =
          placing[slot](Vector<3>(truth.head<3>()), Vector<2>(random.sample(placing[slot].N)));
    }
    for (int step = 0; step < kSteps; ++step) {
      truth.head<3>() = motion(Vector<3>(truth.head<3>()), Vector<2>(random.sample(motion.Q)));
      EXPECT_EQ(belief.predict(motion, Linearizer{}), Status::ok);
      for (int slot = 0; slot < kTargets; ++slot) {
        const Vector<2> z =
            sighting(Vector<3>(truth.head<3>()), Vector<2>(truth.segment<2>(belief.row(slot))), Vector<0>()) +
            random.sample(sighting.R);
        Innovation<2, 5> innovation;
        EXPECT_EQ(belief.innovate(told, slot, z, Linearizer{}, innovation), Status::ok);
        EXPECT_EQ(belief.correct(innovation), Status::ok);
        figures.nis += innovation.gamma / kRuns;
      }
    }
    figures.nees += nees(truth - WholeState(belief).x, belief.covariance()) / kRuns;
  }
  return figures;
}

constexpr double kProbability = 0.99;
const Band kNeesBand = consistency_band(kRuns, kEntries, kProbability);
const Band kNisBand = consistency_band(kRuns, 2 * kTargets * kSteps, kProbability);

TEST(BeliefConsistencyTest, RightNoiseIsConsistent) {
  const Figures figures = run(1.0);
  EXPECT_GT(figures.nees, kNeesBand.low);
  EXPECT_LT(figures.nees, kNeesBand.high);
  EXPECT_GT(figures.nis, kNisBand.low);
  EXPECT_LT(figures.nis, kNisBand.high);
}

TEST(BeliefConsistencyTest, HalfTheNoiseIsOverconfident) {
  const Figures figures = run(0.5);
  EXPECT_GT(figures.nees, kNeesBand.high);
  EXPECT_GT(figures.nis, kNisBand.high);
}

TEST(BeliefConsistencyTest, TwiceTheNoiseIsConservative) {
  const Figures figures = run(2.0);
  EXPECT_LT(figures.nees, kNeesBand.low);
  EXPECT_LT(figures.nis, kNisBand.low);
}

}  // namespace
}  // namespace leadline
