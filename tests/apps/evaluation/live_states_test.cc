#include "apps/evaluation/live_states.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "apps/wire/estimates.h"
#include "apps/wire/event_log.h"
#include "apps/wire/messages.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

VehicleState state_at(std::int64_t utime) {
  VehicleState state;
  state.utime = utime;
  state.pose = {0.1 * static_cast<double>(utime), 2.0, 0.3};
  state.P = Eigen::Matrix3d::Identity();
  return state;
}

vehicle_state_t published(std::int64_t utime, double dx = 0.0) {
  const VehicleState state = state_at(utime);
  vehicle_state_t message{};
  message.utime = utime;
  message.x = state.pose.x + dx;
  message.y = state.pose.y;
  message.heading = state.pose.heading;
  put_covariance(state.P, message.cov);
  put_covariance(state.P, message.local_cov);
  return message;
}

LiveComparison compared(const std::vector<vehicle_state_t>& live, const std::vector<std::int64_t>& times) {
  const ScratchFolder folder;
  EventLogWriter log(folder / "mission.lcmlog");
  log.write(0, "AUV_SPEED", encode(speed_t{0, 0, 1.0, 0.0}));
  for (const vehicle_state_t& state : live) log.write(state.utime, "AUV_STATE", encode(state));
  log.commit();
  Spool<VehicleState> states;
  for (const std::int64_t utime : times) states.push_back(state_at(utime));
  return compare_with_live(folder / "mission.lcmlog", "AUV_", states);
}

TEST(LiveStates, AreComparedAtTheTimesOfTheRun) {
  const LiveComparison comparison =
      compared({published(1), published(2, 0.5), published(3), published(7)}, {1, 2, 4, 7, 9});
  EXPECT_EQ(comparison.published, 4U);
  EXPECT_EQ(comparison.compared, 3U);
  EXPECT_EQ(comparison.equal, 2U);
  EXPECT_NEAR(comparison.max_distance, 0.5, 1e-12);
}

// After a reset a node may come to times that it has been at.
TEST(LiveStates, TheLastOfATimeCountsInWhateverOrderTheyCome) {
  const LiveComparison comparison = compared(
      {published(1), published(5, 1.0), published(6), published(5), published(2), published(6, 0.25)},
      {1, 2, 5, 6});
  EXPECT_EQ(comparison.published, 6U);
  EXPECT_EQ(comparison.compared, 4U);
  EXPECT_EQ(comparison.equal, 3U);
  EXPECT_NEAR(comparison.max_distance, 0.25, 1e-12);
}

TEST(LiveStates, ThereMayBeNone) {
  EXPECT_EQ(compared({}, {1, 2}).published, 0U);
  EXPECT_EQ(compared({published(3)}, {}).compared, 0U);
}

}  // namespace
}  // namespace leadline::app
