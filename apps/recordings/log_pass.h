/// @file
/// One way through a log, front to back.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "apps/recordings/log.h"
#include "apps/wire/event_log.h"
#include "apps/wire/messages.h"
#include "apps/wire/stream_counter.h"
#include "leadline/vehicle/corrections.h"

namespace leadline::app {

/// What is wanted of a log. What it refers to must stay.
struct LogSelection {
  std::span<const Sensor> sensors;  ///< those whose sightings are wanted
  std::string_view prefix = kDefaultPrefix;
  std::span<const std::string> ignore = {};  ///< channels, and sensors on them, by patterns (ignore.h)
  Corrections corrections = {};              ///< of what they say, and of its time
  double duration = std::numeric_limits<double>::infinity();  ///< [s] after the first instant that are wanted
};

/// Goes through the sound messages of a log that are wanted, in the order of their reception.
class LogPass {
 public:
  enum class Channels { all, all_but_truth, truth };

  /// @param report what is found on the way; null: it is known.
  /// @throws std::runtime_error as EventLogReader does; so does next().
  LogPass(const std::filesystem::path& path, const LogSelection& selection, Channels channels = Channels::all,
          LogReport* report = nullptr);

  /// What the next one says; nothing at the end.
  std::optional<Content> next();

 private:
  struct Counted {
    GapFinder gaps;
    std::optional<std::pair<std::int64_t, std::int64_t>> last;  // time and number
  };

  bool is_wanted() const;
  std::optional<Content> take(Receiver receive);
  void pass_over();
  void count_lost(const std::string& stream, std::int64_t utime, std::int64_t seq);
  void refuse(const Rejection& rejection);

  LogSelection selection_;
  std::string truth_channel_;
  Channels channels_;
  LogReport* report_;
  EventLogReader event_;
  std::map<std::string, const MessageFormat*> others_;  // by channel
  std::map<std::string, Counted> counted_;              // by stream
};

}  // namespace leadline::app
