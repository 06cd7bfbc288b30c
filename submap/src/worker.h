/// @file
/// Work beside that of the thread that asks for it.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

namespace leadline {

/// A thread that calls one function as often as it is asked to. Who asks sees what was done once wait() has
/// returned, and the function all that was done before it was asked for. After construction nothing
/// allocates; all but wait() belongs to one thread.
class Worker {
 public:
  explicit Worker(std::function<void()> work);
  /// After all calls that were asked for.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// One more call.
  void ask();
  /// Until all calls have been made.
  void wait() const;

 private:
  void run();

  std::function<void()> work_;
  std::atomic<std::uint32_t> asked_ = 0, done_ = 0;  // calls
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

}  // namespace leadline
