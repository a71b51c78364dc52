#pragma once
// Equality of scenes, field by field. A field that is added to a struct stops this file from compiling.

#include <tuple>

#include "scene/scene.hpp"

namespace drench {

// clang-format off
inline auto fields(const Box& s) { const auto& [a, b] = s; return std::tie(a, b); }
inline auto fields(const TimeScene& s) { const auto& [a, b, c, d] = s; return std::tie(a, b, c, d); }
inline auto fields(const OutputScene& s) { const auto& [a, b, c, d, e] = s; return std::tie(a, b, c, d, e); }
inline auto fields(const ProcessScene& s) { const auto& [a, b, c, d, e] = s; return std::tie(a, b, c, d, e); }
inline auto fields(const MicropolarScene& s) { const auto& [a, b, c, d, e] = s; return std::tie(a, b, c, d, e); }
inline auto fields(const FluidSolverScene& s) { const auto& [a, b, c, d, e] = s; return std::tie(a, b, c, d, e); }
inline auto fields(const BlockScene& s) { const auto& [a, b] = s; return std::tie(a, b); }
inline auto fields(const JetScene& s) { const auto& [a, b, c, d, e] = s; return std::tie(a, b, c, d, e); }
inline auto fields(const FluidScene& s) {
  const auto& [a, b, c, d, e, f, g, h, i, j, k] = s; return std::tie(a, b, c, d, e, f, g, h, i, j, k);
}
inline auto fields(const GridScene& s) { const auto& [a, b] = s; return std::tie(a, b); }
inline auto fields(const SpinScene& s) { const auto& [a, b] = s; return std::tie(a, b); }
inline auto fields(const PinScene& s) {
  const auto& [a, b, c, d, e, f, g, h] = s; return std::tie(a, b, c, d, e, f, g, h);
}
inline auto fields(const SaturationScene& s) { const auto& [a, b] = s; return std::tie(a, b); }
inline auto fields(const PorousScene& s) {
  const auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n] = s; return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n);
}
inline auto fields(const ClothScene& s) {
  const auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, t, u, v, w, x, y, z] = s;
  return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, t, u, v, w, x, y, z);
}
inline auto fields(const ClothSolverScene& s) { const auto& [a, b, c] = s; return std::tie(a, b, c); }
inline auto fields(const BodyScene& s) {
  const auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o] = s;
  return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o);
}
inline auto fields(const FieldScene& s) { const auto& [a, b, c] = s; return std::tie(a, b, c); }
/// Where a scene came from is no part of what it says.
inline auto fields(const Scene& s) {
  const auto& [path, a, b, c, d, e, f, g, h, i, j, k, l, m] = s; static_cast<void>(path);
  return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m);
}
// clang-format on

template <class T>
requires requires(const T& s) { fields(s); }
bool operator==(const T& a, const T& b) { return fields(a) == fields(b); }

}  // namespace drench
