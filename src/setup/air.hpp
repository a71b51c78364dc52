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

/// A wet surface that takes its heat from the air alone (Eqs. 16 to 18): T_w, °C, and j, kg/(m² s).
struct WetBulb {
  double temperature = 0, flux = 0;
};
WetBulb wet_bulb(const Scene& scene);
/// T, °C, of cloth of which the part `wet` (1) of the surface is wet (Eq. 20).
double cloth_temperature(double air, double wet_bulb, double cooling, double wet);

}  // namespace drench
