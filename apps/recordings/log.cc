#include "apps/recordings/log.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>

#include "apps/recordings/log_source.h"
#include "apps/support/interrupt.h"
#include "apps/wire/event_encoder.h"
#include "apps/wire/event_log.h"
#include "apps/wire/stream_counter.h"

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

}  // namespace

void LogReport::refuse(RejectReason reason, std::size_t count, std::string text) {
  Refused& refused_ones = refused[reason];
  if (refused_ones.count == 0) refused_ones.first = std::move(text);
  refused_ones.count += count;
}

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
                   std::string_view prefix, std::span<const std::string> ignore) {
  LogSource source(path, {sensors, prefix, ignore});
  Recording recording = read_all(source);
  report = source.report();
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
