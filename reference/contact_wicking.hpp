#pragma once
// Liquid that passes between layers of cloth that touch: laws 4–6 of src/stages/diffusion.hpp.

#include <array>
#include <vector>

#include "common.hpp"

namespace drench::reference {

/// A sample that touches a triangle of another layer.
struct LayerContact {
  std::array<Index, 3> near_node, far_node;
  std::array<double, 3> near_weight, far_weight;
  double conductance;                   // G, kg/s
  double drop;                          // the terms of (22) without s, 1
  double exponent;                      // n, 1
  std::array<double, 2> height, power;  // ℓ over the lesser of both, β: of the near and of the far fabric
};

std::vector<LayerContact> touching_layers(const ReferenceState& state, double dt);
/// One sub-step of dt (s).
void wick_through(ReferenceState& state, const std::vector<LayerContact>& contacts, double dt);

/// The suction of fabric with hysteresis or large pores at a node, as a height of liquid, m.
double suction(const ReferenceState& state, Index n);
/// R of docs/theory/porous.md, Eq. 49: by how much scanning curves of wetting are steeper than the main one.
double steepening(const ClothMaterial& c);
/// What suctions at one saturation differ by at most through hysteresis, over ℓ.
double suction_jump(const ClothMaterial& c);
/// ĝ, 0 without gravity.
Eigen::Vector3d down(const ReferenceState& state);
/// v_n of every node, m/s.
Vectors node_velocities(const ReferenceState& state);
/// Law 8, once the nodes hold what they gained: Σ_in t_k (v_k − v_n), quanta · m/s, spread over their whole mass.
void change_velocities(ReferenceState& state, const Vectors& gained);
/// ψ of law 2 between two saturations, the flow leaving that of `donor`.
long double mobility(double one, double other, double donor, double n);
/// ψ b of law 2 with the exponent n, 1: > 0 flows from `donor` to `receiver`, which then are what they are called.
double driven(double receiver, double donor, double drop, double n);
/// φ^out and φ^in of every node, 1, for what is to leave and to enter it.
std::vector<double> outflow_limit(const ReferenceState& state, const std::vector<Quanta>& out);
std::vector<double> room_limit(const ReferenceState& state, const std::vector<Quanta>& in);

}  // namespace drench::reference
