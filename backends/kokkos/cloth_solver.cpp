#include "cloth_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "laws/wet_cloth.hpp"
#include "primitives/reduce.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr int plain_iterations = 10;
constexpr double rounding = 0.5;  // of ε Σ D L: what is left of a residual that is summed in this precision
constexpr double trusted = 10;    // × the residual without multipliers: what xpbd may start from

void allocate(Device& d) {
  ClothWork& w = d.cloth_work;
  const auto nodes = static_cast<std::size_t>(d.nodes.count);
  if (w.mass.extent(0) == nodes) return;
  w.mass = Array<Real>("drench::cloth::mass", nodes);
  w.diagonal = Array<Real>("drench::cloth::diagonal", nodes);
  w.friction = Array<Real>("drench::cloth::friction", nodes);
  w.base = Array<Real3>("drench::cloth::base", nodes);
  w.target = Array<Real3>("drench::cloth::target", nodes);
  w.shift = Array<Real3>("drench::cloth::shift", nodes);
  w.last_shift = Array<Real3>("drench::cloth::last_shift", nodes);
}

void masses_and_diagonals(Device& d, const ClothSystem& s) {
  const auto liquid = d.nodes.liquid;
  const auto solid_mass = d.nodes.solid_mass;
  const double quantum = d.quantum;
  const auto capacity = d.nodes.capacity;
  const auto hinge_start = d.nodes.hinge_start, hinge_item = d.nodes.hinge_item;
  const auto hinge_weight = d.mesh.hinge_weight, hinge_stiffness = d.mesh.hinge_stiffness;
  parallel(
      "drench::cloth::diagonal", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Real mass =
            static_cast<Real>(static_cast<double>(solid_mass(n)) + quantum * static_cast<double>(liquid(n)));
        Real diagonal = mass * s.inverse_dt2;
        for (Index r = s.edge_start(n); r < s.edge_start(n + 1); ++r)
          diagonal += (1 + s.strain_damping(n)) * s.edge_stiffness(s.edge_item(r));
        for (Index r = hinge_start(n); r < hinge_start(n + 1); ++r) {
          const Index h = hinge_item(r) / 4;
          Real weight_sum = 0;
          for (Index a = 0; a < 4; ++a) weight_sum += Kokkos::abs(hinge_weight(4 * h + a));
          diagonal += hinge_diagonal(hinge_weight(hinge_item(r)), weight_sum, hinge_stiffness(h));
        }
        if (s.limit_start.exist())
          for (Index r = s.limit_start(n); r < s.limit_start(n + 1); ++r) {
            const Index t = s.limit_item(r) / 4;
            diagonal += strain_limit_diagonal(s.triangle_shape(t), s.limit_stiffness(t), s.limit_item(r) % 4);
          }
        const Material& m = s.materials(s.cloth(n));
        s.friction(n) = at_saturation(m.friction, m.friction_wet, node_saturation(liquid(n), quantum, capacity(n)));
        s.mass(n) = mass;
        s.diagonal(n) = diagonal;
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

/// The largest ρ for which Chebyshev's weights take a third off every mode within the cap (cloth.hpp).
double reachable_radius(int cap) {
  return cap > plain_iterations ? 1 / std::cosh(std::acosh(3.0) / (cap - plain_iterations)) : 0;
}

/// One Jacobi step with Chebyshev's ω; the new iterate replaces x^{k−1}, then the two change places.
void iterate(Device& d, const ClothSystem& s, Real omega) {
  const auto shift = d.cloth_work.shift, last_shift = d.cloth_work.last_shift;
  parallel(
      "drench::cloth::jacobi", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (s.pinned(n)) return;
        const Real thickness = s.thickness(n);
        const Real3 x = s.start(n), before = last_shift(n);
        Real3 step = (1 / s.diagonal(n)) * s.residual(n, shift);
        const NodeContact c = s.contact(n, shift(n), step);
        Real3 next = shift(n) + step;
        if (c.press > 0) next = s.rubbed(c, next, s.friction(n) * c.press);
        next = project_out(s.solids, x, next, thickness);
        if (omega != 1) next = project_out(s.solids, x, omega * (next - before) + before, thickness);
        last_shift(n) = next;
      });
  std::swap(d.cloth_work.shift, d.cloth_work.last_shift);
}

}  // namespace

ClothSystem::ClothSystem(const Device& d, Real step)
    : start(d.nodes.position),
      target(d.cloth_work.target),
      mass(d.cloth_work.mass),
      diagonal(d.cloth_work.diagonal),
      friction(d.cloth_work.friction),
      pinned(d.nodes.pinned),
      cloth(d.nodes.cloth),
      link_start(d.nodes.link_start),
      edge_start(d.nodes.edge_start),
      edge_item(d.nodes.edge_item),
      edge(d.mesh.edge),
      link(d.nodes.link),
      edge_length(d.mesh.edge_length),
      edge_stiffness(d.mesh.edge_stiffness),
      triangle(d.mesh.triangle),
      limit_start(d.nodes.limit_start),
      limit_item(d.nodes.limit_item),
      limit_shape(d.mesh.limit_shape),
      limit_stiffness(d.mesh.limit_stiffness),
      materials(d.materials),
      solids(d.solids),
      dt(step),
      inverse_dt(1 / step),
      inverse_dt2(1 / (step * step)) {}

ClothIteration::ClothIteration(Device& d, Real dt)
    : device_(d),
      system_((allocate(d), ClothSystem(d, dt))),
      method_(d.model.scene.cloth_solver.method),
      tolerance_(d.model.scene.cloth_solver.tolerance),
      rho_(0) {
  masses_and_diagonals(d, system_);
  rho_ = std::min(spectral_bound(system_, d.nodes.count), reachable_radius(d.model.scene.cloth_solver.max_iterations));
}

void ClothIteration::advance(int count) {
  if (method_ == ClothMethod::xpbd) {
    if (iterations_ == 0)
      start();
    else
      anchor_contacts(device_);
  }
  for (int k = 0; k < count; ++k) {
    if (since_restart_ == plain_iterations) omega_ = 2 / (2 - rho_ * rho_);
    if (since_restart_ > plain_iterations) omega_ = 4 / (4 - rho_ * rho_ * omega_);
    if (method_ == ClothMethod::xpbd)
      iterate_multipliers(device_, system_, static_cast<Real>(omega_));
    else
      iterate(device_, system_, static_cast<Real>(omega_));
    ++since_restart_;
    ++iterations_;
  }
}

void ClothIteration::start() {
  anchor_contacts(device_);
  start_multipliers(device_, system_);
  // Those that the cloth would have where it goes by itself; none where these push it about, as they do after a solve that
  // has ended at its cap: from there on they would be explicit forces.
  gather_multipliers(device_, system_);
  const double own = residual();
  swap_multipliers(device_);
  gather_multipliers(device_, system_);
  if (trusted * residual() < own) return;
  swap_multipliers(device_);
  gather_multipliers(device_, system_);
}

double ClothIteration::residual() const {
  const ClothSystem s = system_;
  const auto shift = device_.cloth_work.shift;
  const Index nodes = device_.nodes.count;
  const double tolerance = tolerance_;  // of Σ m |y − x⁰|/Δt²
  const double floor = rounding * static_cast<double>(std::numeric_limits<Real>::epsilon()) *
                       static_cast<double>(device_.mesh.mean_edge);
  const TwoSums sums = ordered_sums(
      "drench::cloth::residual", nodes, KOKKOS_LAMBDA(const Index n) {
        if (s.pinned(n)) return TwoSums{};
        const double force = static_cast<double>(norm(s.unbalanced(n, shift)));
        return TwoSums{force < 1e100 ? force : 1e100,
                       tolerance * static_cast<double>(s.mass(n) * s.inverse_dt2 * norm(s.target(n))) +
                           floor * static_cast<double>(s.diagonal(n))};
      });
  return sums.first > 0 ? sums.first / sums.second : 0;
}

double ClothIteration::check() {
  const double residual = this->residual();
  if (residual > 10 * smallest_) {
    rho_ = std::max(0.0, 1 - 2 * (1 - rho_));
    omega_ = 1;
    since_restart_ = 0;
  }
  smallest_ = std::min(smallest_, residual);
  return residual;
}

}  // namespace drench::kokkos_backend
