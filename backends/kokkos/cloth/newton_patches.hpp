#pragma once
// Patches and colours of the cloth's nodes for Newton's method on a GPU (newton_kernel.hpp).

#include <vector>

#include "cloth/dissection.hpp"

namespace drench::kokkos_backend {

struct NewtonPatches {
  std::vector<Index> order, start;  // nodes, patch by patch
};
/// Connected patches of equal sizes, as far as possible, and of `most` nodes at most, by bisection of the graph along
/// distances in it.
NewtonPatches make_newton_patches(const NodeGraph& near, Index patches, Index most);

/// A number for each node, so that no two neighbours have the same; the least that is free, in the order of nodes.
std::vector<std::uint16_t> colours_of(const NodeGraph& near);

}  // namespace drench::kokkos_backend
