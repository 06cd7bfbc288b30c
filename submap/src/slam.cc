#include "leadline/submap/slam.h"

#include <utility>

#include "background_crossing.h"
#include "leadline/vehicle/elapsed.h"
#include "whole_slam.h"

namespace leadline {

namespace {

std::unique_ptr<BackgroundCrossing> background_of(WholeSlam& whole) {
  const int steps = whole.local.options().submaps.crossing_steps;
  return steps > 0 ? std::make_unique<BackgroundCrossing>(whole, steps) : nullptr;
}

}  // namespace

Slam::Slam(const SlamOptions& options)
    : whole_((validate(options), std::make_unique<WholeSlam>(options))),
      background_(background_of(*whole_)) {}

Slam::Slam(const SlamOptions& options, const Snapshot& snapshot)
    : whole_(
          (validate(options), validate(snapshot, options), std::make_unique<WholeSlam>(options, snapshot))),
      background_(background_of(*whole_)) {}

Slam::Slam(const Slam& other)
    : whole_(std::make_unique<WholeSlam>(other.whole())),
      background_(other.background_ ? std::make_unique<BackgroundCrossing>(*other.background_, *whole_)
                                    : nullptr) {}

Slam::Slam(Slam&&) noexcept = default;

Slam& Slam::operator=(Slam other) noexcept {
  std::swap(background_, other.background_);
  std::swap(whole_, other.whole_);
  return *this;
}

Slam::~Slam() = default;

bool Slam::step(const Instant& instant) {
  return background_ ? background_->step(instant) : whole_->step(instant);
}

Snapshot Slam::snapshot() const {
  Snapshot snapshot;
  const auto& [local, submaps] = whole();
  local.put_into(snapshot);
  snapshot.current = submaps.current();
  snapshot.in_use = submaps.in_use();
  snapshot.submaps = submaps.shared_submaps();
  snapshot.places = submaps.rough_places();
  snapshot.links = submaps.graph().links();
  snapshot.next_gate = submaps.next_gate();
  return snapshot;
}

bool Slam::set_pose(const UncertainPose& X_WB) {
  finish_crossing();
  if (!whole_->local.set_pose(X_WB)) return false;
  whole_->cross();
  return true;
}

void Slam::set_clock(std::int64_t utime) {
  finish_crossing();
  whole_->submaps.shift_clock(shift_between(whole_->local.utime(), utime));
  whole_->local.set_clock(utime);
}

UncertainPose Slam::pose_at(std::int64_t utime) const { return local().pose_at(utime); }

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

const LocalSlam& Slam::local() const { return is_crossing() ? background_->ahead() : whole_->local; }

const WholeSlam& Slam::whole() const {
  if (background_) background_->wait();
  return *whole_;
}

void Slam::finish_crossing() {
  if (is_crossing()) background_->finish();
}

}  // namespace leadline
