// Stage micropolar (src/stages/micropolar.hpp).

#include <algorithm>
#include <cmath>

#include "common.hpp"

namespace drench::reference {

using Eigen::Vector3d;

namespace {

/// dv/dt, m/s², and dω/dt, 1/s².
struct SpinRates {
  Vectors flow, spin;
};

/// Calls visit(j, V_j, x_ij, ∇W_ij) for the liquid neighbours of i.
template <class Visitor>
void for_neighbors(const ReferenceState& state, Index i, const Visitor& visit) {
  const Smoothing w(state.model);
  for (const Index j : state.fluid_fluid[i]) {
    const Vector3d x = vec(state.s.fluid_position[i]) - vec(state.s.fluid_position[j]);
    visit(j, fluid_volume(state, j), x, w.pair_gradient(x));
  }
}

SpinRates spin_rates(const ReferenceState& state, const Vectors& v, const Vectors& omega) {
  const Model& m = state.model;
  const MicropolarScene& law = m.scene.fluid.micropolar;
  const double inertia = law.inertia * m.spacing * m.spacing;
  const Index count = state.s.fluid_count();
  Vectors driving(v.size());  // s′
  SpinRates out{Vectors(v.size(), Vector3d::Zero()), Vectors(v.size(), Vector3d::Zero())};
  for (Index i = 0; i < count; ++i) {
    Vector3d curl = Vector3d::Zero(), rigid = Vector3d::Zero();  // of the flow; of a rigid rotation with ω_i
    for_neighbors(state, i, [&](Index j, double volume, const Vector3d& x, const Vector3d& gradient) {
      curl += volume * (v[i] - v[j]).cross(gradient);
      rigid += volume * omega[i].cross(x).cross(gradient);
      out.spin[i] +=
          2 * law.viscosity * volume * gradient.norm() / std::max(x.norm(), m.support / 8) * (omega[j] - omega[i]);
    });
    const Vector3d slip = curl - rigid;
    for_neighbors(state, i, [&](Index, double volume, const Vector3d& x, const Vector3d& gradient) {
      out.spin[i] += law.transfer / (2 * inertia) * volume * slip.cross(x).cross(gradient);
    });
    driving[i] = slip - (1 - law.reaction) * curl;
  }
  for (Index i = 0; i < count; ++i) {
    for_neighbors(state, i, [&](Index j, double volume, const Vector3d&, const Vector3d& gradient) {
      out.flow[i] += law.transfer / 2 * volume * (driving[i] + driving[j]).cross(gradient);
    });
  }
  return out;
}

/// C, 1/s.
double rate_bound(const ReferenceState& state) {
  const Model& m = state.model;
  const MicropolarScene& law = m.scene.fluid.micropolar;
  const double inertia = law.inertia * m.spacing * m.spacing;
  double steepest = 0, widest = 0;
  for (Index i = 0; i < state.s.fluid_count(); ++i) {
    double gradients = 0, moment = 0;
    for_neighbors(state, i, [&](Index, double volume, const Vector3d& x, const Vector3d& gradient) {
      gradients += volume * gradient.norm();
      moment += volume * gradient.norm() * x.norm();
    });
    steepest = std::max(steepest, gradients);
    widest = std::max(widest, moment);
  }
  return law.transfer / 2 * (4 * steepest * steepest + widest * widest / inertia) +
         4 * law.viscosity * steepest / (m.support / 8);
}

}  // namespace

void micropolar(ReferenceState& state, const StepInfo& info, StepReport& report) {
  HostState& s = state.s;
  if (s.fluid_count() == 0) return;
  Vectors v, omega;
  for (const Vec3& one : s.fluid_velocity) v.push_back(vec(one));
  for (const Vec3& one : s.fluid_spin) omega.push_back(vec(one));
  omega.resize(v.size(), Vector3d::Zero());
  Vectors flow_change(v.size(), Vector3d::Zero()), spin_change = flow_change;

  const double bound = rate_bound(state);
  int stages = 1;
  while (stages * (stages + 1.0) < info.dt * bound) ++stages;
  report.micropolar_stages = stages;
  for (int k = 1; k <= stages; ++k) {
    const SpinRates rates = spin_rates(state, v, omega);
    const double keep = (k - 1.0) / k, weight = (2 * k - 1.0) / k * info.dt * 2 / (stages * (stages + 1.0));
    for (std::size_t i = 0; i < v.size(); ++i) {
      flow_change[i] = keep * flow_change[i] + weight * rates.flow[i];
      spin_change[i] = keep * spin_change[i] + weight * rates.spin[i];
      v[i] += flow_change[i];
      omega[i] += spin_change[i];
    }
  }
  s.fluid_spin.resize(v.size());
  for (std::size_t i = 0; i < v.size(); ++i) {
    s.fluid_velocity[i] = arr(v[i]);
    s.fluid_spin[i] = arr(omega[i]);
  }
}

}  // namespace drench::reference
