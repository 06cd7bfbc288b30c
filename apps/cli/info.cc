#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/recordings/import_csv.h"
#include "apps/recordings/log.h"
#include "apps/recordings/usage.h"
#include "apps/support/text_table.h"

namespace leadline::app {
namespace {

void print_info(const std::filesystem::path& source) {
  std::vector<std::string> faults;
  Survey survey;
  if (std::filesystem::is_directory(source)) {
    survey = survey_csv(source, {}, faults);
  } else {
    LogDamage damage;
    survey = survey_log(source, damage);
    if (damage)
      faults.push_back(fmt::format("{} bytes hold no event, the first: {}", damage.bytes, damage.first));
  }
  for (const auto& [name, channel] : survey.channels())
    if (channel.refused > 0)
      faults.push_back(fmt::format("{}: {} messages cannot be used, the first: {}", name, channel.refused,
                                   channel.first_refused));
  for (std::string& complaint : survey.complaints()) faults.push_back(std::move(complaint));
  fmt::print("{}", format_table(table_of(survey)));
  for (const std::string& fault : faults) fmt::print("! {}\n", fault);
}

}  // namespace

void add_info(CLI::App& app) {
  const auto source = std::make_shared<std::filesystem::path>();
  CLI::App& command =
      *app.add_subcommand("info", "Say what a recording holds, whom it is of use to, and what looks wrong");
  command.add_option("source", *source, "An LCM log, or a folder of CSV files")
      ->required()
      ->type_name("SOURCE");
  command.footer(
      "\nExamples:\n"
      "  leadline info run.lcmlog\n"
      "  leadline info my_recording");
  command.callback([source] { print_info(*source); });
}

}  // namespace leadline::app
