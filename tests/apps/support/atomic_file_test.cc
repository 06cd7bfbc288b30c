#include "apps/support/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <string_view>
#include <system_error>
#include <vector>

#include "apps/results/result_folder.h"
#include "tests/support/scratch_folder.h"

namespace {

/// A folder whose names went to the disk, and what they were.
struct SyncedFolder {
  std::filesystem::path path;
  std::vector<std::string> names;
};
std::vector<SyncedFolder>* synced_folders = nullptr;

}  // namespace

/// Stands in for the C library's in this program.
extern "C" int fsync(int descriptor) {
  const auto path = std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(descriptor));
  if (synced_folders != nullptr && std::filesystem::is_directory(path)) {
    SyncedFolder folder{path, {}};
    for (const auto& entry : std::filesystem::directory_iterator(path))
      folder.names.push_back(entry.path().filename());
    synced_folders->push_back(folder);
  }
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}

namespace leadline::app {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class AtomicFileTest : public ::testing::Test {
 protected:
  AtomicFileTest() { synced_folders = &synced_; }
  ~AtomicFileTest() override { synced_folders = nullptr; }

  ScratchFolder scratch_;
  std::vector<SyncedFolder> synced_;
};

void write_file(const std::filesystem::path& path, std::string_view text) {
  AtomicFile file(path);
  file.write(std::as_bytes(std::span(text)));
  file.commit();
}

TEST_F(AtomicFileTest, IsThereCompleteAndNothingBesides) {
  const auto path = scratch_.write("map", "old");
  write_file(path, "new");
  EXPECT_EQ(read_bytes(path), "new");
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "map.part"));
}

TEST_F(AtomicFileTest, WithoutCommitAllIsAsItWas) {
  const auto path = scratch_.write("map", "old");
  AtomicFile(path).write({});
  EXPECT_EQ(read_bytes(path), "old");
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "map.part"));
}

TEST_F(AtomicFileTest, ItsNameIsOnTheDiskToo) {
  write_file(scratch_ / "map", "new");
  ASSERT_EQ(synced_.size(), 1U);
  EXPECT_TRUE(std::filesystem::equivalent(synced_[0].path, scratch_.path()));
  EXPECT_THAT(synced_[0].names, ElementsAre("map"));
}

TEST_F(AtomicFileTest, ANameWithoutFolderIsOneOfTheFolderInUse) {
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(scratch_.path());
  write_file("map", "new");
  std::filesystem::current_path(before);
  ASSERT_EQ(synced_.size(), 1U);
  EXPECT_TRUE(std::filesystem::equivalent(synced_[0].path, scratch_.path()));
}

TEST_F(AtomicFileTest, AFileThatCannotTakeItsPlaceLeavesNothing) {
  std::filesystem::create_directory(scratch_ / "map");
  scratch_.write("map/inside", "");
  EXPECT_THAT(error_of<std::runtime_error>([&] { write_file(scratch_ / "map", "new"); }),
              HasSubstr("map: cannot write: "));
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "map.part"));
  EXPECT_THAT(synced_, IsEmpty());
}

TEST_F(AtomicFileTest, AFolderThatIsNotThereCannotBeSynced) {
  EXPECT_THROW(sync_folder(scratch_ / "missing"), std::system_error);
}

// Names of folders that were missing above the result are on the disk as well.
TEST_F(AtomicFileTest, SoAreTheNamesOfAResultFolder) {
  ResultFolder folder(scratch_ / "above/result", false);
  synced_.clear();
  folder.commit();
  ASSERT_EQ(synced_.size(), 2U);
  EXPECT_TRUE(std::filesystem::equivalent(synced_[0].path, scratch_.path()));
  EXPECT_THAT(synced_[0].names, Contains("above"));
  EXPECT_TRUE(std::filesystem::equivalent(synced_[1].path, scratch_ / "above"));
  EXPECT_THAT(synced_[1].names, Contains("result"));
}

}  // namespace
}  // namespace leadline::app
