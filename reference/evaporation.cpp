// Stage evaporation of the oracle; the law stands in src/stages/evaporation.hpp.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "air.hpp"
#include "common.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr double least_room = 0.2;                  // 1: of a particle's surroundings, however many solids there are
constexpr double inside = 0.11, at_surface = 0.17;  // 1/h: of N/c², from none to all of the flat law
constexpr double most_bent = 3;                     // 1: largest correction by the curvature
constexpr double least_void = 0.05;                 // 1: of what is not filled

/// Integrals of the kernel: over a plane through its centre, 1/h; mean depth of the liquid's half of a flat surface, h.
struct Integrals {
  double plane, depth;
};

Integrals integrals(KernelKind kind) {
  if (kind == KernelKind::wendland) return {3.0 / 2, 5.0 / 24};
  if (kind == KernelKind::poly6) return {315.0 / 256, 3.0 / 14};
  return {7.0 / 5, 31.0 / 140};
}

/// What is around a particle.
struct Surroundings {
  double liquid = 0, solid = 0;                                                    // Σ V W, 1
  double number = 0;                                                               // Σ d³ W of the liquid, 1
  Vector3d liquid_gradient = Vector3d::Zero(), solid_gradient = Vector3d::Zero();  // 1/m
  bool alone = true;

  double room() const { return std::max({least_room, 1 - solid, liquid}); }
  double colour() const { return liquid / room(); }
  Vector3d gradient() const { return (liquid_gradient + colour() * solid_gradient) / room(); }
};

Surroundings around(const ReferenceState& state, Index i) {
  const HostState& s = state.s;
  const Smoothing smoothing(state.model);
  const Vector3d x = vec(s.fluid_position[i]);
  const double full = std::pow(state.model.spacing, 3);
  Surroundings result;
  result.liquid = fluid_volume(state, i) * smoothing.value(0);
  result.number = full * smoothing.value(0);
  const auto add_solid = [&](double volume, const Vector3d& r) {
    result.solid += volume * smoothing.value(r.norm());
    result.solid_gradient += volume * smoothing.gradient(r);
    result.alone = false;
  };
  for (const Index j : state.fluid_fluid[i]) {
    const Vector3d r = x - vec(s.fluid_position[j]);
    result.liquid += fluid_volume(state, j) * smoothing.value(r.norm());
    result.number += full * smoothing.value(r.norm());
    result.liquid_gradient += fluid_volume(state, j) * smoothing.gradient(r);
    result.alone = false;
  }
  for (const Index b : state.fluid_boundary[i]) add_solid(s.boundary_volume[b], x - vec(s.boundary_position[b]));
  for (const Index b : state.fluid_sample[i]) add_solid(s.sample_volume[b], from_behind(state, i, b));
  return result;
}

/// A particle's outward normal, and how far the flat law holds there, 0 to 1; the normal is 0 where it does not.
struct Normal {
  Vector3d n = Vector3d::Zero();
  double flat = 0;
};

Normal normal(const ReferenceState& state, const std::vector<Surroundings>& near, Index i) {
  const double h = state.model.support;
  const Vector3d x = vec(state.s.fluid_position[i]);
  Vector3d sum = fluid_volume(state, i) * near[i].gradient();
  for (const Index j : state.fluid_fluid[i]) {
    const double q2 = (x - vec(state.s.fluid_position[j])).squaredNorm() / (h * h);
    sum += fluid_volume(state, j) * (1 - q2) * near[j].gradient();
  }
  sum *= 15 / (8 * std::numbers::pi * h * h * h);
  const double c = near[i].colour(), steep = sum.norm() * h / (c * c);
  if (!(steep > inside)) return {};
  return {-sum.normalized(), std::min(1.0, (steep - inside) / (at_surface - inside))};
}

/// H, 1/m: by least squares, of n_j − n_i = H r_t along the surface.
double mean_curvature(const ReferenceState& state, const std::vector<Normal>& normals, Index i) {
  const Smoothing smoothing(state.model);
  const Vector3d x = vec(state.s.fluid_position[i]), n = normals[i].n;
  double turned = 0, square = 0;
  for (const Index j : state.fluid_fluid[i]) {
    if (normals[j].flat == 0) continue;
    const Vector3d r = vec(state.s.fluid_position[j]) - x, along = r - n * n.dot(r);
    const double weight = fluid_volume(state, j) * smoothing.value(r.norm());
    turned += weight * (normals[j].n - n).dot(along);
    square += weight * along.squaredNorm();
  }
  return square > 0 ? turned / square : 0;
}

/// −∇c·n, 1/m, where it is positive.
double steepness(const std::vector<Surroundings>& near, const std::vector<Normal>& normals, Index i) {
  return std::max(0.0, -near[i].gradient().dot(normals[i].n));
}

/// The part of A_i that the gradient tells, m².
double flat_area(const ReferenceState& state, const std::vector<Surroundings>& near, const std::vector<Normal>& normals,
                 Index i) {
  const double steep = steepness(near, normals, i);
  const double depth = integrals(state.model.scene.fluid.kernel).depth * state.model.support;
  const double bent = 1 + 2 * mean_curvature(state, normals, i) * depth;
  return 2 * fluid_volume(state, i) * steep * std::clamp(bent, 0.0, most_bent);
}

/// A_i, m².
double surface_area(const ReferenceState& state, const std::vector<Surroundings>& near,
                    const std::vector<Normal>& normals, Index i) {
  const Surroundings& a = near[i];
  const double volume = fluid_volume(state, i), d = state.model.spacing;
  const double drop = std::cbrt(36 * std::numbers::pi * volume * volume);
  if (a.alone) return drop;
  const double film = integrals(state.model.scene.fluid.kernel).plane * d / state.model.support;
  const double most = 2 * d * d * film / a.number * (1 - std::min(0.5, 2 * a.solid));
  const double small = std::min(drop, most), filled = a.number + a.solid;
  const double thin = std::clamp(4.0 / 3 - 2 * (filled - film) / (1 - film), 0.0, 1.0);
  const double loose = std::clamp(5.5 - 7 * filled / film, 0.0, 1.0), flat = normals[i].flat;
  if (flat == 0) return thin * small;
  const double explained = state.model.support * steepness(near, normals, i) / std::max(least_void, 1 - filled);
  const double rim = thin * std::clamp(8 - 4 * explained, 0.0, 1.0);
  return flat * std::max(std::min(flat_area(state, near, normals, i), most), std::max(loose, rim) * small) +
         (1 - flat) * thin * small;
}

std::vector<double> surface_areas(const ReferenceState& state) {
  const Index count = state.s.fluid_count();
  std::vector<Surroundings> near;
  std::vector<Normal> normals;
  std::vector<double> areas;
  for (Index i = 0; i < count; ++i) near.push_back(around(state, i));
  for (Index i = 0; i < count; ++i) normals.push_back(normal(state, near, i));
  for (Index i = 0; i < count; ++i) areas.push_back(surface_area(state, near, normals, i));
  return areas;
}

}  // namespace

void evaporation(ReferenceState& state, const StepInfo& info, StepReport&) {
  const Model& m = state.model;
  HostState& s = state.s;
  const std::vector<double> area = surface_areas(state);
  for (Index i = 0; i < s.fluid_count(); ++i) {
    Quanta& held = s.fluid_mass[i];
    const double due = m.evaporation_flux * area[i] * info.dt / m.quantum, u = drawn(s.fluid_id[i], info.step);
    if (!(due > 0)) continue;
    Quanta gone = due < static_cast<double>(held) ? static_cast<Quanta>(std::floor(due + u)) : held;
    if (held - gone < m.min_quanta) gone = u * static_cast<double>(held) < due ? held : 0;
    held -= gone;
    s.evaporated += gone;
  }
}

}  // namespace drench::reference
