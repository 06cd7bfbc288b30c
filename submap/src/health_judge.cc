#include "leadline/submap/health_judge.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

#include "leadline/core/chi_square.h"

namespace leadline {

namespace {

constexpr double kAlarm = 1e-6;     // chance of a window, or a test, to be told wrong when all is well
constexpr double kTooWide = 4.0;    // times the expected variance: errors twice as large
constexpr double kClip = 100.0;     // NIS by degree of freedom; one reading cannot say more
constexpr int kFewest = 8;          // innovations that are judged
constexpr double kToldFor = 10.0;   // [s] that what happened at one moment is told
constexpr double kSilence = 3.0;    // [s], the least
constexpr double kIntervals = 4.0;  // of the usual ones that are a silence

// Findings that there may be at once; and one of the map.
constexpr std::size_t kOfReading = 5, kOfSensor = 3, kOfInputs = 3;

/// What right innovations with so many degrees of freedom stay below.
double quantile(int dof) {
  static const auto table = [] {
    std::array<double, 2 * InnovationWindow::kSize + 1> q{};
    for (std::size_t i = 1; i < q.size(); ++i)
      q[i] = chi_square_quantile(1.0 - kAlarm, static_cast<double>(i));
    return q;
  }();
  return table[static_cast<std::size_t>(dof)];
}

}  // namespace

Standing standing_of(Finding::Kind kind) {
  if (kind == Finding::Kind::none) return Standing::ok;
  const bool lost =
      kind == Finding::Kind::unmet || kind == Finding::Kind::doubted || kind == Finding::Kind::conflict;
  return lost ? Standing::lost : Standing::degraded;
}

void InnovationWindow::note(double whitened, int dof) {
  const double most = std::sqrt(kClip * dof);
  Entry& entry = entries_[static_cast<std::size_t>(next_)];
  dof_ += dof - entry.dof;
  sum_ -= entry.whitened * entry.whitened;
  entry = {std::clamp(whitened, -most, most), dof};
  sum_ += entry.whitened * entry.whitened;
  next_ = (next_ + 1) % kSize;
  size_ = std::min(size_ + 1, kSize);
  if (next_ > 0) return;
  sum_ = 0.0;  // rounding goes no farther
  for (const Entry& one : entries_) sum_ += one.whitened * one.whitened;
}

bool InnovationWindow::is_wide() const { return size_ >= kFewest && sum_ > kTooWide * quantile(dof_); }

double InnovationWindow::lag1() const {
  double product = 0.0, square = 0.0;
  for (int i = 0; i < size_; ++i) {
    const int at = (next_ - size_ + i + kSize) % kSize;
    const Entry& one = entries_[static_cast<std::size_t>(at)];
    square += one.whitened * one.whitened;
    if (i + 1 < size_)
      product += one.whitened * entries_[static_cast<std::size_t>((at + 1) % kSize)].whitened;
  }
  return square > 0.0 ? product / square : 0.0;
}

HealthJudge::HealthJudge(std::size_t sensors)
    : channels_(kReadingChannels + sensors),
      findings_(kOfReading * kReadingChannels + kOfSensor * sensors + kOfInputs + 1) {
  quantile(1);
}

void HealthJudge::note_match(std::size_t sensor, double nis, int dof) {
  if (dof < 1 || dof > 2 || !std::isfinite(nis)) return;
  Channel& channel = channels_[kReadingChannels + sensor];
  channel.window.note(std::sqrt(std::max(nis, 0.0)), dof);
  ++channel.judged;
  channel.sum += nis;
  channel.dof += dof;
}

void HealthJudge::note_sighting(bool matched) {
  constexpr double kShare = 1.0 / 16.0;
  supported_ += kShare * ((matched ? 1.0 : 0.0) - supported_);
}

void HealthJudge::note_return(std::size_t sensor) {
  Channel& channel = channels_[kReadingChannels + sensor];
  channel.unheard = channel.others = 0;
  channel.are_several = false;
}

void HealthJudge::restart() {
  for (Channel& channel : channels_) {
    Channel fresh;
    fresh.judged = channel.judged;
    fresh.sum = channel.sum;
    fresh.dof = channel.dof;
    fresh.since = channel.since;
    fresh.interval = channel.interval;
    channel = fresh;
  }
  found_ = 0;
  standing_ = Standing::ok;
  wrong_ = false;
  supported_ = unmet_ = 0.0;
}

/// Wald's test of a share of misses of 0.2 against one of 0.8. What one sensor alone does not hear, where it
/// hears nothing at all, says nothing of the map unless others contradict that, too.
void HealthJudge::note_meeting(const Meeting& meeting) {
  const bool is_met = meeting.fate == Meeting::Fate::met;
  Channel& channel = channels_[kReadingChannels + meeting.sensor];
  for (Channel& other : std::span(channels_).subspan(kReadingChannels))
    if (&other != &channel && other.unheard > 0) other.others += is_met ? 1 : -1;
  if (meeting.fate == Meeting::Fate::unheard) {
    if (channel.unheard++ == 0) {
      channel.unheard_from = meeting.travelled;
      channel.unheard_first = meeting.feature;
    }
    channel.unheard_to = meeting.travelled;
    channel.are_several = channel.are_several || meeting.feature != channel.unheard_first;
    if (sensors() > 1 && channel.others >= 0) return;
  }
  const double step = std::log(4.0), most = -1.5 * std::log(kAlarm);
  unmet_ = std::clamp(unmet_ + (is_met ? -step : step), 0.0, most);
}

bool HealthJudge::is_deaf(std::size_t sensor) const {
  constexpr double kWay = 3.0;  // [m], on which a gap, or what has gone, is passed
  const Channel& channel = channels_[kReadingChannels + sensor];
  return sensors() > 1 && channel.are_several && channel.others >= 0 &&
         channel.unheard * std::log(4.0) > -std::log(kAlarm) &&
         channel.unheard_to - channel.unheard_from > kWay;
}

bool HealthJudge::is_map_unmet() const { return unmet_ > -std::log(kAlarm); }

void HealthJudge::judge(const Step& step) {
  found_ = 0;
  wrong_ = is_map_unmet();
  for (std::size_t i = 0; i < step.gates.size(); ++i) {
    take(channels_[i], step.gates[i], step.dt);
    find_in_reading(static_cast<int>(i), step.gates[i]);
  }
  for (std::size_t sensor = 0; sensor < sensors(); ++sensor) find_in_sensor(sensor, step.ranges);
  find_in_inputs(*step.inputs, step.dt);
  if (is_map_unmet()) add(Finding::Kind::unmet, -1, std::round(unmet_ / std::log(4.0)));
  std::ranges::sort(std::span(findings_).first(found_), {}, [](const Finding& finding) {
    return std::tuple(-static_cast<int>(standing_of(finding.kind)), finding.channel, finding.kind);
  });
  standing_ = found_ == 0 ? Standing::ok : standing_of(findings_.front().kind);
}

void HealthJudge::take(Channel& channel, const ReadingGate& gate, double dt) {
  channel.since += dt;
  channel.doubted_for = std::max(channel.doubted_for - dt, 0.0);
  const auto& last = gate.last();
  if (!last) return;
  const auto& [fate, innovation, doubt, elapsed, travelled] = *last;
  const bool is_first = channel.judged == 0;
  if (channel.judged == 1) channel.interval = channel.since;
  if (channel.judged > 1 && channel.since > 0.0)
    channel.interval *= channel.since > channel.interval ? 1.05 : 1.0 / 1.05;  // towards the median
  channel.since = 0.0;
  ++channel.judged;
  channel.sum += innovation.nis;
  channel.dof += 1.0;
  const bool is_far = fate == ReadingFate::far || fate == ReadingFate::believed;
  if (is_far) channel.refused_nis = innovation.nis;
  if (fate == ReadingFate::taken)
    channel.window.note(std::copysign(std::sqrt(std::max(innovation.nis, 0.0)), innovation.residual), 1);
  channel.refused = static_cast<std::uint8_t>((channel.refused << 1) | (is_far ? 1 : 0));
  channel.refused_in_a_row = is_far ? channel.refused_in_a_row + 1 : 0;
  if (fate != ReadingFate::believed) return;
  const bool is_beginning = !is_first && gate.counts().taken == 0 && gate.counts().believed == 1;
  if (is_beginning) {
    channel.beginning = std::abs(innovation.residual);
  } else {
    channel.doubted = std::abs(innovation.residual);
    channel.doubted_for = kToldFor;
  }
}

void HealthJudge::find_in_reading(int index, const ReadingGate& gate) {
  const Channel& channel = channels_[static_cast<std::size_t>(index)];
  if (channel.judged == 0) return;
  constexpr int kManyRefused = 3;  // in a row, each as rare as a chance of the gate's
  const bool is_refused =
      channel.refused_in_a_row >= kManyRefused || std::popcount(channel.refused) > kManyRefused;
  const bool is_supported = supported_ >= 0.5;
  wrong_ = wrong_ || (is_refused && !is_supported);
  if (channel.doubted_for > 0.0) add(Finding::Kind::doubted, index, channel.doubted);
  if (gate.is_refusing_repeats())
    add(Finding::Kind::repeats, index, gate.repeats().repeats());
  else if (is_refused)
    add(is_supported ? Finding::Kind::refused : Finding::Kind::conflict, index, channel.refused_nis);
  else if (channel.window.is_wide())
    add(Finding::Kind::wide, index, channel.window.nis());
  if (channel.judged >= kFewest && channel.since > std::max(kSilence, kIntervals * channel.interval))
    add(Finding::Kind::silent, index, channel.since);
  if (channel.tiny_sigma > 0.0) add(Finding::Kind::tiny_sigma, index, channel.tiny_sigma);
  if (channel.beginning > 0.0) add(Finding::Kind::beginning, index, channel.beginning);
}

void HealthJudge::find_in_sensor(std::size_t sensor, std::span<const RangeWatch> ranges) {
  const int index = static_cast<int>(kReadingChannels + sensor);
  const Channel& channel = channels_[kReadingChannels + sensor];
  const RangeWatch* watch = sensor < ranges.size() ? &ranges[sensor] : nullptr;
  if (watch && watch->is_stuck())
    add(Finding::Kind::stays, index, watch->range());
  else if ((watch && watch->is_quiet()) || is_deaf(sensor))
    add(Finding::Kind::deaf, index, std::max(watch ? watch->silent() : 0, channel.unheard));
  if (channel.window.is_wide()) add(Finding::Kind::wide, index, channel.window.nis());
  if (channel.tiny_sigma > 0.0) add(Finding::Kind::tiny_sigma, index, channel.tiny_sigma);
}

void HealthJudge::find_in_inputs(const InputWatch& inputs, double dt) {
  const InputWatch::Counts now = inputs.counts();
  input_refused_for_ = now.refused > inputs_.refused ? kToldFor : std::max(input_refused_for_ - dt, 0.0);
  input_lost_for_ = now.lost > inputs_.lost ? kToldFor : std::max(input_lost_for_ - dt, 0.0);
  inputs_ = now;
  if (now.used > 0 && inputs.is_silent()) add(Finding::Kind::input_silent, -1, inputs.silence());
  if (input_refused_for_ > 0.0) add(Finding::Kind::input_refused, -1, static_cast<double>(now.refused));
  if (input_lost_for_ > 0.0) add(Finding::Kind::input_lost, -1, static_cast<double>(now.lost));
}

void HealthJudge::add(Finding::Kind kind, int channel, double figure) {
  findings_[found_++] = {kind, channel, figure};
}

HealthJudge::Figures HealthJudge::figures(std::size_t channel) const {
  const Channel& of = channels_[channel];
  return {of.judged, of.dof > 0.0 ? of.sum / of.dof : 0.0};
}

}  // namespace leadline
