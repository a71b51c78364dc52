#pragma once
// In how many parts stage diffusion takes a step (stages/diffusion.hpp, law 3).

#include <algorithm>
#include <cmath>

namespace drench {

/// n = max(1, ⌈Δt rate/0.5⌉): no node exchanges more than half of what it could hold in one part. `rate` (1/s) is the largest of
/// the nodes, dt is in s. A double: no int holds 10^10.
inline double substeps_for(double rate, double dt) { return std::max(1.0, std::ceil(dt * rate / 0.5)); }

}  // namespace drench
