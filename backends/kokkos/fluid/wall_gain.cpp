#include "fluid/wall_gain.hpp"

#include "core/kernel.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr Real one_sided = Real(0.1);  // |s|² over S² from which walls lie on one side
constexpr int terms = 4;               // of the series, beside 1

/// Sums over the samples of solids.
struct WallSum {
  Real3 gradient;         // s, 1/m
  Real lengths = 0;       // S, 1/m
  Real3 diagonal, shear;  // of M, 1

  /// A sample at −r with V_b (dW/dr)/r, 1/m².
  KOKKOS_INLINE_FUNCTION void add(const Real3& r, Real length, Real factor) {
    gradient += (mirrored * factor) * r;
    lengths -= mirrored * factor * length;
    diagonal -= factor * Real3{r.x * r.x, r.y * r.y, r.z * r.z};
    shear -= factor * Real3{r.y * r.z, r.x * r.z, r.x * r.y};
  }
};

/// L e of a unit vector e. `n`: the normal; `weight`: how much of the tangential part of M counts.
KOKKOS_INLINE_FUNCTION Real3 column(const WallSum& wall, const Real3& n, Real weight, const Real3& e) {
  Real3 sum = e, term = e;
  for (int k = 0; k < terms; ++k) {
    term = term - dot(term, n) * n;
    term = weight * product(wall.diagonal, wall.shear, term);
    term = term - dot(term, n) * n;
    sum += term;
  }
  return sum;
}

}  // namespace

void find_wall_gain(const Constants& constants, const NeighborLists& lists, const Bodies& bodies, Fluid& fluid) {
  const Kernel kernel = constants.kernel;
  const Entries<const Real3> x = fluid.particles.position, xb = bodies.boundary.position;
  const Entries<const Real> volume = bodies.boundary.volume;
  const Neighbors list(lists.fluid_boundary);
  const Entries<Real3> diagonal = fluid.wall_gain.diagonal, shear = fluid.wall_gain.shear;
  parallel(
      "drench::density::wall_gain", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        WallSum wall;
        list.for_each(i, [&](Index b) {
          const Real3 r = x(i) - xb(b);
          const Real length = norm(r);
          wall.add(r, length, volume(b) * kernel.grad_factor(length));
        });
        diagonal(i) = {1, 1, 1};
        shear(i) = {};
        const Real square = dot(wall.gradient, wall.gradient), least = one_sided * wall.lengths * wall.lengths;
        if (!(square > 0)) return;
        const Real3 n = inverse_root(square) * wall.gradient;
        const Real weight = square < least ? square / least : Real(1);
        const Real3 lx = column(wall, n, weight, {1, 0, 0}), ly = column(wall, n, weight, {0, 1, 0}),
                    lz = column(wall, n, weight, {0, 0, 1});
        diagonal(i) = {lx.x, ly.y, lz.z};
        shear(i) = {ly.z, lx.z, lx.y};
      });
}

}  // namespace drench::kokkos_backend
