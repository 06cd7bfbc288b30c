#include "apps/support/atomic_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace leadline::app {

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
  std::error_code error;
  std::filesystem::rename(part_, path_, error);
  if (error) {
    errno = error.value();
    fail();
  }
  file_.reset();
}

void AtomicFile::fail() const {
  throw std::runtime_error(fmt::format("{}: cannot write: {}", path_.string(), std::strerror(errno)));
}

}  // namespace leadline::app
