// The search for the likeliest assignment against all assignments there are, written out.
#include "leadline/core/association/joint_search.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/core/chi_square.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

/// Items that see a few targets from one uncertain place: residuals that hang together.
struct World {
  struct Choice {
    int item, target, dof;
    Vector<2> residual;
    double log_weight;
  };
  std::vector<double> log_alone;
  std::vector<Choice> options;
  Eigen::MatrixXd S;

  explicit World(std::uint64_t seed, int most_items = 6) {
    Random random(seed);
    const int items = 1 + random.index(most_items);
    for (int item = 0; item < items; ++item) {
      log_alone.push_back(std::log(0.1) + random.normal());
      const int first = random.index(5), count = random.index(4);
      for (int k = 0; k < count; ++k)
        options.push_back(
            {item, (first + 2 * k) % 5, 1 + random.index(2), random.vector(2, 1.2), random.normal(0.3)});
    }
    const auto rows = static_cast<Eigen::Index>(2 * options.size());
    const Eigen::MatrixXd A = random.matrix(static_cast<int>(rows), 3, 0.8);
    S = A * A.transpose();
    S.diagonal().array() += 0.3;
  }

  JointSearch search(JointSearch::Limits limits) const {
    limits.items = static_cast<int>(log_alone.size());
    limits.options = static_cast<int>(options.size());
    JointSearch search(limits);
    for (int item = 0, option = 0; item < limits.items; ++item) {
      search.add_item(log_alone[static_cast<std::size_t>(item)]);
      for (; option < limits.options && at(option).item == item; ++option)
        search.add_option(at(option).target, at(option).dof, at(option).residual, at(option).log_weight);
    }
    for (int a = 0; a < limits.options; ++a)
      for (int b = 0; b <= a; ++b) search.set_covariance(a, b, S.block<2, 2>(2 * a, 2 * b));
    return search;
  }

  const Choice& at(int option) const { return options[static_cast<std::size_t>(option)]; }
};

struct Answer {
  std::vector<int> choices;
  std::vector<double> posterior, alone;  // of options, of items
};

/// Every assignment, its likelihood by one Cholesky factorization.
class Exhaustive {
 public:
  Exhaustive(const World& world, double gate) : world_(world), gate_(gate) {
    answer_.posterior.assign(world.options.size(), 0.0);
    answer_.alone.assign(world.log_alone.size(), 0.0);
    go_on(0);
    for (double& p : answer_.posterior) p /= sum_;
    for (double& p : answer_.alone) p /= sum_;
  }
  const Answer& answer() const { return answer_; }

 private:
  void go_on(std::size_t item) {
    if (item == world_.log_alone.size()) return judge();
    choices_.push_back(JointSearch::kNone);
    go_on(item + 1);
    for (int option = 0; option < static_cast<int>(world_.options.size()); ++option) {
      if (world_.at(option).item != static_cast<int>(item)) continue;
      const bool taken = std::ranges::any_of(choices_, [&](int other) {
        return other != JointSearch::kNone && world_.at(other).target == world_.at(option).target;
      });
      if (taken) continue;
      choices_.back() = option;
      go_on(item + 1);
    }
    choices_.pop_back();
  }

  void judge() {
    std::vector<int> rows;
    std::vector<double> residual;
    double score = 0.0;
    for (std::size_t item = 0; item < choices_.size(); ++item) {
      if (choices_[item] == JointSearch::kNone) {
        score += world_.log_alone[item];
        continue;
      }
      const World::Choice& option = world_.at(choices_[item]);
      score += option.log_weight;
      for (int r = 0; r < option.dof; ++r) {
        rows.push_back(2 * choices_[item] + r);
        residual.push_back(option.residual[r]);
      }
    }
    if (!rows.empty()) {
      const Eigen::MatrixXd S = world_.S(rows, rows);
      const Eigen::Map<const Eigen::VectorXd> nu(residual.data(), std::ssize(residual));
      const double gamma = nu.dot(S.ldlt().solve(nu));
      if (gamma >= chi_square_quantile(gate_, static_cast<double>(rows.size()))) return;
      score -= 0.5 * (gamma + std::log((2.0 * kPi * S).determinant()));
    }
    const double likelihood = std::exp(score);
    sum_ += likelihood;
    for (std::size_t item = 0; item < choices_.size(); ++item) {
      if (choices_[item] == JointSearch::kNone)
        answer_.alone[item] += likelihood;
      else
        answer_.posterior[static_cast<std::size_t>(choices_[item])] += likelihood;
    }
    if (likelihood > best_) {
      best_ = likelihood;
      answer_.choices = choices_;
    }
  }

  const World& world_;
  double gate_, sum_ = 0.0, best_ = 0.0;
  std::vector<int> choices_;
  Answer answer_;
};

TEST(JointSearch, IsTheBestOfAllAssignments) {
  int assigned = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const World world(seed);
    const Exhaustive all(world, 0.99);
    JointSearch search = world.search({.hypotheses = 5000, .gate = 0.99});
    for (int again = 0; again < 2; ++again) search.solve();
    for (int item = 0; item < search.items(); ++item) {
      EXPECT_EQ(search.choice(item), all.answer().choices[static_cast<std::size_t>(item)])
          << "world " << seed;
      EXPECT_NEAR(search.posterior_alone(item), all.answer().alone[static_cast<std::size_t>(item)], 1e-8);
      assigned += search.choice(item) != JointSearch::kNone;
    }
    for (int option = 0; option < search.options(); ++option)
      EXPECT_NEAR(search.posterior(option), all.answer().posterior[static_cast<std::size_t>(option)], 1e-8)
          << "world " << seed;
  }
  EXPECT_GT(assigned, 300);
}

TEST(JointSearch, FewHypothesesFindTheBestAsARule) {
  int right = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const World world(seed);
    JointSearch search = world.search({.hypotheses = 16, .gate = 0.99});
    search.solve();
    std::vector<int> choices;
    for (int item = 0; item < search.items(); ++item) choices.push_back(search.choice(item));
    right += choices == Exhaustive(world, 0.99).answer().choices;
  }
  EXPECT_GE(right, 485);
}

TEST(JointSearch, WhatOneSaysTheOthersSay) {
  // Two items 3 off, each alone at 2.1 sigma; together they tell that the place is off, by little.
  const auto both = [](double covariance) {
    JointSearch search({.items = 2, .options = 2});
    for (int item = 0; item < 2; ++item) {
      search.add_item(std::log(0.05));
      search.add_option(item, 1, {3.0, 0.0}, 0.0);
      search.set_covariance(item, item, 2.0 * Matrix<2, 2>::Identity());
    }
    search.set_covariance(1, 0, covariance * Matrix<2, 2>::Identity());
    search.solve();
    return search.choice(0) != JointSearch::kNone && search.choice(1) != JointSearch::kNone;
  };
  EXPECT_TRUE(both(1.99));
  EXPECT_FALSE(both(0.0));
}

TEST(JointSearch, ItemsMayBeNothing) {
  JointSearch search({.items = 3, .options = 2});
  EXPECT_TRUE(search.has_room(2));
  EXPECT_FALSE(search.has_room(3));
  search.add_item(0.0);
  search.add_item(0.0);
  search.add_option(7, 2, {0.1, 0.1}, 0.0);
  search.add_option(8, 2, {50.0, 0.0}, 0.0);  // in no gate
  search.set_covariance(0, 0, 0.01 * Matrix<2, 2>::Identity());
  search.set_covariance(1, 1, Matrix<2, 2>::Identity());
  search.add_item(0.0);
  EXPECT_FALSE(search.has_room(0));
  search.solve();
  EXPECT_EQ(search.choice(0), JointSearch::kNone);
  EXPECT_EQ(search.choice(1), 0);
  EXPECT_EQ(search.choice(2), JointSearch::kNone);
  EXPECT_EQ(search.posterior_alone(0), 1.0);
  EXPECT_EQ(search.posterior(1), 0.0);
  search.clear();
  search.solve();
  EXPECT_EQ(search.items(), 0);
}

TEST(JointSearch, ACovarianceThatIsNoneIsNoOption) {
  JointSearch search({.items = 1, .options = 1});
  search.add_item(0.0);
  search.add_option(0, 2, {0.0, 0.0}, 0.0);
  search.set_covariance(0, 0, Matrix<2, 2>::Zero());
  search.solve();
  EXPECT_EQ(search.choice(0), JointSearch::kNone);
  EXPECT_EQ(search.posterior(0), 0.0);
}

}  // namespace
}  // namespace leadline
