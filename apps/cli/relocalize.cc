#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/input.h"
#include "apps/cli/options.h"
#include "apps/cli/places.h"
#include "apps/evaluation/relocate.h"
#include "apps/maps/known_map_file.h"
#include "apps/recordings/recording_source.h"
#include "apps/support/interrupt.h"
#include "apps/support/progress.h"

namespace leadline::app {
namespace {

struct RelocalizeArguments {
  ConfigOptions options;
  std::filesystem::path map;
  InputArguments input;
  double start = 0.0;  // [s], of the recording that is left out
  std::optional<double> period, memory;
};

/// What is left of a recording after some seconds.
class LaterPart : public ChangedSource {
 public:
  LaterPart(RecordingSource& source, double left_out) : ChangedSource(source), left_out_(left_out) {}

  std::optional<Instant> next_instant() override {
    std::optional<Instant> instant = next_unchanged();
    if (!begin_ && instant) begin_ = instant->utime + std::llround(1e6 * left_out_);
    while (instant && instant->utime < *begin_) instant = next_unchanged();
    return instant;
  }

 private:
  double left_out_;                    // [s]
  std::optional<std::int64_t> begin_;  // [us]
};

std::string_view word(const Relocation& outcome) {
  if (outcome.is_found) return "found";
  return outcome.answer.verdict == PlaceAnswer::Verdict::nothing ? "unknown" : "ambiguous";
}

void relocalize(const RelocalizeArguments& arguments) {
  Config config = arguments.options.config();
  RelocalizationOptions& search = config.slam.relocalization;
  search.period = arguments.period.value_or(search.period);
  search.memory = arguments.memory.value_or(search.memory);
  const KnownMapFile map(arguments.map);
  Input input(arguments.options, config, arguments.input);
  LaterPart later(input.source(), arguments.start);
  Relocation outcome;
  {
    Progress progress("searching", input.instants());
    outcome = relocate(config.slam, landmarks(map.features(config.slam)), later, [&] {
      throw_if_interrupted();
      progress.advance();
    });
  }
  input.warn_of_log();
  if (outcome.searches == 0)
    throw std::runtime_error(fmt::format("nothing is left of the recording after {} s", arguments.start));
  fmt::print("{} after {:.1f} s, {} searches\n{}", word(outcome), outcome.after, outcome.searches,
             table_of(outcome.answer));
}

}  // namespace

void add_relocalize(CLI::App& app) {
  const auto arguments = std::make_shared<RelocalizeArguments>();
  ConfigOptions& options = arguments->options;
  CLI::App& command =
      *app.add_subcommand("relocalize", "Find the place of a vehicle in a map, of which it knows nothing");
  options.add_config(command);
  command
      .add_option(
          "MAP", arguments->map,
          "The map: one of run --save-map or of a node, a folder of results or its map.csv, landmarks "
          "(id,x,y,sigma)")
      ->required();
  command
      .add_option("--log", arguments->input.log,
                  "The recording; without it the configured world is simulated")
      ->type_name("RUN.lcmlog");
  add_ignore(command, arguments->input.ignore, "Leave out the channel NAME of the log");
  command.add_option("--start", arguments->start, "Leave out so many seconds of the recording")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.0, 1e9));
  command.add_option("--every", arguments->period, "Search at every so many seconds")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.01, 1e6));
  command.add_option("--memory", arguments->memory, "Use what was heard in the last so many seconds")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.1, 1e6));
  options.add_association(command);
  options.add_set_and_seed(command);
  command.footer(
      "\nPrints found, ambiguous or unknown, and the places where the vehicle may be, the likeliest first.\n"
      "\nExample:\n"
      "  leadline run configs/harbour_loops.yaml --set simulation.world_seed=1 -o yesterday\n"
      "  leadline relocalize configs/harbour_loops.yaml yesterday --set simulation.world_seed=1 --seed 2 "
      "--start 200");
  command.callback([arguments] { relocalize(*arguments); });
}

}  // namespace leadline::app
