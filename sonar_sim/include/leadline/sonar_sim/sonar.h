/// @file
/// One channel of the range-sonar array, with all that goes wrong in a real one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/core/options.h"
#include "leadline/core/se2.h"
#include "leadline/sonar_sim/noise.h"
#include "leadline/sonar_sim/smooth_noise.h"
#include "leadline/sonar_sim/world.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

/// Faults of a channel; none by default. "Spurious" returns have no label.
struct SonarFaults {
  double dropout = 0.0;        ///< probability that a ping hears nothing of its own
  double multipath = 0.0;      ///< probability of a spurious second echo, over a wall or there and back twice
  double lock = 0.0;           ///< probability per ping that the sonar locks to a spurious range
  double lock_duration = 5.0;  ///< [s], mean time for which it reports that range and nothing of its own
  double cross_talk = 0.0;     ///< probability of a spurious return at the range of another channel's echo
  double clutter = 0.0;        ///< mean number of spurious returns per ping, anywhere within the range limits
  double wrong_label = 0.0;    ///< probability that an echo has the label of another target
  double max_incidence = kPi / 2;  ///< [rad]; a wall met more obliquely sends no echo
  double wall_roughness = 0.0;     ///< [m], standard deviation of the range of walls
  double low_pass_time = 0.0;      ///< [s], time constant of a first-order filter on the range
  double offset = 0.0;             ///< [m], added to the range of the channel's own echo
  double delay = 0.0;              ///< [s]; the range is that of the pose so long ago

  // of a cone
  double edge_dropout = 0.0;  ///< probability that a ping does not hear an edge that it meets
  double faint_size =
      0.0;  ///< [m]; an object of size s > 0 is heard with probability 1 - exp(-s / faint_size)
  double wall_texture =
      0.0;  ///< [m], standard deviation of the range of walls, a smooth function of the place
  double texture_length = 0.3;  ///< [m], along the wall, over which that is correlated
  double aspect_wander = 0.0;   ///< [m], standard deviation of the range of edges and objects, a smooth
                                ///< function of the direction from which they are heard
  double wander_angle = from_degrees(30.0);  ///< [rad], over which that is correlated
};

struct SonarOptions {
  Pose2 X_BS;               ///< mount: sonar in the body frame (x forward, y to port)
  double rate = 1.0;        ///< [Hz], pings
  double phase = 0.0;       ///< share of a period by which it pings later: neighbours take turns
  double min_range = 0.3;   ///< [m]; nearer targets are not heard
  double max_range = 10.0;  ///< [m]; farther ones neither
  double beam_width = from_degrees(4.0);      ///< [rad], full width in which an object echoes
  double bearing_sigma = from_degrees(1.0);   ///< [rad], of the ray that meets a wall, about the axis
  WallEcho wall_echo = WallEcho::along_beam;  ///< from that ray, or the first echo in a cone of beam_width
  double rim_softness = from_degrees(2.5);    ///< [rad], over which a cone's sensitivity falls off at its rim
  double range_sigma = 0.05;                  ///< [m]
  SonarFaults faults;
};

/// Where the sonar is.
void visit_mount(OptionVisitor& visitor, SonarOptions& options);
/// All but that.
void visit(OptionVisitor& visitor, SonarOptions& options);

/// A ping is heard in two steps, because cross-talk needs the echoes of all channels that ping together.
class Sonar {
 public:
  /// @param index of the channel: `Sighting::sensor`. Precondition: the options are valid.
  Sonar(const SonarOptions& options, std::size_t index, std::uint64_t seed);

  /// What the ping meets: the nearest of the objects inside the beam and the wall on a ray that lies off the
  /// axis by a normal deviate; or, if specular, the first echo in the cone that is heard. Each is heard with
  /// a probability that is 1/2 at the rim of the cone and that of a normal distribution beside it, times that
  /// of its kind. Whether the range is within limits depends on the true one, not on the noise of the
  /// reported one.
  std::optional<Echo> echo(const World& world, const Pose2& X_WB);

  /// What the channel says: appends to @p sightings. A range that noise makes negative is lost.
  /// @param echoes of all channels, by index; empty where a channel did not ping or heard nothing.
  void report(const World& world, const Pose2& X_WB, const std::vector<std::optional<Echo>>& echoes,
              std::vector<Sighting>& sightings);

  const SonarOptions& options() const { return options_; }

 private:
  std::optional<Echo> nearest_in_beam(const World& world, const Pose2& X_WS);
  std::optional<Echo> first_in_cone(const World& world, const Pose2& X_WS);
  double loudness(const Echo& echo) const;
  double surface_error(const Echo& echo);
  bool locked();
  double filtered(double range);
  void report_cross_talk(const std::vector<std::optional<Echo>>& echoes, std::vector<Sighting>& sightings);
  void report_clutter(std::vector<Sighting>& sightings);
  void add(double range, int label, std::vector<Sighting>& sightings) const;
  bool hears(double range) const;

  SonarOptions options_;
  std::size_t index_;
  std::uint64_t seed_;
  Noise bearing_noise_, range_noise_, roughness_, dropout_, multipath_, lock_, cross_talk_, clutter_, labels_,
      loudness_;
  std::map<int, SmoothNoise> textures_, wanders_;  // by label; the same for all channels
  std::optional<double> filtered_range_;
  double lock_left_ = 0.0;   // [s]
  double lock_range_ = 0.0;  // [m]
};

}  // namespace leadline
