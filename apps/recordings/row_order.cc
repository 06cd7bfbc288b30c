#include "apps/recordings/row_order.h"

#include <algorithm>
#include <numeric>

namespace leadline::app {
namespace {

constexpr std::size_t kNear = 3;  // rows from its place, where two writers or threads may have swapped them

/// Whether each row is in the longest series that is in order.
std::vector<bool> longest_series(std::span<const std::int64_t> utimes) {
  constexpr auto kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> ends;  // of the series of every length, the last row that is earliest
  std::vector<std::size_t> before(utimes.size(), kNone);
  for (std::size_t i = 0; i < utimes.size(); ++i) {
    const auto longer =
        std::ranges::upper_bound(ends, utimes[i], {}, [&](std::size_t j) { return utimes[j]; });
    if (longer != ends.begin()) before[i] = *std::prev(longer);
    if (longer == ends.end())
      ends.push_back(i);
    else
      *longer = i;
  }
  std::vector<bool> in_order(utimes.size());
  for (std::size_t i = ends.back(); i != kNone; i = before[i]) in_order[i] = true;
  return in_order;
}

/// How far each row is from its place.
std::vector<std::size_t> distances(std::span<const std::int64_t> utimes) {
  std::vector<std::size_t> order(utimes.size()), distance(utimes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return utimes[i]; });
  for (std::size_t rank = 0; rank < order.size(); ++rank)
    distance[order[rank]] = rank > order[rank] ? rank - order[rank] : order[rank] - rank;
  return distance;
}

}  // namespace

RowOrder order_of(std::span<const std::int64_t> utimes) {
  RowOrder result;
  if (std::ranges::is_sorted(utimes)) return result;
  const std::vector<bool> in_order = longest_series(utimes);
  const std::vector<std::size_t> distance = distances(utimes);
  std::vector<std::int64_t> kept;
  for (std::size_t i = 0; i < utimes.size(); ++i) {
    const bool far = !in_order[i] && distance[i] > kNear;
    if (!in_order[i]) (far ? result.astray : result.moved).push_back(i);
    if (!far) kept.push_back(utimes[i]);
  }
  result.reach = std::ranges::max(distances(kept));
  return result;
}

}  // namespace leadline::app
