#include "apps/support/interrupt.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <thread>

namespace leadline::app {
namespace {

/// Whether another thread notes @p signal.
[[noreturn]] void exit_telling(int signal) {
  catch_interrupts();
  bool before = true, after = false;
  std::thread([&] { before = interrupted(); }).join();
  std::raise(signal);
  std::thread([&] { after = interrupted(); }).join();
  std::exit(!before && after ? 0 : 1);
}

TEST(InterruptDeathTest, EveryThreadSeesTheSignal) {
  EXPECT_EXIT(exit_telling(SIGINT), ::testing::ExitedWithCode(0), "");
  EXPECT_EXIT(exit_telling(SIGTERM), ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace leadline::app
