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
