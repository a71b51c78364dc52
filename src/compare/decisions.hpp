#pragma once
// What a rounding decides. Most of a stage is continuous in its input; some of it is a choice: on which side of a cloth's
// plane a particle lies, whether a node has arrived at a body. Where the input lies within rounding of such a choice, a
// backend in float and the reference in double may both be right and yet be far apart. Nothing can be compared there, and
// so `drench compare` and the tests of the stages leave such places before they compare, instead of excusing what differs.

#include "compare/field_difference.hpp"

namespace drench {

/// Moves what lies within rounding of a decision of `stage` some roundings off it, so that backend and reference have to
/// decide alike:
/// - neighbors to advection: particles in the plane of a sample that they see (density.hpp: on which side it is a wall),
///   and those of pairs for which rounding decides whether a cloth parts them (neighbors.hpp, thin sheets): besides,
///   the crossing lies at the end of the sample's reach, or two samples are as near and disagree. They move at random, by
///   up to 8 roundings of a height (more where that is not enough);
/// - advection (stages/advection.hpp): velocities of nodes that would arrive at a body's contact distance (law 2), of
///   liquid that would arrive in a cloth's plane (law 3), at a body's surface (4) or at the domain's border (5): by some
///   roundings over Δt, away from where they would arrive.
/// `reference` is used to move the cloth. Returns how many particles and nodes were moved.
std::size_t leave_decisions(Backend& reference, const Model& model, Stage stage, const StepInfo& info,
                            const Precision& precision, HostState& state);

/// How far a point can be from where double precision has it, m: a stored point (largest coordinate X, m, rounding u) is off
/// by u X along each axis, a sample made from rounded nodes (less than 2 h away) and weights by 5 u X, so a separation of
/// up to h by at most √3 · 10 u X.
double separation_rounding(const Model& model, const Precision& precision, double largest_coordinate);

}  // namespace drench
