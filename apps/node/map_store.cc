#include "apps/node/map_store.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <exception>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "apps/maps/map_file.h"
#include "apps/support/atomic_file.h"
#include "leadline/submap/slam.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

/// @throws std::runtime_error naming the file, if there is none or one that cannot be gone on with.
Snapshot load_for(const SlamOptions& options, const fs::path& path) {
  Snapshot snapshot = read_map(path);
  try {
    const Slam slam(options, snapshot);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(
        fmt::format("{}: does not go with the configuration: {}", path.string(), error.what()));
  }
  return snapshot;
}

}  // namespace

MapStore::MapStore(fs::path directory) : directory_(std::move(directory)) {
  std::error_code error;
  fs::create_directories(directory_, error);
  if (error || !fs::is_directory(directory_))
    throw std::runtime_error(
        fmt::format("{}: is no directory and cannot be made one: {}", directory_.string(), error.message()));
  const fs::path lock = directory_ / "lock";
  std::ofstream(lock, std::ios::app).flush();
  try {
    lock_ = boost::interprocess::file_lock(lock.c_str());
    if (!lock_.try_lock()) throw std::runtime_error("another node uses it");
  } catch (const std::exception& failure) {
    throw std::runtime_error(fmt::format("{}: {}", directory_.string(), failure.what()));
  }
  checkpoints_.emplace(directory_);
  writer_ = std::jthread([this](const std::stop_token& stop) { write_checkpoints(stop); });
}

MapStore::~MapStore() = default;

fs::path MapStore::path(const std::string& name) const { return directory_ / (name + ".map"); }

void MapStore::checkpoint(Snapshot snapshot) {
  const std::scoped_lock lock(mutex_);
  waiting_ = std::move(snapshot);
  changed_.notify_one();
}

std::string MapStore::trouble() const {
  const std::scoped_lock lock(mutex_);
  return trouble_;
}

void MapStore::write_checkpoints(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return waiting_.has_value(); })) {
    const Snapshot snapshot = *std::exchange(waiting_, std::nullopt);
    lock.unlock();
    std::string trouble;
    try {
      const std::scoped_lock disk(disk_);
      checkpoints_->write(snapshot);
    } catch (const std::exception& error) {
      trouble = error.what();
    }
    lock.lock();
    trouble_ = trouble;
  }
}

std::optional<Snapshot> MapStore::resume(const SlamOptions& options) {
  const std::scoped_lock disk(disk_);
  return checkpoints_->resume([&](const fs::path& path) { return load_for(options, path); });
}

void MapStore::put_aside(const std::string& why) {
  const std::scoped_lock disk(disk_);
  checkpoints_->put_aside(why);
}

void MapStore::save(const std::string& name, const Snapshot& snapshot) const {
  write_map(path(name), snapshot);
}

Snapshot MapStore::load(const std::string& name, const SlamOptions& options) const {
  return load_for(options, path(name));
}

}  // namespace leadline::app
