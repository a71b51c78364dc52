#pragma once
// What of a cloth can collide, in clusters (CollisionItems).

#include "cloth/self_collision.hpp"

namespace drench::kokkos_backend {

/// Lists the nodes, triangles and edges that take part; sets `items`, `member`, `nodes` and `thickness`.
void list_items(const Constants& constants, SelfCollisionWork& work);
/// Their bytes, as if all cloth took part.
double item_bytes(const Sizing& s);

}  // namespace drench::kokkos_backend
