#pragma once
// Viscous friction of the liquid at solids and sheets, with slip and without; law: docs/theory/viscosity.md, Slip.

#include "bodies/bodies.hpp"
#include "cloth/cloth.hpp"
#include "particles/viscosity.hpp"

namespace drench::kokkos_backend {

/// What slip adds to bodies and cloths; without any all is empty.
struct WallSlip {
  Field<Real> of_body, of_cloth;     // b, m, of each body and each cloth; inf: free
  Field<Real4> rest_plane, plane;    // of boundary samples at t = 0 and now: unit normal, depth below the wall, m
  Version placed = Version::none();  // of the bodies that `plane` is of
  bool exists() const { return of_body.extent(0) > 0 || of_cloth.extent(0) > 0; }
};

/// Makes the arrays of what slips, on first use, and places the planes where bodies have moved since.
void refresh_slip(const Constants& constants, Bodies& bodies, const StepInfo& info, WallSlip& slip);
MemoryEstimate slip_bytes(const Sizing& s);

/// Walls that hold the liquid at their surface.
struct NoSlip {
  /// Adds what sample b does to a particle at r = x_i − x_b, or the particle to the sample; the latter have r and the
  /// velocity the other way round.
  KOKKOS_INLINE_FUNCTION void at_body(ViscousSum& sum, Index, Real share, const Real3& v, const Real3& r,
                                      const Real3& gradient) const {
    sum.add(share, v, r, gradient);
  }
  KOKKOS_INLINE_FUNCTION void on_body(ViscousSum& sum, Index, Real share, const Real3& v, const Real3& r,
                                      const Real3& gradient) const {
    sum.add(share, v, r, gradient);
  }
  KOKKOS_INLINE_FUNCTION void at_sheet(ViscousSum& sum, Index, Real share, const Real3& v, const Real3& r,
                                       const Real3& gradient) const {
    sum.add(share, v, r, gradient);
  }
};

/// The same where some of them slip.
struct Slip {
  Entries<const Real> of_body, of_cloth;
  Entries<const Real4> plane;
  Entries<const Index> body, cloth;
  Entries<const Real3> normal;  // of the cloth's samples
  Real nearest;                 // m: no particle counts as nearer to a wall
  bool bodies_slip, cloths_slip;

  Slip(const Constants& constants, const WallSlip& slip, const BoundarySamples& boundary, const Samples& samples)
      : of_body(slip.of_body),
        of_cloth(slip.of_cloth),
        plane(slip.plane),
        body(boundary.body),
        cloth(samples.cloth),
        normal(samples.normal),
        nearest(Real(0.25) * constants.spacing),
        bodies_slip(slip.of_body.extent(0) > 0),
        cloths_slip(slip.of_cloth.extent(0) > 0) {}

  /// f: the share of the friction without slip that is left at a distance z (m) from a wall with a slip length b (m).
  KOKKOS_INLINE_FUNCTION Real left(Real z, Real b) const {
    const Real from = z > nearest ? z : nearest;
    return from / (from + b);
  }

  /// A pair at a wall with unit normal n: the share f as without slip, the rest along n alone.
  KOKKOS_INLINE_FUNCTION static void add(ViscousSum& sum, Real f, const Real3& n, Real share, const Real3& v,
                                         const Real3& r, const Real3& gradient) {
    sum.add(f * share, v, r, gradient);
    const Real along = (1 - f) * share * dot(r, n) * dot(gradient, n);
    sum.pull += (along * dot(v, n)) * n;
    sum.bound -= along;
  }
  KOKKOS_INLINE_FUNCTION void solid(ViscousSum& sum, Index b, Real side, Real share, const Real3& v, const Real3& r,
                                    const Real3& gradient) const {
    const Real length = bodies_slip ? of_body(body(b)) : Real(0);
    if (length == 0) return sum.add(share, v, r, gradient);
    const Real4 wall = plane(b);
    const Real3 n = wall.xyz();
    const Real along = side * dot(r, n), distance = (wall.w == 0 ? Kokkos::fabs(along) : along) - wall.w;
    add(sum, left(distance, length), n, share, v, r, gradient);
  }
  KOKKOS_INLINE_FUNCTION void at_body(ViscousSum& sum, Index b, Real share, const Real3& v, const Real3& r,
                                      const Real3& gradient) const {
    solid(sum, b, 1, share, v, r, gradient);
  }
  KOKKOS_INLINE_FUNCTION void on_body(ViscousSum& sum, Index b, Real share, const Real3& v, const Real3& r,
                                      const Real3& gradient) const {
    solid(sum, b, -1, share, v, r, gradient);
  }
  KOKKOS_INLINE_FUNCTION void at_sheet(ViscousSum& sum, Index b, Real share, const Real3& v, const Real3& r,
                                       const Real3& gradient) const {
    const Real length = cloths_slip ? of_cloth(cloth(b)) : Real(0);
    if (length == 0) return sum.add(share, v, r, gradient);
    const Real3 n = normal(b);
    add(sum, left(Kokkos::fabs(dot(r, n)), length), n, share, v, r, gradient);
  }
};

/// Calls run(NoSlip or Slip).
template <class Run>
void with_slip(const Constants& constants, const WallSlip& slip, const Bodies& bodies, const Cloth& cloth,
               const Run& run) {
  if (slip.exists())
    run(Slip(constants, slip, bodies.boundary, cloth.samples));
  else
    run(NoSlip{});
}

}  // namespace drench::kokkos_backend
