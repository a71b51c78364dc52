#pragma once
// Impact zones of stage self_collision (src/stages/self_collision.hpp, law 4).

#include <cstdint>
#include <functional>

#include "cloth/self_collision.hpp"

namespace drench::kokkos_backend {

/// Joins the nodes of pairs that would come too near into zones until no pair does. `renew` finds the pairs again if the
/// ends have moved too far. Returns the number of nodes in zones. Synchronises with the host.
std::int64_t join_zones(const Constants& constants, const Bodies& bodies, const Cloth& cloth, SelfCollisionWork& work, Real dt, const std::function<void()>& renew);

}  // namespace drench::kokkos_backend
