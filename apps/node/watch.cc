#include "apps/node/watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string_view>
#include <utility>

#include "apps/node/status_words.h"
#include "apps/support/text_table.h"
#include "leadline/core/angle.h"

namespace leadline::app {
namespace {

constexpr std::int64_t kHealthPeriod = 1'000'000;  // [us]
constexpr std::int64_t kRateWindow = 2'000'000;    // [us]
constexpr std::size_t kLongestName = 32;           // of a stream

constexpr std::string_view kRed = "\x1b[31m", kYellow = "\x1b[33m", kGreen = "\x1b[32m", kBold = "\x1b[1m",
                           kPlain = "\x1b[0m";

double in_seconds(std::int64_t microseconds) { return 1e-6 * static_cast<double>(microseconds); }

/// The beginning of a text that takes so many columns; a character beyond ASCII takes one.
std::string_view fitting(std::string_view text, std::size_t columns) {
  std::size_t end = 0, taken = 0;
  for (; end < text.size(); ++end) {
    const bool begins = (static_cast<unsigned char>(text[end]) & 0xc0U) != 0x80U;
    if (begins && ++taken > columns) break;
  }
  return text.substr(0, end);
}

std::string short_name(const std::string& name) {
  constexpr std::size_t kHead = 12;
  if (name.size() <= kLongestName) return name;
  return name.substr(0, kHead) + ".." + name.substr(name.size() - (kLongestName - kHead - 2));
}

double sigma_of(double variance) { return std::sqrt(std::max(variance, 0.0)); }

std::string pose_text(const vehicle_state_t& s) {
  std::string text = fmt::format("x {:.3f} m +- {:.3f}   y {:.3f} m +- {:.3f}   heading {:.1f} deg +- {:.1f}",
                                 s.x, sigma_of(s.cov[0]), s.y, sigma_of(s.cov[3]), to_degrees(s.heading),
                                 to_degrees(sigma_of(s.cov[5])));
  if (s.speed_known) text += fmt::format("   speed {:.2f} m/s", s.speed);
  return text;
}

std::string_view colour_of(std::int8_t status) {
  if (status == slam_health_t::LOST) return kRed;
  return status == slam_health_t::OK ? kGreen : kYellow;
}

std::string clock_time(double uptime) {
  const auto s = static_cast<std::int64_t>(uptime);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

/// Those of counts that are not 0.
std::string counts_text(const slam_health_t& h) {
  const std::pair<std::string_view, std::int64_t> counts[] = {{"late", h.late},
                                                              {"clock set", h.clock_jumps},
                                                              {"readings refused", h.bad_values},
                                                              {"weak echoes", h.echoes_dropped},
                                                              {"no room", h.map_full},
                                                              {"numerical trouble", h.numerical_trouble},
                                                              {"labels refused", h.labels_refused}};
  std::string text;
  for (const auto& [name, count] : counts)
    if (count != 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, count);
  for (std::size_t i = 0; i < h.reason.size(); ++i)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", h.reason[i], h.refused[i]);
  return text;
}

}  // namespace

Watch::Watch(std::string source, std::int64_t now) : source_(std::move(source)), start_(now) {}

void Watch::hear(const vehicle_state_t& state, std::int64_t now) {
  states_lost_ += gaps_.missing_before(state.seq);
  state_ = state;
  state_time_ = now;
  state_times_.push_back(now);
  while (now - state_times_.front() > kRateWindow) state_times_.pop_front();
}

void Watch::hear(const slam_health_t& health, std::int64_t now) {
  health_ = health;
  health_time_ = now;
}

bool Watch::is_health_old(std::int64_t now) const { return now - health_time_ > 3 * kHealthPeriod; }

/// Of those that came in the last seconds; 0 when none does any more.
double Watch::state_rate(std::int64_t now) const {
  const auto first = std::ranges::lower_bound(state_times_, now - kRateWindow);
  const auto n = state_times_.end() - first;
  if (n < 2) return 0.0;
  const std::int64_t span = std::max(state_times_.back() - *first, now - state_times_.back());
  return static_cast<double>(n - 1) / in_seconds(std::max<std::int64_t>(span, 1));
}

/// Why there is nothing to be seen; empty if there is something.
std::string Watch::silence(std::int64_t now) const {
  if (!network_trouble_.empty()) return "no network: " + network_trouble_;
  if (!health_)
    return fmt::format("nothing heard for {:.0f} s: is a node running there, with that prefix?",
                       in_seconds(now - start_));
  if (is_health_old(now))
    return fmt::format("no health for {:.0f} s: the node has ended, or the network is gone",
                       in_seconds(now - health_time_));
  return {};
}

std::string Watch::screen(const Room& room, bool colours, std::int64_t now) const {
  std::vector<Line> lines{{fmt::format("leadline watch   {}", source_), kBold}};
  add_status(lines, now);
  if (state_) add_state(lines, now);
  if (health_) {
    add_node(lines);
    add_streams(lines, now);
  }
  if (lines.size() > room.rows) {
    const std::size_t hidden = lines.size() - room.rows + 1;
    lines.resize(room.rows - std::min<std::size_t>(room.rows, 1));
    lines.push_back({fmt::format("... {} more lines in a higher window", hidden)});
    lines.resize(std::min(lines.size(), room.rows));
  }
  std::string text;
  for (const Line& line : lines) {
    const std::string_view seen = fitting(line.text, room.columns);
    const bool coloured = colours && !line.colour.empty();
    text += fmt::format("{}{}{}\n", coloured ? line.colour : "", seen, coloured ? kPlain : "");
  }
  return text;
}

/// What is wrong has a line for each sentence.
void Watch::add_status(std::vector<Line>& lines, std::int64_t now) const {
  if (const std::string why = silence(now); !why.empty()) {
    lines.push_back({"status   " + why, kRed});
    if (!health_) return;
    lines.push_back({fmt::format("was      {}", status_name(health_->status))});
  } else {
    lines.push_back({fmt::format("status   {}", status_name(health_->status)), colour_of(health_->status)});
  }
  std::string_view rest = health_->text;
  while (!rest.empty()) {
    const std::size_t end = rest.find("; ");
    lines.push_back({fmt::format("         {}", rest.substr(0, end)), colour_of(health_->status)});
    rest = end == rest.npos ? std::string_view() : rest.substr(end + 2);
  }
}

void Watch::add_state(std::vector<Line>& lines, std::int64_t now) const {
  lines.push_back({"pose     " + pose_text(*state_)});
  const double rate = state_rate(now);
  lines.push_back(
      {fmt::format("states   {}the last {:.1f} s ago, of {:.3f} s{}{}",
                   rate > 0.0 ? fmt::format("{:.1f} Hz, ", rate) : "", in_seconds(now - state_time_),
                   in_seconds(state_->utime), state_->dead_reckoning ? ", by dead reckoning" : "",
                   states_lost_ > 0 ? fmt::format(", {} lost on the way", states_lost_) : "")});
}

void Watch::add_node(std::vector<Line>& lines) const {
  const slam_health_t& h = *health_;
  lines.push_back(
      {fmt::format("map      {} features in use, {} submaps{}; removed {}, joined {}; loops closed {}",
                   h.features, h.submaps, state_ ? fmt::format(" (in {})", state_->submap) : std::string(),
                   h.features_absent + h.features_displaced, h.features_joined, h.loops_closed)});
  lines.push_back(
      {fmt::format("node     up {}, {} steps of {:.0f} us (at most {:.0f}), CPU {:.1f} %, {:.1f} MB, {} "
                   "waiting",
                   clock_time(h.uptime), h.steps, h.step_mean, h.step_max, 100.0 * h.cpu,
                   1e-6 * static_cast<double>(h.memory), h.queue)});
  if (const std::string counts = counts_text(h); !counts.empty())
    lines.push_back({"counts   " + counts, kYellow});
}

/// Ages go on between two healths.
void Watch::add_streams(std::vector<Line>& lines, std::int64_t now) const {
  const slam_health_t& h = *health_;
  std::vector<std::vector<std::string>> rows{
      {"channel", "NIS", "of", "rate [Hz]", "age [s]", "received", "lost", "late", "twice"}};
  for (std::size_t i = 0; i < h.stream.size(); ++i)
    rows.push_back(
        {short_name(h.stream[i]), h.checked[i] > 0 ? fmt::format("{:.2f}", h.nis[i]) : "-",
         fmt::format("{}", h.checked[i]), fmt::format("{:.1f}", h.rate[i]),
         fmt::format("{:.1f}{}", h.age[i] + in_seconds(now - health_time_), h.silent[i] ? " silent" : ""),
         fmt::format("{}", h.received[i]), fmt::format("{}", h.lost[i]), fmt::format("{}", h.late_ones[i]),
         fmt::format("{}", h.repeated[i])});
  lines.push_back({""});
  std::istringstream table(format_table(rows));
  std::string text;
  for (std::size_t i = 0; std::getline(table, text); ++i)
    lines.push_back({text, i == 0 ? kBold : h.silent[i - 1] ? kYellow : std::string_view()});
}

std::string Watch::line(std::int64_t now) const {
  std::string text = silence(now);
  if (text.empty()) text = status_name(health_->status);
  if (state_)
    text = fmt::format("{:.3f} s   {}   {}   {:.1f} Hz", in_seconds(state_->utime), text, pose_text(*state_),
                       state_rate(now));
  if (health_ && !health_->text.empty()) text += "   " + health_->text;
  return text;
}

}  // namespace leadline::app
