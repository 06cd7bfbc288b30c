#include "apps/cli/input.h"

#include <fmt/format.h>

#include "apps/config/simulation.h"
#include "apps/recordings/usage.h"
#include "apps/support/progress.h"
#include "apps/support/usage_error.h"
#include "leadline/vehicle/corrections.h"

namespace leadline::app {

Input::Input(const ConfigOptions& options, const Config& config, const InputArguments& arguments)
    : log_(arguments.log) {
  if (log_.empty()) {
    if (config.world == SimulatedWorld::none)
      throw UsageError(
          fmt::format("{} simulates no world: name a recording with --log", options.path().string()));
    simulated_ = simulate(config, config.seed);
    correct(simulated_.instants, config.corrections);
    in_memory_.emplace(simulated_, config.slam.sensors);
  } else {
    in_log_.emplace(log_, LogSelection{config.slam.sensors, config.channel_prefix, arguments.ignore,
                                       config.corrections, config.log_duration});
    check_use(log_, in_log_->report().survey, config.slam, config.channel_prefix);
    warn_of_log();
    warn_of(in_log_->report().survey.complaints());
  }
}

RecordingSource& Input::source() {
  if (in_log_) return *in_log_;
  return *in_memory_;
}

void Input::warn_of_log() {
  if (!in_log_) return;
  std::vector<std::string> warnings = in_log_->report().warnings();
  std::erase_if(warnings, [&](const std::string& warning) { return !said_.insert(warning).second; });
  warn_of(warnings);
}

void Input::warn_of(const std::vector<std::string>& warnings) const {
  for (const std::string& warning : warnings) warn(fmt::format("{}: {}", log_.string(), warning));
}

}  // namespace leadline::app
