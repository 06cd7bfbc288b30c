#include "apps/node/monitor.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

namespace leadline::app {
namespace {

/// CPU time of the process so far [s].
double cpu_time() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Resident memory [bytes].
std::int64_t memory() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t size = 0, resident = 0;
  statm >> size >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

void add_line(std::string& text, const std::string& line) {
  if (line.empty()) return;
  if (!text.empty()) text += "; ";
  text += line;
}

}  // namespace

Monitor::Monitor(std::int64_t timeout, std::int64_t now)
    : timeout_(timeout), start_(now), period_start_(now), cpu_start_(cpu_time()) {}

void Monitor::refused(std::string_view channel, const Rejection& rejection) {
  if (refusals_[rejection.reason].count++ == 0)
    spdlog::warn("{}: {} (the first of its kind; the health messages count them)", channel, rejection.text);
}

void Monitor::received(const std::string& name, std::int64_t utime, std::int64_t seq,
                       const Intake::Answer& answer, std::int64_t now) {
  if (streams_.size() == slam_health_t::MAX_STREAMS && !streams_.contains(name)) return;
  Stream& stream = streams_[name];
  const bool is_repeated = answer.verdict == Intake::Verdict::repeated;
  stream.standing += stream.received > 0 && utime == stream.utime && seq != stream.seq;
  stream.utime = utime;
  stream.seq = seq;
  stream.last = now;
  ++stream.received;
  stream.repeated += is_repeated;
  if (!is_repeated) stream.lost += stream.gaps.missing_before(seq);
  if (answer.verdict != Intake::Verdict::late && answer.verdict != Intake::Verdict::stray) return;
  ++stream.late;
  if (std::abs(answer.ahead) <= std::abs(stream.ahead)) return;
  stream.ahead = answer.ahead;
  stream.ahead_of = answer.others;
}

void Monitor::judged(const std::string& name, double nis, int dof) {
  const auto stream = streams_.find(name);
  if (stream == streams_.end() || dof <= 0) return;
  ++stream->second.checked;
  stream->second.nis += nis / dof;
}

void Monitor::stepped(double cost) {
  ++steps_;
  cost_sum_ += cost;
  cost_max_ = std::max(cost_max_, cost);
}

std::string Monitor::complaints(const std::string& name, const Stream& stream, bool silent,
                                std::int64_t now) const {
  if (silent)
    return fmt::format("{} silent for {:.0f} s", name, 1e-6 * static_cast<double>(now - stream.last));
  std::string text;
  if (stream.gaps.has_two_senders()) text = fmt::format("{}: two senders, by their counters", name);
  if (stream.lost > stream.lost_before)
    add_line(text, fmt::format("{} lost {}", name, stream.lost - stream.lost_before));
  if (stream.late > stream.late_before)
    add_line(text, fmt::format("{} late {}, {:.3g} s {} {}", name, stream.late - stream.late_before,
                               1e-6 * static_cast<double>(std::abs(stream.ahead)),
                               stream.ahead < 0 ? "behind" : "ahead of", stream.ahead_of));
  if (stream.standing > 0)
    add_line(text,
             fmt::format("{}: {} of {} messages have the stamp of the one before: does its clock stand?",
                         name, stream.standing, stream.received - stream.received_before));
  return text;
}

slam_health_t Monitor::report(std::int64_t now) {
  slam_health_t health{};
  const double seconds = std::max(1e-6 * static_cast<double>(now - period_start_), 1e-6);
  const double cpu = cpu_time();
  health.uptime = 1e-6 * static_cast<double>(now - start_);
  health.cpu = (cpu - cpu_start_) / seconds;
  health.step_mean = steps_ > 0 ? cost_sum_ / steps_ : 0.0;
  health.step_max = cost_max_;
  health.memory = memory();
  for (auto& [name, stream] : streams_) {
    const bool silent = now - stream.last > timeout_;
    add_line(health.text, complaints(name, stream, silent, now));
    ++health.streams;
    health.stream.push_back(name);
    health.silent.push_back(silent);
    health.rate.push_back(static_cast<double>(stream.received - stream.received_before) / seconds);
    health.age.push_back(1e-6 * static_cast<double>(now - stream.last));
    health.received.push_back(stream.received);
    health.lost.push_back(stream.lost);
    health.late_ones.push_back(stream.late);
    health.repeated.push_back(stream.repeated);
    health.checked.push_back(stream.checked);
    health.nis.push_back(stream.checked > 0 ? stream.nis / stream.checked : 0.0);
    health.late += stream.late;
    stream.received_before = stream.received;
    stream.lost_before = stream.lost;
    stream.late_before = stream.late;
    stream.checked = stream.standing = 0;
    stream.nis = 0.0;
    stream.ahead = 0;
    stream.ahead_of.clear();
  }
  for (auto& [reason, refusals] : refusals_) {
    ++health.reasons;
    health.reason.emplace_back(name(reason));
    health.refused.push_back(refusals.count);
    if (refusals.count > refusals.before)
      add_line(health.text, fmt::format("refused {} ({})", refusals.count - refusals.before, name(reason)));
    refusals.before = refusals.count;
  }
  period_start_ = now;
  cpu_start_ = cpu;
  cost_sum_ = cost_max_ = 0.0;
  steps_ = 0;
  return health;
}

}  // namespace leadline::app
