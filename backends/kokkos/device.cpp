#include "device.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "device_copy.hpp"
#include "laws/viscosity.hpp"

namespace drench::kokkos_backend {
namespace {

Solid solid_of(const Body& b) {
  Solid s{};
  s.kind = static_cast<int>(b.kind);
  s.inside = b.inside ? 1 : 0;
  s.min = to_real(b.box.min);
  s.max = to_real(b.box.max);
  s.center = to_real(b.center);
  s.point = to_real(b.point);
  s.normal = to_real(b.normal);
  s.radius = Real(b.radius);
  s.moves = b.moves() ? 1 : 0;
  s.rest_normal = s.normal;
  for (std::size_t a = 0; a < 3; ++a) s.field_points[a] = b.field.points[a];
  s.field_spacing = Real(b.field.spacing);
  s.field_origin =
      to_real({b.field.origin[0] - b.center[0], b.field.origin[1] - b.center[1], b.field.origin[2] - b.center[2]});
  return s;
}

void make_solids(Device& d) {
  std::vector<double> values;
  for (const Body& b : d.model.bodies) values.insert(values.end(), b.field.value.begin(), b.field.value.end());
  if (!values.empty()) d.fields = to_device<Real>("drench::distance_fields", values);
  std::vector<Solid> list;
  std::size_t first = 0;
  for (const Body& b : d.model.bodies) {
    list.push_back(solid_of(b));
    if (!b.field.empty()) list.back().field = d.fields.data() + first;
    first += b.field.value.size();
  }
  d.solids = to_device<Solid>("drench::solids", list);
}

Material material_of(const ClothMaterial& c) {
  Material m{};
  m.thickness = Real(c.thickness);
  m.damping = Real(c.damping);
  m.strain_damping = Real(c.strain_damping);
  m.friction = Real(c.friction);
  m.friction_wet = Real(c.friction_wet);
  m.damping_wet = Real(c.damping_wet);
  m.strain_limit = Real(c.strain_limit);
  m.solid_fraction = Real(c.solid_fraction);
  m.absorption = Real(c.absorption);
  m.max_saturation = Real(c.max_saturation);
  m.virtual_pressure = Real(c.virtual_pressure);
  m.emission_cosine = Real(c.emission_cosine);
  m.emission_velocity = Real(c.emission_velocity);
  m.diffusivity = Real(c.diffusivity);
  m.capillary_height = Real(c.capillary_height);
  m.degenerate = c.diffusion == DiffusionLaw::degenerate ? 1 : 0;
  m.contact_wicking = c.porous && c.diffusivity > 0 && c.contact_wicking ? 1 : 0;
  m.porous = c.porous ? 1 : 0;
  m.dynamics = c.dynamics ? 1 : 0;
  m.wet_adhesion = Real(c.wet_adhesion);
  m.self_collision = c.self_collision ? 1 : 0;
  return m;
}

Vec3 squares(const Vec3& a) { return {a[0] * a[0], a[1] * a[1], a[2] * a[2]}; }

/// Springs and hinges as one sparse row a node: a third of the loads of going edge by edge and hinge by hinge.
void make_links(Device& d) {
  const ClothMesh& mesh = d.model.mesh;
  std::vector<std::map<Index, Link>> rows(mesh.rest_position.size());
  const auto link = [&](Index n, Index other) -> Link& {
    return rows[static_cast<std::size_t>(n)].try_emplace(other, Link{other, 0, 0, 0}).first->second;
  };
  for (std::size_t e = 0; e < mesh.edge.size(); ++e)
    for (std::size_t end = 0; end < 2; ++end) {
      Link& l = link(mesh.edge[e][end], mesh.edge[e][1 - end]);
      l.length = Real(mesh.edge_length[e]);
      l.stiffness = Real(mesh.edge_stiffness[e]);
    }
  std::vector<std::map<Index, double>> bending(rows.size());
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < 4; ++b)
        if (a != b)
          bending[static_cast<std::size_t>(mesh.hinge[h][a])][mesh.hinge[h][b]] +=
              mesh.hinge_stiffness[h] * mesh.hinge_weight[h][a] * mesh.hinge_weight[h][b];
  for (std::size_t n = 0; n < bending.size(); ++n)
    for (const auto& [other, weight] : bending[n]) link(static_cast<Index>(n), other).bend = Real(weight);
  std::vector<Index> start{0};
  std::vector<Link> links;
  for (const auto& row : rows) {
    for (const auto& entry : row) links.push_back(entry.second);
    start.push_back(static_cast<Index>(links.size()));
  }
  d.nodes.link_start = to_device<Index>("drench::node_link_start", start);
  d.nodes.link = to_device<Link>("drench::node_link", links);
}

void make_nodes(Device& d) {
  const ClothMesh& mesh = d.model.mesh;
  const SampleSet& samples = d.model.samples;
  NodeArrays& n = d.nodes;
  n.count = mesh.nodes();
  n.solid_mass = to_device<Real>("drench::node_solid_mass", mesh.solid_mass);
  n.pinned = to_device<std::uint8_t>("drench::node_pinned", mesh.pinned);
  n.cloth = to_device<Index>("drench::node_cloth", mesh.node_cloth);
  n.edge_start = to_device<Index>("drench::node_edge_start", mesh.node_edges.start);
  n.edge_item = to_device<Index>("drench::node_edge_item", mesh.node_edges.item);
  n.hinge_start = to_device<Index>("drench::node_hinge_start", mesh.node_hinges.start);
  n.hinge_item = to_device<Index>("drench::node_hinge_item", mesh.node_hinges.item);
  make_links(d);
  if (d.model.has_strain_limit()) {
    n.limit_start = to_device<Index>("drench::node_limit_start", mesh.node_triangles.start);
    n.limit_item = to_device<Index>("drench::node_limit_item", mesh.node_triangles.item);
  }
  if (d.model.has_moving_pins()) {
    n.pin_motion = to_device<Index>("drench::node_pin_motion", mesh.pin_motion);
    n.rest_position = to_device3("drench::node_rest_position", mesh.rest_position);
  }
  n.inverse_mass = Array<Real>("drench::node_inverse_mass", n.count);
  n.force = Array<Real3>("drench::node_force", n.count);
  n.acceleration = Array<Real3>("drench::node_acceleration", n.count);
  std::vector<double> capacity(mesh.rest_position.size(), 0.0);
  std::copy_n(samples.node_capacity.begin(), std::min(capacity.size(), samples.node_capacity.size()), capacity.begin());
  n.capacity = to_device<double>("drench::node_capacity", capacity);
  if (samples.count() == 0) return;
  std::vector<Quanta> full(capacity.size()), most(capacity.size());
  for (std::size_t k = 0; k < capacity.size(); ++k) {
    const ClothMaterial& cloth = d.model.cloths[static_cast<std::size_t>(mesh.node_cloth[k])];
    full[k] = static_cast<Quanta>(std::floor(capacity[k] / d.quantum));
    most[k] = static_cast<Quanta>(std::floor(cloth.max_saturation * capacity[k] / d.quantum));
  }
  n.capacity_quanta = to_device<Quanta>("drench::node_capacity_quanta", full);
  n.max_quanta = to_device<Quanta>("drench::node_max_quanta", most);
  n.weight_sum = to_device<double>("drench::node_weight_sum", samples.node_weight_sum);
  n.sample_start = to_device<Index>("drench::node_sample_start", samples.node_samples.start);
  n.sample_item = to_device<Index>("drench::node_sample_item", samples.node_samples.item);
  n.row_bound = Array<Real>("drench::node_row_bound", n.count);
}

void make_mesh(Device& d) {
  const ClothMesh& mesh = d.model.mesh;
  MeshArrays& m = d.mesh;
  m.triangles = mesh.triangles();
  m.edges = static_cast<Index>(mesh.edge.size());
  m.hinges = static_cast<Index>(mesh.hinge.size());
  m.triangle = to_device<Index>("drench::triangle", flat(mesh.triangle));
  if (!mesh.rim.empty()) m.rim = to_device<Index>("drench::rim", flat(mesh.rim));
  std::vector<double> metric;
  for (const auto& t : mesh.triangle) {
    double gram[3] = {0, 0, 0};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto at = [&](std::size_t corner) { return mesh.rest_position[static_cast<std::size_t>(t[corner])][a]; };
      const double u = at(1) - at(0), v = at(2) - at(0);
      gram[0] += u * u;
      gram[1] += u * v;
      gram[2] += v * v;
    }
    const double determinant = gram[0] * gram[2] - gram[1] * gram[1];
    metric.insert(metric.end(), {gram[2] / determinant, -gram[1] / determinant, gram[0] / determinant});
  }
  m.rest_metric = to_device<Real>("drench::rest_metric", metric);
  if (d.model.has_strain_limit()) {
    m.limit_shape = to_device<Real>("drench::limit_shape", flat(mesh.limit_shape));
    m.limit_stiffness = to_device<Real>("drench::limit_stiffness", mesh.limit_stiffness);
  }
  m.edge = to_device<Index>("drench::edge", flat(mesh.edge));
  m.edge_length = to_device<Real>("drench::edge_length", mesh.edge_length);
  m.edge_stiffness = to_device<Real>("drench::edge_stiffness", mesh.edge_stiffness);
  m.hinge = to_device<Index>("drench::hinge", flat(mesh.hinge));
  m.hinge_weight = to_device<Real>("drench::hinge_weight", flat(mesh.hinge_weight));
  m.hinge_stiffness = to_device<Real>("drench::hinge_stiffness", mesh.hinge_stiffness);
  double sum = 0;
  for (double l : mesh.edge_length) sum += l;
  m.mean_edge = mesh.edge_length.empty() ? Real(0) : Real(sum / static_cast<double>(mesh.edge_length.size()));
}

void make_samples(Device& d) {
  const SampleSet& set = d.model.samples;
  SampleArrays& s = d.samples;
  s.count = set.count();
  if (s.count == 0) return;
  std::vector<Index> nodes;
  for (Index t : set.triangle)
    for (Index n : d.model.mesh.triangle[static_cast<std::size_t>(t)]) nodes.push_back(n);
  s.node = to_device<Index>("drench::sample_node", nodes);
  s.triangle = to_device<Index>("drench::sample_triangle", set.triangle);
  s.weight = to_device<Real>("drench::sample_weight", flat(set.weight));
  s.weight_exact = to_device<double>("drench::sample_weight_exact", flat(set.weight));
  s.cloth = to_device<Index>("drench::sample_cloth", set.cloth);
  if (!set.rim.empty()) s.rim = to_device<Index>("drench::sample_rim", flat(set.rim));
  s.position = Array<Real3>("drench::sample_position", s.count);
  s.velocity = Array<Real3>("drench::sample_velocity", s.count);
  s.normal = Array<Real3>("drench::sample_normal", s.count);
  if (d.model.has_fluid()) {
    s.volume = Array<Real>("drench::sample_volume", s.count);
    s.force = Array<Real3>("drench::sample_force", s.count);
    s.place = Array<Real4>("drench::sample_place", s.count);
    s.back = Array<Real4>("drench::sample_back", s.count);
    s.predicted = Array<Real4>("drench::sample_predicted", s.count);
    s.row_load = Array<Real>("drench::sample_row_load", s.count);
    s.row_bound = Array<Real>("drench::sample_row_bound", s.count);
  }
  if (d.model.has_porous()) {
    s.area = to_device<Real>("drench::sample_area", set.area);
    s.capacity = to_device<Real>("drench::sample_capacity", set.capacity);
    s.rest_position = to_device3("drench::sample_rest_position", set.rest_position);
    s.flow_direction = Array<Real3>("drench::sample_flow_direction", s.count);
    s.saturation = Array<Real>("drench::sample_saturation", s.count);
  }
}

}  // namespace

Device::Device(const Model& m)
    : model(m),
      spacing(Real(m.spacing)),
      support(Real(m.support)),
      rest_density(Real(m.rest_density)),
      kernel(m.scene.fluid.kernel, Real(m.support)),
      quantum(m.quantum),
      gravity(to_real(m.scene.gravity)),
      viscous_strength(
          Real(viscosity_normalisation(m.scene.fluid.kernel) * m.scene.fluid.viscosity / (m.support * m.support))),
      field_center(to_real(m.scene.field.center)),
      field_square(to_real(squares(m.scene.field.rate))) {
  if (m.has_cloth()) {
    make_mesh(*this);
    make_nodes(*this);
    make_samples(*this);
    std::vector<Material> list;
    for (const ClothMaterial& c : m.cloths) {
      list.push_back(material_of(c));
      emission_ramp = std::max(emission_ramp, Real(c.porous ? c.emission_ramp : 0.0));
    }
    materials = to_device<Material>("drench::materials", list);
  }
  fluid.spins = m.has_micropolar();
  make_solids(*this);
  boundary.count = m.boundary.count();
  if (boundary.count > 0) {
    boundary.rest_position = to_device3("drench::boundary_rest_position", m.boundary.position);
    boundary.body = to_device<Index>("drench::boundary_body", m.boundary.body);
  }
  for (CellTable* t : {&fluid_cells, &boundary_cells, &sample_cells, &self_collision_work.node_cells,
                       &self_collision_work.edge_cells, &wet_adhesion_work.cells, &measures_work.cells})
    *t = CellTable(m.scene.sort);
  for (const Jet& j : m.jets) jet_offsets.push_back(to_device3("drench::jet_offsets", j.offsets));
}

}  // namespace drench::kokkos_backend
