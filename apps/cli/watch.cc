#include <fmt/format.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/node/watch.h"
#include "apps/support/interrupt.h"
#include "apps/wire/bus.h"
#include "apps/wire/messages.h"

namespace leadline::app {
namespace {

using namespace std::chrono_literals;

struct WatchArguments {
  std::string url;
  std::string prefix{kDefaultPrefix};
  bool once = false;
};

constexpr std::int64_t kFirstHealth = 3'000'000;  // [us], for the first health: three of its periods
constexpr std::int64_t kRetry = 1'000'000;        // [us], until the network is tried again
constexpr auto kRedraw = 250ms;
constexpr auto kRateTime = 1500ms;  // to tell the rate of states

/// [us], never set.
std::int64_t steady_time() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

/// A node on the bus.
class WatchedNode {
 public:
  explicit WatchedNode(const WatchArguments& arguments)
      : bus_(arguments.url), watch_(fmt::format("{}*   {}", arguments.prefix, arguments.url), steady_time()) {
    listen<vehicle_state_t>(arguments.prefix);
    listen<slam_health_t>(arguments.prefix);
  }

  /// Hears what is said within a time, or until a signal comes.
  void listen_for(std::chrono::milliseconds time) {
    const std::int64_t end = steady_time() + std::chrono::microseconds(time).count();
    for (std::int64_t now = steady_time(); now < end && !interrupted(); now = steady_time()) {
      if (!bus_.is_open() && now >= next_try_) {
        next_try_ = now + kRetry;
        bus_.open();
      }
      watch_.set_network_trouble(bus_.is_open() ? std::string() : bus_.trouble());
      bus_.handle(std::chrono::ceil<std::chrono::milliseconds>(std::chrono::microseconds(end - now)));
    }
  }

  const Watch& watch() const { return watch_; }

 private:
  template <class T>
  void listen(const std::string& prefix) {
    const std::string wanted = prefix + std::string(message_format<T>().channel);
    bus_.subscribe(wanted, [this, wanted](std::string_view channel, Bytes data) {
      if (channel != wanted) return;  // a longer one
      const auto received = receive<T>(data);
      if (const auto* message = std::get_if<T>(&received)) watch_.hear(*message, steady_time());
    });
  }

  Bus bus_;
  Watch watch_;
  std::int64_t next_try_ = 0;
};

/// The whole terminal, with no cursor and no echo of what is typed; as it was in the end.
class Screen {
 public:
  Screen() : reads_keys_(::isatty(STDIN_FILENO) != 0 && ::tcgetattr(STDIN_FILENO, &before_) == 0) {
    if (reads_keys_) {
      termios quiet = before_;
      quiet.c_lflag &= ~static_cast<tcflag_t>(ECHO | ICANON);
      quiet.c_cc[VSUSP] = _POSIX_VDISABLE;  // stopped, it would leave the terminal as it is
      ::tcsetattr(STDIN_FILENO, TCSANOW, &quiet);
    }
    put("\x1b[?1049h\x1b[?25l");
  }
  ~Screen() {
    put("\x1b[?25h\x1b[?1049l");
    if (reads_keys_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  }
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// As large as it is now: windows are resized.
  static Watch::Room room() {
    winsize size{};
    if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return {};
    return {size.ws_col, size.ws_row};
  }

  /// What was there is written over line by line, which does not flicker. The last line feed is left out: it
  /// would scroll.
  static void draw(std::string_view text) {
    std::string out = "\x1b[H";
    text.remove_suffix(text.ends_with('\n') ? 1 : 0);
    for (const char c : text) out += c == '\n' ? std::string("\x1b[K\n") : std::string(1, c);
    put(out + "\x1b[K\x1b[J");
  }

  bool quits() const {
    pollfd keys{STDIN_FILENO, POLLIN, 0};
    char key = 0;
    while (reads_keys_ && ::poll(&keys, 1, 0) == 1 && ::read(STDIN_FILENO, &key, 1) == 1)
      if (key == 'q' || key == 'Q') return true;
    return false;
  }

 private:
  static void put(std::string_view text) {
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fflush(stdout);
  }

  termios before_{};
  bool reads_keys_;
};

void show_once(WatchedNode& node, const WatchArguments& arguments) {
  const std::int64_t end = steady_time() + kFirstHealth;
  const auto knows_all = [&] {
    const auto& health = node.watch().health();
    return health && (node.watch().has_state() || health->status == slam_health_t::WAITING ||
                      health->status == slam_health_t::PAUSED);
  };
  node.listen_for(kRateTime);
  while (!knows_all() && steady_time() < end) {
    throw_if_interrupted();
    node.listen_for(50ms);
  }
  if (!node.watch().health())
    throw std::runtime_error(
        fmt::format("no node is heard within {} s on {}, channels {}*: is one running there?",
                    kFirstHealth / 1'000'000, arguments.url, arguments.prefix));
  fmt::print("{}", node.watch().screen({200, 1000}, false, steady_time()));
}

void show_lines(WatchedNode& node) {
  while (!interrupted()) {
    node.listen_for(1000ms);
    if (interrupted()) return;
    fmt::print("{}\n", node.watch().line(steady_time()));
    if (std::fflush(stdout) != 0) throw std::runtime_error("standard output cannot be written");
  }
}

void show_screen(WatchedNode& node) {
  const bool colours = std::getenv("NO_COLOR") == nullptr;
  const Screen screen;
  while (!interrupted() && !screen.quits()) {
    Screen::draw(node.watch().screen(Screen::room(), colours, steady_time()));
    node.listen_for(kRedraw);
  }
}

void watch_node(const WatchArguments& arguments) {
  WatchedNode node(arguments);
  if (arguments.once)
    show_once(node, arguments);
  else if (::isatty(STDOUT_FILENO) != 0)
    show_screen(node);
  else
    show_lines(node);
}

}  // namespace

void add_watch(CLI::App& app) {
  const auto arguments = std::make_shared<WatchArguments>();
  CLI::App& command = *app.add_subcommand("watch", "Watch a node in a terminal: status, pose, channels");
  add_url(command, arguments->url);
  command.add_option("--prefix", arguments->prefix, "Of all channels, as log.channel_prefix")
      ->type_name("TEXT")
      ->capture_default_str();
  command.add_flag("--once", arguments->once, "Print what there is and end; exit code 1 if no node is heard");
  command.footer(
      "\nOn a terminal a screen that is drawn anew four times a second, which q or Ctrl-C ends; NO_COLOR=1 "
      "leaves\n"
      "colours out. Into a file or a pipe a line a second. Nothing is sent: any number may watch.\n"
      "  status    of the node, and a line for each thing that is wrong\n"
      "  pose      in the world, with standard deviations\n"
      "  NIS       of a channel in the last second, 1 expected, and of how many readings or sightings\n"
      "  age       since its last message; silent: for longer than node.timeout_s\n"
      "\nExamples:\n"
      "  leadline watch\n"
      "  leadline watch --once\n"
      "  ssh vehicle leadline watch | tee dive.txt\n"
      "  ssh -t vehicle leadline watch --prefix ROV_");
  command.callback([arguments] { watch_node(*arguments); });
}

}  // namespace leadline::app
