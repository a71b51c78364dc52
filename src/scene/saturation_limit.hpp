#pragma once
// Saturations of a scene against the largest one of its fabric.

namespace drench {

/// Is it above the largest saturation, 1, by more than rounding? That of a film is a quotient, which is rounded.
inline bool exceeds(double saturation, double most) { return saturation > most * (1 + 1e-12); }

}  // namespace drench
