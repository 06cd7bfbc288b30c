#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/recordings/csv_reader.h"
#include "apps/recordings/import.h"
#include "apps/recordings/log.h"
#include "apps/recordings/usage.h"
#include "apps/support/text_table.h"
#include "apps/support/usage_error.h"

namespace leadline::app {
namespace {

struct ImportArguments {
  std::string format;
  std::filesystem::path source;
  ImportOptions options;
  Output output;
};

struct Written {
  std::unique_ptr<ImportSource> source;
  WrittenLog log;
};

Written write(const Importer& importer, const ImportArguments& arguments) {
  try {
    auto source = importer.open(arguments.source, arguments.options);
    const WrittenLog log = write_log(*source, arguments.output.path);
    return {std::move(source), log};
  } catch (const BadRow& bad) {
    if (arguments.options.skip_bad) throw;
    throw std::runtime_error(std::string(bad.what()) + " (--skip-bad leaves such rows out)");
  }
}

void import_into_log(const ImportArguments& arguments) {
  const auto importer = std::ranges::find(importers(), arguments.format, &Importer::name);
  if (importer == importers().end()) throw UsageError(fmt::format("there is no format {}", arguments.format));
  if (!importer->has_options && arguments.options != ImportOptions())
    throw UsageError(fmt::format("import {} has no options of how to read", importer->name));
  arguments.output.check_file();
  const auto [source, written] = write(*importer, arguments);
  for (const std::string& note : source->notes()) warn(note);
  fmt::print("{}: {} instants, {} of the truth, {} true features\n", arguments.output.path.string(),
             written.instants, written.truth, source->map().size());
  LogDamage none;
  const Survey survey = survey_log(arguments.output.path, none);
  for (const std::string& complaint : survey.complaints()) warn(complaint);
  fmt::print("{}", format_table(table_of(survey)));
}

void add_reading_options(CLI::App& command, ImportOptions& options) {
  using Angle = ImportOptions::Angle;
  using From = ImportOptions::HeadingFrom;
  command.add_option("--heading", options.heading, "csv: unit of heading.csv, deg or rad")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, Angle>{{"deg", Angle::deg}, {"rad", Angle::rad}}))
      ->type_name("UNIT");
  command
      .add_option("--heading-from", options.heading_from,
                  "csv: east-ccw, from x and counter-clockwise (the default), or north-cw, as a compass")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, From>{{"east-ccw", From::east_ccw}, {"north-cw", From::north_cw}}))
      ->type_name("WAY");
  command
      .add_option("--no-echo", options.no_echo,
                  "csv: a range that means that there was no echo; may be repeated")
      ->type_name("VALUE")
      ->allow_extra_args(false);
  command.add_flag("--skip-bad", options.skip_bad,
                   "csv: leave out rows that cannot be used, and say how many");
  add_ignore(command, options.ignore, "csv: leave out the file NAME");
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
  add_reading_options(command, arguments->options);
  command.footer(formats +
                 "\nExamples:\n  leadline import csv my_recording -o my.lcmlog\n"
                 "  leadline import csv my_recording -o my.lcmlog --heading deg --heading-from north-cw");
  command.callback([arguments] { import_into_log(*arguments); });
}

}  // namespace leadline::app
