// What undecided targets are judged by: residuals that are white although the vehicle drifts, and decisions
// that are as seldom wrong as the ratio promises.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "leadline/submap/local_map.h"
#include "leadline/vehicle/navigation.h"
#include "leadline/vehicle/sensor/sightings.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr double kNever = 1e12;  // a ratio at which nothing is decided

/// A wall in the world: the points p of n(alpha) . p = rho.
struct TrueWall {
  double rho, alpha;
  double range(const Pose2& X_WR) const {
    const Eigen::Vector2d n(std::cos(alpha), std::sin(alpha));
    return (rho - n.dot(X_WR.position())) / std::cos(angle_difference(X_WR.heading, alpha));
  }
};

/// The vehicle swims past at some distance and drifts as its motion model says, without any reference but
/// the heading it began with.
class Passage {
 public:
  Passage(const SlamOptions& options, const Eigen::Vector3d& way, Random& random)
      : options_(options), way_(way), random_(random), map_(options) {}

  void move() {
    const auto& noise = std::get<OdometryMotion::Options>(options_.motion);
    const double s = noise.increment_sigma, h = noise.increment_heading_sigma;
    X_WB_ = oplus(X_WB_,
                  {way_.x() + random_.normal(s), way_.y() + random_.normal(s), way_.z() + random_.normal(h)});
    EXPECT_EQ(predict(map_.belief(), options_.motion, options_.linearizer, {},
                      OdometryInput{way_.x(), way_.y(), way_.z()}, 0.2),
              Status::ok);
    utime_ += 200'000;
  }

  void hear(double range, double bearing) {
    const Sighting sighting{0, range, bearing, 7};
    if (map_.features().empty()) {
      map_.initialize(sighting, utime_);
    } else {
      map_.predict(sighting, 0, true);
      map_.correct(sighting, 0, utime_);
    }
  }

  Pose2 beam() const { return oplus(X_WB_, options_.sensors[0].X_BS); }
  const Sensor& sensor() const { return options_.sensors[0]; }
  LocalMap& map() { return map_; }
  const Feature& feature() const { return map_.features()[0]; }

 private:
  const SlamOptions& options_;
  Eigen::Vector3d way_;
  Random& random_;
  Pose2 X_WB_;
  LocalMap map_;
  std::int64_t utime_ = 0;
};

SlamOptions passing(double decision_ratio) {
  SlamOptions options;
  options.motion = OdometryMotion::Options{.increment_sigma = 0.03, .increment_heading_sigma = 0.01};
  options.initial.sigma = {0.01, 0.01, 0.02};
  options.association.method = AssociationMethod::known;
  options.features.decision_ratio = decision_ratio;
  options.features.capacity = 1;
  options.sensors.resize(1);
  options.sensors[0].X_BS.heading = kPi / 2;
  options.sensors[0].max_range = 50.0;
  return options;
}

/// Sum of the products of whitened residuals that follow each other, over the sum of their squares.
struct LagOne {
  double products = 0.0, squares = 0.0;
  int count = 0;
  double last = 0.0;

  void begin() { last = 0.0; }
  void add(double whitened) {
    products += last * whitened;
    squares += whitened * whitened;
    ++count;
    last = whitened;
  }
  double correlation() const { return products / squares; }
  double sigma() const { return 1.0 / std::sqrt(count); }
};

/// What a range and bearing sensor sees of a point, or of a wall along its beam.
struct Target {
  TargetKind kind;
  Eigen::Vector2d point;
  TrueWall wall;

  Sighting seen_from(const Pose2& X_WS, const Sensor& sensor, Random& random) const {
    const double aside = random.normal(sensor.bearing_sigma), noise = random.normal(sensor.range_sigma);
    if (kind == TargetKind::wall) return {0, wall.range(oplus(X_WS, {0.0, 0.0, aside})) + noise, 0.0};
    const Eigen::Vector2d seen = transform(inverse(X_WS), point);
    return {0, seen.norm() + noise, std::atan2(seen.y(), seen.x()) + aside};
  }
};

/// Residual of the range over its standard deviation.
template <class Expected>
double whitened(Status (&innovate)(const Belief&, const Sensor&, int, const Sighting&, const Linearizer&,
                                   Expected&),
                Passage& passage, int slot, const Sighting& echo) {
  Expected expected;
  EXPECT_EQ(innovate(passage.map().belief(), passage.sensor(), slot, echo, {}, expected), Status::ok);
  return expected.residual[0] / expected.L(0, 0);
}

/// Of the residuals of the range, by the pair for evidence and by the pair for the place.
struct Correlations {
  LagOne white, place;
};

Correlations correlations(ErrorKind error, TargetKind kind) {
  constexpr int kSeeds = 40, kPings = 40;
  SlamOptions options = passing(kNever);
  options.error = error;
  options.features.wall_direction_sigma = from_degrees(10.0);  // as true ones are turned
  options.sensors[0].kind = Sensor::Kind::range_bearing;
  options.sensors[0].sees_walls = true;
  Correlations found;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    Passage passage(options, {0.05, 0.0, 0.0}, random);
    const double turn = random.normal(options.features.wall_direction_sigma);
    const Target target{kind, {random.normal(1.0), 6.0}, {6.0, kPi / 2 + turn}};
    found.white.begin();
    found.place.begin();
    for (int ping = 0; ping < kPings; ++ping) {
      if (ping > 0) passage.move();
      const Sighting echo = target.seen_from(passage.beam(), passage.sensor(), random);
      if (ping > 0 && kind == TargetKind::wall) {
        found.white.add(whitened(innovate_wall, passage, passage.feature().white_wall_slot, echo));
        found.place.add(whitened(innovate_wall, passage, passage.feature().wall_slot, echo));
      } else if (ping > 0) {
        found.white.add(whitened(innovate_point, passage, passage.feature().white_point_slot, echo));
        found.place.add(whitened(innovate_point, passage, passage.feature().point_slot, echo));
      }
      passage.hear(echo.range, echo.bearing);
    }
  }
  return found;
}

class Evidences : public testing::TestWithParam<ErrorKind> {};

TEST_P(Evidences, ResidualsAreWhiteWhileTheVehicleDrifts) {
  for (const TargetKind truth : {TargetKind::point, TargetKind::wall}) {
    const Correlations found = correlations(GetParam(), truth);
    EXPECT_LT(std::abs(found.white.correlation()), 3.0 * found.white.sigma())
        << (truth == TargetKind::wall ? "wall" : "point");
    EXPECT_NEAR(found.white.squares / found.white.count, 1.0, 0.15);
    if (truth == TargetKind::wall) continue;  // which takes most of it up in its direction
    EXPECT_GT(found.place.correlation(), 10.0 * found.place.sigma())
        << "those of the pair for the place hold the drift, again and again";
  }
}

INSTANTIATE_TEST_SUITE_P(Errors, Evidences, testing::Values(ErrorKind::additive, ErrorKind::invariant),
                         [](const auto& error) {
                           return error.param == ErrorKind::additive ? "additive" : "invariant";
                         });

/// How often a ratio was reached for the wrong kind, by the first time that it was reached.
struct Errors {
  double ratio;
  int decided = 0, wrong = 0;
};

// A likelihood ratio of what is true errs with probability 1 / ratio at most.
TEST(EvidenceTest, DecisionsErrNoMoreOftenThanTheRatioAllows) {
  constexpr int kTargets = 10'000, kPings = 60;
  std::array<Errors, 3> errors{{{20.0}, {200.0}, {2000.0}}};
  SlamOptions options = passing(kNever);
  options.linearizer.kind = Linearizer::Kind::taylor;
  Sensor& sensor = options.sensors[0];
  sensor.bearing_sigma = from_degrees(1.15);  // that of an even distribution over the beam
  const double half_beam = 0.5 * sensor.beam_width;
  Random random(1);
  for (int target = 0; target < kTargets; ++target) {
    Passage passage(options, {0.1, 0.0, 0.0}, random);
    const bool is_wall = random.uniform(0.0, 1.0) < 0.5;
    const double range = random.uniform(3.0, 9.0);
    const double alpha = kPi / 2 + random.normal(options.features.wall_direction_sigma);
    const double rho = range * std::sin(alpha);
    // A point that comes into the beam when the passage begins.
    const Eigen::Vector2d point(range * std::tan(half_beam) * random.uniform(-1.0, 1.0), range);
    std::array<bool, 3> reached{};
    for (int ping = 0; ping < kPings && !reached[2]; ++ping) {
      if (ping > 0) passage.move();
      const Eigen::Vector2d seen = transform(inverse(passage.beam()), point);
      const double ray = random.uniform(-half_beam, half_beam);
      double heard =
          is_wall ? TrueWall{rho, alpha}.range(oplus(passage.beam(), {0.0, 0.0, ray})) : seen.norm();
      if (!is_wall && std::abs(std::atan2(seen.y(), seen.x())) > half_beam) heard = 0.0;
      if (!(heard > 0.0 && heard < sensor.max_range) ||
          random.uniform(0.0, 1.0) < options.features.overlook_probability) {
        if (ping == 0) break;
        passage.map().see_past({0, sensor.max_range, 0.0}, Match::kNone, 1);
      } else {
        passage.hear(heard + random.normal(sensor.range_sigma), 0.0);
      }
      const double log_ratio = passage.feature().evidence.log_ratio();
      for (std::size_t i = 0; i < errors.size(); ++i) {
        if (reached[i] || std::abs(log_ratio) <= std::log(errors[i].ratio)) continue;
        reached[i] = true;
        ++errors[i].decided;
        errors[i].wrong += (log_ratio > 0.0) != is_wall;
      }
    }
  }
  for (const Errors& e : errors) {
    const double allowed = kTargets / e.ratio;
    EXPECT_GT(e.decided, kTargets / 2) << e.ratio;
    EXPECT_LE(e.wrong, allowed + 3.0 * std::sqrt(allowed)) << "of " << e.decided << " at " << e.ratio;
  }
}

}  // namespace
}  // namespace leadline
