// The live programs as processes on a network of their own: node, simulated vehicle, logger, commands.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "apps/config/node_options.h"
#include "apps/maps/map_file.h"
#include "apps/wire/bus.h"
#include "apps/wire/event_log.h"
#include "apps/wire/messages.h"
#include "apps/wire/stream_counter.h"
#include "leadline/core/consistency.h"
#include "leadline/submap/snapshot.h"
#include "tests/apps/node/mission.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

using Clock = std::chrono::steady_clock;
using Words = std::vector<std::string>;

constexpr auto kPatience = 30s;  // on a busy machine
const std::string kLogger = "lcm-logger";

bool shell(const std::string& line) { return std::system((line + " 2>/dev/null").c_str()) == 0; }

bool add_route() { return shell("ip link set lo up && ip route add 239.255.76.67/32 dev lo"); }
bool remove_route() { return shell("ip route del 239.255.76.67/32 dev lo"); }

/// From now on this process and its children have a network of their own, and may mount what only they see.
/// @return why that is not so; empty if it is.
std::string leave_for_a_network_of_our_own() {
  const std::string user = std::to_string(geteuid()), group = std::to_string(getegid());
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET | CLONE_NEWNS) != 0)
    return fmt::format("no namespaces: {}", std::strerror(errno));
  std::ofstream("/proc/self/setgroups") << "deny";
  std::ofstream("/proc/self/uid_map") << "0 " << user << " 1";
  std::ofstream("/proc/self/gid_map") << "0 " << group << " 1";
  return add_route() && remove_route() ? "" : "no multicast route in a namespace";
}

/// A command in the background.
class Process {
 public:
  Process(Words command, fs::path output) : output_(std::move(output)) {
    std::vector<char*> words;
    for (std::string& word : command) words.push_back(word.data());
    words.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int file = ::open(output_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    execvp(words[0], words.data());
    _exit(127);
  }
  ~Process() {
    send(SIGKILL);
    wait();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void send(int signal) {
    if (is_running()) kill(pid_, signal);
  }

  bool is_running() {
    int status = 0;
    if (!code_ && waitpid(pid_, &status, WNOHANG) == pid_)
      code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    return !code_;
  }

  /// Exit code, or minus the signal that ended it.
  int wait() {
    for (const auto deadline = Clock::now() + kPatience; is_running() && Clock::now() < deadline;)
      std::this_thread::sleep_for(2ms);
    if (!code_) ADD_FAILURE() << "does not end: " << output();
    return code_.value_or(-1);
  }

  /// What it has said so far.
  std::string output() const { return read_bytes(output_); }

 private:
  fs::path output_;
  std::optional<int> code_;
  pid_t pid_ = -1;
};

/// What is to be heard on the network.
class Listener {
 public:
  Listener() {
    listen<vehicle_state_t>([this](const vehicle_state_t& state) { states.push_back(state); });
    listen<truth_t>([this](const truth_t& t) { truth[t.utime] = t; });
    listen<slam_health_t>([this](const slam_health_t& h) { health.push_back(h); });
  }

  /// Listens until @p condition is true. @return false if it never is.
  template <class Condition>
  bool hears(Condition condition) {
    for (const auto deadline = Clock::now() + kPatience; !condition();) {
      if (Clock::now() > deadline) return false;
      bus.open();
      bus.handle(20ms);
    }
    return true;
  }
  bool hears_states(std::size_t n) {
    return hears([this, wanted = states.size() + n] { return states.size() >= wanted; });
  }
  /// @p test of a health message that comes from now on.
  template <class Test>
  bool hears_health(Test test) {
    return hears([this, test, from = health.size()]() mutable {
      for (; from < health.size(); ++from)
        if (test(health[from])) return true;
      return false;
    });
  }

  Bus bus{NodeOptions().url};
  std::vector<vehicle_state_t> states;
  std::vector<slam_health_t> health;
  std::map<std::int64_t, truth_t> truth;  // by utime

 private:
  template <class T, class Handler>
  void listen(Handler handler) {
    bus.subscribe(channel<T>(), [handler](std::string_view name, Bytes data) {
      if (name != channel<T>()) return;  // a longer one
      const auto received = receive<T>(data);
      const auto* message = std::get_if<T>(&received);
      ASSERT_NE(message, nullptr) << name << ": " << std::get<Rejection>(received).text;
      handler(*message);
    });
  }
  template <class T>
  static std::string channel() {
    return std::string(kDefaultPrefix) + std::string(message_format<T>().channel);
  }
};

class LiveTest : public testing::Test {
 protected:
  void SetUp() override {
    static const std::string trouble = leave_for_a_network_of_our_own();
    if (!trouble.empty()) GTEST_SKIP() << trouble;
    ASSERT_TRUE(add_route());
  }
  void TearDown() override { remove_route(); }

  Words leadline(Words arguments) const {
    arguments.insert(arguments.begin(), LEADLINE_COMMAND);
    return arguments;
  }
  Words node(const std::string& config, Words options = {}) const {
    Words words{LEADLINE_COMMAND, "node", config_file(config), "--state", (scratch / "state").string()};
    words.insert(words.end(), options.begin(), options.end());
    return words;
  }
  Words sim_node(const std::string& config, const std::string& speed, Words options = {}) const {
    Words words{LEADLINE_COMMAND, "sim-node",        config_file(config), "--speed", speed,
                "--epoch",        "1700000000000000"};
    words.insert(words.end(), options.begin(), options.end());
    return words;
  }
  static std::string config_file(const std::string& name) {
    return LEADLINE_SOURCE_DIR "/configs/" + name + ".yaml";
  }
  fs::path output(const std::string& name) const { return scratch / (name + ".txt"); }

  bool listening(const Process& node) {
    return listener.hears([&] { return node.output().find("listening") != std::string::npos; });
  }

  /// `leadline command`. @return exit code and what it says.
  std::pair<int, std::string> command(Words words) const {
    words.insert(words.begin(), "command");
    Process process(leadline(words), output("command"));
    const int code = process.wait();
    return {code, process.output()};
  }

  /// The newest that a node would go on from.
  std::optional<Snapshot> checkpoint() const {
    for (const char* name : {"state/checkpoint.map", "state/checkpoint.previous.map"}) {
      try {
        return read_map(scratch / name);
      } catch (const std::runtime_error&) {
        continue;  // there is none, or it is just becoming the previous one
      }
    }
    return std::nullopt;
  }

  const ScratchFolder scratch;
  Listener listener;
};

// --- From end to end -------------------------------------------------------------------------------------

struct LoggedRun {
  std::map<std::string, std::int64_t> counts;  // messages by stream, of the vehicle
  std::vector<slam_health_t> health;
};

LoggedRun read_run(const fs::path& path) {
  LoggedRun run;
  const std::string health =
      std::string(kDefaultPrefix) + std::string(message_format<slam_health_t>().channel);
  EventLogReader event(path);
  while (event.next()) {
    if (event.channel() == health)
      run.health.push_back(std::get<slam_health_t>(receive<slam_health_t>(event.data())));
    const Receiver receiver = receiver_of(event.channel(), kDefaultPrefix);
    if (!receiver) continue;
    const auto message = std::get<Message>(receiver(event.data()));
    ++run.counts[std::visit([&](const auto& m) { return stream_of(event.channel(), m); }, message)];
  }
  return run;
}

std::map<std::string, std::int64_t> printed_counts(const std::string& table) {
  std::map<std::string, std::int64_t> counts;
  std::istringstream lines(table);
  std::string line, stream;
  std::int64_t count = 0;
  while (std::getline(lines, line))
    if (line.starts_with(kDefaultPrefix) && std::istringstream(line) >> stream >> count)
      counts[stream] = count;
  return counts;
}

TEST_F(LiveTest, NothingIsLostAndTheLogGivesTheSameStates) {
  if (!shell("command -v " + kLogger + " >/dev/null")) GTEST_SKIP() << "no " << kLogger;
  const fs::path log = scratch / "live.lcmlog";
  Process logger({kLogger, "--lcm-url=" + NodeOptions().url, log.string()}, output("logger"));
  ASSERT_TRUE(listener.hears([&] {
    if (listener.bus.is_open()) listener.bus.publish("PROBE", std::as_bytes(std::span("probe")));
    return fs::exists(log) && fs::file_size(log) > 0;
  }));
  Process node(this->node("tank_0p3"), output("node"));
  ASSERT_TRUE(listening(node));
  Process vehicle(sim_node("tank_0p3", "10", {"--duration", "60"}), output("vehicle"));
  ASSERT_TRUE(listener.hears([&] { return !vehicle.is_running(); }));
  ASSERT_EQ(vehicle.wait(), 0) << vehicle.output();
  ASSERT_TRUE(listener.hears([&] {
    return !listener.states.empty() && listener.states.back().utime == listener.truth.rbegin()->first;
  }));
  const std::int64_t end = listener.states.back().utime;
  ASSERT_TRUE(listener.hears_health([&](const slam_health_t& health) { return health.utime == end; }));
  node.send(SIGTERM);
  EXPECT_EQ(node.wait(), 0);
  logger.send(SIGINT);
  logger.wait();

  const LoggedRun run = read_run(log);
  EXPECT_EQ(run.counts, printed_counts(vehicle.output()));
  EXPECT_GE(run.counts.size(), 6U) << vehicle.output();
  ASSERT_FALSE(run.health.empty());
  const slam_health_t& health = run.health.back();
  EXPECT_EQ(health.streams, 5);
  EXPECT_THAT(health.lost, Each(0));
  EXPECT_EQ(health.late, 0);

  Process offline(leadline({"run", config_file("tank_0p3"), "--log", log.string()}), output("run"));
  EXPECT_EQ(offline.wait(), 0);
  const auto n = std::to_string(health.steps);
  EXPECT_EQ(run.counts.at("AUV_TRUTH"), health.steps);
  EXPECT_THAT(offline.output(), HasSubstr("published live: " + n + " states; " + n +
                                          " of them at times of this run, " + n + " equal to the last bit"));
}

// --- Watching --------------------------------------------------------------------------------------------

TEST_F(LiveTest, WatchOnceShowsWhatThereIs) {
  Process early(leadline({"watch", "--once"}), output("early"));
  EXPECT_EQ(early.wait(), 1);
  EXPECT_THAT(early.output(), HasSubstr("no node is heard within 3 s on udpm://"));

  Process node(this->node("tank_0p3", {"--set", "node.state_rate_hz=10"}), output("node"));
  ASSERT_TRUE(listening(node));
  Process vehicle(sim_node("tank_0p3", "4"), output("vehicle"));
  ASSERT_TRUE(listener.hears_health([](const slam_health_t& health) { return health.steps > 20; }));
  Process watch(leadline({"watch", "--once"}), output("watch"));
  EXPECT_EQ(watch.wait(), 0);
  EXPECT_THAT(watch.output(), testing::AllOf(HasSubstr("status   ok"), HasSubstr("pose     x "),
                                             HasSubstr("AUV_RANGE_SONAR/port"), Not(HasSubstr("\x1b"))));
  Process other(leadline({"watch", "--once", "--prefix", "ROV_"}), output("other"));
  EXPECT_EQ(other.wait(), 1);
  EXPECT_THAT(other.output(), HasSubstr("channels ROV_*"));
}

TEST_F(LiveTest, WatchIntoAFileIsALineASecond) {
  Process node(this->node("tank_0p3"), output("node"));
  Process watch(leadline({"watch"}), output("watch"));
  ASSERT_TRUE(listener.hears([&] { return watch.output().find("waiting\n") != std::string::npos; }))
      << watch.output();
  watch.send(SIGINT);
  EXPECT_EQ(watch.wait(), 0);
  EXPECT_THAT(watch.output(), Not(HasSubstr("\x1b")));
}

/// A terminal of so many columns and rows, in which a command runs.
class Terminal {
 public:
  Terminal(Words command, unsigned short columns, unsigned short rows) {
    const winsize size{rows, columns, 0, 0};
    std::vector<char*> words;
    for (std::string& word : command) words.push_back(word.data());
    words.push_back(nullptr);
    pid_ = forkpty(&screen_, nullptr, nullptr, &size);
    if (pid_ != 0) return;
    execvp(words[0], words.data());
    _exit(127);
  }
  ~Terminal() {
    if (!code_) kill(pid_, SIGKILL);
    wait();
    ::close(screen_);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// Reads until that is to be seen. @return false if it never is.
  bool shows(const std::string& text) {
    for (const auto deadline = Clock::now() + kPatience; shown.find(text) == std::string::npos;)
      if (Clock::now() > deadline || !read()) return false;
    return true;
  }
  void resize(unsigned short columns, unsigned short rows) const {
    const winsize size{rows, columns, 0, 0};
    ioctl(screen_, TIOCSWINSZ, &size);
  }
  void type(const std::string& keys) const {
    EXPECT_EQ(::write(screen_, keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  }
  int wait() {
    while (read()) {
    }
    int status = 0;
    if (!code_ && waitpid(pid_, &status, 0) == pid_)
      code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    return code_.value_or(-1);
  }
  bool echoes() const {
    termios settings{};
    tcgetattr(screen_, &settings);
    return (settings.c_lflag & static_cast<tcflag_t>(ECHO)) != 0;
  }

  std::string shown;

 private:
  bool read() {
    char buffer[4096];
    const ssize_t n = ::read(screen_, buffer, sizeof buffer);
    if (n > 0) shown.append(buffer, static_cast<std::size_t>(n));
    return n > 0;  // EIO when the last one has closed it
  }

  int screen_ = -1;
  pid_t pid_ = -1;
  std::optional<int> code_;
};

TEST_F(LiveTest, WatchFillsATerminalAndLeavesItAsItWas) {
  Process node(this->node("tank_0p3"), output("node"));
  for (const std::string end : {"q", "\x03"}) {  // Ctrl-C
    Terminal terminal(leadline({"watch"}), 60, 12);
    ASSERT_TRUE(terminal.shows("waiting"));
    EXPECT_FALSE(terminal.echoes());
    EXPECT_THAT(terminal.shown, HasSubstr("\x1b[?1049h\x1b[?25l"));
    terminal.shown.clear();
    terminal.resize(14, 4);
    ASSERT_TRUE(terminal.shows("leadline watch\x1b[0m\x1b[K\r\n"));
    terminal.type(end);
    EXPECT_EQ(terminal.wait(), 0);
    EXPECT_THAT(terminal.shown, testing::EndsWith("\x1b[?25h\x1b[?1049l"));
  }
}

// --- Faults ----------------------------------------------------------------------------------------------

// A restart costs seconds of the mission, more on a slow machine.
TEST_F(LiveTest, KilledTwentyTimesItLosesNoMap) {
  constexpr std::int64_t kBetween = 4'000'000;  // [us] of the mission
  Process vehicle(sim_node("harbour_loops", "8"), output("vehicle"));
  const Words start = node("harbour_loops", {"--set", "node.checkpoint_period_s=0.2"});
  std::size_t submaps = 0;
  std::int64_t stored = 0;  // utime
  for (int i = 0; i < 20; ++i) {
    Process node(start, output("node"));
    ASSERT_TRUE(listener.hears([&] {
      const auto newest = checkpoint();
      return newest && newest->utime > stored + (i > 0 ? kBetween : 0);
    })) << node.output();
    std::this_thread::sleep_for(i * 10ms);  // at every moment between two checkpoints, and in them
    node.send(SIGKILL);
    EXPECT_EQ(node.wait(), -SIGKILL);
    EXPECT_THAT(node.output(), Not(HasSubstr("put aside")));
    EXPECT_EQ(node.output().find("going on after") != std::string::npos, i > 0) << node.output();
    const auto newest = checkpoint();
    ASSERT_TRUE(newest);
    EXPECT_GE(newest->submaps.size(), submaps);
    submaps = newest->submaps.size();
    stored = newest->utime;
  }
  EXPECT_GT(submaps, 1U);

  Process node(start, output("node"));
  ASSERT_TRUE(listener.hears_health([&](const slam_health_t& health) {
    return health.steps > 0 && health.submaps >= static_cast<int>(submaps);
  })) << node.output();
  const vehicle_state_t state = listener.states.back();
  EXPECT_FALSE(state.dead_reckoning);
  ASSERT_TRUE(listener.hears([&] { return listener.truth.contains(state.utime); }));
  const truth_t& truth = listener.truth.at(state.utime);
  EXPECT_LT(nees_of(state, {truth.utime, truth.x, truth.y, truth.heading, truth.speed}),
            consistency_band(1, 3, 0.9998).high);
}

TEST_F(LiveTest, WaitsForTheNetworkAndSurvivesItsLoss) {
  ASSERT_TRUE(remove_route());
  Process node(this->node("tank_long"), output("node")),
      vehicle(sim_node("tank_long", "2"), output("vehicle"));
  ASSERT_TRUE(listener.hears([&] {
    return node.output().find("no network") != std::string::npos &&
           vehicle.output().find("waiting for the network") != std::string::npos;
  }));
  ASSERT_TRUE(add_route());
  ASSERT_TRUE(listener.hears_states(20));

  ASSERT_TRUE(shell("ip link set lo down"));
  std::this_thread::sleep_for(1s);
  const vehicle_state_t before = listener.states.back();
  ASSERT_TRUE(add_route());
  ASSERT_TRUE(listener.hears_states(20));
  EXPECT_GT(listener.states.back().utime, before.utime);
  EXPECT_GT(listener.states.back().seq, before.seq) << "another process";
  EXPECT_TRUE(node.is_running());
  EXPECT_TRUE(vehicle.is_running());
  EXPECT_THAT(node.output(), HasSubstr("no network"));
}

/// A disk of a megabyte.
class SmallDisk {
 public:
  explicit SmallDisk(fs::path path) : path_(std::move(path)) {
    fs::create_directory(path_);
    mounted_ = mount("none", path_.c_str(), "tmpfs", 0, "size=1m") == 0;
  }
  ~SmallDisk() {
    if (mounted_) umount2(path_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  bool is_mounted() const { return mounted_; }

  void fill() const {
    std::ofstream file(path_ / "filler", std::ios::app);
    while (file.write(std::string(4096, 'x').data(), 4096).flush()) continue;
  }
  void make_room() const { fs::remove(path_ / "filler"); }

 private:
  fs::path path_;
  bool mounted_ = false;
};

TEST_F(LiveTest, GoesOnWhenTheDiskIsFull) {
  const SmallDisk disk(scratch / "state");
  if (!disk.is_mounted()) GTEST_SKIP() << "cannot mount a small disk";
  Process vehicle(sim_node("tank_long", "5"), output("vehicle"));
  const Words start = node("tank_long", {"--set", "node.checkpoint_period_s=0.2"});
  {
    Process node(start, output("node"));
    ASSERT_TRUE(listener.hears([&] { return checkpoint().has_value(); }));
    // Until nothing is given back any more that a checkpoint under way had taken.
    ASSERT_TRUE(listener.hears_health([&](const slam_health_t& health) {
      disk.fill();
      return health.text.find(".map: cannot write: No space left on device") != std::string::npos;
    }));
    EXPECT_TRUE(listener.hears_states(20));
    EXPECT_TRUE(node.is_running());
    node.send(SIGKILL);
    node.wait();
  }
  EXPECT_TRUE(checkpoint());
  disk.make_room();
  Process node(start, output("node"));
  EXPECT_TRUE(listener.hears([&] { return node.output().find("going on after") != std::string::npos; }));
  EXPECT_THAT(node.output(), Not(HasSubstr("put aside")));
}

// --- Commands and signals --------------------------------------------------------------------------------

TEST_F(LiveTest, ObeysCommands) {
  using ::testing::Pair;
  const auto done = Pair(0, "done\n");
  EXPECT_THAT(command({"pause"}), Pair(1, HasSubstr("no node answers within 2 s")));

  Process node(this->node("tank_long"), output("node"));
  ASSERT_TRUE(listening(node));
  Process vehicle(sim_node("tank_long", "5"), output("vehicle"));
  ASSERT_TRUE(listener.hears_states(20));

  EXPECT_THAT(command({"pause"}), done);
  ASSERT_TRUE(listener.hears_health(
      [](const slam_health_t& health) { return health.status == slam_health_t::PAUSED; }));
  const vehicle_state_t before = std::exchange(listener.states, {}).back();
  ASSERT_TRUE(
      listener.hears([&, wanted = listener.truth.size() + 20] { return listener.truth.size() >= wanted; }));
  EXPECT_TRUE(listener.states.empty());

  const double x = before.x + 10.0;
  EXPECT_THAT(command({"set-pose", "--x", std::to_string(x), "--y", "0", "--heading-deg", "0", "--sigma-m",
                       "3", "--heading-sigma-deg", "20"}),
              done);
  EXPECT_THAT(command({"resume"}), done);
  ASSERT_TRUE(listener.hears_states(1));
  EXPECT_NEAR(listener.states.front().x, x, 4.0);
  EXPECT_GT(listener.states.front().cov[0], 1.0);

  EXPECT_THAT(command({"save-map", "tank"}), done);
  EXPECT_TRUE(fs::exists(scratch / "state/tank.map"));
  EXPECT_THAT(command({"save-map", "../tank"}), Pair(1, HasSubstr("the name of a map must be")));
  EXPECT_THAT(command({"load-map", "harbour"}), Pair(1, HasSubstr("harbour.map: cannot read: No such file")));

  EXPECT_THAT(command({"reset"}), done);
  ASSERT_TRUE(listener.hears([&] { return listener.states.back().cov[0] < 0.1; }));
  EXPECT_NEAR(listener.states.back().x, 0.0, 2.0);
  EXPECT_THAT(command({"load-map", "tank"}), done);
  EXPECT_TRUE(listener.hears([&] { return listener.states.back().x > 0.5 * x; }));
}

TEST_F(LiveTest, StopsInOrderAndKeepsWhatItKnows) {
  Process node(this->node("tank_long", {"--set", "node.checkpoint_period_s=1000"}), output("node"));
  ASSERT_TRUE(listening(node));
  Process vehicle(sim_node("tank_long", "10"), output("vehicle"));
  ASSERT_TRUE(listener.hears_states(20));
  EXPECT_FALSE(checkpoint());
  node.send(SIGTERM);
  EXPECT_EQ(node.wait(), 0);
  ASSERT_TRUE(checkpoint());
  EXPECT_GE(checkpoint()->utime, listener.states.back().utime);
}

}  // namespace
}  // namespace leadline::app
