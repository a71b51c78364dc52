#include "setup/air.hpp"

#include <algorithm>
#include <cmath>

namespace drench {
namespace {

constexpr double zero_celsius = 273.15;     // K
constexpr double pressure = 101325;         // Pa, of the air
constexpr double gas_of_vapour = 461.52;    // J/(kg K)
constexpr double gas_of_air = 287.05;       // J/(kg K)
constexpr double lightness = 1 - 0.62198;   // 1 − M_w/M_a: of vapour among air
constexpr double turbulent_reynolds = 5e5;  // of a flat plate
constexpr double turbulent_rayleigh = 1e7;

/// e_s, Pa (Buck 1996).
double saturation_pressure(double t) { return 611.21 * std::exp((18.678 - t / 234.5) * t / (257.14 + t)); }

/// D_v, m²/s: of water vapour in air (Marrero and Mason 1972).
double vapour_diffusivity(double kelvin) { return 1.87e-10 * std::pow(kelvin, 2.072); }

/// ν_a, m²/s (Sutherland 1893).
double air_viscosity(double kelvin) {
  const double dynamic = 1.716e-5 * std::pow(kelvin / zero_celsius, 1.5) * (zero_celsius + 110.4) / (kelvin + 110.4);
  return dynamic * gas_of_air * kelvin / pressure;
}

/// Mean Sherwood number of air along a flat plate.
double forced(double reynolds, double schmidt) {
  const double part =
      reynolds > turbulent_reynolds ? 0.037 * std::pow(reynolds, 0.8) - 871 : 0.664 * std::sqrt(reynolds);
  return part * std::cbrt(schmidt);
}

/// Of air at rest over a plate, which vapour makes lighter.
double natural(double rayleigh) {
  return rayleigh > turbulent_rayleigh ? 0.15 * std::cbrt(rayleigh) : 0.54 * std::pow(rayleigh, 0.25);
}

}  // namespace

double saturated_vapour(double temperature) {
  return saturation_pressure(temperature) / (gas_of_vapour * (temperature + zero_celsius));
}

double transfer_coefficient(const AirScene& air, double gravity) {
  if (air.transfer_coefficient) return *air.transfer_coefficient;
  const double kelvin = air.temperature + zero_celsius, length = air.length;
  const double diffusivity = vapour_diffusivity(kelvin), viscosity = air_viscosity(kelvin);
  const double lighter = lightness * saturation_pressure(air.temperature) * (1 - air.humidity) / pressure;
  const double rayleigh = gravity * lighter * std::pow(length, 3) / (viscosity * diffusivity);
  const double sherwood = std::max(forced(air.speed * length / viscosity, viscosity / diffusivity), natural(rayleigh));
  return sherwood * diffusivity / length;
}

double evaporation_flux(const Scene& scene) {
  const AirScene& air = scene.air;
  if (air.evaporation_rate) return *air.evaporation_rate;
  const double gravity = std::hypot(scene.gravity[0], scene.gravity[1], scene.gravity[2]);
  return transfer_coefficient(air, gravity) * (1 - air.humidity) * saturated_vapour(air.temperature);
}

}  // namespace drench
