#include "apps/evaluation/relocate.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "leadline/submap/slam.h"

namespace leadline::app {
namespace {

constexpr double kExact = 1e-6;  // [m], [rad]: where one is in one's own frame

/// An estimator that begins in a frame of its own.
SlamOptions in_own_frame(SlamOptions options, const Instant& first) {
  options.problem = Problem::slam;
  options.submaps.radius = std::numeric_limits<double>::infinity();
  options.submaps.crossing_steps = 0;
  options.initial.X_WB = {};
  options.initial.sigma = Eigen::Vector3d(kExact, kExact, kExact);
  const bool is_absolute = options.submaps.orientation == Orientation::absolute;
  if (is_absolute && first.heading) {
    options.initial.X_WB.heading = first.heading->value;
    options.initial.sigma[2] = std::max(first.heading->sigma, options.readings.heading);
  }
  return options;
}

/// What has been heard of late, as it is known from the vehicle.
LocalPicture picture_of(const Slam& slam, double memory) {
  LocalPicture picture;
  const std::int64_t oldest = slam.utime() - static_cast<std::int64_t>(1e6 * memory);
  std::ranges::copy_if(slam.features(), std::back_inserter(picture.features), [&](const Feature& feature) {
    return feature.kind != FeatureKind::undecided && feature.last_seen >= oldest;
  });
  picture.joint = slam.map().joint();
  picture.joint.reexpress(kVehicle, kVehicle);
  return picture;
}

PlacePrior prior_of(const Slam& slam, bool knows_heading) {
  if (!knows_heading) return {};
  const UncertainPose X_WV = slam.pose();
  return {.heading = Reading{X_WV.X.heading, std::sqrt(X_WV.P(2, 2))}};
}

}  // namespace

Relocation relocate(const SlamOptions& options, std::vector<Landmark> map, RecordingSource& source,
                    const RelocateOptions& relocate_options) {
  Relocation outcome;
  std::optional<Instant> instant = source.next_instant();
  if (!instant) return outcome;
  const std::int64_t begin = instant->utime;
  const auto period = static_cast<std::int64_t>(1e6 * relocate_options.period);
  Slam slam(in_own_frame(options, *instant));
  Relocalizer relocalizer(relocate_options.search, std::move(map));
  bool knows_heading = false;
  for (std::int64_t next = begin + period; instant; instant = source.next_instant()) {
    if (relocate_options.progress) relocate_options.progress();
    slam.step(*instant);
    knows_heading =
        knows_heading || (instant->heading && options.submaps.orientation == Orientation::absolute);
    if (slam.utime() < next) continue;
    next = slam.utime() + period;
    outcome.utime = slam.utime();
    outcome.after = 1e-6 * static_cast<double>(slam.utime() - begin);
    outcome.answer =
        relocalizer.search(picture_of(slam, relocate_options.memory), prior_of(slam, knows_heading));
    ++outcome.searches;
    if (outcome.answer.verdict == PlaceAnswer::Verdict::found) break;
  }
  return outcome;
}

}  // namespace leadline::app
