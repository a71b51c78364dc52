// Stage flow_direction (src/stages/flow_direction.hpp).

#include "device.hpp"
#include "laws/flow.hpp"

namespace drench::kokkos_backend {

void flow_direction(Device& d, const StepInfo&, StepReport&) {
  refresh_samples(d);
  const Kernel kernel = d.kernel;
  const Real h = d.support, gravity_size = norm(d.gravity);
  const Real3 gravity = d.gravity;
  const auto x = d.samples.position, xb = d.boundary.position, direction = d.samples.flow_direction;
  const auto vb = d.boundary.volume;
  const auto cloth = d.samples.cloth;
  const auto materials = d.materials;
  const auto count = d.sample_boundary.count;
  const auto list = d.sample_boundary.list;
  const bool solids = d.boundary.count > 0;
  parallel(
      "drench::flow_direction::flow", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        const Index c = cloth(p);
        if (!materials(c).porous) {
          direction(p) = Real3{};
          return;
        }
        const Real strength = materials(c).virtual_pressure;
        Real3 flow = gravity;
        if (solids)
          for (Index k = 0; k < count(p); ++k) {
            const Index b = list(p, k);
            const Real3 r = x(p) - xb(b);
            const Real length = norm(r);
            if (length > Real(1e-9) * h) flow -= strength * h * vb(b) * kernel.slope(length) * r;
          }
        direction(p) = laws::flow_direction(flow, laws::flow_regularisation(gravity_size, strength));
      });
}

}  // namespace drench::kokkos_backend
