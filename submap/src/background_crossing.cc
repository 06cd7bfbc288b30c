#include "background_crossing.h"

#include <algorithm>

namespace leadline {

namespace {

template <class T>
std::int64_t put_first(const std::vector<T>& from, std::vector<T>& to) {
  const std::size_t used = std::min<std::size_t>(from.size(), LocalSlam::kMaxSightings);
  to.assign(from.begin(), from.begin() + static_cast<std::ptrdiff_t>(used));
  return static_cast<std::int64_t>(from.size() - used);
}

}  // namespace

BackgroundCrossing::BackgroundCrossing(WholeSlam& whole, int steps)
    : whole_(&whole),
      ahead_(whole.local.options()),
      waiting_(static_cast<std::size_t>(steps)),
      worker_([this] { work(); }) {
  for (Waiting& waiting : waiting_) {
    waiting.instant.sightings.reserve(LocalSlam::kMaxSightings);
    waiting.instant.silent.reserve(LocalSlam::kMaxSightings);
  }
  const auto most = static_cast<std::size_t>(whole.local.options().features.capacity);
  told_.reserve(most);
  untold_.reserve(most);
}

BackgroundCrossing::BackgroundCrossing(const BackgroundCrossing& other, WholeSlam& whole)
    : BackgroundCrossing(whole, static_cast<int>(other.waiting_.size())) {
  ahead_ = other.ahead_;
  left_ = other.left_;
  centre_ = other.centre_;
  taken_ = other.taken_;
  has_crossed_ = other.has_crossed_;
  told_.assign(other.told_.begin(), other.told_.end());
  untold_.assign(other.untold_.begin(), other.untold_.end());
}

bool BackgroundCrossing::step(const Instant& instant) {
  if (is_under_way()) return step_ahead(instant);
  untold_.clear();
  const bool is_taken = whole_->local.step(instant);
  if (is_taken && whole_->submaps.is_left(whole_->local.map())) begin();
  return is_taken;
}

void BackgroundCrossing::begin() {
  ahead_ = whole_->local;
  centre_ = whole_->submaps.submaps()[static_cast<std::size_t>(whole_->submaps.current())].centre();
  left_ = static_cast<int>(waiting_.size());
  taken_ = 0;
  has_crossed_ = false;
  told_.clear();
  worker_.ask();
}

bool BackgroundCrossing::step_ahead(const Instant& instant) {
  put(instant);
  const bool is_taken = ahead_.step(instant);
  for (const MapChange& change : ahead_.map().changes())
    if (told_.size() < told_.capacity()) told_.push_back(change);
  const double outside = (ahead_.map().belief().pose().position() - centre_).norm();
  if (--left_ == 0 || outside > ahead_.options().submaps.used_radius()) finish();
  return is_taken;
}

/// Asks the whole to take an instant.
void BackgroundCrossing::put(const Instant& instant) {
  auto& [copy, refused] = waiting_[waiting_.size() - static_cast<std::size_t>(left_)];
  copy.utime = instant.utime;
  copy.input = instant.input;
  copy.heading = instant.heading;
  copy.speed = instant.speed;
  copy.velocity = instant.velocity;
  copy.yaw_rate = instant.yaw_rate;
  refused = put_first(instant.sightings, copy.sightings) + put_first(instant.silent, copy.silent);
  worker_.ask();
}

void BackgroundCrossing::finish() {
  worker_.wait();
  left_ = 0;
  std::erase_if(untold_, [&](const MapChange& change) {
    return std::ranges::find(told_, change.feature, &MapChange::feature) != told_.end();
  });
}

/// The worker's: first the crossing, then an instant each.
void BackgroundCrossing::work() {
  LocalMap& map = whole_->local.map();
  const std::size_t told = has_crossed_ ? 0 : map.changes().size();  // by the step that began it
  if (!has_crossed_) {
    whole_->cross();
    has_crossed_ = true;
  } else {
    const auto& [instant, refused] = waiting_[taken_++];
    map.health().bad_values += refused;
    whole_->step(instant);
  }
  const std::span<const MapChange> changes = map.changes().subspan(told);
  untold_.insert(untold_.end(), changes.begin(), changes.end());
}

}  // namespace leadline
