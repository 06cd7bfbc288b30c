#include "apps/evaluation/live_states.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <leadline/vehicle_state_t.hpp>
#include <optional>
#include <variant>

#include "apps/recordings/time_order.h"
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

/// Goes through the states that were published.
class LivePass {
 public:
  LivePass(const std::filesystem::path& log, std::string_view prefix)
      : channel_(std::string(prefix) + std::string(message_format<vehicle_state_t>().channel)), event_(log) {}

  std::optional<vehicle_state_t> next() {
    while (event_.next()) {
      if (event_.channel() != channel_) continue;
      auto received = receive<vehicle_state_t>(event_.data());
      if (auto* state = std::get_if<vehicle_state_t>(&received)) return *state;
    }
    return std::nullopt;
  }

 private:
  std::string channel_;
  EventLogReader event_;
};

}  // namespace

LiveComparison compare_with_live(const std::filesystem::path& log, std::string_view prefix,
                                 const Spool<VehicleState>& states) {
  LiveComparison comparison;
  Lateness lateness;
  LivePass survey(log, prefix);
  while (const auto published = survey.next()) {
    ++comparison.published;
    lateness.add(published->utime);
  }
  if (comparison.published == 0) return comparison;

  LivePass pass(log, prefix);
  TimeOrder<vehicle_state_t> order(lateness.most(), [](vehicle_state_t& state, const vehicle_state_t& later) {
    state = later;
    return true;
  });
  const auto next = [&] {
    for (bool ended = false;;) {
      if (auto state = order.next(ended); state || ended) return state;
      if (auto published = pass.next())
        order.add(*published);
      else
        ended = true;
    }
  };
  std::optional<vehicle_state_t> live = next();
  for (const VehicleState& state : states) {
    while (live && live->utime < state.utime) live = next();
    if (!live) break;
    if (live->utime != state.utime) continue;
    ++comparison.compared;
    comparison.equal += equal(*live, state);
    comparison.max_distance =
        std::max(comparison.max_distance, std::hypot(live->x - state.pose.x, live->y - state.pose.y));
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
