// Stage jets (src/stages/jets.hpp).

#include "common.hpp"
#include "state/needed_fields.hpp"

namespace drench::reference {

using Eigen::Vector3d;

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
      append_particle(s, state.model,
                      {arr(vec(jet.scene.center) + vec(offset) + travelled), jet.scene.velocity, quanta_per_particle,
                       Origin::jet});
      s.supplied += quanta_per_particle;
    }
  }
}

}  // namespace drench::reference
