#pragma once
// Stage pressure: DFSPH's constant-density solve (Bender & Koschier 2015, 2017), with a contact pressure at sheets;
// the cloth's implicit step goes on inside it, and dynamic bodies answer in every iteration.
//
// Law:    docs/theory/liquid.md: iteration and stopping (Eqs. 18 to 21), The density solve (22 to 25).
//         docs/theory/walls_and_sheets.md: extrapolated walls (7a to 7f), contact pressure (10 to 14), coupling with
//         the cloth (18, 19). docs/theory/bodies.md: answer to pressure (9, 10), held bodies (5, 5a). The cloth's
//         iteration: cloth.hpp.
// Reads:  positions (m), masses (quanta), velocities (m/s), fluid_age (s), fluid_origin, fluid_density_ratio (1),
//         node_contact_force, node_friction_force (N), α, C, α', C', lists; the scene's `fluid.solver`,
//         `cloth_solver`.
// Writes: fluid_velocity, node_velocity, body velocities (m/s, rad/s), node_pin_force (N), fluid_kappa_density
//         (m²/s²); StepReport::density_iterations, density_error, density_error_max (1), density_converged, cloth_*.
// Errors: none. A solve that ends at max_iterations, or because the cloth's residual no longer falls, is reported as not
//         converged; pipeline/failure.hpp knows a collapse.

#include <algorithm>
#include <limits>

#include "scene/scene.hpp"

namespace drench {

/// How many iterations of the cloth an iteration of the pressure may take after `spent` of them in the same solve. The
/// whole solve may take some ten times as many; from then on each iteration takes a few, so that the work of a step has
/// a limit.
inline int cloth_iterations_per_pressure(const ClothSolverScene& solver, int spent) {
  constexpr int few = 10;  // the least that the cloth judges
  const int each = std::max(100, solver.max_iterations / 3), left = 10 * each - spent;
  return std::clamp(left, few, each);
}

/// Whether a solve goes on for the sake of cloth whose own step, in stage cloth, has not converged: it would take all
/// of fluid.solver.max_iterations, with the cloth's iterations in each.
class CoupledProgress {
 public:
  /// To be told the cloth's residual (1) of each iteration in which the liquid has converged. True once it has fallen
  /// by less than a tenth in the last few of them.
  bool stalls(double residual) {
    constexpr int few = 5;
    constexpr double least = 0.9;
    if (residual < least * smallest_) {
      smallest_ = residual;
      waiting_ = 0;
      return false;
    }
    return ++waiting_ >= few;
  }

 private:
  double smallest_ = std::numeric_limits<double>::infinity();
  int waiting_ = 0;
};

}  // namespace drench
