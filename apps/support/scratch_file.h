/// @file
/// Room on the disk for what need not be in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace leadline::app {

/// A file without a name: gone with the program, however that ends. It is in the folder that TMPDIR names, or
/// in /var/tmp.
class ScratchFile {
 public:
  /// @throws std::runtime_error naming the folder and the system's reason; so do all others.
  ScratchFile();
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  void append(std::span<const std::byte> bytes);
  /// Precondition: so many bytes have been appended.
  void read(std::uint64_t position, std::span<std::byte> bytes) const;

 private:
  [[noreturn]] void fail() const;

  std::string folder_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace leadline::app
