// Logs that do not fit into memory.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/recordings/log.h"
#include "tests/support/random.h"
#include "tests/support/sanitizer.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

constexpr std::int64_t kTenth = 100'000;  // [us]

/// Up and down between two walls, which sonars on both sides see; ten instants a second with the truth of
/// each.
class EndlessTank : public RecordingSource {
 public:
  explicit EndlessTank(std::size_t instants) : wanted_(instants) {
    for (const char* name : {"port", "starboard"}) sensors_.emplace_back().name = name;
  }

  std::optional<Instant> next_instant() override {
    if (instants_ == wanted_) return std::nullopt;
    Instant instant;
    instant.utime = kTenth * static_cast<std::int64_t>(++instants_);
    instant.heading = Reading{random_.normal(0.017), 0.0};
    instant.speed = Reading{0.2 * std::sin(phase(instant.utime)), 0.0};
    const double port = 1.5 + random_.normal(0.05), starboard = 1.5 + random_.normal(0.05);
    instant.sightings = {{.sensor = 0, .range = port}, {.sensor = 1, .range = starboard}};
    return instant;
  }
  std::optional<Truth> next_truth() override {
    if (truth_ == wanted_) return std::nullopt;
    Truth truth;
    truth.utime = kTenth * static_cast<std::int64_t>(++truth_);
    truth.x = 2.0 * (1.0 - std::cos(phase(truth.utime)));
    truth.heading = 0.0;
    return truth;
  }
  std::span<const TrueFeature> map() const override { return {}; }
  std::span<const Sensor> sensors() const override { return sensors_; }

 private:
  static double phase(std::int64_t utime) { return 1e-7 * static_cast<double>(utime); }

  std::size_t wanted_, instants_ = 0, truth_ = 0;
  std::vector<Sensor> sensors_;
  Random random_{1};
};

class LongLogTest : public testing::Test {
 protected:
  /// @return whether a run needs no more than so much memory of its own [MB].
  bool runs_within(int megabytes, const std::string& options) const {
    const std::string line = fmt::format(
        "cd '{}' && ulimit -d {} && '{}' run '{}/configs/tank_0p3.yaml' {} >out.txt 2>err.txt",
        folder_.path().string(), 1000 * megabytes, LEADLINE_COMMAND, LEADLINE_SOURCE_DIR, options);
    const int status = std::system(line.c_str());
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }
  std::string complaint() const { return read_bytes(folder_ / "err.txt"); }

  const ScratchFolder folder_;
};

// What is kept of an instant is 8 bytes while the log is read and 16 in the end; the rest does not grow.
TEST_F(LongLogTest, IsRunInLittleMemory) {
  if (LEADLINE_SANITIZER) GTEST_SKIP() << "a sanitizer has memory of its own";
  EndlessTank tank(200'000);
  write_log(tank, folder_ / "long.lcmlog");
  EXPECT_TRUE(runs_within(48, "--log long.lcmlog")) << complaint();
  EXPECT_TRUE(runs_within(72, "--log long.lcmlog -o results")) << complaint();
  EXPECT_LT(std::filesystem::file_size(folder_ / "results/report.html"), 4'000'000U);
  EXPECT_FALSE(runs_within(8, "--log long.lcmlog")) << "the limit is none";
}

}  // namespace
}  // namespace leadline::app
