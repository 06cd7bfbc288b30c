#include "apps/node/map_checkpoints.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <exception>
#include <string>
#include <system_error>
#include <utility>

#include "apps/maps/map_file.h"
#include "apps/support/atomic_file.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

void write_file(const fs::path& path, std::span<const std::byte> bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

/// The number in a file's name, nothing if there is none.
std::optional<int> number_of(const fs::path& file) {
  const std::string name = file.filename().string();
  int number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  return error == std::errc() && number > 0 && end != name.data() ? std::optional(number) : std::nullopt;
}

fs::path with_suffix(const fs::path& head, const std::string& suffix) {
  fs::path path = head;
  return path.replace_extension(suffix + ".map");
}

/// The first name of this kind that no file has: "checkpoint.old.map", "checkpoint.old.2.map", ...
fs::path free_name(const fs::path& head, const std::string& suffix) {
  fs::path path = with_suffix(head, suffix);
  for (int number = 2; fs::exists(path); ++number)
    path = with_suffix(head, suffix + "." + std::to_string(number));
  return path;
}

/// Whether a file of this kind is there, whatever its number.
bool is_put_aside(const fs::path& head, const std::string& suffix) {
  const std::string begin = head.stem().string() + suffix + ".";
  const auto is_one = [&](const fs::directory_entry& entry) {
    return entry.path().filename().string().starts_with(begin);
  };
  return std::any_of(fs::directory_iterator(head.parent_path()), fs::directory_iterator(), is_one);
}

std::set<int> named_by(const fs::path& head) {
  const std::optional<Parts> parts = read_parts(head);
  if (!parts) return {};
  std::set<int> named(parts->submaps.begin(), parts->submaps.end());
  named.insert(parts->atlas);
  return named;
}

}  // namespace

MapCheckpoints::MapCheckpoints(const fs::path& directory)
    : newest_{directory / "checkpoint.map", {}}, previous_{directory / "checkpoint.previous.map", {}} {
  fs::create_directories(parts_folder(newest_.path));
  find_files();
}

/// What is there. Files that no head names, and those that were never completed, were left by a process that
/// was killed; unless there is a head that cannot be read, here or put aside: what that names is not known.
void MapCheckpoints::find_files() {
  bool all_known = true;
  for (Head* head : {&newest_, &previous_}) {
    all_known = all_known && !is_put_aside(head->path, ".bad");
    if (!fs::exists(head->path)) continue;
    try {
      head->named = named_by(head->path);
    } catch (const std::exception&) {  // resume() tells
      all_known = false;
    }
    files_.insert(head->named.begin(), head->named.end());
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(parts_folder(newest_.path))) {
    if (entry.path().extension() == ".part") fs::remove(entry.path());
    const std::optional<int> number = number_of(entry.path());
    if (!number) continue;
    next_number_ = std::max(next_number_, *number + 1);
    if (all_known) files_.insert(*number);
  }
}

void MapCheckpoints::write(const Snapshot& snapshot) {
  try {
    write_all(snapshot);
  } catch (...) {
    remove_unnamed();
    throw;
  }
  remove_unnamed();
}

void MapCheckpoints::write_all(const Snapshot& snapshot) {
  stored_.resize(snapshot.submaps.size());
  std::vector<int> numbers;
  for (std::size_t id = 0; id < stored_.size(); ++id) {
    const std::shared_ptr<const Submap>& submap = snapshot.submaps[id];
    if (stored_[id].submap != submap) stored_[id] = {submap, write_part(encode_submap(*submap))};
    numbers.push_back(stored_[id].number);
  }
  std::vector<std::byte> atlas = encode_atlas(snapshot, numbers);
  if (atlas != atlas_) {
    atlas_number_ = write_part(atlas);
    atlas_ = std::move(atlas);
  }
  AtomicFile head(newest_.path);
  head.write(encode_head(snapshot, atlas_number_));
  if (fs::exists(newest_.path)) {
    fs::rename(newest_.path, previous_.path);
    previous_.named = std::exchange(newest_.named, {});
  }
  head.commit();
  newest_.named = {numbers.begin(), numbers.end()};
  newest_.named.insert(atlas_number_);
}

int MapCheckpoints::write_part(const std::vector<std::byte>& bytes) {
  const int number = next_number_++;
  write_file(part_path(newest_.path, number), bytes);
  files_.insert(number);
  return number;
}

void MapCheckpoints::remove_unnamed() {
  std::set<int> needed = newest_.named;
  needed.insert(previous_.named.begin(), previous_.named.end());
  needed.insert(atlas_number_);
  for (const Stored& stored : stored_) needed.insert(stored.number);
  std::erase_if(files_, [&](int number) {
    if (needed.contains(number)) return false;
    std::error_code error;
    fs::remove(part_path(newest_.path, number), error);
    return !error;
  });
}

std::optional<Snapshot> MapCheckpoints::resume(const Load& load) {
  for (Head* head : {&newest_, &previous_}) {
    if (!fs::exists(head->path)) continue;
    try {
      Snapshot snapshot = load(head->path);
      adopt(snapshot, *head);
      return snapshot;
    } catch (const std::exception& error) {
      spdlog::warn("{}; put aside as {}", error.what(), move_aside(*head, ".bad").string());
    }
  }
  return std::nullopt;
}

/// What has just been read need not be written.
void MapCheckpoints::adopt(const Snapshot& snapshot, const Head& head) {
  const std::optional<Parts> parts = read_parts(head.path);
  if (!parts) return;
  stored_.clear();
  for (std::size_t id = 0; id < parts->submaps.size(); ++id)
    stored_.push_back({snapshot.submaps[id], parts->submaps[id]});
}

void MapCheckpoints::put_aside(const std::string& why) {
  if (!fs::exists(newest_.path)) return;
  spdlog::warn("the checkpoint {}; put aside as {}", why, move_aside(newest_, ".old").string());
}

/// @return where it is now.
fs::path MapCheckpoints::move_aside(Head& head, const std::string& suffix) {
  fs::path aside = free_name(head.path, suffix);
  const Head& other = &head == &newest_ ? previous_ : newest_;
  try {
    write_file(aside, encode_map(read_map(head.path)));
    fs::remove(head.path);
  } catch (const std::exception&) {
    fs::rename(head.path, aside);
    for (const int number : head.named)
      if (!other.named.contains(number)) files_.erase(number);
  }
  head.named.clear();
  return aside;
}

}  // namespace leadline::app
