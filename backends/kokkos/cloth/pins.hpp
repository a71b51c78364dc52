#pragma once
// Pins and stitches that move by prescription (src/stages/cloth.hpp).

#include "cloth/cloth.hpp"

namespace drench::kokkos_backend {

/// nodes.pin_motion, .rest_position and .pin_stiffness, if any pin moves or is soft: at set-up, and when the model has
/// changed.
void find_moving_pins(const Model& model, Nodes& nodes);

/// cloth.pin_steps for this step. Does nothing if no pin moves, or if an earlier stage of the step has placed them.
void place_pins(const Constants& constants, Cloth& cloth, const StepInfo& info);

/// The stitches' rest lengths in this step. They pull and never push: no length is above the one that its nodes start
/// with.
void shorten_stitches(Cloth& cloth, const StepInfo& info);

/// What kernels see of them.
struct PinMotions {
  Slice<const Index> motion;
  Entries<const Real3> rest;
  Entries<const PinStep> steps;

  explicit PinMotions(const Cloth& cloth)
      : motion(cloth.nodes.pin_motion), rest(cloth.nodes.rest_position), steps(cloth.pin_steps) {}

  KOKKOS_INLINE_FUNCTION bool moves(Index n) const { return motion.extent(0) > 0 && motion(n) >= 0; }
  KOKKOS_INLINE_FUNCTION Real holds(Index n) const { return steps(motion(n)).holds; }
  /// From the step's start to its end, m.
  KOKKOS_INLINE_FUNCTION Real3 shift(Index n) const {
    const PinStep& s = steps(motion(n));
    const Real3 arm = rest(n) - s.center;
    return s.move + Real3{dot(s.change[0], arm), dot(s.change[1], arm), dot(s.change[2], arm)};
  }
  /// At the step's end, m.
  KOKKOS_INLINE_FUNCTION Real3 position(Index n) const {
    const PinStep& s = steps(motion(n));
    const Real3 arm = rest(n) - s.center;
    return s.offset + Real3{dot(s.rotation[0], arm), dot(s.rotation[1], arm), dot(s.rotation[2], arm)};
  }
};

/// Nodes that springs hold to where their pins are at the step's end (docs/theory/cloth.md, (13a)).
struct SoftPins {
  PinMotions motions;
  Entries<const Real> stiffness;
  Entries<const std::uint8_t> pinned;

  explicit SoftPins(const Cloth& cloth)
      : motions(cloth), stiffness(cloth.nodes.pin_stiffness), pinned(cloth.nodes.pinned) {}

  /// N/m; 0: no soft pin holds it.
  KOKKOS_INLINE_FUNCTION Real operator()(Index n) const {
    return stiffness.exist() && !pinned(n) && motions.moves(n) ? motions.holds(n) * stiffness(n) : Real(0);
  }
  /// What the spring does to a node at `position`, N.
  KOKKOS_INLINE_FUNCTION Real3 force(Index n, const Real3& position) const {
    const Real k = (*this)(n);
    return k > 0 ? k * (motions.position(n) - position) : Real3{};
  }
};

}  // namespace drench::kokkos_backend
