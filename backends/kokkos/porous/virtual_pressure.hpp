#pragma once
// The virtual pressure of stages flow_direction and emission (src/stages/flow_direction.hpp).

#include "porous/flow_law.hpp"
#include "porous/stages.hpp"

namespace drench::kokkos_backend {

/// P′_p = −k^p h Σ_b V_b ∇W_pb over the solid samples near sample p, m/s² (Eq. 5): points away from them.
struct VirtualPressure {
  Entries<const Real3> sample, solid;
  Entries<const Real> volume;
  Materials materials;
  Neighbors list;
  Kernel kernel;
  Real support;
  bool solids;

  explicit VirtualPressure(const Constants& constants, const NeighborLists& lists, const Bodies& bodies,
                           const Cloth& fabric)
      : sample(fabric.samples.position),
        solid(bodies.boundary.position),
        volume(bodies.boundary.volume),
        materials(sample_materials(fabric)),
        list(lists.sample_boundary),
        kernel(constants.kernel),
        support(constants.support),
        solids(bodies.boundary.count > 0) {}

  /// How many solid samples are near.
  KOKKOS_INLINE_FUNCTION Index count(Index p) const { return solids ? list.count(p) : 0; }
  KOKKOS_INLINE_FUNCTION Real3 operator()(Index p) const {
    Real3 sum{};
    const Real strength = materials(p).virtual_pressure * support;
    if (!solids) return sum;
    list.for_each(p, [&](Index b) {
      const Real3 r = sample(p) - solid(b);
      const Real length = norm(r);
      if (length > Real(1e-9) * support) sum -= strength * volume(b) * kernel.grad_factor(length) * r;
    });
    return sum;
  }
};

}  // namespace drench::kokkos_backend
