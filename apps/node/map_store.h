/// @file
/// The maps in the node's state directory.
#pragma once

#include <boost/interprocess/sync/file_lock.hpp>
#include <condition_variable>
#include <cstddef>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "apps/node/map_checkpoints.h"
#include "leadline/submap/options.h"
#include "leadline/submap/snapshot.h"

namespace leadline::app {

/// For one process at a time: checkpoints, from which a node goes on after a crash, and maps saved under
/// names of their own. A file is there complete or not at all.
class MapStore {
 public:
  /// @throws std::runtime_error naming the directory if it cannot be made, or another node uses it.
  explicit MapStore(std::filesystem::path directory);
  /// Waits until the last checkpoint is written.
  ~MapStore();
  MapStore(const MapStore&) = delete;
  MapStore& operator=(const MapStore&) = delete;

  /// Returns at once; a thread encodes and writes. One that waits still is replaced.
  void checkpoint(Snapshot snapshot);

  /// Why the last checkpoint could not be written; empty if it was.
  std::string trouble() const;

  /// The newest checkpoint that can be gone on with. Those that cannot are put aside under another name, with
  /// a warning: nothing is ever lost.
  std::optional<Snapshot> resume(const SlamOptions& options);

  /// Puts the checkpoint aside.
  void put_aside(const std::string& why);

  /// Writes at once. @throws std::runtime_error naming the file.
  void save(const std::string& name, const Snapshot& snapshot) const;

  /// @throws std::runtime_error naming the file, if there is none or one that cannot be gone on with.
  Snapshot load(const std::string& name, const SlamOptions& options) const;

 private:
  std::filesystem::path path(const std::string& name) const;
  void write_checkpoints(const std::stop_token& stop);

  std::filesystem::path directory_;
  boost::interprocess::file_lock lock_;  // ends with the process, however that ends
  std::mutex disk_;                      // held while checkpoints are read or written
  std::optional<MapCheckpoints> checkpoints_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Snapshot> waiting_;
  std::string trouble_;
  std::jthread writer_;  // last: it uses all others
};

}  // namespace leadline::app
