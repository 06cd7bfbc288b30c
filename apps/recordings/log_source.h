/// @file
/// A log as a source of a recording, which need not fit into memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "apps/recordings/log.h"
#include "apps/recordings/log_pass.h"
#include "apps/recordings/recording_source.h"
#include "apps/recordings/time_order.h"

namespace leadline::app {

/// Gives what a log says in the order of its own times (`utime`), not of reception; what is said of one time
/// is joined. In memory are those instants that are not older than the latest so far by more than the latest
/// comer is late; at the construction 8 bytes an instant.
class LogSource : public RecordingSource {
 public:
  /// Reads the log once, to see what there is.
  /// @throws std::runtime_error naming file and byte if it cannot be read, is no log, or holds no
  /// measurement.
  LogSource(const std::filesystem::path& path, const LogSelection& selection);

  /// How many there will be.
  std::size_t instants() const { return found_.instants; }

  std::optional<Instant> next_instant() override;
  std::optional<Truth> next_truth() override;
  std::span<const TrueFeature> map() const override { return found_.map; }
  std::span<const Sensor> sensors() const override { return selection_.sensors; }

  /// Of the whole log. What is said twice for one time is in it when the instants and the truth have come to
  /// their end.
  const LogReport& report() const { return report_; }

 private:
  struct Found {
    std::vector<TrueFeature> map;
    std::size_t instants = 0;
    std::int64_t end = std::numeric_limits<std::int64_t>::max();  // [us], of what is wanted
    Lateness instants_late, truth_late;
  };
  template <class T>
  struct InOrder {
    InOrder(LogPass log, TimeOrder<T> items) : pass(std::move(log)), order(std::move(items)) {}
    LogPass pass;
    TimeOrder<T> order;
    bool ended = false;
  };

  static Found find(const std::filesystem::path& path, const LogSelection& selection, LogReport& report);
  template <class T>
  std::optional<T> next(InOrder<T>& items);

  LogSelection selection_;
  LogReport report_;
  Found found_;
  InOrder<Instant> instants_;
  InOrder<Truth> truth_;
};

/// All that a log says, in memory.
Recording read_all(LogSource& source);

}  // namespace leadline::app
