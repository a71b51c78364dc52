#pragma once
// What a rounding decides (docs/manual/compare.md). `drench compare` and the tests of the stages leave such states
// before they compare, instead of excusing what differs.

#include "compare/field_difference.hpp"

namespace drench {

/// Moves what lies within rounding of a decision of `stage` some roundings off it, so that backend and reference have
/// to decide alike. `reference` is used to move the cloth. Returns how many particles and nodes were moved.
std::size_t leave_decisions(Backend& reference, const Model& model, Stage stage, const StepInfo& info,
                            const Precision& precision, HostState& state);

/// How far a point can be from where double precision has it, m: a stored point (largest coordinate X, m, rounding u)
/// is off by u X along each axis, a sample made from rounded nodes (less than 2 h away) and weights by 5 u X, so a
/// separation of up to h by at most √3 · 10 u X.
double separation_rounding(const Model& model, const Precision& precision, double largest_coordinate);

}  // namespace drench
