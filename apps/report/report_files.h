#pragma once

#include <span>
#include <string_view>

namespace leadline::app {

/// A text file that the build has put into the program.
struct EmbeddedFile {
  std::string_view name;
  std::string_view text;
};

/// The parts of the report page: the files of apps/report/ and D3.
extern const std::span<const EmbeddedFile> kReportFiles;

}  // namespace leadline::app
