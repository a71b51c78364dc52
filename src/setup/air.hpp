#pragma once
// How fast water goes from a wet surface into air (docs/theory/evaporation.md, section 1).

#include "scene/scene.hpp"

namespace drench {

/// ρ_sat, kg/m³: of saturated vapour over water at a temperature, °C (Eqs. 2, 3).
double saturated_vapour(double temperature);
/// h_m, m/s: how fast vapour leaves a wet surface in this air (Eqs. 4 to 7).
double transfer_coefficient(const AirScene& air, double gravity);
/// j, kg/(m² s): what a wet surface loses in the scene's air (Eq. 1).
double evaporation_flux(const Scene& scene);

}  // namespace drench
