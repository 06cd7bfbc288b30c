#include "leadline/submap/submap_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
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

/// All simple paths from submap 0, one by one.
struct AllPaths {
  explicit AllPaths(const SubmapGraph& graph)
      : graph(graph), least(graph.size()), hops(graph.size(), kNone), length(graph.size(), kInfinity) {
    follow({0}, {});
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

// A link is known from both ends, by the one of the lower number when it is told.
TEST(SubmapGraphTest, LinksOfOneSubmapLeadToThoseOfHigherNumber) {
  Random random(4);
  const SubmapGraph graph = any_graph(random, 14, false);
  std::size_t told = 0;
  for (int a = 0; a < graph.size(); ++a) {
    for (const SubmapGraph::Link& link : graph.links_from(a)) {
      EXPECT_EQ(link.a, a);
      EXPECT_LT(a, link.b);
      EXPECT_EQ(link.X_ab.P, link_of(graph, a, link.b)->P);
      ++told;
    }
  }
  EXPECT_EQ(told, graph.links().size());
  EXPECT_GT(told, 0U);
}

TEST(SubmapGraphTest, MadeFromItsLinksItIsAsItWas) {
  Random random(6);
  for (int i = 0; i < 10; ++i) {
    const SubmapGraph graph = any_graph(random, 5 + i, i % 2 == 0);
    const std::vector<SubmapGraph::Link> links = graph.links();
    const SubmapGraph again(graph.size(), links);
    ASSERT_EQ(again.size(), graph.size());
    ASSERT_EQ(again.links().size(), links.size());
    for (std::size_t k = 0; k < links.size(); ++k) {
      EXPECT_EQ(again.links()[k].a, links[k].a);
      EXPECT_EQ(again.links()[k].b, links[k].b);
      EXPECT_EQ(again.links()[k].X_ab.X.position(), links[k].X_ab.X.position());
      EXPECT_EQ(again.links()[k].X_ab.P, links[k].X_ab.P);
    }
    const std::vector<SubmapGraph::Path> before = graph.paths(), after = again.paths();
    for (int submap = 0; submap < graph.size(); ++submap)
      EXPECT_EQ(after[submap].previous, before[submap].previous);
  }
}

TEST(SubmapGraphTest, MadeFromSeveralLinksOfTwoItKeepsTheLeastUncertain) {
  const std::vector<SubmapGraph::Link> links{
      {0, 1, with_sigma(1.0, 0.2)}, {0, 1, with_sigma(2.0, 0.1)}, {0, 1, with_sigma(3.0, 0.3)}};
  const SubmapGraph graph(3, links);
  EXPECT_EQ(graph.size(), 3);
  ASSERT_EQ(graph.links().size(), 1U);
  EXPECT_EQ(graph.links()[0].X_ab.X.x, 2.0);
  EXPECT_EQ(graph.paths()[2].previous, kNone);
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

TEST(SubmapGraphTest, TheDrawingShowsTheTree) {
  const std::vector<SubmapGraph::Link> links{{0, 1, {}}, {1, 2, {}}, {0, 2, {}}};
  std::ostringstream out;
  SubmapGraph(3, links).write_graphviz(out, std::vector<SubmapGraph::Branch>{{kNone}, {0, 7}, {1, 9}});
  EXPECT_EQ(count(out.str(), "style=bold"), 2);
  EXPECT_EQ(count(out.str(), "7 shared"), 1);
  EXPECT_EQ(count(out.str(), "9 shared"), 1);
  EXPECT_EQ(count(out.str(), "--"), 3);
}

TEST(SubmapGraphTest, AnEmptyGraphHasNoPaths) { EXPECT_TRUE(SubmapGraph().paths().empty()); }

}  // namespace
}  // namespace leadline
