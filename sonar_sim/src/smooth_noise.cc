#include "leadline/sonar_sim/smooth_noise.h"

#include <cmath>
#include <cstddef>

#include "leadline/core/angle.h"

namespace leadline {
namespace {

constexpr std::size_t kWaves = 64;

}  // namespace

// Wave numbers of a normal distribution give a correlation of that shape, its Fourier transform.
SmoothNoise SmoothNoise::along(Noise noise, double scale) {
  SmoothNoise function;
  for (std::size_t i = 0; i < kWaves; ++i) {
    const double number = noise.normal(1.0 / scale);
    function.waves_.push_back({number, noise.uniform(-kPi, kPi)});
  }
  return function;
}

SmoothNoise SmoothNoise::around(Noise noise, double scale) {
  SmoothNoise function = along(noise, scale);
  for (Wave& wave : function.waves_) wave.number = std::round(wave.number);
  return function;
}

double SmoothNoise::operator()(double x) const {
  double sum = 0.0;
  for (const auto& [number, phase] : waves_) sum += std::cos(number * x + phase);
  return std::sqrt(2.0 / static_cast<double>(kWaves)) * sum;
}

}  // namespace leadline
