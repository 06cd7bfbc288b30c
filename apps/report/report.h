#pragma once

#include <filesystem>
#include <span>

namespace leadline::app {

/// Writes one self-contained HTML page (no network needed) about the results of one or several
/// folders of `leadline run` or `leadline compare`; several runs stand side by side.
///
/// A failure leaves no half page, and an older page as it was. A folder's name stands in the page.
///
/// @throws std::runtime_error naming folder, file, line and fault when a result folder is not sound
///         or the page cannot be written.
void write_report(std::span<const std::filesystem::path> result_folders,
                  const std::filesystem::path& output_html);

}  // namespace leadline::app
