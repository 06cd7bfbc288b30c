#include "leadline/submap/submap_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/constants.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr int kNone = SubmapGraph::kNone;

/// Somewhere, its heading known exactly or not.
UncertainPose any_pose(Random& random, bool heading_is_known) {
  UncertainPose X{random.pose(), random.covariance(3, 0.3)};
  if (heading_is_known) {
    X.P.row(2).setZero();
    X.P.col(2).setZero();
  }
  return X;
}

UncertainPose with_sigma(double x, double sigma) {
  UncertainPose X{{x, 0.0, 0.0}, {}};
  X.P = (sigma * sigma * Eigen::Vector3d(1.0, 1.0, 0.01)).asDiagonal();
  return X;
}

/// Seven submaps and @p links links, of which some may leave a submap alone.
SubmapGraph any_graph(Random& random, int links, bool headings_are_known) {
  SubmapGraph graph;
  for (int i = 0; i < 7; ++i) graph.add();
  for (int i = 0; i < links; ++i) {
    const int a = random.index(7), b = random.index(7);
    if (a != b) graph.connect(a, b, any_pose(random, headings_are_known));
  }
  return graph;
}

/// X_ab of the link between two submaps, if there is one.
std::optional<UncertainPose> link_of(const SubmapGraph& graph, int a, int b) {
  for (const SubmapGraph::Link& link : graph.links()) {
    if (link.a == a && link.b == b) return link.X_ab;
    if (link.a == b && link.b == a) return inverse(link.X_ab);
  }
  return std::nullopt;
}

/// All simple paths from one submap, one by one.
struct AllPaths {
  explicit AllPaths(const SubmapGraph& graph, int start = 0)
      : graph(graph), least(graph.size()), hops(graph.size(), kNone), length(graph.size(), kInfinity) {
    follow({start}, {});
  }

  void follow(std::vector<int> way, const UncertainPose& X) {
    const int at = way.back(), steps = static_cast<int>(way.size()) - 1;
    if (hops[at] == kNone || steps < hops[at]) hops[at] = steps;
    if (uncertainty(X.P) < length[at]) {
      length[at] = uncertainty(X.P);
      least[at] = X;
    }
    for (int next = 0; next < graph.size(); ++next) {
      if (std::ranges::find(way, next) != way.end()) continue;
      const auto link = link_of(graph, at, next);
      if (!link) continue;
      way.push_back(next);
      follow(way, oplus(X, *link));
      way.pop_back();
    }
  }

  const SubmapGraph& graph;
  std::vector<UncertainPose> least;  // of each submap
  std::vector<int> hops;
  std::vector<double> length;
};

void expect_equal(const UncertainPose& a, const UncertainPose& b) {
  EXPECT_NEAR(a.X.x, b.X.x, 1e-12);
  EXPECT_NEAR(a.X.y, b.X.y, 1e-12);
  EXPECT_NEAR(angle_difference(a.X.heading, b.X.heading), 0.0, 1e-12);
  EXPECT_THAT(a.P, IsNear(b.P, 1e-11));
}

TEST(SubmapGraphTest, UncertaintyIsTheMeanSquareErrorAtTheArm) {
  const Eigen::Matrix3d P = Eigen::Vector3d(1.0, 2.0, 0.5).asDiagonal();
  EXPECT_DOUBLE_EQ(uncertainty(P), 3.5);
  EXPECT_DOUBLE_EQ(uncertainty(P, 2.0), 5.0);
}

TEST(SubmapGraphTest, PathsAreTheLeastUncertainOfAll) {
  Random random(1);
  int alone = 0;
  for (int i = 0; i < 40; ++i) {
    const SubmapGraph graph = any_graph(random, 5 + i % 6, true);
    const AllPaths all(graph);
    const std::vector<SubmapGraph::Path> paths = graph.paths();
    ASSERT_EQ(paths.size(), 7U);
    for (int submap = 0; submap < 7; ++submap) {
      ASSERT_EQ(paths[submap].previous == kNone, all.length[submap] == kInfinity);
      alone += paths[submap].previous == kNone ? 1 : 0;
      if (paths[submap].previous != kNone) expect_equal(paths[submap].X, all.least[submap]);
    }
  }
  EXPECT_GT(alone, 0);
}

TEST(SubmapGraphTest, ThePathBetweenTwoIsTheLeastUncertainOfAllUnlessTooUncertain) {
  Random random(6);
  int found = 0, refused = 0;
  for (int i = 0; i < 20; ++i) {
    const SubmapGraph graph = any_graph(random, 5 + i % 6, true);
    for (int a = 0; a < 7; ++a) {
      const AllPaths all(graph, a);
      for (int b = 0; b < 7; ++b) {
        constexpr double kWidest = 0.3;
        const auto path = graph.path(a, b, kWidest);
        ASSERT_EQ(path.has_value(), all.length[b] <= kWidest) << "from " << a << " to " << b;
        (path ? found : refused) += 1;
        if (path) expect_equal(*path, all.least[b]);
        const auto any = graph.path(a, b, 1e9);
        ASSERT_EQ(any.has_value(), all.length[b] < kInfinity);
      }
    }
  }
  EXPECT_GT(found, 200);
  EXPECT_GT(refused, 200);
}

// Whatever the correlations, a path leads from submap 0 and its pose is that of the links along it.
TEST(SubmapGraphTest, EveryPathComesFromTheFirstSubmap) {
  Random random(2);
  for (int i = 0; i < 40; ++i) {
    const SubmapGraph graph = any_graph(random, 6 + i % 10, false);
    const std::vector<SubmapGraph::Path> paths = graph.paths();
    EXPECT_EQ(paths[0].previous, 0);
    EXPECT_TRUE(paths[0].X.P.isZero(0.0));
    for (int submap = 1; submap < 7; ++submap) {
      if (paths[submap].previous == kNone) continue;
      std::vector<int> way{submap};
      while (way.back() != 0) {
        way.push_back(paths[way.back()].previous);
        ASSERT_LE(way.size(), 7U) << "a path that goes round and round";
      }
      UncertainPose X;
      for (std::size_t k = way.size() - 1; k > 0; --k) {
        const auto link = link_of(graph, way[k], way[k - 1]);
        ASSERT_TRUE(link);
        X = oplus(X, *link);
      }
      expect_equal(paths[submap].X, X);
    }
  }
}

TEST(SubmapGraphTest, HopsAreThoseOfTheShortestWay) {
  Random random(3);
  for (int i = 0; i < 40; ++i) {
    const SubmapGraph graph = any_graph(random, 5 + i % 6, true);
    EXPECT_EQ(graph.hops(0), AllPaths(graph).hops);
  }
  SubmapGraph chain;
  for (int i = 0; i < 4; ++i) chain.add();
  for (int i = 0; i < 3; ++i) chain.connect(i, i + 1, {});
  EXPECT_THAT(chain.hops(2), testing::ElementsAre(2, 1, 0, 1));
}

TEST(SubmapGraphTest, OfTwoLinksTheLessUncertainIsKept) {
  SubmapGraph graph;
  graph.add();
  graph.add();
  graph.connect(0, 1, with_sigma(1.0, 0.2));
  graph.connect(0, 1, with_sigma(2.0, 0.3));
  ASSERT_EQ(graph.links().size(), 1U);
  EXPECT_EQ(graph.links()[0].X_ab.X.x, 1.0);
  graph.connect(1, 0, with_sigma(-3.0, 0.1));
  ASSERT_EQ(graph.links().size(), 1U);
  EXPECT_EQ(graph.links()[0].a, 0);
  EXPECT_NEAR(graph.links()[0].X_ab.X.x, 3.0, 1e-14);
  EXPECT_NEAR(graph.paths()[1].X.X.x, 3.0, 1e-14);
  graph.connect(1, 0, with_sigma(-4.0, 0.2));
  EXPECT_NEAR(graph.paths()[1].X.X.x, 3.0, 1e-14);
}

TEST(SubmapGraphTest, NothingIsKnownOfASubmapUntilItIsLocated) {
  SubmapGraph graph;
  EXPECT_EQ(graph.add(), 0);
  EXPECT_EQ(graph.add(), 1);
  EXPECT_EQ(uncertainty(graph.pose(0).P), 0.0);
  EXPECT_EQ(uncertainty(graph.pose(1).P), kInfinity);
  EXPECT_THAT(graph.locate(1, with_sigma(5.0, 0.5)), testing::ElementsAre(1));
  EXPECT_EQ(graph.pose(1).X.x, 5.0);
  EXPECT_TRUE(graph.locate(1, with_sigma(6.0, 0.6)).empty()) << "less is known than before";
  EXPECT_EQ(graph.pose(1).X.x, 5.0);
  EXPECT_TRUE(graph.locate(0, with_sigma(1.0, 0.1)).empty()) << "submap 0 is the world";
}

// A loop of eight: the way round has made the last ones uncertain; when it closes, what is known at its
// beginning is passed on backwards as far as it is better.
TEST(SubmapGraphTest, AClosedLoopTellsAllAroundIt) {
  SubmapGraph graph;
  graph.add();
  UncertainPose X_WS;
  std::vector<UncertainPose> out{X_WS}, back(8);
  for (int i = 1; i < 8; ++i) {
    graph.add();
    const UncertainPose step{{4.0, 0.0, kPi / 4.0}, with_sigma(0.0, 0.1).P};
    graph.connect(i - 1, i, step);
    X_WS = oplus(X_WS, step);
    EXPECT_THAT(graph.locate(i, X_WS), testing::ElementsAre(i));
    out.push_back(X_WS);
  }
  const UncertainPose last{{-4.0 * std::sqrt(0.5), 4.0 * std::sqrt(0.5), -kPi / 4.0}, with_sigma(0.0, 0.1).P};
  graph.connect(0, 7, last);
  const std::vector<int> improved = graph.locate(7, last);
  back[7] = last;
  for (int i = 6; i > 0; --i) back[i] = oplus(back[i + 1], *link_of(graph, i + 1, i));
  const std::set<int> told(improved.begin(), improved.end());
  EXPECT_EQ(told, (std::set<int>{5, 6, 7}));
  for (int i = 1; i < 8; ++i) {
    EXPECT_EQ(uncertainty(back[i].P) < uncertainty(out[i].P), told.contains(i)) << "submap " << i;
    expect_equal(graph.pose(i), told.contains(i) ? back[i] : out[i]);
  }
}

// The end of it all is that no link tells more than a hundredth of what is not known; and it does end.
TEST(SubmapGraphTest, WhatIsLocatedIsPassedOnToTheEnd) {
  Random random(4);
  for (int i = 0; i < 40; ++i) {
    SubmapGraph graph = any_graph(random, 12, i % 2 == 0);
    graph.connect(3, 4, {});  // links known exactly, in a ring
    graph.connect(4, 5, {});
    graph.connect(5, 3, {});
    const std::vector<SubmapGraph::Path> paths = graph.paths();
    for (int submap = 1; submap < 7; ++submap)
      if (paths[submap].previous != kNone) graph.locate(submap, paths[submap].X);
    for (const SubmapGraph::Link& link : graph.links())
      if (link.a == 0) graph.locate(link.b, link.X_ab);
    for (int k = 0; k < 5; ++k) {
      graph.locate(1 + random.index(6), any_pose(random, false));
      for (const SubmapGraph::Link& link : graph.links()) {
        const double a = uncertainty(graph.pose(link.a).P), b = uncertainty(graph.pose(link.b).P);
        if (a < kInfinity) {
          EXPECT_GE(uncertainty(oplus(graph.pose(link.a), link.X_ab).P), 0.99 * b - 1e-12);
        }
        if (b < kInfinity) {
          EXPECT_GE(uncertainty(oplus(graph.pose(link.b), inverse(link.X_ab)).P), 0.99 * a - 1e-12);
        }
      }
    }
    EXPECT_EQ(uncertainty(graph.pose(0).P), 0.0);
  }
}

int count(const std::string& text, const std::string& what) {
  int n = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(SubmapGraphTest, TheDrawingHasAllSubmapsAndLinks) {
  Random random(5);
  const SubmapGraph graph = any_graph(random, 12, false);
  std::ostringstream out;
  graph.write_graphviz(out);
  const std::string text = out.str();
  EXPECT_TRUE(text.starts_with("graph"));
  for (int submap = 0; submap < 7; ++submap)
    EXPECT_EQ(count(text, "label=\"S" + std::to_string(submap) + "\""), 1);
  EXPECT_EQ(count(text, "--"), static_cast<int>(graph.links().size()));
  for (const SubmapGraph::Link& link : graph.links()) {
    std::ostringstream drawn;
    drawn << "\n" << link.a << "--" << link.b << " ";
    EXPECT_EQ(count(text, drawn.str()), 1);
  }
}

TEST(SubmapGraphTest, AnEmptyGraphHasNoPaths) { EXPECT_TRUE(SubmapGraph().paths().empty()); }

}  // namespace
}  // namespace leadline
