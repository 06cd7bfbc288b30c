/// @file
/// Labels that the map contradicts: how often, and what that says of the objects that have them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "leadline/vehicle/recording.h"

namespace leadline {

/// What a label that is wrong now and then and one that is wrong of itself have in common is that their
/// returns fit another feature than the label says. Those of the first kind are spread over all features and
/// are few of each one's; those of the second kind are of one feature, and many of its returns. So what
/// counts is the share of a label among the returns of one feature, from the first one on that was strange.
///
/// Bounded, and does not allocate after construction but where it says so.
class LabelRecord {
 public:
  static constexpr int kMost = 64;            ///< of each table; the least of it makes room
  static constexpr int kFewest = 5;           ///< returns that a finding needs
  static constexpr double kLeastShare = 0.2;  ///< of a feature's returns

  LabelRecord();

  /// Returns of a channel whose label the map did not follow.
  struct Refusals {
    int sensor = 0;
    int label = 0;
    std::int64_t count = 0;

    friend bool operator==(const Refusals&, const Refusals&) = default;
  };
  void refuse(int sensor, int label);
  /// Of the channels and labels that have most; in no order.
  std::span<const Refusals> refusals() const { return refusals_; }

  /// A return that fits one feature.
  struct Vote {
    int feature = 0;  ///< id
    int label = 0;
    int usual = Sighting::kUnknown;  ///< label of the feature
    bool elsewhere = false;          ///< the label has another feature, well known, that it does not fit
  };
  void count(const Vote& vote);

  /// The feature is not in the map any more.
  void forget(int feature);

  /// What is wrong with the labels themselves.
  struct Finding {
    enum class Kind : std::int8_t {
      two_places,  ///< one label is on two objects
      one_place    ///< two labels are on one object
    };
    Kind kind = Kind::two_places;
    int label = 0;
    int other = Sighting::kUnknown;  ///< one_place: the second, the larger one

    friend bool operator==(const Finding&, const Finding&) = default;
  };
  /// Each once, in the order of kinds and labels. Allocates.
  std::vector<Finding> findings() const;

 private:
  /// A label at a feature of another label, or beside its own; what was counted since it was first there.
  struct Doubt {
    int feature = 0, label = 0, usual = Sighting::kUnknown;
    int votes = 0, strays = 0;  // of the label; those of them that fit no feature of their own
    int usual_votes = 0, all = 0;

    bool names_two_places() const { return is_many(strays); }
    bool is_one_place() const { return is_many(votes) && is_many(usual_votes); }
    bool is_many(int some) const { return some >= kFewest && some > kLeastShare * all; }
    double weight() const { return static_cast<double>(votes) * votes / all; }
  };

  std::vector<Refusals> refusals_;
  std::vector<Doubt> doubts_;  // the oldest first
};

}  // namespace leadline
