/// @file
/// The checkpoints in the node's state directory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "leadline/submap/snapshot.h"

namespace leadline::app {

/// "checkpoint.map", "checkpoint.previous.map", the one before, and the files that they name (map_file.h).
///
/// A checkpoint writes what has changed since the last one: the submaps that have been left meanwhile, the
/// atlas if there were any, and the head. The head comes last and takes its place by rename, so that
/// whenever the process is killed there is one that names only what is complete; files that no head names any
/// more are removed after that.
///
/// Not for several threads at once.
class MapCheckpoints {
 public:
  explicit MapCheckpoints(const std::filesystem::path& directory);

  /// @throws std::runtime_error naming the file that cannot be written; the last checkpoint is there still.
  void write(const Snapshot& snapshot);

  /// Reads a map and says by an exception what is wrong with it.
  using Load = std::function<Snapshot(const std::filesystem::path&)>;

  /// The newest that can be loaded. Others are put aside under another name with a warning: in one file if
  /// they can be read, as they are if not; what only those name is never removed then.
  std::optional<Snapshot> resume(const Load& load);

  /// Puts the newest aside as one file, "checkpoint.old.map", "checkpoint.old.2.map", ...: nothing that was
  /// put aside is overwritten.
  void put_aside(const std::string& why);

 private:
  struct Head {
    std::filesystem::path path;
    std::set<int> named;
  };
  /// A submap and the file it is in.
  struct Stored {
    std::shared_ptr<const Submap> submap;
    int number = 0;
  };

  void find_files();
  void write_all(const Snapshot& snapshot);
  int write_part(const std::vector<std::byte>& bytes);
  void adopt(const Snapshot& snapshot, const Head& head);
  std::filesystem::path move_aside(Head& head, const std::string& suffix);
  void remove_unnamed();

  Head newest_, previous_;
  std::vector<Stored> stored_;  // by id
  std::vector<std::byte> atlas_;
  int atlas_number_ = 0;
  std::set<int> files_;  // that may be removed when nothing names them
  int next_number_ = 1;  // never one that was there before
};

}  // namespace leadline::app
