#include "leadline/vehicle/input_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

namespace leadline {

namespace {

constexpr std::int64_t kFewest = 20;  // inputs from which is known what they are like

constexpr double kMostTurnRate = 3.0;  // [rad/s], of which none is strange
constexpr double kGap = 1.5;           // of the usual interval

/// Of an error that stays: what it has done after @p to seconds beyond what it had after @p from.
double grown(double rate, double from, double to) {
  return std::abs(rate) * std::sqrt(to * to - from * from);
}

OdometryInput sum(const OdometryInput& a, const OdometryInput& b, double times) {
  return {a.dx + times * b.dx, a.dy + times * b.dy, a.dheading + times * b.dheading};
}

}  // namespace

InputWatch::InputWatch(const MotionOptions& motion, const GateOptions& options)
    : timeout_(options.input_timeout),
      wheel_base_(1.0),
      judges_(options.inputs),
      makes_up_(options.lost_increments) {
  constexpr double kSigmas = 10.0;
  if (const auto* increments = std::get_if<OdometryMotion::Options>(&motion))
    least_ = kSigmas * increments->increment_sigma;
  if (const auto* velocity = std::get_if<VelocityMotion::Options>(&motion))
    least_ = kSigmas * velocity->input_speed_sigma;
  if (const auto* car = std::get_if<AckermannMotion::Options>(&motion)) {
    least_ = kSigmas * car->input_speed_sigma;
    wheel_base_ = car->wheel_base;
  }
}

InputWatch::Motion InputWatch::over(const MotionInput& input, double dt) {
  silence_ += dt;
  suspected_ += dt;
  const auto* increment = std::get_if<OdometryInput>(&input);
  if (increment) return of_increment(*increment);
  if (std::holds_alternative<OdometryInput>(held_)) return of_no_increment();
  return of_held(input, dt);
}

InputWatch::Motion InputWatch::of_held(const MotionInput& input, double dt) {
  Motion motion;
  motion.held = held();
  if (is_silent() && !std::holds_alternative<std::monostate>(held_)) {
    const Values rates = values(held_).abs().max(usual());
    const double moved = grown(rates[0], unknown_, silence_);
    motion.sigma << moved, moved, grown(rates[2], unknown_, silence_);
    unknown_ = silence_;
  } else if (suspect_) {
    const Values off = values(*suspect_) - values(held_);
    const double before = suspected_ - dt;
    const double moved = grown(off[0], before, suspected_);
    motion.sigma << moved, moved, grown(off[2], before, suspected_);
  }
  if (std::holds_alternative<std::monostate>(input)) return motion;

  const Values now = values(input);
  const bool is_strange = judges_ && is_beyond(now, 1.0), agrees = is_strange && agrees_with_suspect(now);
  if (suspect_ && !agrees) ++counts_.refused;
  suspect_.reset();
  suspected_ = silence_ = unknown_ = 0.0;
  if (is_strange && !agrees) {
    suspect_ = input;
  } else {
    held_ = input;
    learn(now);
  }
  return motion;
}

/// Whether there is one, and these are far less from it than it is from those before.
bool InputWatch::agrees_with_suspect(const Values& now) const {
  if (!suspect_) return false;
  const Values suspect = values(*suspect_);
  return (now - suspect).matrix().norm() < 0.5 * (suspect - values(held_)).matrix().norm();
}

InputWatch::Motion InputWatch::of_increment(const OdometryInput& input) {
  Motion motion;
  motion.now = input;
  const auto* before = std::get_if<OdometryInput>(&held_);
  const Values now = values(input);
  const double longer = interval_ > 0.0 ? std::max(silence_ / interval_, 1.0) : 1.0;
  const bool is_strange = judges_ && before && is_beyond(now, longer);
  const bool agrees = is_strange && agrees_with_suspect(now);
  if (suspect_ && !agrees) ++counts_.refused;
  // The next one tells soon; if it agrees, the vehicle is where the one that was left out would have put it.
  const Values off = agrees       ? Values(values(*suspect_) - values(held_))
                     : is_strange ? values(held_)
                                  : Values(Values::Zero());
  motion.sigma << off.abs()[0], off.abs()[1], std::min(std::abs(off[2]), kPi);
  suspect_.reset();
  if (is_strange && !agrees) {
    motion.now = *before;
    suspect_ = input;
  } else if (const double missing = missing_by_number(input); missing > 0.0) {
    make_up_for_lost(input, missing, motion);
    held_ = input;
    learn(now);
  } else if (makes_up_ && longer > kGap) {
    make_up_for_lost(input, missing_by_time(input), motion);
  } else {
    held_ = input;
    learn(now);
  }
  number_ = input.number;
  learn_interval();
  silence_ = unknown_ = 0.0;
  return motion;
}

/// While increments do not come.
InputWatch::Motion InputWatch::of_no_increment() {
  Motion motion;
  if (!is_silent() || interval_ == 0.0) return motion;
  const Values rates = usual() / interval_;
  const double moved = grown(std::max(rates[0], rates[1]), unknown_, silence_);
  motion.sigma << moved, moved, grown(rates[2], unknown_, silence_);
  unknown_ = silence_;
  return motion;
}

/// Root mean squares of those believed.
InputWatch::Values InputWatch::usual() const {
  return (squares_ / static_cast<double>(std::max<std::int64_t>(counts_.used, 1))).sqrt();
}

/// Increments between the last and this one, if there was time for them.
double InputWatch::missing_by_number(const OdometryInput& input) const {
  if (number_ == OdometryInput::kUnnumbered || input.number <= number_ || interval_ == 0.0) return 0.0;
  const auto missing = static_cast<double>(input.number - number_ - 1);
  return missing <= kGap * (silence_ / interval_ - 1.0) + 0.5 ? missing : 0.0;
}

double InputWatch::missing_by_time(const OdometryInput& input) const {
  constexpr std::int64_t kFewestIntervals = 10;
  if (counts_.used < kFewestIntervals) return 0.0;
  const double missing = std::round(silence_ / interval_) - 1.0;
  const Values now = values(input), one = values(held_);
  const bool has_gone_on = (now - one).matrix().norm() > (now - (missing + 1.0) * one).matrix().norm();
  return has_gone_on ? 0.0 : std::max(missing, 0.0);
}

/// Adds what increments that did not come would have said.
void InputWatch::make_up_for_lost(const OdometryInput& input, double missing, Motion& motion) {
  if (missing == 0.0) return;
  counts_.lost += static_cast<std::int64_t>(missing);
  if (unknown_ > 0.0) return;  // it is in the covariance already
  motion.now = sum(sum(input, std::get<OdometryInput>(held_), 0.5 * missing), input, 0.5 * missing);
  // The longest way, but the usual turn: nothing is made of what is seen after the worst.
  const Values longest = missing * high_.abs().max(low_.abs());
  const double moved = std::max(longest[0], longest[1]);
  motion.sigma << moved, moved, std::min(missing * usual()[2], kPi);
}

/// The median, in steps of a twentieth.
void InputWatch::learn_interval() {
  constexpr double kStep = 1.05;
  if (counts_.used <= 1) return;
  if (interval_ == 0.0)
    interval_ = silence_;
  else if (std::abs(silence_ - interval_) > (kStep - 1.0) * interval_)
    interval_ = silence_ > interval_ ? interval_ * kStep : interval_ / kStep;
}

InputWatch::Values InputWatch::values(const MotionInput& input) const {
  if (const auto* v = std::get_if<VelocityInput>(&input)) return {v->speed, 0.0, v->yaw_rate};
  if (const auto* a = std::get_if<AckermannInput>(&input))
    return {a->speed, 0.0, a->speed * std::tan(a->steering) / wheel_base_};
  if (const auto* o = std::get_if<OdometryInput>(&input)) return {o->dx, o->dy, o->dheading};
  return Values::Zero();
}

/// More than twice as fast as any other has been. A vehicle that has gone ahead may go aside or back, and
/// may turn by any angle between two increments.
bool InputWatch::is_beyond(const Values& values, double longer) const {
  if (counts_.used < kFewest) return false;
  const Values most = high_.abs().max(low_.abs());
  const double fastest = 2.0 * longer * std::hypot(most[0], most[1]) + least_;
  if (std::hypot(values[0], values[1]) > fastest) return true;
  return !std::holds_alternative<OdometryInput>(held_) &&
         std::abs(values[2]) > std::max(2.0 * most[2], kMostTurnRate);
}

void InputWatch::learn(const Values& values) {
  low_ = counts_.used == 0 ? values : low_.min(values);
  high_ = counts_.used == 0 ? values : high_.max(values);
  squares_ += values.square();
  ++counts_.used;
}

}  // namespace leadline
