#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/report/report.h"
#include "apps/support/usage_error.h"

namespace leadline::app {
namespace {

struct ReportArguments {
  std::vector<std::filesystem::path> folders;
  Output output;
};

void draw_report(const ReportArguments& arguments) {
  Output output = arguments.output;
  if (output.path.empty()) {
    if (arguments.folders.size() > 1) throw UsageError("name the page of several folders with -o");
    output.path = arguments.folders.front() / "report.html";
    output.force = true;
  }
  output.check_file();
  write_report(arguments.folders, output.path);
  fmt::print("{}\n", output.path.string());
}

}  // namespace

void add_report(CLI::App& app) {
  const auto arguments = std::make_shared<ReportArguments>();
  CLI::App& command =
      *app.add_subcommand("report", "Make one HTML page of result folders, several runs side by side");
  command.add_option("folders", arguments->folders, "Result folders of run and compare")
      ->required()
      ->type_name("DIR...");
  arguments->output.add(command, "PAGE.html", "The page; of a single folder by default its report.html",
                        false);
  command.footer("\nExample:\n  leadline report results/ukf results/ekf -o ukf_and_ekf.html");
  command.callback([arguments] { draw_report(*arguments); });
}

}  // namespace leadline::app
