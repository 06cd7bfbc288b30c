/// @file
/// Judging random samples of fixed seeds.
#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <numeric>
#include <vector>

namespace leadline {

inline double mean(const std::vector<double>& samples) {
  return std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(samples.size());
}

inline double standard_deviation(const std::vector<double>& samples) {
  const double m = mean(samples);
  double sum = 0.0;
  for (const double x : samples) sum += (x - m) * (x - m);
  return std::sqrt(sum / static_cast<double>(samples.size() - 1));
}

/// Standard errors that a figure may lie from its expectation: 1 in 16,000 does not.
inline constexpr double kStandardErrors = 4.0;

/// Independent samples of a normal distribution: mean and standard deviation within their confidence bounds.
MATCHER_P2(HasMoments, expected_mean, sigma, "") {
  const auto n = static_cast<double>(arg.size());
  const double m = mean(arg), s = standard_deviation(arg);
  *result_listener << "mean " << m << ", standard deviation " << s << ", " << n << " samples";
  return n > 1 && std::abs(m - expected_mean) <= kStandardErrors * sigma / std::sqrt(n) &&
         std::abs(s / sigma - 1.0) <= kStandardErrors / std::sqrt(2.0 * (n - 1.0));
}

/// A number of successes out of n independent trials of that probability.
MATCHER_P2(IsBinomial, n, probability, "") {
  const double expected = n * probability;
  return std::abs(arg - expected) <= kStandardErrors * std::sqrt(expected * (1.0 - probability));
}

}  // namespace leadline
