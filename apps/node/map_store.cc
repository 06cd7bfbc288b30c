#include "apps/node/map_store.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <exception>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "apps/node/map_file.h"
#include "apps/support/atomic_file.h"
#include "leadline/submap/slam.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

const std::string kCheckpoint = "checkpoint", kPrevious = "checkpoint.previous";

void write_map(const fs::path& path, const Snapshot& snapshot, const fs::path& previous = {}) {
  AtomicFile file(path);
  file.write(encode_map(snapshot));
  if (!previous.empty() && fs::exists(path)) fs::rename(path, previous);
  file.commit();
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
      write_map(path(kCheckpoint), snapshot, path(kPrevious));
    } catch (const std::exception& error) {
      trouble = error.what();
    }
    lock.lock();
    trouble_ = trouble;
  }
}

std::optional<Snapshot> MapStore::resume(const SlamOptions& options) {
  for (const std::string& name : {kCheckpoint, kPrevious}) {
    if (!fs::exists(path(name))) continue;
    try {
      return load(name, options);
    } catch (const std::exception& error) {
      const fs::path aside = path(name + ".bad");
      spdlog::warn("{}; put aside as {}", error.what(), aside.string());
      fs::rename(path(name), aside);
    }
  }
  return std::nullopt;
}

void MapStore::put_aside(const std::string& why) {
  const fs::path aside = path(kCheckpoint + ".old");
  spdlog::warn("the checkpoint {}; put aside as {}", why, aside.string());
  std::error_code missing;
  fs::rename(path(kCheckpoint), aside, missing);
}

void MapStore::save(const std::string& name, const Snapshot& snapshot) const {
  write_map(path(name), snapshot);
}

Snapshot MapStore::load(const std::string& name, const SlamOptions& options) const {
  Snapshot snapshot = read_map(path(name));
  try {
    const Slam slam(options, snapshot);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(
        fmt::format("{}: does not go with the configuration: {}", path(name).string(), error.what()));
  }
  return snapshot;
}

}  // namespace leadline::app
