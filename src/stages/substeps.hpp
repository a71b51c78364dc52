#pragma once
// In how many parts stage diffusion takes a step (stages/diffusion.hpp, law 3).

#include <algorithm>
#include <cmath>

#include "scene/material.hpp"

namespace drench {

/// n = max(1, ⌈Δt rate/0.5⌉): no node exchanges more than half of what it could hold in one part. `rate` (1/s) is the
/// largest of the nodes, dt is in s. A double: no int holds 10^10.
inline double substeps_for(double rate, double dt) { return std::max(1.0, std::ceil(dt * rate / 0.5)); }

/// How a fabric holds liquid, without units (docs/theory/porous.md, sections 6, 18 and 19).
struct RetentionShape {
  double beta = 1;                      // β
  double ratio = 1, drainage_beta = 1;  // ℓ_d/ℓ and β_d of hysteresis; ratio 1: none
  double large = 0, narrowing = 1;      // w and ℓ/ℓ₂ of large pores; w 0: none

  explicit RetentionShape(const BasicMaterial<double>& c)
      : beta(c.retention_exponent),
        ratio(c.drainage_ratio()),
        drainage_beta(c.drainage_exponent > 0 ? c.drainage_exponent : c.retention_exponent) {
    if (!c.has_large_pores()) return;
    large = c.large_pores;
    narrowing = c.capillary_height / c.large_pore_height;
  }

  /// R, 1/γ at least: by how much scanning curves of wetting are steeper than the main one.
  double scanning() const {
    return std::max(1 / (1 - std::pow(1 - 1 / ratio, 1 / drainage_beta)), ratio * drainage_beta / beta);
  }
  /// By how much suctions at one saturation differ with its history, at most, over ℓ.
  double jump() const {
    if (large > 0) return ratio;
    const double k = drainage_beta / beta;
    return ratio - 1 + (k > 1 ? std::pow(k, -1 / (k - 1)) * (1 - 1 / k) : 0);
  }
  /// What h/ℓ falls by with the saturation at most, history included, for the exponent n and saturations up to `most`.
  double steepest(double n, double most) const {
    const double slope = beta > 1 ? beta * std::pow(most, beta - 1) : 1;
    if (ratio > 1) return std::max(slope, beta * scanning() / (1 - large)) + std::max(1.0, n) * jump();
    return large > 0 ? std::max(slope, beta / (1 - large)) : slope;
  }
};

/// ψ_max and μ of the rate (law 3), 1: how much of the differences of saturation and height an edge conducts at most,
/// for the exponent n and the largest saturation (docs/theory/porous.md, Eqs. 49 and 52).
struct MobilityBound {
  double difference, height;
};
inline MobilityBound mobility_bound(double n, double max_saturation, const RetentionShape& c) {
  if (c.large > 0) {
    const double wide = c.narrowing * c.narrowing, full = 1 - c.large + c.large * wide;
    const double height = wide * std::max(1.0, n * std::pow(max_saturation, n - 1));
    const double above = max_saturation > 1 ? full * std::pow(max_saturation, n + c.beta - 1) : 0;
    if (c.ratio > 1) return {c.beta * std::max(full * c.scanning() / (1 - c.large), above) + height * c.jump(), height};
    // Where large pores are full beside empty ones they conduct as the mean of the power does.
    const double beside = wide / (n + 1) * std::max(1.0, std::pow(max_saturation, n + c.beta - 1));
    return {c.beta * std::max(c.narrowing, above) + beside * (1 - 1 / c.narrowing), height};
  }
  if (c.ratio > 1) {
    const double steepest = std::max(std::pow(max_saturation, n + c.beta - 1), c.scanning());
    const double height = std::max(1.0, n * std::pow(max_saturation, n - 1));
    return {c.beta * steepest + height * c.jump(), height};
  }
  if (c.beta != 1)
    return {c.beta * std::pow(max_saturation, n + c.beta - 1),
            std::max(1.0, (n + c.beta) * std::pow(max_saturation, std::max(0.0, n - 1)))};
  if (n == 0) return {1, 1};
  if (n == 1) return {max_saturation, 1};
  return {std::pow(max_saturation, n), std::max(1.0, n * std::pow(max_saturation, n - 1))};
}

}  // namespace drench
