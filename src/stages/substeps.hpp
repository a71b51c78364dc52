#pragma once
// In how many parts stage diffusion takes a step (stages/diffusion.hpp, law 3).

#include <algorithm>
#include <cmath>

namespace drench {

/// n = max(1, ⌈Δt rate/0.5⌉): no node exchanges more than half of what it could hold in one part. `rate` (1/s) is the
/// largest of the nodes, dt is in s. A double: no int holds 10^10.
inline double substeps_for(double rate, double dt) { return std::max(1.0, std::ceil(dt * rate / 0.5)); }

/// ψ_max and μ of the rate (law 3), 1: how much of the differences of saturation and height an edge conducts at most,
/// for the exponent n, the largest saturation, the exponent β of retention and the ratio ℓ_d/ℓ of hysteresis
/// (docs/theory/porous.md, Eq. 49).
struct MobilityBound {
  double difference, height;
};
inline MobilityBound mobility_bound(double n, double max_saturation, double beta, double ratio) {
  if (ratio > 1) {
    const double steepest =
        std::max(std::pow(max_saturation, n + beta - 1), 1 / (1 - std::pow(1 - 1 / ratio, 1 / beta)));
    const double height = std::max(1.0, n * std::pow(max_saturation, n - 1));
    return {beta * steepest + height * (ratio - 1), height};
  }
  if (beta != 1)
    return {beta * std::pow(max_saturation, n + beta - 1),
            std::max(1.0, (n + beta) * std::pow(max_saturation, std::max(0.0, n - 1)))};
  if (n == 0) return {1, 1};
  if (n == 1) return {max_saturation, 1};
  return {std::pow(max_saturation, n), std::max(1.0, n * std::pow(max_saturation, n - 1))};
}

}  // namespace drench
