#pragma once
// Patches of the cloth's nodes for its resident iterations (resident_cloth.cpp).

#include <cstdint>

#include "cloth/cloth.hpp"

namespace drench::kokkos_backend {

/// Who works on which nodes: patches of nodes that lie together, one a block, and the nodes around them.
struct PatchView {
  const Index* order;          // thread / lanes → node
  const std::uint16_t* local;  // of each link, in the order of Nodes::link: the other node's place in the patch
  const Index *around_start, *around;
  int room;  // places: a block's own nodes, then those around it
};

/// The arrays that a PatchView sees.
struct Patches {
  Array<Index> order, around_start, around;
  Array<std::uint16_t> local;
  int most = 0;  // around a patch

  PatchView view(int own_nodes) const {
    return {order.data(), local.data(), around_start.data(), around.data(), own_nodes + most};
  }
};

/// The patches of `own_nodes` nodes each, in the order of a curve through their rest positions.
Patches make_patches(const Constants& constants, const Cloth& cloth, int own_nodes);

}  // namespace drench::kokkos_backend
