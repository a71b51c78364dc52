// Stage drying of the oracle; the law stands in src/stages/drying.hpp.

#include <algorithm>
#include <cmath>

#include "air.hpp"
#include "transfer.hpp"

namespace drench::reference {
namespace {

/// How much of a side with Σ V W of liquid and solids the air reaches, 1.
double open_part(double filled) { return std::max(0.0, 1 - filled / covered_side); }

/// Sides of sample p that dry, 0 to 2.
double open_sides(const ReferenceState& state, Index p) {
  if (!state.model.has_fluid()) return 2;
  const Smoothing smoothing(state.model);
  const Eigen::Vector3d x = sample_position(state, p), n = sample_normal(state, p);
  std::array<double, 2> filled{0, 0};  // Σ V W, 1: where the normal leaves, and where it points
  const auto add = [&](const Vec3& place, double volume) {
    const Eigen::Vector3d away = vec(place) - x;
    filled[away.dot(n) >= 0 ? 1 : 0] += volume * smoothing.value(away.norm());
  };
  for (const Index i : state.sample_fluid[p]) add(state.s.fluid_position[i], fluid_volume(state, i));
  for (const Index b : state.sample_boundary[p]) add(state.s.boundary_position[b], state.s.boundary_volume[b]);
  return open_part(filled[0]) + open_part(filled[1]);
}

/// Open area of every node, m².
std::vector<double> open_areas(const ReferenceState& state) {
  const SampleSet& samples = state.model.samples;
  std::vector<double> area(state.s.node_count(), 0.0);
  for (Index p = 0; p < samples.count(); ++p) {
    if (!is_porous(state, p)) continue;
    const double open = samples.area[p] * open_sides(state, p);
    for (int k = 0; k < 3; ++k) area[sample_node(state, p, k)] += samples.weight[p][k] * open;
  }
  return area;
}

/// w ≤ 0 with w + b (e^w − 1) + due = 0, by bisection.
double logarithm_left(double b, double due) {
  double low = -due, high = 0;
  for (int k = 0; k < 200; ++k) {
    const double middle = 0.5 * (low + high);
    (middle + b * std::expm1(middle) + due > 0 ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

/// What goes from a mass in dt. `rate` goes above the critical mass; below it the wet part x of the surface loses
/// rate (1 + β) x/(1 + β x), with β = `cooling`.
double dried(double mass, double critical, double rate, double cooling, double dt) {
  const double above = std::max(0.0, mass - critical);
  if (critical == 0 || rate * dt <= above) return std::min(mass, rate * dt);
  const double start = std::min(mass, critical), left = dt - above / rate;
  return above +
         start * -std::expm1(logarithm_left(cooling * start / critical, (1 + cooling) * rate * left / critical));
}

}  // namespace

void drying(ReferenceState& state, const StepInfo& info, StepReport&) {
  const Model& m = state.model;
  HostState& s = state.s;
  const std::vector<double> area = open_areas(state);
  for (Index n = 0; n < s.node_count(); ++n) {
    if (!(area[n] > 0) || s.node_liquid[n] == 0) continue;
    const double critical = m.material_of_node(n).critical_saturation * m.samples.node_capacity[n] / m.quantum;
    const double rate = m.evaporation_flux / (1 + m.cooling) * area[n] / m.quantum;
    const double due = dried(static_cast<double>(s.node_liquid[n]), critical, rate, m.cooling, info.dt);
    const Quanta gone = std::min(s.node_liquid[n], floor_quanta(due + drawn(n, info.step)));
    s.node_liquid[n] -= gone;
    s.node_buffered[n] = std::min(s.node_buffered[n], s.node_liquid[n]);
    s.evaporated += gone;
  }
}

}  // namespace drench::reference
