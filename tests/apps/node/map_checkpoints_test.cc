#include "apps/node/map_checkpoints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "apps/maps/map_file.h"
#include "tests/apps/node/mission.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

/// Snapshots of one mission, one after every crossing.
std::vector<Snapshot> snapshots() {
  const Mission mission("tank_0p3", 5, {"simulation.duration_s=80"});
  Slam slam(mission.config.slam);
  std::vector<Snapshot> snapshots;
  int submap = 0;
  for (const Instant& instant : mission.recording.instants) {
    slam.step(instant);
    if (std::exchange(submap, slam.submaps().current()) == slam.submaps().current()) continue;
    snapshots.push_back(slam.snapshot());
  }
  return snapshots;
}

class MapCheckpointsTest : public testing::Test {
 protected:
  MapCheckpointsTest() : snapshots_(snapshots()) {}

  fs::path newest() const { return folder_ / "checkpoint.map"; }
  fs::path previous() const { return folder_ / "checkpoint.previous.map"; }

  /// Files of submaps and atlases, with the time they were written.
  std::map<std::string, fs::file_time_type> parts() const {
    std::map<std::string, fs::file_time_type> parts;
    for (const auto& entry : fs::directory_iterator(parts_folder(newest())))
      parts[entry.path().filename()] = entry.last_write_time();
    return parts;
  }
  /// Names of the files that both heads name.
  std::set<std::string> named() const {
    std::set<std::string> named;
    for (const fs::path& head : {newest(), previous()}) {
      if (!fs::exists(head)) continue;
      const Parts parts = read_parts(head).value();
      named.insert(part_path(head, parts.atlas).filename());
      for (const int number : parts.submaps) named.insert(part_path(head, number).filename());
    }
    return named;
  }
  static std::set<std::string> names(const std::map<std::string, fs::file_time_type>& parts) {
    std::set<std::string> names;
    for (const auto& [name, time] : parts) names.insert(name);
    return names;
  }

  const ScratchFolder folder_;
  std::vector<Snapshot> snapshots_;
};

TEST_F(MapCheckpointsTest, LosesNothing) {
  ASSERT_GE(snapshots_.size(), 4U);
  MapCheckpoints checkpoints(folder_.path());
  for (const Snapshot& snapshot : snapshots_) {
    checkpoints.write(snapshot);
    EXPECT_EQ(encode_map(read_map(newest())), encode_map(snapshot));
  }
  EXPECT_EQ(encode_map(read_map(previous())), encode_map(snapshots_[snapshots_.size() - 2]));
}

TEST_F(MapCheckpointsTest, WritesWhatHasChangedAndRemovesWhatNobodyNames) {
  MapCheckpoints checkpoints(folder_.path());
  checkpoints.write(snapshots_[2]);
  const auto before = parts();
  checkpoints.write(snapshots_[2]);
  EXPECT_EQ(parts(), before) << "nothing but the head";
  for (std::size_t i = 3; i < snapshots_.size(); ++i) {
    const auto old = parts();
    checkpoints.write(snapshots_[i]);
    std::size_t written = 0, changed = 0;
    for (const auto& [name, time] : parts()) written += old.contains(name) ? 0 : 1;
    for (std::size_t k = 0; k < snapshots_[i].submaps.size(); ++k)
      changed +=
          k >= snapshots_[i - 1].submaps.size() || snapshots_[i].submaps[k] != snapshots_[i - 1].submaps[k];
    EXPECT_EQ(written, changed + 1) << "those submaps and the atlas";
    EXPECT_LT(changed, snapshots_[i].submaps.size());
    EXPECT_EQ(names(parts()), named());
  }
}

TEST_F(MapCheckpointsTest, AfterARestartWhatIsThereIsNotWrittenAgain) {
  const MapCheckpoints::Load load = [](const fs::path& path) { return read_map(path); };
  MapCheckpoints(folder_.path()).write(snapshots_[3]);
  const auto before = parts();
  MapCheckpoints checkpoints(folder_.path());
  const auto resumed = checkpoints.resume(load);
  ASSERT_TRUE(resumed);
  checkpoints.write(*resumed);
  EXPECT_EQ(encode_map(read_map(newest())), encode_map(snapshots_[3]));
  std::size_t written = 0;
  for (const auto& [name, time] : parts()) written += before.contains(name) ? 0 : 1;
  EXPECT_EQ(written, 1U) << "the atlas";
}

// Killed between the submaps and the head: the old head names what is there, the rest goes.
TEST_F(MapCheckpointsTest, WhatWasNotCompletedIsRemovedAtTheNextStart) {
  MapCheckpoints(folder_.path()).write(snapshots_[2]);
  folder_.write("checkpoint.parts/1000.map", "of no head");
  folder_.write("checkpoint.parts/1001.map.part", "cut o");
  MapCheckpoints checkpoints(folder_.path());
  EXPECT_EQ(encode_map(read_map(newest())), encode_map(snapshots_[2]));
  checkpoints.write(snapshots_[3]);
  EXPECT_FALSE(fs::exists(folder_ / "checkpoint.parts/1000.map"));
  EXPECT_FALSE(fs::exists(folder_ / "checkpoint.parts/1001.map.part"));
  EXPECT_TRUE(fs::exists(folder_ / "checkpoint.parts/1002.map")) << "a number is never used twice";
}

TEST_F(MapCheckpointsTest, DamagedSubmapIsPutAsideWithItsHead) {
  MapCheckpoints(folder_.path()).write(snapshots_[2]);
  MapCheckpoints(folder_.path()).write(snapshots_[3]);
  const Parts now = read_parts(newest()).value(), then = read_parts(previous()).value();
  const int number = now.submaps.back();
  ASSERT_FALSE(std::ranges::count(then.submaps, number));
  const std::string name = "checkpoint.parts/" + std::to_string(number) + ".map";
  folder_.write(name, "no map");

  MapCheckpoints checkpoints(folder_.path());
  const auto resumed = checkpoints.resume([](const fs::path& path) { return read_map(path); });
  ASSERT_TRUE(resumed);
  EXPECT_EQ(encode_map(*resumed), encode_map(snapshots_[2]));
  EXPECT_TRUE(fs::exists(folder_ / "checkpoint.bad.map"));
  checkpoints.write(snapshots_[4]);
  EXPECT_TRUE(fs::exists(folder_ / name)) << "nothing that cannot be read is removed";
}

TEST_F(MapCheckpointsTest, NothingThatWasPutAsideIsOverwritten) {
  for (std::size_t i = 0; i < 3; ++i) {
    MapCheckpoints checkpoints(folder_.path());
    checkpoints.write(snapshots_[i]);
    checkpoints.put_aside("is of yesterday");
  }
  const char* const names[] = {"checkpoint.old.map", "checkpoint.old.2.map", "checkpoint.old.3.map"};
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(encode_map(read_map(folder_ / names[i])), encode_map(snapshots_[i])) << names[i];
}

TEST_F(MapCheckpointsTest, PartsOfAllBadOnesStay) {
  for (const std::size_t i : {1U, 2U, 3U}) {
    MapCheckpoints(folder_.path()).write(snapshots_[i]);
    folder_.write("checkpoint.map", "no map " + std::to_string(i));
    MapCheckpoints checkpoints(folder_.path());
    EXPECT_FALSE(checkpoints.resume([](const fs::path& path) { return read_map(path); }));
  }
  EXPECT_EQ(read_bytes(folder_ / "checkpoint.bad.map"), "no map 1");
  EXPECT_EQ(read_bytes(folder_ / "checkpoint.bad.3.map"), "no map 3");
  fs::remove(folder_ / "checkpoint.bad.map");
  const auto before = names(parts());
  MapCheckpoints checkpoints(folder_.path());
  checkpoints.write(snapshots_[0]);
  for (const std::string& part : before) EXPECT_TRUE(names(parts()).contains(part)) << part;
}

// The power goes while the last checkpoint is written: whatever of its files is cut, and wherever, it is gone
// on with that one or with the one before.
TEST_F(MapCheckpointsTest, CutAnywhereTheOneBeforeIsThere) {
  MapCheckpoints(folder_.path()).write(snapshots_[2]);
  const auto old = names(parts());
  MapCheckpoints(folder_.path()).write(snapshots_[3]);
  std::vector<std::string> written = {"checkpoint.map"};
  for (const std::string& part : names(parts()))
    if (!old.contains(part)) written.push_back("checkpoint.parts/" + part);
  ASSERT_GE(written.size(), 3U);
  const auto whole = encode_map(snapshots_[3]), before = encode_map(snapshots_[2]);
  for (const std::string& name : written) {
    const std::string bytes = read_bytes(folder_ / name);
    for (std::size_t cut = 0; cut <= 40; ++cut) {
      const ScratchFolder copy;
      fs::copy(folder_.path(), copy.path(),
               fs::copy_options::recursive | fs::copy_options::overwrite_existing);
      const std::size_t size = bytes.size() * cut / 40;
      fs::resize_file(copy / name, size);
      const auto resumed =
          MapCheckpoints(copy.path()).resume([](const fs::path& path) { return read_map(path); });
      ASSERT_TRUE(resumed) << name << " of " << size << " bytes";
      EXPECT_EQ(encode_map(*resumed), size == bytes.size() ? whole : before) << name << ": " << size;
    }
    // Its name is there already, its bytes are not.
    const ScratchFolder copy;
    fs::copy(folder_.path(), copy.path(), fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    copy.write(name, std::string(bytes.size(), '\0'));
    const auto resumed =
        MapCheckpoints(copy.path()).resume([](const fs::path& path) { return read_map(path); });
    ASSERT_TRUE(resumed) << name;
    EXPECT_EQ(encode_map(*resumed), before) << name;
  }
}

TEST_F(MapCheckpointsTest, PutAsideItIsOneFile) {
  MapCheckpoints checkpoints(folder_.path());
  checkpoints.write(snapshots_[2]);
  checkpoints.put_aside("is of yesterday");
  EXPECT_FALSE(fs::exists(newest()));
  EXPECT_EQ(read_bytes(folder_ / "checkpoint.old.map").size(), encode_map(snapshots_[2]).size());
  fs::remove_all(parts_folder(newest()));
  EXPECT_EQ(encode_map(read_map(folder_ / "checkpoint.old.map")), encode_map(snapshots_[2]));
}

}  // namespace
}  // namespace leadline::app
