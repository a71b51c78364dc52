#pragma once
// Solid bodies: where their surfaces are, their poses, and their boundary samples. Laws: src/stages/bodies.hpp.

#include <memory>
#include <optional>
#include <vector>

#include "bodies/rigid.hpp"
#include "core/cell_table.hpp"
#include "core/constants.hpp"
#include "core/neighbor_list.hpp"
#include "pipeline/backend.hpp"
#include "state/rigid_contacts.hpp"

namespace drench::kokkos_backend {

/// The surface of a body that changes its shape, at the end of the step; device memory. Without one all are null.
struct MovingSurface {
  const Index* nearest = nullptr;   // per lattice point: the nearest triangle, −1 beyond the band
  const Index* corner = nullptr;    // three a triangle
  const Real3* position = nullptr;  // per point of the mesh, relative to the lattice's origin, m
  const Real3* velocity = nullptr;  // mean over the step, m/s
};

/// A solid as plain numbers, where it is at the end of the step (place_solids).
struct Solid {
  Index body;  // the body whose surface, or part of it, this is
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
  MovingSurface surface;

  /// Could a particle pass through it, or leave it on the other side? Not through planes and containers.
  KOKKOS_INLINE_FUNCTION bool has_far_side() const { return kind != 2 && !inside && surface.nearest == nullptr; }
};

/// Samples of all solids, as the liquid meets them (Akinci et al. 2012).
struct BoundarySamples {
  Index count = 0;
  Field<Real3> position, velocity, rest_position;  // m, m/s, m
  Field<Real> volume;                              // V_b, m³
  Field<Index> body;
};

/// The samples of measured bodies, numbered by themselves, and sums over them; empty without such bodies. What is not
/// dynamic among them has an infinite mass.
struct DynamicSamples {
  Index count = 0;
  Field<Index> sample, owner;     // the number among all boundary samples, and the body's
  Field<Real3> position, force;   // m, N
  Field<Real3> couple;            // kg m²/s, about the sample (coupling/wall_push.hpp)
  Field<Real3> predicted;         // per boundary sample: velocity in the pressure solves, m/s
  Field<Wrench> part, load;       // partial sums of the bodies' loads; one a body
  Field<Wrench> change;           // a body: what a viscous stage adds to its momenta
  Field<Wrench> inner_change;     // the same without gravity and what programs apply
  Field<Real> row_load, row_arm;  // g_b of the Jacobi diagonal, N/…: the same with the arm
  Field<Real> row_bound;          // two a body: G/M and H ‖I⁻¹‖
  Field<Real> viscous_bound;      // K_b, kg/s (stage forces)
  Field<std::int64_t> pushed;     // 6 a body: what cloth does to it (bodies/pushed_bodies.hpp)
  Field<Wrench> applied;          // a body: what a program does to it, N and N m; null without such a body
  Field<Wrench> held;             // a body: changes of its velocities that contacts and hinges leave it (Holding)
  Field<Wrench> given;            // a body: impulses of the liquid in the step so far, but for given_by_liquid
};

struct DeformingBody;

/// Contacts and hinges of dynamic bodies in this step, as stages before stage bodies see them.
struct Holding {
  bool any = false;                     // does a dynamic body touch another, or hang on a hinge?
  double dt = 0, end = 0, share = 0;    // s, s, 1: of the step (StepInfo)
  Version looked_at = Version::none();  // Bodies::moved when `any` was found
};

struct Bodies {
  explicit Bodies(const Constants& constants);

  void upload(const Constants& constants, const HostState& s);
  void download(const Constants& constants, HostState& s) const;
  /// Only where bodies are and how they move.
  void download_poses(const Constants& constants, HostState& s) const;

  Index count = 0;
  Field<Solid> solids;          // one a body, then those of meshes' second parts (Body::parts)
  Field<Real> distance_fields;  // the meshes', then those of the second parts, m
  // poses: on the device only if a body moves, else kept for the download
  Field<RigidBody> constant;
  std::vector<RigidBody> constant_on_host;
  Field<RigidState> state;
  Array<RigidState> keyed;  // where keys put bodies; no memory without such a body
  Field<RigidState> ahead;  // `state` with the velocities that contacts and hinges leave; null before there are any
  std::vector<Vec3> static_position, static_velocity, static_spin;
  std::vector<drench::Quaternion> static_orientation;
  BoundarySamples boundary;
  DynamicSamples dynamic;
  std::vector<std::shared_ptr<DeformingBody>> deforming;  // those that change their shape (deforming_body.hpp)
  std::vector<Wrench> given_by_cloth, given_by_liquid;    // a body: impulses of the step so far, in addition to those
  std::vector<Wrench> given_by_bodies;                    // the same of contacts; empty before stage bodies
  std::shared_ptr<RigidContacts> contacts;                // null unless a body is dynamic
  Holding holding;
  Version moved;
  Cached<CellTable> cells;  // of the boundary samples

  /// The velocities of boundary samples that a pressure solve sees.
  const Field<Real3>& seen_velocity() const { return dynamic.count > 0 ? dynamic.predicted : boundary.velocity; }
};

MemoryEstimate body_bytes(const Sizing& s);

/// Builds the cells of the boundary samples if bodies have moved since.
void refresh_boundary_cells(const Constants& constants, Bodies& bodies);

/// bodies.solids: the moving ones where they will be at the end of the step.
void place_solids(const Constants& constants, Bodies& bodies, const StepInfo& info);

/// The largest speed of a moving body's surface, m/s; of a dynamic one with `fall` (m/s) added.
double fastest_body(const Bodies& bodies, double fall);

/// The bodies' momenta change by keep · the last change + weight (s) · (dynamic.force and, with `outside`, gravity and
/// what programs apply).
void body_stage(Bodies& bodies, double keep, double weight, const Constants* outside);
/// The same with dynamic.load as it is.
void move_by_load(Bodies& bodies, double keep, double weight, const Constants* outside);
/// bodies.holding, of the bodies where they are: before a pressure solve.
void look_for_contacts(Bodies& bodies, const StepInfo& info);
/// The velocities that contacts and hinges leave bodies which would move as in `free`: docs/theory/bodies.md, Contacts
/// and hinges in other stages.
std::vector<RigidState> held(const Bodies& bodies, std::vector<RigidState> free);
/// dynamic.applied, of the model as it is.
void take_applied(const Constants& constants, Bodies& bodies);
/// Begins a step: nothing has acted on the bodies yet.
void clear_given(Bodies& bodies);
/// Adds an impulse on each body to given_by_cloth or given_by_liquid.
void add_impulses(std::vector<Wrench>& given, const std::vector<Wrench>& impulses);
/// What acts on each body in the last step, of length `dt` (s), N and N m: none for one that is not measured. Waits.
std::vector<std::optional<BodyLoad>> body_loads(const Constants& constants, const Bodies& bodies, double dt);

/// boundary.velocity of the samples of dynamic bodies, from the bodies' velocities.
void refresh_dynamic_samples(Bodies& bodies);

/// bodies.keyed: the poses of bodies with keys at a time (s) and their velocities over the step from it, or at it if
/// `dt` is 0.
void place_keyed(const Constants& constants, Bodies& bodies, double time, double dt);

/// Stage prescribed_motion.
void prescribed_motion(const Constants& constants, Bodies& bodies, const StepInfo& info);

/// Stage bodies.
void bodies(const Constants& constants, Bodies& bodies, const StepInfo& info);

}  // namespace drench::kokkos_backend
