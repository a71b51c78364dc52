// Stage emission of the oracle; the law stands in src/stages/emission.hpp. The letters (a) to (e) are the law's.

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact_wicking.hpp"
#include "state/needed_fields.hpp"
#include "transfer.hpp"

namespace drench::reference {
namespace {

/// What one sample may emit, and what of it is left, in quanta.
struct Share {
  std::array<Quanta, 3> of_node{0, 0, 0};              // E_pk
  Quanta total = 0;                                    // E_p
  Quanta left = 0;                                     // E_p, then E′_p, then E″_p, then what stays
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // v^e_p, m/s
  std::array<Quanta, 3> solute_of_node{0, 0, 0};       // that goes with E_pk
  Quanta solute = 0, solute_left = 0;                  // that goes with E_p, and what is left of it
  bool blocked = false;                                // (b)
  bool steep = false;                                  // (d): its own layer lies ahead, or another one shuts it in
  bool closed() const { return blocked || steep || left == 0; }
  /// Of `quanta` of E_p: it leaves.
  Quanta take_solute(Quanta quanta) {
    const Quanta part = solute_part(solute, quanta, total);
    solute_left -= part;
    return part;
  }
};

/// Is there a direction, and with it a cone?
bool directed(const ReferenceState& state) { return state.model.scene.processes.direction; }

/// Square of the component of gravity normal to the fabric at node n, m²/s⁴, by its slope: Σ ω Δz² over the pairs of a
/// node is twice its area × sin².
double normal_pull(const ReferenceState& state, Index n) {
  const FabricPairs& fabric = state.model.fabric;
  const ClothMaterial& c = state.model.material_of_node(n);
  double steepness = 0;
  for (Index k = fabric.of_node.start[n]; k < fabric.of_node.start[n + 1]; ++k) {
    const Index e = fabric.of_node.item[k] / 2;
    const auto [i, j] = fabric.nodes[e];
    const double fall = (vec(state.s.node_position[i]) - vec(state.s.node_position[j])).dot(down(state));
    steepness += fabric.film[e] * fall * fall;
  }
  const double area = state.model.samples.node_capacity[n] / (state.model.rest_density * c.film_depth);
  return vec(state.model.scene.gravity).squaredNorm() * (1 - std::min(1.0, steepness / (2 * area)));
}

/// Does pressure drive liquid through a sample at node n?
bool passes(const ReferenceState& state, Index n) {
  for (Index p = 0; p < state.model.samples.count(); ++p)
    for (int k = 0; k < 3; ++k)
      if (sample_node(state, p, k) == n && is_driven(state, p)) return true;
  return false;
}

/// 1/s; of a film that hangs under a face the growth of its drops; `film` is what has not matured
/// (docs/theory/porous.md, Eq. 41).
double maturing_rate(const ReferenceState& state, Index n, Quanta film) {
  const Model& m = state.model;
  const ClothMaterial& c = m.material_of_node(n);
  const double fastest = c.emission_velocity / m.spacing;
  if (!m.has_films() || !(c.film_depth > 0)) return fastest;
  if (c.conductance > 0 && passes(state, n)) return std::numeric_limits<double>::infinity();
  if (m.fabric.hem[n]) return fastest;
  const double h = 0.5 * c.film_depth * static_cast<double>(film) * m.quantum / m.samples.node_capacity[n];
  return std::min(fastest, c.film_growth * normal_pull(state, n) * std::pow(h, 3));
}

void mature(ReferenceState& state, double dt) {
  const Model& m = state.model;
  for (Index n = 0; n < state.s.node_count(); ++n) {
    const Quanta capacity = floor_quanta(pore_capacity(state, n) / m.quantum);
    const Quanta excess = std::max<Quanta>(0, state.s.node_liquid[n] - capacity);
    Quanta& buffered = state.s.node_buffered[n];
    buffered = std::min(excess, buffered);
    const double rate = maturing_rate(state, n, excess - buffered);
    buffered += floor_quanta((1 - std::exp(-rate * dt)) * static_cast<double>(excess - buffered));
  }
}

Share share_of(const ReferenceState& state, Index p) {
  Share share;
  if (!is_porous(state, p)) return share;
  if (directed(state) && vec(state.s.sample_flow_direction[p]).norm() == 0) return share;
  const SampleSet& samples = state.model.samples;
  for (int k = 0; k < 3; ++k) {
    const Index n = sample_node(state, p, k);
    if (samples.node_weight_sum[n] == 0) continue;
    share.of_node[k] =
        floor_quanta(samples.weight[p][k] * static_cast<double>(state.s.node_buffered[n]) / samples.node_weight_sum[n]);
    if (state.model.has_solute())
      share.solute_of_node[k] = solute_part(state.s.node_solute[n], share.of_node[k], state.s.node_liquid[n]);
    share.solute += share.solute_of_node[k];
    share.total += share.of_node[k];
    share.velocity += static_cast<double>(share.of_node[k]) * vec(state.s.node_velocity[n]);
  }
  if (share.total > 0) share.velocity /= static_cast<double>(share.total);
  share.left = share.total;
  share.solute_left = share.solute;
  return share;
}

/// e_p: where liquid leaves.
Eigen::Vector3d way_out(const ReferenceState& state, Index p) {
  const Eigen::Vector3d flow = vec(state.s.sample_flow_direction[p]);
  if (flow.norm() == 0 || state.sample_boundary[p].empty() || is_driven(state, p)) return flow;
  return normalised_drive(state, p, virtual_pressure(state, p));
}

/// Where new particles appear from sample p.
Eigen::Vector3d outward(const ReferenceState& state, Index p) {
  if (directed(state)) return way_out(state, p);
  const Eigen::Vector3d gravity = vec(state.model.scene.gravity);
  return gravity / (1.001 * gravity.norm());
}

double cone_cosine(const ReferenceState& state, Index p) { return state.model.material_of_sample(p).emission_cosine; }

bool in_cone(const ReferenceState& state, Index p, const Eigen::Vector3d& x, double least_cosine) {
  const Eigen::Vector3d direction = way_out(state, p);
  const Eigen::Vector3d away = x - sample_position(state, p);
  const double r = away.norm();
  if (r <= 1e-9 * state.model.support) return false;
  if (!directed(state)) return true;
  if (direction.norm() == 0) return false;
  const double cosine = away.dot(direction) / (r * direction.norm());
  return cosine > least_cosine;
}

/// (a) Liquid in the cone is filled up to m_max.
void give_to_liquid(ReferenceState& state, std::vector<Share>& shares) {
  HostState& s = state.s;
  struct Offer {
    Index from, to;
    Quanta quanta;
  };
  std::vector<Offer> offers;
  std::vector<Quanta> offered(s.fluid_count(), 0);
  const auto room = [&](Index j) { return state.model.max_quanta - s.fluid_mass[j]; };
  for (Index p = 0; p < static_cast<Index>(shares.size()); ++p) {
    if (shares[p].total == 0) continue;
    std::vector<Index> takers;
    Quanta rooms = 0;
    for (const Index j : state.sample_fluid[p]) {
      if (room(j) <= 0 || !in_cone(state, p, vec(s.fluid_position[j]), cone_cosine(state, p))) continue;
      takers.push_back(j);
      rooms += room(j);
    }
    for (const Index j : takers) {
      const Quanta o = floor_quanta(static_cast<double>(shares[p].total) * static_cast<double>(room(j)) /
                                    static_cast<double>(rooms));
      offers.push_back({p, j, o});
      offered[j] += o;
    }
  }
  std::vector<Quanta> gained(s.fluid_count(), 0);
  Vectors momentum(s.fluid_count(), Eigen::Vector3d::Zero());  // quanta m/s
  for (const Offer& offer : offers) {
    const Index j = offer.to;
    Quanta accepted = offer.quanta;
    if (offered[j] > room(j)) {
      const double part = static_cast<double>(room(j)) / static_cast<double>(offered[j]);
      accepted = floor_quanta(static_cast<double>(offer.quanta) * part * (1 - 1e-9));
    }
    shares[offer.from].left -= accepted;
    count_on_face(state, offer.from, vec(s.fluid_position[j]), accepted, -1);
    if (state.model.has_solute()) s.fluid_solute[j] += shares[offer.from].take_solute(accepted);
    gained[j] += accepted;
    momentum[j] += static_cast<double>(accepted) * shares[offer.from].velocity;
  }
  for (Index j = 0; j < s.fluid_count(); ++j) {
    if (gained[j] == 0) continue;
    const double before = static_cast<double>(s.fluid_mass[j]);
    s.fluid_mass[j] += gained[j];
    s.fluid_velocity[j] = arr((before * vec(s.fluid_velocity[j]) + momentum[j]) / static_cast<double>(s.fluid_mass[j]));
  }
}

/// (d) Does something at x leave no room for a new particle before p?
bool shuts_in(const ReferenceState& state, Index p, const Eigen::Vector3d& x) {
  const Eigen::Vector3d way = way_out(state, p), apart = x - sample_position(state, p);
  if (way.norm() == 0) return false;
  const double ahead = apart.dot(way.normalized());
  return ahead > 0 && ahead < 1.5 * state.model.spacing &&
         (apart - ahead * way.normalized()).norm() < 0.75 * state.model.spacing;
}

/// (b) A solid in the cone lets nothing more out; a sample's own layer ahead of it, no new particle (d).
void block(const ReferenceState& state, std::vector<Share>& shares) {
  for (Index p = 0; p < static_cast<Index>(shares.size()); ++p) {
    if (shares[p].total == 0 || !directed(state)) continue;
    for (const Index b : state.sample_boundary[p]) {
      const Eigen::Vector3d x = vec(state.s.boundary_position[b]);
      if (is_driven(state, p) ? shuts_in(state, p, x) : in_cone(state, p, x, cone_cosine(state, p)))
        shares[p].blocked = true;
    }
    for (const Index q : state.sample_sample[p]) {
      const bool ahead = in_cone(state, p, sample_position(state, q), std::sqrt(0.75));  // 30°
      if (is_porous(state, q) && same_layer(state, p, q) && ahead) shares[p].steep = true;
      if (!same_layer(state, p, q) && shuts_in(state, p, sample_position(state, q))) shares[p].steep = true;
    }
  }
}

/// What the cloth receives, one value a sample.
struct Received {
  std::vector<Quanta> quanta, solute;
  std::vector<Momentum> momentum;
  std::vector<Split> split;
};

/// (c) Samples of other layers in the cone.
Received give_to_other_layers(const ReferenceState& state, std::vector<Share>& shares) {
  const Index samples = static_cast<Index>(shares.size());
  std::vector<std::vector<Index>> takers(samples);
  std::vector<Quanta> offer(samples, 0), in(samples, 0);
  for (Index p = 0; p < samples; ++p) {
    if (shares[p].blocked || shares[p].left == 0) continue;
    for (const Index q : state.sample_sample[p]) {
      if (!is_porous(state, q) || same_layer(state, p, q)) continue;
      if (!in_cone(state, p, sample_position(state, q), cone_cosine(state, p))) continue;
      takers[p].push_back(q);
    }
    if (takers[p].empty()) continue;
    offer[p] = shares[p].left / static_cast<Quanta>(takers[p].size());
    for (const Index q : takers[p]) in[q] += offer[p];
  }
  Received received{std::vector<Quanta>(samples, 0), std::vector<Quanta>(samples, 0),
                    std::vector<Momentum>(samples, Momentum{0, 0, 0}), inflow_split(state, in, true)};
  for (Index p = 0; p < samples; ++p) {
    for (const Index q : takers[p]) {
      const Quanta accepted = limited(offer[p], received.split[q].share);
      shares[p].left -= accepted;
      received.quanta[q] += accepted;
      received.solute[q] += shares[p].take_solute(accepted);
      add(received.momentum[q], momentum_of(static_cast<double>(accepted), shares[p].velocity));
    }
  }
  return received;
}

/// (d) The sample to which p points: the fullest one of itself and its neighbours in the layer.
Index fullest(const ReferenceState& state, const std::vector<Share>& shares, Index p) {
  Index best = p;
  for (const Index q : state.sample_sample[p]) {
    if (!is_porous(state, q) || !same_layer(state, p, q) || shares[q].closed()) continue;
    if (shares[q].left > shares[best].left || (shares[q].left == shares[best].left && q < best)) best = q;
  }
  return best;
}

/// A particle that may come into being at a collector.
struct Candidate {
  Quanta sum = 0;  // S
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::vector<Index> givers;
  bool driven = false;  // by pressure, which may push it into liquid
};

/// (d) Candidates, in the order of their collectors' indices.
std::vector<Candidate> candidates(const ReferenceState& state, const std::vector<Share>& shares) {
  const Model& m = state.model;
  const Index samples = static_cast<Index>(shares.size());
  std::vector<Index> target(samples, -1);
  for (Index p = 0; p < samples; ++p) {
    if (!shares[p].closed()) target[p] = fullest(state, shares, p);
  }
  std::vector<Candidate> pools(samples);
  for (Index p = 0; p < samples; ++p) {
    if (target[p] < 0 || target[target[p]] != target[p]) continue;
    pools[target[p]].sum += shares[p].left;
    pools[target[p]].givers.push_back(p);
  }
  std::vector<Candidate> result;
  for (Index p = 0; p < samples; ++p) {
    if (pools[p].givers.empty() || pools[p].sum < m.min_quanta) continue;
    const double fill = static_cast<double>(std::min(pools[p].sum, m.max_quanta)) / quanta_per_particle;
    pools[p].position = sample_position(state, p) + 0.5 * m.spacing * (1 + std::cbrt(fill)) * outward(state, p);
    pools[p].driven = is_driven(state, p);
    result.push_back(pools[p]);
  }
  return result;
}

/// (d) New particles where there is room for them.
void create_particles(ReferenceState& state, std::vector<Share>& shares) {
  const Model& m = state.model;
  if (!directed(state) && vec(m.scene.gravity).norm() == 0) return;  // nowhere to go
  const std::vector<Candidate> found = candidates(state, shares);
  const Index old_particles = state.s.fluid_count();
  const Smoothing smoothing(m);
  for (std::size_t c = 0; c < found.size(); ++c) {
    const Eigen::Vector3d& x = found[c].position;
    bool crowded = false;
    double filled = 0;  // Σ_j V_j W
    for (Index i = 0; i < old_particles; ++i) {
      const double r = (vec(state.s.fluid_position[i]) - x).norm();
      crowded = crowded || r < 0.5 * m.spacing;
      if (r < m.support) filled += fluid_volume(state, i) * smoothing.value(r);
    }
    crowded = crowded || (filled > 0.5 && !found[c].driven);
    for (std::size_t other = 0; other < c; ++other) {
      crowded = crowded || (found[other].position - x).norm() < 0.5 * m.spacing;
    }
    if (crowded) continue;
    Quanta mass = 0, solute = 0;
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero();  // quanta m/s
    for (const Index p : found[c].givers) {
      Quanta part = shares[p].left;
      if (found[c].sum > m.max_quanta) {
        part = floor_quanta(static_cast<double>(part) * static_cast<double>(m.max_quanta) /
                            static_cast<double>(found[c].sum));
      }
      shares[p].left -= part;
      count_on_face(state, p, x, part, -1);
      mass += part;
      solute += shares[p].take_solute(part);
      momentum += static_cast<double>(part) * shares[p].velocity;
    }
    append_particle(state.s, m, {arr(x), arr(momentum / static_cast<double>(mass)), mass, Origin::cloth, solute});
  }
}

/// By what goes with E_pk, the remainder in the order of the corners.
void take_solute_from_nodes(ReferenceState& state, Index p, const Share& share) {
  const Quanta given = share.solute - share.solute_left;
  if (given == 0) return;
  std::array<Quanta, 3> part;
  Quanta rest = given;
  for (int k = 0; k < 3; ++k) rest -= part[k] = solute_part(given, share.solute_of_node[k], share.solute);
  for (int k = 0; k < 3; ++k) {
    const Quanta more = std::min(rest, share.solute_of_node[k] - part[k]);
    rest -= more;
    state.s.node_solute[sample_node(state, p, k)] -= part[k] + more;
  }
}

/// Takes what sample p gave from its nodes. It left with the mean velocity of unrounded parts; what a whole part is
/// more leaves its momentum behind.
void take_from_nodes(ReferenceState& state, Index p, const Share& share) {
  const Quanta given = share.total - share.left;
  if (given == 0) return;
  take_solute_from_nodes(state, p, share);
  std::array<Quanta, 3> part;
  Quanta rest = given;
  for (int k = 0; k < 3; ++k) {
    part[k] = floor_quanta(static_cast<double>(given) * static_cast<double>(share.of_node[k]) /
                           static_cast<double>(share.total));
    rest -= part[k];
  }
  for (int k = 0; k < 3; ++k) {
    const Quanta more = std::min(rest, share.of_node[k] - part[k]);
    rest -= more;
    const Index n = sample_node(state, p, k);
    state.s.node_liquid[n] -= part[k] + more;
    state.s.node_buffered[n] -= part[k] + more;
    if (state.model.mesh.is_fixed(n)) continue;
    const double unrounded =
        static_cast<double>(given) * static_cast<double>(share.of_node[k]) / static_cast<double>(share.total);
    const double behind = (static_cast<double>(part[k] + more) - unrounded) * state.model.quantum;  // kg
    state.s.node_velocity[n] = arr(vec(state.s.node_velocity[n]) * (1 + behind / node_mass(state, n)));
  }
}

}  // namespace

void emission(ReferenceState& state, const StepInfo& info, StepReport&) {
  mature(state, info.dt);
  const Index samples = state.model.samples.count();
  std::vector<Share> shares(samples);
  for (Index p = 0; p < samples; ++p) shares[p] = share_of(state, p);

  give_to_liquid(state, shares);
  block(state, shares);
  const Received received = give_to_other_layers(state, shares);
  create_particles(state, shares);
  for (Index p = 0; p < samples; ++p) take_from_nodes(state, p, shares[p]);
  give_solute_to_nodes(state, received.solute, received.quanta, received.split);
  give_to_nodes(state, received.quanta, received.momentum, received.split, info.dt);
}

}  // namespace drench::reference
