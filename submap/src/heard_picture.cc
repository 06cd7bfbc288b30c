#include "heard_picture.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "leadline/core/angle.h"
#include "leadline/core/error.h"
#include "leadline/submap/submap.h"

namespace leadline {

namespace {

bool is_usable(const Joint& joint, const Feature& feature) {
  return feature.kind != FeatureKind::undecided && joint.contains(place_of(feature));
}

bool is_finite(const Joint& joint, const Joint::Part& part) {
  const auto rows = joint.covariance().middleRows(part.row, part.size());
  return part.value.allFinite() && rows.allFinite() &&
         joint.covariance().diagonal().segment(part.row, part.size()).minCoeff() >= 0.0;
}

/// The picture's parts that can be used, and its frame, in the frame of the vehicle.
std::optional<Joint> in_vehicle_frame(const LocalPicture& picture) {
  Joint joint = picture.joint;
  if (joint.parts().empty() || !joint.contains(kVehicle)) return std::nullopt;
  // One part that is not finite makes the rows of all others so: it goes first.
  std::vector<Key> broken;
  for (const Joint::Part& part : joint.parts()) {
    const auto own = joint.covariance().block(part.row, part.row, part.size(), part.size());
    if (!are_within(part.value, kFarthest) || !are_within(own, kFarthest * kFarthest))
      broken.push_back(part.key);
  }
  const auto is_wanted = [&](const Key& key) {
    return std::ranges::find(broken, key) == broken.end() &&
           (key == kVehicle || key.kind == Key::Kind::point || key.kind == Key::Kind::wall);
  };
  if (!is_wanted(kVehicle)) return std::nullopt;
  joint.keep(is_wanted);
  if (!joint.covariance().allFinite() || !is_finite(joint, joint.at(kVehicle))) return std::nullopt;
  joint.add_origin(kPictureFrame);
  joint.reexpress(kVehicle, kVehicle);
  return joint;
}

}  // namespace

HeardPicture::Relation HeardPicture::relation(PairKind kind, int first, int second) const {
  const Landmark &a = (*this)[first], &b = (*this)[second];
  Eigen::Vector3d by_a = Eigen::Vector3d::Zero(), by_b = Eigen::Vector3d::Zero();
  double size = 0.0;
  switch (kind) {
    case PairKind::points: {
      const Eigen::Vector2d way = b.position() - a.position();
      size = way.norm();
      by_b.head<2>() = size > 0.0 ? Eigen::Vector2d(way / size) : Eigen::Vector2d::UnitX();
      by_a = -by_b;
      break;
    }
    case PairKind::point_and_wall: {
      size = off_wall(b, a.position());
      by_a.head<2>() = b.normal();
      by_b << -b.normal(), b.along().dot(a.position() - b.position());
      if (size < 0.0) by_a = -by_a, by_b = -by_b;
      size = std::abs(size);
      break;
    }
    case PairKind::walls: {
      const double turn = line_angle(b.value[2], a.value[2]);
      by_b[2] = turn < 0.0 ? -1.0 : 1.0;
      by_a[2] = -by_b[2];
      size = std::abs(turn);
      break;
    }
  }
  const auto& P = joint.covariance();
  const auto block = [&](int i, int j) {
    const Joint::Part &of_i = part(i), &of_j = part(j);
    Eigen::Matrix3d result = Eigen::Matrix3d::Zero();
    const int m = std::min(of_i.size(), 3), n = std::min(of_j.size(), 3);
    result.topLeftCorner(m, n) = P.block(of_i.row, of_j.row, m, n);
    return result;
  };
  const double variance = by_a.dot(block(first, first) * by_a) + by_b.dot(block(second, second) * by_b) +
                          2.0 * by_a.dot(block(first, second) * by_b);
  return {size, std::max(variance, 0.0)};
}

std::optional<HeardPicture> heard_picture(const LocalPicture& picture, int most) {
  std::optional<Joint> joint = in_vehicle_frame(picture);
  if (!joint) return std::nullopt;
  HeardPicture heard;
  for (const Feature& feature : picture.features) {
    if (!is_usable(*joint, feature)) continue;
    const Landmark added = landmark(*joint, feature);
    if (added.is_finite()) heard.landmarks.push_back(added);
  }
  std::ranges::sort(heard.landmarks, {},
                    [](const Landmark& l) { return std::tuple(spread_of(l).place, l.kind, l.id); });
  const auto same = [](const Landmark& a, const Landmark& b) { return a.id == b.id && a.kind == b.kind; };
  heard.landmarks.erase(std::unique(heard.landmarks.begin(), heard.landmarks.end(), same),
                        heard.landmarks.end());
  if (heard.size() > most) heard.landmarks.resize(static_cast<std::size_t>(most));
  if (heard.landmarks.empty()) return std::nullopt;
  for (const Landmark& landmark : heard.landmarks) {
    heard.spreads.push_back(spread_of(landmark));
    heard.middles.push_back(landmark.middle());
  }

  // Its parts in the order of the landmarks.
  std::vector<Joint::Part> parts{joint->at(kPictureFrame)};
  for (const Landmark& l : heard.landmarks)
    parts.push_back(joint->at({l.is_wall() ? Key::Kind::wall : Key::Kind::point, l.id}));
  std::vector<int> rows;
  for (const Joint::Part& part : parts)
    for (int k = 0; k < part.size(); ++k) rows.push_back(part.row + k);
  const Joint::Part& frame = parts.front();
  const Pose2 X_VL{frame.value[0], frame.value[1], frame.value[2]};
  heard.joint = Joint(parts, joint->covariance()(rows, rows));
  for (const LocalPicture::Disc& disc : picture.heard)
    if (are_within(Eigen::Vector3d(disc.centre.x(), disc.centre.y(), disc.radius), kFarthest) &&
        disc.radius > 0.0)
      heard.heard.push_back({transform(X_VL, disc.centre), disc.radius});
  return heard;
}

}  // namespace leadline
