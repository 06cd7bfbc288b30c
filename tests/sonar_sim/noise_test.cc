#include "leadline/sonar_sim/noise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "statistics.h"

namespace leadline {
namespace {

constexpr int kSamples = 100000;

template <class Draw>
std::vector<double> samples(Draw draw) {
  std::vector<double> result;
  for (int i = 0; i < kSamples; ++i) result.push_back(draw());
  return result;
}

TEST(NoiseTest, NormalHasItsMomentsAndTails) {
  Noise noise(1, "test");
  const auto x = samples([&] { return noise.normal(3.0); });
  EXPECT_THAT(x, HasMoments(0.0, 3.0));
  const auto outside = [&](double bound) {
    return static_cast<double>(
        std::count_if(x.begin(), x.end(), [&](double v) { return std::abs(v) > bound; }));
  };
  EXPECT_THAT(outside(3.0), IsBinomial(kSamples, 0.31731));
  EXPECT_THAT(outside(6.0), IsBinomial(kSamples, 0.04550));
  EXPECT_THAT(outside(12.0), IsBinomial(kSamples, 6.334e-5));
}

TEST(NoiseTest, UniformFillsItsRange) {
  Noise noise(2, "test");
  const auto x = samples([&] { return noise.uniform(-1.0, 3.0); });
  EXPECT_THAT(x, testing::Each(testing::AllOf(testing::Ge(-1.0), testing::Lt(3.0))));
  const double sigma = 4.0 / std::sqrt(12.0);
  EXPECT_NEAR(mean(x), 1.0, kStandardErrors * sigma / std::sqrt(kSamples));
  EXPECT_NEAR(standard_deviation(x), sigma, 0.01 * sigma);
}

TEST(NoiseTest, ExponentialHasItsMean) {
  Noise noise(3, "test");
  const auto x = samples([&] { return noise.exponential(2.0); });
  EXPECT_NEAR(mean(x), 2.0, kStandardErrors * 2.0 / std::sqrt(kSamples));
  EXPECT_THAT(static_cast<double>(std::count_if(x.begin(), x.end(), [](double v) { return v > 4.0; })),
              IsBinomial(kSamples, std::exp(-2.0)));
}

TEST(NoiseTest, ChanceHasItsProbability) {
  Noise noise(4, "test");
  double hits = 0.0;
  for (int i = 0; i < kSamples; ++i) hits += noise.chance(0.3) ? 1.0 : 0.0;
  EXPECT_THAT(hits, IsBinomial(kSamples, 0.3));
  EXPECT_FALSE(noise.chance(0.0));
  EXPECT_TRUE(noise.chance(1.0));
}

TEST(NoiseTest, NothingIsDrawnLessForSigmaZero) {
  Noise with(5, "test"), without(5, "test");
  EXPECT_NE(with.normal(1.0), 0.0);
  EXPECT_EQ(without.normal(0.0), 0.0);
  EXPECT_EQ(with.uniform(0.0, 1.0), without.uniform(0.0, 1.0));
}

TEST(NoiseTest, StreamsDifferBySeedNameAndIndex) {
  const auto first = [](std::uint64_t seed, const char* stream, std::size_t index) {
    return Noise(seed, stream, index).uniform(0.0, 1.0);
  };
  EXPECT_EQ(first(1, "a", 0), first(1, "a", 0));
  EXPECT_NE(first(1, "a", 0), first(2, "a", 0));
  EXPECT_NE(first(1, "a", 0), first(1, "b", 0));
  EXPECT_NE(first(1, "a", 0), first(1, "a", 1));
}

TEST(NoiseTest, NeighbouringSeedsAreUncorrelated) {
  std::vector<double> product;
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    product.push_back(Noise(seed, "a").normal(1.0) * Noise(seed + 1, "a").normal(1.0));
  }
  EXPECT_NEAR(mean(product), 0.0, kStandardErrors / std::sqrt(20000.0));
}

// The same numbers on every machine and with every standard library.
TEST(NoiseTest, IsReproducible) {
  Noise noise(42, "golden");
  EXPECT_DOUBLE_EQ(noise.uniform(0.0, 1.0), 0.69801316211953035);
  EXPECT_DOUBLE_EQ(noise.normal(1.0), 1.6105452239889326);
  EXPECT_DOUBLE_EQ(noise.exponential(1.0), 0.49273584580016966);
}

}  // namespace
}  // namespace leadline
