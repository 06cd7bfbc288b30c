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

/// Goes along a track and finds the neighbours of times, if they are near enough to tell what was between
/// them. Times must not decrease.
template <class T>
class Along {
 public:
  explicit Along(const Spool<T>& track) : track_(track), next_(track.begin()) { advance(); }

  std::optional<Bracket<T>> at(std::int64_t utime) {
    while (after_ && after_->utime < utime) advance();
    if (!after_) return std::nullopt;
    if (after_->utime == utime) return Bracket<T>{&*after_, &*after_, 0.0};
    if (!before_) return std::nullopt;
    const std::int64_t gap = after_->utime - before_->utime;
    if (gap > kMaxGap) return std::nullopt;
    return Bracket<T>{&*before_, &*after_,
                      static_cast<double>(utime - before_->utime) / static_cast<double>(gap)};
  }

 private:
  void advance() {
    before_ = std::exchange(after_, std::nullopt);
    if (next_ != track_.end()) after_ = *next_++;
  }

  const Spool<T>& track_;
  typename Spool<T>::Iterator next_;
  std::optional<T> before_, after_;
};

std::optional<Truth> truth_at(Along<Truth>& track, std::int64_t utime) {
  const auto between = track.at(utime);
  if (!between) return std::nullopt;
  const auto& [a, b, share] = *between;
  Truth truth{utime, std::lerp(a->x, b->x, share), std::lerp(a->y, b->y, share), std::nullopt, std::nullopt};
  if (a->heading && b->heading)
    truth.heading = wrap_angle(*a->heading + share * angle_difference(*b->heading, *a->heading));
  return truth;
}

std::optional<Eigen::Vector2d> position_at(Along<VehicleState>& track, std::int64_t utime) {
  const auto between = track.at(utime);
  if (!between) return std::nullopt;
  const auto& [a, b, share] = *between;
  return Eigen::Vector2d(std::lerp(a->pose.x, b->pose.x, share), std::lerp(a->pose.y, b->pose.y, share));
}

double rms_distance(const Spool<PointPair>& pairs, const Pose2& X_AB) {
  double sum = 0.0;
  for (const auto& [a, b] : pairs) sum += (a - transform(X_AB, b)).squaredNorm();
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

/// [us], of the last instant.
std::int64_t end_of(const RunTrace& trace) { return trace.states.empty() ? 0 : trace.states.back().utime; }

const TrueFeature* find_true(const std::vector<TrueFeature>& map, int label, TargetKind kind) {
  const auto found =
      std::ranges::find_if(map, [&](const TrueFeature& f) { return f.label == label && f.kind == kind; });
  return found == map.end() ? nullptr : &*found;
}

/// Whose echoes each feature was made of.
class Labels {
 public:
  explicit Labels(const Spool<Return>& returns) {
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
const TrueFeature* true_wall(const std::vector<TrueFeature>& map, const Labels& labels, int feature,
                             const Belief::Line& line, const Truth& from) {
  const std::int64_t utime = from.utime;
  const double x = from.x, y = from.y;
  if (labels.known()) {
    const TrueFeature* wall = find_true(map, labels.majority(feature), TargetKind::wall);
    return wall && wall->life.contains(utime) ? wall : nullptr;
  }
  const TrueFeature* best = nullptr;
  double best_distance = 0.0;
  for (const TrueFeature& wall : map) {
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

std::optional<WallError> wall_error(const Return& r, const std::vector<TrueFeature>& map,
                                    const Labels& labels, const Truth& truth) {
  const TrueFeature* wall = true_wall(map, labels, r.association.feature, *r.wall, truth);
  if (!wall) return std::nullopt;
  const bool along_y = std::abs(std::cos(wall->alpha)) > std::abs(std::sin(wall->alpha));
  const double estimated = line_place(r.wall->rho, r.wall->alpha, truth.x, truth.y, along_y);
  return WallError{std::abs(estimated - line_place(wall->rho, wall->alpha, truth.x, truth.y, along_y)),
                   wall->label};
}

struct ErrorFigures {
  Statistic position, expected, heading, heading_sensor, nees, own_nees, walls;
  double inside = 0, not_above = 0;
  std::optional<double> last_position;
};

/// Estimates of an instant against the truth of its time.
class InstantJudge {
 public:
  InstantJudge(const RunTrace& trace, const GroundTruth& truth, const Labels& labels)
      : trace_(trace), truth_(truth), labels_(labels) {}

  ErrorFigures judge(Spool<Consistency>& rows) {
    Along<Truth> track(truth_.track);
    auto seen = trace_.returns.begin();
    std::size_t instant = 0;
    for (const VehicleState& state : trace_.states) {
      const auto truth = truth_at(track, state.utime);
      std::optional<Consistency> row;
      if (truth) row = judge_pose(state, *truth, rows.empty());
      for (; seen != trace_.returns.end(); ++seen) {
        const Return r = *seen;
        if (r.instant != instant) break;
        if (truth && r.wall) judge_wall(r, *truth, row);
      }
      if (row) rows.push_back(*row);
      ++instant;
    }
    return figures_;
  }

 private:
  /// @return nothing if the truth has no heading.
  std::optional<Consistency> judge_pose(const VehicleState& state, const Truth& truth, bool is_first) {
    Eigen::Vector3d error(truth.x - state.pose.x, truth.y - state.pose.y, 0.0);
    figures_.position.add(error.head<2>().norm());
    figures_.expected.add(std::sqrt(std::max(state.P.topLeftCorner<2, 2>().trace(), 0.0)));
    figures_.last_position = error.head<2>().norm();
    if (!truth.heading) return std::nullopt;

    error[2] = angle_difference(*truth.heading, state.pose.heading);
    figures_.heading.add(std::abs(error[2]));
    if (state.compass) figures_.heading_sensor.add(angle_difference(*state.compass, *truth.heading));

    Consistency row;
    row.utime = state.utime;
    row.error = error;
    row.sigma = state.P.diagonal().cwiseMax(0.0).cwiseSqrt();
    row.nees = nees(error, state.P);
    if (!is_first) {
      figures_.nees.add(row.nees);
      figures_.own_nees.add(
          pose_nees(trace_.error, {state.pose, state.P}, {truth.x, truth.y, *truth.heading}));
      figures_.inside += row.nees >= band_.low && row.nees <= band_.high;
      figures_.not_above += row.nees <= band_.high;
    }
    return row;
  }

  void judge_wall(const Return& r, const Truth& truth, std::optional<Consistency>& row) {
    const auto error = wall_error(r, truth_.map, labels_, truth);
    if (!error) return;
    figures_.walls.add(error->error);
    if (!row || row->wall_error >= error->error) return;
    row->wall_error = error->error;
    row->wall = error->wall;
  }

  const RunTrace& trace_;
  const GroundTruth& truth_;
  const Labels& labels_;
  const Band band_ = consistency_band(1, 3);
  ErrorFigures figures_;
};

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

MapFigures judge_map(const RunTrace& trace, const GroundTruth& truth, const Labels& labels, bool in_world) {
  MapFigures figures;
  double many = 0, right = 0, undecided = 0, false_points = 0, false_walls = 0;
  std::map<int, int> found;  // walls, by their labels
  int strange = 0;           // walls that are none
  const Pose2 last = trace.states.empty() ? Pose2{} : trace.states.back().pose;
  const Truth end{end_of(trace), last.x, last.y, std::nullopt, std::nullopt};
  for (const MapFeature& entry : trace.map) {
    const Feature& feature = entry.feature;
    const bool wall = feature.kind == FeatureKind::wall;
    if (feature.confirmed) ++(wall ? figures.walls : figures.points);
    if (feature.confirmed && wall) {
      const TrueFeature* stands_for = true_wall(truth.map, labels, feature.id, entry.line, end);
      if (stands_for)
        ++found[stands_for->label];
      else
        ++strange;
    }
    const int label = labels.majority(feature.id);
    const bool is_wall = find_true(truth.map, label, TargetKind::wall);
    if (!is_wall && !find_true(truth.map, label, TargetKind::point)) continue;
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
          find_true(truth.map, labels.majority(decided.feature), TargetKind::wall))
        after.add(decided.after);
    figures.wall_decided_after = after.mean();
  }
  if (std::ranges::none_of(truth.map, [](const TrueFeature& f) { return f.kind == TargetKind::wall; }) ||
      (!in_world && !labels.known()))
    return figures;

  figures.walls_found = static_cast<double>(found.size());
  figures.walls_duplicate = figures.walls - strange - static_cast<double>(found.size());
  if (labels.known()) {
    figures.walls_missed = std::ranges::count_if(truth.map, [&](const TrueFeature& f) {
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

LandmarkPairs pair_by_label(const RunTrace& trace, const GroundTruth& truth, const Labels& labels) {
  std::map<int, const MapFeature*> best;  // by label; of several the one seen most
  for (const MapFeature& entry : trace.map) {
    if (!entry.feature.confirmed || entry.feature.kind != FeatureKind::point) continue;
    const MapFeature*& place = best[labels.majority(entry.feature.id)];
    if (!place || entry.feature.hits > place->feature.hits) place = &entry;
  }
  LandmarkPairs pairs;
  for (const auto& [label, entry] : best) {
    if (const TrueFeature* point = find_true(truth.map, label, TargetKind::point))
      pairs.push_back({entry->position, point});
  }
  return pairs;
}

LandmarkPairs pair_by_nearness(const RunTrace& trace, const GroundTruth& truth, const Pose2& X_WT) {
  struct Candidate {
    double distance;
    std::size_t estimated, truth;
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < trace.map.size(); ++i) {
    if (!trace.map[i].feature.confirmed || trace.map[i].feature.kind != FeatureKind::point) continue;
    for (std::size_t j = 0; j < truth.map.size(); ++j) {
      const TrueFeature& point = truth.map[j];
      if (point.kind != TargetKind::point) continue;
      const double distance = (trace.map[i].position - transform(X_WT, {point.x, point.y})).norm();
      if (distance < kLandmarkGate) candidates.push_back({distance, i, j});
    }
  }
  std::ranges::stable_sort(candidates, {}, &Candidate::distance);
  std::vector<bool> used(trace.map.size()), found(truth.map.size());
  LandmarkPairs pairs;
  for (const auto& [distance, i, j] : candidates) {
    if (used[i] || found[j]) continue;
    used[i] = found[j] = true;
    pairs.push_back({trace.map[i].position, &truth.map[j]});
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
LandmarkFigures judge_landmarks(const LandmarkPairs& pairs, const RunTrace& trace, const GroundTruth& truth,
                                const Labels& labels, int confirmed) {
  const std::int64_t begin = trace.states.empty() ? 0 : trace.states.front().utime;
  const std::int64_t end = end_of(trace);
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
    return std::ranges::count_if(truth.map,
                                 [&](const TrueFeature& f) { return f.kind == TargetKind::point && is(f); });
  };

  LandmarkFigures figures;
  figures.found = paired(is_there);
  figures.spurious = confirmed - *figures.found;
  Spool<PointPair> places;
  for (const LandmarkPair& pair : pairs)
    if (is_there(*pair.truth)) places.push_back({pair.estimated, {pair.truth->x, pair.truth->y}});
  if (const auto X_WL = align(places)) figures.rmse = rms_distance(places, *X_WL);
  if (std::ranges::all_of(truth.map, [](const TrueFeature& f) { return f.life == Lifetime{}; }))
    return figures;
  figures.gone = points(is_gone);
  figures.stale = paired(is_gone);
  figures.added = points(is_added);
  figures.added_found = paired(is_added);
  return figures;
}

/// Confirmed features that were forgotten while what they stand for was there and no other in the map stood
/// for it.
double wrongly_removed(const RunTrace& trace, const GroundTruth& truth, const Labels& labels) {
  std::map<int, std::size_t> first_return, gone;  // instants, by feature
  for (const Return& r : trace.returns)
    if (r.association.feature >= 0) first_return.try_emplace(r.association.feature, r.instant);
  std::map<int, std::vector<int>> stand_for;  // features, by object
  for (const auto& [feature, instant] : first_return) stand_for[labels.majority(feature)].push_back(feature);
  for (const Removal& removal : trace.removals) gone.try_emplace(removal.change.feature, removal.instant);

  const auto is_held_otherwise = [&](const Removal& removal) {
    const auto is_there_then = [&](int feature) {
      const auto end = gone.find(feature);
      return feature != removal.change.feature && first_return.at(feature) <= removal.instant &&
             (end == gone.end() || end->second > removal.instant);
    };
    return std::ranges::any_of(stand_for[labels.majority(removal.change.feature)], is_there_then);
  };
  const auto is_there = [&](const Removal& removal) {
    const auto& [instant, change] = removal;
    if (change.reason != MapChange::Reason::absent || !change.confirmed) return false;
    const auto stands_for =
        std::ranges::find(truth.map, labels.majority(change.feature), &TrueFeature::label);
    return stands_for != truth.map.end() && stands_for->life.contains(trace.states[instant].utime) &&
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

/// How many returns were decided so, by decision.
std::map<Decision, double> decisions_of(const Spool<Return>& returns) {
  std::map<Decision, double> counts;
  for (const Return& r : returns) ++counts[r.association.decision];
  return counts;
}

}  // namespace

GroundTruth::GroundTruth(RecordingSource& source) : map(source.map().begin(), source.map().end()) {
  while (const std::optional<Truth> truth = source.next_truth()) track.push_back(*truth);
}

GroundTruth::GroundTruth(const Recording& recording)
    : track(std::span(recording.truth)), map(recording.map) {}

std::optional<Pose2> align(const Spool<PointPair>& pairs) {
  if (pairs.size() < 2) return std::nullopt;
  const auto n = static_cast<double>(pairs.size());
  Eigen::Vector2d mean_a = Eigen::Vector2d::Zero(), mean_b = Eigen::Vector2d::Zero();
  for (const auto& [a, b] : pairs) {
    mean_a += a / n;
    mean_b += b / n;
  }
  double dot = 0.0, cross = 0.0;  // in the plane Umeyama's SVD is one angle
  for (const auto& [a, b] : pairs) {
    const Eigen::Vector2d from = b - mean_b, to = a - mean_a;
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

Judgement judge(const RunTrace& trace, const GroundTruth& truth, TruthFrame truth_frame) {
  Judgement judgement;
  const bool in_world = truth_frame == TruthFrame::world;
  const Labels labels(trace.returns);

  ErrorFigures errors;
  if (in_world) errors = InstantJudge(trace, truth, labels).judge(judgement.consistency);

  Spool<PointPair> positions;
  Along<VehicleState> track(trace.states);
  for (const Truth& t : truth.track)
    if (const auto position = position_at(track, t.utime)) positions.push_back({*position, {t.x, t.y}});
  judgement.X_WT = align(positions);
  std::optional<double> ate;
  if (judgement.X_WT) ate = rms_distance(positions, *judgement.X_WT);

  const MapFigures map = judge_map(trace, truth, labels, in_world);
  LandmarkFigures landmarks;
  const bool has_points =
      std::ranges::any_of(truth.map, [](const TrueFeature& f) { return f.kind == TargetKind::point; });
  if (has_points && (labels.known() || in_world || judgement.X_WT)) {
    const LandmarkPairs pairs = labels.known()
                                    ? pair_by_label(trace, truth, labels)
                                    : pair_by_nearness(trace, truth, in_world ? Pose2{} : *judgement.X_WT);
    landmarks = judge_landmarks(pairs, trace, truth, labels, map.points);
  }

  std::optional<double> features_lost;
  if (labels.known() && !truth.map.empty()) features_lost = wrongly_removed(trace, truth, labels);

  std::optional<double> heading_ratio;
  if (errors.heading_sensor.rms() && *errors.heading_sensor.rms() > 0.0)
    heading_ratio = *errors.heading.rms() / *errors.heading_sensor.rms();
  const double judged =
      judgement.consistency.empty() ? 0.0 : static_cast<double>(judgement.consistency.size() - 1);
  const double duration =
      trace.states.empty()
          ? 0.0
          : 1e-6 * static_cast<double>(trace.states.back().utime - trace.states.front().utime);

  auto returns = decisions_of(trace.returns);
  judgement.figures = {
      {"rmse_position_m", "position error, RMS", "m", errors.position.rms()},
      {"expected_position_error_m", "position error that the filter expects, RMS", "m",
       errors.expected.rms()},
      {"max_position_error_m", "position error, maximum", "m", errors.position.max()},
      {"final_position_error_m", "position error at the end", "m", errors.last_position},
      {"ate_se2_m", "trajectory error after alignment, RMS", "m", ate},
      {"rmse_heading_deg", "heading error, RMS", "deg", in_degrees(errors.heading.rms())},
      {"heading_sensor_rmse_deg", "heading sensor's error, RMS", "deg",
       in_degrees(errors.heading_sensor.rms())},
      {"heading_ratio", "heading error over sensor's error", "", heading_ratio},
      {"wall_error_max_m", "wall error, maximum", "m", errors.walls.max()},
      {"wall_error_mean_m", "wall error, mean", "m", errors.walls.mean()},
      {"nees_mean", "NEES of the pose, mean (3 expected)", "", errors.nees.mean()},
      {"nees_own_mean", "the same in the filter's own error", "", errors.own_nees.mean()},
      {"nees_inside_95", "NEES inside its 95 % band", "of instants",
       share(errors.inside, errors.nees.mean(), judged)},
      {"nees_not_above_95", "NEES inside or below it", "of instants",
       share(errors.not_above, errors.nees.mean(), judged)},
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
      {"returns_matched", "returns matched", "", returns[Decision::matched] + returns[Decision::root]},
      {"returns_new", "returns that began a feature", "", returns[Decision::fresh]},
      {"returns_waiting", "returns that waited for a second one", "", returns[Decision::waiting]},
      {"returns_discarded", "returns discarded", "", returns[Decision::discarded]},
      {"labels_refused", "labels refused: of other features, or dropped", "",
       trace.uses_labels ? std::optional(static_cast<double>(trace.health.labels_refused)) : std::nullopt},
      {"duration_s", "duration", "s", duration},
  };
  return judgement;
}

}  // namespace leadline::app
