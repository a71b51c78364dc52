// Stage diffusion of the oracle; the law stands in src/stages/diffusion.hpp.

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact_wicking.hpp"
#include "pipeline/substeps.hpp"
#include "state/film.hpp"
#include "transfer.hpp"

namespace drench::reference {
namespace {

/// Two nodes that exchange liquid.
struct Pair {
  Index first, second;
  double conductance;  // G, kg/s
  double drop;         // (x_first − x_second)·ĝ/ℓ, 1: above 0 if the first is the lower one
  double film;         // ω of a film
  double rest_square;  // m², of its length at rest; 0: a stitch, or pores do not narrow
};

const ClothMaterial& material(const ReferenceState& state, Index n) { return state.model.material_of_node(n); }

/// s_n of the pores, 1: at most what the law of diffusion is bounded for, also where they are pressed.
double saturation(const ReferenceState& state, Index n) {
  const double s = static_cast<double>(state.s.node_liquid[n]) * state.model.quantum / pore_capacity(state, n);
  return state.node_pores.empty() ? s : std::min(s, material(state, n).max_saturation);
}
/// The same without what a film holds.
double pore_saturation(const ReferenceState& state, Index n) {
  return material(state, n).film_depth > 0 ? std::min(1.0, saturation(state, n)) : saturation(state, n);
}
/// What pressure has left no room for, of what the pores hold under it, 1.
double squeezed_out(const ReferenceState& state, Index n) {
  const Quanta most = floor_quanta(most_liquid(state, n) / state.model.quantum),
               above = std::max<Quanta>(0, state.s.node_liquid[n] - most);
  return state.node_pores.empty() ? 0 : static_cast<double>(above) * state.model.quantum / pore_capacity(state, n);
}
/// The thickness of the film on both faces, m.
double film_thickness(const ReferenceState& state, Index n) {
  const double beyond = static_cast<double>(state.s.node_liquid[n]) * state.model.quantum - pore_capacity(state, n);
  return material(state, n).film_depth * std::max(0.0, beyond / state.model.samples.node_capacity[n]);
}

/// A main curve of retention: pores of one or two kinds that hold liquid up to a height each.
struct MainCurve {
  double height, large_height, exponent, large;  // ℓ and ℓ₂ of it, m; β, w

  double filling(double suction, double of_height) const {
    return std::pow(std::max(0.0, 1 - suction / of_height), 1 / exponent);
  }
  double saturation(double suction) const {
    return (1 - large) * filling(suction, height) + (large > 0 ? large * filling(suction, large_height) : 0);
  }
  /// h at a saturation of 1 at most, m, by halving.
  double suction(double s) const {
    if (large == 0) return height * (1 - std::pow(std::max(0.0, s), exponent));
    double low = 0, high = height;
    for (int k = 0; k < 100; ++k) {
      const double middle = (low + high) / 2;
      (saturation(middle) > s ? low : high) = middle;
    }
    return (low + high) / 2;
  }
};
MainCurve wetting_curve(const ClothMaterial& c) {
  return {c.capillary_height, c.large_pore_height, c.retention_exponent, c.large_pores};
}
MainCurve drainage_curve(const ClothMaterial& c) {
  return {c.drainage_height, c.large_pore_height * c.drainage_height / c.capillary_height,
          c.drainage_exponent > 0 ? c.drainage_exponent : c.retention_exponent, c.large_pores};
}

/// The suction as a height of liquid, m, with hysteresis on the node's own curve (docs/theory/porous.md, Eq. 47).
double suction(const ClothMaterial& c, double s, double curve) {
  if (s >= 1) return c.capillary_height * (1 - std::pow(s, c.retention_exponent));
  if (curve < 0) return s < -curve ? drainage_curve(c).suction(s / -curve) : 0;
  return wetting_curve(c).suction(std::max(0.0, 1 - (1 - s) / (curve > 0 ? curve : 1)));
}

/// Which curve each node is on in this sub-step.
void turn_nodes(ReferenceState& state) {
  constexpr double turning = 1e-3;
  for (Index n = 0; n < state.s.node_count(); ++n) {
    const ClothMaterial& c = material(state, n);
    if (!c.has_hysteresis() || !(state.model.samples.node_capacity[n] > 0)) continue;
    double &curve = state.s.node_scanning[n], &extreme = state.s.node_extreme[n];
    const double s = pore_saturation(state, n);
    if (curve == 0 || s >= 1) {  // it begins, or is full, and has no history
      curve = 1;
      extreme = s;
    }
    const bool drains = curve < 0;
    if (drains ? s <= extreme : s >= extreme) {
      extreme = s;
    } else if (!drains && s <= extreme - turning) {
      const double at = std::min(1.0, extreme);
      curve = -std::min(1.0, at / drainage_curve(c).saturation(suction(c, at, curve)));
      extreme = s;
    } else if (drains && s >= extreme + turning) {
      const double wet = wetting_curve(c).saturation(suction(c, extreme, curve));
      curve = wet < 1 ? std::min(1.0, (1 - extreme) / (1 - wet)) : 1;
      extreme = s;
    }
  }
}

std::vector<Pair> exchanging_pairs(const ReferenceState& state) {
  const Model& m = state.model;
  std::vector<Pair> pairs;
  for (std::size_t e = 0; e < m.fabric.weight.size(); ++e) {
    const auto [i, j] = m.fabric.nodes[e];
    if (m.samples.node_capacity[i] == 0 || m.samples.node_capacity[j] == 0) continue;
    const ClothMaterial& c = m.cloths[m.mesh.node_cloth[i]];                    // the weight knows of regions
    const double load = m.rest_density * (1 - c.solid_fraction) * c.thickness;  // kg/m² at saturation 1
    const Eigen::Vector3d apart = vec(state.s.node_position[i]) - vec(state.s.node_position[j]);
    pairs.push_back({i, j, load * c.diffusivity * m.fabric.weight[e], apart.dot(down(state)) / c.capillary_height,
                     m.fabric.film.empty() ? 0 : m.fabric.film[e],
                     m.fabric.rest_square.empty() ? 0 : m.fabric.rest_square[e]});
  }
  return pairs;
}

/// ν of every node: by what its pores are finer where the fabric is stretched (docs/theory/porous.md, Eq. 53).
std::vector<double> pore_narrowing(const ReferenceState& state, const std::vector<Pair>& pairs) {
  const Index nodes = state.s.node_count();
  std::vector<double> narrowing(nodes, 1.0), now(nodes, 0.0), rest(nodes, 0.0);
  if (!state.model.has_narrowing()) return narrowing;
  for (const Pair& pair : pairs) {
    if (!(pair.rest_square > 0)) continue;
    const double square =
        (vec(state.s.node_position[pair.first]) - vec(state.s.node_position[pair.second])).squaredNorm();
    for (const Index n : {pair.first, pair.second}) {
      now[n] += pair.conductance * square;
      rest[n] += pair.conductance * pair.rest_square;
    }
  }
  for (Index n = 0; n < nodes; ++n)
    if (rest[n] > 0)
      narrowing[n] = std::clamp(1 + material(state, n).pore_narrowing * (now[n] / rest[n] - 1), 0.25, 4.0);
  return narrowing;
}
/// Factor on what a pair conducts.
double thinning(const std::vector<double>& narrowing, const Pair& pair) {
  return 2 / (std::pow(narrowing[pair.first], 2) + std::pow(narrowing[pair.second], 2));
}

/// Of the film that runs from one node to the other, kg/s, positive to the first: docs/theory/porous.md, Eq. 39. δ is
/// the film's thickness on both faces of the upper node.
double film_flux(const ReferenceState& state, const Pair& pair) {
  const ClothMaterial& c = material(state, pair.first);
  if (!(c.film_depth > 0) || pair.drop == 0) return 0;
  const Index upper = pair.drop > 0 ? pair.second : pair.first;
  const double delta = std::min(film_thickness(state, upper), 2 * c.film);  // what hangs at a hem is thicker
  return pair.film * c.film_flow * std::pow(delta, 3) * pair.drop * c.capillary_height;
}

/// What the flux of the thickest film grows by with the saturation, kg/s.
double steepest_film(const ReferenceState& state, const Pair& pair) {
  const ClothMaterial& c = material(state, pair.first);
  const double most = 2 * c.film, drop = std::abs(pair.drop) * c.capillary_height;
  return pair.film * c.film_flow * 3 * most * most * c.film_depth * drop;
}

/// What a pair conducts at most of a difference of saturation and of height: docs/theory/porous.md, Eqs. 19, 49 and 52.
std::pair<double, double> conducts_at_most(const ClothMaterial& c) {
  const double e = c.diffusion_exponent, beta = c.retention_exponent, top = c.pore_saturation();
  const double above = std::pow(top, e + beta - 1), steep = std::max(1.0, e * std::pow(top, e - 1));
  if (c.has_large_pores()) {
    const double narrowing = c.capillary_height / c.large_pore_height, w = c.large_pores;
    const double full = 1 - w + w * narrowing * narrowing, height = narrowing * narrowing * steep;
    double most = c.has_hysteresis() ? full * steepening(c) / (1 - w) : narrowing;
    if (top > 1) most = std::max(most, full * above);
    // Large pores that are full beside empty ones conduct as the mean of the power does.
    const double jump = c.has_hysteresis()
                            ? height * suction_jump(c)
                            : narrowing * narrowing / (e + 1) * std::max(1.0, above) * (1 - 1 / narrowing);
    return {beta * most + jump, height};
  }
  if (c.has_hysteresis()) return {beta * std::max(above, steepening(c)) + steep * suction_jump(c), steep};
  if (beta != 1) return {beta * above, std::max(1.0, (e + beta) * std::pow(top, std::max(0.0, e - 1)))};
  return {beta * above, steep};
}

/// The largest of the nodes, 1/s.
double exchange_rate(const ReferenceState& state, const std::vector<Pair>& pairs,
                     const std::vector<double>& narrowing) {
  std::vector<double> rate(state.s.node_count(), 0.0);  // 1/s
  for (const Pair& pair : pairs) {
    const ClothMaterial& c = material(state, pair.first);
    const auto [most, steep] = conducts_at_most(c);
    const double one = narrowing[pair.first], other = narrowing[pair.second];
    const double height = std::abs(pair.drop) + std::abs(one - other);
    for (const Index n : {pair.first, pair.second})
      rate[n] += (pair.conductance * thinning(narrowing, pair) * (most * std::max(one, other) + steep * height) +
                  steepest_film(state, pair)) /
                 pore_capacity(state, n);
  }
  return rate.empty() ? 0 : *std::max_element(rate.begin(), rate.end());
}

/// What drives liquid to the first node times the mobility, 1: by suction.
double by_suction(const ReferenceState& state, const Pair& pair, const std::vector<double>& narrowing) {
  const ClothMaterial& c = material(state, pair.first);
  const auto drawn = [&](Index n) { return narrowing[n] * suction(state, n); };
  const double drive = (drawn(pair.first) - drawn(pair.second)) / c.capillary_height + pair.drop;
  const double receiver = pore_saturation(state, pair.first), donor = pore_saturation(state, pair.second);
  if (!c.has_large_pores())
    return static_cast<double>(drive * mobility(receiver, donor, drive > 0 ? donor : receiver, c.diffusion_exponent));
  // Pores of both sizes conduct side by side, as the square of their size.
  const MainCurve curve = wetting_curve(c);
  long double sum = 0;
  for (const double height : {curve.height, curve.large_height}) {
    const auto full = [&](double s) { return s >= 1 ? s : curve.filling(curve.suction(s), height); };
    const double share = height == curve.height ? 1 - curve.large : curve.large, size = curve.height / height;
    sum += share * size * size *
           mobility(full(receiver), full(donor), full(drive > 0 ? donor : receiver), c.diffusion_exponent);
  }
  return static_cast<double>(drive * sum);
}

/// One of n sub-steps of the step dt.
void exchange_once(ReferenceState& state, const std::vector<Pair>& pairs, const std::vector<double>& narrowing,
                   double dt, int n) {
  const Index nodes = state.s.node_count();
  std::vector<Quanta> offer(pairs.size());
  std::vector<bool> to_first(pairs.size());
  std::vector<Quanta> out(nodes, 0), in(nodes, 0);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Pair& pair = pairs[k];
    const ClothMaterial& c = material(state, pair.first);
    const auto held = [&](Index at) {
      const double s = pore_saturation(state, at);
      return c.retention_exponent == 1 ? s : std::pow(std::max(0.0, s), c.retention_exponent);
    };
    const double pores = c.flows_by_suction() ? thinning(narrowing, pair) * by_suction(state, pair, narrowing)
                                              : driven(held(pair.first), held(pair.second), pair.drop,
                                                       c.diffusion_exponent / c.retention_exponent);
    const double flux = pair.conductance * pores + film_flux(state, pair) +
                        pair.conductance * (squeezed_out(state, pair.second) - squeezed_out(state, pair.first));
    to_first[k] = flux > 0;
    const bool dry = state.s.node_liquid[to_first[k] ? pair.second : pair.first] == 0;
    offer[k] = dry ? 0 : offered_quanta(std::abs(flux) * dt / (n * state.model.quantum));
    out[to_first[k] ? pair.second : pair.first] += offer[k];
    in[to_first[k] ? pair.first : pair.second] += offer[k];
  }
  const std::vector<double> phi_out = outflow_limit(state, out), phi_in = room_limit(state, in);
  const Vectors velocity = node_velocities(state);
  Vectors gained(nodes, Eigen::Vector3d::Zero());  // Σ_in t (v_donor − v_n), quanta · m/s
  const std::vector<Quanta> liquid = state.s.node_liquid, solute = state.s.node_solute;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Index donor = to_first[k] ? pairs[k].second : pairs[k].first;
    const Index receiver = to_first[k] ? pairs[k].first : pairs[k].second;
    const Quanta moved = limited(offer[k], std::min(phi_out[donor], phi_in[receiver]));
    if (state.model.has_solute()) {
      const Quanta carried = solute_part(solute[donor], moved, liquid[donor]);
      state.s.node_solute[donor] -= carried;
      state.s.node_solute[receiver] += carried;
    }
    state.s.node_liquid[donor] -= moved;
    state.s.node_liquid[receiver] += moved;
    gained[receiver] += static_cast<double>(moved) * (velocity[donor] - velocity[receiver]);
  }
  change_velocities(state, gained);
}

}  // namespace

double steepening(const ClothMaterial& c) {
  const double ratio = c.drainage_height / c.capillary_height, own = drainage_curve(c).exponent;
  return std::max(1 / (1 - std::pow(1 - 1 / ratio, 1 / own)), ratio * own / c.retention_exponent);
}

double suction_jump(const ClothMaterial& c) {
  const double ratio = c.drainage_height / c.capillary_height;
  if (c.has_large_pores()) return ratio;
  const double k = drainage_curve(c).exponent / c.retention_exponent;
  return ratio - 1 + (k > 1 ? std::pow(k, 1 / (1 - k)) * (k - 1) / k : 0);
}

double suction(const ReferenceState& state, Index n) {
  const double curve = state.s.node_scanning.empty() ? 1 : state.s.node_scanning[n];
  return suction(material(state, n), pore_saturation(state, n), curve);
}

Eigen::Vector3d down(const ReferenceState& state) {
  const Eigen::Vector3d gravity = vec(state.model.scene.gravity);
  return gravity.norm() > 0 ? Eigen::Vector3d(gravity.normalized()) : Eigen::Vector3d::Zero();
}

Vectors node_velocities(const ReferenceState& state) {
  Vectors velocity;
  for (const Vec3& v : state.s.node_velocity) velocity.push_back(vec(v));
  return velocity;
}

void change_velocities(ReferenceState& state, const Vectors& gained) {
  for (Index n = 0; n < state.s.node_count(); ++n) {
    if (state.model.mesh.is_fixed(n) || gained[n].isZero(0)) continue;
    const Eigen::Vector3d change = gained[n] * state.model.quantum / node_mass(state, n);
    state.s.node_velocity[n] = arr(vec(state.s.node_velocity[n]) + change);
  }
}

long double mobility(double one, double other, double donor, double n) {
  const long double a = std::max(0.0, one), b = std::max(0.0, other), given = std::max(0.0, donor), power = n;
  // The mean of sⁿ between both, in numbers wide enough for the difference of nearly equal powers.
  const bool apart = std::abs(a - b) > 1e-8L * (a + b);
  const long double mean = apart ? (std::pow(b, power + 1) - std::pow(a, power + 1)) / ((power + 1) * (b - a))
                                 : std::pow((a + b) / 2, power);
  return std::min(mean, 2 * std::pow(given, power));
}

double driven(double receiver, double donor, double drop, double n) {
  const double drive = donor - receiver + drop;
  return static_cast<double>(drive * mobility(receiver, donor, drive > 0 ? donor : receiver, n));
}

std::vector<double> outflow_limit(const ReferenceState& state, const std::vector<Quanta>& out) {
  std::vector<double> phi(state.s.node_count(), 1.0);
  for (Index n = 0; n < state.s.node_count(); ++n) {
    const Quanta have = std::max<Quanta>(0, state.s.node_liquid[n] - (out[n] >> 16) - 1024);
    if (out[n] > have) phi[n] = static_cast<double>(have) / static_cast<double>(out[n]);
  }
  return phi;
}

std::vector<double> room_limit(const ReferenceState& state, const std::vector<Quanta>& in) {
  const Model& m = state.model;
  std::vector<double> phi(state.s.node_count(), 1.0);
  for (Index n = 0; n < state.s.node_count(); ++n) {
    const Quanta full = floor_quanta(most_liquid(state, n) / m.quantum);
    const Quanta room = std::max<Quanta>(0, full - state.s.node_liquid[n] - (in[n] >> 16) - 1024);
    if (in[n] > room) phi[n] = static_cast<double>(room) / static_cast<double>(in[n]);
  }
  for (const Reservoir& r : m.reservoirs)
    for (const Index n : r.nodes) phi[n] = 1;
  return phi;
}

void diffusion(ReferenceState& state, const StepInfo& info, StepReport& report) {
  const std::vector<Pair> pairs = exchanging_pairs(state);
  const std::vector<double> narrowing = pore_narrowing(state, pairs);
  const int n = diffusion_substeps_within_limit(exchange_rate(state, pairs, narrowing), info, report);
  const std::vector<LayerContact> contacts = touching_layers(state, info.dt / n);
  for (int k = 0; k < n; ++k) {
    if (state.model.has_hysteresis()) turn_nodes(state);
    exchange_once(state, pairs, narrowing, info.dt, n);
    wick_through(state, contacts, info.dt / n);
    if (k + 1 < n) reservoir(state, info, report);
  }
  report.diffusion_substeps = n;
}

}  // namespace drench::reference
