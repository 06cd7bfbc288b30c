#include "apps/evaluation/judge.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "leadline/core/angle.h"
#include "leadline/core/consistency.h"

namespace leadline::app {
namespace {

constexpr std::int64_t kMaxGap = 1'000'000;           // [us] over which positions are interpolated
constexpr int kManyReturns = 5;                       // from which a feature's kind must be right
constexpr double kLandmarkGate = 1.0;                 // [m], of an estimated landmark from the true one
constexpr double kWallTurnGate = from_degrees(30.0);  // of an estimated wall from the true one

/// Mean, root mean square and maximum of what is added.
class Statistic {
 public:
  void add(double value) {
    ++count_;
    sum_ += value;
    squares_ += value * value;
    max_ = std::max(max_, value);
  }
  std::optional<double> mean() const { return known(sum_ / count_); }
  std::optional<double> rms() const { return known(std::sqrt(squares_ / count_)); }
  std::optional<double> max() const { return known(max_); }

 private:
  std::optional<double> known(double value) const { return count_ > 0 ? std::optional(value) : std::nullopt; }
  double count_ = 0, sum_ = 0, squares_ = 0, max_ = 0;
};

template <class T>
struct Bracket {
  const T* before;
  const T* after;
  double share;  // of the way to `after`
};

/// The neighbours of a time in a track, if they are near enough to tell what was between them.
template <class T>
std::optional<Bracket<T>> bracket(const std::vector<T>& track, std::int64_t utime) {
  const auto after = std::ranges::lower_bound(track, utime, {}, &T::utime);
  if (after == track.end()) return std::nullopt;
  if (after->utime == utime) return Bracket<T>{&*after, &*after, 0.0};
  if (after == track.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const std::int64_t gap = after->utime - before->utime;
  if (gap > kMaxGap) return std::nullopt;
  return Bracket<T>{&*before, &*after, static_cast<double>(utime - before->utime) / static_cast<double>(gap)};
}

std::optional<Truth> truth_at(const std::vector<Truth>& track, std::int64_t utime) {
  const auto between = bracket(track, utime);
  if (!between) return std::nullopt;
  const auto& [a, b, share] = *between;
  Truth truth{utime, std::lerp(a->x, b->x, share), std::lerp(a->y, b->y, share), std::nullopt, std::nullopt};
  if (a->heading && b->heading)
    truth.heading = wrap_angle(*a->heading + share * angle_difference(*b->heading, *a->heading));
  return truth;
}

std::optional<Eigen::Vector2d> position_at(const std::vector<VehicleState>& track, std::int64_t utime) {
  const auto between = bracket(track, utime);
  if (!between) return std::nullopt;
  const auto& [a, b, share] = *between;
  return Eigen::Vector2d(std::lerp(a->pose.x, b->pose.x, share), std::lerp(a->pose.y, b->pose.y, share));
}

double rms_distance(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b,
                    const Pose2& X_AB) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - transform(X_AB, b[i])).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

std::int64_t end_of(const Recording& recording) {
  return recording.instants.empty() ? 0 : recording.instants.back().utime;
}

const TrueFeature* find_true(const std::vector<TrueFeature>& map, int label, TargetKind kind) {
  const auto found =
      std::ranges::find_if(map, [&](const TrueFeature& f) { return f.label == label && f.kind == kind; });
  return found == map.end() ? nullptr : &*found;
}

/// Whose echoes each feature was made of.
class Labels {
 public:
  explicit Labels(const std::vector<Return>& returns) {
    for (const Return& r : returns) {
      known_ = known_ || r.sighting.label != Sighting::kUnknown;
      ++seen_[r.sighting.label];
      if (r.association.feature >= 0 && r.association.decision != Decision::discarded)
        ++votes_[r.association.feature][r.sighting.label];
    }
  }

  /// Whether the recording tells them at all.
  bool known() const { return known_; }

  /// The label of most of a feature's sightings; kUnknown if most have none.
  int majority(int feature) const {
    const auto votes = votes_.find(feature);
    if (votes == votes_.end()) return Sighting::kUnknown;
    return std::ranges::max_element(votes->second, {}, [](const auto& vote) { return vote.second; })->first;
  }

  int seen(int label) const {
    const auto found = seen_.find(label);
    return found == seen_.end() ? 0 : found->second;
  }

 private:
  bool known_ = false;
  std::map<int, int> seen_;
  std::map<int, std::map<int, int>> votes_;
};

/// Signed distance of a line from a point, along the line's normal.
double line_distance(double rho, double alpha, double x, double y) {
  return rho - x * std::cos(alpha) - y * std::sin(alpha);
}

/// Where a line is: its y at x, for a line along y (by @p along_y) its x at y. [m]
double line_place(double rho, double alpha, double x, double y, bool along_y) {
  const double c = std::cos(alpha), s = std::sin(alpha);
  return along_y ? (rho - y * s) / c : (rho - x * c) / s;
}

/// The true wall, there at a time, that an estimated one stands for, seen from a true position.
const TrueFeature* true_wall(const Recording& recording, const Labels& labels, int feature,
                             const Belief::Line& line, const Truth& from) {
  const std::int64_t utime = from.utime;
  const double x = from.x, y = from.y;
  if (labels.known()) {
    const TrueFeature* wall = find_true(recording.map, labels.majority(feature), TargetKind::wall);
    return wall && wall->life.contains(utime) ? wall : nullptr;
  }
  const TrueFeature* best = nullptr;
  double best_distance = 0.0;
  for (const TrueFeature& wall : recording.map) {
    if (wall.kind != TargetKind::wall || !wall.life.contains(utime)) continue;
    const double turn = angle_difference(wall.alpha, line.alpha);
    const double sign = std::cos(turn) < 0.0 ? -1.0 : 1.0;  // the normal may point either way
    if (std::abs(std::remainder(turn, kPi)) > kWallTurnGate) continue;
    const double distance = std::abs(line_distance(wall.rho, wall.alpha, x, y) -
                                     sign * line_distance(line.rho, line.alpha, x, y));
    if (best && distance >= best_distance) continue;
    best = &wall;
    best_distance = distance;
  }
  return best;
}

struct WallError {
  double error;  // [m]
  int wall;      // label
};

std::optional<WallError> wall_error(const Return& r, const Recording& recording, const Labels& labels,
                                    const Truth& truth) {
  const TrueFeature* wall = true_wall(recording, labels, r.association.feature, *r.wall, truth);
  if (!wall) return std::nullopt;
  const bool along_y = std::abs(std::cos(wall->alpha)) > std::abs(std::sin(wall->alpha));
  const double estimated = line_place(r.wall->rho, r.wall->alpha, truth.x, truth.y, along_y);
  return WallError{std::abs(estimated - line_place(wall->rho, wall->alpha, truth.x, truth.y, along_y)),
                   wall->label};
}

struct PoseFigures {
  Statistic position, expected, heading, heading_sensor, nees, own_nees;
  double inside = 0, not_above = 0;
  std::optional<double> last_position;
};

PoseFigures judge_poses(const RunTrace& trace, const Recording& recording, std::vector<Consistency>& rows) {
  PoseFigures figures;
  const Band band = consistency_band(1, 3);
  for (std::size_t i = 0; i < trace.states.size(); ++i) {
    const VehicleState& state = trace.states[i];
    const auto truth = truth_at(recording.truth, state.utime);
    if (!truth) continue;
    Eigen::Vector3d error(truth->x - state.pose.x, truth->y - state.pose.y, 0.0);
    figures.position.add(error.head<2>().norm());
    figures.expected.add(std::sqrt(std::max(state.P.topLeftCorner<2, 2>().trace(), 0.0)));
    figures.last_position = error.head<2>().norm();
    if (!truth->heading) continue;

    error[2] = angle_difference(*truth->heading, state.pose.heading);
    figures.heading.add(std::abs(error[2]));
    if (const auto& reading = recording.instants[i].heading)
      figures.heading_sensor.add(angle_difference(reading->value, *truth->heading));

    Consistency row;
    row.utime = state.utime;
    row.error = error;
    row.sigma = state.P.diagonal().cwiseMax(0.0).cwiseSqrt();
    row.nees = nees(error, state.P);
    if (!rows.empty()) {
      figures.nees.add(row.nees);
      figures.own_nees.add(
          pose_nees(trace.error, {state.pose, state.P}, {truth->x, truth->y, *truth->heading}));
      figures.inside += row.nees >= band.low && row.nees <= band.high;
      figures.not_above += row.nees <= band.high;
    }
    rows.push_back(row);
  }
  return figures;
}

Statistic judge_walls(const RunTrace& trace, const Recording& recording, const Labels& labels,
                      std::vector<Consistency>& rows) {
  Statistic statistic;
  for (const Return& r : trace.returns) {
    if (!r.wall) continue;
    const std::int64_t utime = trace.states[r.instant].utime;
    const auto truth = truth_at(recording.truth, utime);
    const auto error = truth ? wall_error(r, recording, labels, *truth) : std::nullopt;
    if (!error) continue;
    statistic.add(error->error);
    const auto row = std::ranges::lower_bound(rows, utime, {}, &Consistency::utime);
    if (row == rows.end() || row->utime != utime || row->wall_error >= error->error) continue;
    row->wall_error = error->error;
    row->wall = error->wall;
  }
  return statistic;
}

struct MapFigures {
  int points = 0, walls = 0;
  std::optional<double> right_kind, undecided, false_points, false_walls, wall_decided_after;
  std::optional<double> walls_found, walls_missed, walls_duplicate;
};

std::optional<double> mean_miss_rate(const std::vector<MissRate>& rates) {
  Statistic statistic;
  for (const MissRate& rate : rates) statistic.add(rate.mean());
  return statistic.mean();
}

MapFigures judge_map(const RunTrace& trace, const Recording& recording, const Labels& labels, bool in_world) {
  MapFigures figures;
  double many = 0, right = 0, undecided = 0, false_points = 0, false_walls = 0;
  std::map<int, int> found;  // walls, by their labels
  int strange = 0;           // walls that are none
  const Pose2 last = trace.states.empty() ? Pose2{} : trace.states.back().pose;
  const Truth end{end_of(recording), last.x, last.y, std::nullopt, std::nullopt};
  for (const MapFeature& entry : trace.map) {
    const Feature& feature = entry.feature;
    const bool wall = feature.kind == FeatureKind::wall;
    if (feature.confirmed) ++(wall ? figures.walls : figures.points);
    if (feature.confirmed && wall) {
      const TrueFeature* truth = true_wall(recording, labels, feature.id, entry.line, end);
      if (truth)
        ++found[truth->label];
      else
        ++strange;
    }
    const int label = labels.majority(feature.id);
    const bool is_wall = find_true(recording.map, label, TargetKind::wall);
    if (!is_wall && !find_true(recording.map, label, TargetKind::point)) continue;
    if (feature.confirmed && wall != is_wall) ++(wall ? false_walls : false_points);
    if (feature.hits < kManyReturns) continue;
    if (feature.kind == FeatureKind::undecided) {
      ++undecided;
      continue;
    }
    ++many;
    right += wall == is_wall;
  }
  if (labels.known()) {
    if (many > 0) figures.right_kind = right / many;
    figures.undecided = undecided;
    figures.false_points = false_points;
    figures.false_walls = false_walls;
    Statistic after;
    for (const KindDecision& decided : trace.kinds)
      if (decided.kind == FeatureKind::wall &&
          find_true(recording.map, labels.majority(decided.feature), TargetKind::wall))
        after.add(decided.after);
    figures.wall_decided_after = after.mean();
  }
  if (std::ranges::none_of(recording.map, [](const TrueFeature& f) { return f.kind == TargetKind::wall; }) ||
      (!in_world && !labels.known()))
    return figures;

  figures.walls_found = static_cast<double>(found.size());
  figures.walls_duplicate = figures.walls - strange - static_cast<double>(found.size());
  if (labels.known()) {
    figures.walls_missed = std::ranges::count_if(recording.map, [&](const TrueFeature& f) {
      return f.kind == TargetKind::wall && f.life.contains(end.utime) &&
             labels.seen(f.label) >= kManyReturns && !found.contains(f.label);
    });
  }
  return figures;
}

/// A confirmed point and the true one that it stands for.
struct LandmarkPair {
  Eigen::Vector2d estimated;
  const TrueFeature* truth;
};
using LandmarkPairs = std::vector<LandmarkPair>;

LandmarkPairs pair_by_label(const RunTrace& trace, const Recording& recording, const Labels& labels) {
  std::map<int, const MapFeature*> best;  // by label; of several the one seen most
  for (const MapFeature& entry : trace.map) {
    if (!entry.feature.confirmed || entry.feature.kind != FeatureKind::point) continue;
    const MapFeature*& place = best[labels.majority(entry.feature.id)];
    if (!place || entry.feature.hits > place->feature.hits) place = &entry;
  }
  LandmarkPairs pairs;
  for (const auto& [label, entry] : best) {
    if (const TrueFeature* truth = find_true(recording.map, label, TargetKind::point))
      pairs.push_back({entry->position, truth});
  }
  return pairs;
}

LandmarkPairs pair_by_nearness(const RunTrace& trace, const Recording& recording, const Pose2& X_WT) {
  struct Candidate {
    double distance;
    std::size_t estimated, truth;
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < trace.map.size(); ++i) {
    if (!trace.map[i].feature.confirmed || trace.map[i].feature.kind != FeatureKind::point) continue;
    for (std::size_t j = 0; j < recording.map.size(); ++j) {
      const TrueFeature& truth = recording.map[j];
      if (truth.kind != TargetKind::point) continue;
      const double distance = (trace.map[i].position - transform(X_WT, {truth.x, truth.y})).norm();
      if (distance < kLandmarkGate) candidates.push_back({distance, i, j});
    }
  }
  std::ranges::stable_sort(candidates, {}, &Candidate::distance);
  std::vector<bool> used(trace.map.size()), found(recording.map.size());
  LandmarkPairs pairs;
  for (const auto& [distance, i, j] : candidates) {
    if (used[i] || found[j]) continue;
    used[i] = found[j] = true;
    pairs.push_back({trace.map[i].position, &recording.map[j]});
  }
  return pairs;
}

struct LandmarkFigures {
  std::optional<double> found, spurious, rmse;
  std::optional<double> gone, stale, added, added_found;  // where the world has changed
};

/// Labels of what has ever been in the map.
std::set<int> ever_mapped(const RunTrace& trace, const Labels& labels) {
  std::set<int> mapped;
  for (const int feature : trace.confirmed) mapped.insert(labels.majority(feature));
  return mapped;
}

/// Against the landmarks that are there at the end. @param confirmed points in the map.
LandmarkFigures judge_landmarks(const LandmarkPairs& pairs, const RunTrace& trace, const Recording& recording,
                                const Labels& labels, int confirmed) {
  const std::int64_t begin = recording.instants.empty() ? 0 : recording.instants.front().utime;
  const std::int64_t end = end_of(recording);
  const auto is_there = [&](const TrueFeature& f) { return f.life.contains(end); };
  const auto is_added = [&](const TrueFeature& f) { return f.life.from > begin && is_there(f); };
  const std::set<int> mapped = ever_mapped(trace, labels);
  const auto is_gone = [&](const TrueFeature& f) {
    return f.life.until <= end && (!labels.known() || mapped.contains(f.label));
  };
  const auto paired = [&](const auto& is) {
    return std::ranges::count_if(pairs, [&](const LandmarkPair& pair) { return is(*pair.truth); });
  };
  const auto points = [&](const auto& is) {
    return std::ranges::count_if(recording.map,
                                 [&](const TrueFeature& f) { return f.kind == TargetKind::point && is(f); });
  };

  LandmarkFigures figures;
  figures.found = paired(is_there);
  figures.spurious = confirmed - *figures.found;
  std::vector<Eigen::Vector2d> estimated, truth;
  for (const LandmarkPair& pair : pairs) {
    if (!is_there(*pair.truth)) continue;
    estimated.push_back(pair.estimated);
    truth.emplace_back(pair.truth->x, pair.truth->y);
  }
  if (const auto X_WL = align(estimated, truth)) figures.rmse = rms_distance(estimated, truth, *X_WL);
  if (std::ranges::all_of(recording.map, [](const TrueFeature& f) { return f.life == Lifetime{}; }))
    return figures;
  figures.gone = points(is_gone);
  figures.stale = paired(is_gone);
  figures.added = points(is_added);
  figures.added_found = paired(is_added);
  return figures;
}

/// Confirmed features that were forgotten while what they stand for was there and no other in the map stood
/// for it.
double wrongly_removed(const RunTrace& trace, const Recording& recording, const Labels& labels) {
  const auto is_held_otherwise = [&](const Removal& removal) {
    const int object = labels.majority(removal.change.feature);
    const auto is_of_another = [&](const Return& r) {
      const int feature = r.association.feature;
      if (feature < 0 || feature == removal.change.feature || r.instant > removal.instant) return false;
      const auto has_gone = [&](const Removal& other) {
        return other.change.feature == feature && other.instant <= removal.instant;
      };
      return labels.majority(feature) == object && std::ranges::none_of(trace.removals, has_gone);
    };
    return std::ranges::any_of(trace.returns, is_of_another);
  };
  const auto is_there = [&](const Removal& removal) {
    const auto& [instant, change] = removal;
    if (change.reason != MapChange::Reason::absent || !change.confirmed) return false;
    const auto truth = std::ranges::find(recording.map, labels.majority(change.feature), &TrueFeature::label);
    return truth != recording.map.end() && truth->life.contains(trace.states[instant].utime) &&
           !is_held_otherwise(removal);
  };
  return static_cast<double>(std::ranges::count_if(trace.removals, is_there));
}

std::optional<double> share(double part, const std::optional<double>& exists, double whole) {
  return exists ? std::optional(part / whole) : std::nullopt;
}

std::optional<double> in_degrees(std::optional<double> radians) {
  if (radians) radians = to_degrees(*radians);
  return radians;
}

double count(const std::vector<Return>& returns, Decision decision) {
  return static_cast<double>(
      std::ranges::count(returns, decision, [](const Return& r) { return r.association.decision; }));
}

}  // namespace

std::optional<Pose2> align(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b) {
  if (a.size() < 2) return std::nullopt;
  Eigen::Vector2d mean_a = Eigen::Vector2d::Zero(), mean_b = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) {
    mean_a += a[i] / static_cast<double>(a.size());
    mean_b += b[i] / static_cast<double>(a.size());
  }
  double dot = 0.0, cross = 0.0;  // in the plane Umeyama's SVD is one angle
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Eigen::Vector2d from = b[i] - mean_b, to = a[i] - mean_a;
    dot += from.dot(to);
    cross += from.x() * to.y() - from.y() * to.x();
  }
  if (dot == 0.0 && cross == 0.0) return std::nullopt;
  Pose2 X_AB{0.0, 0.0, std::atan2(cross, dot)};
  const Eigen::Vector2d shift = mean_a - transform(X_AB, mean_b);
  X_AB.x = shift.x();
  X_AB.y = shift.y();
  return X_AB;
}

std::optional<double> Judgement::value(std::string_view key) const {
  const auto figure = std::ranges::find(figures, key, &Figure::key);
  return figure == figures.end() ? std::nullopt : figure->value;
}

Judgement judge(const RunTrace& trace, const Recording& recording, TruthFrame truth_frame) {
  Judgement judgement;
  const bool in_world = truth_frame == TruthFrame::world;
  const Labels labels(trace.returns);

  PoseFigures poses;
  Statistic walls;
  if (in_world) {
    poses = judge_poses(trace, recording, judgement.consistency);
    walls = judge_walls(trace, recording, labels, judgement.consistency);
  }

  std::vector<Eigen::Vector2d> estimated, truth;
  for (const Truth& t : recording.truth) {
    const auto position = position_at(trace.states, t.utime);
    if (!position) continue;
    estimated.push_back(*position);
    truth.emplace_back(t.x, t.y);
  }
  judgement.X_WT = align(estimated, truth);
  std::optional<double> ate;
  if (judgement.X_WT) ate = rms_distance(estimated, truth, *judgement.X_WT);

  const MapFigures map = judge_map(trace, recording, labels, in_world);
  LandmarkFigures landmarks;
  const bool has_points =
      std::ranges::any_of(recording.map, [](const TrueFeature& f) { return f.kind == TargetKind::point; });
  if (has_points && (labels.known() || in_world || judgement.X_WT)) {
    const LandmarkPairs pairs =
        labels.known() ? pair_by_label(trace, recording, labels)
                       : pair_by_nearness(trace, recording, in_world ? Pose2{} : *judgement.X_WT);
    landmarks = judge_landmarks(pairs, trace, recording, labels, map.points);
  }

  std::optional<double> features_lost;
  if (labels.known() && !recording.map.empty()) features_lost = wrongly_removed(trace, recording, labels);

  std::optional<double> heading_ratio;
  if (poses.heading_sensor.rms() && *poses.heading_sensor.rms() > 0.0)
    heading_ratio = *poses.heading.rms() / *poses.heading_sensor.rms();
  const double judged =
      judgement.consistency.empty() ? 0.0 : static_cast<double>(judgement.consistency.size() - 1);
  const double duration =
      trace.states.empty()
          ? 0.0
          : 1e-6 * static_cast<double>(trace.states.back().utime - trace.states.front().utime);

  judgement.figures = {
      {"rmse_position_m", "position error, RMS", "m", poses.position.rms()},
      {"expected_position_error_m", "position error that the filter expects, RMS", "m", poses.expected.rms()},
      {"max_position_error_m", "position error, maximum", "m", poses.position.max()},
      {"final_position_error_m", "position error at the end", "m", poses.last_position},
      {"ate_se2_m", "trajectory error after alignment, RMS", "m", ate},
      {"rmse_heading_deg", "heading error, RMS", "deg", in_degrees(poses.heading.rms())},
      {"heading_sensor_rmse_deg", "heading sensor's error, RMS", "deg",
       in_degrees(poses.heading_sensor.rms())},
      {"heading_ratio", "heading error over sensor's error", "", heading_ratio},
      {"wall_error_max_m", "wall error, maximum", "m", walls.max()},
      {"wall_error_mean_m", "wall error, mean", "m", walls.mean()},
      {"nees_mean", "NEES of the pose, mean (3 expected)", "", poses.nees.mean()},
      {"nees_own_mean", "the same in the filter's own error", "", poses.own_nees.mean()},
      {"nees_inside_95", "NEES inside its 95 % band", "of instants",
       share(poses.inside, poses.nees.mean(), judged)},
      {"nees_not_above_95", "NEES inside or below it", "of instants",
       share(poses.not_above, poses.nees.mean(), judged)},
      {"features_confirmed", "features confirmed", "", map.points + map.walls},
      {"points_confirmed", "points among them", "", map.points},
      {"walls_confirmed", "walls among them", "", map.walls},
      {"features_right_kind", "right kind, of decided features with 5 returns", "", map.right_kind},
      {"features_undecided", "features with 5 returns undecided", "", map.undecided},
      {"points_false", "confirmed points that are walls", "", map.false_points},
      {"walls_false", "confirmed walls that are points", "", map.false_walls},
      {"wall_decided_after_s", "true walls: first return to decision, mean", "s", map.wall_decided_after},
      {"miss_rate", "chance of a ping to miss what it meets, as learnt, mean of the sensors", "",
       mean_miss_rate(trace.miss_rates)},
      {"walls_found", "true walls found", "", map.walls_found},
      {"walls_missed", "true walls with 5 returns missed", "", map.walls_missed},
      {"walls_duplicate", "walls mapped twice", "", map.walls_duplicate},
      {"landmarks_found", "true landmarks found, of those there at the end", "", landmarks.found},
      {"landmarks_spurious", "points that are no landmark there, or one again", "", landmarks.spurious},
      {"landmark_rmse_se2_m", "landmark error after alignment, RMS", "m", landmarks.rmse},
      {"landmarks_gone", "landmarks taken away that had been in the map", "", landmarks.gone},
      {"landmarks_stale", "of them still in the map", "", landmarks.stale},
      {"landmarks_added", "landmarks added", "", landmarks.added},
      {"landmarks_added_found", "of them found", "", landmarks.added_found},
      {"submaps", "submaps", "", static_cast<double>(trace.submaps.size())},
      {"reentries", "returns into a submap", "", static_cast<double>(trace.health.reentries)},
      {"loops_closed", "loops closed by them", "", static_cast<double>(trace.health.loops_closed)},
      {"features_unfetched", "features that a submap did without (map.separator_limit)", "",
       static_cast<double>(trace.health.features_unfetched)},
      {"features_absent", "features removed: not there", "",
       static_cast<double>(trace.health.features_absent)},
      {"features_displaced", "features removed: in the way of likelier ones", "",
       static_cast<double>(trace.health.features_displaced)},
      {"features_joined", "features joined with others", "",
       static_cast<double>(trace.health.features_joined)},
      {"features_lost", "confirmed features removed of what was there and in the map but once", "",
       features_lost},
      {"returns_matched", "returns matched", "",
       count(trace.returns, Decision::matched) + count(trace.returns, Decision::root)},
      {"returns_new", "returns that began a feature", "", count(trace.returns, Decision::fresh)},
      {"returns_waiting", "returns that waited for a second one", "",
       count(trace.returns, Decision::waiting)},
      {"returns_discarded", "returns discarded", "", count(trace.returns, Decision::discarded)},
      {"labels_refused", "labels refused: of other features, or dropped", "",
       trace.uses_labels ? std::optional(static_cast<double>(trace.health.labels_refused)) : std::nullopt},
      {"duration_s", "duration", "s", duration},
  };
  return judgement;
}

}  // namespace leadline::app
