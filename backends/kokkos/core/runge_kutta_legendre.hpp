#pragma once
// Stages of RKL1 (Meyer, Balsara & Aslam 2014), as stages forces and micropolar take them (src/stages/forces.hpp).

#include "core/types.hpp"

namespace drench::kokkos_backend {

/// A stage as the change that it makes: D_k = Y_k − Y_{k−1} = keep D_{k−1} + weight L(Y_{k−1}), weight in s.
/// (With Y_k from Y_{k−1} and Y_{k−2} hundreds of stages would lose three digits of a float.)
struct LegendreStage {
  Real keep = 0, weight = 0;
};

/// The k-th of `count` stages over dt (s).
inline LegendreStage legendre(int k, int count, double dt) {
  return {Real((k - 1.0) / k), Real((2 * k - 1.0) / k * dt * 2 / (double(count) * (count + 1.0)))};
}

}  // namespace drench::kokkos_backend
