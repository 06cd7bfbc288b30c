/// @file
/// A YAML document in which every value knows where it was written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace leadline::app {

/// Where a value was written.
struct YamlPlace {
  std::string text;           ///< "tank.yaml:12", or the command-line option
  bool command_line = false;  ///< the latter

  /// Refuses what stands there.
  /// @throws UsageError for the command line, else std::runtime_error: "place: message".
  [[noreturn]] void fail(std::string_view message) const;
};

struct YamlTree {
  enum class Kind : std::int8_t { null, scalar, map, list };
  struct Entry;

  Kind kind = Kind::null;
  std::string scalar;
  bool quoted = false;         ///< a scalar in quotes is a text, whatever it looks like
  std::vector<Entry> entries;  ///< in the order of the file; those of a list are named 0, 1, ...
  YamlPlace place;

  YamlTree* find(std::string_view name);
  const YamlTree* find(std::string_view name) const;
};

struct YamlTree::Entry {
  std::string name;
  YamlPlace place;  ///< of the name
  YamlTree value;
};

/// What a value is, in the words of an error message: its text if it is a scalar, else its kind.
std::string describe(const YamlTree& value);

/// Reads one document of plain YAML: no aliases, no duplicate keys.
/// @throws std::runtime_error naming file, line and fault.
YamlTree read_yaml(const std::filesystem::path& path);

/// Puts @p value, itself YAML, in the place that @p key names, as "sensors.0.range_sigma_m". What is on the
/// way there is made if it is missing, except elements of lists.
/// @param option the command-line option that asks for it, named in every later error about the value.
/// @throws UsageError if there is no such place, or the value is not YAML.
void set_yaml(YamlTree& root, std::string_view key, const std::string& value, std::string_view option);

}  // namespace leadline::app
