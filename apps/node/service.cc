#include "apps/node/service.h"

#include <systemd/sd-daemon.h>

#include <algorithm>
#include <cstdint>

namespace leadline::app::service {

void ready() { sd_notify(0, "READY=1"); }

void alive() { sd_notify(0, "WATCHDOG=1"); }

void status(const std::string& text) {
  std::string line = "STATUS=" + text;
  std::ranges::replace(line, '\n', ' ');  // the next line would be another message
  sd_notify(0, line.c_str());
}

void stopping() { sd_notify(0, "STOPPING=1"); }

std::optional<std::chrono::microseconds> watchdog_period() {
  std::uint64_t period = 0;
  if (sd_watchdog_enabled(0, &period) <= 0) return std::nullopt;
  return std::chrono::microseconds(period);
}

}  // namespace leadline::app::service
