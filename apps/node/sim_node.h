/// @file
/// The simulated vehicle on the LCM network: its sensors and its truth, as time goes by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "apps/wire/bus.h"
#include "apps/wire/event_encoder.h"
#include "leadline/sonar_sim/simulated_instant.h"

namespace leadline::app {

/// What the configured world has to say, an instant at a time: the events that write_log() makes of the same
/// run. Only the true map comes again every 10 s, for late listeners, and a large one in parts, one an
/// instant.
class SimulatedVehicle {
 public:
  /// @throws std::runtime_error if there is no world, or it cannot be made.
  explicit SimulatedVehicle(const Config& config);

  /// The next instant; empty when the run is over.
  std::optional<SimulatedInstant> next();

  /// Its messages: motion, heading, speed, sensors, truth and, when it is due, the true map. All have the
  /// time stamp @p epoch [us] plus that of the instant.
  std::vector<Event> encode(SimulatedInstant instant, std::int64_t epoch);

  const std::vector<TrueFeature>& map() const { return map_; }

  /// Messages encoded so far.
  const StreamCounter& counter() const { return encoder_.counter(); }

 private:
  std::vector<TrueFeature> map_due(std::int64_t time, std::int64_t epoch);

  std::vector<Sensor> sensors_;
  Simulator simulator_;
  std::vector<TrueFeature> map_;
  std::size_t map_sent_ = 0;   // features
  std::int64_t map_time_ = 0;  // [us], when it is to be sent again
  EventEncoder encoder_;
};

/// Opens the bus, trying once a second and saying why that takes so long. @return false if a signal comes
/// first.
bool open_patiently(Bus& bus);

/// How publishing went.
struct Pace {
  double behind = 0.0;      ///< [s], the longest that an instant was late
  std::int64_t unsent = 0;  ///< messages that found no network
};

/// Publishes @p vehicle from @p epoch [us] on, @p speed times as fast as in reality, until the run is over or
/// a signal comes. Messages are due at absolute times, so that delays do not add up. What cannot be sent is
/// lost, as in reality; the bus is opened again once a second.
/// @param duration [s], simulated, for the progress bar.
Pace publish_in_time(SimulatedVehicle& vehicle, Bus& bus, std::int64_t epoch, double speed, double duration);

}  // namespace leadline::app
