#include "apps/recordings/csv_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <iterator>

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

}  // namespace

std::string_view known_name_like(const std::string& name) {
  constexpr std::size_t kTelling = 3;  // letters
  const std::string stem = lower_case(fs::path(name).stem().string());
  if (stem.size() < kTelling) return {};
  for (const KnownFile& known : kKnownFiles) {
    const std::string_view other = known.name.substr(0, known.name.size() - 4);
    if (stem.find(other) != std::string::npos || other.find(stem) != std::string_view::npos)
      return known.name;
  }
  return {};
}

bool may_be_table(const std::string& name) {
  const std::string ending = lower_case(fs::path(name).extension().string());
  const bool is_text = ending == ".txt" || ending == ".tsv" || ending == ".dat";
  return ending == ".csv" || (is_text && !known_name_like(name).empty());
}

std::string known_names() {
  std::string names;
  for (const KnownFile& known : kKnownFiles)
    names += fmt::format("{}{}", names.empty() ? "" : ", ", known.name);
  return names;
}

std::vector<std::string> files_of(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    if (!entry.is_directory()) names.push_back(entry.path().filename().string());
  std::erase_if(names, [](const std::string& name) { return name.starts_with('.'); });
  std::ranges::sort(names);
  return names;
}

bool is_known(std::string_view name) {
  return std::ranges::find(kKnownFiles, name, &KnownFile::name) != std::end(kKnownFiles);
}

}  // namespace leadline::app
