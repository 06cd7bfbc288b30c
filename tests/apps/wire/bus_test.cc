#include "apps/wire/bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace leadline::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using namespace std::chrono_literals;

Bytes bytes(const std::string& text) { return std::as_bytes(std::span(text)); }

// Listens to a bus within the process.
struct Listener {
  void listen(const std::string& prefix) {
    bus.subscribe(prefix, [this](std::string_view channel, Bytes data) {
      heard.push_back(std::string(channel) + ' ' +
                      std::string(reinterpret_cast<const char*>(data.data()), data.size()));
    });
  }

  Bus bus{std::make_unique<lcm::LCM>("memq://")};
  std::vector<std::string> heard;
};

TEST(Bus, HandsOutTheMessagesOfAPrefixInTheirOrder) {
  Listener listener;
  listener.listen("AUV_");
  EXPECT_TRUE(listener.bus.is_open());
  EXPECT_TRUE(listener.bus.publish("AUV_HEADING", bytes("1")));
  EXPECT_TRUE(listener.bus.publish("ROV_HEADING", bytes("foreign")));
  EXPECT_TRUE(listener.bus.publish("MY_AUV_HEADING", bytes("foreign")));
  EXPECT_TRUE(listener.bus.publish("AUV_SPEED", bytes("2")));
  EXPECT_TRUE(listener.bus.publish("AUV_", bytes("")));
  EXPECT_EQ(listener.bus.handle(0ms), 3);
  EXPECT_THAT(listener.heard, ElementsAre("AUV_HEADING 1", "AUV_SPEED 2", "AUV_ "));
}

TEST(Bus, TakesAPrefixLiterally) {
  Listener listener;
  listener.listen("A.(*)[+]$_");
  listener.bus.publish("A.(*)[+]$_X", bytes("1"));
  listener.bus.publish("AB(*)[+]$_X", bytes("2"));
  listener.bus.handle(0ms);
  EXPECT_THAT(listener.heard, ElementsAre("A.(*)[+]$_X 1"));
}

TEST(Bus, AnEmptyPrefixIsThatOfEveryChannel) {
  Listener listener;
  listener.listen("");
  listener.bus.publish("X", bytes("1"));
  EXPECT_EQ(listener.bus.handle(0ms), 1);
}

TEST(Bus, KeepsABurst) {
  Listener listener;
  listener.listen("AUV_");
  constexpr int kBurst = 5000;
  for (int i = 0; i < kBurst; ++i) listener.bus.publish("AUV_X", bytes(std::to_string(i)));
  int handled = 0;
  while (const int now = listener.bus.handle(0ms)) {
    EXPECT_LE(now, 1000);  // so that who keeps time gets to it
    handled += now;
  }
  EXPECT_EQ(handled, kBurst);
  EXPECT_EQ(listener.heard.back(), "AUV_X 4999");
}

TEST(Bus, HandsOutNoMoreOfALargeMessageThanShowsThatItIsTooLarge) {
  Bus bus(std::make_unique<lcm::LCM>("memq://"));
  std::size_t size = 0;
  bus.subscribe("X", [&](std::string_view, Bytes data) { size = data.size(); });
  bus.publish("X", bytes(std::string(300'000, 'x')));
  bus.handle(0ms);
  EXPECT_EQ(size, kMaxMessageSize + 1);
}

TEST(Bus, SurvivesAHandlerThatThrows) {
  Bus bus(std::make_unique<lcm::LCM>("memq://"));
  int calls = 0;
  bus.subscribe("AUV_", [&](std::string_view, Bytes) {
    ++calls;
    throw std::runtime_error("no use for it");
  });
  bus.publish("AUV_X", bytes("1"));
  bus.publish("AUV_X", bytes("2"));
  testing::internal::CaptureStderr();
  EXPECT_EQ(bus.handle(0ms), 2);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("AUV_X was not handled: no use for it"));
  EXPECT_EQ(calls, 2);
  EXPECT_TRUE(bus.is_open());
}

TEST(Bus, AHandlerMayPublish) {
  Listener listener;
  listener.bus.subscribe("QUESTION",
                         [&](std::string_view, Bytes) { listener.bus.publish("ANSWER", bytes("42")); });
  listener.listen("ANSWER");
  listener.bus.publish("QUESTION", bytes("?"));
  EXPECT_EQ(listener.bus.handle(0ms), 2);
  EXPECT_THAT(listener.heard, ElementsAre("ANSWER 42"));
}

TEST(Bus, WaitsAsLongAsAsked) {
  Bus open(std::make_unique<lcm::LCM>("memq://"));
  open.subscribe("AUV_", [](std::string_view, Bytes) {});
  Bus closed("udpm://239.255.76.67:7667?ttl=0");
  for (Bus* bus : {&open, &closed}) {
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_EQ(bus->handle(30ms), 0);
    EXPECT_GE(std::chrono::steady_clock::now() - begin, 29ms);
  }
}

TEST(Bus, SaysWhyItIsNotOpen) {
  testing::internal::CaptureStderr();  // LCM's own words
  for (const char* url : {"carrier_pigeon://", "udpm://no_address", "udpm", "udpm://1.2.3.4.5:7667"}) {
    Bus bus(url);
    EXPECT_THAT(bus.trouble(), HasSubstr(url));
    EXPECT_FALSE(bus.open()) << url;
    EXPECT_FALSE(bus.is_open());
    EXPECT_THAT(bus.trouble(), HasSubstr(url));
    EXPECT_FALSE(bus.publish("AUV_X", bytes("1")));
  }
  Bus bad(std::make_unique<lcm::LCM>("carrier_pigeon://"));
  EXPECT_FALSE(bad.is_open());
  EXPECT_FALSE(bad.open());
  EXPECT_THAT(bad.trouble(), Not(IsEmpty()));
  testing::internal::GetCapturedStderr();
}

TEST(Bus, KeepsItsSubscriptionsWhenItOpens) {
  Bus bus("memq://");
  int calls = 0;
  bus.subscribe("AUV_", [&](std::string_view, Bytes) { ++calls; });
  ASSERT_TRUE(bus.open());
  EXPECT_THAT(bus.trouble(), IsEmpty());
  bus.subscribe("ROV_", [&](std::string_view, Bytes) { ++calls; });
  bus.publish("AUV_X", bytes("1"));
  bus.publish("ROV_X", bytes("1"));
  EXPECT_EQ(bus.handle(0ms), 2);
  EXPECT_EQ(calls, 2);
}

}  // namespace
}  // namespace leadline::app
