#pragma once
// The virtual pressure of stages flow_direction and emission (src/stages/flow_direction.hpp).

#include "device.hpp"
#include "laws/flow.hpp"

namespace drench::kokkos_backend {

/// P′_p = −k^p h Σ_b V_b ∇W_pb over the solid samples near sample p, m/s² (Eq. 5): points away from them.
struct VirtualPressure {
  decltype(Device::samples.position) sample, solid;
  decltype(Device::boundary.volume) volume;
  decltype(Device::samples.cloth) cloth;
  decltype(Device::materials) materials;
  decltype(Device::sample_boundary.count) count;
  decltype(Device::sample_boundary.list) list;
  Kernel kernel;
  Real support;
  bool solids;

  explicit VirtualPressure(const Device& d)
      : sample(d.samples.position),
        solid(d.boundary.position),
        volume(d.boundary.volume),
        cloth(d.samples.cloth),
        materials(d.materials),
        count(d.sample_boundary.count),
        list(d.sample_boundary.list),
        kernel(d.kernel),
        support(d.support),
        solids(d.boundary.count > 0) {}

  KOKKOS_INLINE_FUNCTION Real3 operator()(Index p) const {
    Real3 sum{};
    const Real strength = materials(cloth(p)).virtual_pressure * support;
    const Index n = solids ? count(p) : 0;
    for (Index k = 0; k < n; ++k) {
      const Index b = list(p, k);
      const Real3 r = sample(p) - solid(b);
      const Real length = norm(r);
      if (length > Real(1e-9) * support) sum -= strength * volume(b) * kernel.slope(length) * r;
    }
    return sum;
  }
};

}  // namespace drench::kokkos_backend
