/// @file
/// Options of the estimator. All have a meaning of their own; none is tuned to a world.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/core/belief.h"
#include "leadline/core/error.h"
#include "leadline/core/linearizer.h"
#include "leadline/core/options.h"
#include "leadline/submap/relocalizer_options.h"
#include "leadline/vehicle/motion/models.h"
#include "leadline/vehicle/navigation_options.h"
#include "leadline/vehicle/reading_gate.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

enum class AssociationMethod {
  joint,  ///< all sightings of an instant together, with what is new or false as an alternative
  nnsf,   ///< nearest neighbour standard filter (Hwang and Seong eq. 25-26)
  known   ///< joint, with the labels of the sightings as evidence
};

struct AssociationOptions {
  AssociationMethod method = AssociationMethod::joint;
  double gate = 0.99;        ///< probability that a right match passes
  double new_gate = 0.9999;  ///< a sighting outside this gate of every feature is a new target
  // Of the others than nnsf:
  double beam_density = 0.1;    ///< [1/m], of a sonar's ranges that come from nothing in the map
  double scan_density = 0.02;   ///< [1/m], the same of a range and bearing sensor, at a point's bearing
  double wait_beyond = 0.4;     ///< [m]; a sonar's echo waits where a feature is known less well than that
  double point_density = 0.02;  ///< [1/m^2], of objects that are not in the map yet
  double label_error = 0.01;    ///< probability that a label is wrong; 0: what it says is only gated
  double wall_density = 0.01;   ///< [1/(m rad)], the same of walls
  bool learn = false;           ///< densities of ranges and Sensor::common_share, those given being the prior

  /// Of a sensor's returns that nothing in the map explains [1/m].
  double density(Sensor::Kind kind) const {
    return kind == Sensor::Kind::range_bearing ? scan_density : beam_density;
  }
};

struct FeatureOptions {
  int capacity = 100;    ///< features held at once
  int tentative = 100;   ///< of them not confirmed, at most; the least likely goes. Not with nnsf
  int confirm_hits = 3;  ///< sightings until a feature of known kind corrects the vehicle
  double wall_direction_sigma = from_degrees(20);  ///< [rad], of a wall's normal about the first beam
  double wall_reach = 1.0;  ///< [m]; a wall is believed in so far beyond what was seen of it
  /// An object is no point, and which side of it answers is the same at many echoes: its place walks by so
  /// much while it is seen [m/sqrt(s)], so that no number of echoes makes it surer than the object is small.
  double point_walk = 0.0;
  /// [m], expected, of what is no wall. That of a beacon is its bias with the other sign: it answers so much
  /// later.
  double radius = 0.0;
  double radius_sigma = 0.0;  ///< [m], of that; 0 for both: points
  /// The same of what a cone hears: another side of it answers from another side [m/sqrt(rad)].
  double edge_wander = 0.05;
  double echo_way = 0.5;  ///< [m]; the range errors of one object are alike over so much way of a cone
  double merge_reach =
      5.0;  ///< [m]; walls that lie in one line are one if no wider gap parts what was seen of them
  double overlook_probability = 0.05;  ///< that a beam meets a target and returns no echo of it
  double stranger_density = 0.01;  ///< [1/m], of echoes that come from another target than they are taken for
  double decision_ratio = 1e4;  ///< likelihood ratio that decides between point and wall, or where in a cone

  /// Of beacons, of which each is heard through a speed of sound of its own: the share by which its ranges
  /// are too long; 0: none has one.
  double scale_sigma = 0.0;

  /// What is no wall begins as that.
  TargetShape point_shape() const {
    if (scale_sigma > 0.0) return TargetShape::scaled;
    return radius != 0.0 || radius_sigma > 0.0 ? TargetShape::circle : TargetShape::point;
  }
};

/// Whether the vehicle knows where it heads in the world.
enum class Orientation {
  absolute,  ///< there is a heading reference
  gyro       ///< there is none
};

/// Circular local maps (Hwang and Seong, Table 3).
struct SubmapOptions {
  double radius = std::numeric_limits<double>::infinity();  ///< [m]; infinite: one map for the whole run
  /// Poses of the vehicle at crossings that two submaps side by side hold beside the first, the latest. Each
  /// that is forgotten leaves the two a little less sure of each other.
  int gates = 2;
  /// Rows that two submaps side by side share at most. Up to it submaps know what one map would; beyond, a
  /// feature on two sides of the limit is two, and the map knows less of it.
  int separator_limit = 300;
  /// A crossing is made by a thread of its own and taken over so many steps after the vehicle has left its
  /// circle, or where it is farther outside than crossing_margin; 0: it is made within the step.
  int crossing_steps = 0;
  double crossing_margin = 0.0;  ///< so far outside its circle a submap knows all that may be seen [m]
  Orientation orientation = Orientation::absolute;

  /// How far from the centre of its circle a submap may be in use [m].
  double used_radius() const { return radius + crossing_margin; }
};

/// What is to be found out, and what is known (Thrun, Burgard and Fox, Probabilistic Robotics, ch. 7 to 10).
enum class Problem : std::int8_t {
  slam,          ///< vehicle and map
  localization,  ///< the vehicle: the map that a Slam begins with is considered, but never corrected
  mapping        ///< the map: poses are known, see Instant::pose
};

struct SlamOptions {
  ErrorKind error = ErrorKind::invariant;
  Linearizer linearizer;
  InitialPose initial;
  ReadingSigmas readings;
  GateOptions gates;
  MotionOptions motion;
  std::vector<Sensor> sensors;
  AssociationOptions association;
  FeatureOptions features;
  SubmapOptions submaps;
  Problem problem = Problem::slam;
  bool add_to_known = false;  ///< localization: what is not in the map that is known becomes part of it
  RelocalizationOptions relocalization;
};

/// @throws std::invalid_argument "name is value, must be allowed", as OptionChecker does: what a Slam with
/// these options could not work with. Names are those of the configuration ("features.capacity"); sensors are
/// counted from 0.
void validate(const SlamOptions& options);

void visit(OptionVisitor& visitor, AssociationOptions& association);
void visit(OptionVisitor& visitor, FeatureOptions& features);
/// Section vehicle but for the model in use, which visit_model() asks for before.
void visit_vehicle(OptionVisitor& visitor, SlamOptions& options);
/// Section filter but for the kind of linearizer. The model in use is already known.
void visit_filter(OptionVisitor& visitor, SlamOptions& options);
/// Section map. The model in use is already known. An infinite radius is not visited.
void visit_map(OptionVisitor& visitor, SlamOptions& options);
/// Once the radius is known.
void require_one_map_for_mapping(OptionVisitor& visitor, const SlamOptions& options);

}  // namespace leadline
