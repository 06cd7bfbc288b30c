/// @file
/// What comes nearly in the order of time, put in it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

namespace leadline::app {

/// How late the latecomers of a sequence are.
class Lateness {
 public:
  void add(std::int64_t utime) {
    most_ = std::max(most_, latest_.value_or(utime) - utime);
    latest_ = std::max(latest_.value_or(utime), utime);
  }
  /// [us], the most that one was behind the latest before it.
  std::int64_t most() const { return most_; }

 private:
  std::optional<std::int64_t> latest_;
  std::int64_t most_ = 0;
};

/// Puts items in the order of time, and those of one time together in the order in which they came. It holds
/// those of as much time as the latest are late.
template <class T>
class TimeOrder {
 public:
  /// Adds to an item another one of its time. @return false if that is not used.
  using Join = bool (*)(T&, const T&);

  /// @param lateness Lateness::most() of what will come [us].
  TimeOrder(std::int64_t lateness, Join join) : lateness_(lateness), join_(join) {}

  void add(T item) {
    const std::int64_t utime = item.utime;
    latest_ = std::max(latest_.value_or(utime), utime);
    const auto [place, is_new] = waiting_.try_emplace(utime, std::move(item));
    if (!is_new) left_out_ += !join_(place->second, item);
  }

  /// The next item to which nothing can be added any more. @param ended whether nothing more will come.
  std::optional<T> next(bool ended) {
    if (waiting_.empty() || (!ended && waiting_.begin()->first >= *latest_ - lateness_)) return std::nullopt;
    return std::move(waiting_.extract(waiting_.begin()).mapped());
  }

  /// Items that were not used.
  std::size_t left_out() const { return left_out_; }

 private:
  std::int64_t lateness_;
  Join join_;
  std::map<std::int64_t, T> waiting_;
  std::optional<std::int64_t> latest_;
  std::size_t left_out_ = 0;
};

}  // namespace leadline::app
