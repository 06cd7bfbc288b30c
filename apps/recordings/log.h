/// @file
/// Recordings as LCM event logs, which lcm-logger, lcm-logplayer and lcm-spy know too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/recordings/recording_source.h"
#include "apps/recordings/survey.h"
#include "apps/wire/event_log.h"
#include "apps/wire/messages.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline::app {

/// What was in a log besides what came out of it.
struct LogReport {
  struct Refused {
    std::size_t count = 0;
    std::string first;  ///< where and why
  };

  std::size_t events = 0;                   ///< in the file
  std::size_t foreign = 0;                  ///< of these on channels that are not ours
  std::map<RejectReason, Refused> refused;  ///< messages on our channels that were not used
  std::int64_t lost = 0;                    ///< messages that are missing by the counters `seq`
  std::set<std::string> two_senders;        ///< streams in which two counters go on in turns
  Survey survey;                            ///< channel by channel
  LogDamage damage;                         ///< what is not used of the file's bytes
  std::uintmax_t bytes = 0;                 ///< of the file

  /// @param text where and why, of the first.
  void refuse(RejectReason reason, std::size_t count, std::string text);
  /// One line for each thing that the user should know; empty after a clean log.
  std::vector<std::string> warnings() const;
};

/// What has been written.
struct WrittenLog {
  std::size_t instants = 0;
  std::size_t truth = 0;
};

/// Writes a log: times of events are those of the measurements, so that equal recordings give equal bytes. At
/// equal times sensors come before truth. An instant at which nothing was measured leaves no trace.
/// @throws std::invalid_argument if the source is empty or gives what no reader would accept (order of time,
/// limits).
/// @throws std::runtime_error if the file cannot be written, or as the source does; nothing is left behind.
WrittenLog write_log(RecordingSource& source, const std::filesystem::path& path,
                     std::string_view prefix = kDefaultPrefix);

/// The same of a recording. @param sensors the names and kinds behind its indices.
void write_log(const Recording& recording, std::span<const Sensor> sensors, const std::filesystem::path& path,
               std::string_view prefix = kDefaultPrefix);

/// Reads a log. Measurements are ordered and joined by their own time (`utime`), not by that of their
/// reception. Messages that are not sound are left out and counted in @p report.
/// @param sensors those whose sightings are wanted.
/// @param ignore channels, and sensors on them, that are not wanted, by patterns (ignore.h).
/// What is damaged is passed over: of a log that was cut off all but its last event is used.
/// @throws std::runtime_error naming file and byte if it cannot be read, is no log, or holds no measurement.
Recording read_log(const std::filesystem::path& path, std::span<const Sensor> sensors, LogReport& report,
                   std::string_view prefix = kDefaultPrefix, std::span<const std::string> ignore = {});

/// What is in a log, by types, whatever the prefixes of its channels.
/// @param[out] damage what is not used of the file's bytes.
/// @throws std::runtime_error as EventLogReader does.
Survey survey_log(const std::filesystem::path& path, LogDamage& damage);

}  // namespace leadline::app
