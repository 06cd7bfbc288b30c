// Bytes that no honest sender sends, while the mission goes on.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>
#include <new>
#include <numeric>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "apps/wire/bus.h"
#include "tests/apps/node/mission.h"
#include "tests/apps/wire/sample_messages.h"
#include "tests/support/sanitizer.h"
#include "tests/support/scratch_folder.h"

namespace {
thread_local bool metering = false;
thread_local std::size_t metered = 0;  // bytes

void meter(std::size_t size) {
  if (metering) metered += size;
}
}  // namespace

#if LEADLINE_SANITIZER
// GCC ships no header for it.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*)(const volatile void*, std::size_t),
                                                         void (*)(const volatile void*));

const int kHooks = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t size) { meter(size); }, [](const volatile void*) {});
#else
extern "C" void* __libc_malloc(std::size_t size);

extern "C" void* malloc(std::size_t size) {
  meter(size);
  return __libc_malloc(size);
}
#endif

namespace leadline::app {
namespace {

constexpr int kPerSoundMessage = 50;
constexpr std::size_t kMostBytes = 1 << 20;

std::size_t bytes_allocated_by(auto&& action) {
  metered = 0;
  metering = true;
  action();
  metering = false;
  return metered;
}

/// Messages that a test spoils; LEADLINE_HOSTILE_MESSAGES says how many.
int hostile_messages() {
  const char* number = std::getenv("LEADLINE_HOSTILE_MESSAGES");
  return number ? std::stoi(number) : 50'000;
}

/// Spoils sound messages of all types in all the ways of broken memory and of ill will.
class Vandal {
 public:
  Vandal(const Mission& mission, unsigned seed) : sound_(mission.events), random_(seed) {
    // The types that a mission does not have are as frequent as those that it has.
    const std::size_t copies = sound_.size() / std::variant_size_v<EveryMessage>;
    for_each_message_type([&]<class T>(std::type_identity<T>) {
      const std::string channel = mission.config.channel_prefix + std::string(message_format<T>().channel);
      sound_.insert(sound_.end(), copies, Event{0, channel, encode(sample_message<T>())});
    });
  }

  /// Every other time @p current, which is the one that is new enough to be used.
  const Event& spoil(const Event& current) {
    event_ = below(2) == 0 ? current : any();
    for (std::size_t times = 1 + below(3); times > 0; --times) spoil_once();
    return event_;
  }

 private:
  std::size_t below(std::size_t limit) { return random_() % limit; }
  std::byte any_byte() { return static_cast<std::byte>(random_() & 0xff); }
  const Event& any() { return sound_[below(sound_.size())]; }

  void spoil_once() {
    std::vector<std::byte>& data = event_.data;
    if (data.empty()) return;
    std::byte& victim = data[below(data.size())];
    switch (below(9)) {
      case 0:
        victim ^= std::byte{1} << below(8);
        break;
      case 1:
        victim = std::array{std::byte{0x00}, std::byte{0x7f}, std::byte{0x80}, std::byte{0xff}}[below(4)];
        break;
      case 2:
        data.resize(below(data.size()));
        break;
      case 3:
        for (std::size_t more = below(1000) == 0 ? 70'000 : 1 + below(64); more > 0; --more)
          data.push_back(any_byte());
        break;
      case 4: {
        const std::vector<std::byte>& tail = any().data;
        data.resize(below(data.size()));
        data.insert(data.end(), tail.begin() + static_cast<std::ptrdiff_t>(below(tail.size())), tail.end());
        break;
      }
      case 5:
        put(kCounts[below(kCounts.size())]);
        break;
      case 6:
      case 7:
        put(std::bit_cast<std::int64_t>(kReals[below(kReals.size())]));
        break;
      default:
        event_.channel = below(20) == 0 ? "AUV_" : any().channel;
    }
  }

  /// Big-endian, wherever it fits.
  template <class Integer>
  void put(Integer value) {
    if (event_.data.size() < sizeof value) return;
    auto byte =
        event_.data.begin() + static_cast<std::ptrdiff_t>(below(event_.data.size() - sizeof value + 1));
    for (int shift = 8 * (static_cast<int>(sizeof value) - 1); shift >= 0; shift -= 8)
      *byte++ = static_cast<std::byte>(value >> shift & 0xff);
  }

  using Int = std::numeric_limits<std::int32_t>;
  using Real = std::numeric_limits<double>;
  static constexpr std::array<std::int32_t, 10> kCounts = {0,     1,       -1,      64,         1025,
                                                           65536, 1 << 28, 1 << 29, Int::min(), Int::max()};
  static constexpr std::array<double, 9> kReals = {Real::quiet_NaN(),
                                                   Real::infinity(),
                                                   -Real::infinity(),
                                                   Real::max(),
                                                   Real::lowest(),
                                                   Real::denorm_min(),
                                                   1e300,
                                                   -0.0,
                                                   1e-300};

  std::vector<Event> sound_;
  std::mt19937 random_;
  Event event_;
};

std::string command_channel(const Config& config) {
  return config.channel_prefix + std::string(message_format<slam_command_t>().channel);
}

std::string health_channel(const Config& config) {
  return config.channel_prefix + std::string(message_format<slam_health_t>().channel);
}

enum class Fate { ignored, refused, used };

/// What the rules say of a message to a node.
Fate fate(const Event& event, const Config& config) {
  if (event.channel == command_channel(config))
    return check(message_format<slam_command_t>(), event.data) ? Fate::refused : Fate::used;
  if (event.channel == health_channel(config))  // of another node
    return check(message_format<slam_health_t>(), event.data) ? Fate::refused : Fate::ignored;
  const Receiver receiver = receiver_of(event.channel, config.channel_prefix);
  if (!receiver) return Fate::ignored;
  const std::variant<Message, Rejection> received = receiver(event.data);
  const auto* message = std::get_if<Message>(&received);
  return message && !std::holds_alternative<Rejection>(content(*message, config.slam.sensors))
             ? Fate::used
             : Fate::refused;
}

std::int64_t refused_by(const Desk& desk) {
  const std::vector<std::int64_t>& refused = desk.sent.health.back().refused;
  return std::reduce(refused.begin(), refused.end());
}

TEST(HostileNode, TheMeterCounts) {
  EXPECT_EQ(bytes_allocated_by([] { ::operator delete(::operator new(kMostBytes)); }), kMostBytes);
}

// Of messages that are refused there is no trace but a number.
TEST(HostileNode, EstimatesAsIfTheyHadNotCome) {
  int left = hostile_messages();
  std::size_t most = 0;
  for (int seed = 1; left > 0; ++seed) {
    const Mission mission("tank_0p1", seed);
    Desk undisturbed(mission.config), desk(mission.config);
    undisturbed.feed_all(mission.events);
    Vandal vandal(mission, static_cast<unsigned>(seed));
    std::int64_t refused = 0;
    for (const Event& event : mission.events) {
      desk.feed(event);
      for (int i = 0; i < kPerSoundMessage; ++i) {
        const Event& spoilt = vandal.spoil(event);
        const Fate expected = fate(spoilt, mission.config);
        if (expected == Fate::used) continue;
        refused += expected == Fate::refused;
        --left;
        most = std::max(most, bytes_allocated_by([&] { desk.receive(spoilt.channel, spoilt.data); }));
      }
    }
    desk.wait_until(desk.now() + 1'000'000);
    ASSERT_EQ(refused_by(desk), refused);

    const std::vector<vehicle_state_t>& states = desk.sent.states;
    ASSERT_EQ(states.size(), undisturbed.sent.states.size());
    for (std::size_t i = 0; i < states.size(); ++i)
      ASSERT_EQ(encode(states[i]), encode(undisturbed.sent.states[i]))
          << "mission " << seed << ", state " << i;
    const vehicle_state_t& last = states.back();
    const auto truth = mission.truth_at(last.utime);
    ASSERT_TRUE(truth);
    EXPECT_LT(std::hypot(last.x - truth->x, last.y - truth->y), 1.0);
    EXPECT_LT(last.cov[0] + last.cov[3], 1.0);
  }
  EXPECT_LE(most, kMostBytes);
  fmt::print("at most {} bytes were allocated for a message\n", most);
}

// Spoilt messages that are sound by all rules are believed, and commands among them obeyed; what comes of it
// is an estimate still.
TEST(HostileNode, SurvivesTheSoundOnesAmongThem) {
  const Mission mission("tank_0p1", 1);
  const ScratchFolder state;
  Desk desk(mission.config, state.path());
  Vandal vandal(mission, 1);
  std::size_t most = 0;
  bool commanded = false;
  for (int left = hostile_messages() / 10; left > 0;) {
    for (const Event& event : mission.events) {
      desk.feed({desk.now() + 200'000, event.channel, event.data});
      for (int i = 0; i < kPerSoundMessage; ++i, --left) {
        const Event& spoilt = vandal.spoil(event);
        const std::size_t bytes = bytes_allocated_by([&] { desk.receive(spoilt.channel, spoilt.data); });
        // A command may make a new estimator: at once or, if it ends a pause, at the next measurement.
        if (spoilt.channel == command_channel(mission.config))
          commanded = true;
        else if (bytes <= kMostBytes || !std::exchange(commanded, false))
          most = std::max(most, bytes);
      }
    }
    const slam_health_t& health = desk.sent.health.back();
    ASSERT_EQ(std::llround(health.uptime), desk.now() / 1'000'000);
    ASSERT_EQ(health.text.find("not sent"), std::string::npos) << health.text;
    ASSERT_FALSE(std::exchange(desk.sent, {}).states.empty());
  }
  EXPECT_LE(most, kMostBytes);
  fmt::print("at most {} bytes were allocated for a measurement\n", most);
}

TEST(HostileNode, SurvivesMessagesTooSmallAndTooLargeOnTheBus) {
  const Mission mission("tank_0p1", 1);
  Desk desk(mission.config);
  Bus bus(std::make_unique<lcm::LCM>("memq://"));
  for (const std::string& channel : desk.node().channels())
    bus.subscribe(channel, [&](std::string_view name, Bytes data) { desk.receive(std::string(name), data); });
  const std::vector<std::byte> payload(70'000, std::byte{0xff});
  std::int64_t sent = 0;
  for (const std::size_t size : {0U, 1U, 2U, 3U, 70'000U}) {
    for (const std::string& channel : desk.node().channels()) {
      ASSERT_TRUE(bus.publish(channel, std::span(payload).first(size)));
      ++sent;
    }
  }
  while (bus.handle(std::chrono::milliseconds(0)) > 0) {
  }
  desk.feed_all(mission.events);
  EXPECT_EQ(refused_by(desk), sent);
  EXPECT_EQ(desk.sent.states.size(), mission.recording.instants.size());
}

}  // namespace
}  // namespace leadline::app
