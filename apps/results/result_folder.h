/// @file
/// A folder of results that is there complete or not at all.
#pragma once

#include <array>
#include <filesystem>
#include <string_view>
#include <vector>

#include "apps/support/atomic_file.h"

namespace leadline::app {

/// Every file that a result folder may hold.
inline constexpr std::array<std::string_view, 17> kResultFiles{
    "trajectory.tum", "truth.tum",        "states.csv",  "map.csv",          "map_history.csv",
    "submaps.csv",    "submap_links.csv", "submaps.dot", "associations.csv", "changes.csv",
    "truth_map.csv",  "consistency.csv",  "trials.csv",  "nees.csv",         "summary.json",
    "timing.json",    "report.html"};

/// A folder that is there complete or not at all: filled under a temporary name beside its place and put
/// there by commit(). Without commit() nothing is left behind.
class ResultFolder {
 public:
  /// @param force an older result folder (one that holds nothing but kResultFiles) may be replaced.
  /// @throws std::runtime_error naming the folder and why: something is there that may not be replaced, or
  ///   the system's reason why it cannot be written; so do all others. The command's exit code is 1 for both.
  ResultFolder(const std::filesystem::path& path, bool force);
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  /// The folder to be filled. Its last part is the one it will have.
  const std::filesystem::path& path() const { return work_; }

  /// A file of the folder, to be written and committed.
  AtomicFile open(std::string_view file) const { return AtomicFile(work_ / file); }
  void write(std::string_view file, std::string_view content) const;

  /// Waits until the disk has it all.
  void commit();

 private:
  void remove_work();

  std::filesystem::path target_;
  std::filesystem::path temporary_;  // holds work_
  std::filesystem::path work_;
  std::vector<std::filesystem::path> made_;  // missing folders above the target, outermost first
};

}  // namespace leadline::app
