// Stage cloth (law: src/stages/cloth.hpp). Rows are gathered per node; the unknown is the shift u = x − x⁰.

#include "stages/cloth.hpp"

#include <algorithm>
#include <utility>

#include "device.hpp"
#include "laws/contact.hpp"
#include "laws/elasticity.hpp"
#include "primitives/reduce.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr int check_interval = 10, iteration_cap = 300;
constexpr double residual_tolerance = 1e-5;  // of the mean rest edge length
constexpr Real contact_range = Real(1.01);   // of the thickness

/// What the kernels see of the cloth: everything that stays the same during one solve.
struct ClothSystem {
  Array<Real3> start, target;
  Array<Real> mass, diagonal;
  Array<std::uint8_t> pinned;
  Array<Index> cloth, edge_start, edge_item, hinge_start, hinge_item, edge, hinge;
  Array<Real> edge_length, edge_stiffness, hinge_weight, hinge_stiffness;
  Array<Material> materials;
  Array<Solid> solids;
  Real inverse_dt2;

  explicit ClothSystem(const Device& d, Real dt)
      : start(d.nodes.position),
        target(d.cloth_work.target),
        mass(d.cloth_work.mass),
        diagonal(d.cloth_work.diagonal),
        pinned(d.nodes.pinned),
        cloth(d.nodes.cloth),
        edge_start(d.nodes.edge_start),
        edge_item(d.nodes.edge_item),
        hinge_start(d.nodes.hinge_start),
        hinge_item(d.nodes.hinge_item),
        edge(d.mesh.edge),
        hinge(d.mesh.hinge),
        edge_length(d.mesh.edge_length),
        edge_stiffness(d.mesh.edge_stiffness),
        hinge_weight(d.mesh.hinge_weight),
        hinge_stiffness(d.mesh.hinge_stiffness),
        materials(d.materials),
        solids(d.solids),
        inverse_dt2(1 / (dt * dt)) {}

  /// −∂(elastic energy)/∂x_n, N.
  KOKKOS_INLINE_FUNCTION Real3 elastic_force(Index n, const Array<Real3>& shift) const {
    const Real3 here = start(n), moved = shift(n);
    Real3 force;
    for (Index r = edge_start(n); r < edge_start(n + 1); ++r) {
      const Index e = edge_item(r);
      const Index other = edge(2 * e) == n ? edge(2 * e + 1) : edge(2 * e);
      force += spring_force(separation(here, moved, start(other), shift(other)), edge_length(e), edge_stiffness(e));
    }
    for (Index r = hinge_start(n); r < hinge_start(n + 1); ++r) {
      const Index h = hinge_item(r) / 4, corner = hinge_item(r) % 4;
      Real3 bend;  // Σ K_a x_a = Σ K_a (x_a − x_n), as Σ K_a = 0
      for (Index a = 0; a < 4; ++a) {
        const Index other = hinge(4 * h + a);
        bend += hinge_weight(4 * h + a) * separation(start(other), shift(other), here, moved);
      }
      force += hinge_force(bend, hinge_weight(4 * h + corner), hinge_stiffness(h));
    }
    return force;
  }

  /// r_n, N.
  KOKKOS_INLINE_FUNCTION Real3 residual(Index n, const Array<Real3>& shift) const {
    return (mass(n) * inverse_dt2) * (target(n) - shift(n)) + elastic_force(n, shift);
  }

  KOKKOS_INLINE_FUNCTION Real thickness(Index n) const { return materials(cloth(n)).thickness; }
};

void allocate(Device& d) {
  ClothWork& w = d.cloth_work;
  const auto nodes = static_cast<std::size_t>(d.nodes.count);
  if (w.mass.extent(0) == nodes) return;
  w.mass = Array<Real>("drench::cloth::mass", nodes);
  w.diagonal = Array<Real>("drench::cloth::diagonal", nodes);
  w.target = Array<Real3>("drench::cloth::target", nodes);
  w.shift = Array<Real3>("drench::cloth::shift", nodes);
  w.last_shift = Array<Real3>("drench::cloth::last_shift", nodes);
}

/// Masses, target and Jacobi diagonal; the iteration starts at x = y.
void prepare(Device& d, const ClothSystem& s, Real dt) {
  const auto velocity = d.nodes.velocity;
  const auto liquid = d.nodes.liquid;
  const auto solid_mass = d.nodes.solid_mass;
  const auto shift = d.cloth_work.shift, last_shift = d.cloth_work.last_shift;
  const Real3 gravity = d.gravity;
  const double quantum = d.quantum;
  parallel(
      "drench::cloth::prepare", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Real mass =
            static_cast<Real>(static_cast<double>(solid_mass(n)) + quantum * static_cast<double>(liquid(n)));
        Real diagonal = mass * s.inverse_dt2;
        for (Index r = s.edge_start(n); r < s.edge_start(n + 1); ++r) diagonal += s.edge_stiffness(s.edge_item(r));
        for (Index r = s.hinge_start(n); r < s.hinge_start(n + 1); ++r) {
          const Index h = s.hinge_item(r) / 4;
          Real weight_sum = 0;
          for (Index a = 0; a < 4; ++a) weight_sum += Kokkos::abs(s.hinge_weight(4 * h + a));
          diagonal += hinge_diagonal(s.hinge_weight(s.hinge_item(r)), weight_sum, s.hinge_stiffness(h));
        }
        const Real damping = s.materials(s.cloth(n)).damping;
        const Real3 target = (dt * Kokkos::exp(-damping * dt)) * velocity(n) + (dt * dt) * gravity;
        s.mass(n) = mass;
        s.diagonal(n) = diagonal;
        s.target(n) = target;
        shift(n) = s.pinned(n) ? Real3{} : target;
        last_shift(n) = shift(n);
      });
}

/// A bound for the linear part's spectral radius: max over free nodes of 1 − m_n/(Δt² D_n).
double spectral_bound(const ClothSystem& s, Index nodes) {
  return maximum(
      "drench::cloth::spectral_bound", nodes, KOKKOS_LAMBDA(const Index n) {
        if (s.pinned(n)) return 0.0;
        return 1 -
               static_cast<double>(s.mass(n)) * static_cast<double>(s.inverse_dt2) / static_cast<double>(s.diagonal(n));
      });
}

/// One Jacobi step with Chebyshev's ω; the new iterate replaces x^{k−1}, then the two change places.
void iterate(Device& d, const ClothSystem& s, Real omega) {
  const auto shift = d.cloth_work.shift, last_shift = d.cloth_work.last_shift;
  parallel(
      "drench::cloth::jacobi", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (s.pinned(n)) return;
        const Real thickness = s.thickness(n);
        const Real3 x = s.start(n), before = last_shift(n);
        const Real3 step = (1 / s.diagonal(n)) * s.residual(n, shift);
        Real3 next = project_out(s.solids, x, shift(n) + step, thickness);
        if (omega != 1) next = project_out(s.solids, x, omega * (next - before) + before, thickness);
        last_shift(n) = next;
      });
  std::swap(d.cloth_work.shift, d.cloth_work.last_shift);
}

/// max |r_n|/D_n over free nodes, m, without the parts of r that press into a body; huge if not a number.
double largest_displacement(const Device& d, const ClothSystem& s) {
  const auto shift = d.cloth_work.shift;
  return maximum(
      "drench::cloth::residual", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (s.pinned(n)) return 0.0;
        Real3 r = s.residual(n, shift);
        for (std::size_t b = 0; b < s.solids.extent(0); ++b) {
          const SolidDistance contact = solid_distance(s.solids(b), s.start(n), shift(n));
          if (contact.phi < contact_range * s.thickness(n)) r = without_inward(r, contact.normal);
        }
        const double displacement = static_cast<double>(norm(r) / s.diagonal(n));
        return displacement < 1e100 ? displacement : 1e100;
      });
}

/// Velocities from the shifts, contact normals, friction, and the pins' reaction.
void finish(Device& d, const ClothSystem& s, Real dt) {
  const auto shift = d.cloth_work.shift;
  const auto velocity = d.nodes.velocity, contact_normal = d.nodes.contact_normal, pin_force = d.nodes.pin_force;
  const Real3 gravity = d.gravity;
  parallel(
      "drench::cloth::velocity", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (s.pinned(n)) {
          pin_force(n) -= s.elastic_force(n, shift) + s.mass(n) * gravity;
          velocity(n) = Real3{};
          contact_normal(n) = Real3{};
          return;
        }
        Real3 normal;
        bool contact = false;
        for (std::size_t b = 0; b < s.solids.extent(0); ++b) {
          const SolidDistance at = solid_distance(s.solids(b), s.start(n), shift(n));
          if (!(at.phi < contact_range * s.thickness(n))) continue;
          normal = at.normal;
          contact = true;
        }
        Real3 v = (1 / dt) * shift(n);
        if (contact) {
          const Real inward = -dot(s.residual(n, shift), normal);
          const Real press = inward > 0 ? inward : 0;
          v = with_friction(v, normal, s.materials(s.cloth(n)).friction * dt * press / s.mass(n));
        }
        velocity(n) = v;
        contact_normal(n) = normal;
      });
}

}  // namespace

void cloth(Device& d, const StepInfo& info, StepReport& report) {
  const Real dt = static_cast<Real>(info.dt);
  allocate(d);
  const ClothSystem system(d, dt);
  prepare(d, system, dt);
  double rho = spectral_bound(system, d.nodes.count);
  const double mean_edge = static_cast<double>(d.mesh.mean_edge), goal = residual_tolerance * mean_edge;

  double omega = 1, smallest = 1e300, residual = 1e300;
  int iterations = 0, since_restart = 0;
  while (iterations < iteration_cap) {
    if (since_restart == check_interval) omega = 2 / (2 - rho * rho);
    if (since_restart > check_interval) omega = 4 / (4 - rho * rho * omega);
    iterate(d, system, static_cast<Real>(omega));
    ++iterations;
    ++since_restart;
    if (iterations % check_interval != 0) continue;
    residual = largest_displacement(d, system);
    if (residual <= goal) break;
    if (residual > 10 * smallest) {
      rho = std::max(0.0, 1 - 2 * (1 - rho));
      omega = 1;
      since_restart = 0;
    }
    smallest = std::min(smallest, residual);
  }
  finish(d, system, dt);
  report.cloth_iterations = iterations;
  report.cloth_residual = mean_edge > 0 ? residual / mean_edge : 0;
  report.cloth_converged = residual <= goal;
}

}  // namespace drench::kokkos_backend
