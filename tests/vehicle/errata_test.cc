// The errors of the source texts (docs/theory.md): the right formula is the derivative, or the limit, of what
// we compute; the printed one is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <span>

#include "leadline/core/se2.h"
#include "leadline/vehicle/motion/models.h"
#include "leadline/vehicle/navigation.h"
#include "leadline/vehicle/sensor/sightings.h"
#include "leadline/vehicle/sensor/wall_sighting.h"
#include "tests/support/matchers.h"
#include "tests/support/numerical_derivative.h"

namespace leadline {
namespace {

TEST(Errata, HwangSeong36CompoundingSecondRow) {
  const Pose2 X_oi{1.0, 2.0, 0.5}, X_ij{0.7, -0.4, 0.3};
  const double right = X_oi.y + X_ij.x * std::sin(0.5) + X_ij.y * std::cos(0.5);
  const double printed = X_oi.y + X_ij.x * std::sin(0.5) - X_ij.y * std::cos(0.5);
  EXPECT_NEAR(oplus(X_oi, X_ij).y, right, 1e-15);
  EXPECT_GT(std::abs(printed - right), 0.1);
}

TEST(Errata, HwangSeong29ThirdColumnBelongsToTheHeading) {
  // l([x y V], z) has no derivative by V; the printed column is the one by the heading.
  const Sensor sensor;
  const double r = 3.0, theta = 0.8;
  const Sighting sighting{0, r, theta};
  const PointFromSighting place{sensor, sighting};
  const auto f = [&](const Eigen::VectorXd& pose) {
    return Eigen::VectorXd(place(Vector<3>(pose), Vector<2>(Vector<2>::Zero())));
  };
  const Eigen::MatrixXd G = numerical_derivative(f, Vector<3>(1.0, 2.0, 0.0));
  EXPECT_THAT(Eigen::MatrixXd(G.col(2)), IsNear(Vector<2>(-r * std::sin(theta), r * std::cos(theta)), 1e-9));

  // A vehicle whose speed alone is uncertain knows where the object is, relative to itself.
  InitialPose initial;
  initial.sigma.setZero();
  Belief belief = initial_belief(initial, ConstantVelocity::Options{}, ErrorKind::additive, 1);
  int slot = 0;
  ASSERT_EQ(add_point(belief, sensor, sighting, {.kind = Linearizer::Kind::taylor}, slot), Status::ok);
  EXPECT_GT(belief.covariance()(3, 3), 0.0);
  EXPECT_TRUE(belief.covariance().col(3).tail<2>().isZero(0.0));
}

TEST(Errata, HwangSeong2And3TheCentreHasNoWeight) {
  // 2 n points of weight 1/(2 n) already sum to one and give the variance back: none is left for the centre.
  const Linearizer linearizer{.kind = Linearizer::Kind::paper_sigma_points};
  Affine<1, 3> affine;
  const auto square = [](const auto& xi) {
    Eigen::Matrix<typename std::decay_t<decltype(xi)>::Scalar, 1, 1> y;
    y[0] = xi.squaredNorm();
    return y;
  };
  ASSERT_TRUE((linearize<1, 3>(linearizer, square, Vector<3>::Zero(), Matrix<3, 3>::Identity(), 0, affine)));
  EXPECT_NEAR(affine.z[0], 3.0, 1e-12);
  EXPECT_EQ(linearizer.spread_squared(3), 3.0);
}

TEST(Errata, HwangSeong8And24TheSumHasAsManyTermsAsPoints) {
  // With one weight more than points the mean of a constant would not be the constant.
  const auto constant = [](const auto& xi) {
    Eigen::Matrix<typename std::decay_t<decltype(xi)>::Scalar, 1, 1> y;
    y[0] = xi[0] * 0.0 + 7.0;
    return y;
  };
  Affine<1, 3> affine;
  ASSERT_TRUE(
      (linearize<1, 3>(Linearizer{}, constant, Vector<3>::Zero(), Matrix<3, 3>::Identity(), 0, affine)));
  EXPECT_NEAR(affine.z[0], 7.0, 1e-13);
}

/// Lim and Lee: f by its small step, u = (v, w).
struct Car {
  AckermannMotion::Options options;
  double v = 2.0, w = 0.3, theta = 0.6, a = 3.78, b = 0.5, L = 2.83;
  Car() {
    options.wheel_base = L;
    options.sensor_offset = {a, b};
  }
  Vector<3> rate(double v_now, double w_now) const {
    constexpr double kStep = 1e-6;
    const AckermannMotion model(options, {v_now, w_now}, kStep);
    const Vector<3> start(0.0, 0.0, theta);
    return (model(start, Vector<5>(Vector<5>::Zero())) - start) / kStep;
  }
};

TEST(Errata, LimLeeHeadingRowHasTheTimeStep) {
  const Car car;
  const double dt = 0.1;
  const AckermannMotion model(car.options, {car.v, car.w}, dt);
  const double turned = model(Vector<3>(0.0, 0.0, car.theta), Vector<5>(Vector<5>::Zero()))[2] - car.theta;
  EXPECT_NEAR(turned, dt * car.v / car.L * std::tan(car.w), 1e-12);
  EXPECT_GT(std::abs(turned - car.v / car.L * std::tan(car.w)), 0.1);
}

TEST(Errata, LimLeePsi21AndPsi22) {
  const Car car;
  const auto by_input = [&](const Eigen::VectorXd& u) { return Eigen::VectorXd(car.rate(u[0], u[1])); };
  const Eigen::MatrixXd Psi = numerical_derivative(by_input, Vector<2>(car.v, car.w));
  const double c = std::cos(car.theta), s = std::sin(car.theta), t = std::tan(car.w);
  const double lever = car.a * c - car.b * s, printed = car.a * c + car.b * s;
  EXPECT_NEAR(Psi(1, 0), s + t / car.L * lever, 1e-5);
  EXPECT_NEAR(Psi(1, 1), car.v / car.L * (1.0 + t * t) * lever, 1e-5);
  EXPECT_GT(std::abs(Psi(1, 0) - (s + t / car.L * printed)), 0.01);
  EXPECT_GT(std::abs(Psi(1, 1) - car.v / car.L * (1.0 + t * t) * printed), 0.1);
}

TEST(Errata, LimLeeGradientByTheLandmarkHasTheOppositeSigns) {
  const Sensor sensor;
  const double x = 1.0, y = 2.0, mx = 4.0, my = 6.0, r = 5.0;
  const auto by_landmark = [&](const Eigen::VectorXd& m) {
    return Eigen::VectorXd(PointSighting{sensor}(Vector<3>(x, y, 0.3), Vector<2>(m), Vector<0>()));
  };
  const Eigen::MatrixXd H = numerical_derivative(by_landmark, Vector<2>(mx, my));
  Matrix<2, 2> right, printed;
  right << (mx - x) / r, (my - y) / r, -(my - y) / (r * r), (mx - x) / (r * r);
  printed << (x - mx) / r, (y - my) / r, -(y - my) / (r * r), (x - mx) / (r * r);
  EXPECT_THAT(H, IsNear(right, 1e-9));
  EXPECT_GT((H - printed).norm(), 0.5);
}

TEST(Errata, LimLeeGradientOfTheInverseSightingTurnsLikeIt) {
  // Laser bearings from the y axis: g uses cos(phi + theta - pi/2), and so must its gradient.
  const double r = 4.0, phi = 1.1, theta = 0.4;
  const auto g = [&](const Eigen::VectorXd& z) {
    return Eigen::VectorXd(
        Vector<2>(z[0] * std::cos(z[1] + theta - kPi / 2), z[0] * std::sin(z[1] + theta - kPi / 2)));
  };
  const Eigen::MatrixXd G = numerical_derivative(g, Vector<2>(r, phi));
  const auto gradient = [&](double t) {
    Matrix<2, 2> m;
    m << std::cos(t), -r * std::sin(t), std::sin(t), r * std::cos(t);
    return m;
  };
  EXPECT_THAT(G, IsNear(gradient(theta + phi - kPi / 2), 1e-9));
  EXPECT_GT((G - gradient(theta + phi)).norm(), 0.5);
  // Ours has the convention removed at import: bearing = phi - pi/2.
  const Sensor sensor;
  const Sighting sighting{0, r, phi - kPi / 2};
  EXPECT_THAT((PointFromSighting{sensor, sighting}(Vector<3>(0.0, 0.0, theta), Vector<2>(Vector<2>::Zero()))),
              IsNear(g(Vector<2>(r, phi)), 1e-12));
}

TEST(Errata, KnownCorrespondenceVelocityModelSecondRow) {
  const double v = 1.2, w = 0.7, theta = 0.4, dt = 0.9;
  const VelocityMotion model({}, {v, w}, dt);
  const double moved = model(Vector<3>(0.0, 0.0, theta), Vector<2>(Vector<2>::Zero()))[1];
  EXPECT_NEAR(moved, v / w * std::cos(theta) - v / w * std::cos(theta + w * dt), 1e-12);
  EXPECT_GT(std::abs(moved - (-v / w * std::cos(theta) - v / w * std::cos(theta + w * dt))), 0.1);
}

TEST(Errata, KnownCorrespondenceBearingInAllQuadrants) {
  const Sensor sensor;
  for (const double bearing : {0.3, 1.9, 3.0, -0.3, -1.9, -3.0}) {
    const Vector<2> point(2.0 * std::cos(bearing), 2.0 * std::sin(bearing));
    const double read = PointSighting{sensor}(Vector<3>(0.0, 0.0, 0.0), point, Vector<0>())[1];
    EXPECT_NEAR(read, bearing, 1e-9);
    if (std::abs(bearing) > kPi / 2) {
      EXPECT_GT(std::abs(std::atan(point.y() / point.x()) - bearing), 1.0);
    }
  }
}

/// A vehicle that has placed a point 5 m ahead of it, and its second sighting of that point.
struct SecondSighting {
  Sensor sensor;
  Sighting sighting{0, 5.1, 0.35};
  Belief belief;
  PointInnovation innovation;

  SecondSighting() : belief(ErrorKind::additive, Vector<3>(0.0, 0.0, 0.2), covariance(), 1) {
    int slot = 0;
    const Linearizer ekf{.kind = Linearizer::Kind::taylor};
    const Sighting first{0, 5.0, 0.3};
    EXPECT_EQ(add_point(belief, sensor, first, ekf, slot), Status::ok);
    EXPECT_EQ(innovate_point(belief, sensor, slot, sighting, ekf, innovation), Status::ok);
  }
  static Matrix<3, 3> covariance() {
    Matrix<3, 3> P;
    P << 0.04, 0.01, 0.0, 0.01, 0.09, 0.0, 0.0, 0.0, 0.02;
    return P;
  }
  /// H of Lim and Lee, H_t of the known-correspondence text: the derivative of the sighting by all it depends
  /// on.
  Matrix<2, 5> H() const {
    Vector<5> x;
    x << belief.vehicle(), belief.position(0);
    const auto h = [&](const Eigen::VectorXd& v) {
      return Eigen::VectorXd(
          PointSighting{sensor}(Vector<3>(v.head<3>()), Vector<2>(v.tail<2>()), Vector<0>()));
    };
    return numerical_derivative(h, x, 0b10);
  }
};

TEST(Errata, LimLeeInnovationAndGainHaveTheirTransposes) {
  // S = H P H' + R and K = P H' S^-1; without the transposes the products do not even exist, H not being
  // square.
  SecondSighting second;
  const Eigen::MatrixXd P = second.belief.covariance(), H = second.H();
  const Eigen::MatrixXd S = H * P * H.transpose() + PointSighting{second.sensor}.additive_noise();
  EXPECT_THAT(second.innovation.S, IsNear(S, 1e-9));
  const Vector<5> corrected = P * H.transpose() * S.inverse() * second.innovation.residual;
  const Vector<3> before = second.belief.vehicle();
  ASSERT_EQ(second.belief.correct(second.innovation), Status::ok);
  EXPECT_THAT(second.belief.vehicle() - before, IsNear(corrected.head<3>(), 1e-9));
  // Of the part that is square, the target's, the printed product H P H is another matrix.
  const Matrix<2, 2> H_m = H.rightCols<2>(), P_m = P.bottomRightCorner<2, 2>();
  EXPECT_GT((H_m * P_m * H_m - H_m * P_m * H_m.transpose()).norm(), 0.01);
}

TEST(Errata, KnownCorrespondenceLine6NeedsTheJacobianOfLine5) {
  // Line 6 names C_t, which nothing defines; the innovation is by H_t, pose and landmark together.
  const SecondSighting second;
  EXPECT_THAT(second.innovation.A.leftCols<5>(), IsNear(second.H(), 1e-9));
  const std::span rows(second.innovation.rows.data(), static_cast<std::size_t>(second.innovation.reads));
  EXPECT_THAT(rows, testing::ElementsAre(0, 1, 2, 3, 4));
}

TEST(Errata, HwangSeong17ObjectsStandStill) {
  // F_o is the identity: a prediction changes nothing of the objects.
  SecondSighting second;
  const Eigen::Vector2d p = second.belief.position(0);
  const Eigen::Matrix2d P = second.belief.position_covariance(0);
  ASSERT_EQ(
      predict(second.belief, OdometryMotion::Options{}, Linearizer{}, {}, OdometryInput{1.0, 0.5, 0.3}, 1.0),
      Status::ok);
  EXPECT_EQ(second.belief.position(0), p);
  EXPECT_EQ(second.belief.position_covariance(0), P);
}

}  // namespace
}  // namespace leadline
