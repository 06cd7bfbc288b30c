/// @file
/// Real matrices from MATLAB files of version 5 to 7.
#pragma once

#include <matio.h>

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>

#include "apps/support/limits.h"

namespace leadline::app {

/// A file open for reading. Every error is a std::runtime_error that names file, variable, what was found and
/// what is allowed.
class MatFile {
 public:
  static constexpr Eigen::Index kAny = -1;

  explicit MatFile(const std::filesystem::path& path);

  const std::string& path() const { return path_; }

  /// A matrix of real doubles. @param rows, @param cols its size, each may be kAny. @param limits of all
  /// elements.
  Eigen::MatrixXd matrix(const std::string& name, Eigen::Index rows, Eigen::Index cols, Limits limits) const;

  /// A vector of real doubles, stored as a row or as a column. @param size may be kAny.
  Eigen::VectorXd vector(const std::string& name, Eigen::Index size, Limits limits) const;

 private:
  template <class... Args>
  [[noreturn]] void fail(const std::string& name, const char* format, const Args&... args) const;

  std::string path_;
  std::unique_ptr<mat_t, int (*)(mat_t*)> file_;
};

}  // namespace leadline::app
