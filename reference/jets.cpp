// Stage jets (src/stages/jets.hpp).

#include "common.hpp"

namespace drench::reference {

using Eigen::Vector3d;

namespace {

void add_particle(HostState& s, bool spins, const Vector3d& position, const Vec3& velocity) {
  s.fluid_position.push_back(arr(position));
  s.fluid_velocity.push_back(velocity);
  s.fluid_mass.push_back(quanta_per_particle);
  s.fluid_id.push_back(s.next_id++);
  s.fluid_age.push_back(0);
  s.fluid_origin.push_back(static_cast<std::uint8_t>(Origin::jet));
  s.fluid_density_ratio.push_back(0);
  s.fluid_kappa_density.push_back(0);
  s.fluid_kappa_divergence.push_back(0);
  if (spins) s.fluid_spin.push_back({0, 0, 0});
  s.supplied += quanta_per_particle;
}

}  // namespace

void jets(ReferenceState& state, const StepInfo& info, StepReport&) {
  HostState& s = state.s;
  const double now = info.time + info.dt;
  s.jet_particles.resize(state.model.jets.size(), 0);
  for (std::size_t k = 0; k < state.model.jets.size(); ++k) {
    const Jet& jet = state.model.jets[k];
    for (std::int64_t& q = s.jet_particles[k];; ++q) {
      const double leaves = jet.scene.start + (static_cast<double>(q) + 0.5) * jet.interval;
      if (leaves > now || leaves >= jet.scene.end) break;
      const Vector3d travelled = vec(jet.scene.velocity) * (now - leaves);
      const Vec3& offset = jet.offsets[static_cast<std::size_t>(q) % jet.offsets.size()];
      add_particle(s, state.model.has_micropolar(), vec(jet.scene.center) + vec(offset) + travelled, jet.scene.velocity);
    }
  }
}

}  // namespace drench::reference
