#pragma once
// Stage squeezing: how solids and other layers press the fabric, and what that leaves of its pores. Runs only where a
// moving porous cloth has a `compressibility`.
//
// Law:    docs/theory/porous.md, section 17 (Eqs. 42 to 45). Forces between layers that touch follow from Gauss'
//         principle: `passes` Jacobi passes over the pairs, from no force.
// Reads:  node_position (m), node_liquid (quanta), the pairs of stage self_collision, solids.
// Writes: node_contact_pressure (Pa), and what each node's pores hold from here to the end of the step: kg, not part
//         of the state.
// Exact:  forces between layers are 64-bit sums in units of the heaviest node's mass, wet, times 2^-32 m/s².
// Errors: none.

namespace drench::squeezing_law {

inline constexpr int passes = 40;
inline constexpr int spreads = 6;  // of the nodes' forces to their neighbours; even
/// β of pass k = 0, 1, …: the next one starts from λ_k + β (λ_k − λ_{k−1}) (Beck and Teboulle 2009).
/// The last has none.
constexpr double momentum(int pass) { return pass / (pass + 3.0); }
inline constexpr double touching = 1.05;       // of τ: layers that are nearer touch
inline constexpr double response_time = 0.05;  // s, T: over which the pressure is averaged
inline constexpr double least_pores = 1e-3;    // of the pores at rest: they never close altogether

}  // namespace drench::squeezing_law
