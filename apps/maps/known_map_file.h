/// @file
/// A map that somebody names, to localize in it or to go on with it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <variant>

#include "leadline/submap/known_map.h"

namespace leadline::app {

/// One of
/// - a map that a node has saved, with all that is known of how its features depend on each other;
/// - the map.csv of a result folder, or that folder: what is confirmed in it, each feature with its
/// covariance
///   and independent of the others;
/// - landmarks: columns id, x, y [m], and sigma [m] where they are not exact; the id is the label.
class KnownMapFile {
 public:
  /// @throws std::runtime_error naming file, line, column and what is allowed.
  explicit KnownMapFile(const std::filesystem::path& path);

  /// What an estimator begins with in that map. @param utime of the first instant [us].
  /// @throws std::runtime_error naming the file, if it cannot.
  Snapshot begin(const SlamOptions& options, std::int64_t utime) const;

  /// What is in it, in W. @throws std::runtime_error as begin() does.
  FeatureMap features(const SlamOptions& options) const;

 private:
  std::filesystem::path path_;
  std::variant<Snapshot, FeatureMap> map_;
};

}  // namespace leadline::app
