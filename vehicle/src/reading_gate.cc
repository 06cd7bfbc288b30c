#include "leadline/vehicle/reading_gate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "leadline/core/angle.h"
#include "leadline/core/chi_square.h"
#include "leadline/vehicle/elapsed.h"

namespace leadline {

namespace {

double gate_of(double probability) {
  return probability < 1.0 ? chi_square_quantile(probability, 1) : std::numeric_limits<double>::infinity();
}

bool is_speed(ReadingChannel channel) {
  return channel != ReadingChannel::heading && channel != ReadingChannel::yaw_rate;
}

}  // namespace

double GateOptions::of(ReadingChannel channel) const {
  switch (channel) {
    case ReadingChannel::heading:
      return heading;
    case ReadingChannel::speed:
      return speed;
    case ReadingChannel::yaw_rate:
      return yaw_rate;
    case ReadingChannel::surge:
    case ReadingChannel::sway:
      break;
  }
  return velocity;
}

void visit(OptionVisitor& visitor, GateOptions& gates) {
  constexpr Limits kProbability{0.5, 1.0};
  visitor.number("heading", gates.heading, kProbability,
                 {"", "probability that a right heading reading passes; 1: all do"});
  visitor.number("speed", gates.speed, kProbability, {"", "the same of a speed reading"});
  visitor.number("velocity", gates.velocity, kProbability,
                 {"", "of surge and of sway in a body-velocity reading"});
  visitor.number("yaw_rate", gates.yaw_rate, kProbability, {"", "of a gyro's reading"});
  visitor.number("doubt_after_s", gates.doubt_after, {0.0, 1e4},
                 {"s",
                  "readings that were refused for so long and agree among themselves are believed, and the "
                  "estimate is widened; not while sightings of the map support it"});
  visitor.flag("inputs", gates.inputs,
               {"", "an input far beyond all others is not believed before the next one agrees with it"});
  visitor.number("input_timeout_s", gates.input_timeout, {1e-3, 1e6},
                 {"s",
                  "an input that is not renewed for so long tells nothing: the vehicle has stopped, or "
                  "goes on"});
  visitor.flag("lost_increments", gates.lost_increments,
               {"",
                "increments that did not come, as gaps in time tell, are made up for and widen the estimate; "
                "false where the one after a gap tells of all of it"});
}

void RepeatWatch::note(double value, double sigma) {
  if (last_ && value == *last_) {
    ++repeats_;
    surprise_ = -log_chance(sigma) * repeats_;
    stuck_ = stuck_ || (others_ >= kMany && is_beyond_chance());
    return;
  }
  if (last_) {
    const double step = std::abs(value - *last_);
    if (step <= coarsest_ * sigma) {
      resolution_ = resolution_ > 0.0 ? std::min(resolution_, step) : step;
      steps_ += 1.0;
    }
    others_ += 1.0;
    repeated_ += stuck_ ? kFewest : repeats_;
  }
  last_ = value;
  repeats_ = 0;
  surprise_ = 0.0;
  stuck_ = false;
}

void RepeatWatch::note_silence() { others_ = std::max(others_, 1.0); }

/// Of a channel that has said little else it is not known how often it repeats.
bool RepeatWatch::is_beyond_chance() const {
  constexpr double kTooRare = 13.8;  // a chance of 1e-6
  const double most = others_ >= kMany ? surprise_ : std::log(2.0) * repeats_;
  return repeats_ >= kFewest && std::min(surprise_, most) > kTooRare;
}

/// Logarithm of the chance that a value is the one before: as often as it was, or as rounding makes it. Of
/// one that has never said anything else nothing is known.
double RepeatWatch::log_chance(double sigma) const {
  constexpr double kMostByRounding = 0.9;
  if (others_ == 0.0) return 0.0;
  const double by_count = (repeated_ + 0.05) / (repeated_ + others_ + 0.5);
  // Of values that are not rounded the smallest step becomes ever smaller, about as 2 sigma over their
  // number.
  constexpr double kNotRounded = 8.0;
  const bool is_rounded = resolution_ * steps_ > kNotRounded * sigma;
  const double by_rounding = is_rounded ? std::min(resolution_ / sigma, kMostByRounding) : 0.0;
  return std::log(std::max(by_count, by_rounding));
}

ReadingGate::ReadingGate(ReadingChannel channel, const GateOptions& options)
    : channel_(channel), gate_(gate_of(options.of(channel))), doubt_after_(options.doubt_after) {}

ReadingGate::Verdict ReadingGate::judge(const Innovation& innovation, const Moment& now) {
  repeats_.note(innovation.value, innovation.sigma);
  if (repeats_.repeats() == 0) {
    far_at_first_ = innovation.nis > gate_ ? std::abs(innovation.residual) : 0.0;
    repeated_from_ = now;
    narrowed_ = 0.0;
  }
  doubt_ = 0.0;
  Moment since = run_.readings > 0 ? run_.begin : now;
  Verdict verdict{fate_of(innovation, now), innovation};
  if (verdict.fate == ReadingFate::stuck && narrowed_ > 0.0) {
    doubt_ = std::hypot(doubt_, std::sqrt(std::exchange(narrowed_, 0.0)));
    since = repeated_from_;
  }
  if (is_taken(verdict.fate) && repeats_.repeats() > 0) narrowed_ += innovation.prior * innovation.prior;
  verdict.doubt = doubt_;
  verdict.elapsed = seconds_between(since.utime, now.utime);
  verdict.travelled = now.travelled - since.travelled;
  switch (verdict.fate) {
    case ReadingFate::taken:
      ++counts_.taken;
      break;
    case ReadingFate::far:
      ++counts_.far;
      break;
    case ReadingFate::stuck:
      ++counts_.stuck;
      break;
    case ReadingFate::believed:
      ++counts_.believed;
      break;
  }
  refuses_repeats_ = verdict.fate == ReadingFate::stuck;
  last_ = verdict;
  return verdict;
}

void ReadingGate::shift_clock(std::int64_t shift) {
  run_.begin.utime = after_setting(run_.begin.utime, shift);
  repeated_from_.utime = after_setting(repeated_from_.utime, shift);
}

ReadingFate ReadingGate::fate_of(const Innovation& innovation, const Moment& now) {
  const bool stuck = is_stuck(innovation);
  if (!(innovation.nis > gate_) && !stuck) {
    run_ = {};
    return ReadingFate::taken;
  }
  if (run_.readings == 0 || !agrees(innovation.residual)) run_ = {now, innovation.residual, 0};
  run_.residual = innovation.residual;
  ++run_.readings;
  if (!is_long(innovation, now)) return stuck ? ReadingFate::stuck : ReadingFate::far;
  if (stuck) {
    const double square = innovation.residual * innovation.residual - innovation.prior * innovation.prior;
    if (far_at_first_ > 0.0) doubt_ = std::sqrt(std::max(square, 0.0));
    run_ = {};
    return ReadingFate::stuck;
  }
  doubt_ = std::abs(innovation.residual);
  run_ = {};
  return ReadingFate::believed;
}

bool ReadingGate::is_stuck(const Innovation& innovation) const {
  if (!repeats_.is_stuck()) return false;
  if (!is_speed(channel_) || innovation.value != 0.0) return true;
  const bool has_come_to_it = innovation.nis <= gate_ && innovation.prior < far_at_first_ / 3.0;
  return far_at_first_ > 0.0 && !has_come_to_it;
}

/// Far less from the one before than both from the estimate.
bool ReadingGate::agrees(double residual) const {
  double step = residual - run_.residual;
  if (channel_ == ReadingChannel::heading) step = wrap_angle(step);
  return std::abs(step) <= 0.5 * std::abs(run_.residual);
}

bool ReadingGate::is_long(const Innovation& innovation, const Moment& now) const {
  constexpr int kFewest = 3;
  constexpr double kPatience = 12.0;
  constexpr double kNoBeginning = 1e4;  // NIS, of what no beginning is so wrong by
  const bool was_believed = counts_.taken + counts_.believed > 0;
  if (!was_believed && innovation.nis < kNoBeginning) return run_.readings >= 2;
  const std::int64_t sightings = now.sightings - run_.begin.sightings;
  const std::int64_t matched = now.matched - run_.begin.matched;
  const bool is_supported = matched >= kFewest && 2 * matched >= sightings;
  if (is_supported && channel_ != ReadingChannel::heading) return false;
  const double elapsed = seconds_between(run_.begin.utime, now.utime);
  const double patience = is_supported || !was_believed ? kPatience : 1.0;
  return run_.readings >= kFewest && elapsed >= patience * doubt_after_;
}

}  // namespace leadline
