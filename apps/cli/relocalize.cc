#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/relocate.h"
#include "apps/maps/known_map_file.h"
#include "apps/recordings/log_source.h"
#include "apps/recordings/usage.h"
#include "apps/support/interrupt.h"
#include "apps/support/text_table.h"
#include "apps/support/usage_error.h"
#include "leadline/core/angle.h"

namespace leadline::app {
namespace {

struct RelocalizeArguments {
  ConfigOptions options;
  std::filesystem::path map, log;
  double start = 0.0;  // [s], of the recording that is left out
  RelocateOptions search;
};

/// What is left of a recording after some seconds.
class LaterPart : public RecordingSource {
 public:
  LaterPart(RecordingSource& source, double seconds) : source_(source), left_out_(seconds) {}

  std::optional<Instant> next_instant() override {
    std::optional<Instant> instant = source_.next_instant();
    if (!begin_ && instant) begin_ = instant->utime + static_cast<std::int64_t>(1e6 * left_out_);
    while (instant && instant->utime < *begin_) instant = source_.next_instant();
    return instant;
  }
  std::optional<Truth> next_truth() override { return source_.next_truth(); }
  std::span<const TrueFeature> map() const override { return source_.map(); }
  std::span<const Sensor> sensors() const override { return source_.sensors(); }

 private:
  RecordingSource& source_;
  double left_out_;
  std::optional<std::int64_t> begin_;  // [us]
};

std::string_view word(PlaceAnswer::Verdict verdict) {
  switch (verdict) {
    case PlaceAnswer::Verdict::nothing:
      return "unknown";
    case PlaceAnswer::Verdict::ambiguous:
      return "ambiguous";
    case PlaceAnswer::Verdict::found:
      break;
  }
  return "found";
}

/// The places where the vehicle may be, the likeliest first.
std::string table_of(const PlaceAnswer& answer) {
  std::vector<std::vector<std::string>> rows{
      {"x [m]", "y [m]", "heading [deg]", "sd [m]", "sd [deg]", "of heard", "probability"}};
  for (const Place& place : answer.places) {
    const auto& [X, P] = place.X_WV;
    rows.push_back({fmt::format("{:.2f}", X.x), fmt::format("{:.2f}", X.y),
                    fmt::format("{:.1f}", to_degrees(X.heading)),
                    fmt::format("{:.2f}", std::sqrt(0.5 * (P(0, 0) + P(1, 1)))),
                    fmt::format("{:.1f}", to_degrees(std::sqrt(P(2, 2)))),
                    fmt::format("{}", place.matches.size()), fmt::format("{:.4f}", place.probability)});
  }
  rows.push_back({"elsewhere", "", "", "", "", "", fmt::format("{:.4f}", answer.elsewhere)});
  return format_table(rows);
}

Relocation relocate_by(const RelocalizeArguments& arguments, const Config& config, RecordingSource& source) {
  const KnownMapFile map(arguments.map);
  LaterPart later(source, arguments.start);
  RelocateOptions search = arguments.search;
  search.progress = [](double, const PlaceAnswer&) { throw_if_interrupted(); };
  return relocate(config.slam, landmarks(map.features(config.slam)), later, search);
}

void relocalize(const RelocalizeArguments& arguments) {
  const Config config = arguments.options.config();
  Relocation outcome;
  if (arguments.log.empty()) {
    if (config.world == SimulatedWorld::none)
      throw UsageError(fmt::format("{} simulates no world: name a recording with --log",
                                   arguments.options.path().string()));
    Recording recording = simulate(config, config.seed);
    correct(recording.instants, config.corrections);
    RecordedSource source(recording, config.slam.sensors);
    outcome = relocate_by(arguments, config, source);
  } else {
    LogSource source(
        arguments.log,
        {config.slam.sensors, config.channel_prefix, {}, config.corrections, config.log_duration});
    check_use(arguments.log, source.report().survey, config.slam, config.channel_prefix);
    outcome = relocate_by(arguments, config, source);
  }
  fmt::print("{} after {:.1f} s, {} searches\n{}", word(outcome.answer.verdict), outcome.after,
             outcome.searches, table_of(outcome.answer));
}

}  // namespace

void add_relocalize(CLI::App& app) {
  const auto arguments = std::make_shared<RelocalizeArguments>();
  ConfigOptions& options = arguments->options;
  CLI::App& command =
      *app.add_subcommand("relocalize", "Find the place of a vehicle in a map, of which it knows nothing");
  options.add_config(command);
  command
      .add_option("MAP", arguments->map,
                  "The map: one that a node has saved, a folder of results or its map.csv, landmarks "
                  "(id,x,y,sigma)")
      ->required();
  command.add_option("--log", arguments->log, "The recording; without it the configured world is simulated")
      ->type_name("RUN.lcmlog");
  command.add_option("--start", arguments->start, "Leave out so many seconds of the recording")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.0, 1e9));
  command.add_option("--every", arguments->search.period, "Search at every so many seconds")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.01, 1e6));
  command.add_option("--memory", arguments->search.memory, "Use what was heard in the last so many seconds")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.1, 1e6));
  options.add_association(command);
  options.add_set_and_seed(command);
  command.footer(
      "\nPrints found, ambiguous or unknown, and the places where the vehicle may be, the likeliest first.\n"
      "\nExample:\n"
      "  leadline run configs/harbour_loops.yaml --seed 1 -o yesterday\n"
      "  leadline relocalize configs/harbour_loops.yaml yesterday --seed 2 --start 200");
  command.callback([arguments] { relocalize(*arguments); });
}

}  // namespace leadline::app
