#include "apps/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "apps/report/report_data.h"
#include "apps/report/report_files.h"
#include "apps/support/atomic_file.h"

namespace leadline::app {
namespace {

std::string_view embedded(std::string_view name) {
  const auto found = std::ranges::find(kReportFiles, name, &EmbeddedFile::name);
  if (found == kReportFiles.end()) {
    throw std::logic_error(fmt::format("the report has no part '{}'", name));
  }
  return found->text;
}

/// JSON that may stand inside a <script> element, whatever texts it holds.
std::string script_safe(const nlohmann::json& data) {
  std::string safe;
  for (const char c : data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) {
    if (c == '<') {
      safe += "\\u003c";  // neither "</script>" nor "<!--" can arise
    } else {
      safe += c;
    }
  }
  return safe;
}

/// The template with every {{name}} replaced by the embedded file of that name, and {{data}} by `data`.
std::string fill_template(std::string_view text, std::string_view data) {
  std::string page;
  for (;;) {
    const std::size_t open = text.find("{{");
    page += text.substr(0, open);
    if (open == std::string_view::npos) {
      return page;
    }
    const std::size_t close = text.find("}}", open);
    const std::string_view name = text.substr(open + 2, close - open - 2);
    page += name == "data" ? data : embedded(name);
    text.remove_prefix(close + 2);
  }
}

}  // namespace

void write_report(std::span<const std::filesystem::path> result_folders,
                  const std::filesystem::path& output_html) {
  if (result_folders.empty()) {
    throw std::runtime_error("a report needs at least one result folder");
  }
  nlohmann::json folders = nlohmann::json::array();
  for (const std::filesystem::path& folder : result_folders) {
    folders.push_back(read_result_folder(folder));
  }
  const std::string page = fill_template(embedded("report.html"), script_safe(folders));
  AtomicFile file(output_html);
  file.write(std::as_bytes(std::span(page)));
  file.commit();
}

}  // namespace leadline::app
