// Stage flow_direction (src/stages/flow_direction.hpp).

#include "virtual_pressure.hpp"

namespace drench::kokkos_backend {

void flow_direction(Device& d, const StepInfo&, StepReport&) {
  place_samples(d);
  const Real gravity_size = norm(d.gravity);
  const Real3 gravity = d.gravity;
  const Entries<Real3> direction = d.samples.flow_direction;
  const Entries<Index> cloth = d.samples.cloth;
  const Entries<Material> materials = d.materials;
  const VirtualPressure pressure(d);
  parallel(
      "drench::flow_direction::flow", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        const Index c = cloth(p);
        if (!materials(c).porous) {
          direction(p) = Real3{};
          return;
        }
        direction(p) = laws::flow_direction(laws::holding_pressure(pressure(p), gravity) + gravity,
                                            laws::flow_regularisation(gravity_size, materials(c).virtual_pressure));
      });
}

}  // namespace drench::kokkos_backend
