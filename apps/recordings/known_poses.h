/// @file
/// Where the vehicle was, as something else than the estimator knows it: what mapping begins from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/recordings/recording_source.h"
#include "apps/support/spool.h"
#include "leadline/core/se2.h"
#include "leadline/vehicle/navigation_options.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// Poses X_WB over time.
class KnownPoses {
 public:
  /// Of a file: a trajectory `t x y z qx qy qz qw` with blanks between (TUM), or CSV with the columns t, x,
  /// y, heading [s, m, m, rad] and, if they are known, p_xx, p_xy, p_xh, p_yy, p_yh, p_hh [m, rad], as
  /// states.csv has them. @param sigmas of poses that bring none.
  /// @throws std::runtime_error naming file, line, column and what is allowed.
  KnownPoses(const std::filesystem::path& path, const ReadingSigmas& sigmas);

  /// The truth of a recording, as far as it has a heading.
  KnownPoses(const Spool<Truth>& truth, const ReadingSigmas& sigmas);

  /// At a time [us]: one of them, or on the straight way between two that are not more than kMostGap apart.
  std::optional<UncertainPose> at(std::int64_t utime) const;

  static constexpr std::int64_t kMostGap = 2'000'000;  ///< [us]

 private:
  struct Stamped {
    std::int64_t utime;
    UncertainPose X_WB;
  };
  void read_tum(const std::filesystem::path& path, const Eigen::Matrix3d& usual);
  void read_csv(const std::filesystem::path& path, const Eigen::Matrix3d& usual);
  void add(std::int64_t utime, const UncertainPose& X_WB, const std::string& place);

  std::vector<Stamped> poses_;  // in the order of time
};

/// A recording whose instants have the poses.
class PlacedSource : public ChangedSource {
 public:
  PlacedSource(RecordingSource& source, const KnownPoses& poses) : ChangedSource(source), poses_(poses) {}

  std::optional<Instant> next_instant() override {
    std::optional<Instant> instant = next_unchanged();
    if (instant) instant->pose = poses_.at(instant->utime);
    return instant;
  }

 private:
  const KnownPoses& poses_;
};

}  // namespace leadline::app
