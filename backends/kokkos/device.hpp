#pragma once
// The backend's state on the device. Arrays of a part that the scene lacks stay empty (nothing is allocated).

#include <cstdint>
#include <memory>
#include <vector>

#include "laws/collision.hpp"
#include "laws/kernel.hpp"
#include "laws/rigid.hpp"
#include "pipeline/backend.hpp"
#include "porous_work.hpp"
#include "primitives/cell_table.hpp"
#include "self_collision.hpp"
#include "types.hpp"

namespace drench::kokkos_backend {

/// Neighbours of each row, one row behind the other with room for what each has, so that memory does not depend on the longest.
/// On a GPU 32 rows are a bundle that lies together, entry by entry, as wide as the longest of them: what the threads of a
/// warp read at once are neighbours in memory. Bundles lie in the order in which they were found, which nothing depends on.
struct NeighborList {
  Array<Index> count;
  Array<std::int64_t> start;  // where a bundle's entries begin
  Array<Index> entry;
  // Beside `entry`, kept by stage density for the step: V_j (dW/dr)/r, 1/m², between particles; V_b ∇W of a particle, 1/m,
  // with a cloth's sample as the pressure sees it (laws/wall.hpp).
  Array<Real> slope;
  Array<Real3> gradient;
  Index rows = 0;
  // While it is filled: entries that are given out, by this filling and by the next one; how many were asked for, if too many.
  Kokkos::View<std::int64_t[2], MemSpace> used;
  Kokkos::View<std::int64_t, Kokkos::SharedHostPinnedSpace> needed;
  int filling = 0;
};

/// One row as kernels see it. `place(k)` says where entry k is in arrays beside the entries.
struct NeighborRow {
#ifdef KOKKOS_ENABLE_CUDA
  static constexpr Index bundle = 32;  // the threads of a warp
#else
  static constexpr Index bundle = 1;
#endif

  Index* item;
  Real* slope_of;  // null without slopes
  std::int64_t first;
  Index count;

  KOKKOS_INLINE_FUNCTION std::int64_t place(Index k) const { return first + std::int64_t{k} * bundle; }
  KOKKOS_INLINE_FUNCTION Index& operator()(Index k) const { return item[place(k)]; }
  KOKKOS_INLINE_FUNCTION Real& slope(Index k) const { return slope_of[place(k)]; }
};

/// A list as kernels see it.
struct Neighbors {
  Entries<Index> count;
  Entries<std::int64_t> start;
  Index* item;
  Real* slope_of;

  Neighbors(const NeighborList& l) : count(l.count), start(l.start), item(l.entry.data()), slope_of(l.slope.data()) {}
  KOKKOS_INLINE_FUNCTION NeighborRow row(Index i) const {
    return {item, slope_of, start(i / NeighborRow::bundle) + i % NeighborRow::bundle, count(i)};
  }
};

/// Liquid particles; arrays are at least `count` long (capacity grows between steps). In the order of their cells from
/// stage neighbors on, with later ones behind; HostState has them by id.
struct FluidArrays {
  Index count = 0;
  Array<Real3> position, velocity;
  Array<Quanta> mass;
  Array<std::int64_t> id;
  Array<Real> age;
  Array<std::uint8_t> origin;
  Array<Real> density_ratio, kappa_density, kappa_divergence;
  bool spins = false;  // with stage micropolar
  Array<Real3> spin;   // ω, 1/s
};

/// Calls visit(array) for each of them.
template <class Arrays, class Visitor>
void visit_arrays(Arrays& fluid, Visitor&& visit) {
  visit(fluid.position);
  visit(fluid.velocity);
  visit(fluid.mass);
  visit(fluid.id);
  visit(fluid.age);
  visit(fluid.origin);
  visit(fluid.density_ratio);
  visit(fluid.kappa_density);
  visit(fluid.kappa_divergence);
  if (fluid.spins) visit(fluid.spin);
}

/// Liquid that touches a sheet (src/stages/pressure.hpp): made by stage density where there are sheets.
struct SheetContact {
  Array<Real> alpha;             // α'_i, m²; 0: does not touch (stage density)
  Array<Real> compliance;        // C'_i, 1/m² (stage density)
  Array<Real> push, next, last;  // λ_i and the iterates beside it, m²/s² (in-stage)
  Array<Real> rate;              // R'_i, 1/s (in-stage)
};

/// Stage-to-stage and in-stage arrays of the liquid; refreshed by stage density unless said otherwise.
struct FluidWork {
  Array<Real> volume;                  // V_i, m³ (stage density)
  Array<Real> alpha;                   // m² (stage density)
  Array<Real> compliance;              // C_i, 1/m² (stage density)
  Array<Real3> shift;                  // m, apart from particles too close (stage density)
  Array<Real4> place;                  // x_i, m, since stage density, and V_i or κ_i, as the stage's pairs need
  Array<Real4> flight;                 // v_i, m/s, and 1/√δ_i (stage forces)
  Array<Real4> predicted;              // v_i + Δt a_i, m/s, and the thrust on sheets (pressure_system.hpp); in-stage
  Array<Real> rate;                    // R_i, 1/s; stage forces: C_i, 1/s (in-stage)
  Array<Real> kappa_next, kappa_last;  // the solves' iterates beside κ, m²/s² (in-stage)
  Array<Index> nearest_sample;         // −1: none within h; made on first use (stage neighbors)
  SheetContact contact;
  Array<std::uint8_t> active;  // takes part in the divergence solve (in-stage)
};

struct BoundaryArrays {
  Index count = 0;
  Array<Real3> position, velocity, rest_position;
  Array<Real> volume;
  Array<Index> body;
};

/// What a node shares with another one: the spring of an edge (stiffness 0: none) and B_nm = Σ_h c_h K_n K_m of their
/// hinges. One load of 16 bytes in float.
struct alignas(4 * sizeof(Real)) Link {
  Index other;
  Real length, stiffness, bend;  // m, N/m, N/m
};

struct NodeArrays {
  Index count = 0;
  Array<Real3> position, velocity, contact_force, friction_force, pin_force;
  Array<Quanta> liquid, ripe;
  // constant
  Array<Real> solid_mass;  // kg
  Array<std::uint8_t> pinned;
  Array<Index> cloth;
  Array<double> capacity;                  // C_n, kg
  Array<Quanta> capacity_quanta;           // floor(C_n/q)
  Array<Quanta> max_quanta;                // floor(s_max C_n/q)
  Array<double> weight_sum;                // w′_n
  Array<Index> sample_start, sample_item;  // node → items 4·sample + corner
  Array<Index> edge_start, edge_item, hinge_start, hinge_item;
  Array<Index> link_start;  // node → links
  Array<Link> link;
  Array<Index> limit_start, limit_item;  // node → 4·triangle + corner; empty without strain limiting
  Array<Index> pin_motion;               // −1: none; empty unless pins move
  Array<Real3> rest_position;            // m; empty unless pins move
  // work
  Array<Real> inverse_mass;  // u_n, 1/kg; 0 if pinned (refresh_inverse_mass)
  Array<Real3> force;        // f_n, N (node_forces_from_samples)
  Array<Real3> acceleration;
  Array<Real> row_bound;  // u_n G_n of the Jacobi diagonal (stage density); u_n Σ_b w_bn K_b (stage forces)
};

struct MeshArrays {
  Array<Index> triangle;  // 3 per triangle
  Array<Index> rim;       // 3 per edge of the rim; empty: none
  Array<Index> edge;      // 2 per edge
  Array<Real> edge_length, edge_stiffness;
  Array<Index> hinge;        // 4 per hinge
  Array<Real> hinge_weight;  // 4 per hinge
  Array<Real> hinge_stiffness;
  Array<Real> rest_metric;  // 3 per triangle: inverse of its edges' Gram matrix at rest (xx, xy, yy), 1/m²
  Array<Real> limit_shape, limit_stiffness;  // 3 and 1 per triangle; empty without strain limiting
  Index triangles = 0, edges = 0, hinges = 0;
  Real mean_edge = 0;  // m
};

struct SampleArrays {
  Index count = 0;
  Array<Index> node;  // 3 per sample: the triangle's nodes
  Array<Index> triangle;
  Array<Real> weight;          // 3 per sample
  Array<double> weight_exact;  // the same in double, for splitting quanta
  Array<Index> cloth;
  Array<Index> rim;            // 2 per sample: edges of the rim near it; empty: none
  Array<Real> area, capacity;  // m², kg
  Array<Real3> rest_position;
  Array<Real3> flow_direction;
  Array<Real> volume;  // Akinci V_b, m³
  // work
  Array<Real3> position, velocity;  // refresh_samples
  Array<Real3> normal;              // unit normal of the triangle, 0 if it has no area (refresh_samples)
  Array<Real> saturation;           // s_p before stage absorption
  Array<Real3> force;               // F_b, N
  Array<Real4> place;               // x_b, m, and V_b, m³ (stage density)
  Array<Real4> back;                // ½ d n_b, m (stage density)
  Array<Real4> predicted;           // v_b + Δt a_b, m/s (in-stage)
  Array<Real> row_load, row_bound;  // g_b, c_b of the Jacobi diagonal (stage density)
};

/// Per-cloth material as plain numbers, indexable on the device.
struct Material {
  Real thickness, damping, damping_wet, strain_damping, friction, friction_wet, strain_limit, solid_fraction,
      absorption, max_saturation, virtual_pressure, emission_cosine, emission_velocity, diffusivity, capillary_height;
  int degenerate;  // DiffusionLaw
  int contact_wicking;
  Real wet_adhesion;  // w, N/m
  int porous, dynamics, self_collision;
};

/// One motion of pins in a step: a node moves from x⁰ by move + change (X0 − C), to offset + turn (X0 − C).
struct PinStep {
  Real3 center, offset, move;  // m
  Real3 turn[3], change[3];    // rows; 1
};

/// A solid as plain numbers, where it is at the end of the step (place_solids).
struct Solid {
  int kind;    // 0 box, 1 sphere, 2 plane, 3 mesh
  int inside;  // container
  int moves;
  Real3 min, max, center, point, normal;
  Real radius;
  // of bodies that move
  Real3 half;            // m: a box's half edges
  Real3 axis[3];         // the body's own axes in the world
  Real3 velocity, spin;  // m/s, rad/s
  Real3 rest_normal;     // a plane's at t = 0
  // of a closed mesh: its distance field, relative to the centre at t = 0
  const Real* field;  // m; device memory; null for an open mesh
  Index field_points[3];
  Real field_spacing;
  Real3 field_origin;  // m
};

/// The solid bodies' poses; on the device only if one of them moves.
struct BodyArrays {
  Index count = 0;
  std::vector<Vec3> still_position, still_velocity, still_spin;  // when none moves
  std::vector<Quaternion> still_orientation;
  Array<RigidBody> constant;
  Array<RigidState> state;
  // of dynamic bodies; empty without them
  Index samples = 0;
  Array<Index> sample, owner;     // per sample of a dynamic body: its number among all, and its body's
  Array<Real3> position, force;   // per such sample: m, N
  Array<Real3> predicted;         // per boundary sample: velocity in the pressure solves, m/s
  Array<Wrench> part, load;       // partial sums of the bodies' loads; one a body
  Array<Wrench> change;           // a body: what a viscous stage adds to its momenta
  Array<Real> row_load, row_arm;  // per such sample: g_b of the Jacobi diagonal; the same with the arm
  Array<Real> row_bound;          // two a body: G/M and H ‖I⁻¹‖
};

/// Work arrays of the cloth's solver, made on first use; per node.
struct ClothWork {
  Array<Real> mass, diagonal;      // m_n, kg; D_n, N/m
  Array<Real> friction;            // μ_n, 1
  Array<Real3> base;               // the target without the pressure's part, m (stage pressure)
  Array<Real3> target;             // y_n − x⁰_n, m
  Array<Real3> shift, last_shift;  // x_n − x⁰_n of the last two iterates, m (xpbd: of this one and the last anchored)
  // of xpbd: what a spring does to its first node and what a hinge pulls with (cloth.hpp), of the last two iterates, N
  Array<Real3> edge_force, last_edge_force, hinge_force, last_hinge_force;
  Array<Real> edge_rate, hinge_rate;               // θ, 1
  Array<Real3> limit_stress, last_limit_stress;    // 2 per triangle with a strain limit: the columns of P, N·m
  Array<Real> limit_rate;                          // 2 per triangle: θ, 1
  std::shared_ptr<struct ResidentCloth> resident;  // of CUDA (cuda/resident_cloth.cpp)
};

/// What the ledger's pass over the state has found beside its sums, until the liquid moves.
struct StateMeasures {
  bool fresh = false;
  PointBounds fluid;                       // around the liquid
  double fluid_speed = 0, node_speed = 0;  // m/s: the fastest, as stage time_step asks (with `mode: cfl`)
};

/// Work arrays of stage wet_adhesion, made on first use. `impulse` is zero between steps.
struct WetAdhesionWork {
  Real thickness = 0;           // m: the largest
  Array<Real> area;             // per node: A_n, m²
  Index triangles = 0;          // of cloths with self_collision
  Array<Index> triangle;        // 3 each
  Array<Real3> center;          // of each, m
  CellTable cells;              // of these
  Array<std::int64_t> impulse;  // 3 per node, units of q · 2^-20 m/s
};

/// What stage advection counts; exact in any order.
struct AdvectionCounts {
  std::int64_t collisions = 0, clamped = 0;
  std::int64_t removed = 0, drained = 0;  // particles beyond the border; their quanta
  std::int64_t gone = 0;                  // particles that do not stay
  std::int64_t put_back_near = 0;         // clamped ones that had cloth within h
  double square = 0;                      // m²/s²: the largest |v|² of those beyond the border
  KOKKOS_INLINE_FUNCTION AdvectionCounts& operator+=(const AdvectionCounts& o) {
    collisions += o.collisions;
    clamped += o.clamped;
    removed += o.removed;
    drained += o.drained;
    gone += o.gone;
    put_back_near += o.put_back_near;
    if (o.square > square) square = o.square;
    return *this;
  }
};

/// Particles that went through a cloth: how many, and the lowest of their ids; exact in any order.
struct CrossedCloth {
  std::int64_t count = 0, lowest = INT64_MAX;
  KOKKOS_INLINE_FUNCTION CrossedCloth& operator+=(const CrossedCloth& o) {
    count += o.count;
    if (o.lowest < lowest) lowest = o.lowest;
    return *this;
  }
};

/// The largest stretch of a triangle at the start, 1, and the bounds of the nodes' displacements, m.
struct ClothMotion {
  double stretch = 0;
  Double3 least, most;
};

/// Work arrays of stage advection, made on first use. `momentum` and `hits` are zero between steps.
struct AdvectionWork {
  Array<Real3> start;            // per node: x⁰_n, m
  Array<std::int64_t> momentum;  // 3 per node, units of q · 2^-8 m/s
  Array<Index> hits;             // per node: c_k
  Array<Box> box;                // per triangle: of its way in the step
  Kokkos::View<ClothMotion, MemSpace> motion;
  Kokkos::View<AdvectionCounts, Kokkos::SharedHostPinnedSpace> counts;
  Array<Real3> end, hit_weight, hit_normal;  // per liquid particle: x1, m; barycentric; towards x0
  Array<Index> hit_triangle;                 // −1: none
  Array<Index> near;                         // on a GPU: particles that may hit, in no order
  Kokkos::View<Index, MemSpace> near_count;  // zero between steps
  Array<std::uint8_t> gone;
};

/// Work arrays of stage forces with cloth, made on first use.
struct ViscousWork {
  Array<Real> sample_bound;     // K_b, kg/s
  Array<Real3> impulse_change;  // per node: D_k of its impulse, N s (with more than one stage)
};

/// Work arrays of stage surface_tension, made on first use.
struct SurfaceTensionWork {
  Array<Real3> normal;                        // n_i, 1
  Array<Real> body_adhesion, cloth_adhesion;  // D, N/m³, per body and per cloth
};

/// Work arrays of stage micropolar, made on first use.
struct MicropolarWork {
  Array<Real4> slip;                          // s′_i, 1/s, and g_i, 1/m
  Array<Real4> rate;                          // dω_i/dt, 1/s², and k_i, 1
  Array<Real3> velocity_change, spin_change;  // D_k, m/s and 1/s (with more than one stage)
};

/// Scratch of what reorders the liquid, kept between steps.
struct ReorderWork {
  Array<Index> source;  // compact_fluid
  FluidArrays spare;
};

struct Device {
  explicit Device(const Model& m);
  const Model& model;
  // numbers
  Real spacing, support, rest_density;
  Kernel kernel;
  double quantum;  // q, kg
  Real3 gravity;
  Real viscous_strength;             // χ ν/h², 1/s
  Real3 field_center, field_square;  // c, m; Ω², 1/s²
  FluidArrays fluid;
  FluidWork work;
  BoundaryArrays boundary;
  NodeArrays nodes;
  ClothWork cloth_work;
  AdvectionWork advection_work;
  SelfCollisionWork self_collision_work;
  WetAdhesionWork wet_adhesion_work;
  ViscousWork viscous_work;
  MicropolarWork micropolar_work;
  SurfaceTensionWork surface_tension_work;
  MeshArrays mesh;
  SampleArrays samples;
  Array<Material> materials;
  Array<PinStep> pin_steps;  // empty unless pins move (place_pins)
  Array<Solid> solids;
  Array<Real> fields;  // the meshes' distance fields, one after the other, m
  BodyArrays bodies;
  NeighborList fluid_fluid, fluid_boundary, fluid_sample, sample_fluid, sample_sample, sample_boundary;
  NeighborList boundary_fluid;  // rows: the samples of dynamic bodies
  CellTable fluid_cells, boundary_cells, sample_cells;
  Real emission_ramp = 0;  // s, the largest of the cloths
  // What is still true for the nodes and bodies where they are: advection and upload end it.
  bool samples_fresh = false;        // samples.position and .normal
  bool sample_bounds_fresh = false;  // sample_bounds, and the host has waited for it
  bool sample_cells_fresh = false;   // sample_cells
  bool sample_list_fresh = false;    // sample_sample
  bool boundary_list_fresh = false;  // sample_boundary
  HostBounds sample_bounds;          // made on first use
  ReorderWork reorder;
  TransferWork transfer_work;
  AbsorptionWork absorption_work;
  EmissionWork emission_work;
  DiffusionWork diffusion_work;
  ContactWork contact_work;
  ReservoirWork reservoir_work;
  MeasuresWork measures_work;
  StateMeasures measured;
  // ledger and counters on the host
  Quanta drained = 0, supplied = 0;
  std::int64_t next_id = 0;
  std::vector<std::int64_t> jet_particles;
  std::vector<Array<Real3>> jet_offsets;
  std::int64_t step = 0;
  double time = 0;
  Kokkos::View<CrossedCloth, MemSpace> crossed;  // since advection, until the ledger takes it; made with cloth

  void upload(const HostState& s);
  HostState download() const;
  /// Makes room for `n` liquid particles, keeping what is there (amortised growth).
  void reserve_fluid(Index n);
  /// Removes particles with mass 0 or with `gone(i)` ≠ 0 (may be empty), keeping the order. Lists become stale.
  /// `kept`: how many stay, where that is known; else the host waits for their number.
  void compact_fluid(const Array<std::uint8_t>& gone, Index kept = -1);
  /// The spins of `count` particles from `first` on := 0, if there are any.
  void clear_spins(Index first, Index count);
  /// Puts the liquid in the order of `fluid_cells`, which must be fresh, so that neighbours lie together in memory.
  void order_fluid_by_cell();
};

// device_refresh.cpp: derived quantities that several stages share
void refresh_samples(Device& d);             // samples.position, .normal and .velocity from the nodes
void place_samples(Device& d);               // samples.position and .normal, if they are stale
void refresh_samples_and_bounds(Device& d);  // the same as refresh_samples, and sample_bounds: to be waited for
/// sample_cells, if they are stale. Their cells have the edge h.
void refresh_sample_cells(Device& d);
void refresh_inverse_mass(Device& d);      // nodes.inverse_mass
void node_forces_from_samples(Device& d);  // nodes.force = Σ w F_b from samples.force
/// nodes.row_bound = u_n Σ_b w_bn c_b from a number c_b of each sample.
void node_bounds_from_samples(const char* label, const Device& d, const Array<Real>& of_sample);
/// v_n += Δt u_n f_n, and pin_force −= f_n on pinned nodes.
void apply_node_forces(Device& d, Real dt);

#define DRENCH_KOKKOS_STAGE(name, when) void name(Device& d, const StepInfo& info, StepReport& report);
DRENCH_STAGES(DRENCH_KOKKOS_STAGE)
#undef DRENCH_KOKKOS_STAGE

}  // namespace drench::kokkos_backend
