#include "setup/boundary_loops.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/eigen_vec.hpp"

namespace drench {

std::vector<Chain> chains_of(const std::vector<std::array<Index, 2>>& edges) {
  std::map<Index, std::set<Index>> next;
  for (const auto& [a, b] : edges) {
    next[a].insert(b);
    next[b].insert(a);
  }
  const auto walk = [&](Index from) {
    Chain chain{{from}, false};
    for (Index here = from; !next[here].empty();) {
      const Index there = *next[here].begin();
      next[here].erase(there);
      next[there].erase(here);
      here = there;
      if (here == from && next[here].empty()) {
        chain.closed = true;
        break;
      }
      chain.nodes.push_back(here);
    }
    return chain;
  };
  std::vector<Chain> chains;
  std::vector<Index> ends;
  for (const auto& [node, others] : next)
    if (others.size() % 2 == 1) ends.push_back(node);
  for (const Index node : ends)
    if (!next[node].empty()) chains.push_back(walk(node));
  std::vector<Index> nodes;
  for (const auto& entry : next) nodes.push_back(entry.first);
  for (const Index node : nodes)
    while (!next[node].empty()) chains.push_back(walk(node));
  std::sort(chains.begin(), chains.end(), [](const Chain& a, const Chain& b) {
    return *std::min_element(a.nodes.begin(), a.nodes.end()) < *std::min_element(b.nodes.begin(), b.nodes.end());
  });
  return chains;
}

std::vector<Chain> boundary_loops(const std::vector<std::array<Index, 3>>& triangles) {
  std::vector<std::array<Index, 2>> edges;
  for (const MeshEdge& e : mesh_edges(triangles))
    if (e.triangles == 1) edges.push_back({e.a, e.b});
  return chains_of(edges);
}

double length_of(const Chain& chain, const std::vector<Vec3>& points) {
  const auto at = [&](std::size_t k) { return to_eigen(points[static_cast<std::size_t>(chain.nodes[k])]); };
  double length = 0;
  for (std::size_t k = 0; k + 1 < chain.nodes.size(); ++k) length += (at(k + 1) - at(k)).norm();
  return chain.closed ? length + (at(0) - at(chain.nodes.size() - 1)).norm() : length;
}

}  // namespace drench
