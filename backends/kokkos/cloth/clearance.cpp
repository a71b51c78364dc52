#include "cloth/clearance.hpp"

#include "bodies/contact.hpp"

namespace drench::kokkos_backend {

void set_clearance(const Constants& constants, const Bodies& bodies, Cloth& cloth, Real dt) {
  if (bodies.solids.extent(0) == 0) return;
  const Version both = cloth.moved + bodies.moved;
  if (cloth.cleared == both && cloth.cleared_for == dt && !constants.model.has_dynamic_body()) return;
  cloth.cleared = both;
  cloth.cleared_for = dt;
  allocate_zeros(cloth.nodes.clearance, "drench::node_clearance", static_cast<std::size_t>(cloth.nodes.count));
  const Slice<const Solid> solids = bodies.solids;
  const Materials materials = node_materials(cloth);
  const Entries<const Real3> position = std::as_const(cloth).nodes.position;
  const Entries<Real> clearance = cloth.nodes.clearance;
  parallel(
      "drench::cloth::clearance", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Real thickness = materials(n).thickness;
        clearance(n) = least_kept(solids, position(n), {thickness, thickness, materials(n).release * dt, dt});
      });
}

}  // namespace drench::kokkos_backend
