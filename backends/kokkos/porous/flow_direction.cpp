// Stage flow_direction (src/stages/flow_direction.hpp).

#include "porous/stages.hpp"
#include "porous/virtual_pressure.hpp"

namespace drench::kokkos_backend {

void flow_direction(const Constants& constants, const NeighborLists& lists, const Bodies& bodies, Cloth& cloth) {
  place_samples(cloth);
  const Real gravity_size = norm(constants.gravity);
  const Real3 gravity = constants.gravity;
  const Entries<Real3> direction = cloth.samples.flow_direction;
  const VirtualPressure pressure(constants, lists, bodies, cloth);
  parallel(
      "drench::flow_direction::flow", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        const Material& m = pressure.materials(p);
        if (!m.porous) {
          direction(p) = Real3{};
          return;
        }
        direction(p) = laws::flow_direction(laws::holding_pressure(pressure(p), gravity) + gravity,
                                            laws::flow_regularisation(gravity_size, m.virtual_pressure));
      });
}

}  // namespace drench::kokkos_backend
