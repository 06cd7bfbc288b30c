#include "leadline/submap/channel.h"

#include <cmath>

namespace leadline {

namespace {

/// Pings that are remembered.
constexpr double kMemory = 300.0;
constexpr double kFade = 1.0 - 1.0 / kMemory;

constexpr double kSure = 3.0;  // standard deviations

}  // namespace

void Channel::note_ping(bool heard) {
  pings.missed = kFade * pings.missed + (heard ? 0.0 : 1.0);
  pings.heard = kFade * pings.heard + (heard ? 1.0 : 0.0);
}

void Channel::note_wall(double residual, double variance, double roughness) {
  walls.echoes = kFade * walls.echoes + 1.0;
  walls.sum = kFade * walls.sum + residual * residual - variance + roughness * roughness;
  walls.squares = kFade * walls.squares + variance * variance;
}

bool Channel::misses_more(double configured) const {
  const double n = pings.pings();
  return pings.missed > n * configured + kSure * std::sqrt(n * configured * (1.0 - configured)) + 1.0;
}

double Channel::wall_roughness(double configured) const {
  if (!(walls.echoes > 0.0)) return configured;
  const double variance = configured * configured, learnt = walls.sum / walls.echoes;
  const double sigma = std::sqrt(2.0 * walls.squares) / walls.echoes;  // a residual^2 has twice variance^2
  return learnt > variance + kSure * sigma ? std::sqrt(learnt) : configured;
}

}  // namespace leadline
