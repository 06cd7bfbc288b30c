#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace leadline::app {

/// What the report page draws of one result folder, of `leadline run` or of `leadline compare`.
///
/// Tables become objects of columns; a column of texts becomes {"names": [...], "index": [...]}.
/// Times count from the run's first state. Lengths and angles keep 5 decimals, other numbers 5
/// digits, and long tables are thinned evenly as they are read, so that page and memory stay small;
/// "notes" says where.
/// Files that a run need not have (truth, consistency, map history, submaps) leave their key out.
///
/// @throws std::runtime_error naming file, line and fault when the folder is not as the two commands
///         write it.
[[nodiscard]] nlohmann::json read_result_folder(const std::filesystem::path& folder);

}  // namespace leadline::app
