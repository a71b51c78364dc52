#include "self_contact.hpp"

#include "cloth_problem.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr double kappa = 30, near_end = 1.5;

/// Where the nodes' velocities take them, out of bodies; pins go where they are led.
Vectors ends(const ReferenceState& state, const StepInfo& info, const std::vector<PlacedBody>& bodies) {
  const ClothMesh& mesh = state.model.mesh;
  Vectors end;
  for (Index n = 0; n < mesh.nodes(); ++n) {
    end.push_back(mesh.pinned[n] ? pin_position(state, n, info.time + info.dt)
                                 : vec(state.s.node_position[n]) + info.dt * vec(state.s.node_velocity[n]));
    if (!mesh.pinned[n]) project_out(bodies, state.model.cloths[mesh.node_cloth[n]].thickness, end[n]);
  }
  return end;
}

/// How a pair lies where it touches; none: it does not.
std::optional<Near> touching(const Pair& pair, const Four& x, const Four& u) {
  if (!reaches(pair, x, u, 0.5 * std::min(pair.thickness, pair.distance))) {
    Four end;
    for (int k = 0; k < 4; ++k) end[k] = x[k] + u[k];
    const Near near = nearest(end, pair.edges);
    return near.apart.norm() <= near_end * pair.thickness ? std::optional(near) : std::nullopt;
  }
  return pair.distance > pair.thickness ? reaches(pair, x, u, pair.thickness) : nearest(x, pair.edges);
}

}  // namespace

Vector3d SelfContact::force(const Four& moved) const {
  Vector3d u = Vector3d::Zero();
  for (int k = 0; k < 4; ++k) u += b[k] * moved[k];
  const double pressed = short_of - normal.dot(u);
  if (pressed <= 0) return Vector3d::Zero();
  Vector3d slip = u - normal * normal.dot(u);
  if (slip.norm() > pair.friction * pressed) slip *= pair.friction * pressed / slip.norm();
  return stiffness * (pressed * normal - slip);
}

std::vector<SelfContact> self_contacts(const ReferenceState& state, const StepInfo& info,
                                       const std::vector<PlacedBody>& bodies) {
  std::vector<SelfContact> contacts;
  if (!state.model.has_contacts_in_solve()) return contacts;
  const Vectors end = ends(state, info, bodies);
  std::vector<int> share(end.size(), 0);
  for (const Pair& pair : all_pairs(state)) {
    Four x, u;
    for (int k = 0; k < 4; ++k) {
      x[k] = vec(state.s.node_position[pair.node[k]]);
      u[k] = end[pair.node[k]] - x[k];
    }
    const std::optional<Near> near = touching(pair, x, u);
    if (!near || !(near->apart.norm() > 0)) continue;
    SelfContact c{pair, near->b, near->apart.normalized(), pair.target_gap(pair.thickness), 0};
    for (int k = 0; k < 4; ++k) {
      c.short_of -= c.b[k] * c.normal.dot(x[k] - x[0]);
      share[pair.node[k]] += c.b[k] != 0;
    }
    contacts.push_back(c);
  }
  for (SelfContact& c : contacts) {
    double mobility = 0;
    for (int k = 0; k < 4; ++k) {
      const Index n = c.pair.node[k];
      mobility += c.b[k] * c.b[k] * share[n] * inverse_node_mass(state, n);
    }
    c.stiffness = mobility > 0 ? kappa / (info.dt * info.dt * mobility) : 0;
  }
  return contacts;
}

}  // namespace drench::reference
