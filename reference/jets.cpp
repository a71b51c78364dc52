// Stage jets (src/stages/jets.hpp).

#include <Eigen/Geometry>

#include "common.hpp"
#include "state/needed_fields.hpp"

namespace drench::reference {

using Eigen::Vector3d;

namespace {

/// Eqs. 30, 31: the liquid comes out as a plug, whose axis turns as keys say.
void let_go_by_keys(ReferenceState& state, const Jet& jet, std::int64_t& q, double now) {
  if (now <= jet.scene.start) return;
  const double out = jet.speed.integral(jet.scene.start, std::min(now, jet.scene.end));
  const Vector3d axis = vec(jet.aim.at(now)).normalized();
  const auto turn = Eigen::Quaterniond::FromTwoVectors(vec(jet.aim.plain()), axis);
  for (; (static_cast<double>(q) + 0.5) * jet.advance <= out; ++q) {
    const double ahead = out - (static_cast<double>(q) + 0.5) * jet.advance;
    const Vec3& offset = jet.offsets[static_cast<std::size_t>(q) % jet.offsets.size()];
    append_particle(state.s, state.model,
                    {arr(vec(jet.scene.center) + turn * vec(offset) + ahead * axis), arr(jet.speed.at(now) * axis),
                     jet.mass, Origin::jet, jet.solute});
    state.s.supplied += jet.mass;
    state.s.solute_supplied += jet.solute;
  }
}

}  // namespace

void jets(ReferenceState& state, const StepInfo& info, StepReport&) {
  HostState& s = state.s;
  const double now = info.time + info.dt;
  s.jet_particles.resize(state.model.jets.size(), 0);
  for (std::size_t k = 0; k < state.model.jets.size(); ++k) {
    const Jet& jet = state.model.jets[k];
    if (jet.has_keys()) {
      let_go_by_keys(state, jet, s.jet_particles[k], now);
      continue;
    }
    const Vec3& velocity = jet.scene.velocity.plain();
    for (std::int64_t& q = s.jet_particles[k];; ++q) {
      const double leaves = jet.scene.start + (static_cast<double>(q) + 0.5) * jet.interval;
      if (leaves > now || leaves >= jet.scene.end) break;
      const Vector3d travelled = vec(velocity) * (now - leaves);
      const Vec3& offset = jet.offsets[static_cast<std::size_t>(q) % jet.offsets.size()];
      append_particle(
          s, state.model,
          {arr(vec(jet.scene.center) + vec(offset) + travelled), velocity, jet.mass, Origin::jet, jet.solute});
      s.supplied += jet.mass;
      s.solute_supplied += jet.solute;
    }
  }
}

}  // namespace drench::reference
