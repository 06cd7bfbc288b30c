#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/node/node.h"
#include "apps/node/service.h"
#include "apps/node/status_words.h"
#include "apps/support/interrupt.h"
#include "apps/wire/bus.h"

namespace leadline::app {
namespace {

using namespace std::chrono_literals;

struct NodeArguments {
  ConfigOptions options;
  std::filesystem::path state;  // folder of checkpoints and maps; empty: there is none
};

/// [us], never set; goes on while the machine sleeps, for the vehicle does.
std::int64_t machine_time() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return 1'000'000 * std::int64_t{now.tv_sec} + now.tv_nsec / 1'000;
}

/// Opens the bus whenever the network is there, and tries for it once a second while it is not.
class Connection {
 public:
  explicit Connection(Bus& bus) : bus_(bus) {}

  void keep_up(std::int64_t now) {
    if (bus_.is_open() || now < next_try_) return;
    next_try_ = now + 1'000'000;
    if (bus_.open()) {
      spdlog::info("listening");
      told_ = false;
    } else if (!told_) {
      spdlog::warn("no network: {}; trying once a second", bus_.trouble());
      told_ = true;
    }
  }

 private:
  Bus& bus_;
  std::int64_t next_try_ = 0;
  bool told_ = false;
};

/// Tells those who watch the process how it is doing: systemd every change, the log only one of the status.
class StatusLine {
 public:
  void tell(const slam_health_t& health) {
    std::string text(status_sentence(health.status));
    if (!health.text.empty()) text += ": " + health.text;
    if (text == text_) return;
    service::status(text);
    if (health.status != status_) spdlog::log(level_of(health.status), text);
    text_ = std::move(text);
    status_ = health.status;
  }

 private:
  static spdlog::level::level_enum level_of(std::int8_t status) {
    return is_trouble(status) ? spdlog::level::warn : spdlog::level::info;
  }

  std::string text_;
  std::int8_t status_ = slam_health_t::WAITING;
};

void estimate_live(const NodeArguments& arguments) {
  const Config config = arguments.options.config();
  check_problem(config, {Problem::slam, Problem::localization},
                "a node is told no poses; map with leadline run");
  Bus bus(config.node.url);
  const auto send = [&](std::string_view channel, Bytes data) { bus.publish(channel, data); };
  Node node(config, arguments.state, send, machine_time());
  for (const std::string& channel : node.channels())
    bus.subscribe(channel,
                  [&](std::string_view name, Bytes data) { node.receive(name, data, machine_time()); });

  Connection connection(bus);
  StatusLine status;
  service::ready();
  while (!interrupted()) {
    connection.keep_up(machine_time());
    const auto idle = std::chrono::microseconds(node.wake_up() - machine_time());
    bus.handle(std::clamp(std::chrono::ceil<std::chrono::milliseconds>(idle), 0ms, 100ms));
    node.tick(machine_time());
    status.tell(node.health());
    service::alive();
  }
  service::stopping();
  node.checkpoint();
  spdlog::info("stopped after {} steps", node.slam().health().steps);
}

}  // namespace

void add_node(CLI::App& app) {
  const auto arguments = std::make_shared<NodeArguments>();
  ConfigOptions& options = arguments->options;
  CLI::App& command =
      *app.add_subcommand("node", "Estimate live: sensors in from the LCM network, estimates out");
  options.add_config(command);
  command
      .add_option("--state", arguments->state,
                  "Folder for saved maps and the checkpoint from which a restarted node goes on")
      ->type_name("DIR");
  options.add_filter(command);
  options.add_map(command);
  options.add_association(command);
  options.add_set(command);
  command.footer("\nExample:\n  leadline node configs/tank_0p1.yaml --state state");
  command.callback([arguments] { estimate_live(*arguments); });
}

}  // namespace leadline::app
