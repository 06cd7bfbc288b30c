#include "leadline/submap/relocalizer.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "heard_picture.h"
#include "landmark_index.h"
#include "leadline/core/angle.h"
#include "leadline/core/option_checker.h"
#include "leadline/core/semidefinite.h"
#include "place_odds.h"
#include "place_seed.h"
#include "placement.h"
#include "silence.h"

namespace leadline {

namespace {

/// Looking at a place closely costs as much as so many seeds.
constexpr int kPiecesOfCheck = 50;
/// Places kept to be looked at closely, for each that may be: most of them turn out to be one.
constexpr std::size_t kKeptOfCheck = 16;
/// Below the likeliest, in logarithms: what no sum notices.
constexpr double kNegligible = 20.0;
/// Two poses of one place differ by less, in standard deviations squared of three numbers (99 %).
constexpr double kSameGate = 11.3;
/// What is known better of a pose before than this is known so well: [m^2], [rad^2].
const Eigen::Vector3d kLeastPrior(1e-6, 1e-6, 1e-8);

/// log(e^a + e^b).
double log_sum(double a, double b) {
  const double more = std::max(a, b), less = std::min(a, b);
  return std::isinf(less) ? more : more + std::log1p(std::exp(less - more));
}

constexpr double kLogZero = -std::numeric_limits<double>::infinity();

std::vector<Landmark> checked(std::vector<Landmark> map) {
  for (const Landmark& landmark : map) {
    if (landmark.is_sound()) continue;
    refuse_option("landmark " + std::to_string(landmark.id), "not finite or has no covariance",
                  "finite, with a covariance and an extent");
  }
  return map;
}

RelocalizerOptions checked(const RelocalizerOptions& options) {
  validate(options);
  return options;
}

/// The prior with variances that can be divided by; nothing if it is none.
std::optional<PlacePrior> usable(PlacePrior prior) {
  if (!(prior.in_map >= 0.0 && prior.in_map <= 1.0)) return std::nullopt;
  if (prior.heading) {
    Reading& heading = *prior.heading;
    if (!are_within(Eigen::Vector2d(heading.value, heading.sigma), kFarthest) || heading.sigma < 0.0)
      return std::nullopt;
    heading.sigma = std::max(heading.sigma, std::sqrt(kLeastPrior[2]));
  }
  if (prior.X_WV) {
    auto& [X, P] = *prior.X_WV;
    if (!are_within(Eigen::Vector3d(X.x, X.y, X.heading), kFarthest) || !are_within(P, kFarthest * kFarthest))
      return std::nullopt;
    Eigen::Matrix3d L;
    if (!semidefinite_cholesky(P, L)) return std::nullopt;
    P = 0.5 * (P + P.transpose().eval());
    P.diagonal() += kLeastPrior;
  }
  return prior;
}

Eigen::Vector3d difference(const Pose2& to, const Pose2& from) {
  return {to.x - from.x, to.y - from.y, angle_difference(to.heading, from.heading)};
}

/// Gaussians of one place, the likeliest first, as one.
class Mixture {
 public:
  explicit Mixture(const Pose2& about) : about_(about) {}
  void add(const UncertainPose& pose, double weight) {
    const Eigen::Vector3d off = difference(pose.X, about_);
    weight_ += weight;
    mean_ += weight * off;
    square_ += weight * (pose.P + off * off.transpose());
  }
  UncertainPose pose() const {
    const Eigen::Vector3d mean = mean_ / weight_;
    return {{about_.x + mean.x(), about_.y + mean.y(), wrap_angle(about_.heading + mean.z())},
            square_ / weight_ - mean * mean.transpose()};
  }

 private:
  Pose2 about_;
  double weight_ = 0.0;
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square_ = Eigen::Matrix3d::Zero();
};

}  // namespace

/// A search under way. What does not change is shared by copies.
struct Relocalizer::Search {
  /// A hypothesis that is to be looked at closely.
  struct Candidate {
    PlaceSeed seed;
    RoughPose pose;
    double log_ratio = 0.0;
    double log_share = 0.0;  ///< of it, where as many seeds lead to the hypothesis as it has pairs
    int number = 0;          ///< in the order of the seeds
  };
  static std::tuple<double, int> rank(const Candidate& candidate) {
    return {-candidate.log_ratio, candidate.number};
  }

  Search(const RelocalizerOptions& given, std::vector<Landmark> landmarks)
      : options(given),
        map(std::make_shared<LandmarkIndex>(std::move(landmarks), given.reach,
                                            static_cast<std::size_t>(given.pairs))),
        solver(given) {}

  bool begin(const LocalPicture& picture, const PlacePrior& prior) {
    heard.reset();
    odds.reset();
    silence.reset();
    seeds.reset();
    candidates.clear();
    placements.clear();
    next = 0;
    tried = checks = 0;
    is_sorted = false;
    log_others = kLogZero;
    std::optional<HeardPicture> found = heard_picture(picture, options.features);
    const std::optional<PlacePrior> known = usable(prior);
    if (!found || !known) return false;
    in_map = known->in_map;
    heard = std::make_shared<HeardPicture>(*std::move(found));
    odds = std::make_shared<PlaceOdds>(options, *map, *heard, *known);
    silence = std::make_shared<Silence>(options, *heard, *map);
    best = std::max(odds->unrecognized(), 0.0);
    seeds.emplace(*heard, *map, *odds, options.seeds);
    return true;
  }

  bool advance(int pieces) {
    if (!seeds) return false;
    for (; pieces > 0 && !is_sorted; --pieces) try_seeds();
    while (pieces > 0 && next < candidates.size()) pieces -= look_closely(candidates[next++]);
    return !is_sorted || next < candidates.size();
  }

  void try_seeds() {
    const auto some = seeds->next(*heard, *map);
    if (some) {
      for (const PlaceSeed& seed : *some) try_seed(seed);
    } else {
      std::ranges::sort(candidates, {}, rank);
      is_sorted = true;
    }
  }

  void try_seed(const PlaceSeed& seed) {
    const std::optional<RoughPose> pose = rough_pose(seed, *heard, *map, odds->given(), options.wall_reach);
    if (!pose) return;
    const std::optional<RoughScore> score =
        rough_score(seed, *pose, *heard, *map, *odds, options.wall_reach, best - kNegligible);
    if (!score) return;
    best = std::max(best, score->log_ratio);
    const double pairs = seed.size == 1 ? 1.0 : 0.5 * score->matches * (score->matches - 1);
    candidates.push_back({seed, *pose, score->log_ratio, score->log_ratio - std::log(pairs), tried++});
    const std::size_t most = kKeptOfCheck * static_cast<std::size_t>(options.checks);
    if (candidates.size() >= 2 * most) keep_likeliest(most);
  }

  void keep_likeliest(std::size_t most) {
    const auto end = candidates.begin() + static_cast<std::ptrdiff_t>(most);
    std::ranges::nth_element(candidates, end, {}, rank);
    for (auto left = end; left != candidates.end(); ++left) log_others = log_sum(log_others, left->log_share);
    candidates.erase(end, candidates.end());
  }

  /// @return pieces of work that it was.
  int look_closely(const Candidate& candidate) {
    const bool line = is_line(candidate.seed, *heard);
    const auto holds = [&](const Placement& placement) {
      return placement.holds(candidate.seed, candidate.pose.X_WV, line);
    };
    if (std::ranges::any_of(placements, holds)) return 1;
    if (checks == options.checks || candidate.log_ratio < best - kNegligible) {
      log_others = log_sum(log_others, candidate.log_share);
      return 1;
    }
    ++checks;
    std::optional<Placement> placement =
        solver.solve(candidate.seed, candidate.pose, *heard, *map, *odds, *silence);
    if (placement) {
      best = std::max(best, placement->log_ratio);
      placements.push_back(*std::move(placement));
    }
    return kPiecesOfCheck;
  }

  PlaceAnswer result() const;
  bool is_same(const UncertainPose& a, const UncertainPose& b) const;
  std::vector<std::vector<const Placement*>> places() const;
  bool is_found(const PlaceAnswer& answer) const;

  RelocalizerOptions options;
  std::shared_ptr<const LandmarkIndex> map;
  PlacementSolver solver;
  std::shared_ptr<const HeardPicture> heard;
  std::shared_ptr<const PlaceOdds> odds;
  std::shared_ptr<const Silence> silence;
  std::optional<PlaceSeeds> seeds;
  std::vector<Candidate> candidates;
  std::vector<Placement> placements;
  std::size_t next = 0;
  int tried = 0, checks = 0;
  bool is_sorted = false;  // all seeds have been tried
  double in_map = 0.5;
  double best = 0.0;             // log ratio of all so far, rough ones among them
  double log_others = kLogZero;  // evidence of what was not looked at closely
};

/// Whether they lie no farther apart than poses of one place, and what each is not known by.
bool Relocalizer::Search::is_same(const UncertainPose& a, const UncertainPose& b) const {
  const Eigen::Vector3d off = difference(a.X, b.X);
  const Eigen::Vector3d same(options.same_place, options.same_place, options.same_heading);
  const auto within = [&](const Eigen::Matrix3d& P) {
    const Eigen::Matrix3d S = P + Eigen::Matrix3d(same.cwiseAbs2().asDiagonal());
    return off.dot(S.ldlt().solve(off)) < kSameGate;
  };
  return within(a.P) && within(b.P);
}

/// Placements by place, the likeliest first.
std::vector<std::vector<const Placement*>> Relocalizer::Search::places() const {
  std::vector<const Placement*> all;
  for (const Placement& placement : placements) all.push_back(&placement);
  std::ranges::stable_sort(all, std::ranges::greater(), &Placement::log_ratio);
  std::vector<std::vector<const Placement*>> result;
  for (const Placement* placement : all) {
    const auto same = std::ranges::find_if(
        result, [&](const auto& place) { return is_same(place.front()->X_WV, placement->X_WV); });
    if (same == result.end())
      result.push_back({placement});
    else
      same->push_back(placement);
  }
  return result;
}

PlaceAnswer Relocalizer::Search::result() const {
  PlaceAnswer answer;
  if (!seeds) return answer;
  answer.complete = seeds->complete();
  // All relative to the likeliest, of which there is one: a rough score may promise more than comes of it.
  const double log_in = std::log(in_map), log_out = std::log1p(-in_map);
  const double log_elsewhere = log_sum(log_out, log_in + odds->unrecognized());
  double most = std::max(log_elsewhere, log_in + log_others);
  for (const Placement& placement : placements) most = std::max(most, log_in + placement.log_ratio);
  const double elsewhere = std::exp(log_elsewhere - most);
  double others = std::exp(log_in + log_others - most), sum = elsewhere + others;
  for (const auto& placed : places()) {
    Mixture vehicle(placed.front()->X_WV.X), frame(placed.front()->X_WL.X);
    double weight = 0.0;
    for (const Placement* placement : placed) {
      weight += std::exp(log_in + placement->log_ratio - most);
      // Relative to the place's likeliest: of one that is out of the question there is still a pose.
      const double share = std::exp(placement->log_ratio - placed.front()->log_ratio);
      vehicle.add(placement->X_WV, share);
      frame.add(placement->X_WL, share);
    }
    sum += weight;
    Place place{vehicle.pose(), frame.pose(), weight, {}};
    for (const auto& [i, j] : placed.front()->matches)
      place.matches.push_back({(*heard)[i].id, (*map)[j].id});
    std::ranges::sort(place.matches, {}, &PlaceMatch::heard);
    answer.places.push_back(std::move(place));
  }
  std::ranges::stable_sort(answer.places, std::ranges::greater(), &Place::probability);
  while (std::ssize(answer.places) > options.places) {
    others += answer.places.back().probability;
    answer.places.pop_back();
  }
  answer.elsewhere = elsewhere / sum;
  answer.others = others / sum;
  for (Place& place : answer.places) place.probability /= sum;
  const double in_places = 1.0 - answer.elsewhere;
  if (answer.places.empty() || in_places < options.least_odds * answer.elsewhere)
    answer.verdict = PlaceAnswer::Verdict::nothing;
  else
    answer.verdict = is_found(answer) ? PlaceAnswer::Verdict::found : PlaceAnswer::Verdict::ambiguous;
  return answer;
}

bool Relocalizer::Search::is_found(const PlaceAnswer& answer) const {
  const Place& place = answer.places.front();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(place.X_WV.P.topLeftCorner<2, 2>(),
                                                            Eigen::EigenvaluesOnly);
  return place.probability >= options.sure &&
         axes.eigenvalues()[1] <= options.found_sigma * options.found_sigma;
}

Relocalizer::Relocalizer(const RelocalizerOptions& options, std::vector<Landmark> map)
    : search_(std::make_unique<Search>(checked(options), checked(std::move(map)))) {}

Relocalizer::Relocalizer(const Relocalizer& other) : search_(std::make_unique<Search>(*other.search_)) {}
Relocalizer::Relocalizer(Relocalizer&&) noexcept = default;
Relocalizer& Relocalizer::operator=(Relocalizer other) noexcept {
  std::swap(search_, other.search_);
  return *this;
}
Relocalizer::~Relocalizer() = default;

bool Relocalizer::begin(const LocalPicture& picture, const PlacePrior& prior) {
  return search_->begin(picture, prior);
}

bool Relocalizer::advance(int pieces) { return search_->advance(pieces); }

PlaceAnswer Relocalizer::result() const { return search_->result(); }

PlaceAnswer Relocalizer::search(const LocalPicture& picture, const PlacePrior& prior) {
  begin(picture, prior);
  while (advance(std::numeric_limits<int>::max())) {
  }
  return result();
}

const RelocalizerOptions& Relocalizer::options() const { return search_->options; }

}  // namespace leadline
