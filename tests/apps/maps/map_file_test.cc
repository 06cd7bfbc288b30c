#include "apps/maps/map_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <boost/crc.hpp>
#include <cstdint>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "apps/recordings/import_car_park.h"
#include "apps/support/limits.h"
#include "tests/apps/node/mission.h"
#include "tests/support/public_recording.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::HasSubstr;

Snapshot snapshot_of(const std::string& config, const std::vector<std::string>& sets) {
  const Mission mission(config, 5, sets);
  Slam slam(mission.config.slam);
  for (const Instant& instant : mission.recording.instants) slam.step(instant);
  return slam.snapshot();
}

void expect_to_go_on(const SlamOptions& options, std::span<const Instant> instants) {
  Slam whole(options);
  auto restarted = std::make_unique<Slam>(options);
  int k = 0;
  for (const Instant& instant : instants) {
    whole.step(instant);
    restarted->step(instant);
    ASSERT_EQ(restarted->belief().vehicle(), whole.belief().vehicle()) << "step " << k;
    if (++k % 40 == 0)
      restarted = std::make_unique<Slam>(options, decode_map(encode_map(restarted->snapshot())));
  }
  EXPECT_EQ(restarted->belief().covariance(), whole.belief().covariance());
  EXPECT_GT(whole.submaps().submaps().size(), 3U);
}

class MapFileTest : public testing::TestWithParam<std::pair<const char*, const char*>> {};

// Written, read and written again it is the same file: nothing is lost, not even a bit.
TEST_P(MapFileTest, LosesNothing) {
  const Snapshot snapshot = snapshot_of(GetParam().first, {GetParam().second});
  const std::vector<std::byte> bytes = encode_map(snapshot);
  const Snapshot read = decode_map(bytes);
  EXPECT_EQ(encode_map(read), bytes);
  EXPECT_EQ(read.joint.covariance(), snapshot.joint.covariance());
  EXPECT_EQ(read.error, snapshot.error);
  EXPECT_EQ(read.held_input.index(), snapshot.held_input.index());
  EXPECT_EQ(read.submaps.size(), snapshot.submaps.size());
  EXPECT_EQ(read.in_use, snapshot.in_use);
  EXPECT_EQ(read.next_gate, snapshot.next_gate);
  const auto same_place = [](const Pose2& a, const Pose2& b) {
    return a.position() == b.position() && a.heading == b.heading;
  };
  EXPECT_TRUE(std::ranges::equal(read.places, snapshot.places, same_place));
  const auto expect_same = [&](auto member) {
    EXPECT_TRUE(std::ranges::equal(read.features, snapshot.features, {}, member, member));
  };
  for (const auto member : {&Feature::hits, &Feature::label, &Feature::label_lead, &Feature::sensor})
    expect_same(member);
  expect_same(&Feature::point_shape);
  expect_same(&Feature::given_up);
  expect_same(&Feature::evidence);
  expect_same(&Feature::existence);
  expect_same(&Feature::farthest);
  expect_same(&Feature::last_seen);
  EXPECT_EQ(read.first_returns, snapshot.first_returns);
  EXPECT_FALSE(read.channels.empty());
  EXPECT_EQ(read.channels, snapshot.channels);
}

// However often a vehicle is switched off, it goes on to the bit as if it had not been. In circles so small
// that it is switched off in several, with targets in doubt and returns that wait.
TEST_P(MapFileTest, GoesOnToTheBit) {
  const auto& [world, set] = GetParam();
  const Mission mission(world, 6, {set, "map.mode=submaps", "map.radius_m=3"});
  expect_to_go_on(mission.config.slam, mission.recording.instants);
}

// The same where the world is none that was made here.
TEST(MapFileRecording, GoesOnToTheBitInTheCarPark) {
  const auto folder = public_recording("car_park");
  if (!folder) GTEST_SKIP() << kNoRecordings;
  const Config config = read_config(LEADLINE_SOURCE_DIR "/configs/car_park.yaml",
                                    {Setting::parse("map.mode=submaps"), Setting::parse("map.radius_m=4")});
  const Import import = import_car_park(*folder);
  expect_to_go_on(config.slam, import.recording.instants);
}

INSTANTIATE_TEST_SUITE_P(OfEveryWorld, MapFileTest,
                         testing::Values(std::pair("tank_0p3", "simulation.duration_s=60"),
                                         std::pair("harbour_loops", "simulation.duration_s=300"),
                                         std::pair("field_50", "simulation.field.steps=100"),
                                         std::pair("tank_0p3", "features.radius_sigma_m=0.2"),
                                         std::pair("tank_0p3", "features.scale_sigma=0.02")));

// The clock may be set to any time that a message may have: what was before that is kept as long ago.
TEST(MapFileTest, AClockThatWasSetToTheFirstOrLastTimeIsRead) {
  const Mission mission("tank_0p3", 5, {"simulation.duration_s=30"});
  for (const double utime : {limits::kTime.min, limits::kTime.max}) {
    Slam slam(mission.config.slam);
    for (const Instant& instant : mission.recording.instants) slam.step(instant);
    slam.set_clock(1'700'000'000'000'000);
    slam.set_clock(static_cast<std::int64_t>(utime));
    const std::vector<std::byte> bytes = encode_map(slam.snapshot());
    EXPECT_EQ(encode_map(decode_map(bytes)), bytes);
    EXPECT_NO_THROW(Slam(mission.config.slam, decode_map(bytes)));
  }
}

std::string refusal(std::vector<std::byte> bytes) {
  return error_of<std::runtime_error>([&] { decode_map(bytes); });
}

TEST(MapFileTest, EveryCutAndEveryFlipIsNoticed) {
  const std::vector<std::byte> bytes = encode_map(snapshot_of("tank_0p3", {"simulation.duration_s=20"}));
  for (std::size_t size = 0; size < bytes.size(); size += 7)
    EXPECT_THROW(decode_map(std::span(bytes).first(size)), std::runtime_error);
  for (std::size_t i = 0; i < bytes.size(); i += 5) {
    std::vector<std::byte> damaged = bytes;
    damaged[i] ^= std::byte{0x10};
    EXPECT_THROW(decode_map(damaged), std::runtime_error) << "byte " << i;
  }
  EXPECT_THAT(refusal({}), HasSubstr("is no map"));
  std::vector<std::byte> other = bytes;
  other[13] = std::byte{9};
  EXPECT_THAT(refusal(other), HasSubstr("is of version 9, this program reads version 5"));
  other = bytes;
  other.push_back({});
  EXPECT_THAT(refusal(other), HasSubstr("bytes after its header"));
  other = bytes;
  other.back() ^= std::byte{1};
  EXPECT_THAT(refusal(other), HasSubstr("checksum"));
}

TEST(MapFileTest, LostIdentitiesComeBackInTheirOrder) {
  Snapshot snapshot = snapshot_of("tank_0p3", {"simulation.duration_s=20"});
  EXPECT_TRUE(decode_map(encode_map(snapshot)).aliases.empty());
  snapshot.aliases = {{2'000'000'000, 7}, {3, 1}, {12, -5}};  // sound or not, the estimator says
  EXPECT_EQ(decode_map(encode_map(snapshot)).aliases, snapshot.aliases);
}

std::filesystem::path seeds() { return LEADLINE_SOURCE_DIR "/tests/fuzz/seeds/map"; }

/// A map of that document, under a header that is right.
std::vector<std::byte> map_of(std::span<const std::uint8_t> document) {
  boost::crc_32_type crc;
  crc.process_bytes(document.data(), document.size());
  std::vector<std::byte> bytes;
  const auto append = [&](const auto& value) { std::ranges::copy(value, std::back_inserter(bytes)); };
  append(std::as_bytes(std::span(std::string_view("leadline map\n"))));
  append(std::bit_cast<std::array<std::byte, 4>>(kMapVersion));
  append(std::bit_cast<std::array<std::byte, 8>>(std::uint64_t{document.size()}));
  append(std::bit_cast<std::array<std::byte, 4>>(std::uint32_t{crc.checksum()}));
  append(std::as_bytes(document));
  return bytes;
}

TEST(MapFileTest, LostIdentitiesThatAreNoneAreRefused) {
  using nlohmann::json;
  const std::string seed = read_bytes(seeds() / "tank");
  json document = json::from_cbor(seed);
  const auto with = [&](const char* aliases) {
    document["aliases"] = json::parse(aliases);
    return map_of(json::to_cbor(document));
  };
  EXPECT_EQ(decode_map(with("[[7, 3]]")).aliases, (std::vector<Alias>{{7, 3}}));
  EXPECT_THAT(refusal(with("[[7]]")), HasSubstr("is not as a map must be"));
  EXPECT_THAT(refusal(with("[7, 3]")), HasSubstr("is not as a map must be"));
  EXPECT_THAT(refusal(with("[[7.5, 3]]")), HasSubstr("holds 7.5 where there must be a whole number"));
  EXPECT_THAT(refusal(with("[[7, 3000000000]]")), HasSubstr("holds 3000000000"));
  EXPECT_THAT(refusal(with("[[\"7\", \"3\"]]")), HasSubstr("where there must be a whole number"));
  document.erase("aliases");
  EXPECT_THAT(refusal(map_of(json::to_cbor(document))), HasSubstr("'aliases' not found"));
}

TEST(MapFileTest, PlacesErrorsAndFeaturesInUseThatAreNoneAreRefused) {
  using nlohmann::json;
  const json document = json::from_cbor(read_bytes(seeds() / "tank"));
  const auto with = [&](const char* key, const json& value) {
    json other = document;
    other[key] = value;
    return map_of(json::to_cbor(other));
  };
  const auto place_of_bytes = [](std::size_t n) {
    return json::array({json::binary(std::vector<std::uint8_t>(n))});
  };
  EXPECT_EQ(decode_map(with("in_use", {7, 3})).in_use, (std::vector<int>{7, 3}));
  EXPECT_THAT(refusal(with("in_use", {7.5})), HasSubstr("holds 7.5 where there must be a whole number"));
  EXPECT_THAT(refusal(with("in_use", {3'000'000'000})), HasSubstr("holds 3000000000"));
  EXPECT_EQ(decode_map(with("places", place_of_bytes(24))).places.size(), 1U);
  EXPECT_THAT(refusal(with("places", place_of_bytes(16))),
              HasSubstr("holds 2 numbers where there must be 3"));
  EXPECT_THAT(refusal(with("places", place_of_bytes(32))),
              HasSubstr("holds 4 numbers where there must be 3"));
  EXPECT_THAT(refusal(with("places", place_of_bytes(23))), HasSubstr("holds a part of a number"));
  EXPECT_THAT(refusal(with("places", {json::array({0.0, 0.0, 0.0})})), HasSubstr("is not as a map must be"));
  EXPECT_EQ(decode_map(with("error", 0)).error, ErrorKind::additive);
  EXPECT_THAT(refusal(with("error", 2)), HasSubstr("holds 2"));
  for (const char* key : {"in_use", "places", "error"}) {
    json other = document;
    other.erase(key);
    EXPECT_THAT(refusal(map_of(json::to_cbor(other))), HasSubstr(std::string("'") + key + "' not found"));
  }
}

// Else the fuzzer would not get beyond what every map has.
TEST(MapFileTest, SeedsOfTheFuzzerAreOfThisFormat) {
  const auto map = [](const char* seed) {
    const std::string document = read_bytes(seeds() / seed);
    return map_of({reinterpret_cast<const std::uint8_t*>(document.data()), document.size()});
  };
  for (const char* seed : {"start", "tank", "field"}) EXPECT_NO_THROW(decode_map(map(seed))) << seed;
  EXPECT_EQ(decode_map(map("field")).aliases.size(), 3U);
  EXPECT_THAT(refusal(map("nan")), HasSubstr("where there must be a whole number"));
  EXPECT_THAT(refusal(map("nested")), HasSubstr("nested too deeply"));
  EXPECT_THAT(refusal(map("point_of_five")), HasSubstr("holds a part of 5 numbers"));
}

TEST(MapFileTest, HeadAloneIsNoMap) {
  const std::vector<std::byte> head = encode_head(snapshot_of("tank_0p3", {"simulation.duration_s=20"}), 1);
  EXPECT_THAT(refusal(head), HasSubstr("is the head of a checkpoint"));
}

TEST(MapFileTest, FileIsNamed) {
  const ScratchFolder folder;
  EXPECT_THAT(error_of<std::runtime_error>([&] { read_map(folder / "none.map"); }),
              HasSubstr("none.map: cannot read"));
  folder.write("text.map", "not a map");
  EXPECT_THAT(error_of<std::runtime_error>([&] { read_map(folder / "text.map"); }),
              HasSubstr("text.map: is no map"));
}

}  // namespace
}  // namespace leadline::app
