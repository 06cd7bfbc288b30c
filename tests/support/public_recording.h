/// @file
/// Recordings that others made: they are no part of the project.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string_view>

namespace leadline {

/// Why a test that needs one is skipped.
inline constexpr std::string_view kNoRecordings =
    "LEADLINE_DATA does not name the folder of public recordings";

/// Folder of the recording of that name; nothing where the environment names none.
inline std::optional<std::filesystem::path> public_recording(std::string_view name) {
  const char* data = std::getenv("LEADLINE_DATA");
  if (data == nullptr) return std::nullopt;
  return std::filesystem::path(data) / name;
}

}  // namespace leadline
