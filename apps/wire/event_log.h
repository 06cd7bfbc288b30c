/// @file
/// LCM event logs, the files of lcm-logger and lcm-logplayer.
///
/// A log is a sequence of events, all numbers big-endian: sync word 0xeda1da01 (4 bytes), number (8),
/// timestamp [us] (8), length of the channel (4), length of the data (4), channel (not terminated), data. It
/// is read here and not by lcm::LogFile, which allocates whatever the lengths say.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "apps/support/atomic_file.h"
#include "apps/wire/wire.h"

namespace leadline::app {

/// Writes a log that is there complete or not at all.
class EventLogWriter {
 public:
  /// @throws std::runtime_error naming the file if it cannot be written; so do all others.
  explicit EventLogWriter(const std::filesystem::path& path) : file_(path) {}

  /// @throws std::invalid_argument if @p channel is longer than LCM allows.
  void write(std::int64_t timestamp, std::string_view channel, Bytes data);

  void commit() { file_.commit(); }

 private:
  AtomicFile file_;
  std::int64_t number_ = 0;
};

/// What of a log is no event: the tail that was being written when the power went, a bad sector.
struct LogDamage {
  std::uintmax_t bytes = 0;  ///< passed over
  std::string first;         ///< where, and what is wrong there

  explicit operator bool() const { return bytes > 0; }
};

/// Reads a log front to back; a length is checked against what is left of the file before it is used. What is
/// no event is passed over.
class EventLogReader {
 public:
  /// @throws std::runtime_error naming the file, and the byte where it cannot be read; so do all others.
  explicit EventLogReader(const std::filesystem::path& path);

  /// Moves to the next event; false at the end of the file.
  /// @throws std::runtime_error also if there is none in the whole file.
  bool next();

  /// First byte of the event.
  std::uintmax_t position() const { return position_; }
  /// When it was received [us].
  std::int64_t timestamp() const { return timestamp_; }
  std::string_view channel() const { return channel_; }

  /// Data of the event, valid until the next call; of what is larger than any message may be, just enough to
  /// show that.
  Bytes data();

  /// So far.
  const LogDamage& damage() const { return damage_; }
  std::uintmax_t size() const { return size_; }

 private:
  /// Opens the event at a byte. @return what is wrong with it; nothing if it is open.
  std::string open(std::uintmax_t position);
  /// The next byte after @p position at which an event may begin; the end of the file if there is none.
  std::uintmax_t find_sync_word(std::uintmax_t position);
  void seek(std::uintmax_t position);
  void read(std::span<std::byte> bytes);
  [[noreturn]] void fail(std::string_view why) const;

  std::string path_;
  std::ifstream file_;
  std::uintmax_t size_ = 0;      // of the file
  std::uintmax_t position_ = 0;  // first byte of the event
  std::uintmax_t cursor_ = 0;    // next byte to be read
  std::uintmax_t end_ = 0;       // first byte after the event
  bool any_ = false;             // whether there was an event
  std::int64_t timestamp_ = 0;
  std::string channel_;
  LogDamage damage_;
  std::vector<std::byte> data_;
};

}  // namespace leadline::app
