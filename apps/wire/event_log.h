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

/// Reads a log front to back; a length is checked against what is left of the file before it is used.
class EventLogReader {
 public:
  /// @throws std::runtime_error naming the file, and the byte where it is not a sound log; so do all others.
  explicit EventLogReader(const std::filesystem::path& path);

  /// Moves to the next event; false at the end of the file.
  bool next();

  /// First byte of the event.
  std::uintmax_t position() const { return position_; }
  std::string_view channel() const { return channel_; }

  /// Data of the event, valid until the next call; of what is larger than any message may be, just enough to
  /// show that.
  Bytes data();

 private:
  void read(std::span<std::byte> bytes);

  template <class... Args>
  [[noreturn]] void fail(std::string_view format, const Args&... args) const;

  std::string path_;
  std::ifstream file_;
  std::uintmax_t size_ = 0;      // of the file
  std::uintmax_t position_ = 0;  // first byte of the event
  std::uintmax_t cursor_ = 0;    // next byte to be read
  std::uintmax_t end_ = 0;       // first byte after the event
  std::string channel_;
  std::vector<std::byte> data_;
};

}  // namespace leadline::app
