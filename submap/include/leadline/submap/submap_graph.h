/// @file
/// How the submaps hang together: relative poses, and the least uncertain way between two of them.
#pragma once

#include <boost/graph/adjacency_list.hpp>
#include <iosfwd>
#include <optional>
#include <span>
#include <vector>

#include "leadline/core/se2.h"

namespace leadline {

/// Vertices are submaps, counted from 0, whose frame is W; edges are relative poses with covariance, each
/// known from what one submap holds of both frames. In the manner of Atlas (Bosse et al. 2004).
class SubmapGraph {
 public:
  static constexpr int kNone = -1;

  struct Link {
    int a = 0, b = 0;    ///< a < b
    UncertainPose X_ab;  ///< frame of b in that of a
  };

  /// A submap in W by the least uncertain path from submap 0.
  struct Path {
    int previous = kNone;  ///< submap before it on that path; its own for submap 0; kNone: there is no path
    UncertainPose X;
  };

  SubmapGraph() = default;
  /// As another was. @param poses by number, infinite variance where nothing is known.
  /// @param links between two of those; of several between the same two the least uncertain counts.
  SubmapGraph(std::span<const UncertainPose> poses, std::span<const Link> links);

  /// One more submap, about whose place in W nothing is known unless it is submap 0. @return its number.
  int add();
  int size() const { return static_cast<int>(boost::num_vertices(graph_)); }

  /// Links two submaps, or replaces their link if the new one is the less uncertain.
  void connect(int a, int b, const UncertainPose& X_ab);

  /// A new estimate of a submap in W, whose links may be new as well. What improves on what was known of it
  /// or of others is taken and passed on along links; so a loop that is closed tells all around it.
  /// @return the submaps of which more is known now; one may be named twice.
  std::vector<int> locate(int submap, const UncertainPose& X_WS);

  /// Where a submap is as far as is known; infinite variance where nothing is.
  const UncertainPose& pose(int submap) const { return graph_[static_cast<std::size_t>(submap)]; }

  /// X_ab by the least uncertain path between two submaps, if there is one of at most @p widest [m^2].
  /// Costs what lies within that uncertainty of @p a, whatever the size of the graph.
  std::optional<UncertainPose> path(int a, int b, double widest) const;

  std::vector<Link> links() const;
  /// Those of @p a to submaps of higher number.
  std::vector<Link> links_from(int a) const;

  /// Dijkstra with compounding for addition (eq. 36-37). Links count as independent of each other.
  std::vector<Path> paths() const;

  /// Breadth first: number of links from @p start to every submap, kNone where there is no path.
  std::vector<int> hops(int start) const;

  /// The graph for Graphviz; links are as long as the distance of the frames [m].
  void write_graphviz(std::ostream& out) const;

 private:
  void append_links(int a, std::vector<Link>& links) const;

  using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::directedS, UncertainPose,
                                      UncertainPose>;  // each link in both directions
  Graph graph_;
};

/// How uncertain a pose is [m^2]: the mean square error of a point at @p arm [m] from its origin, which
/// weighs metres and radians in one number. Never negative.
double uncertainty(const Eigen::Matrix3d& P, double arm = 1.0);

}  // namespace leadline
