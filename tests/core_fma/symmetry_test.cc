// P is symmetric to the bit also where products and sums are fused, as compilers for arm64 do by default:
// this program is the library and the test compiled so for x86.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "leadline/core/belief.h"
#include "tests/core/linear_models.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr int kSlots = 30;  // more entries than a block of Belief::mirror

bool has_fused_operations() {
#ifdef __x86_64__
  return __builtin_cpu_supports("fma") > 0;
#else
  return true;
#endif
}

class SymmetryTest : public testing::TestWithParam<ErrorKind> {
 protected:
  void SetUp() override {
    if (!has_fused_operations()) GTEST_SKIP() << "this processor does not multiply and add in one operation";
  }

  void expect_symmetric() const {
    const Eigen::MatrixXd P = belief_.covariance();
    for (int j = 0; j < P.cols(); ++j)
      for (int i = 0; i < j; ++i) ASSERT_EQ(P(i, j), P(j, i)) << i << ", " << j;
  }

  template <int M>
  void correct(int slot, Update update) {
    const auto model = LinearSighting<TargetShape::point, M, 0>::any(random_);
    Innovation<M, 5> innovation;
    ASSERT_EQ(belief_.innovate(model, slot, Vector<M>(random_.vector(M)), linearizer_, innovation),
              Status::ok);
    ASSERT_EQ(leadline::correct(belief_, innovation, update), Status::ok);
    expect_symmetric();
  }

  Random random_{5};
  Linearizer linearizer_;
  Belief belief_{GetParam(), random_.vector(4), random_.covariance(4, 0.1), kSlots};
};

TEST_P(SymmetryTest, WhateverHappens) {
  expect_symmetric();
  for (int i = 0; i < kSlots; ++i) {
    int slot = 0;
    ASSERT_EQ(belief_.add(LinearInitialization<TargetShape::point>::any(random_), linearizer_, slot),
              Status::ok);
    expect_symmetric();
  }
  for (int step = 0; step < 20; ++step) {
    ASSERT_EQ(belief_.predict(LinearMotion<4, 3>::any(random_), linearizer_), Status::ok);
    expect_symmetric();
    correct<1>(random_.index(kSlots), Update::all);
    correct<2>(random_.index(kSlots), Update::all);
    correct<3>(random_.index(kSlots), Update::all);
    correct<2>(random_.index(kSlots), Update::target);
  }
}

INSTANTIATE_TEST_SUITE_P(Errors, SymmetryTest, testing::Values(ErrorKind::additive, ErrorKind::invariant),
                         [](const auto& error) {
                           return error.param == ErrorKind::additive ? "additive" : "invariant";
                         });

}  // namespace
}  // namespace leadline
