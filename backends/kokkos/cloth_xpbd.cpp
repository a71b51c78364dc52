// The cloth's implicit step by XPBD (law: src/stages/cloth.hpp): Jacobi iterations on the multipliers of springs and
// hinges (a force each, N) and strain limits (two columns each, N·m); a node gathers those of its own constraints.

#include <utility>

#include "cloth_solver.hpp"

namespace drench::kokkos_backend {
namespace {

void allocate(Device& d) {
  ClothWork& w = d.cloth_work;
  const auto edges = static_cast<std::size_t>(d.mesh.edges), hinges = static_cast<std::size_t>(d.mesh.hinges);
  if (w.edge_rate.extent(0) == edges) return;
  w.edge_rate = Array<Real>("drench::cloth::edge_rate", edges);
  w.edge_force = Array<Real3>("drench::cloth::edge_force", edges);
  w.last_edge_force = Array<Real3>("drench::cloth::last_edge_force", edges);
  w.hinge_rate = Array<Real>("drench::cloth::hinge_rate", hinges);
  w.hinge_force = Array<Real3>("drench::cloth::hinge_force", hinges);
  w.last_hinge_force = Array<Real3>("drench::cloth::last_hinge_force", hinges);
  if (!d.model.has_strain_limit()) return;
  const auto columns = 2 * static_cast<std::size_t>(d.mesh.triangles);
  w.limit_rate = Array<Real>("drench::cloth::limit_rate", columns);
  w.limit_stress = Array<Real3>("drench::cloth::limit_stress", columns);
  w.last_limit_stress = Array<Real3>("drench::cloth::last_limit_stress", columns);
}

/// q_n = Δt² D_n/m_n: how much softer than its inertia alone a node's neighbourhood lets it answer; 1 if pinned.
KOKKOS_INLINE_FUNCTION Real slowness(const ClothSystem& s, Index n) {
  return s.pinned(n) ? Real(1) : s.diagonal(n) / (s.mass(n) * s.inverse_dt2);
}

/// The hinges' nodes, weights and stiffnesses.
struct Hinges {
  Array<Index> node;
  Array<Real> weight, stiffness;
  Array<Real3> start;

  /// −c_h Σ_a K_a x_a, from differences: ΣK = 0.
  KOKKOS_INLINE_FUNCTION Real3 force(Index h, const Array<Real3>& shift) const {
    const Index first = node(4 * h);
    Real3 bend;
    for (Index a = 1; a < 4; ++a) {
      const Index n = node(4 * h + a);
      bend += weight(4 * h + a) * separation(start(n), shift(n), start(first), shift(first));
    }
    return hinge_force(bend, 1, stiffness(h));
  }
};

Hinges hinges_of(const Device& d) {
  return {d.mesh.hinge, d.mesh.hinge_weight, d.mesh.hinge_stiffness, d.nodes.position};
}

/// A multiplier f that moves towards its law, with Chebyshev's ω.
KOKKOS_INLINE_FUNCTION Real3 relaxed(const Real3& f, const Real3& before, const Real3& law, Real rate, Real omega) {
  const Real3 next = f + rate * (law - f);
  return omega == 1 ? next : omega * (next - before) + before;
}

/// Π: `free` moved out of the planes that touch the solids next to x + anchor, then what is left of a curved solid. Out of
/// the solid itself would be wrong: without the contact's own force a pressed node lies deep in it, maybe beyond its centre.
KOKKOS_INLINE_FUNCTION Real3 held_out(const Slice<Solid>& solids, const Real3& x, const Real3& anchor, Real3 free,
                                      Real thickness) {
  for (std::size_t b = 0; b < solids.extent(0); ++b) {
    const SolidDistance d = solid_distance(solids(b), x, anchor);
    const Real depth = thickness - d.phi - dot(d.normal, free - anchor);
    if (depth > 0) free += depth * d.normal;
  }
  return project_out(solids, x, free, thickness);
}

}  // namespace

void anchor_contacts(Device& d) {
  if (d.solids.extent(0) == 0) return;
  const auto shift = d.cloth_work.shift, anchor = d.cloth_work.last_shift;
  parallel(
      "drench::cloth::anchor_contacts", d.nodes.count, KOKKOS_LAMBDA(const Index n) { anchor(n) = shift(n); });
}

void gather_multipliers(Device& d, const ClothSystem& s) {
  const ClothWork& w = d.cloth_work;
  const auto shift = w.shift, target = w.target, anchor = w.last_shift;
  const Hinges hinges = hinges_of(d);
  const auto edge_force = w.edge_force, force = w.hinge_force, stress = w.limit_stress;
  const auto hinge_start = d.nodes.hinge_start, hinge_item = d.nodes.hinge_item;
  parallel(
      "drench::cloth::gather_multipliers", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
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
        if (s.limit_start.exist())
          for (Index r = s.limit_start(n); r < s.limit_start(n + 1); ++r) {
            const Index t = s.limit_item(r) / 4;
            sum += corner_force({stress(2 * t), stress(2 * t + 1)},
                                corner_gradient(s.triangle_shape(t), s.limit_item(r) % 4));
          }
        const Real3 free = target(n) + (1 / (s.mass(n) * s.inverse_dt2)) * sum;
        Real3 step = free - anchor(n);
        const NodeContact c = s.contact(s.terms(n), anchor(n), step);
        if (c.press > 0) {
          const Real3 next = s.rubbed(c, anchor(n) + step, s.friction(n) * c.press);
          shift(n) = project_out(s.solids, s.start(n), next, s.thickness(n));
        } else {
          shift(n) = held_out(s.solids, s.start(n), anchor(n), free, s.thickness(n));
        }
      });
}

void start_multipliers(Device& d, const ClothSystem& s) {
  allocate(d);
  const ClothWork& w = d.cloth_work;
  const auto shift = w.shift;
  const auto edge_force = w.edge_force, last_edge_force = w.last_edge_force;
  const auto edge_rate = w.edge_rate, hinge_rate = w.hinge_rate;
  parallel(
      "drench::cloth::edge_multiplier", d.mesh.edges, KOKKOS_LAMBDA(const Index e) {
        edge_force(e) = s.edge_force(e, shift);
        last_edge_force(e) = Real3{};
        edge_rate(e) = 2 / (slowness(s, s.edge(2 * e)) + slowness(s, s.edge(2 * e + 1)));
      });
  const Hinges hinges = hinges_of(d);
  const auto force = w.hinge_force, last_force = w.last_hinge_force;
  parallel(
      "drench::cloth::hinge_multiplier", d.mesh.hinges, KOKKOS_LAMBDA(const Index h) {
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
  if (!d.model.has_strain_limit()) return;
  const auto stress = w.limit_stress, last_stress = w.last_limit_stress;
  const auto limit_rate = w.limit_rate;
  parallel(
      "drench::cloth::limit_multiplier", d.mesh.triangles, KOKKOS_LAMBDA(const Index t) {
        const Columns law = s.limit_stress(t, shift);
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
        limit_rate(2 * t) = sum.x / weighted.x;
        limit_rate(2 * t + 1) = sum.y / weighted.y;
      });
}

void swap_multipliers(Device& d) {
  std::swap(d.cloth_work.edge_force, d.cloth_work.last_edge_force);
  std::swap(d.cloth_work.hinge_force, d.cloth_work.last_hinge_force);
  std::swap(d.cloth_work.limit_stress, d.cloth_work.last_limit_stress);
}

void iterate_multipliers(Device& d, const ClothSystem& s, Real omega) {
  ClothWork& w = d.cloth_work;
  const auto shift = w.shift;
  {
    const auto force = w.edge_force, last = w.last_edge_force;
    const auto rate = w.edge_rate;
    parallel(
        "drench::cloth::spring_multipliers", d.mesh.edges,
        KOKKOS_LAMBDA(const Index e) { last(e) = relaxed(force(e), last(e), s.edge_force(e, shift), rate(e), omega); });
  }
  const Hinges hinges = hinges_of(d);
  {
    const auto force = w.hinge_force, last = w.last_hinge_force;
    const auto rate = w.hinge_rate;
    parallel(
        "drench::cloth::hinge_multipliers", d.mesh.hinges,
        KOKKOS_LAMBDA(const Index h) { last(h) = relaxed(force(h), last(h), hinges.force(h, shift), rate(h), omega); });
  }
  if (d.model.has_strain_limit()) {
    const auto stress = w.limit_stress, last = w.last_limit_stress;
    const auto rate = w.limit_rate;
    parallel(
        "drench::cloth::limit_multipliers", d.mesh.triangles, KOKKOS_LAMBDA(const Index t) {
          const Columns law = s.limit_stress(t, shift);
          const Index c = 2 * t;
          last(c) = relaxed(stress(c), last(c), law.first, rate(c), omega);
          last(c + 1) = relaxed(stress(c + 1), last(c + 1), law.second, rate(c + 1), omega);
        });
  }
  swap_multipliers(d);
  gather_multipliers(d, s);
}

}  // namespace drench::kokkos_backend
