// The cloths on the device: what stays the same of them, and the exchange of their state.

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "cloth/cloth.hpp"
#include "cloth/pins.hpp"
#include "core/host_copy.hpp"
#include "stages/substeps.hpp"
#include "state/film.hpp"

namespace drench::kokkos_backend {
namespace {

Material material_of(const ClothMaterial& c) {
  Material m{material_in<Real>(c)};
  const double most = double(Real(c.pore_saturation()));
  const RetentionShape shape(c);
  const MobilityBound bound = mobility_bound(c.diffusion_exponent, most, shape);
  m.mobility_exponent = c.diffusion_exponent;
  m.retention = c.retention_exponent;
  m.most_mobility = bound.difference;
  m.height_mobility = bound.height;
  m.steepest_suction = shape.steepest(c.diffusion_exponent, most);
  m.by_suction = c.flows_by_suction();
  m.suction = {
      {shape.beta, shape.large, shape.narrowing}, {shape.drainage_beta, shape.large, shape.narrowing}, shape.ratio};
  m.contact_wicking = c.wicks_through_contact();
  return m;
}

/// Springs, hinges and plates as one sparse row a node: a third of the loads of going edge by edge and hinge by hinge.
void make_links(const ClothMesh& mesh, bool expands, Nodes& nodes, Mesh& of_mesh) {
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
  for (std::size_t k = 0; k < mesh.stitch.size(); ++k)
    for (std::size_t end = 0; end < 2; ++end) {
      Link& l = link(mesh.stitch[k][end], mesh.stitch[k][1 - end]);
      l.length = Real(mesh.stitch_length[k]);
      l.stiffness = Real(mesh.stitch_stiffness[k]);
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
  std::vector<double> plate(mesh.plate_pair.empty() ? 0 : rows.size(), 0.0);
  for (std::size_t k = 0; k < mesh.plate_pair.size(); ++k)
    for (std::size_t end = 0; end < 2; ++end) {
      const Index n = mesh.plate_pair[k][end];
      link(n, mesh.plate_pair[k][1 - end]).bend = Real(mesh.plate_weight[k]);
      plate[static_cast<std::size_t>(n)] += std::max(0.0, -mesh.plate_weight[k]);  // ½ (|B_nn| + Σ_m |B_nm|)
    }
  if (!plate.empty()) nodes.plate_diagonal = to_device<Real>("drench::node_plate_diagonal", plate);
  std::vector<Index> start{0};
  std::vector<Link> links;
  for (const auto& row : rows) {
    for (const auto& entry : row) links.push_back(entry.second);
    start.push_back(static_cast<Index>(links.size()));
  }
  nodes.link_start = to_device<Index>("drench::node_link_start", start);
  nodes.link = to_device<Link>("drench::node_link", links);
  if (expands) {
    std::vector<Real> dry;
    for (const Link& l : links) dry.push_back(l.stiffness > 0 ? l.length : Real(0));
    of_mesh.dry_link_length = to_device<Real>("drench::dry_link_length", dry);
  }
  if (mesh.stitch.empty()) return;
  std::vector<Index> of_stitch;
  for (const auto& stitch : mesh.stitch)
    for (std::size_t end = 0; end < 2; ++end) {
      const auto& row = rows[static_cast<std::size_t>(stitch[end])];
      of_stitch.push_back(start[static_cast<std::size_t>(stitch[end])] +
                          static_cast<Index>(std::distance(row.begin(), row.find(stitch[1 - end]))));
    }
  of_mesh.stitch_link = to_device<Index>("drench::stitch_link", of_stitch);
}

template <class T>
std::vector<T> joined(std::vector<T> first, const std::vector<T>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// The capacities as whole quanta, at s = 1 and at s_max.
void make_capacities(const Model& m, const std::vector<double>& capacity, Nodes& n) {
  std::vector<Quanta> full(capacity.size()), most(capacity.size());
  for (std::size_t k = 0; k < capacity.size(); ++k) {
    full[k] = static_cast<Quanta>(std::floor(capacity[k] / m.quantum));
    most[k] = static_cast<Quanta>(std::floor(ceiling_of_node(m, static_cast<Index>(k)) * capacity[k] / m.quantum));
  }
  n.capacity_quanta = to_device<Quanta>("drench::node_capacity_quanta", full);
  n.max_quanta = to_device<Quanta>("drench::node_max_quanta", most);
  if (!m.has_squeezing()) return;
  std::vector<double> ceiling(capacity.size());
  for (std::size_t k = 0; k < capacity.size(); ++k) ceiling[k] = ceiling_of_node(m, static_cast<Index>(k));
  n.pores = to_device<double>("drench::node_pores", capacity);
  n.ceiling = to_device<double>("drench::node_ceiling", ceiling);
}

void make_nodes(const Model& m, Nodes& n, Mesh& of_mesh) {
  const ClothMesh& mesh = m.mesh;
  const SampleSet& samples = m.samples;
  n.count = mesh.nodes();
  n.solid_mass = to_device<Real>("drench::node_solid_mass", mesh.solid_mass);
  n.pinned = to_device<std::uint8_t>("drench::node_pinned", mesh.pinned);
  std::vector<std::uint8_t> fixed;
  for (Index k = 0; k < mesh.nodes(); ++k) fixed.push_back(mesh.is_fixed(k));
  n.fixed = to_device<std::uint8_t>("drench::node_fixed", fixed);
  n.cloth = to_device<Index>("drench::node_cloth", mesh.node_cloth);
  if (m.has_regions()) n.material = to_device<Index>("drench::node_material", mesh.node_material);
  n.edge_start = to_device<Index>("drench::node_edge_start", mesh.node_edges.start);
  n.edge_item = to_device<Index>("drench::node_edge_item", mesh.node_edges.item);
  n.hinge_start = to_device<Index>("drench::node_hinge_start", mesh.node_hinges.start);
  n.hinge_item = to_device<Index>("drench::node_hinge_item", mesh.node_hinges.item);
  make_links(mesh, m.expands_when_wet(), n, of_mesh);
  if (m.has_stitches()) n.joint = to_device<Index>("drench::node_joint", mesh.joint);
  if (m.has_triangle_stress()) {
    n.triangle_start = to_device<Index>("drench::node_triangle_start", mesh.node_triangles.start);
    n.triangle_item = to_device<Index>("drench::node_triangle_item", mesh.node_triangles.item);
  }
  find_moving_pins(m, n);
  allocate_zeros(n.inverse_mass, "drench::node_inverse_mass", static_cast<std::size_t>(n.count));
  allocate_zeros(n.force, "drench::node_force", static_cast<std::size_t>(n.count));
  allocate_zeros(n.predicted, "drench::node_predicted", static_cast<std::size_t>(n.count));
  std::vector<double> capacity(mesh.rest_position.size(), 0.0);
  std::copy_n(samples.node_capacity.begin(), std::min(capacity.size(), samples.node_capacity.size()), capacity.begin());
  n.capacity = to_device<double>("drench::node_capacity", capacity);
  if (samples.count() == 0) return;
  make_capacities(m, capacity, n);
  n.weight_sum = to_device<double>("drench::node_weight_sum", samples.node_weight_sum);
  n.sample_start = to_device<Index>("drench::node_sample_start", samples.node_samples.start);
  n.sample_item = to_device<Index>("drench::node_sample_item", samples.node_samples.item);
  allocate_zeros(n.row_bound, "drench::node_row_bound", static_cast<std::size_t>(n.count));
}

/// With the mesh's parts that each node lists.
double node_bytes(const Sizing& m) {
  const double r = m.real;
  double node = 0;
#define DRENCH_BYTES(owner, name, host_type, unit, needed) \
  if (needed) node += m.entry<host_type>();
  DRENCH_NODE_FIELDS(DRENCH_BYTES)
#undef DRENCH_BYTES
  node += r + 2 + index_bytes + double_bytes;  // solid_mass, pinned, fixed, cloth, capacity
  node += 3 * index_bytes + 7 * r;             // edge_start, hinge_start, link_start; inverse_mass, force, predicted
  // capacity_quanta, max_quanta, weight_sum, sample_start, row_bound
  if (m.size.samples > 0) node += 2 * quanta_bytes + double_bytes + index_bytes + r;
  if (m.size.squeezing) node += 2 * double_bytes;  // pores, ceiling
  if (m.size.patches > 0) node += index_bytes;     // material
  if (m.size.stitches > 0) node += index_bytes;    // joint
  double bytes = m.size.nodes * node + m.size.links * 4 * r + m.size.patches * sizeof(Material);
  bytes +=
      (m.size.edges + m.size.stitches) * 2 * index_bytes + m.size.hinges * 4 * index_bytes;  // edge_item, hinge_item
  if (m.size.strain_limit || m.size.membrane) bytes += m.size.triangles * 3 * index_bytes;   // triangle_item
  if (!m.size.scene.bodies.empty()) bytes += m.size.nodes * r;                               // clearance
  if (m.size.plate) bytes += m.size.nodes * r;                                               // plate_diagonal
  return bytes + m.size.samples * 3 * index_bytes;                                           // sample_item
}

/// Of each triangle the inverse of its edges' Gram matrix at rest (xx, xy, yy), 1/m².
std::vector<double> rest_metrics(const ClothMesh& mesh) {
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
  return metric;
}

void make_mesh(const Model& model, Mesh& m) {
  const ClothMesh& mesh = model.mesh;
  m.triangles = mesh.triangles();
  m.edges = static_cast<Index>(mesh.edge.size() + mesh.stitch.size());
  m.stitches = static_cast<Index>(mesh.stitch.size());
  m.hinges = static_cast<Index>(mesh.hinge.size());
  m.triangle = to_device<Index>("drench::triangle", flat(mesh.triangle));
  if (!mesh.boundary_edge.empty())
    m.boundary_edge = to_device<Index>("drench::boundary_edge", flat(mesh.boundary_edge));
  m.rest_metric = to_device<Real>("drench::rest_metric", rest_metrics(mesh));
  if (model.has_triangle_stress())
    m.triangle_shape = to_device<Real>("drench::triangle_shape", flat(mesh.triangle_shape));
  if (model.has_strain_limit()) m.limit_stiffness = to_device<Real>("drench::limit_stiffness", mesh.limit_stiffness);
  if (model.has_membrane()) {
    std::vector<Membrane<Real>> membrane;
    for (const Membrane<double>& t : mesh.membrane)
      membrane.push_back({Real(t.cosine), Real(t.sine), Real(t.warp), Real(t.weft), Real(t.shear), Real(t.wet),
                          Real(t.warp_locking), Real(t.weft_locking)});
    m.membrane = to_device<Membrane<Real>>("drench::membrane", membrane);
  }
  m.edge = to_device<Index>("drench::edge", flat(joined(mesh.edge, mesh.stitch)));
  m.edge_length = to_device<Real>("drench::edge_length", joined(mesh.edge_length, mesh.stitch_length));
  m.edge_stiffness = to_device<Real>("drench::edge_stiffness", joined(mesh.edge_stiffness, mesh.stitch_stiffness));
  if (model.expands_when_wet()) {
    m.dry_length = to_device<Real>("drench::dry_length", mesh.edge_length);
    if (model.has_triangle_stress()) m.dry_shape = to_device<Real>("drench::dry_shape", flat(mesh.triangle_shape));
  }
  if (m.stitches > 0) {
    m.stitch_length = to_device<double>("drench::stitch_length", mesh.stitch_length);
    m.stitch_end = to_device<double>("drench::stitch_end", mesh.stitch_time);
  }
  m.hinge = to_device<Index>("drench::hinge", flat(mesh.hinge));
  m.hinge_weight = to_device<Real>("drench::hinge_weight", flat(mesh.hinge_weight));
  m.hinge_stiffness = to_device<Real>("drench::hinge_stiffness", mesh.hinge_stiffness);
  double sum = 0;
  for (double l : mesh.edge_length) sum += l;
  m.mean_edge = mesh.edge_length.empty() ? Real(0) : Real(sum / static_cast<double>(mesh.edge_length.size()));
}

double mesh_bytes(const Sizing& s) {
  const double r = s.real, shape = s.size.strain_limit || s.size.membrane ? 3 * r : 0;
  const double limit = shape + (s.size.strain_limit ? r : 0) + (s.size.membrane ? 8 * r : 0);
  const double edges = s.size.edges + s.size.stitches;
  const double dry = s.size.expands ? r * (s.size.edges + s.size.links) + shape * s.size.triangles : 0;
  return dry + s.size.triangles * (3 * index_bytes + 3 * r + limit) + edges * (2 * index_bytes + 2 * r) +
         s.size.stitches * 2 * (double_bytes + index_bytes) + s.size.hinges * (4 * index_bytes + 5 * r);
}

void make_samples(const Model& m, Samples& s) {
  const SampleSet& set = m.samples;
  s.count = set.count();
  if (s.count == 0) return;
  const auto samples = static_cast<std::size_t>(s.count);
  std::vector<Index> nodes;
  for (Index t : set.triangle)
    for (Index n : m.mesh.triangle[static_cast<std::size_t>(t)]) nodes.push_back(n);
  s.node = to_device<Index>("drench::sample_node", nodes);
  s.triangle = to_device<Index>("drench::sample_triangle", set.triangle);
  s.weight = to_device<Real>("drench::sample_weight", flat(set.weight));
  s.weight_exact = to_device<double>("drench::sample_weight_exact", flat(set.weight));
  s.cloth = to_device<Index>("drench::sample_cloth", set.cloth);
  if (m.has_regions()) s.material = to_device<Index>("drench::sample_material", set.material);
  if (!set.boundary_edges.empty())
    s.boundary_edge = to_device<Index>("drench::sample_boundary_edge", flat(set.boundary_edges));
  allocate_zeros(s.position, "drench::sample_position", samples);
  allocate_zeros(s.velocity, "drench::sample_velocity", samples);
  allocate_zeros(s.normal, "drench::sample_normal", samples);
  if (m.has_fluid()) {
    allocate_zeros(s.volume, "drench::sample_volume", samples);
    allocate_zeros(s.force, "drench::sample_force", samples);
    allocate_zeros(s.position_volume, "drench::sample_position_volume", samples);
    allocate_zeros(s.normal_offset, "drench::sample_normal_offset", samples);
    allocate_zeros(s.row_load, "drench::sample_row_load", samples);
    allocate_zeros(s.row_bound, "drench::sample_row_bound", samples);
  }
  if (m.has_porous()) {
    s.area = to_device<Real>("drench::sample_area", set.area);
    s.capacity = to_device<Real>("drench::sample_capacity", set.capacity);
    s.rest_position = to_device3("drench::sample_rest_position", set.rest_position);
    allocate_zeros(s.flow_direction, "drench::sample_flow_direction", samples);
  }
  if (m.has_permeation()) {
    allocate_zeros(s.flux, "drench::sample_flux", samples);
    allocate_zeros(s.passing, "drench::sample_passing", samples);
  }
  if (!m.counts_faces()) return;
  allocate_zeros(s.taken_front, "drench::sample_taken_front", samples);
  allocate_zeros(s.taken_back, "drench::sample_taken_back", samples);
  allocate_zeros(s.given_front, "drench::sample_given_front", samples);
  allocate_zeros(s.given_back, "drench::sample_given_back", samples);
}

double sample_bytes(const Sizing& m) {
  const double r = m.real;
  double sample = 5 * index_bytes + 3 * r + 3 * double_bytes;  // node, triangle, cloth; weight, weight_exact
  sample += 9 * r;                                             // position, velocity, normal
#define DRENCH_BYTES(owner, name, host_type, unit, needed) \
  if (needed) sample += m.entry<host_type>();
  DRENCH_SAMPLE_FIELDS(DRENCH_BYTES)
#undef DRENCH_BYTES
  // force, position_volume, normal_offset, row_load, row_bound; boundary_edge
  if (m.size.liquid) sample += 13 * r + 2 * index_bytes;
  if (m.size.porous) sample += 5 * r;             // area, capacity, rest_position
  if (m.size.patches > 0) sample += index_bytes;  // material
  return m.size.samples * sample;
}

}  // namespace

MemoryEstimate cloth_bytes(const Sizing& s) {
  MemoryEstimate sum;
  sum.cloth = node_bytes(s) + mesh_bytes(s) + sample_bytes(s);
  if (s.size.searches_samples) sum.cells = cell_table_bytes(s.size.samples, s.size.sample_cells, s);
  return sum;
}

Cloth::Cloth(const Constants& constants) : sample_cells(constants.model.scene.sort) {
  const Model& m = constants.model;
  if (!m.has_cloth()) return;
  make_mesh(m, mesh);
  make_nodes(m, nodes, mesh);
  make_samples(m, samples);
  std::vector<Material> list;
  m.for_materials([&](const ClothMaterial& c) {
    list.push_back(material_of(c));
    emission_ramp = std::max(emission_ramp, Real(c.porous ? c.emission_ramp : 0.0));
  });
  materials = to_device<Material>("drench::materials", list);
}

void Cloth::upload([[maybe_unused]] const Model& m, const HostState& s) {
  moved.advance();
  soaked.advance();
  if (nodes.count > 0) {
#define DRENCH_UPLOAD(owner, name, host_type, unit, needed)                                      \
  if (needed) {                                                                                  \
    auto values = s.owner##_##name;                                                              \
    values.resize(static_cast<std::size_t>(nodes.count)); /* a state made by hand may lack it */ \
    nodes.name = to_device<OnDevice<host_type>::type>("drench::" #owner "_" #name, values);      \
  }
    DRENCH_NODE_FIELDS(DRENCH_UPLOAD)
#undef DRENCH_UPLOAD
  }
#define DRENCH_UPLOAD(owner, name, host_type, unit, needed) \
  if (samples.name.exists()) copy_to_device(samples.name, s.owner##_##name);
  DRENCH_SAMPLE_FIELDS(DRENCH_UPLOAD)
#undef DRENCH_UPLOAD
}

void Cloth::download([[maybe_unused]] const Model& m, HostState& s) const {
#define DRENCH_DOWNLOAD(owner, name, host_type, unit, needed) \
  if (needed) s.owner##_##name = to_host<host_type>(nodes.name, nodes.count);
  DRENCH_NODE_FIELDS(DRENCH_DOWNLOAD)
#undef DRENCH_DOWNLOAD
#define DRENCH_DOWNLOAD(owner, name, host_type, unit, needed) \
  s.owner##_##name = to_host<host_type>(samples.name, samples.count);
  DRENCH_SAMPLE_FIELDS(DRENCH_DOWNLOAD)
#undef DRENCH_DOWNLOAD
  if (!samples.flux.exists()) s.sample_flux.clear();  // the others are 0 where they are not needed
  if (samples.taken_front.exists()) return;
  for (auto* account : {&s.sample_taken_front, &s.sample_taken_back, &s.sample_given_front, &s.sample_given_back})
    account->clear();
}

}  // namespace drench::kokkos_backend
