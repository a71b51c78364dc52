// Stage flow_direction (src/stages/flow_direction.hpp).

#include "porous/virtual_pressure.hpp"
#include "porous/stages.hpp"

namespace drench::kokkos_backend {

void flow_direction(const Constants& constants, const NeighborLists& lists, const Bodies& bodies, Cloth& cloth) {
  place_samples(cloth);
  const Real gravity_size = norm(constants.gravity);
  const Real3 gravity = constants.gravity;
  const Entries<Real3> direction = cloth.samples.flow_direction;
  const Entries<const Index> cloth_of = cloth.samples.cloth;
  const Entries<const Material> materials = cloth.materials;
  const VirtualPressure pressure(constants, lists, bodies, cloth);
  parallel(
      "drench::flow_direction::flow", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        const Index c = cloth_of(p);
        if (!materials(c).porous) {
          direction(p) = Real3{};
          return;
        }
        direction(p) = laws::flow_direction(laws::holding_pressure(pressure(p), gravity) + gravity,
                                            laws::flow_regularisation(gravity_size, materials(c).virtual_pressure));
      });
}

}  // namespace drench::kokkos_backend
