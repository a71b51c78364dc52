// HostState → device and back.

#include <algorithm>
#include <numeric>

#include "device_copy.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {
namespace {

/// Copies values into the front of an array that is large enough.
template <class T, class S>
void put(const Array<T>& a, const std::vector<S>& values) {
  if (values.empty()) return;
  const auto part = Kokkos::subview(a, Kokkos::make_pair(std::size_t(0), values.size()));
  const auto mirror = Kokkos::create_mirror_view(part);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if constexpr (std::is_same_v<T, Real3>)
      mirror(i) = to_real(values[i]);
    else
      mirror(i) = static_cast<T>(values[i]);
  }
  Kokkos::deep_copy(part, mirror);
}

/// Puts `values` into the order that `place` says, the k-th being values[place[k]].
template <class T>
void arrange(std::vector<T>& values, const std::vector<Index>& place) {
  std::vector<T> ordered(values.size());
  for (std::size_t k = 0; k < values.size(); ++k) ordered[k] = values[static_cast<std::size_t>(place[k])];
  values = std::move(ordered);
}

}  // namespace

std::vector<Index> by_id(const std::vector<std::int64_t>& id) {
  std::vector<Index> place(id.size());
  std::iota(place.begin(), place.end(), Index{0});
  std::stable_sort(place.begin(), place.end(),
                   [&](Index a, Index b) { return id[static_cast<std::size_t>(a)] < id[static_cast<std::size_t>(b)]; });
  return place;
}

void Device::upload(const HostState& s) {
  fluid.count = 0;
  reserve_fluid(s.fluid_count());
  fluid.count = s.fluid_count();
  put(fluid.position, s.fluid_position);
  put(fluid.velocity, s.fluid_velocity);
  put(fluid.mass, s.fluid_mass);
  put(fluid.id, s.fluid_id);
  put(fluid.age, s.fluid_age);
  put(fluid.origin, s.fluid_origin);
  put(fluid.density_ratio, s.fluid_density_ratio);
  put(fluid.kappa_density, s.fluid_kappa_density);
  put(fluid.kappa_divergence, s.fluid_kappa_divergence);
  if (fluid.spins) {
    clear_spins(0, fluid.count);  // a state made by hand may have none
    put(fluid.spin, s.fluid_spin);
  }
  boundary.count = s.boundary_count();
  if (boundary.count > 0) {
    boundary.position = to_device3("drench::boundary_position", s.boundary_position);
    boundary.velocity = to_device3("drench::boundary_velocity", s.boundary_velocity);
    boundary.volume = to_device<Real>("drench::boundary_volume", s.boundary_volume);
    boundary_cells = CellTable(model.scene.sort);
  }
  upload_bodies(*this, s);
  if (nodes.count > 0) {
    nodes.position = to_device3("drench::node_position", s.node_position);
    nodes.velocity = to_device3("drench::node_velocity", s.node_velocity);
    nodes.liquid = to_device<Quanta>("drench::node_liquid", s.node_liquid);
    nodes.ripe = to_device<Quanta>("drench::node_ripe", s.node_ripe);
    nodes.contact_force = to_device3("drench::node_contact_force", s.node_contact_force);
    nodes.friction_force = to_device3("drench::node_friction_force", s.node_friction_force);
    nodes.pin_force = to_device3("drench::node_pin_force", s.node_pin_force);
  }
  put(samples.volume.extent(0) > 0 ? samples.volume : Array<Real>(),
      samples.volume.extent(0) > 0 ? s.sample_volume : std::vector<double>());
  put(samples.flow_direction.extent(0) > 0 ? samples.flow_direction : Array<Real3>(),
      samples.flow_direction.extent(0) > 0 ? s.sample_flow_direction : std::vector<Vec3>());
  drained = s.drained;
  supplied = s.supplied;
  next_id = s.next_id;
  jet_particles = s.jet_particles;
  jet_particles.resize(model.jets.size(), 0);
  step = s.step;
  time = s.time;
  samples_fresh = sample_bounds_fresh = sample_cells_fresh = sample_list_fresh = boundary_list_fresh = false;
  diffusion_work.rate_launched = measured.fresh = false;
}

HostState Device::download() const {
  HostState s;
  const Index n = fluid.count;
  s.fluid_position = to_host<Vec3>(fluid.position, n);
  s.fluid_velocity = to_host<Vec3>(fluid.velocity, n);
  s.fluid_mass = to_host<Quanta>(fluid.mass, n);
  s.fluid_id = to_host<std::int64_t>(fluid.id, n);
  s.fluid_age = to_host<double>(fluid.age, n);
  s.fluid_origin = to_host<std::uint8_t>(fluid.origin, n);
  s.fluid_density_ratio = to_host<double>(fluid.density_ratio, n);
  s.fluid_kappa_density = to_host<double>(fluid.kappa_density, n);
  s.fluid_kappa_divergence = to_host<double>(fluid.kappa_divergence, n);
  if (fluid.spins) s.fluid_spin = to_host<Vec3>(fluid.spin, n);
  if (!std::is_sorted(s.fluid_id.begin(), s.fluid_id.end())) {
    const std::vector<Index> place = by_id(s.fluid_id);
    visit_fields(s, [&](std::string_view name, auto& values) {
      if (name.starts_with("fluid_") && !values.empty()) arrange(values, place);
    });
  }
  s.boundary_position = to_host<Vec3>(boundary.position, boundary.count);
  s.boundary_velocity = to_host<Vec3>(boundary.velocity, boundary.count);
  s.boundary_volume = to_host<double>(boundary.volume, boundary.count);
  download_bodies(*this, s);
  s.node_position = to_host<Vec3>(nodes.position, nodes.count);
  s.node_velocity = to_host<Vec3>(nodes.velocity, nodes.count);
  s.node_liquid = to_host<Quanta>(nodes.liquid, nodes.count);
  s.node_ripe = to_host<Quanta>(nodes.ripe, nodes.count);
  s.node_contact_force = to_host<Vec3>(nodes.contact_force, nodes.count);
  s.node_friction_force = to_host<Vec3>(nodes.friction_force, nodes.count);
  s.node_pin_force = to_host<Vec3>(nodes.pin_force, nodes.count);
  s.sample_volume = to_host<double>(samples.volume, samples.count);
  s.sample_flow_direction = to_host<Vec3>(samples.flow_direction, samples.count);
  s.drained = drained;
  s.supplied = supplied;
  s.next_id = next_id;
  s.jet_particles = jet_particles;
  s.step = step;
  s.time = time;
  return s;
}

}  // namespace drench::kokkos_backend
