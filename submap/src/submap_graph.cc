#include "leadline/submap/submap_graph.h"

#include <algorithm>
#include <boost/graph/breadth_first_search.hpp>
#include <boost/graph/dijkstra_shortest_paths.hpp>
#include <boost/graph/graphviz.hpp>
#include <cmath>
#include <limits>
#include <ostream>

namespace leadline {

namespace {

/// Length of a path: where it leads, and how uncertain that is.
struct Length {
  UncertainPose X;
  double uncertainty = 0.0;

  bool operator<(const Length& other) const { return uncertainty < other.uncertainty; }
};

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Length compound(const Length& path, const UncertainPose& link) {
  if (path.uncertainty == kInfinity) return path;
  const UncertainPose X = oplus(path.X, link);
  // A correlation of place and heading may make a longer way less uncertain; a path must not gain by it.
  return {X, std::max(uncertainty(X.P), path.uncertainty)};
}

}  // namespace

double uncertainty(const Eigen::Matrix3d& P, double arm) {
  return std::max(P(0, 0) + P(1, 1) + arm * arm * P(2, 2), 0.0);  // rounding may leave less
}

SubmapGraph::SubmapGraph(int size, std::span<const Link> links) : graph_(static_cast<std::size_t>(size)) {
  for (const auto& [a, b, X_ab] : links) connect(a, b, X_ab);
}

int SubmapGraph::add() { return static_cast<int>(boost::add_vertex(graph_)); }

void SubmapGraph::connect(int a, int b, const UncertainPose& X_ab) {
  const auto from = static_cast<std::size_t>(a), to = static_cast<std::size_t>(b);
  const auto [link, exists] = boost::edge(from, to, graph_);
  if (!exists) {
    boost::add_edge(from, to, X_ab, graph_);
    boost::add_edge(to, from, inverse(X_ab), graph_);
  } else if (uncertainty(X_ab.P) < uncertainty(graph_[link].P)) {
    graph_[link] = X_ab;
    graph_[boost::edge(to, from, graph_).first] = inverse(X_ab);
  }
}

std::vector<SubmapGraph::Link> SubmapGraph::links() const {
  std::vector<Link> links;
  links.reserve(boost::num_edges(graph_) / 2);
  for (int a = 0; a < size(); ++a) append_links(a, links);
  return links;
}

std::vector<SubmapGraph::Link> SubmapGraph::links_from(int a) const {
  std::vector<Link> links;
  append_links(a, links);
  return links;
}

void SubmapGraph::append_links(int a, std::vector<Link>& links) const {
  for (const auto& link : boost::make_iterator_range(boost::out_edges(static_cast<std::size_t>(a), graph_))) {
    const int b = static_cast<int>(boost::target(link, graph_));
    if (a < b) links.push_back({a, b, graph_[link]});
  }
}

std::vector<SubmapGraph::Path> SubmapGraph::paths() const {
  const std::size_t n = boost::num_vertices(graph_);
  if (n == 0) return {};
  std::vector<std::size_t> previous(n);
  std::vector<Length> length(n);
  const auto index = boost::get(boost::vertex_index, graph_);
  boost::dijkstra_shortest_paths(
      graph_, 0,
      boost::predecessor_map(boost::make_iterator_property_map(previous.begin(), index))
          .distance_map(boost::make_iterator_property_map(length.begin(), index))
          .weight_map(boost::get(boost::edge_bundle, graph_))
          .distance_compare(std::less<Length>())
          .distance_combine(&compound)
          .distance_inf(Length{{}, kInfinity})
          .distance_zero(Length{}));
  std::vector<Path> paths(n);
  for (std::size_t i = 0; i < n; ++i)
    if (length[i].uncertainty < kInfinity) paths[i] = {static_cast<int>(previous[i]), length[i].X};
  return paths;
}

std::vector<int> SubmapGraph::hops(int start) const {
  std::vector<int> hops(boost::num_vertices(graph_), kNone);
  hops[static_cast<std::size_t>(start)] = 0;
  const auto recorder = boost::record_distances(hops.data(), boost::on_tree_edge());
  boost::breadth_first_search(graph_, static_cast<std::size_t>(start),
                              boost::visitor(boost::make_bfs_visitor(recorder)));
  return hops;
}

void SubmapGraph::write_graphviz(std::ostream& out, std::span<const Branch> tree) const {
  const auto branch = [&](int child, int parent) {
    const auto k = static_cast<std::size_t>(child);
    return k < tree.size() && tree[k].parent == parent ? &tree[k] : nullptr;
  };
  using Drawn = boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS, boost::no_property, Link>;
  Drawn drawn(boost::num_vertices(graph_));
  for (const Link& link : links())
    boost::add_edge(static_cast<std::size_t>(link.a), static_cast<std::size_t>(link.b), link, drawn);
  boost::write_graphviz(
      out, drawn, [](std::ostream& to, std::size_t submap) { to << "[label=\"S" << submap << "\"]"; },
      [&](std::ostream& to, const auto& edge) {
        const auto& [a, b, X] = drawn[edge];
        to << "[len=" << X.X.position().norm() << ", label=\"" << std::sqrt(uncertainty(X.P)) << " m";
        if (const Branch* held = branch(b, a))
          to << ", " << held->shared << " shared\", style=bold]";
        else
          to << "\"]";
      },
      [](std::ostream& to) { to << "graph [layout=neato];\nnode [shape=circle];\n"; });
}

}  // namespace leadline
