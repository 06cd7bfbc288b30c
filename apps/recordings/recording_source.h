/// @file
/// Where a recording comes from, bit by bit: it need not be in memory as a whole.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline::app {

/// Gives instants and truth, each in the order of time; nothing at the end.
class RecordingSource {
 public:
  virtual ~RecordingSource() = default;

  virtual std::optional<Instant> next_instant() = 0;
  virtual std::optional<Truth> next_truth() = 0;
  virtual std::span<const TrueFeature> map() const = 0;
  /// Those behind the indices of the instants that have been given.
  virtual std::span<const Sensor> sensors() const = 0;
};

/// Another source, of which those who derive from this change the instants.
class ChangedSource : public RecordingSource {
 public:
  explicit ChangedSource(RecordingSource& source) : source_(source) {}

  std::optional<Truth> next_truth() override { return source_.next_truth(); }
  std::span<const TrueFeature> map() const override { return source_.map(); }
  std::span<const Sensor> sensors() const override { return source_.sensors(); }

 protected:
  std::optional<Instant> next_unchanged() { return source_.next_instant(); }

 private:
  RecordingSource& source_;
};

/// A recording that is in memory, and stays there.
class RecordedSource : public RecordingSource {
 public:
  RecordedSource(const Recording& recording, std::span<const Sensor> sensors)
      : recording_(recording), sensors_(sensors) {}

  std::optional<Instant> next_instant() override { return next(recording_.instants, instants_); }
  std::optional<Truth> next_truth() override { return next(recording_.truth, truth_); }
  std::span<const TrueFeature> map() const override { return recording_.map; }
  std::span<const Sensor> sensors() const override { return sensors_; }

 private:
  template <class T>
  static std::optional<T> next(const std::vector<T>& items, std::size_t& place) {
    return place < items.size() ? std::optional(items[place++]) : std::nullopt;
  }

  const Recording& recording_;
  std::span<const Sensor> sensors_;
  std::size_t instants_ = 0, truth_ = 0;  // given so far
};

}  // namespace leadline::app
