/// @file
/// A progress bar on stderr, if that is a terminal.
#pragma once

#include <cstddef>
#include <mutex>
#include <string>

namespace leadline::app {

/// May be advanced by several threads.
class Progress {
 public:
  Progress(std::string label, std::size_t total);
  /// Clears the line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance();

 private:
  void draw(std::size_t percent) const;

  std::string label_;
  std::size_t total_;
  bool visible_;
  std::mutex mutex_;
  std::size_t done_ = 0;
  std::size_t drawn_ = 0;  // percent
};

}  // namespace leadline::app
