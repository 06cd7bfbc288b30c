#include "apps/results/result_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

/// Absolute, and without a slash at the end.
fs::path whole(const fs::path& path) {
  const fs::path absolute = fs::absolute(path).lexically_normal();
  return absolute.has_filename() ? absolute : absolute.parent_path();
}

[[noreturn]] void refuse(const fs::path& path, std::string_view reason) {
  throw std::runtime_error(fmt::format("{}: {}", path.string(), reason));
}

void check_replaceable(const fs::path& path, bool force) {
  if (!fs::exists(fs::symlink_status(path))) return;
  if (!force) refuse(path, "is there already; --force replaces a result folder");
  if (!fs::is_directory(fs::symlink_status(path))) refuse(path, "is not a folder, and is not replaced");
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    const std::string file = entry.path().filename().string();
    if (std::ranges::find(kResultFiles, file) == kResultFiles.end())
      refuse(path, fmt::format("is not replaced: it is not a mere result folder, it holds '{}'", file));
  }
}

}  // namespace

ResultFolder::ResultFolder(const fs::path& path, bool force) : target_(whole(path)) {
  try {
    check_replaceable(target_, force);
    for (fs::path parent = target_.parent_path(); !fs::exists(parent); parent = parent.parent_path())
      made_.insert(made_.begin(), parent);
    fs::create_directories(target_.parent_path());
    std::string pattern =
        (target_.parent_path() / fmt::format(".{}.part-XXXXXX", target_.filename().string())).string();
    if (!::mkdtemp(pattern.data())) refuse(target_, fmt::format("cannot be made: {}", std::strerror(errno)));
    temporary_ = pattern;
    work_ = temporary_ / target_.filename();
    fs::create_directory(work_);
  } catch (const fs::filesystem_error& error) {
    remove_work();
    refuse(target_, fmt::format("cannot be made: {}", error.code().message()));
  } catch (...) {
    remove_work();
    throw;
  }
}

ResultFolder::~ResultFolder() { remove_work(); }

void ResultFolder::write(std::string_view file, std::string_view content) const {
  AtomicFile out = open(file);
  out.write(std::as_bytes(std::span(content)));
  out.commit();
}

void ResultFolder::commit() {
  try {
    const fs::path old = temporary_ / "replaced";
    const bool replaces = fs::exists(target_);
    if (replaces) fs::rename(target_, old);
    std::error_code error;
    fs::rename(work_, target_, error);
    if (error) {
      if (replaces) fs::rename(old, target_);
      refuse(target_, fmt::format("cannot be put in its place: {}", error.message()));
    }
    for (const fs::path& made : made_) sync_folder(made.parent_path());
    made_.clear();
    sync_folder(target_.parent_path());
  } catch (const std::system_error& error) {
    refuse(target_, fmt::format("cannot be put in its place: {}", error.code().message()));
  }
}

void ResultFolder::remove_work() {
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
  for (; !made_.empty(); made_.pop_back()) fs::remove(made_.back(), ignored);  // if empty
}

}  // namespace leadline::app
