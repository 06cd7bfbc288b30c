#include "leadline/submap/place_search.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "leadline/core/angle.h"

namespace leadline {

namespace {

std::int64_t microseconds(double seconds) { return static_cast<std::int64_t>(1e6 * seconds); }

/// On a map, and a little beside it.
UncertainPose anywhere(const std::vector<Landmark>& map, double margin, bool knows_heading) {
  Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = low;
  if (!map.empty()) low = high = map.front().middle();
  for (const Landmark& landmark : map) {
    low = low.cwiseMin(landmark.middle());
    high = high.cwiseMax(landmark.middle());
  }
  const Eigen::Vector2d centre = 0.5 * (low + high);
  const double reach = (high - centre).norm() + margin;
  const double heading = knows_heading ? 0.0 : kPi * kPi / 3.0;
  return {{centre.x(), centre.y(), 0.0},
          Eigen::Vector3d(reach * reach, reach * reach, heading).asDiagonal().toDenseMatrix()};
}

bool knows_heading(const LocalSlam& own) {
  return own.options().submaps.orientation == Orientation::absolute;
}

/// What has been heard of late, in L.
LocalPicture picture_of(const LocalSlam& own) {
  LocalPicture picture{own.map().joint(), {}};
  const std::int64_t oldest = own.utime() - microseconds(own.options().relocalization.memory);
  std::ranges::copy_if(own.map().features(), std::back_inserter(picture.features),
                       [&](const Feature& feature) {
                         return feature.kind != FeatureKind::undecided && feature.last_seen >= oldest;
                       });
  return picture;
}

}  // namespace

UncertainPose pose_in_own_frame(const SlamOptions& options, const Reading& heading) {
  constexpr double kExact = 1e-6;  // [m], [rad]: where one is in one's own frame
  const bool is_absolute = options.submaps.orientation == Orientation::absolute;
  const Eigen::Vector3d sigma(kExact, kExact, is_absolute ? std::max(heading.sigma, kExact) : kExact);
  return {{0.0, 0.0, is_absolute ? heading.value : 0.0}, sigma.cwiseAbs2().asDiagonal().toDenseMatrix()};
}

PlaceSearch::PlaceSearch(LocalSlam own, std::vector<Landmark> map, const Known& known)
    : own_(std::move(own)),
      is_anywhere_(!known.X_WL),
      in_map_(known.in_map),
      X_WL_(known.X_WL ? *known.X_WL
                       : anywhere(map, own_.options().relocalization.search.margin, knows_heading(own_))),
      relocalizer_(own_.options().relocalization.search, std::move(map)),
      agreement_(own_.options().relocalization),
      next_(own_.utime() + microseconds(own_.options().relocalization.period)) {}

bool PlaceSearch::step(const Instant& instant) {
  const bool is_taken = own_.step(instant);
  if (is_taken && own_.utime() >= next_) search();
  return is_taken;
}

void PlaceSearch::set_clock(std::int64_t utime) {
  next_ += utime - own_.utime();
  own_.set_clock(utime);
}

void PlaceSearch::search() {
  next_ = own_.utime() + microseconds(own_.options().relocalization.period);
  answer_ = relocalizer_.search(picture_of(own_), prior());
  ++searches_;
  agreement_.note(answer_, own_.pose());
}

PlacePrior PlaceSearch::prior() const {
  PlacePrior prior{.in_map = in_map_};
  if (!is_anywhere_) {
    prior.X_WV = pose();
  } else if (knows_heading(own_)) {
    const UncertainPose X_LV = own_.pose();
    prior.heading = Reading{X_LV.X.heading, std::sqrt(X_LV.P(2, 2))};
  }
  return prior;
}

}  // namespace leadline
