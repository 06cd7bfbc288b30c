#include "leadline/core/association/assign.h"

#include <gtest/gtest.h>

#include <vector>

#include "leadline/core/chi_square.h"

namespace leadline {
namespace {

const NearestNeighbour kAssociator(0.99, 0.9999);

TEST(NearestNeighbour, TakesTheSmallestGammaInsideTheGate) {
  const std::vector<Candidate> candidates{{7, 5.0, 2}, {8, 2.0, 2}, {9, 3.0, 2}};
  const Match match = kAssociator(candidates);
  EXPECT_EQ(match.feature, 8);
  EXPECT_EQ(match.gamma, 2.0);
  EXPECT_EQ(match.dof, 2);
  EXPECT_EQ(match.kind, Match::Kind::feature);
}

TEST(NearestNeighbour, ComparesDegreesOfFreedomByTheirGates) {
  // 6 of 6.63 is farther out than 7 of 9.21, though smaller.
  EXPECT_EQ(kAssociator(std::vector<Candidate>{{1, 6.0, 1}, {2, 7.0, 2}}).feature, 2);
}

TEST(NearestNeighbour, GatesAreChiSquareQuantiles) {
  for (int dof : {1, 2}) {
    const double gate = chi_square_quantile(0.99, dof);
    EXPECT_DOUBLE_EQ(kAssociator.gate(dof), gate);
    EXPECT_EQ(kAssociator(std::vector<Candidate>{{3, gate * 0.999, dof}}).feature, 3);
    EXPECT_EQ(kAssociator(std::vector<Candidate>{{3, gate * 1.001, dof}}).feature, Match::kNone);
  }
}

TEST(NearestNeighbour, BetweenTheGatesIsNeitherMatchNorNew) {
  const Match match = kAssociator(std::vector<Candidate>{{1, chi_square_quantile(0.999, 2), 2}});
  EXPECT_EQ(match.feature, Match::kNone);
  EXPECT_EQ(match.kind, Match::Kind::clutter);
}

TEST(NearestNeighbour, BeyondTheSecondGateOfAllIsNew) {
  const double far = chi_square_quantile(0.9999, 2) * 1.01;
  EXPECT_EQ(kAssociator(std::vector<Candidate>{{1, far, 2}, {2, far, 2}}).kind, Match::Kind::fresh);
  EXPECT_EQ(kAssociator(std::vector<Candidate>{{1, far, 2}, {2, 12.0, 2}}).kind, Match::Kind::clutter);
  EXPECT_EQ(kAssociator(std::vector<Candidate>{{2, 12.0, 2}, {1, far, 2}}).kind, Match::Kind::clutter);
  EXPECT_EQ(kAssociator(std::vector<Candidate>{{2, 12.0, 2}, {1, 2.0, 2}}).feature, 1);
  EXPECT_EQ(kAssociator({}).kind, Match::Kind::fresh);
}

TEST(NearestNeighbour, ATrustedCandidateGoesFirst) {
  EXPECT_EQ(kAssociator(std::vector<Candidate>{{1, 0.1, 2, false}, {2, 8.0, 2, true}}).feature, 2);
  EXPECT_EQ(kAssociator(std::vector<Candidate>{{2, 8.0, 2, true}, {1, 0.1, 2, false}}).feature, 2);
  EXPECT_EQ(kAssociator(std::vector<Candidate>{{1, 0.1, 2, false}, {2, 20.0, 2, true}}).feature, 1);
}

// A table whose candidates depend on what was settled before.
struct Once {
  int size() const { return 3; }
  std::span<const Candidate> candidates(int) const { return taken ? std::span<const Candidate>() : all; }
  void settle(int measurement, const Match& match) {
    kinds.push_back(match.kind);
    asked.push_back(measurement);
    taken = taken || match.kind == Match::Kind::feature;
  }

  std::vector<Candidate> all{{5, 1.0, 2}};
  bool taken = false;
  std::vector<Match::Kind> kinds;
  std::vector<int> asked;
};

TEST(Assign, SettlesEveryMeasurementAgainstWhatThoseBeforeHaveLeft) {
  Once table;
  assign(kAssociator, table);
  EXPECT_EQ(table.asked, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(table.kinds,
            (std::vector<Match::Kind>{Match::Kind::feature, Match::Kind::fresh, Match::Kind::fresh}));
}

}  // namespace
}  // namespace leadline
