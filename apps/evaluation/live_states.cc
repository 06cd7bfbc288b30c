#include "apps/evaluation/live_states.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <variant>

#include "apps/wire/estimates.h"
#include "apps/wire/event_log.h"
#include "apps/wire/messages.h"

namespace leadline::app {
namespace {

bool equal(const vehicle_state_t& live, const VehicleState& state) {
  vehicle_state_t estimated{};
  put_covariance(state.P, estimated.cov);
  return live.x == state.pose.x && live.y == state.pose.y && live.heading == state.pose.heading &&
         std::ranges::equal(live.cov, estimated.cov);
}

}  // namespace

std::vector<vehicle_state_t> read_live_states(const std::filesystem::path& path, std::string_view prefix) {
  const std::string channel = std::string(prefix) + std::string(message_format<vehicle_state_t>().channel);
  std::vector<vehicle_state_t> states;
  EventLogReader event(path);
  while (event.next()) {
    if (event.channel() != channel) continue;
    auto received = receive<vehicle_state_t>(event.data());
    if (auto* state = std::get_if<vehicle_state_t>(&received)) states.push_back(*state);
  }
  return states;
}

LiveComparison compare_with_live(std::span<const vehicle_state_t> live,
                                 std::span<const VehicleState> states) {
  std::map<std::int64_t, const vehicle_state_t*> by_time;
  for (const vehicle_state_t& state : live) by_time[state.utime] = &state;
  LiveComparison comparison{.published = live.size()};
  for (const VehicleState& state : states) {
    const auto found = by_time.find(state.utime);
    if (found == by_time.end()) continue;
    const vehicle_state_t& published = *found->second;
    ++comparison.compared;
    comparison.equal += equal(published, state);
    comparison.max_distance =
        std::max(comparison.max_distance, std::hypot(published.x - state.pose.x, published.y - state.pose.y));
  }
  return comparison;
}

std::string LiveComparison::text() const {
  return fmt::format(
      "published live: {} states; {} of them at times of this run, {} equal to the last bit, the others at "
      "most {:.3g} m away",
      published, compared, equal, max_distance);
}

}  // namespace leadline::app
