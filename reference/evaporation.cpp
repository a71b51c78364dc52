// Stage evaporation of the oracle; the law stands in src/stages/evaporation.hpp.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "air.hpp"
#include "common.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr double flat_gradient = 0.1;  // 1/d: a mean ∇c/c below it is that of a particle within the liquid

/// ∇c of the liquid and of all that it touches, 1/m.
Vector3d colour_gradient(const ReferenceState& state, Index i) {
  const HostState& s = state.s;
  const Smoothing smoothing(state.model);
  const Vector3d x = vec(s.fluid_position[i]);
  Vector3d sum = Vector3d::Zero();
  for (const Index j : state.fluid_fluid[i])
    sum += fluid_volume(state, j) * smoothing.gradient(x - vec(s.fluid_position[j]));
  for (const Index b : state.fluid_boundary[i])
    sum += s.boundary_volume[b] * smoothing.gradient(x - vec(s.boundary_position[b]));
  for (const Index b : state.fluid_sample[i]) sum += s.sample_volume[b] * smoothing.gradient(from_behind(state, i, b));
  return sum;
}

/// c, 1.
double colour(const ReferenceState& state, Index i) {
  const HostState& s = state.s;
  const Smoothing smoothing(state.model);
  const Vector3d x = vec(s.fluid_position[i]);
  double sum = fluid_volume(state, i) * smoothing.value(0);
  for (const Index j : state.fluid_fluid[i])
    sum += fluid_volume(state, j) * smoothing.value((x - vec(s.fluid_position[j])).norm());
  for (const Index b : state.fluid_boundary[i])
    sum += s.boundary_volume[b] * smoothing.value((x - vec(s.boundary_position[b])).norm());
  for (const Index b : state.fluid_sample[i])
    sum += s.sample_volume[b] * smoothing.value(from_behind(state, i, b).norm());
  return sum;
}

bool is_alone(const ReferenceState& state, Index i) {
  return state.fluid_fluid[i].empty() && state.fluid_boundary[i].empty() && state.fluid_sample[i].empty();
}

/// A_i, m².
double surface_area(const ReferenceState& state, const Vectors& gradient, Index i) {
  const double volume = fluid_volume(state, i);
  if (is_alone(state, i)) return std::cbrt(36 * std::numbers::pi * volume * volume);
  const Smoothing smoothing(state.model);
  const Vector3d x = vec(state.s.fluid_position[i]);
  Vector3d smooth = volume * smoothing.value(0) * gradient[i];
  for (const Index j : state.fluid_fluid[i])
    smooth += fluid_volume(state, j) * smoothing.value((x - vec(state.s.fluid_position[j])).norm()) * gradient[j];
  const double c = colour(state, i);
  if (smooth.norm() < flat_gradient / state.model.spacing * c * c) return 0;
  return std::max(0.0, 2 * volume * gradient[i].dot(smooth.normalized()));
}

}  // namespace

void evaporation(ReferenceState& state, const StepInfo& info, StepReport&) {
  const Model& m = state.model;
  HostState& s = state.s;
  Vectors gradient;
  for (Index i = 0; i < s.fluid_count(); ++i) gradient.push_back(colour_gradient(state, i));
  std::vector<double> area;
  for (Index i = 0; i < s.fluid_count(); ++i) area.push_back(surface_area(state, gradient, i));
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
