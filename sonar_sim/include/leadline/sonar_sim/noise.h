/// @file
/// Seeded random numbers that are the same with every standard library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <string_view>

namespace leadline {

/// One stream of random numbers. Every source of noise owns a stream named after it, so that a fault that is
/// switched on leaves the noise of all the others as it was. Each call draws, also for sigma or probability
/// 0, for the same reason.
class Noise {
 public:
  /// @param seed of the whole simulation; @param stream name of the source of noise;
  /// @param index tells sources of the same name apart.
  Noise(std::uint64_t seed, std::string_view stream, std::size_t index = 0);

  double uniform(double low, double high);
  double normal(double sigma);
  double exponential(double mean);
  bool chance(double probability);

  /// Calls @p arrive a Poisson number of times, which may draw from the same stream in between.
  template <class Arrive>
  void arrivals(double mean, const Arrive& arrive) {
    for (double t = exponential(1.0); t < mean; t += exponential(1.0)) arrive();
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace leadline
