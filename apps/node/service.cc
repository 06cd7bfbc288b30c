#include "apps/node/service.h"

#include <systemd/sd-daemon.h>

#include <algorithm>

namespace leadline::app::service {

void ready() { sd_notify(0, "READY=1"); }

void alive() { sd_notify(0, "WATCHDOG=1"); }

void status(const std::string& text) {
  std::string line = "STATUS=" + text;
  std::ranges::replace(line, '\n', ' ');  // the next line would be another message
  sd_notify(0, line.c_str());
}

void stopping() { sd_notify(0, "STOPPING=1"); }

}  // namespace leadline::app::service
