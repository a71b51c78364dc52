#pragma once
// Exact transfers of mass and momentum in the porous stages: integer quanta, and momentum in fixed point. Integer sums
// do not depend on their order, so nothing is lost or gained.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common.hpp"
#include "sheets.hpp"

namespace drench::reference {

/// A fixed-point momentum, in units of q · 2^-8 m/s.
using Momentum = std::array<std::int64_t, 3>;
inline constexpr double momentum_steps = 256;

/// The largest integer that is not above x, which must fit into 64 bits.
inline Quanta floor_quanta(double x) { return static_cast<Quanta>(std::floor(x)); }
/// What a flow offers: at most 2⁵⁶, so that the offers of many add up. No node holds as much.
inline Quanta offered_quanta(double x) { return floor_quanta(std::min(x, 0x1p56)); }

/// Momentum of a mass (in quanta; a fraction is allowed) at a velocity (m/s), rounded per component.
Momentum momentum_of(double quanta, const Eigen::Vector3d& velocity);
void add(Momentum& sum, const Momentum& part);

/// A sample's quanta over its three nodes: floor(w_k t) each, the remainder to the largest weight (first of equals).
std::array<Quanta, 3> split_over_nodes(const std::array<double, 3>& weight, Quanta quanta);

/// The solute of `part` of a holder's liquid: floor(S part / M), exactly; all of it with all.
Quanta solute_part(Quanta solute, Quanta part, Quanta liquid);

/// A sum of solute over three parts of liquid that bring it: by those, the remainder to the largest (first of equals).
std::array<Quanta, 3> split_solute(Quanta solute, const std::array<Quanta, 3>& part);

/// Σ_p floor(w_pn a_p), one value a node: what samples offer, seen by the nodes.
std::vector<Quanta> gather_at_nodes(const ReferenceState& state, const std::vector<Quanta>& at_samples);

/// The whole offer where nothing limits it, else its part φ, rounded down.
inline Quanta limited(Quanta offer, double phi) {
  return phi == 1 ? offer : floor_quanta(static_cast<double>(offer) * phi);
}

/// Each node takes its own part φ_n of what comes: φ_p = Σ_n w_pn φ_n, and what enters goes to the nodes by w_pn
/// φ_n/φ_p.
struct Split {
  std::array<double, 3> weight;
  double share = 1;  // φ_p
};
/// From `in`, quanta that would enter each sample. φ = 1 where it is not limited.
std::vector<Split> inflow_split(const ReferenceState& state, const std::vector<Quanta>& in, bool is_limited);

/// Adds quanta and momentum (one value a sample) to the nodes: v_n = (m_n v_n + p_n)/(m_n + Δm_n), pinned nodes keep v
/// and their pins hold against the rest within `dt` (s).
void give_to_nodes(ReferenceState& state, const std::vector<Quanta>& quanta, const std::vector<Momentum>& momentum,
                   const std::vector<Split>& split, double dt);

/// Adds the solute that comes with `quanta` (one value a sample each) to the nodes.
void give_solute_to_nodes(ReferenceState& state, const std::vector<Quanta>& solute, const std::vector<Quanta>& quanta,
                          const std::vector<Split>& split);

/// Applies momentum (one value a node) without mass: v_n += u_n p_n; pins hold against it within `dt` (s).
void push_nodes(ReferenceState& state, const std::vector<Momentum>& momentum, double dt);

/// Removes the marked particles from all fluid_* arrays; the order of the others stays.
void remove_particles(HostState& s, const std::vector<bool>& gone);

/// P′ of sample p, m/s², and what becomes of it with gravity: (P + g)/(|P + g| + ε) (src/stages/flow_direction.hpp).
Eigen::Vector3d virtual_pressure(const ReferenceState& state, Index p);
Eigen::Vector3d normalised_drive(const ReferenceState& state, Index p, const Eigen::Vector3d& pressure);

/// Σ V W of one side of a sheet, 1: below the first the rest of that side counts as air, above the second it is
/// covered.
inline constexpr double full_side = 0.1, covered_side = 0.25;

/// A particle that pressure drains is taken whole where less than this part of m_min would remain.
inline constexpr Quanta drained_part = 16;

/// May pressure drive liquid through the cloth of sample p, and does it?
bool is_permeable(const ReferenceState& state, Index p);
/// u (m/s) that a difference of p/ρ0 (m²/s²) drives through a sheet.
double flux_through(const ClothMaterial& cloth, double drive);
bool is_driven(const ReferenceState& state, Index p);

/// Sample p takes (1) or gives (-1) quanta from or to liquid at x, where the scene counts what comes and goes on the
/// faces.
void count_on_face(ReferenceState& state, Index p, const Eigen::Vector3d& x, Quanta quanta, int direction);

/// Is the cloth of sample p porous?
bool is_porous(const ReferenceState& state, Index p);

/// Do samples p and q belong to the same layer: one cloth, and less than 2h apart at rest?
bool same_layer(const ReferenceState& state, Index p, Index q);

}  // namespace drench::reference
