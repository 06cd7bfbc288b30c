#include "apps/node/status_words.h"

#include <array>
#include <cstddef>
#include <leadline/slam_health_t.hpp>

namespace leadline::app {
namespace {

struct Words {
  std::int8_t status;
  std::string_view name, sentence;
  bool is_trouble;
};

const Words& words_of(std::int8_t status) {
  static constexpr Words kUnknown{-1, "unknown", "a status of another version", true};
  static constexpr std::array kWords{
      Words{slam_health_t::OK, "ok", "all is well", false},
      Words{slam_health_t::WARNING, "warning", "estimating", true},
      Words{slam_health_t::DEAD_RECKONING, "dead reckoning", "dead reckoning", true},
      Words{slam_health_t::WAITING, "waiting", "waiting for the first measurement", false},
      Words{slam_health_t::PAUSED, "paused", "paused", false},
      Words{slam_health_t::LOST, "lost", "lost, the estimate is doubted", true}};
  for (const Words& words : kWords)
    if (words.status == status) return words;
  return kUnknown;
}

}  // namespace

std::string_view status_name(std::int8_t status) { return words_of(status).name; }
std::string_view status_sentence(std::int8_t status) { return words_of(status).sentence; }
bool is_trouble(std::int8_t status) { return words_of(status).is_trouble; }

}  // namespace leadline::app
