/// @file
/// All sightings of an instant against the map, together.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "leadline/core/association/claim.h"
#include "leadline/core/association/joint_search.h"
#include "leadline/core/association/match.h"
#include "leadline/submap/local_map.h"
#include "leadline/submap/options.h"

namespace leadline {

/// For every sighting of an instant: a feature of the map, a new one, or neither. The matches are those that
/// are likeliest together, since all residuals share what is not known of the vehicle's pose; and each has an
/// alternative, that the echo comes from nothing in the map.
///
/// A sonar's echo is not asked of a feature whose place relative to the vehicle is vague and that has not
/// been seen of late: whatever is new would fall into its gate. Such an echo begins or feeds a young feature
/// beside the old one, and the Joiner finds out which are the same. A scan has the shape of its points to go
/// by: there a vague feature may be matched, but keeps none from being new.
///
/// Does not allocate after construction.
class ScanAssociator {
 public:
  static constexpr int kMostSightings = 32;

  explicit ScanAssociator(const SlamOptions& options);

  /// @param sightings at most kMostSightings, sound ones of one instant.
  /// @return one to each; features by their indices. Valid until the next call.
  std::span<const Match> operator()(LocalMap& map, std::span<const Sighting> sightings, std::int64_t utime);

 private:
  static constexpr int kMostOrigins = 6;  // of one sighting

  /// What a sighting may come from.
  struct Origin {
    int feature = 0;
    bool decided = false;
    bool sure = false;         // of its place: it was seen of late, or is known well
    double log_density = 0.0;  // [1/m]
    Claim claim;
  };
  /// A feature that a sighting is too near to for a new one.
  struct Veto {
    int sighting, feature;
  };

  /// Densities [1/m] of a sonar's range that copies another of the instant.
  struct CopyDensity {
    double cross_talk = 0.0, multipath = 0.0;
    double sum() const { return cross_talk + multipath; }
  };

  /// What the label of a sighting says.
  struct LabelEvidence {
    bool asked = false;
    bool in_map = false;
    int label = 0;
    double log_right = 0.0, log_wrong = 0.0;  // that it is right; that it is this one wrongly
    double log_labels = 0.0;                  // of their number

    bool is_own(const Feature& feature) const { return asked && feature.label == label; }
    double of(const Feature& feature) const;
    double of_new() const;
  };

  Vector<2> common_noise(const LocalMap& map, std::span<const Sighting> sightings, int a, int b) const;
  void learn_common(LocalMap& map, std::span<const Sighting> sightings) const;
  const Claim* sure_claim(const LocalMap& map, std::span<const Sighting> sightings, int i, int sensor) const;
  double density(const LocalMap& map, int sensor) const;
  CopyDensity copies_of_scanner(LocalMap& map, std::span<const Sighting> sightings, int i) const;
  CopyDensity copy_density(LocalMap& map, std::span<const Sighting> sightings, int i) const;
  void learn_returns(LocalMap& map, std::span<const Sighting> sightings) const;
  double score(const LocalMap& map, std::span<const Sighting> sightings, int i, int choice) const;
  double otherwise(const LocalMap& map, std::span<const Sighting> sightings, int i, int choice) const;
  Match match(const LocalMap& map, std::span<const Sighting> sightings, int i) const;
  void ask(LocalMap& map, std::span<const Sighting> sightings, int i, std::int64_t utime);
  LabelEvidence label_evidence(const LocalMap& map, int label) const;
  void ask_feature(LocalMap& map, std::span<const Sighting> sightings, int i, int k,
                   const LabelEvidence& label, std::int64_t utime);
  bool waits(const Sensor& sensor, double blur, bool recent) const;
  bool is_vetoed(std::span<const Sighting> sightings, int i) const;

  AssociationOptions options_;
  NearestNeighbour gates_;
  JointSearch search_;
  std::vector<Origin> origins_of_one_, origins_;  // of one sighting; of all, as in the search
  std::vector<Veto> vetoes_;
  std::vector<CopyDensity> copies_;  // by sighting
  std::vector<bool> waits_;          // by sighting, beside a feature
  std::vector<Match> matches_;
};

}  // namespace leadline
