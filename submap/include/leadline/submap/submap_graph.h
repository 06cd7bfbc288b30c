/// @file
/// How submaps lie to each other: relative poses, and the least uncertain way to each of them.
#pragma once

#include <boost/graph/adjacency_list.hpp>
#include <iosfwd>
#include <span>
#include <vector>

#include "leadline/core/se2.h"

namespace leadline {

/// Vertices are submaps, counted from 0, each at the pose of the vehicle where it opened the submap; submap 0
/// at W. Edges are relative poses with covariance, as they were believed at a crossing, when one joint held
/// both. In the manner of Atlas (Bosse et al. 2004). For display and refinement: what the filter knows goes
/// from submap to submap along the tree (SubmapManager), not here.
class SubmapGraph {
 public:
  static constexpr int kNone = -1;

  struct Link {
    int a = 0, b = 0;    ///< a < b
    UncertainPose X_ab;  ///< pose of b as seen from that of a
  };

  /// A submap in W by the least uncertain path from submap 0.
  struct Path {
    int previous = kNone;  ///< submap before it on that path; its own for submap 0; kNone: there is no path
    UncertainPose X;
  };

  SubmapGraph() = default;
  /// As another was. @param links between two of @p size submaps; of several between the same two the least
  /// uncertain counts.
  SubmapGraph(int size, std::span<const Link> links);

  /// One more submap. @return its number.
  int add();
  int size() const { return static_cast<int>(boost::num_vertices(graph_)); }

  /// Links two submaps, or replaces their link if the new one is the less uncertain.
  void connect(int a, int b, const UncertainPose& X_ab);

  std::vector<Link> links() const;
  /// Those of @p a to submaps of higher number.
  std::vector<Link> links_from(int a) const;

  /// Dijkstra with compounding for addition (eq. 36-37). Links count as independent of each other.
  std::vector<Path> paths() const;

  /// Breadth first: number of links from @p start to every submap, kNone where there is no path.
  std::vector<int> hops(int start) const;

  /// How a submap hangs on the tree.
  struct Branch {
    int parent = kNone;
    int shared = 0;  ///< features that both hold
  };
  /// The graph for Graphviz; links are as long as the distance of the poses [m]. @param tree branches by
  /// submap: drawn bold, with what they share.
  void write_graphviz(std::ostream& out, std::span<const Branch> tree = {}) const;

 private:
  void append_links(int a, std::vector<Link>& links) const;

  using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::directedS, boost::no_property,
                                      UncertainPose>;  // each link in both directions
  Graph graph_;
};

/// How uncertain a pose is [m^2]: the mean square error of a point at @p arm [m] from its origin, which
/// weighs metres and radians in one number. Never negative.
double uncertainty(const Eigen::Matrix3d& P, double arm = 1.0);

}  // namespace leadline
