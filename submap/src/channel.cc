#include "leadline/submap/channel.h"

#include <algorithm>
#include <cmath>

#include "leadline/core/angle.h"

namespace leadline {

namespace {

/// Pings that are remembered.
constexpr double kMemory = 300.0;
constexpr double kFade = 1.0 - 1.0 / kMemory;

constexpr double kSure = 3.0;  // standard deviations

}  // namespace

void MissRate::note(bool was_heard) {
  missed = kFade * missed + (was_heard ? 0.0 : 1.0);
  heard = kFade * heard + (was_heard ? 1.0 : 0.0);
}

double Channel::View::miss_rate() const {
  constexpr double kPrior = 0.2, kPriorLooks = 5.0;
  return (looks + MissRate::of(kPrior, kPriorLooks)).mean();
}

void Channel::note_wall(double residual, double variance, double roughness) {
  constexpr double kMost = 4.0;  // standard deviations
  // The weight does not depend on what has been learnt: it would favour the echoes from before.
  const double smooth = variance - roughness * roughness;
  const double square = std::min(residual * residual, kMost * kMost * variance);
  const double weight = 0.5 / (smooth * smooth);
  walls.echoes = kFade * walls.echoes + 1.0;
  walls.sum = kFade * walls.sum + weight * (square - smooth);
  walls.weight = kFade * walls.weight + weight;
}

void Channel::Copies::note(double share) {
  copies = kFade * copies + share;
  pings = kFade * pings + 1.0;
}

double Channel::Copies::rate() const {
  constexpr double kPrior = 0.02, kPriorPings = 25.0;
  return (kPrior * kPriorPings + copies) / (kPriorPings + pings);
}

void Channel::Unexplained::note(double expected, double range) {
  returns = kFade * returns + expected;
  ranges = kFade * ranges + range;
  pings = kFade * pings + 1.0;
}

double Channel::Unexplained::density(double prior) const {
  constexpr double kPriorPings = 25.0;
  // Alike at all ranges up to twice their mean.
  const double learnt = ranges > 0.0 ? 0.5 * returns * returns / ranges : 0.0;
  return (prior * kPriorPings + learnt) / (kPriorPings + pings);
}

double Channel::new_density(const Sensor& sensor, double configured) const {
  const double of_bearing = std::sqrt(2.0 * kPi) * sensor.bearing_sigma;
  // A scan's return may be anywhere in view.
  const double share = sensor.kind == Sensor::Kind::range_bearing
                           ? of_bearing / std::max(view.to - view.from, of_bearing)
                           : 1.0;
  return share * unexplained.density(configured / share);
}

void Channel::Common::add(double square, double variance, double shared) {
  constexpr double kMost = 16.0;  // variances: one of the two may be another's
  const double inverse = 0.5 / (variance * variance);
  sum += inverse * shared * (variance - std::min(square, kMost * variance));
  weight += inverse * shared * shared;
}

void Channel::Common::note(const Common& pairs) {
  sum = kFade * sum + pairs.sum;
  weight = kFade * weight + pairs.weight;
}

double Channel::Common::share(double prior) const {
  constexpr double kPrior = 10.0, kMost = 0.98;
  return std::clamp((prior * kPrior + sum) / (kPrior + weight), 0.0, kMost);
}

double Channel::Births::log_odds(double prior) const {
  constexpr double kPriorGone = 0.5;
  return std::log((prior + kept) / (kPriorGone + gone));
}

bool Channel::misses_more(double configured) const {
  const double n = pings.pings();
  return pings.missed > n * configured + kSure * std::sqrt(n * configured * (1.0 - configured)) + 1.0;
}

double Channel::wall_roughness(double configured) const {
  constexpr double kFewest = 20.0;  // echoes
  if (walls.echoes < kFewest) return configured;
  const double variance = configured * configured, learnt = walls.sum / walls.weight;
  return learnt > variance + kSure / std::sqrt(walls.weight) ? std::sqrt(learnt) : configured;
}

Channels::Channels(const std::vector<Sensor>& sensors, double overlook_probability)
    : channels_(sensors.size()), overlook_probability_(overlook_probability) {
  for (const Sensor& sensor : sensors) configured_roughness_.push_back(sensor.wall_roughness);
}

void Channels::restore(std::span<const Channel> channels) {
  if (!channels.empty()) channels_.assign(channels.begin(), channels.end());
}

void Channels::note_turn(double turn) {
  for (Channel& channel : channels_) channel.turned += turn;
}

void Channels::note_ping(std::size_t sensor, int feature, std::optional<bool> heard, double bearing) {
  Channel& channel = channels_[sensor];
  channel.feature = feature;
  channel.turned = -bearing;
  if (heard) channel.pings.note(*heard);
}

void Channels::note_cross_talk(std::size_t sensor, double share) { channels_[sensor].cross_talk.note(share); }

void Channels::note_multipath(std::size_t sensor, double share) { channels_[sensor].multipath.note(share); }

void Channels::note_unexplained(std::size_t sensor, double expected, double range) {
  channels_[sensor].unexplained.note(expected, range);
}

void Channels::note_pairs(std::size_t sensor, const Channel::Common& pairs) {
  channels_[sensor].common.note(pairs);
}

void Channels::note_kept(std::size_t sensor, bool gone) {
  Channel::Births& births = channels_[sensor].births;
  births.kept = kFade * births.kept + 1.0;
  births.gone = std::max(kFade * births.gone - (gone ? 1.0 : 0.0), 0.0);
}

void Channels::note_gone(std::size_t sensor, bool kept) {
  Channel::Births& births = channels_[sensor].births;
  births.kept = std::max(kFade * births.kept - (kept ? 1.0 : 0.0), 0.0);
  births.gone = kFade * births.gone + 1.0;
}

void Channels::note_view(std::size_t sensor, double range, double bearing) {
  Channel::View& view = channels_[sensor].view;
  view.farthest = std::max(view.farthest, range);
  view.from = std::min(view.from, bearing);
  view.to = std::max(view.to, bearing);
}

void Channels::note_look(std::size_t sensor, bool seen) { channels_[sensor].view.looks.note(seen); }

void Channels::note_wall(std::size_t sensor, double residual, double variance, double roughness) {
  channels_[sensor].note_wall(residual, variance, roughness);
}

/// @param learnt of a channel, what is asked for.
template <class Learnt>
MissRate Channels::with_others(std::size_t sensor, const Learnt& learnt) const {
  // Few pings, for this sensor may be quite another.
  constexpr double kConfigured = 5.0, kMostOfOthers = 25.0;
  const Channel& own = channels_[sensor];
  MissRate prior = MissRate::of(overlook_probability_, kConfigured);
  for (const Channel& other : channels_)
    if (&other != &own) prior = prior + learnt(other);
  return learnt(own) + MissRate::of(prior.mean(), std::min(prior.pings(), kMostOfOthers));
}

MissRate Channels::miss_rate(std::size_t sensor) const {
  return with_others(sensor, [](const Channel& channel) { return channel.pings; });
}

double Channels::passage_miss_rate(std::size_t sensor) const {
  constexpr double kLeast = 0.01;  // from some side a target may not answer
  return std::max(with_others(sensor, [](const Channel& channel) { return channel.view.looks; }).mean(),
                  kLeast);
}

MissRate Channels::miss_rate_in_doubt(std::size_t sensor) const {
  constexpr double kDoubt = 100.0;  // pings
  const MissRate rate = miss_rate(sensor);
  const double least = (rate + MissRate::of(overlook_probability_, kDoubt)).mean();
  return MissRate::of(std::max(rate.mean(), least), rate.pings());
}

double Channels::wall_roughness(std::size_t sensor) const {
  return channels_[sensor].wall_roughness(configured_roughness_[sensor]);
}

}  // namespace leadline
