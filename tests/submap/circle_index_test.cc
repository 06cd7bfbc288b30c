#include "leadline/submap/circle_index.h"

#include <gtest/gtest.h>

#include <random>

namespace leadline {
namespace {

Eigen::Vector2d somewhere(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-20.0, 20.0);
  const double x = uniform(random);
  return {x, uniform(random)};
}

std::vector<int> brute_force(const std::vector<Eigen::Vector2d>& centres, const Eigen::Vector2d& point,
                             double radius) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < centres.size(); ++i)
    if ((centres[i] - point).norm() <= radius) numbers.push_back(static_cast<int>(i));
  return numbers;
}

TEST(CircleIndex, FindsWhatASearchOverAllFinds) {
  constexpr double kRadius = 3.0;
  std::mt19937 random(1);
  CircleIndex index(kRadius);
  std::vector<Eigen::Vector2d> centres(200);
  for (std::size_t i = 0; i < centres.size(); ++i) {
    centres[i] = somewhere(random);
    index.put(static_cast<int>(i), centres[i]);
  }
  for (int move = 0; move < 100; ++move) {
    const std::size_t moved = random() % centres.size();
    centres[moved] = somewhere(random);
    index.put(static_cast<int>(moved), centres[moved]);
    const Eigen::Vector2d point = somewhere(random);
    EXPECT_EQ(index.holding(point), brute_force(centres, point, kRadius));
  }
}

// Nearer than the circles reach, as far, and farther: whatever the boxes are made for.
TEST(CircleIndex, FindsTheCentresWithinAnyDistance) {
  constexpr double kRadius = 3.0;
  std::mt19937 random(2);
  CircleIndex index(kRadius);
  std::vector<Eigen::Vector2d> centres(200);
  const auto put = [&](std::size_t i) {
    centres[i] = somewhere(random);
    index.put(static_cast<int>(i), centres[i]);
  };
  for (std::size_t i = 0; i < centres.size(); ++i) put(i);
  for (const double distance : {0.0, 0.5, 3.0, 3.1, 7.0, 50.0}) {
    std::size_t found = 0;
    for (int move = 0; move < 100; ++move) {
      put(random() % centres.size());
      const Eigen::Vector2d point = somewhere(random);
      const std::vector<int> near = index.near(point, distance);
      EXPECT_EQ(near, brute_force(centres, point, distance));
      found += near.size();
    }
    EXPECT_EQ(found > 0, distance > 0.0) << "within " << distance;
  }
}

TEST(CircleIndex, WhatIsAsFarAsAskedIsNear) {
  CircleIndex index(1.0);
  index.put(3, {0.0, 0.0});
  index.put(1, {3.0, 4.0});
  EXPECT_EQ(index.near({0.0, 0.0}, 0.0), std::vector<int>{3});
  EXPECT_EQ(index.near({0.0, 0.0}, 4.999), std::vector<int>{3});
  EXPECT_EQ(index.near({0.0, 0.0}, 5.0), (std::vector<int>{1, 3}));
  EXPECT_EQ(index.near({0.0, 0.0}, 1.0), index.holding({0.0, 0.0}));
  index.put(1, {30.0, 40.0});
  EXPECT_EQ(index.near({0.0, 0.0}, 5.0), std::vector<int>{3});
  EXPECT_TRUE(CircleIndex(1.0).near({0.0, 0.0}, 1e6).empty());
}

TEST(CircleIndex, ACopyIsIndependent) {
  CircleIndex index(1.0);
  index.put(0, {0.0, 0.0});
  CircleIndex copy = index;
  copy.put(0, {5.0, 0.0});
  copy.put(1, {0.0, 0.0});
  EXPECT_EQ(index.holding({0.0, 0.0}), std::vector<int>{0});
  EXPECT_EQ(copy.holding({0.0, 0.0}), std::vector<int>{1});
  EXPECT_FALSE(index.has(1));
  EXPECT_TRUE(copy.has(1));
  index = copy;
  EXPECT_EQ(index.holding({5.0, 0.0}), std::vector<int>{0});
}

}  // namespace
}  // namespace leadline
