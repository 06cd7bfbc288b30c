/// @file
/// Options that several sub-commands have.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "apps/config/config.h"

namespace leadline::app {

/// Options that change the configuration; they become settings, so that they pass its checks.
class ConfigOptions {
 public:
  void add_config(CLI::App& command);
  void add_set(CLI::App& command);
  void add_set_and_seed(CLI::App& command);
  void add_map(CLI::App& command);
  void add_association(CLI::App& command);
  void add_filter(CLI::App& command);
  void add_problem(CLI::App& command);

  const std::filesystem::path& path() const { return path_; }
  std::vector<Setting> settings() const;

  /// The configuration that the command line means.
  /// @throws what read_config() throws.
  Config config() const { return read_config(path_, settings()); }

  /// @throws UsageError if that simulates no world.
  Config simulated_config() const;

 private:
  std::filesystem::path path_;
  std::vector<std::string> sets_;
  std::string filter_, map_, association_, problem_, seed_;  // empty: not given
};

/// Refuses a configuration whose map.problem a command does not know. @param allowed those that it does.
/// @throws UsageError
void check_problem(const Config& config, std::initializer_list<Problem> allowed, std::string_view why);

/// Where results go.
struct Output {
  std::filesystem::path path;  ///< empty: nowhere, if the command allows it
  bool force = false;          ///< replace what is there

  void add(CLI::App& command, const char* type, const char* help, bool required);

  /// @throws std::runtime_error if a file would be replaced against the user's will, or is none.
  void check_file() const;
};

/// What is not wanted of a recording.
void add_ignore(CLI::App& command, std::vector<std::string>& patterns, const char* help);

/// The LCM network to talk on.
void add_url(CLI::App& command, std::string& url);

/// To stderr.
void warn(std::string_view text);

}  // namespace leadline::app
