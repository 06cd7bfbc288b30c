#include "apps/support/spool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>

#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Piece {
  std::uint64_t number = 0;
  double half = 0.0;
  char rest[1000] = {};
};

Piece piece(std::uint64_t number) { return {number, 0.5 * static_cast<double>(number), {}}; }

constexpr std::size_t kPieces = 3 * Spool<Piece>::kBlock + 5;

Spool<Piece> pieces() {
  Spool<Piece> spool;
  for (std::size_t i = 0; i < kPieces; ++i) spool.push_back(piece(i));
  return spool;
}

/// TMPDIR is another folder for as long as this lives.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const std::string& name) {
    if (const char* before = std::getenv("TMPDIR")) before_ = before;
    setenv("TMPDIR", name.c_str(), 1);
  }
  ~TemporaryFolder() {
    if (before_.empty())
      unsetenv("TMPDIR");
    else
      setenv("TMPDIR", before_.c_str(), 1);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

 private:
  std::string before_;
};

TEST(Spool, GivesBackWhatItWasGivenAgainAndAgain) {
  const Spool<Piece> spool = pieces();
  ASSERT_EQ(spool.size(), kPieces);
  for (int time = 0; time < 2; ++time) {
    std::size_t i = 0;
    for (const Piece& found : spool) {
      ASSERT_EQ(found.number, i);
      ASSERT_EQ(found.half, 0.5 * static_cast<double>(i++));
    }
    EXPECT_EQ(i, kPieces);
  }
}

TEST(Spool, IsReadAtAnyPlaceWhileItGrows) {
  Spool<Piece> spool = pieces();
  for (std::size_t step = 0; step < 2000; ++step) {
    const std::size_t i = step * 7919 % spool.size();
    ASSERT_EQ(spool[i].number, i);
    spool.push_back(piece(spool.size()));
  }
  EXPECT_EQ(spool.front().number, 0U);
  EXPECT_EQ(spool.back().number, kPieces + 1999);
}

TEST(Spool, TheLastItemMayBeChanged) {
  Spool<Piece> spool;
  for (std::size_t i = 0; i < Spool<Piece>::kBlock; ++i) spool.push_back(piece(i));
  spool.back().half = 7.0;
  spool.push_back(piece(0));
  EXPECT_EQ(spool[Spool<Piece>::kBlock - 1].half, 7.0);
}

TEST(Spool, MovesWithItsFile) {
  Spool<Piece> first = pieces();
  const Spool<Piece> second = std::move(first);
  EXPECT_EQ(second[3].number, 3U);
  EXPECT_EQ(second.size(), kPieces);
}

TEST(Spool, OfAFewIsAnOrdinarySequence) {
  const TemporaryFolder nowhere("/nowhere");
  const Spool<int> spool{3, 1, 2};
  EXPECT_THAT(spool, ElementsAre(3, 1, 2));
  EXPECT_TRUE(Spool<int>().empty());
  EXPECT_EQ(Spool<int>().begin(), Spool<int>().end());
}

TEST(Spool, LeavesNothingBehindAndNothingToBeSeen) {
  const ScratchFolder folder;
  const TemporaryFolder here(folder.path().string());
  const Spool<Piece> spool = pieces();
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  EXPECT_EQ(spool[0].number, 0U);
}

TEST(Spool, NamesAFolderThatHasNoRoom) {
  const TemporaryFolder nowhere("/nowhere");
  try {
    pieces();
    ADD_FAILURE() << "written nowhere";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nowhere: cannot keep there"));
    EXPECT_THAT(error.what(), HasSubstr("No such file or directory (TMPDIR names another folder)"));
  }
}

}  // namespace
}  // namespace leadline::app
