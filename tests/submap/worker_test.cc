#include "submap/src/worker.h"

#include <gtest/gtest.h>

#include <vector>

namespace leadline {
namespace {

TEST(WorkerTest, DoesWhatItIsAskedForAsOftenAndInOrder) {
  std::vector<int> given(1000), taken;
  std::size_t next = 0;
  Worker worker([&] { taken.push_back(given[next++]); });
  worker.wait();  // nothing was asked for
  for (int i = 0; i < 1000; ++i) {
    given[static_cast<std::size_t>(i)] = i;
    worker.ask();
    if (i % 100 != 0) continue;
    worker.wait();
    ASSERT_EQ(taken.size(), static_cast<std::size_t>(i + 1));
  }
  worker.wait();
  EXPECT_EQ(taken, given);
}

TEST(WorkerTest, EndsWhenAllIsDone) {
  int done = 0;
  {
    Worker worker([&] { ++done; });
    for (int i = 0; i < 50; ++i) worker.ask();
  }
  EXPECT_EQ(done, 50);
  {
    const Worker idle([&] { ++done; });
  }
  EXPECT_EQ(done, 50);
}

}  // namespace
}  // namespace leadline
