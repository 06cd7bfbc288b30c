/// @file
/// What a command estimates: a recording as it is simulated, or as a log has it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "apps/cli/options.h"
#include "apps/config/config.h"
#include "apps/recordings/log_source.h"
#include "apps/recordings/recording_source.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// Which recording that is.
struct InputArguments {
  std::filesystem::path log;        ///< empty: the world of the configuration is simulated
  std::vector<std::string> ignore;  ///< names of channels of the log
};

/// Warns of what is wrong with a log.
class Input {
 public:
  /// @throws UsageError if there is no log and no world; std::runtime_error as LogSource and check_use() do.
  /// @param options that @p config is of.
  Input(const ConfigOptions& options, const Config& config, const InputArguments& arguments);
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;

  RecordingSource& source();
  std::size_t instants() const { return in_log_ ? in_log_->instants() : simulated_.instants.size(); }

  /// Says what has not been said of the log: some of it is known only at its end.
  void warn_of_log();

 private:
  void warn_of(const std::vector<std::string>& warnings) const;

  std::filesystem::path log_;
  Recording simulated_;
  std::optional<RecordedSource> in_memory_;
  std::optional<LogSource> in_log_;
  std::set<std::string> said_;
};

}  // namespace leadline::app
