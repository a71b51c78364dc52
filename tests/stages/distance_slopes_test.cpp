// Normals of interpolated distances at the faces between a lattice's cells.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "bodies/contact.hpp"

namespace drench::test {
namespace {

using kokkos_backend::Real;
using kokkos_backend::Real3;
using kokkos_backend::Solid;

constexpr Index points = 5;
constexpr Real spacing = Real(0.01);  // m

/// Distances to a surface near y = 0.02 m that bends across x = 0.02 m, a face of the lattice, so that its slope jumps
/// there.
struct Lattice {
  std::array<Real, points * points * points> value;
  Solid solid{};

  explicit Lattice(double jump) {
    for (Index z = 0; z < points; ++z)
      for (Index y = 0; y < points; ++y)
        for (Index x = 0; x < points; ++x) {
          const double bend = jump * std::max(0, x - 2);
          value[std::size_t((z * points + y) * points + x)] = Real(spacing * (y - 2 + 0.1 * x + bend));
        }
    solid.kind = 3;
    solid.field = value.data();
    solid.field_spacing = spacing;
    for (Index& n : solid.field_points) n = points;
  }
  /// At `cells` from the face.
  Real3 normal(double cells) const {
    const Real3 x{Real(0.02 + cells * double(spacing)), Real(0.0213), Real(0.0154)};
    return kokkos_backend::solid_distance(solid, x, Real3{}).normal;
  }
  double turn(double from, double to) const { return double(norm(normal(from) - normal(to))); }
};

}  // namespace

TEST(distance_slopes, turn_steadily_from_cell_to_cell) {
  const Lattice bent(0.05);
  const double whole = bent.turn(-0.5, 0.5);
  EXPECT_GT(whole, 0.04);
  EXPECT_LT(bent.turn(-0.001, 0.001), 0.02 * whole);
  for (const double side : {-1.0, 1.0}) {
    EXPECT_NEAR(bent.turn(0.5 * side, 0.05 * side), whole / 4, 0.02 * whole);
    EXPECT_NEAR(bent.turn(0.5 * side, 0.11 * side), 0, 1e-6) << "beyond a tenth of a cell the cell's own slope holds";
  }
}

TEST(distance_slopes, jump_at_sharp_edges_alone) {
  // Nothing is left of jumps up to 0.3, half of 0.45, all of 0.6: the rule itself does not end abruptly.
  for (const auto& [jump, left] : {std::pair{0.05, 0.0}, {0.29, 0.0}, {0.45, 0.5}, {0.59, 0.97}, {0.61, 1.0}}) {
    const Lattice edge(jump);
    EXPECT_NEAR(edge.turn(-0.0005, 0.0005) / edge.turn(-0.5, 0.5), left, 0.05) << jump;
  }
}

TEST(distance_slopes, need_a_cell_beyond_the_face) {
  const Lattice bent(0.05);
  for (const double at : {-1.999, 1.999}) {  // cells from the middle, next to the lattice's end
    const Real3 end = bent.normal(at), inside = bent.normal(at > 0 ? 1.5 : -1.5);
    EXPECT_NEAR(double(norm(end - inside)), 0, 1e-5);
  }
}

}  // namespace drench::test
