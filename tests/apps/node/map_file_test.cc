#include "apps/node/map_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "tests/apps/node/mission.h"
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

class MapFileTest : public testing::TestWithParam<std::pair<const char*, const char*>> {};

// Written, read and written again it is the same file: nothing is lost, not even a bit.
TEST_P(MapFileTest, LosesNothing) {
  const Snapshot snapshot = snapshot_of(GetParam().first, {GetParam().second});
  const std::vector<std::byte> bytes = encode_map(snapshot);
  const Snapshot read = decode_map(bytes);
  EXPECT_EQ(encode_map(read), bytes);
  EXPECT_EQ(read.joint.covariance(), snapshot.joint.covariance());
  EXPECT_EQ(read.held_input.index(), snapshot.held_input.index());
  EXPECT_EQ(read.submaps.size(), snapshot.submaps.size());
  const auto expect_same = [&](auto member) {
    EXPECT_TRUE(std::ranges::equal(read.features, snapshot.features, {}, member, member));
  };
  for (const auto member : {&Feature::hits, &Feature::label, &Feature::label_lead, &Feature::sensor})
    expect_same(member);
  expect_same(&Feature::evidence);
  expect_same(&Feature::existence);
  expect_same(&Feature::farthest);
  expect_same(&Feature::last_seen);
  EXPECT_EQ(read.first_returns, snapshot.first_returns);
  EXPECT_FALSE(read.channels.empty());
  EXPECT_EQ(read.channels, snapshot.channels);
}

INSTANTIATE_TEST_SUITE_P(OfEveryWorld, MapFileTest,
                         testing::Values(std::pair("tank_0p3", "simulation.duration_s=60"),
                                         std::pair("harbour_loops", "simulation.duration_s=300"),
                                         std::pair("field_50", "simulation.field.steps=100")));

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
  EXPECT_THAT(refusal(other), HasSubstr("is of version 9, this program reads version 4"));
  other = bytes;
  other.push_back({});
  EXPECT_THAT(refusal(other), HasSubstr("bytes after its header"));
  other = bytes;
  other.back() ^= std::byte{1};
  EXPECT_THAT(refusal(other), HasSubstr("checksum"));
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
