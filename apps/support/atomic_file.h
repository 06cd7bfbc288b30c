/// @file
/// A file that is there complete or not at all.
#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>

namespace leadline::app {

/// Waits until the disk has the names in @p folder as they are now: a file that was renamed is found under
/// its new name after a loss of power only then.
/// @throws std::system_error with the system's reason.
void sync_folder(const std::filesystem::path& folder);

/// Written beside its place under a temporary name, "<path>.part", and put there by commit(). Without
/// commit() nothing is left behind, and a file that was there before is untouched.
class AtomicFile {
 public:
  /// @throws std::runtime_error naming the file and the system's reason; so do all others.
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::span<const std::byte> bytes);

  /// Waits until the disk has it all, the file's name included.
  void commit();

 private:
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  std::filesystem::path part_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

}  // namespace leadline::app
