#pragma once
// What wetness does to the fabric's own numbers.

#include "cloth/cloth.hpp"

namespace drench::kokkos_backend {

/// The nodes' liquid beside what they can hold, as a kernel sees it.
struct NodeLiquid {
  Entries<const Quanta> liquid;
  Entries<const double> capacity;  // kg
  Entries<const double> pores;     // the same under pressure, kg; empty without stage squeezing
  double quantum;                  // kg

  NodeLiquid(const Constants& constants, const Cloth& cloth)
      : liquid(cloth.nodes.liquid),
        capacity(cloth.nodes.capacity),
        pores(cloth.nodes.pores),
        quantum(constants.quantum) {}
  /// What the pores hold as they are pressed, kg.
  KOKKOS_INLINE_FUNCTION double room(Index n) const { return pores.exist() ? pores(n) : capacity(n); }
  /// m_f/C_n, 1, of a node that can hold some; above 1 it is overfull.
  KOKKOS_INLINE_FUNCTION double filling(Index n) const { return double(liquid(n)) * quantum / room(n); }
  /// The same of pores that nothing presses.
  KOKKOS_INLINE_FUNCTION double filling_at_rest(Index n) const { return double(liquid(n)) * quantum / capacity(n); }
  /// What is beyond the pores over what they hold at rest, 1; below 0 they have room.
  KOKKOS_INLINE_FUNCTION double beyond(Index n) const {
    return pores.exist() ? (double(liquid(n)) * quantum - pores(n)) / capacity(n) : filling(n) - 1;
  }
  /// The same of the pores alone: what is beyond them in fabric that carries a film is not theirs.
  /// Nor more than fabric holds that is pressed, which stage diffusion's bound relies on.
  KOKKOS_INLINE_FUNCTION double pore_filling(Index n, const Material& m) const {
    if (m.film_depth > 0) return smaller(1.0, filling(n));
    return pores.exist() ? smaller(double(m.max_saturation), filling(n)) : filling(n);
  }
  /// s_n = min(1, m_f/C_n) of the pores at rest, 1; dry where it holds none.
  KOKKOS_INLINE_FUNCTION Real saturation(Index n) const {
    return capacity(n) > 0 ? Real(smaller(1.0, filling_at_rest(n))) : Real(0);
  }
};

/// Friction (1) or damping (1/s) at saturation s, linear between its dry value and that at s = 1.
KOKKOS_INLINE_FUNCTION Real at_saturation(Real dry, Real wet, Real saturation) {
  return dry + saturation * (wet - dry);
}
/// Friction, 1, and damping, 1/s, of the material at node n.
KOKKOS_INLINE_FUNCTION Real friction_at(const Material& m, const NodeLiquid& wet, Index n) {
  return at_saturation(m.friction, m.friction_wet, wet.saturation(n));
}
KOKKOS_INLINE_FUNCTION Real damping_at(const Material& m, const NodeLiquid& wet, Index n) {
  return at_saturation(m.damping, m.damping_wet, wet.saturation(n));
}

}  // namespace drench::kokkos_backend
