#include "apps/recordings/log.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>

#include "apps/recordings/ignore.h"
#include "apps/support/interrupt.h"
#include "apps/wire/event_encoder.h"
#include "apps/wire/event_log.h"
#include "apps/wire/stream_counter.h"
#include "leadline/vehicle/timeline.h"

namespace leadline::app {
namespace {

/// The next item of a series, which is later than the one before.
template <class T>
std::optional<T> later(const std::optional<T>& before, std::optional<T> next, std::string_view what) {
  if (before && next && next->utime <= before->utime)
    throw std::invalid_argument(fmt::format("the {} at utime {} is followed by one at {}, must be later",
                                            what, before->utime, next->utime));
  return next;
}

void refuse(LogReport& report, RejectReason reason, std::size_t count, std::string text) {
  LogReport::Refused& refused = report.refused[reason];
  if (refused.count == 0) refused.first = std::move(text);
  refused.count += count;
}

/// Takes messages and makes a recording of them.
class Collector {
 public:
  Collector(std::span<const Sensor> sensors, std::span<const std::string> ignore,
            const Corrections& corrections, LogReport& report)
      : sensors_(sensors), ignore_(ignore), corrections_(corrections), report_(report) {}

  void add(EventLogReader& event, Receiver receive) {
    const std::string channel(event.channel());
    if (is_ignored(channel, ignore_)) return;
    const auto received = receive(event.data());
    if (const auto* rejection = std::get_if<Rejection>(&received)) {
      report_.survey.refuse(channel, rejection->text);
      return refuse_event(event, *rejection);
    }
    const Message& message = std::get<Message>(received);
    const std::string stream = std::visit([&](const auto& m) { return stream_of(channel, m); }, message);
    if (is_ignored(stream, ignore_)) return;
    report_.survey.add(stream, message);
    Content said = content(message, sensors_);
    if (const auto* rejection = std::get_if<Rejection>(&said)) return refuse_event(event, *rejection);
    if (auto* instant = std::get_if<Instant>(&said)) add_instant(corrected(std::move(*instant), corrections_));
    if (const auto* truth = std::get_if<Truth>(&said)) recording_.truth.push_back(*truth);
    if (const auto* map = std::get_if<std::vector<TrueFeature>>(&said)) add_features(*map);
    std::visit([&](const auto& m) { count_lost(stream, m.utime, m.seq); }, message);
  }

  /// On a channel that is not read: what it is, the first message tells.
  void pass_over(EventLogReader& event) {
    ++report_.foreign;
    const std::string channel(event.channel());
    if (is_ignored(channel, ignore_)) return;
    const auto known = others_.find(channel);
    const MessageFormat* format = known != others_.end() ? known->second : format_of(event.data());
    others_.try_emplace(channel, format);
    report_.survey.pass_over(channel, format, event.timestamp());
  }

  Recording finish() && {
    std::ranges::move(late_, std::back_inserter(recording_.instants));
    twice_ += join_by_time(recording_.instants) + join_by_time(recording_.truth);
    if (twice_ > 0)
      refuse(report_, RejectReason::duplicate, twice_, "a second value for the same time is not used");
    return std::move(recording_);
  }

 private:
  void refuse_event(const EventLogReader& event, const Rejection& rejection) {
    refuse(report_, rejection.reason, 1,
           fmt::format("byte {}: {}: {}", event.position(), event.channel(), rejection.text));
  }

  /// Most come in the order of time and are joined at once, so that memory holds each instant once.
  void add_instant(Instant&& instant) {
    std::vector<Instant>& instants = recording_.instants;
    if (instants.empty() || instant.utime > instants.back().utime)
      instants.push_back(std::move(instant));
    else if (instant.utime < instants.back().utime)
      late_.push_back(std::move(instant));
    else
      twice_ += !join(instants.back(), instant);
  }

  void count_lost(const std::string& stream, std::int64_t utime, std::int64_t seq) {
    auto& [gaps, last] = counted_[stream];
    if (std::exchange(last, std::pair(utime, seq)) == std::pair(utime, seq)) return;  // it came twice
    report_.lost += gaps.missing_before(seq);
    if (gaps.has_two_senders()) report_.two_senders.insert(stream);
  }

  void add_features(const std::vector<TrueFeature>& features) {
    for (const TrueFeature& feature : features) {
      const auto [place, added] = places_.try_emplace(feature.label, recording_.map.size());
      if (added) {
        recording_.map.push_back(feature);
        continue;
      }
      TrueFeature& known = recording_.map[place->second];
      const Lifetime life{known.life.from, std::min(known.life.until, feature.life.until)};
      known = feature;
      known.life = life;
    }
  }

  struct Counted {
    GapFinder gaps;
    std::optional<std::pair<std::int64_t, std::int64_t>> last;  // time and number
  };

  std::span<const Sensor> sensors_;
  std::span<const std::string> ignore_;
  const Corrections& corrections_;
  LogReport& report_;
  std::map<std::string, const MessageFormat*> others_;  // by channel
  std::map<std::string, Counted> counted_;              // by stream
  std::map<int, std::size_t> places_;                   // of labels in the map
  Recording recording_;
  std::vector<Instant> late_;  // to be joined when all have come, after those of their time
  std::size_t twice_ = 0;      // said for the same time
};

/// The true map as it is told: what is there at the beginning, then what is put there or taken away.
std::map<std::int64_t, std::vector<TrueFeature>> told(const std::vector<TrueFeature>& map,
                                                      std::int64_t begin) {
  std::map<std::int64_t, std::vector<TrueFeature>> at;
  for (const TrueFeature& feature : map) {
    if (feature.life.from <= begin) at[begin].push_back(feature);
    for (const std::int64_t time : {feature.life.from, feature.life.until})
      if (time > begin && time != Lifetime{}.until) at[time].push_back(feature);
  }
  return at;
}

/// Where measurements are that are not read.
std::string other_prefixes(const Survey& survey) {
  std::string text;
  for (const auto& [name, channel] : survey.channels())
    if (!channel.read && channel.format && receiver_of(channel.format->channel, ""))
      text += fmt::format("{}{} ({}, {} messages)", text.empty() ? "; there is " : ", ", name,
                          channel.format->type, channel.messages);
  return text.empty() ? text : text + ": another log.channel_prefix?";
}

}  // namespace

std::vector<std::string> LogReport::warnings() const {
  std::vector<std::string> lines;
  if (damage)
    lines.push_back(
        fmt::format("damaged or cut off: {} of {} bytes hold no event and are not used, the first: {}; used "
                    "are the other {} events",
                    damage.bytes, bytes, damage.first, events));
  for (const auto& [reason, refused_ones] : refused) {
    lines.push_back(fmt::format("{} messages refused ({}), the first: {}", refused_ones.count, name(reason),
                                refused_ones.first));
  }
  if (lost > 0)
    lines.push_back(fmt::format("{} messages are missing by their counters (or were refused)", lost));
  for (const std::string& stream : two_senders)
    lines.push_back(fmt::format("{}: two senders, by their counters", stream));
  return lines;
}

WrittenLog write_log(RecordingSource& source, const std::filesystem::path& path, std::string_view prefix) {
  constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
  std::optional<Instant> instant = source.next_instant();
  if (!instant) throw std::invalid_argument("the recording has no instant");
  std::optional<Truth> truth = source.next_truth();
  auto features = told({source.map().begin(), source.map().end()}, instant->utime);

  EventEncoder encoder(prefix);
  EventLogWriter log(path);
  const auto write = [&](std::vector<Message> messages) {
    for (Message& message : messages) {
      const Event event = encoder.encode(std::move(message));
      log.write(event.utime, event.channel, event.data);
    }
  };
  WrittenLog written;
  while (instant || truth || !features.empty()) {
    throw_if_interrupted();
    const std::int64_t measured = instant ? instant->utime : kNever, known = truth ? truth->utime : kNever,
                       changed = features.empty() ? kNever : features.begin()->first;
    if (instant && measured <= std::min(known, changed)) {
      write(to_messages(*instant, source.sensors()));
      instant = later(instant, source.next_instant(), "instant");
      ++written.instants;
    } else if (truth && known <= changed) {
      write({to_message(*truth)});
      truth = later(truth, source.next_truth(), "truth");
      ++written.truth;
    } else {
      write(to_messages(features.begin()->second, changed));
      features.erase(features.begin());
    }
  }
  log.commit();
  return written;
}

void write_log(const Recording& recording, std::span<const Sensor> sensors, const std::filesystem::path& path,
               std::string_view prefix) {
  RecordedSource source(recording, sensors);
  write_log(source, path, prefix);
}

Recording read_log(const std::filesystem::path& path, std::span<const Sensor> sensors, LogReport& report,
                   std::string_view prefix, std::span<const std::string> ignore,
                   const Corrections& corrections) {
  EventLogReader event(path);
  Collector collector(sensors, ignore, corrections, report);
  while (event.next()) {
    ++report.events;
    if (const Receiver receive = receiver_of(event.channel(), prefix))
      collector.add(event, receive);
    else
      collector.pass_over(event);
  }
  report.damage = event.damage();
  report.bytes = event.size();
  Recording recording = std::move(collector).finish();
  if (recording.instants.empty()) {
    std::string message = fmt::format("{}: holds no measurement: {} events, {} of them not on channels {}*",
                                      path.string(), report.events, report.foreign, prefix);
    for (const std::string& warning : report.warnings()) message += "; " + warning;
    throw std::runtime_error(message + other_prefixes(report.survey));
  }
  return recording;
}

Survey survey_log(const std::filesystem::path& path, LogDamage& damage) {
  Survey survey;
  std::map<std::string, const MessageFormat*> formats;  // by channel, as its first message tells
  EventLogReader event(path);
  while (event.next()) {
    throw_if_interrupted();
    const std::string channel(event.channel());
    const auto known = formats.find(channel);
    const bool is_new = known == formats.end();
    if (!is_new && !known->second) {
      survey.pass_over(channel, nullptr, event.timestamp());
      continue;
    }
    const Bytes data = event.data();
    const MessageFormat* format = is_new ? formats[channel] = format_of(data) : known->second;
    const Receiver receive = format ? receiver_of(format->channel, "") : nullptr;
    if (!receive) {
      survey.pass_over(channel, format, event.timestamp());
      continue;
    }
    const auto received = receive(data);
    if (const auto* rejection = std::get_if<Rejection>(&received)) {
      survey.refuse(channel, rejection->text);
      continue;
    }
    const Message& message = std::get<Message>(received);
    survey.add(std::visit([&](const auto& m) { return stream_of(channel, m); }, message), message);
  }
  damage = event.damage();
  return survey;
}

}  // namespace leadline::app
