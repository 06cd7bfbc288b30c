// Teaches: a motion model of your own is one struct; everything else takes it as it takes the library's. This
// vehicle knows its speed through the water and its heading; the water moves, nobody says how. With the
// current in the state, positions that come now and then (here: of a ship's beacon) tell it.
#include <cmath>
#include <cstdio>
#include <variant>

#include "leadline/vehicle/motion/parts.h"
#include "leadline/vehicle/navigation_impl.h"

// [x y psi c_x c_y] with the current c [m/s] in W; noise of the speed and yaw rate read, and of the current.
struct InCurrent {
  static constexpr std::string_view kName = "in_current";
  static constexpr std::string_view kMeaning = "speed through the water, which moves";
  static constexpr int kState = 5, kNoise = 4;
  static constexpr leadline::HeadingUse kHeading = leadline::HeadingUse::measured;
  using Input = leadline::VelocityInput;

  struct Options {
    using Model = InCurrent;
    double speed_sigma = 0.05;                            // [m/s]
    double yaw_rate_sigma = leadline::from_degrees(0.5);  // [rad/s]
    double current_sigma = 0.5;                           // [m/s], at the start
    double current_drift = 0.002;                         // [m/s / sqrt(s)]

    leadline::Vector<2> initial_value() const { return leadline::Vector<2>::Zero(); }
    leadline::Vector<2> initial_sigma() const { return leadline::Vector<2>::Constant(current_sigma); }
  };

  Options options;
  Input input;
  double dt;  // [s]

  InCurrent(const Options& options, const Input& input, double dt) : options(options), input(input), dt(dt) {}

  leadline::Matrix<4, 4> noise() const {
    const double drift = options.current_drift * std::sqrt(dt);
    const leadline::Vector<4> sigma(options.speed_sigma, options.yaw_rate_sigma, drift, drift);
    return sigma.array().square().matrix().asDiagonal();
  }

  template <class T>
  Eigen::Matrix<T, 5, 1> operator()(const Eigen::Matrix<T, 5, 1>& vehicle,
                                    const Eigen::Matrix<T, 4, 1>& w) const {
    Eigen::Matrix<T, 5, 1> next = vehicle;
    const T turn = (w[1] + input.yaw_rate) * dt;
    const T distance = (w[0] + input.speed) * dt;
    leadline::internal::advance(next, T(vehicle[2] + turn * 0.5), Eigen::Matrix<T, 2, 1>(distance, T(0.0)));
    next[0] += vehicle[3] * dt;
    next[1] += vehicle[4] * dt;
    next[2] += turn;
    next[3] += w[2];
    next[4] += w[3];
    return next;
  }
};

int main() {
  const std::variant<InCurrent::Options> motion;
  const leadline::Linearizer linearizer;
  // Additive: then a position is a sum of entries of the vehicle.
  leadline::Belief belief =
      leadline::any_motion::initial_belief({}, motion, leadline::ErrorKind::additive, 0);

  const leadline::VelocityInput input{.speed = 0.5, .yaw_rate = leadline::from_degrees(3.0)};
  double x = 0.0, y = 0.0, heading = 0.0;  // the truth
  for (int second = 1; second <= 300; ++second) {
    x += input.speed * std::cos(heading + 0.5 * input.yaw_rate) + 0.35;
    y += input.speed * std::sin(heading + 0.5 * input.yaw_rate) - 0.15;
    heading += input.yaw_rate;
    leadline::any_motion::predict(belief, motion, linearizer, input, {}, 1.0);
    if (second % 10 != 0) continue;
    leadline::Innovation<1, 1> innovation;
    if (belief.innovate<1>({0}, x, 1.0, false, innovation) == leadline::Status::ok)
      belief.correct(innovation);
    if (belief.innovate<1>({1}, y, 1.0, false, innovation) == leadline::Status::ok)
      belief.correct(innovation);
  }
  const Eigen::MatrixXd P = belief.vehicle_covariance();
  std::printf("current %.2f m/s %.2f m/s, sigma %.2f m/s\n", belief.vehicle()[3], belief.vehicle()[4],
              std::sqrt(P(3, 3)));
}
