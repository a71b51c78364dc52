// The cloth's implicit step by XPBD (law: src/stages/cloth.hpp): Jacobi iterations on the multipliers of springs and
// hinges (a force each, N) and of strain limits and membranes (two columns a triangle, N·m); a node gathers those of
// its own constraints.

#include <utility>

#include "cloth/solver.hpp"

namespace drench::kokkos_backend {
namespace {

void allocate_moves(const Constants& constants, const Cloth& cloth, ClothSolverWork& solver) {
  const auto edges = static_cast<std::size_t>(cloth.mesh.edges), hinges = static_cast<std::size_t>(cloth.mesh.hinges);
  allocate_zeros(solver.edge_rate, "drench::cloth::edge_rate", edges);
  allocate_zeros(solver.edge_force, "drench::cloth::edge_force", edges);
  allocate_zeros(solver.last_edge_force, "drench::cloth::last_edge_force", edges);
  allocate_zeros(solver.hinge_rate, "drench::cloth::hinge_rate", hinges);
  allocate_zeros(solver.hinge_force, "drench::cloth::hinge_force", hinges);
  allocate_zeros(solver.last_hinge_force, "drench::cloth::last_hinge_force", hinges);
  if (!constants.model.has_triangle_stress()) return;
  const auto columns = 2 * static_cast<std::size_t>(cloth.mesh.triangles);
  allocate_zeros(solver.triangle_rate, "drench::cloth::triangle_rate", columns);
  allocate_zeros(solver.triangle_stress, "drench::cloth::triangle_stress", columns);
  allocate_zeros(solver.last_triangle_stress, "drench::cloth::last_triangle_stress", columns);
}

}  // namespace

double multiplier_bytes(const Sizing& s) {
  const double columns = s.size.strain_limit || s.size.membrane ? 2 * s.size.triangles : 0;
  return (s.size.edges + s.size.stitches + s.size.hinges + columns) * 7 * s.real;
}

namespace {

/// q_n = Δt² D_n/m_n: how much softer than its inertia alone a node's neighbourhood lets it answer; 1 if pinned.
KOKKOS_INLINE_FUNCTION Real slowness(const ClothSystem& s, Index n) {
  return s.pinned(n) ? Real(1) : s.diagonal(n) / (s.mass(n) * s.inverse_dt2);
}

/// The hinges' nodes, weights and stiffnesses.
struct Hinges {
  Entries<const Index> node;
  Entries<const Real> weight, stiffness;
  Entries<const Real3> start;

  /// −c_h Σ_a K_a x_a, from differences: ΣK = 0.
  KOKKOS_INLINE_FUNCTION Real3 force(Index h, const Entries<const Real3>& shift) const {
    const Index first = node(4 * h);
    Real3 bend;
    for (Index a = 1; a < 4; ++a) {
      const Index n = node(4 * h + a);
      bend += weight(4 * h + a) * separation(start(n), shift(n), start(first), shift(first));
    }
    return hinge_force(bend, 1, stiffness(h));
  }
};

Hinges hinges_of(const Cloth& cloth) {
  return {cloth.mesh.hinge, cloth.mesh.hinge_weight, cloth.mesh.hinge_stiffness, cloth.nodes.position};
}

/// A multiplier f that moves towards its law, with Chebyshev's ω.
KOKKOS_INLINE_FUNCTION Real3 relaxed(const Real3& f, const Real3& before, const Real3& law, Real rate, Real omega) {
  const Real3 next = f + rate * (law - f);
  return omega == 1 ? next : omega * (next - before) + before;
}

/// One Jacobi step of multipliers towards law(i): the newest ones replace the last.
template <class Law>
void relax(const char* label, Index count, const Field<Real3>& multiplier, Field<Real3>& last_multiplier,
           const Field<Real>& rates, Real omega, const Law& law) {
  const Entries<const Real3> f = multiplier;
  const Entries<Real3> last = last_multiplier;
  const Entries<const Real> rate = rates;
  parallel(
      label, count, KOKKOS_LAMBDA(const Index i) { last(i) = relaxed(f(i), last(i), law(i), rate(i), omega); });
}

/// Π: `free` moved out of the planes that touch the solids next to x + anchor, then what is left of a curved solid. Out
/// of the solid itself would be wrong: without the contact's own force a pressed node lies deep in it, maybe beyond its
/// centre.
KOKKOS_INLINE_FUNCTION Real3 held_out(const Slice<const Solid>& solids, const Real3& x, const Real3& anchor, Real3 free,
                                      const Clearance& clearance) {
  for (std::size_t b = 0; b < solids.extent(0); ++b) {
    const NearSolid<Real> own = near_solid(solids(b), x, anchor, clearance);
    const SolidDistance<>& d = own.at;
    if (!(d.phi < far_away)) continue;
    const Real kept = d.phi < own.kept ? distance_to_keep(solids, b, own, x, anchor, clearance) : own.kept;
    const Real depth = kept - d.phi - dot(d.normal, free - anchor);
    if (depth > 0) free += depth * d.normal;
  }
  return project_out(solids, x, free, clearance);
}

}  // namespace

void anchor_contacts(const Bodies& bodies, const Cloth& cloth, ClothSolverWork& solver) {
  if (bodies.solids.extent(0) == 0) return;
  const Entries<const Real3> shift = solver.displacement;
  const Entries<Real3> anchor = solver.last_displacement;
  parallel(
      "drench::cloth::anchor_contacts", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { anchor(n) = shift(n); });
}

void gather_multipliers(const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s) {
  const Entries<Real3> shift = solver.displacement;
  const Entries<const Real3> target = solver.target, anchor = solver.last_displacement;
  const Hinges hinges = hinges_of(cloth);
  const Entries<const Real3> edge_force = solver.edge_force, force = solver.hinge_force,
                             stress = solver.triangle_stress;
  const Entries<const Index> hinge_start = cloth.nodes.hinge_start, hinge_item = cloth.nodes.hinge_item;
  parallel(
      "drench::cloth::gather_multipliers", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (s.pinned(n)) return;
        Real3 sum;
        for (Index r = s.edge_start(n); r < s.edge_start(n + 1); ++r) {
          const Index e = s.edge_item(r);
          if (s.edge(2 * e) == n)
            sum += edge_force(e);
          else
            sum -= edge_force(e);
        }
        for (Index r = hinge_start(n); r < hinge_start(n + 1); ++r)
          sum += hinges.weight(hinge_item(r)) * force(hinge_item(r) / 4);
        if (s.triangle_start.exist())
          for (Index r = s.triangle_start(n); r < s.triangle_start(n + 1); ++r) {
            const Index t = s.triangle_item(r) / 4;
            sum += corner_force(Columns<>{stress(2 * t), stress(2 * t + 1)},
                                corner_gradient(s.triangle_shape(t), s.triangle_item(r) % 4));
          }
        const Real3 free = target(n) + (1 / (s.mass(n) * s.inverse_dt2)) * sum;
        Real3 step = free - anchor(n);
        const NodeTerms t = s.terms(n);
        const NodeContact<> c = s.contact(t, anchor(n), step, t.compression / t.inertia);
        if (c.press > 0) {
          const Real3 next = c.slipped(anchor(n), anchor(n) + step, s.friction(n) * c.press);
          shift(n) = project_out(s.solids, s.start(n), next, t.clearance);
        } else {
          shift(n) = held_out(s.solids, s.start(n), anchor(n), free, t.clearance);
        }
      });
}

void start_multipliers(const Constants& constants, const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s) {
  allocate_moves(constants, cloth, solver);
  const Entries<const Real3> shift = solver.displacement;
  const Entries<Real3> edge_force = solver.edge_force, last_edge_force = solver.last_edge_force;
  const Entries<Real> edge_rate = solver.edge_rate, hinge_rate = solver.hinge_rate;
  parallel(
      "drench::cloth::edge_multiplier", cloth.mesh.edges, KOKKOS_LAMBDA(const Index e) {
        edge_force(e) = s.edge_force(e, shift);
        last_edge_force(e) = Real3{};
        edge_rate(e) = 2 / (slowness(s, s.edge(2 * e)) + slowness(s, s.edge(2 * e + 1)));
      });
  const Hinges hinges = hinges_of(cloth);
  const Entries<Real3> force = solver.hinge_force, last_force = solver.last_hinge_force;
  parallel(
      "drench::cloth::hinge_multiplier", cloth.mesh.hinges, KOKKOS_LAMBDA(const Index h) {
        force(h) = hinges.force(h, shift);
        last_force(h) = Real3{};
        Real weights = 0, weighted = 0;
        for (Index a = 0; a < 4; ++a) {
          const Real weight = Kokkos::abs(hinges.weight(4 * h + a));
          weights += weight;
          weighted += weight * slowness(s, hinges.node(4 * h + a));
        }
        hinge_rate(h) = weights > 0 ? weights / weighted : Real(1);
      });
  if (!constants.model.has_triangle_stress()) return;
  const Entries<Real3> stress = solver.triangle_stress, last_stress = solver.last_triangle_stress;
  const Entries<Real> triangle_rate = solver.triangle_rate;
  parallel(
      "drench::cloth::triangle_multiplier", cloth.mesh.triangles, KOKKOS_LAMBDA(const Index t) {
        const Columns<> law = s.triangle_stress(t, shift);
        stress(2 * t) = law.first;
        stress(2 * t + 1) = law.second;
        last_stress(2 * t) = last_stress(2 * t + 1) = Real3{};
        const CornerGradient sum = gradient_sums(s.triangle_shape(t));
        CornerGradient weighted{0, 0};
        for (Index c = 0; c < 3; ++c) {
          const CornerGradient n = corner_gradient(s.triangle_shape(t), c);
          const Real q = slowness(s, s.triangle(3 * t + c));
          weighted.x += Kokkos::abs(n.x) * q;
          weighted.y += Kokkos::abs(n.y) * q;
        }
        const Real along_x = sum.x / weighted.x, along_y = sum.y / weighted.y;
        const bool joined = s.membrane.exist() && s.membrane(t).warp > 0;  // the columns move alike
        triangle_rate(2 * t) = joined ? smaller(along_x, along_y) : along_x;
        triangle_rate(2 * t + 1) = joined ? smaller(along_x, along_y) : along_y;
      });
}

void swap_multipliers(ClothSolverWork& solver) {
  std::swap(solver.edge_force, solver.last_edge_force);
  std::swap(solver.hinge_force, solver.last_hinge_force);
  std::swap(solver.triangle_stress, solver.last_triangle_stress);
}

void iterate_multipliers(const Constants& constants, const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s,
                         Real omega) {
  const Entries<const Real3> shift = solver.displacement;
  relax(
      "drench::cloth::spring_multipliers", cloth.mesh.edges, solver.edge_force, solver.last_edge_force,
      solver.edge_rate, omega, KOKKOS_LAMBDA(const Index e) { return s.edge_force(e, shift); });
  const Hinges hinges = hinges_of(cloth);
  relax(
      "drench::cloth::hinge_multipliers", cloth.mesh.hinges, solver.hinge_force, solver.last_hinge_force,
      solver.hinge_rate, omega, KOKKOS_LAMBDA(const Index h) { return hinges.force(h, shift); });
  if (constants.model.has_triangle_stress()) {
    const Entries<const Real3> stress = solver.triangle_stress;
    const Entries<Real3> last = solver.last_triangle_stress;
    const Entries<const Real> rate = solver.triangle_rate;
    parallel(
        "drench::cloth::triangle_multipliers", cloth.mesh.triangles, KOKKOS_LAMBDA(const Index t) {
          const Columns<> law = s.triangle_stress(t, shift);
          const Index c = 2 * t;
          last(c) = relaxed(stress(c), last(c), law.first, rate(c), omega);
          last(c + 1) = relaxed(stress(c + 1), last(c + 1), law.second, rate(c + 1), omega);
        });
  }
  swap_multipliers(solver);
  gather_multipliers(cloth, solver, s);
}

}  // namespace drench::kokkos_backend
