#pragma once
// The plain types that all of drench shares. SI units throughout.

#include <array>
#include <cstddef>
#include <cstdint>

namespace drench {

using Vec3 = std::array<double, 3>;        ///< a vector or point, x y z
using Quaternion = std::array<double, 4>;  ///< a rotation, w x y z, of length 1
using Index = std::int32_t;                ///< index of a particle, node, sample or triangle
using Quanta = std::int64_t;               ///< liquid mass as a count of quanta, \f$q = m_0 / 2^{32}\f$

/// An index as the standard library's containers want it.
constexpr std::size_t at(Index i) { return static_cast<std::size_t>(i); }

/// Quanta of one full particle, of mass \f$m_0 = \rho_0 d^3\f$. A mass is exact to 2.3e-10 of a particle, and a signed
/// 64-bit sum holds two thousand million full particles.
inline constexpr Quanta quanta_per_particle = Quanta{1} << 32;

}  // namespace drench
