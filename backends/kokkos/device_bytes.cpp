// What the device state occupies, for reports.

#include "device.hpp"

namespace drench::kokkos_backend {
namespace {

template <class... Views>
std::int64_t sum_bytes(const Views&... v) {
  return (std::int64_t{0} + ... + static_cast<std::int64_t>(v.span() * sizeof(typename Views::value_type)));
}

std::int64_t list_bytes(const NeighborList& l) { return sum_bytes(l.count, l.list, l.slope); }

}  // namespace

std::int64_t Device::bytes() const {
  std::int64_t total = 0;
  for (const FluidArrays* f : {&fluid, &reorder.spare}) visit_arrays(*f, [&](const auto& a) { total += sum_bytes(a); });
  total += sum_bytes(work.volume, work.alpha, work.compliance, work.shift, work.place, work.flight, work.predicted,
                     work.rate, work.kappa_next, work.kappa_last, work.nearest_sample, work.active);
  total += sum_bytes(reorder.source);
  const SurfaceTensionWork& t = surface_tension_work;
  total += sum_bytes(t.normal, t.body_adhesion, t.cloth_adhesion);
  total += sum_bytes(boundary.position, boundary.velocity, boundary.rest_position, boundary.volume, boundary.body);
  const BodyArrays& b = bodies;
  total += sum_bytes(solids, fields, b.constant, b.state, b.sample, b.owner, b.position, b.force, b.predicted, b.part,
                     b.load, b.change, b.row_load, b.row_arm, b.row_bound);
  const NodeArrays& n = nodes;
  total += sum_bytes(n.position, n.velocity, n.contact_force, n.friction_force, n.pin_force, n.liquid, n.ripe,
                     n.solid_mass, n.pinned, mesh.rest_metric, n.link_start, n.link, n.cloth, n.capacity,
                     n.capacity_quanta, n.max_quanta, n.weight_sum, n.sample_start, n.sample_item, n.edge_start,
                     n.edge_item, n.hinge_start, n.hinge_item, n.limit_start, n.limit_item, n.pin_motion,
                     n.rest_position, pin_steps, n.inverse_mass, n.force, n.acceleration, n.row_bound);
  const MeshArrays& m = mesh;
  total += sum_bytes(m.triangle, m.edge, m.edge_length, m.edge_stiffness, m.hinge, m.hinge_weight, m.hinge_stiffness,
                     m.limit_shape, m.limit_stiffness);
  const SampleArrays& s = samples;
  total += sum_bytes(s.node, s.triangle, s.weight, s.weight_exact, s.cloth, s.area, s.capacity, s.rest_position,
                     s.flow_direction, s.volume, s.position, s.velocity, s.saturation, s.force, s.predicted, s.row_load,
                     s.row_bound);
  total += fluid_cells.bytes() + boundary_cells.bytes() + sample_cells.bytes();
  for (const NeighborList* l :
       {&fluid_fluid, &fluid_boundary, &fluid_sample, &sample_fluid, &sample_sample, &sample_boundary, &boundary_fluid})
    total += list_bytes(*l);
  return total;
}

}  // namespace drench::kokkos_backend
