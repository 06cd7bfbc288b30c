// Whatever the configuration allows gives a run or a clear error: no crash, no number that is none.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <ostream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/config/config.h"
#include "apps/config/config_keys.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/run.h"
#include "apps/keys/units.h"

namespace leadline::app {
namespace {

/// Gives one key in twenty another allowed value, often a limit.
class Shaker final : public OptionVisitor {
 public:
  explicit Shaker(unsigned seed) : random_(seed) {}

  void number(std::string_view name, double& value, Limits allowed, const OptionText& text) override {
    if (!chosen(name)) return;
    value = from_unit(draw(allowed), text.unit);
    note(name, in_unit(value, text.unit));
  }
  void whole_number(std::string_view name, std::int64_t& value, Limits allowed, const OptionText&) override {
    if (!chosen(name)) return;
    value = std::llround(draw(allowed));
    note(name, value);
  }
  void flag(std::string_view name, bool& value, const OptionText&) override {
    if (!chosen(name)) return;
    value = !value;
    note(name, value);
  }
  void word(std::string_view, std::string&, Limits, const OptionText&) override {}
  void one_of(std::string_view name, std::size_t& index, std::span<const std::string_view> options,
              const OptionText&) override {
    if (!chosen(name)) return;
    index = random_() % options.size();
    note(name, options[index]);
  }
  void section(std::string_view, std::string_view, const std::function<void()>& body) override { body(); }
  void sections(std::string_view, std::string_view, std::size_t size, const std::function<void(std::size_t)>&,
                const std::function<void(std::size_t)>& body) override {
    for (std::size_t i = 0; i < size; ++i) body(i);
  }
  void only(std::string_view, bool holds, const std::function<void()>& body) override {
    if (holds) body();
  }
  void alternative(std::string_view, bool in_use, const std::function<void()>& body) override {
    if (in_use) body();
  }
  void defaults(const std::function<void()>&, std::span<const DefaultText>) override {}
  void require(bool holds, std::string_view, std::string_view) override { sound_ = sound_ && holds; }

  bool sound() const { return sound_; }
  const std::string& changes() const { return changes_; }

 private:
  template <class T>
  void note(std::string_view name, const T& value) {
    changes_ += fmt::format(" {}={}", name, value);
  }
  bool chosen(std::string_view name) {
    // What takes long or much memory, and what makes another world of it.
    for (const char* kept : {"duration_s", "steps", "rate_hz", "landmarks", "objects", "piles", "capacity",
                             "world", "kind", "clutter", "physics_step_s"})
      if (name == kept) return false;
    return random_() % 20 == 0;
  }
  double draw(Limits allowed) {
    switch (random_() % 4) {
      case 0:
        return allowed.min;
      case 1:
        return allowed.max;
      case 2:
        return std::clamp(std::exp(std::normal_distribution(0.0, 5.0)(random_)), allowed.min, allowed.max);
      default:
        return std::uniform_real_distribution(allowed.min, allowed.max)(random_);
    }
  }

  std::mt19937_64 random_;
  bool sound_ = true;
  std::string changes_;
};

struct World {
  const char* name;
  const char* file;
  std::vector<Setting> settings;
};

void PrintTo(const World& world, std::ostream* out) { *out << world.name; }

class ConfigLimitsTest : public testing::TestWithParam<World> {};

TEST_P(ConfigLimitsTest, AllowedValuesGiveFiniteEstimates) {
  const Config shipped = read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / GetParam().file,
                                     GetParam().settings);
  int runs = 0;
  std::size_t submaps = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Config config = shipped;
    config.tank.duration = 20.0;
    config.field.steps = 80;
    Shaker shaker(seed);
    declare(shaker, config);
    if (!shaker.sound()) continue;  // keys that contradict each other: refused when read
    SCOPED_TRACE("seed " + std::to_string(seed) + shaker.changes());
    Recording recording;
    try {
      recording = simulate(config, 1);
    } catch (const std::runtime_error&) {
      continue;  // a world that cannot be
    }
    const RunTrace trace = run(config.slam, recording, {3, seed % 2 == 0, {}});
    ++runs;
    submaps = std::max(submaps, trace.submaps.size());
    for (const VehicleState& s : trace.states) {
      ASSERT_TRUE(std::isfinite(s.pose.x) && std::isfinite(s.pose.y) && std::isfinite(s.pose.heading));
      ASSERT_TRUE(s.P.allFinite());
      ASSERT_GE(s.P.diagonal().minCoeff(), -1e-9 * (1.0 + s.P.trace()));
    }
    for (const SubmapState& s : trace.submaps) {
      ASSERT_TRUE(std::isfinite(s.pose.X.x) && std::isfinite(s.pose.X.y) && std::isfinite(s.pose.X.heading));
      ASSERT_TRUE(s.centre.allFinite() && s.pose.P.allFinite());
    }
    for (const MapFeature& f : trace.map) {
      ASSERT_TRUE(f.position.allFinite() && f.P.allFinite());
      ASSERT_TRUE(std::isfinite(f.line.rho) && std::isfinite(f.line.alpha));
    }
    judge(trace, recording, config.truth_frame);
  }
  EXPECT_GT(runs, 30);
  EXPECT_GT(submaps, shipped.map == Map::submaps ? 3U : 0U);
}

INSTANTIATE_TEST_SUITE_P(Worlds, ConfigLimitsTest,
                         testing::Values(World{"tank", "tank_0p1.yaml", {{"map.radius_m", "0.3", ""}}},
                                         World{"tank_laps",
                                               "tank_long.yaml",
                                               {{"simulation.trajectory.circuit_length_m", "2", ""},
                                                {"simulation.tank.objects", "4", ""},
                                                {"map.radius_m", "0.5", ""}}},
                                         World{"field", "field_50.yaml", {}},
                                         World{"field_laps",
                                               "field_400.yaml",
                                               {{"simulation.field.landmarks", "12", ""},
                                                {"simulation.field.margin_m", "3", ""},
                                                {"map.radius_m", "1", ""}}}),
                         [](const auto& world) { return std::string(world.param.name); });

}  // namespace
}  // namespace leadline::app
