/// @file
/// What the estimator knows as a file: maps that are saved and loaded by command, and checkpoints.
///
/// A line "leadline map", the format's version, length and CRC-32 of the rest, and that in CBOR (RFC 8949): a
/// map with named entries, so that later versions can read what earlier ones wrote.
///
/// A saved map is one file. A checkpoint is a small one, the head, which names others by their numbers: one
/// for each submap that has been left, and one, the atlas, that lists those and holds what the graph knows.
/// They are never changed, so a checkpoint writes what is new and names what was there. All are in the folder
/// that parts_folder() says.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "leadline/submap/snapshot.h"

namespace leadline::app {

/// Of the format that is written, and alone is read.
inline constexpr std::uint32_t kMapVersion = 5;

/// Whether a file begins as maps do. @throws std::runtime_error naming it if it cannot be read.
bool is_map_file(const std::filesystem::path& path);

/// The bytes of a saved map.
std::vector<std::byte> encode_map(const Snapshot& snapshot);

/// @throws std::runtime_error saying what is wrong with the bytes: no map, cut off, damaged, of a version
/// that is not known, or a head, which is not all of a map. Whether an estimator can go on with it,
/// validate() says.
Snapshot decode_map(std::span<const std::byte> bytes);

/// A map as a file, there complete or not at all. @throws std::runtime_error naming it.
void write_map(const std::filesystem::path& path, const Snapshot& snapshot);

/// The bytes of a checkpoint's files. @param atlas, submaps numbers of files.
std::vector<std::byte> encode_head(const Snapshot& snapshot, int atlas);
std::vector<std::byte> encode_atlas(const Snapshot& snapshot, std::span<const int> submaps);
std::vector<std::byte> encode_submap(const Submap& submap);

/// Where a head's other files are, and the name of one of them.
std::filesystem::path parts_folder(const std::filesystem::path& head);
std::filesystem::path part_path(const std::filesystem::path& head, int number);

/// A saved map, or a head with all that it names.
/// @throws std::runtime_error naming the file that cannot be read and what is wrong with it.
Snapshot read_map(const std::filesystem::path& path);

/// Numbers of the files that a head names.
struct Parts {
  int atlas = 0;
  std::vector<int> submaps;  ///< by id
};

/// @return nothing of a saved map. @throws std::runtime_error as read_map() does.
std::optional<Parts> read_parts(const std::filesystem::path& head);

}  // namespace leadline::app
