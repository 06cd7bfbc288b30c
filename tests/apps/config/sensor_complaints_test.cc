#include "apps/config/sensor_complaints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "apps/config/config.h"
#include "apps/config/simulation.h"

namespace leadline::app {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> complaints_in_the_tank(std::vector<Setting> settings) {
  settings.push_back({"association.method", "known", "--set"});
  const Config config =
      read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "tank_0p1.yaml", settings);
  Slam slam(config.slam);
  for (const Instant& instant : simulate(config, 1).instants) slam.step(instant);
  return sensor_complaints(slam);
}

TEST(SensorComplaints, NoneOfSonarsThatAreAsTold) { EXPECT_THAT(complaints_in_the_tank({}), IsEmpty()); }

TEST(SensorComplaints, NameSensorValueAndKey) {
  EXPECT_THAT(complaints_in_the_tank({{"simulation.sonars.dropout", "0.4", "--set"}}),
              Contains(AllOf(HasSubstr("sensor port misses"), HasSubstr("not 5 %"),
                             HasSubstr("features.overlook_probability"))));
  EXPECT_THAT(
      complaints_in_the_tank({{"simulation.sonars.wall_roughness_m", "0.15", "--set"}}),
      Contains(AllOf(HasSubstr("walls scatter by 0.1"), HasSubstr("port"), HasSubstr("wall_roughness_m"))));
}

}  // namespace
}  // namespace leadline::app
