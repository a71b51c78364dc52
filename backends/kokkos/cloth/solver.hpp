#pragma once
// The cloth's implicit step by Jacobi iterations with Chebyshev acceleration, on positions (pd) or on the constraints'
// multipliers (xpbd, cloth_xpbd.cpp): what stage cloth and the coupled pressure solve share. Law: src/stages/cloth.hpp.
// The unknown is the shift u = x − x⁰.

#include <memory>

#include "cloth/cloth.hpp"
#include "cloth/cloth_progress.hpp"
#include "cloth/elasticity.hpp"
#include "cloth/node_contact.hpp"

namespace drench::kokkos_backend {

/// Work arrays of the cloth's solver, made on first use; per node.
struct ClothSolverWork {
  Field<Real> mass, diagonal;  // m_n, kg, of softly pinned nodes m_n + K_n Δt²; D_n, N/m
  Field<Real> friction;        // μ_n, 1
  Field<Real> saturation;      // s_n, 1; empty unless membranes soften when wet
  Field<Real3> base;           // the target without the pressure's part, m (stage pressure)
  Field<Real3> target;         // y_n − x⁰_n, m
  // x_n − x⁰_n of the last two iterates, m; of xpbd: of this one and of the last that contacts were anchored at
  Field<Real3> displacement, last_displacement;
  // of xpbd: what a spring does to its first node and what a hinge pulls with (cloth.hpp), of the last two iterates, N
  Field<Real3> edge_force, last_edge_force, hinge_force, last_hinge_force;
  Field<Real> edge_rate, hinge_rate;  // θ, 1
  Field<Real3> triangle_stress,
      last_triangle_stress;                        // 2 per triangle with a limit or a membrane: the columns of P, N·m
  Field<Real> triangle_rate;                       // 2 per triangle: θ, 1
  std::shared_ptr<struct ResidentCloth> resident;  // of CUDA (cloth/cuda/resident_cloth.cpp)
  std::shared_ptr<struct ResidentNewton> resident_newton;  // of CUDA (cloth/cuda/resident_newton.cpp)
  std::shared_ptr<class NewtonCloth> newton;               // of a host, or of a GPU's (cloth/newton.hpp)
  Kokkos::View<Real*, Kokkos::HostSpace> fields_on_host;   // a GPU's Bodies::distance_fields, once its host needs them
};

MemoryEstimate cloth_solver_bytes(const Sizing& s);

/// What an iteration reads of a node and what stays the same during one solve.
struct NodeTerms {
  Real3 start, target;               // x⁰_n, y_n − x⁰_n, m
  Real inertia, diagonal, friction;  // m_n/Δt² and D_n, N/m; μ, 1
  Clearance clearance;
  Real compression;  // N: takes half of what pressure can take from its thickness
  Real rigid_share;  // 1: of the thickness, that it cannot
};

/// What stays the same of a triangle during one solve.
template <class T>
struct TriangleTerms {
  Vector3<T> first, second;  // edges from its first corner at x⁰, m
  TriangleShape shape;
  Real limit = 0, limit_stiffness = 0;  // ε, 1; K, N·m
  Membrane<Real> membrane{};
  YarnExcess<T> excess{};                // of its membrane at x⁰
  YarnStrains<T> most{};                 // of yarns that lock
  Real damping_rate = 0, softening = 1;  // τ/Δt; factor on its stiffness, as wet as it is
};

/// What the kernels see of the cloth: everything that stays the same during one solve. With a kernel's own arrays and
/// Kokkos' policy it has to stay within 512 bytes (types.hpp).
struct ClothSystem {
  Entries<const Real3> start;
  Entries<Real3> target;
  Entries<Real> mass, diagonal, friction;  // friction: μ, as wet as the node is
  Entries<const Real> solid_mass, kept;    // kept: the distance from solids, m; null without solids
  Entries<Real> saturation;                // s_n, 1; null unless membranes soften when wet
  Entries<const std::uint8_t> pinned;
  Entries<const Index> link_start, edge_start, edge_item, edge;
  Entries<const Link> link;
  Entries<const Real> edge_length, edge_stiffness;
  Entries<const Index> triangle, triangle_start, triangle_item;
  Entries<const Real> shape, limit_stiffness;
  Entries<const Membrane<Real>> membrane;
  Materials materials;
  Slice<const Solid> solids;
  Real dt, inverse_dt, inverse_dt2;

  ClothSystem(const Bodies& bodies, const Cloth& fabric, ClothSolverWork& solver, Real step);

  KOKKOS_INLINE_FUNCTION NodeTerms terms(Index n) const {
    return {start(n),
            target(n),
            mass(n) * inverse_dt2,
            diagonal(n),
            friction(n),
            clearance(n),
            materials(n).compression_per_mass * solid_mass(n),
            materials(n).rigid_share};
  }

  /// Adds what a link does to its node, N; `apart` = x⁰_n − x⁰_m, `moved_apart` = u_n − u_m, `excess`: spring_excess,
  /// `damping`: strain_damping.
  template <class T>
  KOKKOS_INLINE_FUNCTION static void add_link(Vector3<T>& force, const Link& l, const Vector3<T>& apart,
                                              const Vector3<T>& moved_apart, std::type_identity_t<T> excess,
                                              Real damping) {
    const Vector3<T> x = apart + moved_apart;
    // −Σ_m B_nm x_m = Σ_m B_nm (x_n − x_m): the rows of B sum to 0
    T pull = l.bend;
    if (l.stiffness > 0) pull += spring_pull(apart, moved_apart, excess, l.length, l.stiffness);
    force = fused_sum(force, pull, x);
    if (damping > 0) force += strain_damping_force(apart, moved_apart, damping);
  }
  /// What the links of a node do to it, N, in the precision of the shifts.
  template <class Shift>
  KOKKOS_INLINE_FUNCTION auto link_force(Index n, const Shift& shift) const {
    const auto moved = shift(n);
    using Vector = std::remove_cvref_t<decltype(moved)>;
    using T = decltype(moved.x);
    const Vector here = in_precision<T>(start(n));
    const Real rate = strain_damping_rate(n);
    Vector force;
    const Index last = link_start(n + 1);
    DRENCH_UNROLL
    for (Index r = link_start(n); r < last; ++r) {
      const Link l = link(r);
      const Vector apart = here - in_precision<T>(start(l.other));
      const Real damping = rate > 0 ? strain_damping(start(n) - start(l.other), l.stiffness, rate) : Real(0);
      const T excess = l.stiffness > 0 ? spring_excess<T>(start(n), start(l.other), l.length) : T(0);
      add_link(force, l, apart, moved - shift(l.other), excess, damping);
    }
    return force;
  }
  /// −∂(elastic energy)/∂x_n and the strain damping, N, in the precision of the shifts.
  template <class Shift>
  KOKKOS_INLINE_FUNCTION auto elastic_force(Index n, const Shift& shift) const {
    auto force = link_force(n, shift);
    if (triangle_start.exist()) force += triangle_force(n, shift, 0, 1);
    return force;
  }

  /// Strain limits and membranes, N: every `step`-th of the node's triangles, from `from` on.
  template <class Shift>
  KOKKOS_INLINE_FUNCTION auto triangle_force(Index n, const Shift& shift, Index from, Index step) const {
    std::remove_cvref_t<decltype(shift(n))> force;
    for (Index r = triangle_start(n) + from; r < triangle_start(n + 1); r += step) {
      const Index t = triangle_item(r) / 4;
      force += corner_force(triangle_stress(t, shift), corner_gradient(triangle_shape(t), triangle_item(r) % 4));
    }
    return force;
  }
  /// P of triangle t, N·m, in the precision of the shifts.
  template <class Shift>
  KOKKOS_INLINE_FUNCTION auto triangle_stress(Index t, const Shift& shift) const {
    const Index a = triangle(3 * t), b = triangle(3 * t + 1), c = triangle(3 * t + 2);
    return triangle_stress(t, shift(a), shift(b), shift(c));
  }
  template <class T>
  KOKKOS_INLINE_FUNCTION Columns<T> triangle_stress(Index t, const Vector3<T>& u_a, const Vector3<T>& u_b,
                                                    const Vector3<T>& u_c) const {
    return triangle_stress(triangle_terms<T>(t), u_a, u_b, u_c);
  }
  template <class T>
  KOKKOS_INLINE_FUNCTION TriangleTerms<T> triangle_terms(Index t) const {
    const Index a = triangle(3 * t), b = triangle(3 * t + 1), c = triangle(3 * t + 2);
    const Vector3<T> corner = in_precision<T>(start(a));
    TriangleTerms<T> terms{.first = in_precision<T>(start(b)) - corner,
                           .second = in_precision<T>(start(c)) - corner,
                           .shape = triangle_shape(t)};
    if (limit_stiffness.exist()) {
      terms.limit = materials(a).strain_limit;
      terms.limit_stiffness = limit_stiffness(t);
    }
    if (!membrane.exist()) return terms;
    terms.membrane = membrane(t);
    const Double3 origin = widen(start(a));
    const Double3 to_b = widen(start(b)) - origin, to_c = widen(start(c)) - origin;
    terms.excess = yarn_excess<T>(to_b, to_c, terms.shape, terms.membrane);
    if (yarns_lock(terms.membrane)) terms.most = most_strains<T>(to_b, to_c, terms.shape, terms.membrane);
    terms.damping_rate = strain_damping_rate(a);
    terms.softening = softening(t, terms.membrane);
    return terms;
  }
  template <class T>
  KOKKOS_INLINE_FUNCTION Columns<T> triangle_stress(const TriangleTerms<T>& t, const Vector3<T>& u_a,
                                                    const Vector3<T>& u_b, const Vector3<T>& u_c) const {
    const Vector3<T> first = t.first + (u_b - u_a), second = t.second + (u_c - u_a);
    Columns<T> stress;
    if (limit_stiffness.exist()) stress = strain_limit_stress(first, second, t.shape, t.limit, t.limit_stiffness);
    if (!membrane.exist()) return stress;
    Yarns<T> before, moved;
    if (!enough_digits<T> || t.damping_rate > 0) {
      before = yarns_of(t.first, t.second, t.shape, t.membrane);
      moved = yarns_of(u_b - u_a, u_c - u_a, t.shape, t.membrane);
    }
    const Columns<T> own = membrane_stress(yarns_of(first, second, t.shape, t.membrane), before, moved, t.excess,
                                           t.most, t.membrane, t.damping_rate, t.softening);
    stress.first += own.first;
    stress.second += own.second;
    return stress;
  }
  /// Factor on the stiffness of a triangle's membrane, as wet as it is.
  KOKKOS_INLINE_FUNCTION Real softening(Index t, const Membrane<Real>& m) const {
    if (!saturation.exist()) return 1;
    return 1 + (m.wet - 1) / 3 *
                   (saturation(triangle(3 * t)) + saturation(triangle(3 * t + 1)) + saturation(triangle(3 * t + 2)));
  }
  /// K of a triangle's share of the Jacobi diagonal, N·m.
  KOKKOS_INLINE_FUNCTION Real triangle_bound(Index t) const {
    const Real limit = limit_stiffness.exist() ? limit_stiffness(t) : Real(0);
    if (!membrane.exist()) return limit;
    return limit + (1 + strain_damping_rate(triangle(3 * t))) * membrane_bound(membrane(t), most_strains_of(t));
  }
  /// The strains up to which the yarns of a triangle follow their law in this step; 0 where they never lock.
  KOKKOS_INLINE_FUNCTION YarnStrains<Real> most_strains_of(Index t) const {
    if (!yarns_lock(membrane(t))) return {};
    const Double3 origin = widen(start(triangle(3 * t)));
    return most_strains<Real>(widen(start(triangle(3 * t + 1))) - origin, widen(start(triangle(3 * t + 2))) - origin,
                              triangle_shape(t), membrane(t));
  }
  KOKKOS_INLINE_FUNCTION TriangleShape triangle_shape(Index t) const {
    return {shape(3 * t), shape(3 * t + 1), shape(3 * t + 2)};
  }

  /// What the spring of edge e does to its first node, its damping with it, N.
  KOKKOS_INLINE_FUNCTION Real3 edge_force(Index e, const Entries<const Real3>& shift) const {
    const Index i = edge(2 * e), j = edge(2 * e + 1);
    const Real3 apart = start(i) - start(j), moved = shift(i) - shift(j);
    const Real excess = spring_excess<Real>(start(i), start(j), edge_length(e)), rate = strain_damping_rate(i);
    Real3 force = spring_pull(apart, moved, excess, edge_length(e), edge_stiffness(e)) * (apart + moved);
    if (rate > 0) force += strain_damping_force(apart, moved, strain_damping(apart, edge_stiffness(e), rate));
    return force;
  }

  /// r_n, N.
  KOKKOS_INLINE_FUNCTION Real3 residual(Index n, const Entries<const Real3>& shift) const {
    return (mass(n) * inverse_dt2) * (target(n) - shift(n)) + elastic_force(n, shift);
  }

  /// Solids within the clearance and 0.01 of the thickness at x⁰ + `shift`, the first four of them. `push`, a force or
  /// a displacement, loses what presses into them: each(solid, that), first the two that squeeze the node.
  /// `compression`: what presses a squeezed node to half of its thickness, of the same unit.
  template <class T, class Each>
  KOKKOS_INLINE_FUNCTION NodeContact<T> contact(const NodeTerms& t, const Vector3<T>& shift, Vector3<T>& push,
                                                Real compression, const Each& each) const {
    std::size_t solid = solids.extent(0);
    NearSolid<T> near{};
    DRENCH_ROLLED
    for (std::size_t b = 0; b < solids.extent(0); ++b) {
      const NearSolid<T> own = near_solid(solids(b), t.start, shift, t.clearance);
      if (!in_contact(own, t)) continue;
      if (solid < b) return contact_with_several(t, shift, push, compression, each, {solid, near}, {b, own});
      solid = b;
      near = own;
    }
    if (solid == solids.extent(0)) return {};
    const NodeContact<T> c = contact_with(solid, near, t, shift, push);
    each(solid, -c.press * near.at.normal);
    return c;
  }
  /// The same of a node that one solid is next to; if it is in contact.
  template <class T>
  KOKKOS_INLINE_FUNCTION NodeContact<T> contact_with(std::size_t solid, const NearSolid<T>& near, const NodeTerms& t,
                                                     const Vector3<T>& shift, Vector3<T>& push) const {
    NodeContact<T> c;
    if (!in_contact(near, t)) return c;
    c.touches = true;
    c.press = larger(T(0), -dot(push, near.at.normal));
    c.normal = near.at.normal;
    c.moved = dt * surface_velocity(solids(solid), t.start, shift);
    push += c.press * near.at.normal;
    return c;
  }
  /// Does a solid next to the node hold it?
  template <class T>
  KOKKOS_INLINE_FUNCTION static bool in_contact(const NearSolid<T>& near, const NodeTerms& t) {
    return near.at.phi < near.kept + Real(0.01) * t.clearance.thickness;  // that far beyond the distance that it keeps
  }
  /// The same of a node that more than one solid is next to, the first two of which have been found.
  template <class T, class Each>
  KOKKOS_FUNCTION DRENCH_SELDOM NodeContact<T> contact_with_several(const NodeTerms& t, const Vector3<T>& shift,
                                                                    Vector3<T>& push, Real compression,
                                                                    const Each& each, const FoundSolid<T>& one,
                                                                    const FoundSolid<T>& two) const {
    NodeContact<T> c;
    TouchedSolids<T> touched;
    const Real thickness = t.clearance.thickness;
    touched.add(solids, one.solid, one.near);
    touched.add(solids, two.solid, two.near);
    for (std::size_t b = two.solid + 1; b < solids.extent(0) && touched.count < touched.most; ++b) {
      const NearSolid<T> own = near_solid(solids(b), t.start, shift, t.clearance);
      if (in_contact(own, t)) touched.add(solids, b, own);
    }
    T squeeze = 0;  // of all pairs on each of their two solids
    const T rigid = t.rigid_share;
    for (int k = 1; k < touched.count; ++k)
      for (int j = 0; j < k; ++j) {
        if (!squeezed(solids(touched.solid[j]), touched.near[j], solids(touched.solid[k]), touched.near[k], t.start,
                      shift, thickness))
          continue;
        touched.add_pair(j, k);
        const T gap = touched.phi(j) + touched.phi(k);
        const T room = larger(gap / (2 * thickness), rigid + T(0.01));  // of the cloth's own
        const T unsqueezed = unsqueezed_width(touched.near[j], touched.near[k], T(thickness));
        squeeze += compression * larger(T(0), unsqueezed - room) / (room - rigid);
      }
    touched.take(push);
    c.touches = true;
    const auto moved = [&](int k) { return dt * surface_velocity(solids(touched.solid[k]), t.start, shift); };
    const auto press = [&](int k, T held, const Vector3<T>& normal) {
      each(touched.solid[k], -held * normal);
      c.press += held;
    };
    if (touched.first >= 0) {
      const Vector3<T>& halfway = touched.halfway;
      c.add_plane(halfway);
      c.moved = T(0.5) * (moved(touched.first) + moved(touched.second));
      press(touched.first, squeeze + larger(T(0), touched.across), halfway);
      press(touched.second, squeeze + larger(T(0), -touched.across), -halfway);
    }
    for (int k = 0; k < touched.count; ++k) {
      if (touched.holds_halfway(k)) continue;
      press(k, touched.held[k], touched.normal(k));
      if (!(touched.held[k] > 0)) continue;
      c.moved += (touched.held[k] / c.press) * (moved(k) - c.moved);  // the mean so far, by what presses
      c.add_plane(touched.normal(k));
    }
    if (!(c.press > 0) && touched.first < 0) {
      c.normal = touched.normal(0);
      c.moved = moved(0);
      return c;
    }
    for (int k = 0; k < touched.count; ++k)
      if (!touched.holds_halfway(k) && !(touched.held[k] > 0)) c.add_beside(touched.normal(k));
    return c;
  }
  template <class T>
  KOKKOS_INLINE_FUNCTION NodeContact<T> contact(const NodeTerms& t, const Vector3<T>& shift, Vector3<T>& push,
                                                Real compression) const {
    return contact(t, shift, push, compression, [](std::size_t, const Vector3<T>&) {});
  }
  /// The next iterate of a node from the last two and r_n: one Jacobi step, then Chebyshev's ω. `touching`: false where
  /// there are no solids, for a kernel with fewer registers.
  template <bool touching = true, class T>
  KOKKOS_INLINE_FUNCTION Vector3<T> next_shift(const NodeTerms& t, const Vector3<T>& shift, const Vector3<T>& before,
                                               const Vector3<T>& residual, Real omega) const {
    Vector3<T> step = (1 / T(t.diagonal)) * residual;
    if constexpr (!touching) {
      const Vector3<T> next = shift + step;
      return omega != 1 ? omega * (next - before) + before : next;
    }
    const NodeContact<T> c = contact(t, shift, step, t.compression / t.diagonal);
    Vector3<T> next = shift + step;
    if (c.press > 0) next = c.slipped(shift, next, t.friction * c.press);
    if (omega != 1) next = omega * (next - before) + before;
    return project_out(solids, t.start, next, t.clearance);
  }
  /// What is left of r_n after the solid's reaction: its normal part if it pulls, its tangential part beyond friction.
  template <class T>
  KOKKOS_INLINE_FUNCTION Vector3<T> unbalanced(const NodeTerms& t, const Vector3<T>& shift,
                                               const Vector3<T>& residual) const {
    Vector3<T> left = residual;
    const NodeContact<T> c = contact(t, shift, left, t.compression);
    return c.press > 0 ? unbalanced(t, shift, c, left) : left;
  }
  /// The same of a node that contact() has been asked about; `left` is what that left of the residual. `blocked`
  /// becomes true where friction presses the node into a solid that it is not pressed into.
  template <class T>
  KOKKOS_INLINE_FUNCTION static Vector3<T> unbalanced(const NodeTerms& t, const Vector3<T>& shift,
                                                      const NodeContact<T>& c, const Vector3<T>& left,
                                                      bool* blocked = nullptr) {
    // How far it would slip on with what is left, and how much of that friction takes.
    const Vector3<T> relative = shift - c.moved, slip = counted_slip(relative, c.tangential(relative)),
                     on = c.tangential(left);
    NodeContact<T> here = c;
    here.moved = {};
    const T loss = t.friction * c.press / t.diagonal;
    const Vector3<T> after = here.slipped(slip, slip + (1 / T(t.diagonal)) * on, loss, blocked);
    return left - on + t.diagonal * (after - slip);
  }
  /// A node's share of the residual's goal (cloth.hpp), N; `floor`: ½ ε L̄, m.
  KOKKOS_INLINE_FUNCTION static double goal(const NodeTerms& t, double tolerance, double floor) {
    return tolerance * static_cast<double>(t.inertia * norm(t.target)) + floor * static_cast<double>(t.diagonal);
  }
  /// A node's share of the residual's sum and of its goal, N.
  template <bool touching = true>
  KOKKOS_INLINE_FUNCTION TwoSums imbalance(const NodeTerms& t, const Real3& shift, const Real3& residual,
                                           double tolerance, double floor) const {
    const double force = static_cast<double>(norm(touching ? unbalanced(t, shift, residual) : residual));
    return {force < 1e100 ? force : 1e100, goal(t, tolerance, floor)};
  }

  /// τ/Δt of the node's cloth.
  KOKKOS_INLINE_FUNCTION Real strain_damping_rate(Index n) const { return materials(n).strain_damping * inverse_dt; }
  KOKKOS_INLINE_FUNCTION Clearance clearance(Index n) const {
    const Real thickness = materials(n).thickness;
    return {thickness, kept.exist() ? kept(n) : thickness, materials(n).release * dt, dt};
  }
};
#ifndef DRENCH_CHECK_BOUNDS
static_assert(sizeof(ClothSystem) <= 256);
#endif

/// The cloth as it is: masses, Jacobi diagonals and distances from solids are made anew.
ClothSystem weigh_cloth(const Constants& constants, const Bodies& bodies, Cloth& cloth, ClothSolverWork& solver,
                        Real dt);

/// The iterations of one implicit step, in as many calls as the caller likes.
class ClothIteration {
 public:
  /// With weigh_cloth; the caller sets target and shift afterwards.
  ClothIteration(const Constants& constants, const Bodies& bodies, Cloth& cloth, ClothSolverWork& solver, Real dt);
  const ClothSystem& system() const { return system_; }
  /// Iterates until the residual is within its goal, checked every 10 iterations, `most` iterations at most; the newest
  /// iterate is solver.displacement. A GPU may still be at it on return.
  void run(int most);
  /// Newton's method on a GPU's host follows where iterations fail: they end early where they are expected to take
  /// longer than that. Of the first call of run().
  void end_early_for_host();
  /// Waits for the iterations. The residual is in units of its goal: converged if ≤ 1.
  const ClothProgress& progress();
  /// Where the iterations of a GPU have ended above the goal, Newton's method goes on, on its host, and then a few more
  /// iterations; the best of what they find is the result. Waits.
  void finish_on_host();
  /// Shortens the step of each cloth where a solve that ended at its cap has led uphill (line search, cloth.hpp).
  /// Waits.
  void line_search();

 private:
  void advance(int count);
  double residual() const;
  /// xpbd: multipliers to begin with.
  void start();

  const Constants& constants_;
  const Bodies& bodies_;
  const Cloth& cloth_;
  ClothSolverWork& solver_;
  ClothSystem system_;
  ClothMethod method_;
  double tolerance_, floor_;
  ClothProgress progress_;
  bool solves_;                        // false: all nodes are pinned
  bool resident_, under_way_ = false;  // resident: see below
  bool newton_ = false;                // of a host
  bool resident_newton_ = false;       // before the resident iterations
  bool has_failed_ = false;            // a call of Newton's method in this solve
};

// cuda/resident_cloth.cpp: all iterations of a call in one kernel that stays on the device, several times as fast as
// launches where the cloth has few nodes for a GPU.
/// Can it be done: on CUDA, with cooperative launches, if all nodes fit on the device at once? (Then it makes its
/// arrays.)
bool prepare_resident_cloth(const Constants& constants, const Cloth& cloth, ClothSolverWork& solver,
                            const ClothSystem& s);
/// Where it expects a bound of the spectral radius at the first call of a solve.
Kokkos::View<double, MemSpace> resident_spectral_bound(const ClothSolverWork& solver);
/// ClothIteration::run; `begin` for the first call of a solve, with the largest ρ that it may use; null to go on.
void run_resident_cloth(ClothSolverWork& solver, const ClothSystem& s, Index nodes, const ClothProgress* begin,
                        int most, double tolerance, double floor, bool after_newton);
/// Waits for it.
ClothProgress resident_progress(const ClothSolverWork& solver);
/// Where the device keeps its progress.
struct ResidentProgress {
  const double* spectral_bound;
  ClothProgress *progress, *seen;
};
ResidentProgress resident_progress_of(const ClothSolverWork& solver);

// cuda/resident_newton.cpp: Newton's method in one kernel that stays on the device. The resident iterations follow
// where it has not converged, or expects them to take less time.
/// Does it pay? It does for cloth with fabric or strain limits (`triangles`), for cloth in scenes with mesh bodies, and
/// for cloth alone, up to 20,000 nodes (docs/dev/cloth.md).
bool is_for_newton(const Scene& scene, bool triangles, double nodes);
/// False: it does not pay, or the device cannot. Makes its arrays at the first call, and begins a solve.
/// `pushes_bodies`: do dynamic bodies feel the cloth?
bool prepare_resident_newton(const Constants& constants, const Cloth& cloth, ClothSolverWork& solver,
                             const ClothSystem& s, bool pushes_bodies);
/// `begin` counts in the first call of a solve; `most` iterations at most.
void run_resident_newton(ClothSolverWork& solver, const ClothSystem& s, const ClothProgress& begin, int most,
                         double tolerance, double floor);

// newton.cpp: on a host Newton's method needs few iterations.
/// Can it be done: where kernels run on the host. (Then it makes its arrays.)
bool prepare_newton(const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s, bool pushes_bodies);
/// NewtonCloth::run, from the displacements to them.
bool run_newton(ClothSolverWork& solver, const ClothSystem& s, ClothProgress& progress, int most, double tolerance);
/// NewtonCloth::begin_anew.
void begin_newton_anew(ClothSolverWork& solver);
/// Displacements from the best iterate of Newton's method: NewtonCloth::write_result.
void restore_newton(ClothSolverWork& solver, const ClothSystem& s);
/// NewtonCloth::run on a GPU's host, from the displacements to them; its arrays are made at the first call. Waits.
void run_newton_on_host(const Bodies& bodies, const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s,
                        bool pushes_bodies, ClothProgress& progress, int most, double tolerance);

// xpbd.cpp
/// Of the multipliers and their rates.
double multiplier_bytes(const Sizing& s);
/// Multipliers of the iterate as it is, the last ones 0, and their rates θ, from the masses and diagonals.
void start_multipliers(const Constants& constants, const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s);
/// The last multipliers become the newest and the other way round.
void swap_multipliers(ClothSolverWork& solver);
/// The positions that go with the multipliers.
void gather_multipliers(const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s);
/// From here on contact planes are those at the iterate as it is.
void anchor_contacts(const Bodies& bodies, const Cloth& cloth, ClothSolverWork& solver);
/// One Jacobi step of all multipliers with Chebyshev's ω, and the positions that go with them.
void iterate_multipliers(const Constants& constants, const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s,
                         Real omega);

}  // namespace drench::kokkos_backend
