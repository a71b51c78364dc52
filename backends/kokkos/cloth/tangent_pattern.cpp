#include "cloth/tangent_pattern.hpp"

#include <numeric>

#include "cloth/solver.hpp"

namespace drench::kokkos_backend {
namespace {

/// The edges by their nodes.
class EdgeNumbers {
 public:
  EdgeNumbers(const ClothSystem& s, Index nodes, Index edges) : start_(at(nodes + 1), 0), edge_(at(edges)) {
    for (Index e = 0; e < edges; ++e) ++start_[at(s.edge(2 * e) + 1)];
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    std::vector<Index> next(start_.begin(), start_.end() - 1);
    for (Index e = 0; e < edges; ++e) edge_[at(next[at(s.edge(2 * e))]++)] = {s.edge(2 * e + 1), e};
  }
  /// The last edge from a to b, or −1.
  Index from(Index a, Index b) const {
    Index found = -1;
    for (Index k = start_[at(a)]; k < start_[at(a + 1)]; ++k)
      if (edge_[at(k)].end == b) found = edge_[at(k)].number;
    return found;
  }

 private:
  struct Edge {
    Index end, number;
  };
  std::vector<Index> start_;
  std::vector<Edge> edge_;
};

}  // namespace

TangentPattern::TangentPattern(const ClothSystem& s, Index nodes, Index edges, Index triangles)
    : edge_of(at(s.link_start(nodes)), -1),
      pair_of(edge_of.size(), -1),
      pair_start(1, 0),
      bending_start(1, 0),
      part_start(1, 0),
      bending(at(nodes)) {
  const EdgeNumbers number(s, nodes, edges);
  for (Index n = 0; n < nodes; ++n) {
    for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l) {
      const Link link = s.link(l);
      bending[at(n)] -= link.bend;
      if (const Index e = number.from(n, link.other); e >= 0) edge_of[at(l)] = 2 * e;
      if (const Index e = number.from(link.other, n); e >= 0) edge_of[at(l)] = 2 * e + 1;
      if (edge_of[at(l)] < 0) {
        bending_pairs.push_back({link.other, link.bend});
        continue;
      }
      pair_of[at(l)] = static_cast<Index>(pairs.size());
      pairs.push_back({link.other, edge_of[at(l)], link.bend});
    }
    pair_start.push_back(static_cast<Index>(pairs.size()));
    bending_start.push_back(static_cast<Index>(bending_pairs.size()));
  }
  std::vector<std::vector<EdgePart>> of_edge(at(edges));
  for (Index t = 0; t < triangles; ++t)
    for (Index k = 0; k < 3; ++k) {
      const Index a = s.triangle(3 * t + k), b = s.triangle(3 * t + (k + 1) % 3);
      const std::size_t block = 6 * at(t) + 3 + at(k);
      if (const Index e = number.from(a, b); e >= 0) of_edge[at(e)].push_back({block, false});
      if (const Index e = number.from(b, a); e >= 0) of_edge[at(e)].push_back({block, true});
    }
  for (const auto& of : of_edge) {
    parts.insert(parts.end(), of.begin(), of.end());
    part_start.push_back(static_cast<Index>(parts.size()));
  }
}

}  // namespace drench::kokkos_backend
