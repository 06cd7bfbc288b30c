#include "apps/wire/estimates.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "leadline/core/semidefinite.h"
#include "leadline/submap/shape.h"
#include "leadline/submap/submap.h"

namespace leadline::app {
namespace {

template <int N>
Eigen::Matrix<double, N, N> clean(Eigen::Matrix<double, N, N> P) {
  for (int i = 0; i < N; ++i) {
    if (P(i, i) > 0.0) continue;
    P.row(i).setZero();
    P.col(i).setZero();
  }
  return nearest_semidefinite<N>(P);
}

std::vector<double> packed(const Eigen::Matrix3d& P) {
  double values[6];
  put_covariance(P, values);
  return {values, values + 6};
}

std::vector<double> packed(const Eigen::Matrix2d& P) { return {P(0, 0), P(0, 1), P(1, 1)}; }

std::int8_t kind_of(Shape shape) {
  switch (shape) {
    case Shape::undecided:
      return +submap_t::UNDECIDED;
    case Shape::point:
      return +submap_t::POINT;
    case Shape::corner:
      return +submap_t::CORNER;
    case Shape::edge:
      return +submap_t::EDGE;
    case Shape::cylinder:
      return +submap_t::CYLINDER;
    case Shape::wall:
      break;
  }
  return +submap_t::WALL;
}

void add_feature(const Joint& joint, const Feature& feature, Shape shape, submap_t& message) {
  message.feature.push_back(feature.id);
  message.kind.push_back(kind_of(shape));
  message.confirmed.push_back(feature.confirmed);
  message.hits.push_back(feature.hits);
  Belief::Line line;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Matrix2d P;
  if (feature.kind == FeatureKind::wall) {
    line = joint.line(feature.id);
    P = line.P;
  } else {
    const Joint::Part& point = joint.at(place_of(feature));
    position = point.value.head<2>();
    P = joint.covariance().block<2, 2>(point.row, point.row);
  }
  message.px.push_back(position.x());
  message.py.push_back(position.y());
  message.rho.push_back(line.rho);
  message.alpha.push_back(line.alpha);
  const Parameter radius = radius_of(joint, feature), scale = scale_of(joint, feature);
  message.feature_radius.push_back(radius.value);
  message.radius_sigma.push_back(radius.sigma);
  message.scale.push_back(scale.value);
  message.scale_sigma.push_back(scale.sigma);
  message.feature_cov.push_back(packed(clean<2>(P)));
}

/// What all messages of a submap have in common.
submap_t submap_header(const Slam& slam, const Submap& submap) {
  submap_t message{};
  message.utime = slam.utime();
  message.id = submap.id();
  message.parent = submap.parent();
  message.root = submap.root();
  message.in_use = submap.id() == slam.submaps().current();
  message.visits = submap.visits();
  message.centre_x = submap.centre().x();
  message.centre_y = submap.centre().y();
  const double radius = slam.options().submaps.radius;
  message.radius = std::isfinite(radius) ? radius : 0.0;
  const UncertainPose X_WS = slam.place(submap.id());
  message.x = X_WS.X.x;
  message.y = X_WS.X.y;
  message.heading = X_WS.X.heading;
  put_covariance(X_WS.P, message.cov);
  return message;
}

void add_link(const SubmapGraph::Link& link, submap_graph_t& message) {
  ++message.links;
  message.a.push_back(link.a);
  message.b.push_back(link.b);
  message.link_x.push_back(link.X_ab.X.x);
  message.link_y.push_back(link.X_ab.X.y);
  message.link_heading.push_back(link.X_ab.X.heading);
  message.link_cov.push_back(packed(link.X_ab.P));
}

static_assert(+map_changes_t::NONE == MapChange::kNone && +map_changes_t::MAX_CHANGES >= Aliases::kMost);

std::int8_t reason_of(const MapChange& change) {
  switch (change.reason) {
    case MapChange::Reason::absent:
      return +map_changes_t::ABSENT;
    case MapChange::Reason::displaced:
      return +map_changes_t::DISPLACED;
    case MapChange::Reason::joined:
      break;
  }
  return +map_changes_t::JOINED;
}

void add_change(int feature, std::int8_t reason, int into, map_changes_t& message) {
  ++message.count;
  message.feature.push_back(feature);
  message.reason.push_back(reason);
  message.into.push_back(into);
}

vehicle_state_t state_message(const Slam& slam, std::int64_t utime, const UncertainPose& X_WB,
                              const UncertainPose& X_SB, bool dead_reckoning) {
  vehicle_state_t message{};
  message.utime = utime;
  message.x = X_WB.X.x;
  message.y = X_WB.X.y;
  message.heading = X_WB.X.heading;
  put_covariance(X_WB.P, message.cov);
  const Belief& belief = slam.belief();
  const int speed_row = motion_traits(slam.options().motion).speed_row;
  message.speed_known = speed_row != MotionTraits::kNone;
  message.speed = message.speed_known ? belief.vehicle()[speed_row] : 0.0;
  message.submap = slam.submap();
  message.local_x = X_SB.X.x;
  message.local_y = X_SB.X.y;
  message.local_heading = X_SB.X.heading;
  put_covariance(X_SB.P, message.local_cov);
  message.dead_reckoning = dead_reckoning;
  return message;
}

}  // namespace

void put_covariance(const Eigen::Matrix3d& covariance, double (&packed)[6]) {
  const Eigen::Matrix3d P = clean<3>(covariance);
  std::size_t i = 0;
  for (int row = 0; row < 3; ++row)
    for (int column = row; column < 3; ++column) packed[i++] = P(row, column);
}

vehicle_state_t state_message(const Slam& slam, bool dead_reckoning) {
  return state_message(slam, slam.utime(), slam.pose(), slam.local_pose(), dead_reckoning);
}

vehicle_state_t state_message(const Slam& slam, std::int64_t utime, const UncertainPose& X_WB,
                              bool dead_reckoning) {
  return state_message(slam, utime, X_WB, oplus({inverse(slam.frame())}, X_WB), dead_reckoning);
}

std::vector<submap_t> submap_messages(const Slam& slam, int submap) {
  const Submap& stored = slam.submaps().submaps()[static_cast<std::size_t>(submap)];
  const auto [joint, held] = slam.content(submap);
  const std::span<const Feature> features(held);
  const submap_t header = submap_header(slam, stored);
  constexpr std::size_t kMost = submap_t::MAX_FEATURES;
  std::vector<submap_t> messages;
  std::size_t first = 0;
  do {
    submap_t& message = messages.emplace_back(header);
    const auto part = features.subspan(first, std::min(features.size() - first, kMost));
    message.total = static_cast<std::int32_t>(features.size());
    message.first = static_cast<std::int32_t>(first);
    message.count = static_cast<std::int32_t>(part.size());
    for (const Feature& feature : part)
      add_feature(joint, feature, shape_of(joint, feature, features, slam.options().features), message);
    first += part.size();
  } while (first < features.size());
  return messages;
}

std::vector<submap_graph_t> graph_messages(const Slam& slam, int first) {
  const SubmapManager& submaps = slam.submaps();
  const int end = std::min(submaps.graph().size(), first + submap_graph_t::MAX_SUBMAPS);
  submap_graph_t header{};
  header.utime = slam.utime();
  header.total = submaps.graph().size();
  header.current = submaps.current();
  std::vector<submap_graph_t> messages{header};
  for (int k = first; k < end; ++k) {
    submap_graph_t& message = messages.front();
    const UncertainPose X_WS = slam.place(k);
    ++message.submaps;
    message.id.push_back(k);
    message.parent.push_back(submaps.submaps()[static_cast<std::size_t>(k)].parent());
    message.x.push_back(X_WS.X.x);
    message.y.push_back(X_WS.X.y);
    message.heading.push_back(X_WS.X.heading);
    message.cov.push_back(packed(X_WS.P));
    for (const SubmapGraph::Link& link : submaps.graph().links_from(k)) {
      if (messages.back().links == submap_graph_t::MAX_LINKS) messages.push_back(header);
      add_link(link, messages.back());
    }
  }
  return messages;
}

map_changes_t changes_message(const Slam& slam) {
  map_changes_t message{};
  message.utime = slam.utime();
  for (const MapChange& change : slam.changes())
    add_change(change.feature, reason_of(change), change.into, message);
  return message;
}

map_changes_t aliases_message(const Slam& slam) {
  map_changes_t message{};
  message.utime = slam.utime();
  for (const auto& [lost, kept] : slam.aliases().all())
    add_change(lost, +map_changes_t::JOINED, kept, message);
  return message;
}

}  // namespace leadline::app
