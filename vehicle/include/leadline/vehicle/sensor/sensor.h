/// @file
/// Sensors that see targets: a channel of a range-sonar array, or a range-bearing sensor (laser, marker
/// camera).
#pragma once

#include <optional>
#include <string>

#include "leadline/core/angle.h"
#include "leadline/core/options.h"
#include "leadline/core/se2.h"

namespace leadline {

/// Which range a wall returns.
enum class WallEcho {
  along_beam,  ///< a narrow beam: where its axis meets the wall
  specular     ///< a cone: from the foot of the perpendicular, wherever in the beam that is
};

/// One sensor as the estimator believes it to be.
struct Sensor {
  enum class Kind { range_sonar, range_bearing };

  std::string name;
  Kind kind = Kind::range_sonar;
  Pose2 X_BS;                                ///< mount: sensor in the body frame (x forward, y to port)
  double min_range = 0.0;                    ///< [m]; nearer returns are refused
  double max_range = 100.0;                  ///< [m]; farther ones too
  double range_sigma = 0.05;                 ///< [m], standard deviation
  double wall_roughness = 0.0;               ///< [m], standard deviation of a wall's range beside that
  double bearing_sigma = from_degrees(1.0);  ///< [rad]; of a sonar: how far off its axis an echo may lie
  double beam_width = from_degrees(4.0);     ///< [rad], full width; sonar only
  WallEcho wall_echo = WallEcho::along_beam;
  double confidence_drop = 0.5;      ///< an echo of less confidence is not used
  double confidence_full = 0.9;      ///< from it on range_sigma holds
  double confidence_widening = 3.0;  ///< times range_sigma at confidence_drop, linear in between
  /// Else every target is a point. Not given: a sonar does, a range-bearing sensor does not, as most see
  /// poles, piles or markers.
  std::optional<bool> sees_walls;
  /// Of the noise's variance, what two returns of one instant from the same place share; it falls off with
  /// exp(-d^2 / (2 common_distance^2)) of their distance d. Their difference is the sharper for it.
  double common_share = 0.0;
  double common_distance = 0.7;  ///< [m]

  /// It hears the nearest of what is in a wide beam, and how far that is, not where (cone.h).
  bool is_cone() const { return kind == Kind::range_sonar && wall_echo == WallEcho::specular; }
  /// It hears all around, as a receiver of beacons does: nothing is beside its cone, nothing hides another.
  bool is_omnidirectional() const { return is_cone() && beam_width >= 2.0 * kPi; }
  bool may_see_walls() const { return sees_walls.value_or(kind == Kind::range_sonar); }
  /// Its beam turns, step by step or through a whole scan at once, and every bearing is a ping of its own.
  /// (One that sees points shows all of them in one picture.)
  bool is_scanner() const { return kind == Kind::range_bearing && may_see_walls(); }
};

/// All but the name.
void visit(OptionVisitor& visitor, Sensor& sensor);

}  // namespace leadline
