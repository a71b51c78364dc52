// Stage ledger (src/stages/ledger.hpp).

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common.hpp"

namespace drench::reference {
namespace {

/// Compensated summation (Neumaier 1974).
class NeumaierSum {
 public:
  void add(double term) {
    const double next = sum_ + term;
    rest_ += std::abs(sum_) >= std::abs(term) ? (sum_ - next) + term : (term - next) + sum_;
    sum_ = next;
  }
  double value() const { return sum_ + rest_; }

 private:
  double sum_ = 0, rest_ = 0;
};

}  // namespace

void ledger(ReferenceState& state, const StepInfo& info, StepReport& report) {
  HostState& s = state.s;
  report.mass_fluid = std::accumulate(s.fluid_mass.begin(), s.fluid_mass.end(), Quanta{0});
  report.mass_cloth = std::accumulate(s.node_liquid.begin(), s.node_liquid.end(), Quanta{0});
  report.solute_fluid = std::accumulate(s.fluid_solute.begin(), s.fluid_solute.end(), Quanta{0});
  report.solute_cloth = std::accumulate(s.node_solute.begin(), s.node_solute.end(), Quanta{0});
  report.solute_drained = s.solute_drained;
  report.solute_supplied = s.solute_supplied;
  report.solute_deposited = s.solute_deposited;
  report.mass_drained = s.drained;
  report.mass_supplied = s.supplied;
  report.mass_evaporated = s.evaporated;
  report.particles = s.fluid_count();

  NeumaierSum mass;
  report.saturation_max = 0;
  report.kinetic_energy = 0;
  report.nonfinite = 0;
  report.fluid_speed = report.cloth_speed = report.cloth_stretch = 0;
  for (Index i = 0; i < s.fluid_count(); ++i) {
    mass.add(fluid_mass(state, i));
    report.kinetic_energy += 0.5 * fluid_mass(state, i) * vec(s.fluid_velocity[i]).squaredNorm();
    report.fluid_speed = std::max(report.fluid_speed, vec(s.fluid_velocity[i]).norm());
    report.nonfinite += !(vec(s.fluid_position[i]).allFinite() && vec(s.fluid_velocity[i]).allFinite());
  }
  for (Index n = 0; n < s.node_count(); ++n) {
    const double liquid = static_cast<double>(s.node_liquid[n]) * state.model.quantum;
    mass.add(liquid);
    report.kinetic_energy += 0.5 * node_mass(state, n) * vec(s.node_velocity[n]).squaredNorm();
    report.cloth_speed = std::max(report.cloth_speed, vec(s.node_velocity[n]).norm());
    report.nonfinite += !(vec(s.node_position[n]).allFinite() && vec(s.node_velocity[n]).allFinite());
    const auto& capacity = state.model.samples.node_capacity;
    if (!capacity.empty() && capacity[n] > 0) {
      report.saturation_max = std::max(report.saturation_max, liquid / capacity[n]);
    }
  }
  report.mass_float = mass.value();
  const ClothMesh& mesh = state.model.mesh;
  for (std::size_t e = 0; state.model.has_moving_cloth() && e < mesh.edge.size(); ++e) {
    const Vec3 &a = s.node_position[mesh.edge[e][0]], &b = s.node_position[mesh.edge[e][1]];
    report.cloth_stretch = std::max(report.cloth_stretch, (vec(b) - vec(a)).norm() / mesh.edge_length[e]);
  }
  for (Index k = 0; k < s.body_count(); ++k) {
    const Quaternion& q = s.body_orientation[k];
    report.nonfinite += !(vec(s.body_position[k]).allFinite() && vec(s.body_velocity[k]).allFinite() &&
                          vec(s.body_angular_velocity[k]).allFinite() && std::isfinite(q[0] + q[1] + q[2] + q[3]));
  }
  s.step = info.step + 1;
  s.time = info.time + info.dt;
}

}  // namespace drench::reference
