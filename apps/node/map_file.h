/// @file
/// What the estimator knows as a file: checkpoints, and maps that are saved and loaded by command.
///
/// A line "leadline map", the format's version, length and CRC-32 of the rest, and that in CBOR (RFC 8949): a
/// map with named entries, so that later versions can read what earlier ones wrote.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "leadline/submap/snapshot.h"

namespace leadline::app {

/// The file's bytes.
std::vector<std::byte> encode_map(const Snapshot& snapshot);

/// @throws std::runtime_error saying what is wrong with the bytes: no map, cut off, damaged, of a version
/// that is not known. Whether an estimator can go on with it, validate() says.
Snapshot decode_map(std::span<const std::byte> bytes);

/// @throws std::runtime_error naming the file and what is wrong with it.
Snapshot read_map(const std::filesystem::path& path);

}  // namespace leadline::app
