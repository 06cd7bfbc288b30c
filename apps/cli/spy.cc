#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPackages = "liblcm-bin liblcm-java libjchart2d-java default-jre";

bool is_installed(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (::access((fs::path(folder) / program).c_str(), X_OK) == 0) return true;
  return false;
}

/// The jar of the message types, of this build or beside this installation.
fs::path types_jar() {
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path();
  for (const char* place : {"../leadline_lcmtypes.jar", "../share/leadline/leadline_lcmtypes.jar"})
    if (const fs::path jar = folder / place; fs::exists(jar)) return fs::canonical(jar);
  throw std::runtime_error(
      "there is no leadline_lcmtypes.jar: leadline was built where there was no Java; install the packages "
      "default-jdk-headless liblcm-java, then configure and build again");
}

void add_to_environment(const char* name, const std::string& value, std::string_view separator) {
  const char* present = std::getenv(name);
  const std::string all = present != nullptr ? fmt::format("{}{}{}", value, separator, present) : value;
  ::setenv(name, all.c_str(), 1);
}

[[noreturn]] void become_lcm_spy(const std::string& on) {
  for (const char* program : {"lcm-spy", "java"})
    if (!is_installed(program))
      throw std::runtime_error(fmt::format("there is no {}: install the packages {}", program, kPackages));
  add_to_environment("CLASSPATH", types_jar().string(), ":");
  // lcm-spy asks for an option that Java no longer knows.
  add_to_environment("JAVA_TOOL_OPTIONS", "-XX:+IgnoreUnrecognizedVMOptions", " ");
  std::string program = "lcm-spy", url = "--lcm-url=" + on;
  const std::array<char*, 3> command{program.data(), url.data(), nullptr};
  ::execvp(command[0], command.data());
  throw std::runtime_error(fmt::format("lcm-spy: {}", std::strerror(errno)));
}

}  // namespace

void add_spy(CLI::App& app) {
  const auto url = std::make_shared<std::string>();
  CLI::App& command = *app.add_subcommand("spy", "Watch the LCM network with lcm-spy, which needs Java");
  add_url(command, *url);
  command.footer("\nExample, in a second terminal:\n  leadline sim-node configs/tank_0p1.yaml");
  command.callback([url] { become_lcm_spy(*url); });
}

}  // namespace leadline::app
