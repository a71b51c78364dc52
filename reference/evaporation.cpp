// Stage evaporation of the oracle; the law stands in src/stages/evaporation.hpp.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "air.hpp"
#include "common.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr double least_room = 0.2;           // 1: of a particle's surroundings, however many solids there are
constexpr double none = 0.11, whole = 0.17;  // 1/h: of N/c², of the flat law
constexpr double most_bent = 3;              // 1: largest correction by the curvature
constexpr double least_void = 0.05;          // 1: of what is not filled

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
  double moment = 0;                                                               // M, 1: of all around
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
  const auto add = [&](double volume, const Vector3d& r, double& share, Vector3d& gradient) {
    const Vector3d change = volume * smoothing.gradient(r);
    share += volume * smoothing.value(r.norm());
    gradient += change;
    result.moment -= r.dot(change) / 3;
    result.alone = false;
  };
  const auto add_solid = [&](double volume, const Vector3d& r) { add(volume, r, result.solid, result.solid_gradient); };
  for (const Index j : state.fluid_fluid[i]) {
    const Vector3d r = x - vec(s.fluid_position[j]);
    add(fluid_volume(state, j), r, result.liquid, result.liquid_gradient);
    result.number += full * smoothing.value(r.norm());
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
  if (!(steep > none)) return {};
  return {-sum.normalized(), std::min(1.0, (steep - none) / (whole - none))};
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

/// What the areas are made of, one entry a particle.
struct Surface {
  const ReferenceState& state;
  std::vector<Surroundings> near{};
  std::vector<Normal> normals{};
  std::vector<double> flat{};  // f F, m²: what the gradient tells, below 0 where it points inwards
  std::vector<double> near_inside{}, moment_of_inside{};  // C and B, 1: how much of the inside is near, and its moment

  Index count() const { return state.s.fluid_count(); }
  double film() const {
    return integrals(state.model.scene.fluid.kernel).plane * state.model.spacing / state.model.support;
  }
  double filled(Index i) const { return near[i].number + near[i].solid; }
  /// t, 1.
  double thin(Index i) const { return std::clamp(4.0 / 3 - 2 * (filled(i) - film()) / (1 - film()), 0.0, 1.0); }
  /// −∇c·n, 1/m.
  double steepness(Index i) const { return -near[i].gradient().dot(normals[i].n); }
  /// Σ over a particle and its neighbours j of W_ij of(j), 1/m³ times the unit of `of`.
  template <class Of>
  double weighted_sum(Index i, const Of& of) const {
    const Smoothing smoothing(state.model);
    const Vector3d x = vec(state.s.fluid_position[i]);
    double sum = smoothing.value(0) * of(i);
    for (const Index j : state.fluid_fluid[i])
      sum += smoothing.value((x - vec(state.s.fluid_position[j])).norm()) * of(j);
    return sum;
  }
};

void find_flat_areas(Surface& s) {
  const double depth = integrals(s.state.model.scene.fluid.kernel).depth * s.state.model.support;
  const auto inside = [&](Index j) { return (1 - s.normals[j].flat) * (1 - s.thin(j)) * fluid_volume(s.state, j); };
  for (Index i = 0; i < s.count(); ++i) {
    const bool surface = s.normals[i].flat > 0;
    const double bent = surface ? std::clamp(1 + 2 * mean_curvature(s.state, s.normals, i) * depth, 0.0, most_bent) : 0;
    s.flat.push_back(s.normals[i].flat * 2 * fluid_volume(s.state, i) * s.steepness(i) * bent);
    s.near_inside.push_back(surface ? s.weighted_sum(i, inside) : 0);
    s.moment_of_inside.push_back(surface ? s.weighted_sum(i, [&](Index j) { return inside(j) * s.near[j].moment; })
                                         : 0);
  }
}

/// f A^f, m²: without what points inwards nearby, and of a kernel whose moment is that of the inside.
std::vector<double> outward_areas(const Surface& s) {
  const auto outwards = [&](Index j) { return std::max(0.0, s.flat[j]); };
  std::vector<double> taken;  // Q, m³
  for (Index j = 0; j < s.count(); ++j) {
    const double inwards = (1 - s.thin(j)) * std::max(0.0, -s.flat[j]),
                 given = inwards > 0 ? s.weighted_sum(j, outwards) : 0;
    taken.push_back(given > 0 ? inwards / given : 0);
  }
  std::vector<double> result;
  for (Index i = 0; i < s.count(); ++i) {
    const double area = outwards(i);
    if (area == 0) {
      result.push_back(0);
      continue;
    }
    const double left = std::max(0.0, 1 - s.weighted_sum(i, [&](Index j) { return taken[j]; }));
    const double near = s.weighted_sum(i, [&](Index j) { return fluid_volume(s.state, j) * s.near_inside[j]; });
    const double moment = s.weighted_sum(i, [&](Index j) { return fluid_volume(s.state, j) * s.moment_of_inside[j]; });
    result.push_back(near > 0 ? area * left * near / moment : area * left);
  }
  return result;
}

/// A_i, m², of f A^f.
double surface_area(const Surface& s, double outward, Index i) {
  const Surroundings& a = s.near[i];
  const double volume = fluid_volume(s.state, i), d = s.state.model.spacing, film = s.film();
  const double drop = std::cbrt(36 * std::numbers::pi * volume * volume);
  if (a.alone) return drop;
  const double open = 1 - std::min(0.5, 2 * a.solid), both_sides = 2 * d * d * film / a.number;
  const double small = std::min(drop, both_sides * open), thin = s.thin(i), flat = s.normals[i].flat;
  if (flat == 0) return thin * small;
  const double loose = std::clamp(5.5 - 7 * s.filled(i) / film, 0.0, 1.0);
  const double explained =
      s.state.model.support * std::max(0.0, s.steepness(i)) / std::max(least_void, 1 - s.filled(i));
  const double rim = thin * std::clamp(8 - 4 * explained, 0.0, 1.0);
  const double bound = flat * 2 * both_sides * open * open, few = flat * std::max(loose, rim) * small;
  return std::max(std::min(outward, bound), few) + (1 - flat) * thin * small;
}

std::vector<double> surface_areas(const ReferenceState& state) {
  Surface s{state};
  for (Index i = 0; i < s.count(); ++i) s.near.push_back(around(state, i));
  for (Index i = 0; i < s.count(); ++i) s.normals.push_back(normal(state, s.near, i));
  find_flat_areas(s);
  const std::vector<double> outward = outward_areas(s);
  std::vector<double> areas;
  for (Index i = 0; i < s.count(); ++i) areas.push_back(surface_area(s, outward[i], i));
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
