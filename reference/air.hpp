#pragma once
// What evaporation from liquid and from cloth share (docs/theory/evaporation.md, section 5).

#include <cstdint>

namespace drench::reference {

/// u in [0, 1), drawn for a thing (its id or index) in a step.
inline double drawn(std::int64_t thing, std::int64_t step) {
  std::uint64_t z =
      static_cast<std::uint64_t>(thing) * 0xD1B54A32D192ED03U + static_cast<std::uint64_t>(step) * 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1p-53;
}

}  // namespace drench::reference
