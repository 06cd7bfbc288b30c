#include "leadline/submap/slam.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "background_crossing.h"
#include "displacement_watch.h"
#include "leadline/submap/landmark.h"
#include "leadline/submap/place_search.h"
#include "leadline/submap/world_map.h"
#include "leadline/vehicle/elapsed.h"
#include "whole_slam.h"

namespace leadline {

namespace {

std::unique_ptr<BackgroundCrossing> background_of(WholeSlam& whole) {
  const int steps = whole.local.options().submaps.crossing_steps;
  return steps > 0 ? std::make_unique<BackgroundCrossing>(whole, steps) : nullptr;
}

void put_into(const WholeSlam& whole, Snapshot& snapshot) {
  const auto& [local, submaps] = whole;
  local.put_into(snapshot);
  snapshot.current = submaps.current();
  snapshot.in_use = submaps.in_use();
  snapshot.submaps = submaps.shared_submaps();
  snapshot.places = submaps.rough_places();
  snapshot.links = submaps.graph().links();
  snapshot.next_gate = submaps.next_gate();
}

constexpr double kAnyHeading = from_degrees(60.0);  // [rad], of one who is lost
constexpr double kInMap = 0.5;                      // prior probability that one who is lost is in the map
constexpr std::int64_t kSecond = 1'000'000;         // [us]
/// Fewer features have no shape.
constexpr std::size_t kFewestOld = 3;

/// Where that L is, if the vehicle is known to be there.
UncertainPose frame_of(const SlamOptions& options, UncertainPose X_WB) {
  if (options.submaps.orientation != Orientation::absolute) return X_WB;
  X_WB.X.heading = 0.0;
  X_WB.P.row(2).setZero();
  X_WB.P.col(2).setZero();
  return X_WB;
}

/// What a search takes of the map.
std::vector<Landmark> searchable(const Slam& slam) {
  std::vector<Landmark> map = landmarks(world_map(slam));
  std::erase_if(map, [](const Landmark& landmark) { return !landmark.is_sound(); });
  return map;
}

bool is_wide(const UncertainPose& X, double limit) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(X.P.topLeftCorner<2, 2>());
  return axes.eigenvalues()[1] > limit * limit;
}

}  // namespace

Slam::Slam(const SlamOptions& options)
    : whole_((validate(options), std::make_unique<WholeSlam>(options))),
      background_(background_of(*whole_)),
      displacement_(std::make_unique<DisplacementWatch>(options.relocalization)) {}

Slam::Slam(const SlamOptions& options, const Snapshot& snapshot)
    : whole_(
          (validate(options), validate(snapshot, options), std::make_unique<WholeSlam>(options, snapshot))),
      background_(background_of(*whole_)),
      displacement_(std::make_unique<DisplacementWatch>(options.relocalization)) {
  look_if_wide();
}

Slam::Slam(const Slam& other)
    : whole_(std::make_unique<WholeSlam>(other.whole())),
      background_(other.background_ ? std::make_unique<BackgroundCrossing>(*other.background_, *whole_)
                                    : nullptr),
      search_(other.search_ ? std::make_unique<PlaceSearch>(*other.search_) : nullptr),
      known_(other.known_ ? std::make_unique<WholeSlam>(*other.known_) : nullptr),
      doubt_(other.doubt_),
      displacement_(std::make_unique<DisplacementWatch>(*other.displacement_)),
      relocalizations_(other.relocalizations_),
      places_(other.places_) {}

Slam::Slam(Slam&&) noexcept = default;

Slam& Slam::operator=(Slam other) noexcept {
  std::swap(background_, other.background_);
  std::swap(whole_, other.whole_);
  std::swap(search_, other.search_);
  std::swap(known_, other.known_);
  std::swap(doubt_, other.doubt_);
  std::swap(displacement_, other.displacement_);
  std::swap(relocalizations_, other.relocalizations_);
  std::swap(places_, other.places_);
  return *this;
}

Slam::~Slam() = default;

bool Slam::step(const Instant& instant) {
  if (is_looking()) {
    const int before = search_->searches();
    const bool is_taken = search_->step(instant);
    if (search_->searches() > before) places_ = search_->answer();
    if (search_->found()) come_back();
    return is_taken;
  }
  const bool is_taken = background_ ? background_->step(instant) : whole_->step(instant);
  if (!is_taken || !may_look()) return is_taken;
  if (search_)
    doubt(instant);
  else if (utime() >= doubt_ && is_lost())
    begin_doubt();
  return true;
}

bool Slam::may_look() const {
  const SlamOptions& options = this->options();
  return options.relocalization.when_lost && options.association.method != AssociationMethod::nnsf &&
         options.problem != Problem::mapping && !is_crossing();
}

/// By what has contradicted the estimate for long, or because what it hears is elsewhere; in localization
/// nothing tells what is heard of what is not in the map.
bool Slam::is_lost() {
  constexpr double kLeastSupport = 0.7;
  const LocalSlam& local = whole_->local;
  if (options().problem == Problem::localization && local.judge().supported() < kLeastSupport) return true;
  if (local.judge().is_map_unmet() || local.wrong_for() > options().relocalization.lost_for) return true;
  return displacement_->is_displaced(local, [this] { return searchable(*this); });
}

/// From now on there are two: one that goes on as it believes, and one that has lost its place and looks for
/// it in what was known before. Who finds out that it is lost has been so for some time, and has begun
/// features where they are not.
void Slam::begin_doubt() {
  displacement_->restart();
  doubt_ = utime() + kSecond;
  std::vector<Landmark> map = searchable(*this);
  const int first_young = whole_->local.births().first_young();
  const auto is_young = [&](const Landmark& landmark) { return landmark.id >= first_young; };
  const auto old = static_cast<std::size_t>(std::ranges::count_if(map, std::not_fn(is_young)));
  if (map.size() < kFewestOld) return;
  known_ = std::make_unique<WholeSlam>(*whole_);
  if (old >= kFewestOld) {
    std::erase_if(map, is_young);
    known_->local.map().forget_from(first_young);
  }
  LocalSlam own = whole_->local;
  own.lose_place(pose_in_own_frame(options(), {own.pose().X.heading, kAnyHeading}));
  search_ = std::make_unique<PlaceSearch>(std::move(own), std::move(map), PlaceSearch::Known{{}, kInMap});
  doubt_ = utime();
}

/// Until it is known which of the two is right, or what is heard is new for all that is known.
void Slam::doubt(const Instant& instant) {
  search_->step(instant);
  const RelocalizationOptions& relocalization = options().relocalization;
  const Place* place = search_->found();
  if (place && !is_at(*place, local().pose(), relocalization.search)) {
    *whole_ = std::move(*known_);
    known_.reset();
    ++relocalizations_.lost;
    places_ = search_->answer();
    come_back();
  } else if (place || seconds_between(doubt_, utime()) > relocalization.memory) {
    end_doubt();
  }
}

void Slam::end_doubt() {
  search_.reset();
  known_.reset();
  displacement_->restart();
  doubt_ = utime() + 30 * kSecond;
}

void Slam::relocalize() {
  if (!is_looking()) look({});
}

void Slam::look_if_wide() {
  const RelocalizationOptions& relocalization = options().relocalization;
  if (relocalization.when_lost && is_wide(pose(), relocalization.wide)) look(pose());
}

/// The estimate is believed no longer. @param X_WB what is known of the vehicle; nothing: it may be anywhere.
void Slam::look(const std::optional<UncertainPose>& X_WB) {
  if (options().problem == Problem::mapping) return;
  finish_crossing();
  std::vector<Landmark> map = searchable(*this);
  if (map.size() < kFewestOld) return;
  LocalSlam own = whole_->local;
  const Reading heading =
      X_WB ? Reading{X_WB->X.heading, std::sqrt(X_WB->P(2, 2))} : Reading{own.pose().X.heading, kAnyHeading};
  own.lose_place(pose_in_own_frame(options(), heading));
  search_ = std::make_unique<PlaceSearch>(
      std::move(own), std::move(map),
      PlaceSearch::Known{X_WB ? std::optional(frame_of(options(), *X_WB)) : std::nullopt, kInMap});
  known_.reset();
  places_.reset();
  ++relocalizations_.lost;
}

void Slam::come_back() {
  const Place& place = *search_->found();
  if (!whole_->find_place(search_->own(), {place.X_WL, place.matches})) return;
  end_doubt();
  ++relocalizations_.found;
}

Snapshot Slam::snapshot() const {
  Snapshot snapshot;
  if (is_looking()) {
    WholeSlam known = whole();
    known.local.take_over(search_->own());
    known.local.set_pose(pose());
    put_into(known, snapshot);
  } else {
    put_into(whole(), snapshot);
  }
  return snapshot;
}

bool Slam::set_pose(const UncertainPose& X_WB) {
  finish_crossing();
  if (is_looking()) {
    const UncertainPose X_WL = oplus(X_WB, inverse(search_->own().pose()));
    if (!whole_->find_place(search_->own(), {X_WL, {}})) return false;
  } else {
    if (!whole_->local.set_pose(X_WB)) return false;
    whole_->cross();
  }
  end_doubt();
  look_if_wide();
  return true;
}

void Slam::set_clock(std::int64_t utime) {
  finish_crossing();
  const std::int64_t shift = shift_between(this->utime(), utime);
  whole_->shift_clock(shift);
  if (known_) known_->shift_clock(shift);
  doubt_ += shift;
  displacement_->shift_clock(shift);
  if (search_) search_->set_clock(utime);
}

UncertainPose Slam::pose_at(std::int64_t utime) const {
  const UncertainPose X = local().pose_at(utime);
  return is_looking() ? oplus(search_->frame(), X) : X;
}

UncertainPose Slam::pose() const { return is_looking() ? search_->pose() : local().pose(); }

UncertainPose Slam::local_pose() const {
  if (is_looking()) return oplus({inverse(whole_->local.frame())}, pose());
  return {belief().pose(), belief().pose_covariance()};
}

Pose2 Slam::frame() const { return is_looking() ? search_->frame().X : local().frame(); }

Joint Slam::joint_in_world() const {
  if (!is_looking()) return local().joint_in_world();
  Joint joint = map().joint();
  joint.set_pose(kWorld, inverse(search_->frame()));
  joint.reexpress(kWorld, kWorld);
  return joint;
}

std::span<const MapChange> Slam::changes() const {
  // While a crossing is under way its thread writes what is not told yet.
  return background_ && !is_crossing() && !background_->untold().empty() ? background_->untold()
                                                                         : map().changes();
}

const SlamOptions& Slam::options() const { return whole_->local.options(); }

bool Slam::is_crossing() const { return background_ && background_->is_under_way(); }

const SubmapManager& Slam::submaps() const { return whole().submaps; }

SubmapManager::Content Slam::content(int submap) const {
  return whole().submaps.content(submap, whole().local.map());
}

std::vector<SubmapManager::Content> Slam::contents() const {
  return whole().submaps.contents(whole().local.map());
}

UncertainPose Slam::place(int submap) const { return whole().submaps.place(submap, whole().local.map()); }

const LocalSlam& Slam::local() const {
  if (is_looking()) return search_->own();
  return is_crossing() ? background_->ahead() : whole_->local;
}

const WholeSlam& Slam::whole() const {
  if (background_) background_->wait();
  return *whole_;
}

void Slam::finish_crossing() {
  if (is_crossing()) background_->finish();
}

}  // namespace leadline
