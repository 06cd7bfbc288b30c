/// @file
/// A field of point landmarks, seen by a range-bearing sensor on a vehicle with odometry and, unless asked
/// for, no heading reference: the world in which SLAM libraries are usually compared.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/sonar_sim/lawn_mower.h"
#include "leadline/sonar_sim/navigation_sensors.h"
#include "leadline/sonar_sim/noise.h"
#include "leadline/sonar_sim/point_grid.h"
#include "leadline/sonar_sim/simulated_instant.h"
#include "leadline/sonar_sim/world_change.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// The vehicle starts at the origin of W with heading 0. The field is a square of landmarks / density m^2,
/// the path keeps `margin` away from its edges.
struct FieldOptions {
  std::int64_t epoch = 0;      ///< [us], utime of the beginning
  std::int64_t steps = 10000;  ///< increments of odometry; one instant more than that
  double step_length = 0.5;    ///< [m], along the path
  double step_time = 1.0;      ///< [s]

  int landmarks = 50;
  double density = 0.12;      ///< [1/m^2]
  double margin = 2.0;        ///< [m]
  double lane_spacing = 4.0;  ///< [m], at most
  double turn_radius = 1.0;   ///< [m]
  std::vector<WorldChange> changes;

  double odometry_sigma = 0.02;                       ///< [m], each of dx and dy, per increment
  double odometry_heading_sigma = from_degrees(0.5);  ///< [rad], per increment

  /// Reads at every step, whatever its rate; 0: there is none.
  HeadingSensorOptions heading{.rate = 0.0};

  double min_range = 0.3;                    ///< [m]; nearer landmarks are not seen
  double max_range = 4.0;                    ///< [m]; farther ones neither; both true ranges
  double field_of_view = 2.0 * kPi;          ///< [rad], full angle about the x axis of the body
  double range_sigma = 0.1;                  ///< [m]
  double bearing_sigma = from_degrees(1.5);  ///< [rad]
  double dropout = 0.0;                      ///< probability that a landmark in view is not seen
  double clutter = 0.0;                      ///< mean number of sightings of nothing a step, anywhere in view
  double wrong_label = 0.0;                  ///< probability that a sighting has another landmark's label
  std::int64_t world_seed = 0;               ///< of where landmarks stand; 0: that of the noise
};

void visit(OptionVisitor& visitor, FieldOptions& options);

/// @throws std::invalid_argument "name is value, must be allowed", as OptionChecker does. Names are those of
/// the configuration, in its section simulation.
void validate(const FieldOptions& options);

/// Simulates the field, one instant a call. Equal options and seeds give equal instants.
class FieldSimulator {
 public:
  /// @throws std::invalid_argument as validate() does.
  FieldSimulator(const FieldOptions& options, std::uint64_t seed);

  /// The next instant: sightings, labelled, in the order of labels, then those of nothing, a heading if there
  /// is a sensor, and the increment since the instant before. The first one, at the start, has no increment.
  /// Empty when the run is over.
  std::optional<SimulatedInstant> next();

  /// All that is there at any time.
  const std::vector<TrueFeature>& map() const { return map_; }
  const Path& path() const { return path_; }

 private:
  void see(const Pose2& X_BW, std::int64_t utime, std::vector<Sighting>& sightings);
  void see_nothing(std::vector<Sighting>& sightings);

  FieldOptions options_;
  Path path_;
  std::vector<TrueFeature> map_;
  PointGrid grid_;  // of the map
  HeadingSensor heading_sensor_;
  Odometer odometer_;
  Noise sensor_noise_, dropout_, clutter_, labels_;
  std::int64_t step_ = 0;
  Pose2 X_WB_;
};

/// The whole run, with truth at every instant and the true map.
/// @throws std::invalid_argument as FieldSimulator does.
Recording record(const FieldOptions& options, std::uint64_t seed);
/// What is left of a run.
Recording record(FieldSimulator& simulator);

}  // namespace leadline
