#include "apps/wire/wire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <type_traits>

#include "apps/wire/messages.h"
#include "tests/apps/wire/sample_messages.h"

namespace leadline::app {
namespace {

using ::testing::HasSubstr;

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

// The number of a message, of a command or its reply.
template <class T>
std::int64_t& counter(T& message) {
  if constexpr (requires { message.seq; }) {
    return message.seq;
  } else {
    return message.id;
  }
}

template <class T>
class EveryType : public ::testing::Test {};
template <class T>
class RecordedType : public ::testing::Test {};

template <class Variant>
struct TypesOf;
template <class... Ts>
struct TypesOf<std::variant<Ts...>> : std::type_identity<::testing::Types<Ts...>> {};
TYPED_TEST_SUITE(EveryType, TypesOf<EveryMessage>::type);
TYPED_TEST_SUITE(RecordedType, TypesOf<Message>::type);

TYPED_TEST(EveryType, ComesBackAsItWasSent) {
  const auto bytes = encode(sample_message<TypeParam>());
  const auto received = receive<TypeParam>(bytes);
  ASSERT_TRUE(std::holds_alternative<TypeParam>(received)) << std::get<Rejection>(received).text;
  EXPECT_EQ(encode(std::get<TypeParam>(received)), bytes);
}

TYPED_TEST(RecordedType, IsKnownByItsChannel) {
  const std::string channel = "SUB2_" + std::string(message_format<TypeParam>().channel);
  const Receiver receiver = receiver_of(channel, "SUB2_");
  ASSERT_NE(receiver, nullptr);
  const auto received = receiver(encode(sample_message<TypeParam>()));
  ASSERT_TRUE(std::holds_alternative<Message>(received));
  EXPECT_TRUE(std::holds_alternative<TypeParam>(std::get<Message>(received)));
  EXPECT_EQ(receiver_of(channel, "AUV_"), nullptr);
  EXPECT_EQ(receiver_of(channel + "2", "SUB2_"), nullptr);
}

TYPED_TEST(EveryType, IsRefusedWhenCutAnywhere) {
  const auto bytes = encode(sample_message<TypeParam>());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_EQ(reason_of<TypeParam>(Bytes(bytes).first(size)), RejectReason::too_short) << size;
  }
}

TYPED_TEST(EveryType, IsRefusedWithTrailingBytes) {
  auto bytes = encode(sample_message<TypeParam>());
  bytes.push_back(std::byte{0});
  EXPECT_EQ(reason_of<TypeParam>(bytes), RejectReason::trailing_bytes);
  bytes.resize(kMaxMessageSize + 1);
  EXPECT_EQ(reason_of<TypeParam>(bytes), RejectReason::too_large);
}

TYPED_TEST(EveryType, IsRefusedWithAnotherFingerprint) {
  auto bytes = encode(sample_message<TypeParam>());
  bytes[7] ^= std::byte{1};
  EXPECT_EQ(reason_of<TypeParam>(bytes), RejectReason::wrong_type);
}

TYPED_TEST(EveryType, IsRefusedWhenTimeOrCounterAreOut) {
  auto message = sample_message<TypeParam>();
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
  message = sample_message<TypeParam>();
  counter(message) = -1;
  EXPECT_TRUE(refused());
}

// Whatever the bytes: no crash, and what is accepted is exactly what a sound sender would have sent.
TYPED_TEST(EveryType, SurvivesMutation) {
  const auto sound = encode(sample_message<TypeParam>());
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

// What range_sonar_t was before it had a quality is read as it was, live and from logs.
TEST(Wire, ReadsThePlainPingsOfOldLogs) {
  EXPECT_EQ(static_cast<std::uint64_t>(range_sonar_plain_t::getHash()), 0xe2ae0f57790d05d1);
  const range_sonar_plain_t plain{1'000'000, 3, "port", 2, {0.5, 100.0}, {-1, 7}};
  const std::vector<std::byte> bytes = encode(plain);
  const Receiver receive = receiver_of("AUV_RANGE_SONAR", "AUV_");
  const auto received = receive(bytes);
  const auto& message = std::get<range_sonar_t>(std::get<Message>(received));
  EXPECT_EQ(message.utime, plain.utime);
  EXPECT_EQ(message.seq, plain.seq);
  EXPECT_EQ(message.sensor, plain.sensor);
  EXPECT_EQ(message.count, 2);
  EXPECT_EQ(message.range, plain.range);
  EXPECT_EQ(message.label, plain.label);
  EXPECT_EQ(message.sigma, std::vector<double>(2, 0.0));
  EXPECT_EQ(message.confidence, std::vector<double>(2, -1.0));
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_TRUE(std::holds_alternative<Rejection>(receive(Bytes(bytes).first(size)))) << size;
}

TEST(Wire, TypesHaveDifferentFingerprintsAndChannels) {
  std::set<std::int64_t> fingerprints;
  std::set<std::string_view> channels;
  for_each_message_type([&]<class T>(std::type_identity<T>) {
    fingerprints.insert(message_format<T>().fingerprint);
    channels.insert(message_format<T>().channel);
  });
  EXPECT_EQ(fingerprints.size(), std::variant_size_v<EveryMessage>);
  EXPECT_EQ(channels.size(), std::variant_size_v<EveryMessage>);
}

TEST(Wire, RefusesFlagsAndKindsThatDoNotExist) {
  auto truth = sample_message<truth_t>();
  truth.heading_known = 2;
  EXPECT_THROW(encode(truth), std::invalid_argument);
  auto map = sample_message<truth_map_t>();
  map.kind[1] = 8;
  EXPECT_THROW(encode(map), std::invalid_argument);
  auto submap = sample_message<submap_t>();
  submap.kind[2] = submap_t::CYLINDER + 1;
  EXPECT_THROW(encode(submap), std::invalid_argument);
  auto changes = sample_message<map_changes_t>();
  changes.reason[1] = map_changes_t::JOINED + 1;
  EXPECT_THROW(encode(changes), std::invalid_argument);
  auto health = sample_message<slam_health_t>();
  health.status = slam_health_t::LOST + 1;
  EXPECT_THROW(encode(health), std::invalid_argument);
  auto command = sample_message<slam_command_t>();
  command.kind = -1;
  EXPECT_THROW(encode(command), std::invalid_argument);
}

TEST(Wire, SaysWhatIsWrong) {
  auto message = sample_message<range_bearing_t>();
  message.bearing[1] = 90.0;
  try {
    encode(message);
    FAIL() << "was sent";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "range_bearing_t: bearing[1] is 90, allowed is -6.2832 to 6.2832");
  }
}

TEST(Wire, TakesEveryCovarianceWithinRounding) {
  const double line = 1.0 / 3.0;  // all along one line: nothing but rounding keeps it from being singular
  const double tiny = 1e-300;
  const double covariances[][6] = {
      {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
      {1.0, 0.0, 0.0, 0.0, 0.0, 0.0},
      {0.0, 0.0, 0.0, 4.0, 0.2, 0.01},
      {1.0, 1.0, 1.0, 1.0, 1.0, 1.0},
      {1.0, line, -line * line, line * line, -line * line * line, line * line * line * line},
      {1e16, 1e4, 1e-2, 1e-8, 1e-14, 1e-20},
      {tiny, -tiny, 0.0, tiny, 0.0, tiny},
  };
  for (const auto& covariance : covariances) {
    auto state = sample_message<vehicle_state_t>();
    std::ranges::copy(covariance, state.cov);
    EXPECT_NO_THROW(encode(state)) << ::testing::PrintToString(covariance);
  }
}

TEST(Wire, RefusesWhatIsNoCovariance) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const struct {
    double covariance[6];
    RejectReason reason;
  } cases[] = {
      {{1.0, 0.0, 0.0, 1.0, 0.0, kNan}, RejectReason::not_finite},
      {{1.0, 0.0, -kInf, 1.0, 0.0, 1.0}, RejectReason::not_finite},
      {{1e17, 0.0, 0.0, 1.0, 0.0, 1.0}, RejectReason::out_of_range},
      {{-1e-9, 0.0, 0.0, 1.0, 0.0, 1.0}, RejectReason::not_covariance},
      {{1.0, 0.0, 0.0, -1.0, 0.0, 1.0}, RejectReason::not_covariance},
      {{1.0, 0.0, 0.0, 1.0, 0.0, -1.0}, RejectReason::not_covariance},
      {{1.0, 1.0001, 0.0, 1.0, 0.0, 1.0}, RejectReason::not_covariance},
      {{1.0, 0.0, -1.0001, 1.0, 0.0, 1.0}, RejectReason::not_covariance},
      {{1.0, 0.0, 0.0, 1.0, 1.0001, 1.0}, RejectReason::not_covariance},
      {{1.0, 0.9, -0.9, 1.0, 0.9, 1.0}, RejectReason::not_covariance},  // each pair is sound
      {{0.0, 1e-12, 0.0, 1.0, 0.0, 1.0}, RejectReason::not_covariance},
      {{0.0, 1e16, 1e16, 0.0, 1e16, 0.0}, RejectReason::not_covariance},
  };
  for (const auto& test : cases) {
    auto state = sample_message<vehicle_state_t>();
    std::ranges::copy(test.covariance, state.local_cov);
    std::vector<std::byte> bytes(static_cast<std::size_t>(state.getEncodedSize()));
    state.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    EXPECT_EQ(reason_of<vehicle_state_t>(bytes), test.reason) << ::testing::PrintToString(test.covariance);
  }
}

TEST(Wire, NamesTheCovarianceThatIsNone) {
  auto submap = sample_message<submap_t>();
  submap.feature_cov[2] = {1.0, 2.0, 1.0};
  try {
    encode(submap);
    FAIL() << "was sent";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "submap_t: feature_cov[2] is not positive semi-definite");
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

  submap_t submap{};
  submap.total = submap.count = submap_t::MAX_FEATURES;
  for (auto* values : {&submap.feature, &submap.hits}) values->resize(submap_t::MAX_FEATURES);
  for (auto* values : {&submap.kind, &submap.confirmed}) values->resize(submap_t::MAX_FEATURES);
  for (auto* values : {&submap.px, &submap.py, &submap.rho, &submap.alpha, &submap.feature_radius,
                       &submap.radius_sigma, &submap.scale, &submap.scale_sigma}) {
    values->resize(submap_t::MAX_FEATURES);
  }
  submap.feature_cov.assign(submap_t::MAX_FEATURES, std::vector<double>(3));
  EXPECT_LE(encode(submap).size(), kMaxMessageSize);

  submap_graph_t graph{};
  graph.total = graph.submaps = submap_graph_t::MAX_SUBMAPS;
  graph.links = submap_graph_t::MAX_LINKS;
  for (auto* values : {&graph.id, &graph.parent}) values->resize(submap_graph_t::MAX_SUBMAPS);
  for (auto* values : {&graph.x, &graph.y, &graph.heading}) values->resize(submap_graph_t::MAX_SUBMAPS);
  graph.cov.assign(submap_graph_t::MAX_SUBMAPS, std::vector<double>(6));
  for (auto* values : {&graph.a, &graph.b}) values->resize(submap_graph_t::MAX_LINKS);
  for (auto* values : {&graph.link_x, &graph.link_y, &graph.link_heading}) {
    values->resize(submap_graph_t::MAX_LINKS);
  }
  graph.link_cov.assign(submap_graph_t::MAX_LINKS, std::vector<double>(6));
  EXPECT_LE(encode(graph).size(), kMaxMessageSize);

  map_changes_t changes{};
  changes.count = map_changes_t::MAX_CHANGES;
  for (auto* values : {&changes.feature, &changes.into}) values->resize(map_changes_t::MAX_CHANGES);
  changes.reason.resize(map_changes_t::MAX_CHANGES);
  EXPECT_LE(encode(changes).size(), kMaxMessageSize);

  slam_health_t health{};
  health.text = std::string(slam_health_t::MAX_TEXT, 'a');
  health.streams = slam_health_t::MAX_STREAMS;
  health.stream.assign(slam_health_t::MAX_STREAMS, std::string(slam_health_t::MAX_NAME, 'a'));
  health.silent.resize(slam_health_t::MAX_STREAMS);
  for (auto* values : {&health.rate, &health.age, &health.nis}) values->resize(slam_health_t::MAX_STREAMS);
  for (auto* values : {&health.received, &health.lost, &health.late_ones, &health.repeated}) {
    values->resize(slam_health_t::MAX_STREAMS);
  }
  health.checked.resize(slam_health_t::MAX_STREAMS);
  health.reasons = slam_health_t::MAX_REASONS;
  health.reason.assign(slam_health_t::MAX_REASONS, std::string(slam_health_t::MAX_NAME, 'a'));
  health.refused.resize(slam_health_t::MAX_REASONS);
  EXPECT_LE(encode(health).size(), kMaxMessageSize);
}

}  // namespace
}  // namespace leadline::app
