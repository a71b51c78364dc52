// Stage advection (law: src/stages/advection.hpp), law 2.

#include "coupling/cloth_motion.hpp"

#include <algorithm>
#include <utility>

#include "bodies/contact.hpp"
#include "cloth/clearance.hpp"
#include "cloth/pins.hpp"

namespace drench::kokkos_backend {
namespace {

/// Moves the free nodes and keeps them out of the bodies; beside it the largest stretch of a triangle since its rest
/// shape (how much farther than there its points lie from its samples), and the nodes' inverse masses, which liquid
/// asks for.
struct MoveCloth {
  using value_type = ClothMotion;
  Entries<const Real3> start;
  Entries<Real3> position, velocity;
  Entries<const Real3> contact_force;
  Entries<const std::uint8_t> pinned, fixed;
  Entries<const Index> triangle;
  Entries<const Real> rest, solid_mass, kept;  // kept: Nodes::clearance
  Entries<Real> inverse_mass;
  Entries<const Quanta> liquid;
  Materials materials;
  Slice<const Solid> solids;
  PinMotions pins;
  double quantum;
  Real dt;
  Index nodes, triangles;

  KOKKOS_INLINE_FUNCTION void init(ClothMotion& m) const {
    constexpr double far = Kokkos::Experimental::finite_max_v<double>;
    m = {0, {far, far, far}, {-far, -far, -far}};
  }
  KOKKOS_INLINE_FUNCTION void join(ClothMotion& m, const ClothMotion& o) const {
    if (o.stretch > m.stretch) m.stretch = o.stretch;
    join(m, o.least, o.most);
  }
  KOKKOS_INLINE_FUNCTION static void join(ClothMotion& m, const Double3& least, const Double3& most) {
    if (least.x < m.least.x) m.least.x = least.x;
    if (least.y < m.least.y) m.least.y = least.y;
    if (least.z < m.least.z) m.least.z = least.z;
    if (most.x > m.most.x) m.most.x = most.x;
    if (most.y > m.most.y) m.most.y = most.y;
    if (most.z > m.most.z) m.most.z = most.z;
  }
  KOKKOS_INLINE_FUNCTION void operator()(const Index k, ClothMotion& most) const {
    if (k < triangles) {
      const double own = stretch(k);
      if (own > most.stretch) most.stretch = own;
    }
    if (k >= nodes) return;
    const Double3 moved = widen(move(k));
    join(most, moved, moved);
  }
  KOKKOS_INLINE_FUNCTION double stretch(Index t) const {
    const Real3 corner = start(triangle(3 * t));
    const Real3 u = start(triangle(3 * t + 1)) - corner, v = start(triangle(3 * t + 2)) - corner;
    const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v);
    const double a = rest(3 * t), b = rest(3 * t + 1), c = rest(3 * t + 2);
    const double trace = a * uu + 2 * b * uv + c * vv, determinant = (a * c - b * b) * (uu * vv - uv * uv);
    const double square = 0.5 * (trace + Kokkos::sqrt(larger(0.0, trace * trace - 4 * determinant)));
    return Kokkos::sqrt(square);
  }
  /// Returns its displacement, m.
  KOKKOS_INLINE_FUNCTION Real3 move(Index n) const {
    const Real3 x = start(n);
    inverse_mass(n) = fixed(n) ? Real(0) : Real(1) / (solid_mass(n) + Real(double(liquid(n)) * quantum));
    if (pinned(n)) {
      position(n) = x;
      if (!pins.moves(n)) return {};
      position(n) = pins.position(n);
      return position(n) - x;
    }
    const Real thickness = materials(n).thickness;
    const Clearance clearance{thickness, kept.exist() ? kept(n) : thickness, materials(n).release * dt, dt};
    Real3 v = velocity(n), shift = dt * v;
    const std::size_t bodies = materials(n).self_collision ? 0 : solids.extent(0);
    for (std::size_t b = 0; b < bodies; ++b) {
      const Solid& solid = solids(static_cast<std::int64_t>(b));
      const NearSolid<Real> own = near_solid(solid, x, shift, clearance);
      const SolidDistance<>& contact = own.at;
      if (!(contact.phi < own.kept)) continue;
      const Real distance = distance_to_keep(solids, b, own, x, shift, clearance);
      if (!(contact.phi < distance)) continue;
      v = without_inward(v, contact.normal, surface_velocity(solid, x, shift));
      shift = to_distance(solid, x, shift, own, distance);
    }
    position(n) = x + shift;
    if (clearance.least < Real(0.999) * thickness)
      v = at_rest_outwards(v, x, shift, clearance, (dt * inverse_mass(n)) * contact_force(n));
    velocity(n) = v;
    return shift;
  }
  /// The velocity of a node without what it gained as solids pushed it out (docs/theory/cloth.md, (26b)). `pushed`:
  /// what their forces have added to it in the step, m/s.
  KOKKOS_INLINE_FUNCTION Real3 at_rest_outwards(Real3 v, const Real3& x, const Real3& shift, const Clearance& clearance,
                                                const Real3& pushed) const {
    for (std::size_t b = 0; b < solids.extent(0); ++b) {
      const Solid& solid = solids(static_cast<std::int64_t>(b));
      const NearSolid<Real> own = near_solid(solid, x, shift, clearance);
      const SolidDistance<>& d = own.at;
      const Real distance = distance_to_keep(solids, b, own, x, shift, clearance);
      if (!(d.phi < distance + touching * clearance.thickness)) continue;
      const Real before = distance_at_start(solid, x, dt);
      const Real outward = dot(v - surface_velocity(solid, x, shift), d.normal);
      const Real gained = smaller(dot(pushed, d.normal), (d.phi - before) / dt);
      v -= larger(Real(0), smaller(outward, gained)) * d.normal;
    }
    return v;
  }
  static constexpr Real touching = Real(0.01);  // of the thickness: nodes so near rest on a solid
};

}  // namespace

void move_cloth(const Constants& constants, const Fluid& fluid, const Bodies& bodies, Cloth& cloth, AdvectionWork& work,
                Real dt) {
  set_clearance(constants, bodies, cloth, dt);
  std::swap(cloth.nodes.position, work.start);
  const Index nodes = cloth.nodes.count, triangles = fluid.particles.total > 0 ? cloth.mesh.triangles : 0;
  const MoveCloth move{.start = work.start,
                       .position = cloth.nodes.position,
                       .velocity = cloth.nodes.velocity,
                       .contact_force = std::as_const(cloth).nodes.contact_force,
                       .pinned = cloth.nodes.pinned,
                       .fixed = cloth.nodes.fixed,
                       .triangle = cloth.mesh.triangle,
                       .rest = cloth.mesh.rest_metric,
                       .solid_mass = cloth.nodes.solid_mass,
                       .kept = cloth.nodes.clearance,
                       .inverse_mass = cloth.nodes.inverse_mass,
                       .liquid = cloth.nodes.liquid,
                       .materials = node_materials(cloth),
                       .solids = bodies.solids,
                       .pins = PinMotions(cloth),
                       .quantum = constants.quantum,
                       .dt = dt,
                       .nodes = nodes,
                       .triangles = triangles};
  Kokkos::parallel_reduce("drench::advection::cloth", range(std::max(nodes, triangles)), move, work.motion);
  cloth.moved.advance();
}

}  // namespace drench::kokkos_backend
