#pragma once
// An order of elimination whose work several threads can share (cloth/block_cholesky.hpp).

#include <vector>

#include "base/types.hpp"

namespace drench::kokkos_backend {

/// For each node those that share an entry of the matrix with it.
using NodeGraph = std::vector<std::vector<Index>>;

/// Parts that share no entry, and the nodes between them, which come last. It depends on the graph alone.
struct Dissection {
  Index parts = 1;
  std::vector<Index> part;   // of each node; `parts`: between them
  std::vector<Index> place;  // of each node, in the order of elimination: minimum degree within each part
};
Dissection dissect(const NodeGraph& near);

/// The graph with each node at its place.
NodeGraph reordered(const NodeGraph& near, const std::vector<Index>& place);
/// Columns of the Cholesky factor in that order: their first row below the diagonal, −1 if there is none.
std::vector<Index> elimination_tree(const NodeGraph& near);
/// Places with which children stand before their parents.
std::vector<Index> postorder(const std::vector<Index>& parent);

}  // namespace drench::kokkos_backend
