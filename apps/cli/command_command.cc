#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/support/interrupt.h"
#include "apps/support/usage_error.h"
#include "apps/wire/bus.h"
#include "apps/wire/messages.h"

namespace leadline::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience{2};
constexpr std::chrono::milliseconds kLongestWait{50};  // between two looks for a signal

std::vector<std::byte> encode_checked(const slam_command_t& command) {
  try {
    return encode(command);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
}

}  // namespace

void command_command(const CommandArguments& arguments) {
  slam_command_t command = arguments.command;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  command.utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  command.id = command.utime;  // no two commands have the same
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

}  // namespace leadline::app
