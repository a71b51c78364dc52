// Contact wicking of the oracle, a part of stage diffusion; laws 4–6 stand in src/stages/diffusion.hpp.

#include "contact_wicking.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>

#include "proximity.hpp"
#include "transfer.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

struct Touch {
  Index triangle;
  Near near;
};

/// Triangles that law 4 lets sample p touch.
std::set<Index> candidates(const ReferenceState& state, Index p) {
  const Model& m = state.model;
  const auto& own = m.mesh.triangle[m.samples.triangle[p]];
  std::set<Index> found;
  for (const Index q : state.sample_sample[p]) {
    if (!m.cloths[m.samples.cloth[q]].wicks_through_contact()) continue;
    const auto& corner = m.mesh.triangle[m.samples.triangle[q]];
    const auto joint = [&](Index n) { return m.mesh.joint.empty() ? n : m.mesh.joint[n]; };  // sewn nodes count as one
    const bool neighbors = std::any_of(own.begin(), own.end(), [&](Index n) {
      return std::any_of(corner.begin(), corner.end(), [&](Index other) { return joint(other) == joint(n); });
    });
    if (!neighbors) found.insert(m.samples.triangle[q]);
  }
  return found;
}

double lesser_height(const ClothMaterial& a, const ClothMaterial& b) {
  return std::min(a.capillary_height, b.capillary_height);
}

/// K, kg/(m² s).
double conductance(const Model& m, const ClothMaterial& a, const ClothMaterial& b, double dt) {
  const auto load = [&](const ClothMaterial& c) { return m.rest_density * (1 - c.solid_fraction) * c.thickness; };
  const auto height = [&](const ClothMaterial& c) { return c.capillary_height / lesser_height(a, b); };
  const auto resistance = [&](const ClothMaterial& c) {
    return height(c) * 0.5 * c.thickness / (m.rest_density * (1 - c.solid_fraction) * c.diffusivity);
  };
  const auto most = [](const ClothMaterial& c) { return c.film_depth > 0 ? 1 : c.max_saturation; };
  const auto steepest = [&](const ClothMaterial& c) {  // of r (1 − h/ℓ)
    const double beta = c.retention_exponent, slope = beta > 1 ? beta * std::pow(most(c), beta - 1) : 1;
    const double small = 1 - c.large_pores;
    if (!c.flows_by_suction()) return height(c) * slope;
    if (!c.has_hysteresis()) return height(c) * std::max(slope, beta / small);
    return height(c) *
           (std::max(slope, beta * steepening(c) / small) + std::max(1.0, c.diffusion_exponent) * suction_jump(c));
  };
  const double n = std::max(a.diffusion_exponent, b.diffusion_exponent);
  const double growth = n > 1 ? std::pow(std::max(most(a), most(b)), n - 1) : 1;
  return std::min(1 / (resistance(a) + resistance(b)),
                  0.25 * std::min(load(a) / steepest(a), load(b) / steepest(b)) / (dt * growth));
}

/// What an end holds: its saturation, and r (1 − h/ℓ).
struct Held {
  double saturation = 0, suction = 0;
};

/// kg/s, into the near end: both ends' suctions over the lesser ℓ, and the mean of sⁿ between them.
double flux_of(const LayerContact& c, const Held& at_near, const Held& at_far) {
  const double near = at_near.saturation, far = at_far.saturation;
  const double drive = at_far.suction - at_near.suction + c.drop;
  return c.conductance * static_cast<double>(drive * mobility(near, far, drive > 0 ? far : near, c.exponent));
}

}  // namespace

std::vector<LayerContact> touching_layers(const ReferenceState& state, double dt) {
  const Model& m = state.model;
  std::vector<LayerContact> contacts;
  if (!m.has_contact_wicking()) return contacts;
  const auto x = [&](Index n) { return vec(state.s.node_position[n]); };
  for (Index p = 0; p < m.samples.count(); ++p) {
    const ClothMaterial& own = m.material_of_sample(p);
    if (!own.wicks_through_contact()) continue;
    const auto& corner = m.mesh.triangle[m.samples.triangle[p]];
    const Vector3d normal = (x(corner[1]) - x(corner[0])).cross(x(corner[2]) - x(corner[0])).normalized();
    std::array<std::optional<Touch>, 2> best;
    for (const Index t : candidates(state, p)) {
      const auto& other = m.mesh.triangle[t];
      const Near near = near_triangle({sample_position(state, p), x(other[0]), x(other[1]), x(other[2])});
      const double distance = near.apart.norm(), height = near.apart.dot(normal);
      const double thickness = 0.5 * (own.thickness + m.material_of_triangle(t).thickness);
      if (distance == 0 || distance > 1.5 * thickness || std::abs(height) < distance * std::sqrt(0.5)) continue;
      std::optional<Touch>& touch = best[height > 0 ? 0 : 1];
      if (!touch || distance < touch->near.apart.norm()) touch = Touch{t, near};
    }
    for (const auto& touch : best) {
      if (!touch) continue;
      const ClothMaterial& other = m.material_of_triangle(touch->triangle);
      const auto& b = touch->near.b;
      const double least = lesser_height(own, other);
      contacts.push_back(
          {corner,
           m.mesh.triangle[touch->triangle],
           m.samples.weight[p],
           {-b[1], -b[2], -b[3]},
           0.5 * m.samples.area[p] * conductance(m, own, other, dt),
           touch->near.apart.dot(down(state)) / least + (own.capillary_height - other.capillary_height) / least,
           std::max(own.diffusion_exponent, other.diffusion_exponent),
           {own.capillary_height / least, other.capillary_height / least},
           {own.retention_exponent, other.retention_exponent}});
    }
  }
  return contacts;
}

void wick_through(ReferenceState& state, const std::vector<LayerContact>& contacts, double dt) {
  if (contacts.empty()) return;
  std::vector<Quanta> out(state.s.node_count(), 0), in(out), offer(contacts.size());
  std::vector<bool> inward(contacts.size());  // to the sample
  const auto held = [&](const LayerContact& contact, int side) {
    const std::array<Index, 3>& node = side == 0 ? contact.near_node : contact.far_node;
    const std::array<double, 3>& weight = side == 0 ? contact.near_weight : contact.far_weight;
    double sum = 0, scanned = 0;
    bool by_suction = false;
    for (int k = 0; k < 3; ++k) {
      if (state.model.samples.node_capacity[node[k]] == 0) continue;
      const double s =
          static_cast<double>(state.s.node_liquid[node[k]]) * state.model.quantum / pore_capacity(state, node[k]);
      const ClothMaterial& c = state.model.material_of_node(node[k]);
      const double most = state.node_pores.empty() ? s : c.max_saturation;
      sum += weight[k] * std::min(s, c.film_depth > 0 ? 1.0 : most);
      by_suction = c.flows_by_suction();
      if (by_suction) scanned += weight[k] * (1 - suction(state, node[k]) / c.capillary_height);
    }
    const double power = contact.power[side];
    if (!by_suction) scanned = power == 1 ? sum : std::pow(std::max(0.0, sum), power);
    return Held{sum, contact.height[side] * scanned};
  };
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const LayerContact& contact = contacts[c];
    const double flux = flux_of(contact, held(contact, 0), held(contact, 1));
    inward[c] = flux > 0;
    offer[c] = offered_quanta(std::abs(flux) * dt / state.model.quantum);
    if (offer[c] == 0) continue;
    for (int k = 0; k < 3; ++k) {
      (inward[c] ? in : out)[contact.near_node[k]] +=
          floor_quanta(contact.near_weight[k] * static_cast<double>(offer[c])) + 1;
      (inward[c] ? out : in)[contact.far_node[k]] +=
          floor_quanta(contact.far_weight[k] * static_cast<double>(offer[c])) + 1;
    }
  }
  const std::vector<double> phi_out = outflow_limit(state, out), phi_in = room_limit(state, in);
  const Vectors velocity = node_velocities(state);
  Vectors gained(state.s.node_count(), Vector3d::Zero());  // quanta · m/s
  const std::vector<Quanta> liquid = state.s.node_liquid, solute = state.s.node_solute;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (offer[c] == 0) continue;
    const LayerContact& contact = contacts[c];
    double share = 1;
    for (int k = 0; k < 3; ++k) {
      if (contact.near_weight[k] > 0) share = std::min(share, (inward[c] ? phi_in : phi_out)[contact.near_node[k]]);
      if (contact.far_weight[k] > 0) share = std::min(share, (inward[c] ? phi_out : phi_in)[contact.far_node[k]]);
    }
    const Quanta moved = limited(offer[c], share);
    const auto near = split_over_nodes(contact.near_weight, moved), far = split_over_nodes(contact.far_weight, moved);
    for (int k = 0; k < 3; ++k) {
      state.s.node_liquid[contact.near_node[k]] += inward[c] ? near[k] : -near[k];
      state.s.node_liquid[contact.far_node[k]] -= inward[c] ? far[k] : -far[k];
    }
    if (moved == 0) continue;
    const auto& [donor, receiver] =
        inward[c] ? std::tie(contact.far_node, contact.near_node) : std::tie(contact.near_node, contact.far_node);
    const auto& [given, taken] = inward[c] ? std::tie(far, near) : std::tie(near, far);
    if (state.model.has_solute()) {
      Quanta sum = 0;
      for (int k = 0; k < 3; ++k) {
        const Quanta part = solute_part(solute[donor[k]], given[k], liquid[donor[k]]);
        state.s.node_solute[donor[k]] -= part;
        sum += part;
      }
      const std::array<Quanta, 3> parts = split_solute(sum, taken);
      for (int k = 0; k < 3; ++k) state.s.node_solute[receiver[k]] += parts[k];
    }
    Vector3d carried = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) carried += static_cast<double>(given[k]) * velocity[donor[k]];
    carried /= static_cast<double>(moved);
    for (int k = 0; k < 3; ++k)
      gained[receiver[k]] += static_cast<double>(taken[k]) * (carried - velocity[receiver[k]]);
  }
  change_velocities(state, gained);
}

}  // namespace drench::reference
