#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <leadline/slam_command_t.hpp>
#include <leadline/slam_reply_t.hpp>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/support/interrupt.h"
#include "apps/support/usage_error.h"
#include "apps/wire/bus.h"
#include "apps/wire/messages.h"
#include "leadline/core/angle.h"

namespace leadline::app {
namespace {

using Clock = std::chrono::steady_clock;

struct CommandArguments {
  std::string url;
  std::string prefix{kDefaultPrefix};
  slam_command_t command{};  // without utime and id
  double heading_deg = 0.0, sigma = 0.0, heading_sigma_deg = 0.0;
};

constexpr std::chrono::seconds kPatience{2};
constexpr std::chrono::milliseconds kLongestWait{50};  // between two looks for a signal

std::vector<std::byte> encode_checked(const slam_command_t& command) {
  try {
    return encode(command);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
}

void tell_node(const CommandArguments& arguments) {
  slam_command_t command = arguments.command;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  command.utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  command.id = command.utime;  // no two commands have the same
  command.heading = from_degrees(arguments.heading_deg);
  command.x_sigma = command.y_sigma = arguments.sigma;
  command.heading_sigma = from_degrees(arguments.heading_sigma_deg);
  const std::vector<std::byte> data = encode_checked(command);
  const auto channel_of = [&](const MessageFormat& format) {
    return arguments.prefix + std::string(format.channel);
  };

  Bus bus(arguments.url);
  std::optional<slam_reply_t> reply;
  bus.subscribe(channel_of(message_format<slam_reply_t>()), [&](std::string_view, Bytes bytes) {
    auto received = receive<slam_reply_t>(bytes);
    if (auto* message = std::get_if<slam_reply_t>(&received); message && message->id == command.id)
      reply = std::move(*message);
  });
  if (!bus.open() || !bus.publish(channel_of(message_format<slam_command_t>()), data))
    throw std::runtime_error(bus.trouble());

  const Clock::time_point deadline = Clock::now() + kPatience;
  while (!reply && Clock::now() < deadline) {
    throw_if_interrupted();
    bus.handle(kLongestWait);
  }
  if (!reply)
    throw std::runtime_error(
        fmt::format("no node answers within {} s on {}, channels {}*: is one running there?",
                    kPatience.count(), arguments.url, arguments.prefix));
  if (reply->done == 0) throw std::runtime_error(reply->text);
  fmt::print("{}\n", reply->text);
}

using SharedArguments = std::shared_ptr<CommandArguments>;

CLI::App& add_kind(CLI::App& parent, const SharedArguments& arguments, const char* name, std::int8_t kind,
                   const char* help) {
  CLI::App& command = *parent.add_subcommand(name, help);
  add_url(command, arguments->url);
  command.add_option("--prefix", arguments->prefix, "Of all channels, as log.channel_prefix")
      ->type_name("TEXT")
      ->capture_default_str();
  command.callback([arguments, kind] {
    arguments->command.kind = kind;
    tell_node(*arguments);
  });
  return command;
}

void add_map_name(CLI::App& command, const SharedArguments& arguments) {
  command.add_option("name", arguments->command.name, "Of the map: letters, digits, - and _")
      ->required()
      ->type_name("NAME");
}

void add_pose(CLI::App& command, const SharedArguments& arguments) {
  const auto add_number = [&](const char* name, double& value, const char* help) {
    command.add_option(name, value, help)->type_name("VALUE")->required();
  };
  add_number("--x", arguments->command.x, "Position of the body's origin [m]");
  add_number("--y", arguments->command.y, "The same, to port of x [m]");
  add_number("--heading-deg", arguments->heading_deg, "Counter-clockwise from x [deg]");
  add_number("--sigma-m", arguments->sigma, "Standard deviation of x and of y [m]");
  add_number("--heading-sigma-deg", arguments->heading_sigma_deg, "Of the heading [deg]");
}

}  // namespace

void add_command(CLI::App& app) {
  const auto arguments = std::make_shared<CommandArguments>();
  CLI::App& command =
      *app.add_subcommand("command", "Tell a running node what to do, and wait for its answer");
  command.require_subcommand(1);
  command.footer(
      "\nExamples:\n"
      "  leadline command save-map harbour\n"
      "  leadline command set-pose --x 2 --y -1.5 --heading-deg 90 --sigma-m 0.2 --heading-sigma-deg 5");
  const auto add = [&](const char* name, std::int8_t kind, const char* help) -> CLI::App& {
    return add_kind(command, arguments, name, kind, help);
  };
  add("reset", slam_command_t::RESET, "Forget everything and begin at the configured pose");
  add_pose(add("set-pose", slam_command_t::SET_POSE, "Say where the vehicle is; the map stays"), arguments);
  add_map_name(add("save-map", slam_command_t::SAVE_MAP, "Write the map into the node's state folder"),
               arguments);
  add_map_name(add("load-map", slam_command_t::LOAD_MAP,
                   "Read a map; the vehicle is where it was then, unless set-pose or relocalize follows"),
               arguments);
  add("relocalize", slam_command_t::RELOCALIZE, "Look for the vehicle in the map: it may be anywhere there");
  add("pause", slam_command_t::PAUSE, "Take no measurement until resume");
  add("resume", slam_command_t::RESUME, "Take measurements again");
}

}  // namespace leadline::app
