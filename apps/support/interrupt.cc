#include "apps/support/interrupt.h"

#include <atomic>
#include <csignal>

namespace leadline::app {
namespace {

// Written by a signal handler, which may touch no lock, and read by every thread.
std::atomic<bool> signal_came = false;
static_assert(std::atomic<bool>::is_always_lock_free);

void note_signal(int) { signal_came = true; }

}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = note_signal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() { return signal_came; }

void throw_if_interrupted() {
  if (interrupted()) throw Interrupted();
}

}  // namespace leadline::app
