#include "setup/air.hpp"

#include <algorithm>
#include <cmath>

namespace drench {
namespace {

constexpr double coldest = -20;             // °C: no wet bulb is colder, with air from 0 °C on
constexpr double zero_celsius = 273.15;     // K
constexpr double pressure = 101325;         // Pa, of the air
constexpr double gas_of_vapour = 461.52;    // J/(kg K)
constexpr double gas_of_air = 287.05;       // J/(kg K)
constexpr double lightness = 1 - 0.62198;   // 1 − M_w/M_a: of vapour among air
constexpr double turbulent_reynolds = 5e5;  // of a flat plate
constexpr double turbulent_rayleigh = 1e7;
constexpr double heat_of_air = 1006;  // c_p, J/(kg K)
constexpr double prandtl = 0.71;      // of air
constexpr double emissivity = 0.95;   // of wet cloth and of what is around it
constexpr double stefan_boltzmann = 5.6704e-8;

/// e_s, Pa (Buck 1996).
double saturation_pressure(double t) { return 611.21 * std::exp((18.678 - t / 234.5) * t / (257.14 + t)); }

/// L_v, J/kg: of water that evaporates (Henderson-Sellers 1984).
double latent_heat(double t) {
  const double kelvin = t + zero_celsius, ratio = kelvin / (kelvin - 33.91);
  return 1.91846e6 * ratio * ratio;
}

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

WetBulb wet_bulb(const Scene& scene) {
  const AirScene& air = scene.air;
  const double gravity = std::hypot(scene.gravity[0], scene.gravity[1], scene.gravity[2]);
  const double kelvin = air.temperature + zero_celsius, transfer = transfer_coefficient(air, gravity);
  const double lewis = air_viscosity(kelvin) / prandtl / vapour_diffusivity(kelvin);
  const double convection = transfer * pressure / (gas_of_air * kelvin) * heat_of_air * std::pow(lewis, 2.0 / 3);
  const double radiation = 4 * emissivity * stefan_boltzmann * std::pow(kelvin, 3);
  const double far = air.humidity * saturation_pressure(air.temperature);
  const auto flux = [&](double t) {
    return transfer * (saturation_pressure(t) - far) / (gas_of_vapour * (0.5 * (t + air.temperature) + zero_celsius));
  };
  const auto excess = [&](double t) {
    return (convection + radiation) * (air.temperature - t) - latent_heat(t) * flux(t);
  };
  double low = coldest, high = air.temperature;  // at the dew point or below nothing evaporates
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    (excess(middle) > 0 ? low : high) = middle;
  }
  return {high, flux(high)};
}

double cloth_temperature(double air, double wet_bulb, double cooling, double wet) {
  return air - (air - wet_bulb) * (1 + cooling) * wet / (1 + cooling * wet);
}

}  // namespace drench
