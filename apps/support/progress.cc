#include "apps/support/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace leadline::app {

Progress::Progress(std::string label, std::size_t total)
    : label_(std::move(label)),
      total_(std::max<std::size_t>(total, 1)),
      visible_(::isatty(STDERR_FILENO) == 1) {
  if (visible_) draw(0);
}

Progress::~Progress() {
  if (visible_) fmt::print(stderr, "\r\033[K");
}

void Progress::advance() {
  const std::scoped_lock lock(mutex_);
  ++done_;
  const std::size_t percent = 100 * done_ / total_;
  if (!visible_ || percent == drawn_) return;
  drawn_ = percent;
  draw(percent);
}

void Progress::draw(std::size_t percent) const {
  constexpr std::size_t kWidth = 40;
  const std::size_t filled = kWidth * percent / 100;
  fmt::print(stderr, "\r{} [{:=<{}}{: <{}}] {:3} %", label_, "", filled, "", kWidth - filled, percent);
  std::fflush(stderr);
}

}  // namespace leadline::app
