#include "leadline/sonar_sim/point_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "leadline/sonar_sim/noise.h"

namespace leadline {
namespace {

TEST(PointGridTest, FindsWhatBruteForceFinds) {
  for (const double cell : {0.3, 4.0, 1000.0}) {
    Noise noise(1, "grid");
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < 2000; ++i) {
      const double x = noise.uniform(-50.0, 50.0), y = noise.uniform(-50.0, 50.0);
      points.emplace_back(x, y);
    }
    const PointGrid grid(points, cell);
    for (int i = 0; i < 200; ++i) {
      const double x = noise.uniform(-60.0, 60.0), y = noise.uniform(-60.0, 60.0);
      const std::vector<std::size_t> found = grid.near({x, y});
      EXPECT_TRUE(std::ranges::is_sorted(found));
      EXPECT_EQ(std::ranges::adjacent_find(found), found.end());
      for (std::size_t k = 0; k < points.size(); ++k) {
        const double distance = (points[k] - Eigen::Vector2d(x, y)).norm();
        const bool is_found = std::ranges::binary_search(found, k);
        if (distance <= cell) {
          EXPECT_TRUE(is_found);
        }
        if (distance >= 3.0 * cell) {
          EXPECT_FALSE(is_found);
        }
      }
    }
  }
}

TEST(PointGridTest, EmptyGridFindsNothing) {
  EXPECT_THAT(PointGrid({}, 1.0).near({0.0, 0.0}), testing::IsEmpty());
}

}  // namespace
}  // namespace leadline
