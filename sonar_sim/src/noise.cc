#include "leadline/sonar_sim/noise.h"

#include <boost/random/normal_distribution.hpp>
#include <cmath>

namespace leadline {
namespace {

// Steele, Lea, Flood 2014 (splitmix64): scatters neighbouring seeds.
std::uint64_t scatter(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

// FNV-1a.
std::uint64_t hash(std::string_view text) {
  std::uint64_t h = 0xcbf29ce484222325;
  for (const char c : text) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return h;
}

}  // namespace

Noise::Noise(std::uint64_t seed, std::string_view stream, std::size_t index)
    : engine_(scatter(scatter(scatter(seed) ^ hash(stream)) ^ index)) {}

// The distributions of the standard library differ from one implementation to the next; these do not.
double Noise::uniform(double low, double high) {
  return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
}

double Noise::normal(double sigma) { return sigma * boost::random::normal_distribution<double>()(engine_); }

double Noise::exponential(double mean) { return -mean * std::log1p(-uniform(0.0, 1.0)); }

bool Noise::chance(double probability) { return uniform(0.0, 1.0) < probability; }

}  // namespace leadline
