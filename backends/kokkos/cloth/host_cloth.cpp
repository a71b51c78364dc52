#include "cloth/host_cloth.hpp"

#include "bodies/deforming_body.hpp"

namespace drench::kokkos_backend {

HostCloth::HostCloth(const Bodies& bodies, const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s)
    : system(s) {
  displacement = copy(solver.displacement);
  const Nodes& nodes = cloth.nodes;
  const Mesh& mesh = cloth.mesh;
  system.start = copy(nodes.position);
  system.target = copy(solver.target);
  system.mass = copy(solver.mass);
  system.diagonal = copy(solver.diagonal);
  system.friction = copy(solver.friction);
  system.solid_mass = copy(nodes.solid_mass);
  system.kept = copy(nodes.clearance);
  system.saturation = copy(solver.saturation);
  system.pinned = copy(nodes.pinned);
  system.link_start = copy(nodes.link_start);
  system.link = copy(nodes.link);
  system.edge = copy(mesh.edge);
  system.edge_start = system.edge_item = {};
  system.edge_length = system.edge_stiffness = {};
  system.triangle = copy(mesh.triangle);
  system.triangle_start = copy(nodes.triangle_start);
  system.triangle_item = copy(nodes.triangle_item);
  system.shape = copy(mesh.triangle_shape);
  system.limit_stiffness = copy(mesh.limit_stiffness);
  system.membrane = copy(mesh.membrane);
  system.materials = {copy(material_numbers(nodes)), copy(cloth.materials)};
  system.solids = copy_solids(bodies, solver);
}

template <class T>
Entries<T> HostCloth::copy(const Field<T>& a) {
  if (!a.exists()) return {};
  const Kokkos::View<T*, Kokkos::HostSpace> own(Kokkos::ViewAllocateWithoutInitializing("drench::cloth::on_host"),
                                                a.extent(0));
  copy_now(own, a);
  kept_.emplace_back(own);
  return {own.data(), own.extent(0)};
}

Slice<const Solid> HostCloth::copy_solids(const Bodies& bodies, ClothSolverWork& solver) {
  const Entries<Solid> solids = copy(bodies.solids);
  // Up to hundreds of megabytes that never change.
  auto& fields = solver.fields_on_host;
  if (bodies.distance_fields.exists() && fields.extent(0) == 0) {
    fields = Kokkos::View<Real*, Kokkos::HostSpace>(
        Kokkos::ViewAllocateWithoutInitializing("drench::cloth::fields_on_host"), bodies.distance_fields.extent(0));
    copy_now(fields, bodies.distance_fields);
  }
  const std::size_t count = bodies.solids.extent(0);
  for (std::size_t b = 0; b < count; ++b) {
    Solid& solid = solids(b);
    if (solid.field != nullptr) solid.field = fields.data() + (solid.field - bodies.distance_fields.data());
  }
  for (const auto& body : bodies.deforming) {
    Solid& solid = solids(body->index);
    solid.field = copy(body->distance).data;
    solid.surface = {copy(body->nearest).data, copy(body->corner).data, copy(body->position).data,
                     copy(body->velocity).data};
  }
  return {solids.data, count};
}

void HostCloth::write_displacement(ClothSolverWork& solver) const {
  const Kokkos::View<const Real3*, Kokkos::HostSpace, Kokkos::MemoryTraits<Kokkos::Unmanaged>> result(
      displacement.data, solver.displacement.extent(0));
  copy_now(solver.displacement, result);
}

}  // namespace drench::kokkos_backend
