#include "worker.h"

#include <utility>

namespace leadline {

Worker::Worker(std::function<void()> work) : work_(std::move(work)), thread_([this] { run(); }) {}

Worker::~Worker() {
  wait();
  over_ = true;
  ask();
  thread_.join();
}

void Worker::ask() {
  asked_.fetch_add(1, std::memory_order_release);
  asked_.notify_one();
}

void Worker::wait() const {
  const std::uint32_t asked = asked_.load(std::memory_order_relaxed);
  for (std::uint32_t done = done_.load(std::memory_order_acquire); done != asked;
       done = done_.load(std::memory_order_acquire))
    done_.wait(done, std::memory_order_acquire);
}

void Worker::run() {
  for (std::uint32_t done = 0;;) {
    asked_.wait(done, std::memory_order_acquire);
    if (over_) return;
    work_();
    done_.store(++done, std::memory_order_release);
    done_.notify_all();
  }
}

}  // namespace leadline
