#include "apps/node/sim_node.h"
#include "apps/config/simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "apps/recordings/log.h"
#include "apps/wire/event_log.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::Not;
using namespace std::chrono_literals;

constexpr std::int64_t kEpoch = 1'700'000'000'000'000;

Config config(const std::string& name, const std::vector<Setting>& settings = {}) {
  return read_config(std::string(LEADLINE_SOURCE_DIR "/configs/") + name, settings);
}

Config tank(const std::string& duration) {
  return config("tank_long.yaml",
                {{"simulation.duration_s", duration, "--set"}, {"simulation.tank.objects", "2", "--set"}});
}

std::vector<Event> run(const Config& config, std::int64_t epoch) {
  SimulatedVehicle vehicle(config);
  std::vector<Event> events;
  while (const auto instant = vehicle.next())
    std::ranges::move(vehicle.encode(*instant, epoch), std::back_inserter(events));
  return events;
}

// Channel and bytes.
std::string text(std::string_view channel, Bytes data) {
  return std::string(channel) + ' ' + std::string(reinterpret_cast<const char*>(data.data()), data.size());
}

std::vector<std::string> texts(const std::vector<Event>& events) {
  std::vector<std::string> texts;
  texts.reserve(events.size());
  for (const Event& event : events) texts.push_back(text(event.channel, event.data));
  return texts;
}

bool is_map(const Event& event) { return event.channel == "AUV_TRUTH_MAP"; }

// Times of the messages with the true map [s].
std::vector<double> map_times(const std::vector<Event>& events) {
  std::vector<double> times;
  for (const Event& event : events)
    if (is_map(event)) times.push_back(static_cast<double>(event.utime) * 1e-6);
  return times;
}

void expect_events_of_the_log(const Config& config) {
  const ScratchFolder folder;
  write_log(simulate(config, config.seed), config.slam.sensors, folder / "a.lcmlog", config.channel_prefix);
  std::vector<std::string> logged;
  for (EventLogReader event(folder / "a.lcmlog"); event.next();)
    logged.push_back(text(event.channel(), event.data()));

  std::vector<Event> sent = run(config, 0);
  const auto first_map = std::ranges::find_if(sent, is_map);
  ASSERT_NE(first_map, sent.end());
  sent.erase(std::remove_if(first_map + 1, sent.end(), is_map), sent.end());
  EXPECT_THAT(texts(sent), ElementsAreArray(logged));
}

TEST(SimulatedVehicle, SaysInTheTankWhatTheLogOfTheSameRunSays) { expect_events_of_the_log(tank("25")); }

TEST(SimulatedVehicle, SaysInTheFieldWhatTheLogOfTheSameRunSays) {
  expect_events_of_the_log(config("field_50.yaml", {{"simulation.field.steps", "25", "--set"}}));
}

TEST(SimulatedVehicle, IsRepeatable) {
  const Config same = tank("5");
  Config other = same;
  ++other.seed;
  EXPECT_THAT(texts(run(same, kEpoch)), ElementsAreArray(texts(run(same, kEpoch))));
  EXPECT_THAT(texts(run(same, kEpoch)), Not(ElementsAreArray(texts(run(other, kEpoch)))));
}

TEST(SimulatedVehicle, MessagesOfAnInstantHaveItsTimeAndAnOrder) {
  SimulatedVehicle vehicle(tank("5"));
  std::vector<std::string> channels;
  const auto instant = vehicle.next();
  ASSERT_TRUE(instant);
  for (const Event& event : vehicle.encode(*instant, kEpoch)) {
    EXPECT_EQ(event.utime, kEpoch);
    channels.push_back(event.channel);
  }
  EXPECT_THAT(channels, ElementsAre("AUV_HEADING", "AUV_SPEED", "AUV_RANGE_SONAR", "AUV_RANGE_SONAR",
                                    "AUV_RANGE_SONAR", "AUV_TRUTH", "AUV_TRUTH_MAP"));
}

TEST(SimulatedVehicle, RepeatsTheMapEveryTenSeconds) {
  EXPECT_THAT(map_times(run(tank("25"), 0)), ElementsAre(0, 10, 20));
}

TEST(SimulatedVehicle, SendsALargeMapInPartsOneAnInstant) {
  const Config field = config("field_50.yaml", {{"simulation.field.landmarks", "3000", "--set"},
                                                {"simulation.field.steps", "20", "--set"}});
  EXPECT_THAT(map_times(run(field, 0)), ElementsAre(0, 1, 2, 10, 11, 12, 20));
}

TEST(SimulatedVehicle, RefusesAConfigurationWithoutAWorld) {
  EXPECT_THAT(error_of<std::runtime_error>([] { SimulatedVehicle vehicle(config("car_park.yaml")); }),
              HasSubstr("car_park simulates nothing"));
}

TEST(SimNode, PublishesAtTheSpeedAsked) {
  const Config config = tank("2");
  SimulatedVehicle vehicle(config);
  Bus bus(std::make_unique<lcm::LCM>("memq://"));
  std::vector<std::string> channels;
  bus.subscribe("AUV_", [&](std::string_view channel, Bytes) { channels.emplace_back(channel); });
  const auto begin = std::chrono::steady_clock::now();
  const Pace pace = publish_in_time(vehicle, bus, kEpoch, 20.0, 2.0);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 100ms);
  EXPECT_EQ(pace.unsent, 0);
  bus.handle(0ms);
  EXPECT_EQ(channels.size(), run(config, kEpoch).size());
}

TEST(SimNode, SaysThatItFellBehindAndWhatWasNotSent) {
  SimulatedVehicle vehicle(tank("2"));
  Bus nowhere("carrier_pigeon://");
  testing::internal::CaptureStderr();  // LCM's own words
  const Pace pace = publish_in_time(vehicle, nowhere, kEpoch, 1e6, 2.0);
  testing::internal::GetCapturedStderr();
  EXPECT_THAT(pace.behind, Gt(0.0));
  EXPECT_EQ(pace.unsent, static_cast<std::int64_t>(run(tank("2"), 0).size()));
}

}  // namespace
}  // namespace leadline::app
