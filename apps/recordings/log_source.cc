#include "apps/recordings/log_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>
#include <variant>

#include "leadline/vehicle/timeline.h"

namespace leadline::app {
namespace {

/// Notes what is said of the true map.
class TrueMap {
 public:
  void add(const std::vector<TrueFeature>& features) {
    for (const TrueFeature& feature : features) {
      const auto [place, added] = places_.try_emplace(feature.label, map_.size());
      if (added) {
        map_.push_back(feature);
        continue;
      }
      TrueFeature& known = map_[place->second];
      const Lifetime life{known.life.from, std::min(known.life.until, feature.life.until)};
      known = feature;
      known.life = life;
    }
  }

  std::vector<TrueFeature> map() && { return std::move(map_); }

 private:
  std::map<int, std::size_t> places_;  // of labels
  std::vector<TrueFeature> map_;
};

/// Counts the instants that a log will make.
class InstantCount {
 public:
  void add(std::int64_t utime) {
    if (times_.empty() || utime > times_.back())
      times_.push_back(utime);
    else if (utime < times_.back())
      late_.push_back(utime);
  }

  bool empty() const { return times_.empty(); }
  std::int64_t first() const {
    return late_.empty() ? times_[0] : std::min(times_[0], std::ranges::min(late_));
  }
  /// How many there are until @p end, that included.
  std::size_t until(std::int64_t end) && {
    std::ranges::sort(late_);
    late_.erase(std::unique(late_.begin(), late_.end()), late_.end());
    std::erase_if(late_, [&](std::int64_t utime) { return std::ranges::binary_search(times_, utime); });
    const auto until_end = [end](const std::vector<std::int64_t>& times) {
      return static_cast<std::size_t>(std::ranges::upper_bound(times, end) - times.begin());
    };
    return until_end(times_) + until_end(late_);
  }

 private:
  std::vector<std::int64_t> times_;  // each later than those before
  std::vector<std::int64_t> late_;
};

/// Where measurements are that are not read.
std::string other_prefixes(const Survey& survey) {
  std::string text;
  for (const auto& [name, channel] : survey.channels())
    if (!channel.read && channel.format && receiver_of(channel.format->channel, ""))
      text += fmt::format("{}{} ({}, {} messages)", text.empty() ? "; there is " : ", ", name,
                          channel.format->type, channel.messages);
  return text.empty() ? text : text + ": another log.channel_prefix?";
}

bool join_truth(Truth&, const Truth&) { return false; }

std::string no_measurement(const std::filesystem::path& path, const LogSelection& selection,
                           const LogReport& report) {
  std::string message = fmt::format("{}: holds no measurement: {} events, {} of them not on channels {}*",
                                    path.string(), report.events, report.foreign, selection.prefix);
  for (const std::string& warning : report.warnings()) message += "; " + warning;
  return message + other_prefixes(report.survey);
}

}  // namespace

LogSource::Found LogSource::find(const std::filesystem::path& path, const LogSelection& selection,
                                 LogReport& report) {
  LogPass pass(path, selection, LogPass::Channels::all, &report);
  TrueMap map;
  InstantCount count;
  Found found;
  while (const std::optional<Content> said = pass.next()) {
    if (const auto* instant = std::get_if<Instant>(&*said)) {
      count.add(instant->utime);
      found.instants_late.add(instant->utime);
    }
    if (const auto* truth = std::get_if<Truth>(&*said)) found.truth_late.add(truth->utime);
    if (const auto* features = std::get_if<std::vector<TrueFeature>>(&*said)) map.add(*features);
  }
  if (count.empty()) throw std::runtime_error(no_measurement(path, selection, report));
  if (std::isfinite(selection.duration)) found.end = count.first() + std::llround(1e6 * selection.duration);
  found.instants = std::move(count).until(found.end);
  found.map = std::move(map).map();
  return found;
}

LogSource::LogSource(const std::filesystem::path& path, const LogSelection& selection)
    : selection_(selection),
      found_(find(path, selection, report_)),
      instants_({path, selection, LogPass::Channels::all_but_truth}, {found_.instants_late.most(), join}),
      truth_({path, selection, LogPass::Channels::truth}, {found_.truth_late.most(), join_truth}) {}

std::optional<Instant> LogSource::next_instant() { return next(instants_); }
std::optional<Truth> LogSource::next_truth() { return next(truth_); }

template <class T>
std::optional<T> LogSource::next(InOrder<T>& items) {
  for (;;) {
    if (std::optional<T> item = items.order.next(items.ended))
      return item->utime <= found_.end ? std::move(item) : std::nullopt;
    if (items.ended) return std::nullopt;
    std::optional<Content> said = items.pass.next();
    items.ended = !said;
    if (items.ended && items.order.left_out() > 0)
      report_.refuse(RejectReason::duplicate, items.order.left_out(),
                     "a second value for the same time is not used");
    if (said && std::holds_alternative<T>(*said)) items.order.add(std::get<T>(std::move(*said)));
  }
}

Recording read_all(LogSource& source) {
  Recording recording;
  recording.instants.reserve(source.instants());
  while (std::optional<Instant> instant = source.next_instant())
    recording.instants.push_back(std::move(*instant));
  while (const std::optional<Truth> truth = source.next_truth()) recording.truth.push_back(*truth);
  recording.map.assign(source.map().begin(), source.map().end());
  return recording;
}

}  // namespace leadline::app
