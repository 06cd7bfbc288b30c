#include "apps/wire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <string>

#include "apps/messages.h"

namespace leadline::app {
namespace {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

template <class T>
T sample();

template <>
velocity_t sample() {
  return {1'000'000, 3, -0.25, 0.125};
}
template <>
ackermann_t sample() {
  return {1'000'000, 3, 2.5, -0.3};
}
template <>
odometry_t sample() {
  return {-5, 0, 0.5, -0.01, 1.0 / 3.0};
}
template <>
heading_t sample() {
  return {1'700'000'000'000'000, 3, -3.1, 0.02};
}
template <>
speed_t sample() {
  return {1'000'000, 3, 0.1, 0.0};
}
template <>
range_sonar_t sample() {
  return {1'000'000, 3, "port", 2, {0.5, 100.0}, {-1, 7}};
}
template <>
range_bearing_t sample() {
  return {1'000'000, 3, "laser", 3, {0.0, 1.0, 2.0}, {-1.5, 0.0, 1.5}, {0, -1, 2147483647}};
}
template <>
truth_t sample() {
  return {1'000'000, 3, 1.0, 2.0, 1, 0.5, 0, 0.0};
}
template <>
truth_map_t sample() {
  return {1'000'000, 3, 2, {1, 2}, {0, 1}, {1.0, 0.0}, {2.0, 0.0}, {0.0, 4.0}, {0.0, 1.57}};
}

// Puts bytes together by hand, as a hostile sender would.
class Payload {
 public:
  explicit Payload(std::int64_t fingerprint) { put(fingerprint); }

  template <class Value>
  Payload& put(Value value) {
    if constexpr (std::is_same_v<Value, double>) {
      return put(std::bit_cast<std::int64_t>(value));
    } else {
      for (int shift = 8 * (static_cast<int>(sizeof value) - 1); shift >= 0; shift -= 8) {
        bytes_.push_back(static_cast<std::byte>(value >> shift & 0xff));
      }
      return *this;
    }
  }
  Payload& text(std::string_view text) {
    for (const char c : text) bytes_.push_back(static_cast<std::byte>(c));
    return *this;
  }
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

template <class T>
RejectReason reason_of(Bytes bytes) {
  auto received = receive<T>(bytes);
  if (auto* rejection = std::get_if<Rejection>(&received)) {
    EXPECT_THAT(rejection->text, HasSubstr(T::getTypeName()));
    return rejection->reason;
  }
  ADD_FAILURE() << "the message was accepted";
  return {};
}

template <class T>
class EveryType : public ::testing::Test {};
using Types = ::testing::Types<velocity_t, ackermann_t, odometry_t, heading_t, speed_t, range_sonar_t,
                               range_bearing_t, truth_t, truth_map_t>;
TYPED_TEST_SUITE(EveryType, Types);

TYPED_TEST(EveryType, ComesBackAsItWasSent) {
  const auto bytes = encode(sample<TypeParam>());
  const auto received = receive<TypeParam>(bytes);
  ASSERT_TRUE(std::holds_alternative<TypeParam>(received)) << std::get<Rejection>(received).text;
  EXPECT_EQ(encode(std::get<TypeParam>(received)), bytes);
}

TYPED_TEST(EveryType, IsKnownByItsChannel) {
  const std::string channel = "SUB2_" + std::string(message_format<TypeParam>().channel);
  const Receiver receiver = receiver_of(channel, "SUB2_");
  ASSERT_NE(receiver, nullptr);
  const auto received = receiver(encode(sample<TypeParam>()));
  ASSERT_TRUE(std::holds_alternative<Message>(received));
  EXPECT_TRUE(std::holds_alternative<TypeParam>(std::get<Message>(received)));
  EXPECT_EQ(receiver_of(channel, "AUV_"), nullptr);
  EXPECT_EQ(receiver_of(channel + "2", "SUB2_"), nullptr);
}

TYPED_TEST(EveryType, IsRefusedWhenCutAnywhere) {
  const auto bytes = encode(sample<TypeParam>());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_EQ(reason_of<TypeParam>(Bytes(bytes).first(size)), RejectReason::too_short) << size;
  }
}

TYPED_TEST(EveryType, IsRefusedWithTrailingBytes) {
  auto bytes = encode(sample<TypeParam>());
  bytes.push_back(std::byte{0});
  EXPECT_EQ(reason_of<TypeParam>(bytes), RejectReason::trailing_bytes);
  bytes.resize(kMaxMessageSize + 1);
  EXPECT_EQ(reason_of<TypeParam>(bytes), RejectReason::too_large);
}

TYPED_TEST(EveryType, IsRefusedWithAnotherFingerprint) {
  auto bytes = encode(sample<TypeParam>());
  bytes[7] ^= std::byte{1};
  EXPECT_EQ(reason_of<TypeParam>(bytes), RejectReason::wrong_type);
}

TYPED_TEST(EveryType, IsRefusedWhenTimeOrCounterAreOut) {
  auto message = sample<TypeParam>();
  const auto refused = [&] {
    try {
      encode(message);
    } catch (const std::invalid_argument&) {
      return true;
    }
    return false;
  };
  message.utime = std::numeric_limits<std::int64_t>::min();
  EXPECT_TRUE(refused());
  message = sample<TypeParam>();
  message.seq = -1;
  EXPECT_TRUE(refused());
}

// Whatever the bytes: no crash, and what is accepted is exactly what a sound sender would have sent.
TYPED_TEST(EveryType, SurvivesMutation) {
  const auto sound = encode(sample<TypeParam>());
  std::mt19937 random(1);
  int accepted = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    auto bytes = sound;
    for (auto changes = random() % 4 + 1; changes > 0; --changes) {
      // The fingerprint is mostly spared, else hardly anything gets further.
      const std::size_t from = random() % 20 == 0 ? 0 : 8;
      bytes[from + random() % (bytes.size() - from)] =
          static_cast<std::byte>(random() % 3 == 0 ? 0xff : random());
    }
    if (random() % 8 == 0) bytes.resize(random() % (bytes.size() + 8));
    const auto received = receive<TypeParam>(bytes);
    if (const auto* message = std::get_if<TypeParam>(&received)) {
      EXPECT_EQ(encode(*message), bytes);
      ++accepted;
    }
  }
  EXPECT_GT(accepted, 0);
}

TEST(Wire, TypesHaveDifferentFingerprintsAndChannels) {
  std::set<std::int64_t> fingerprints;
  std::set<std::string_view> channels;
  const auto note = [&](const MessageFormat& format) {
    fingerprints.insert(format.fingerprint);
    channels.insert(format.channel);
  };
  [&]<class... Ts>(std::type_identity<std::variant<Ts...>>) {
    (note(message_format<Ts>()), ...);
  }(std::type_identity<Message>{});
  EXPECT_EQ(fingerprints.size(), std::variant_size_v<Message>);
  EXPECT_EQ(channels.size(), std::variant_size_v<Message>);
}

TEST(Wire, RefusesHostileSonarMessages) {
  // A sound beginning, up to the length of the sensor's name.
  const auto begin = [](std::int64_t utime = 1, std::int64_t seq = 0) {
    return Payload(range_sonar_t::getHash()).put(utime).put(seq);
  };
  const auto named = [&] { return begin().put(std::int32_t{5}).text(std::string_view("port\0", 5)); };
  const auto one = [&](double range, std::int32_t label) {
    return named().put(std::int32_t{1}).put(range).put(label);
  };
  const std::string long_name(65, 'a');
  const struct {
    const char* what;
    Payload payload;
    RejectReason reason;
  } cases[] = {
      {"negative count", named().put(std::int32_t{-1}), RejectReason::bad_count},
      {"smallest count", named().put(std::numeric_limits<std::int32_t>::min()), RejectReason::bad_count},
      {"count 2^28", named().put(std::int32_t{1} << 28), RejectReason::bad_count},
      {"count 2^29 wraps its size", named().put(std::int32_t{1} << 29), RejectReason::bad_count},
      {"largest count", named().put(std::numeric_limits<std::int32_t>::max()), RejectReason::bad_count},
      {"one too many", named().put(range_sonar_t::MAX_ECHOES + 1), RejectReason::bad_count},
      {"count without elements", named().put(std::int32_t{64}), RejectReason::too_short},
      {"smallest text length", begin().put(std::numeric_limits<std::int32_t>::min()), RejectReason::bad_text},
      {"largest text length", begin().put(std::numeric_limits<std::int32_t>::max()), RejectReason::bad_text},
      {"text length -1", begin().put(std::int32_t{-1}), RejectReason::bad_text},
      {"text length 0", begin().put(std::int32_t{0}), RejectReason::bad_text},
      {"empty text", begin().put(std::int32_t{1}).put('\0'), RejectReason::bad_text},
      {"text too long", begin().put(std::int32_t{66}).text(long_name).put('\0'), RejectReason::bad_text},
      {"text longer than the message", begin().put(std::int32_t{60}).text("port"), RejectReason::too_short},
      {"text not terminated", begin().put(std::int32_t{4}).text("port").put(std::int32_t{0}),
       RejectReason::bad_text},
      {"zero inside the text",
       begin().put(std::int32_t{3}).text(std::string_view("a\0\0", 3)).put(std::int32_t{0}),
       RejectReason::bad_text},
      {"control character",
       begin().put(std::int32_t{3}).text(std::string_view("a\n\0", 3)).put(std::int32_t{0}),
       RejectReason::bad_text},
      {"range NaN", one(kNan, -1), RejectReason::not_finite},
      {"range infinite", one(kInf, -1), RejectReason::not_finite},
      {"range negative", one(-0.001, -1), RejectReason::out_of_range},
      {"range huge", one(1e300, -1), RejectReason::out_of_range},
      {"label -2", one(1.0, -2), RejectReason::out_of_range},
      {"last time", begin(std::numeric_limits<std::int64_t>::max()), RejectReason::out_of_range},
      {"counter negative", begin(0, -1), RejectReason::out_of_range},
  };
  for (const auto& test : cases) {
    EXPECT_EQ(reason_of<range_sonar_t>(test.payload.bytes()), test.reason) << test.what;
  }
}

TEST(Wire, RefusesFlagsAndKindsThatDoNotExist) {
  auto truth = sample<truth_t>();
  truth.heading_known = 2;
  EXPECT_THROW(encode(truth), std::invalid_argument);
  auto map = sample<truth_map_t>();
  map.kind[1] = 2;
  EXPECT_THROW(encode(map), std::invalid_argument);
}

TEST(Wire, SaysWhatIsWrong) {
  auto message = sample<range_bearing_t>();
  message.bearing[1] = 90.0;
  try {
    encode(message);
    FAIL() << "was sent";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "range_bearing_t: bearing[1] is 90, allowed is -6.2832 to 6.2832");
  }
}

TEST(Wire, LargestMessagesFit) {
  truth_map_t map{};
  map.count = truth_map_t::MAX_FEATURES;
  const auto size = static_cast<std::size_t>(map.count);
  map.label.resize(size);
  map.kind.resize(size);
  for (auto* values : {&map.x, &map.y, &map.rho, &map.alpha}) values->resize(size);
  EXPECT_LE(encode(map).size(), kMaxMessageSize);

  range_bearing_t scan{};
  scan.sensor = std::string(range_bearing_t::MAX_NAME, 'a');
  scan.count = range_bearing_t::MAX_SIGHTINGS;
  scan.range.resize(range_bearing_t::MAX_SIGHTINGS);
  scan.bearing.resize(range_bearing_t::MAX_SIGHTINGS);
  scan.label.resize(range_bearing_t::MAX_SIGHTINGS);
  EXPECT_LE(encode(scan).size(), kMaxMessageSize);
}

}  // namespace
}  // namespace leadline::app
