#pragma once
// The cloth's implicit step by Jacobi iterations with Chebyshev acceleration, on positions (pd) or on the constraints'
// multipliers (xpbd, cloth_xpbd.cpp): what stage cloth and the coupled pressure solve share. Law: src/stages/cloth.hpp.
// The unknown is the shift u = x − x⁰.

#include "device.hpp"
#include "laws/contact.hpp"
#include "laws/elasticity.hpp"

namespace drench::kokkos_backend {

/// The solids that a node touches: the last one's normal and how far its surface moves in the step (m), and what presses
/// the node into all of them, as a force or a way.
struct NodeContact {
  bool touches = false;
  Real3 normal, moved;
  Real press = 0;
};

/// What the kernels see of the cloth: everything that stays the same during one solve. With a kernel's own arrays and
/// Kokkos' policy it has to stay within 512 bytes (types.hpp).
struct ClothSystem {
  Entries<Real3> start, target;
  Entries<Real> mass, diagonal, friction;  // friction: μ, as wet as the node is
  Entries<std::uint8_t> pinned;
  Entries<Index> cloth, link_start, edge_start, edge_item, edge;
  Entries<Link> link;
  Entries<Real> edge_length, edge_stiffness;
  Entries<Index> triangle, limit_start, limit_item;
  Entries<Real> limit_shape, limit_stiffness;
  Entries<Material> materials;
  Slice<Solid> solids;
  Real dt, inverse_dt, inverse_dt2;

  ClothSystem(const Device& d, Real step);

  /// −∂(elastic energy)/∂x_n and the strain damping, N.
  KOKKOS_INLINE_FUNCTION Real3 elastic_force(Index n, const Array<Real3>& shift) const {
    const Real3 here = start(n), moved = shift(n);
    const Real damping = strain_damping(n);
    Real3 force;
    const Index last = link_start(n + 1);
    DRENCH_UNROLL
    for (Index r = link_start(n); r < last; ++r) {
      const Link l = link(r);
      const Real3 apart = here - start(l.other), moved_apart = moved - shift(l.other);
      const Real3 x = apart + moved_apart;
      // −Σ_m B_nm x_m = Σ_m B_nm (x_n − x_m): the rows of B sum to 0
      force += spring_force(x, l.length, l.stiffness) + l.bend * x;
      if (damping > 0) force += strain_damping_force(apart, moved_apart, l.stiffness, damping);
    }
    if (limit_start.exist()) force += limit_force(n, shift);
    return force;
  }

  /// Strain limiting, N.
  KOKKOS_INLINE_FUNCTION Real3 limit_force(Index n, const Array<Real3>& shift) const {
    Real3 force;
    for (Index r = limit_start(n); r < limit_start(n + 1); ++r) {
      const Index t = limit_item(r) / 4;
      force += corner_force(limit_stress(t, shift), corner_gradient(triangle_shape(t), limit_item(r) % 4));
    }
    return force;
  }
  /// P of triangle t, N·m.
  KOKKOS_INLINE_FUNCTION Columns limit_stress(Index t, const Array<Real3>& shift) const {
    const Index a = triangle(3 * t), b = triangle(3 * t + 1), c = triangle(3 * t + 2);
    return strain_limit_stress(separation(start(b), shift(b), start(a), shift(a)),
                               separation(start(c), shift(c), start(a), shift(a)), triangle_shape(t),
                               materials(cloth(a)).strain_limit, limit_stiffness(t));
  }
  KOKKOS_INLINE_FUNCTION TriangleShape triangle_shape(Index t) const {
    return {limit_shape(3 * t), limit_shape(3 * t + 1), limit_shape(3 * t + 2)};
  }

  /// What the spring of edge e does to its first node, its damping with it, N.
  KOKKOS_INLINE_FUNCTION Real3 edge_force(Index e, const Array<Real3>& shift) const {
    const Index i = edge(2 * e), j = edge(2 * e + 1);
    Real3 force = spring_force(separation(start(i), shift(i), start(j), shift(j)), edge_length(e), edge_stiffness(e));
    const Real damping = strain_damping(i);
    if (damping > 0)
      force += strain_damping_force(start(i) - start(j), shift(i) - shift(j), edge_stiffness(e), damping);
    return force;
  }

  /// r_n, N.
  KOKKOS_INLINE_FUNCTION Real3 residual(Index n, const Array<Real3>& shift) const {
    return (mass(n) * inverse_dt2) * (target(n) - shift(n)) + elastic_force(n, shift);
  }

  /// Solids within 1.01 of the thickness at x⁰ + `shift`. `push`, a force or a way, loses what presses into them.
  KOKKOS_INLINE_FUNCTION NodeContact contact(Index n, const Real3& shift, Real3& push) const {
    NodeContact c;
    const Real range = Real(1.01) * thickness(n);
    for (std::size_t b = 0; b < solids.extent(0); ++b) {
      const SolidDistance at = solid_distance(solids(b), start(n), shift);
      if (!(at.phi < range)) continue;
      c.touches = true;
      c.normal = at.normal;
      c.moved = dt * surface_velocity(solids(b), start(n), shift);
      const Real inward = dot(push, at.normal);
      if (!(inward < 0)) continue;
      c.press -= inward;
      push -= inward * at.normal;
    }
    return c;
  }
  /// A shift after Coulomb friction: it slips along the surface by `loss` (m) less, at most to a standstill.
  KOKKOS_INLINE_FUNCTION static Real3 rubbed(const NodeContact& c, const Real3& shift, Real loss) {
    const Real3 slip = tangential(shift - c.moved, c.normal);
    const Real length = norm(slip);
    return length > loss ? shift - (loss / length) * slip : shift - slip;
  }
  KOKKOS_INLINE_FUNCTION static Real3 tangential(const Real3& v, const Real3& normal) {
    return v - dot(v, normal) * normal;
  }
  /// What is left of r_n after the solid's reaction: its normal part if it pulls, its tangential part beyond friction.
  KOKKOS_INLINE_FUNCTION Real3 unbalanced(Index n, const Array<Real3>& shift) const {
    Real3 left = residual(n, shift);
    const NodeContact c = contact(n, shift(n), left);
    if (!(c.press > 0)) return left;
    // How far it would slip on with what is left, and how much of that friction takes.
    const Real3 slip = tangential(shift(n) - c.moved, c.normal), on = tangential(left, c.normal);
    const Real stiffness = diagonal(n);
    const Real3 after = rubbed({true, c.normal, {}, 0}, slip + (1 / stiffness) * on, friction(n) * c.press / stiffness);
    return left - on + stiffness * (after - slip);
  }

  /// τ/Δt of the node's cloth.
  KOKKOS_INLINE_FUNCTION Real strain_damping(Index n) const { return materials(cloth(n)).strain_damping * inverse_dt; }
  KOKKOS_INLINE_FUNCTION Real thickness(Index n) const { return materials(cloth(n)).thickness; }
};
static_assert(sizeof(ClothSystem) <= 240);

/// Chebyshev's weights (Wang 2015), which go on over several calls of `advance`.
class ClothIteration {
 public:
  /// Wet masses and Jacobi diagonals; the caller sets target and shift afterwards.
  ClothIteration(Device& d, Real dt);
  const ClothSystem& system() const { return system_; }
  int iterations() const { return iterations_; }
  /// `count` iterations; the newest iterate is d.cloth_work.shift.
  void advance(int count);
  /// The residual of the newest iterate in units of its goal: converged if ≤ 1. If it has grown tenfold over the
  /// smallest so far, ρ is lowered and the weights start again. Synchronises with the host.
  double check();
  /// The same number, without consequences.
  double residual() const;
  /// xpbd: multipliers to begin with.
  void start();

 private:
  Device& device_;
  ClothSystem system_;
  ClothMethod method_;
  double tolerance_;
  double rho_, omega_ = 1, smallest_ = 1e300;
  int since_restart_ = 0, iterations_ = 0;
};

// cloth_xpbd.cpp
/// Multipliers of the iterate as it is, the last ones 0, and their rates θ, from the masses and diagonals.
void start_multipliers(Device& d, const ClothSystem& s);
/// The last multipliers become the newest and the other way round.
void swap_multipliers(Device& d);
/// The positions that go with the multipliers.
void gather_multipliers(Device& d, const ClothSystem& s);
/// From here on contact planes are those at the iterate as it is.
void anchor_contacts(Device& d);
/// One Jacobi step of all multipliers with Chebyshev's ω, and the positions that go with them.
void iterate_multipliers(Device& d, const ClothSystem& s, Real omega);

}  // namespace drench::kokkos_backend
