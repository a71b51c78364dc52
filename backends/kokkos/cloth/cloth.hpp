#pragma once
// The cloths: nodes, meshes, materials and samples. Arrays of a part that the scene lacks stay empty.

#include <array>

#include "bodies/bodies.hpp"
#include "cloth/retention_law.hpp"
#include "core/cell_table.hpp"
#include "core/constants.hpp"
#include "pipeline/backend.hpp"

namespace drench::kokkos_backend {

/// A cloth's material as plain numbers, indexable on the device.
struct Material : ResolvedMaterial<Real> {
  double mobility_exponent = 0, retention = 1;    // n and β of the law of diffusion, unrounded
  double most_mobility = 1, height_mobility = 1;  // ψ_max, μ of its rate (stages/substeps.hpp)
  double steepest_suction = 1;                    // what h/ℓ falls by with the saturation at most, history included
  bool by_suction = false;                        // it flows by `suction`
  laws::Retention suction{};                      // with hysteresis or large pores
};

/// What a node shares with another one: the spring of an edge (stiffness 0: none) and B_nm = Σ_h c_h K_n K_m of their
/// hinges, or of a plate. One load of 16 bytes in float.
struct alignas(4 * sizeof(Real)) Link {
  Index other;
  Real length, stiffness, bend;  // m, N/m, N/m
};

struct Nodes {
  Index count = 0;
  // the state (src/state/fields.hpp)
#define DRENCH_FIELD(owner, name, host_type, unit, needed) Field<OnDevice<host_type>::type> name;
  DRENCH_NODE_FIELDS(DRENCH_FIELD)
#undef DRENCH_FIELD
  // constant
  Field<Real> solid_mass;             // kg
  Field<std::uint8_t> pinned, fixed;  // fixed: ClothMesh::is_fixed
  Field<Index> cloth;
  Field<Index> material;                   // of Cloth::materials; empty: as `cloth`
  Field<double> capacity;                  // C_n, kg
  Field<double> pores;                     // what C_n is under pressure, kg (stage squeezing); empty without
  Field<double> ceiling;                   // s_max, 1; empty without stage squeezing
  Field<Quanta> capacity_quanta;           // floor(C_n/q), of the pores under pressure
  Field<Quanta> max_quanta;                // floor(s_max C_n/q), the same
  Field<double> weight_sum;                // w′_n
  Field<Index> sample_start, sample_item;  // node → items 4·sample + corner
  Field<Index> edge_start, edge_item, hinge_start, hinge_item;
  Field<Real> plate_diagonal;  // half the absolute row sums of plates, N/m; empty without them
  Field<Index> link_start;     // node → links
  Field<Link> link;
  Field<Index> triangle_start, triangle_item;  // node → 4·triangle + corner; empty without limits and membranes
  Field<Index> joint;                          // the lowest node that it is sewn to; empty without stitches
  Field<Index> pin_motion;                     // −1: none; empty unless pins move
  Field<Real3> rest_position;                  // m; empty unless pins move
  Field<Real> pin_stiffness;                   // N/m; empty without soft pins
  static constexpr std::array<double, 2> not_placed{-1, 0};
  std::array<double, 2> pins_placed = not_placed;  // time and length (s) of the step that Cloth::pin_steps is of
  // derived
  Field<Real> inverse_mass;  // u_n, 1/kg; 0 if fixed (refresh_inverse_mass)
  Field<Real3> force;        // f_n, N: what the stage that runs does to the node
  Field<Real> film_pull;   // (g·n)² of a film, m²/s⁴, at_hem at hems (stage porous_neighbors); empty without films
  Field<Real> clearance;   // m: the least one from solids (stage cloth); empty without solids
  Field<Real3> predicted;  // v_n + Δt a_n, m/s, in the pressure solves
  Field<Real> row_bound;   // u_n Σ_b w_bn c_b (node_bounds_from_samples)
};

struct Mesh {
  Field<Index> triangle;       // 3 per triangle
  Field<Index> boundary_edge;  // 3 per edge of the boundary loops: its nodes and its triangle's third; empty: none
  Field<Index> edge;           // 2 per edge; the last ones are the stitches
  Field<Real> edge_length, edge_stiffness;  // lengths: as wet as the fabric is
  // lengths, links' lengths and shapes of dry fabric; empty unless it expands when it is wet (expand_wet_cloth)
  Field<Real> dry_length, dry_link_length, dry_shape;
  Field<double> stitch_length, stitch_end;  // m, at t = 0; s: when the rest length is 0 (shorten_stitches)
  Field<Index> stitch_link;                 // 2 per stitch: its links
  Field<Index> hinge;                       // 4 per hinge
  Field<Real> hinge_weight;                 // 4 per hinge
  Field<Real> hinge_stiffness;
  Field<Real> rest_metric;         // 3 per triangle: inverse of its edges' Gram matrix at rest (xx, xy, yy), 1/m²
  Field<Real> triangle_shape;      // 3 per triangle; empty without limits and membranes
  Field<Real> limit_stiffness;     // per triangle; empty without strain limiting
  Field<Membrane<Real>> membrane;  // per triangle; empty without membranes
  Index triangles = 0, edges = 0, stitches = 0, hinges = 0;
  Real mean_edge = 0;  // m
};

/// Samples of the cloths: boundary particles for the liquid, porous particles of porous cloths.
struct Samples {
  Index count = 0;
  // the state (src/state/fields.hpp)
#define DRENCH_FIELD(owner, name, host_type, unit, needed) Field<OnDevice<host_type>::type> name;
  DRENCH_SAMPLE_FIELDS(DRENCH_FIELD)
#undef DRENCH_FIELD
  // constant
  Field<Index> node;  // 3 per sample: the triangle's nodes
  Field<Index> triangle;
  Field<Real> weight;          // 3 per sample
  Field<double> weight_exact;  // the same in double, for splitting quanta
  Field<Index> cloth;
  Field<Index> material;       // of Cloth::materials; empty: as `cloth`
  Field<Index> boundary_edge;  // 2 per sample: edges of the boundary loop near it; empty: none
  Field<Real> area, capacity;  // m², kg
  Field<Real3> rest_position;
  // from the nodes (refresh_samples)
  Field<Real3> position, velocity;
  Field<Real3> normal;  // unit normal of the triangle, 0 if it has no area
  // of the liquid's stages
  Field<Real3> force;               // F_b, N
  Field<Real4> position_volume;     // x_b, m, and V_b, m³ (stage density)
  Field<Real4> normal_offset;       // ½ d n_b, m (stage density)
  Field<Real> row_load, row_bound;  // g_b, c_b of the Jacobi diagonal (stage density)
  Field<Real> passing;              // m/s: what of the flux passes in this step (stage permeation)
};

/// One motion of pins in a step: a node moves from x⁰ by move + change (X0 − C), to offset + rotation (X0 − C).
struct PinStep {
  Real3 center, offset, move;    // m
  Real3 rotation[3], change[3];  // rows; 1
  Real holds = 1;                // 0: its springs have let go
};

/// Bounds of the samples on the host, which has to wait for them.
struct SampleBounds {
  HostBounds box;
};

struct Cloth {
  explicit Cloth(const Constants& constants);

  void upload(const Model& model, const HostState& s);
  void download(const Model& model, HostState& s) const;

  Nodes nodes;
  Mesh mesh;
  Samples samples;
  Field<Material> materials;          // of the cloths, then of their regions (Model::material)
  Field<PinStep> pin_steps;           // empty unless pins move (place_pins)
  Real emission_ramp = 0;             // s, the largest of the cloths
  Version moved;                      // of the nodes' positions
  Version soaked;                     // of the liquid in them
  Version weighed = Version::none();  // that nodes.inverse_mass is of
  Version cleared = Version::none();  // of nodes and bodies that nodes.clearance is of, ...
  Real cleared_for = 0;               // ... and in a step of this length, s
  Cached<SampleBounds> sample_bounds;
  Cached<CellTable> sample_cells;            // their edge is h
  Version samples_placed = Version::none();  // that samples.position and .normal are of
};

MemoryEstimate cloth_bytes(const Sizing& s);

/// The material of each node or of each sample, as a kernel sees it.
struct Materials {
  Entries<const Index> cloth;  // or region
  Entries<const Material> of_cloth;
  KOKKOS_INLINE_FUNCTION const Material& operator()(Index i) const { return of_cloth(cloth(i)); }
};
/// Numbers of the materials of nodes, or of samples.
template <class NodesOrSamples>
const Field<Index>& material_numbers(const NodesOrSamples& of) {
  return of.material.exists() ? of.material : of.cloth;
}
inline Materials node_materials(const Cloth& cloth) { return {material_numbers(cloth.nodes), cloth.materials}; }
inline Materials sample_materials(const Cloth& cloth) { return {material_numbers(cloth.samples), cloth.materials}; }

/// The node that stands for all that node n is sewn to; `joint`: Nodes::joint.
KOKKOS_INLINE_FUNCTION Index joint_of(const Entries<const Index>& joint, Index n) {
  return joint.exist() ? joint(n) : n;
}

// samples.cpp: derived quantities that several stages share
void refresh_samples(Cloth& cloth);             // samples.position, .normal and .velocity from the nodes
void place_samples(Cloth& cloth);               // the same, if the nodes have moved since
void refresh_samples_and_bounds(Cloth& cloth);  // refresh_samples, and the bounds' box: to be waited for
/// cloth.sample_cells, if the nodes have moved since.
void refresh_sample_cells(const Constants& constants, Cloth& cloth);
void refresh_inverse_mass(const Constants& constants,
                          Cloth& cloth);      // nodes.inverse_mass, if their liquid has changed since
void node_forces_from_samples(Cloth& cloth);  // nodes.force = Σ w F_b from samples.force
/// nodes.row_bound = u_n Σ_b w_bn c_b from a number c_b of each sample.
void node_bounds_from_samples(const char* label, Cloth& cloth, const Entries<const Real>& of_sample);
/// v_n += Δt u_n f_n, and pin_force −= f_n on fixed nodes.
void apply_node_forces(Cloth& cloth, Real dt);

}  // namespace drench::kokkos_backend
