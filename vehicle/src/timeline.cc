#include "leadline/vehicle/timeline.h"

#include <algorithm>
#include <variant>

namespace leadline {
namespace {

bool pinged(const Instant& instant, int sensor) {
  return std::ranges::find(instant.sightings, sensor, &Sighting::sensor) != instant.sightings.end() ||
         std::ranges::find(instant.silent, sensor) != instant.silent.end();
}

bool overlap(const Instant& a, const Instant& b) {
  return (a.input.index() != 0 && b.input.index() != 0) || (a.heading && b.heading) || (a.speed && b.speed) ||
         (a.velocity && b.velocity) || (a.yaw_rate && b.yaw_rate) ||
         std::ranges::any_of(b.sightings,
                             [&](const Sighting& sighting) { return pinged(a, sighting.sensor); }) ||
         std::ranges::any_of(b.silent, [&](int sensor) { return pinged(a, sensor); });
}

template <class T>
std::size_t sort_and_join(std::vector<T>& items, bool (*join)(T&, const T&)) {
  if (!std::ranges::is_sorted(items, {}, &T::utime)) std::ranges::stable_sort(items, {}, &T::utime);
  std::size_t joined = 0, left_out = 0;
  for (T& item : items) {
    if (joined == 0 || items[joined - 1].utime != item.utime) {
      if (&items[joined] != &item) items[joined] = std::move(item);
      ++joined;
    } else if (!join(items[joined - 1], item)) {
      ++left_out;
    }
  }
  items.resize(joined);
  return left_out;
}

}  // namespace

bool join(Instant& instant, const Instant& other) {
  if (overlap(instant, other)) return false;
  if (other.input.index() != 0) instant.input = other.input;
  if (other.heading) instant.heading = other.heading;
  if (other.speed) instant.speed = other.speed;
  if (other.velocity) instant.velocity = other.velocity;
  if (other.yaw_rate) instant.yaw_rate = other.yaw_rate;
  instant.sightings.insert(instant.sightings.end(), other.sightings.begin(), other.sightings.end());
  instant.silent.insert(instant.silent.end(), other.silent.begin(), other.silent.end());
  std::ranges::stable_sort(instant.sightings, {}, &Sighting::sensor);
  std::ranges::sort(instant.silent);
  return true;
}

std::size_t join_by_time(std::vector<Instant>& instants) { return sort_and_join<Instant>(instants, join); }

std::size_t join_by_time(std::vector<Truth>& truth) {
  return sort_and_join<Truth>(truth, [](Truth&, const Truth&) { return false; });
}

}  // namespace leadline
