#pragma once
// An order of elimination whose work several threads can share (cloth/block_cholesky.hpp).

#include <vector>

#include "base/types.hpp"

namespace drench::kokkos_backend {

/// For each node those that share an entry of the matrix with it.
using NodeGraph = std::vector<std::vector<Index>>;

/// Nested dissection: halves of a graph that share no entry, and separators between them, again and again. It depends
/// on the graph alone. Parts are numbered level by level: 2^levels leaves, then the separators of pairs of leaves, up
/// to the one that halves the whole graph.
struct Dissection {
  Index levels = 0;          // of separators
  std::vector<Index> part;   // of each node
  std::vector<Index> place;  // of each node, in the order of elimination: minimum degree within each part

  /// The first part of a level; 0: leaves.
  Index first_part(Index level) const { return (Index{2} << levels) - ((Index{2} << levels) >> level); }
  Index parts_on(Index level) const { return Index{1} << (levels - level); }
  Index parts() const { return first_part(levels + 1); }
  Index level_of(Index part) const {
    Index level = 0;
    while (part >= first_part(level + 1)) ++level;
    return level;
  }
  /// Is `part` one of those that separator `other` keeps apart?
  bool is_below(Index part, Index other) const {
    const Index level = level_of(part), above = level_of(other);
    return level < above && (part - first_part(level)) % parts_on(above) == other - first_part(above);
  }
};
Dissection dissect(const NodeGraph& near);

/// The graph with each node at its place.
NodeGraph reordered(const NodeGraph& near, const std::vector<Index>& place);
/// Columns of the Cholesky factor in that order: their first row below the diagonal, −1 if there is none.
std::vector<Index> elimination_tree(const NodeGraph& near);
/// Places with which children stand before their parents.
std::vector<Index> postorder(const std::vector<Index>& parent);

}  // namespace drench::kokkos_backend
