#include "coupling/wall_slip.hpp"

#include "bodies/deforming_body.hpp"
#include "core/host_copy.hpp"

namespace drench::kokkos_backend {
namespace {

template <class Parts>
Field<Real> lengths_of(const char* label, const Parts& parts) {
  std::vector<double> lengths;
  for (const auto& part : parts) lengths.push_back(part.slip);
  return to_device<Real>(label, lengths);
}

/// Normals of the bodies that move as they are, for those that turn.
void turn_planes(const Bodies& bodies, WallSlip& slip) {
  const Entries<const RigidBody> constant = bodies.constant;
  const Entries<const RigidState> state = bodies.state;
  const Entries<const Index> of = bodies.boundary.body;
  const Entries<const Real4> rest = std::as_const(slip).rest_plane;
  const Entries<Real4> plane = slip.plane;
  parallel(
      "drench::forces::wall_plane", bodies.boundary.count, KOKKOS_LAMBDA(const Index b) {
        if (!constant(of(b)).moves) return;
        plane(b) = {narrow(rotate(state(of(b)).orientation, widen(rest(b).xyz()))), rest(b).w};
      });
}

/// Normals of the triangles of a body that changes its shape.
void bend_planes(DeformingBody& body, double time, WallSlip& slip) {
  const PointsBetween points = points_of_step(body, time, 0).begin;
  const Entries<const Index> triangle = std::as_const(body).sample_triangle, corner = std::as_const(body).corner;
  const Entries<Real4> plane = slip.plane;
  const Index first = body.first_sample;
  parallel(
      "drench::forces::bent_wall_plane", body.samples, KOKKOS_LAMBDA(const Index s) {
        const std::int64_t t = 3 * static_cast<std::int64_t>(triangle(s));
        const Double3 origin = points(corner(t));
        const Double3 across = outer(minus(points(corner(t + 1)), origin), minus(points(corner(t + 2)), origin));
        const double length = Kokkos::sqrt(inner(across, across));
        plane(first + s) = {narrow(times(length > 0 ? 1 / length : 0, across)), plane(first + s).w};
      });
}

}  // namespace

void refresh_slip(const Constants& constants, Bodies& bodies, const StepInfo& info, WallSlip& slip) {
  const Model& m = constants.model;
  if (m.has_slipping_cloth() && slip.of_cloth.extent(0) == 0)
    slip.of_cloth = lengths_of("drench::forces::cloth_slip", m.cloths);
  if (!m.has_slipping_body() || slip.placed == bodies.moved) return;
  if (slip.of_body.extent(0) == 0) {
    slip.of_body = lengths_of("drench::forces::body_slip", m.bodies);
    std::vector<Real4> planes;
    for (std::size_t b = 0; b < m.boundary.wall_normal.size(); ++b)
      planes.emplace_back(to_real(m.boundary.wall_normal[b]), Real(m.boundary.wall_depth[b]));
    slip.plane = to_device<Real4>("drench::forces::wall_plane", planes);
    if (m.has_moving_body()) slip.rest_plane = to_device<Real4>("drench::forces::rest_wall_plane", planes);
  }
  slip.placed = bodies.moved;
  if (!m.has_moving_body()) return;
  turn_planes(bodies, slip);
  for (const auto& body : bodies.deforming) bend_planes(*body, info.time, slip);
}

MemoryEstimate slip_bytes(const Sizing& s) {
  MemoryEstimate sum;
  sum.bodies = s.size.wall_planes * s.size.boundary * 4 * s.real;
  return sum;
}

}  // namespace drench::kokkos_backend
