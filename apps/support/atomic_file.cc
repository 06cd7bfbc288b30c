#include "apps/support/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace leadline::app {

void sync_folder(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  int error = descriptor < 0 || ::fsync(descriptor) != 0 ? errno : 0;
  if (descriptor >= 0) ::close(descriptor);
  if (error == EINVAL) error = 0;  // the file system has no such thing
  if (error != 0) throw std::system_error(error, std::generic_category());
}

AtomicFile::AtomicFile(std::filesystem::path path)
    : path_(std::move(path)),
      part_(path_.string() + ".part"),
      file_(std::fopen(part_.c_str(), "wb"), std::fclose) {
  if (!file_) fail();
}

AtomicFile::~AtomicFile() {
  if (!file_) return;  // committed
  file_.reset();
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
}

void AtomicFile::write(std::span<const std::byte> bytes) {
  if (!bytes.empty() && std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) fail();
}

void AtomicFile::commit() {
  if (std::fflush(file_.get()) != 0 || ::fsync(::fileno(file_.get())) != 0) fail();
  try {
    std::filesystem::rename(part_, path_);
    file_.reset();
    sync_folder(path_.has_parent_path() ? path_.parent_path() : ".");
  } catch (const std::system_error& error) {
    errno = error.code().value();
    fail();
  }
}

void AtomicFile::fail() const {
  throw std::runtime_error(fmt::format("{}: cannot write: {}", path_.string(), std::strerror(errno)));
}

}  // namespace leadline::app
