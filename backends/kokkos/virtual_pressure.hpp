#pragma once
// The virtual pressure of stages flow_direction and emission (src/stages/flow_direction.hpp).

#include "device.hpp"
#include "laws/flow.hpp"

namespace drench::kokkos_backend {

/// P′_p = −k^p h Σ_b V_b ∇W_pb over the solid samples near sample p, m/s² (Eq. 5): points away from them.
struct VirtualPressure {
  Entries<Real3> sample, solid;
  Entries<Real> volume;
  Entries<Index> cloth;
  Entries<Material> materials;
  Neighbors list;
  Kernel kernel;
  Real support;
  bool solids;

  explicit VirtualPressure(const Device& d)
      : sample(d.samples.position),
        solid(d.boundary.position),
        volume(d.boundary.volume),
        cloth(d.samples.cloth),
        materials(d.materials),
        list(d.sample_boundary),
        kernel(d.kernel),
        support(d.support),
        solids(d.boundary.count > 0) {}

  /// How many solid samples are near.
  KOKKOS_INLINE_FUNCTION Index count(Index p) const { return solids ? list.count(p) : 0; }
  KOKKOS_INLINE_FUNCTION Real3 operator()(Index p) const {
    Real3 sum{};
    const Real strength = materials(cloth(p)).virtual_pressure * support;
    if (!solids) return sum;
    const NeighborRow near = list.row(p);
    for (Index k = 0; k < near.count; ++k) {
      const Index b = near(k);
      const Real3 r = sample(p) - solid(b);
      const Real length = norm(r);
      if (length > Real(1e-9) * support) sum -= strength * volume(b) * kernel.slope(length) * r;
    }
    return sum;
  }
};

}  // namespace drench::kokkos_backend
