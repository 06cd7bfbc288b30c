#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/recordings/import.h"
#include "apps/recordings/log.h"
#include "apps/support/interrupt.h"
#include "apps/support/usage_error.h"

namespace leadline::app {
namespace {

struct ImportArguments {
  std::string format;
  std::filesystem::path source;
  Output output;
};

void import_into_log(const ImportArguments& arguments) {
  const auto importer = std::ranges::find(importers(), arguments.format, &Importer::name);
  if (importer == importers().end()) throw UsageError(fmt::format("there is no format {}", arguments.format));
  arguments.output.check_file();
  const Import import = importer->read(arguments.source);
  throw_if_interrupted();
  write_log(import.recording, import.sensors, arguments.output.path);
  fmt::print("{}: {} instants, {} of the truth, {} true features\n", arguments.output.path.string(),
             import.recording.instants.size(), import.recording.truth.size(), import.recording.map.size());
}

}  // namespace

void add_import(CLI::App& app) {
  const auto arguments = std::make_shared<ImportArguments>();
  CLI::App& command = *app.add_subcommand("import", "Turn a recording in another format into an LCM log");
  std::string formats = "\nFormats:\n";
  std::vector<std::string> names;
  for (const Importer& importer : importers()) {
    formats += fmt::format("  {:<12} {}\n", importer.name, importer.help);
    names.emplace_back(importer.name);
  }
  command.add_option("format", arguments->format, "Format of the source")
      ->required()
      ->check(CLI::IsMember(names))
      ->type_name("FORMAT");
  command.add_option("source", arguments->source, "Where the recording is")->required()->type_name("SOURCE");
  arguments->output.add(command, "RUN.lcmlog", "The log", true);
  command.footer(formats + "\nExample:\n  leadline import csv my_recording -o my.lcmlog");
  command.callback([arguments] { import_into_log(*arguments); });
}

}  // namespace leadline::app
