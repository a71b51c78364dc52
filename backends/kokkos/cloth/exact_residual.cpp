#include "cloth/exact_residual.hpp"

#include "core/host_parallel.hpp"

namespace drench::kokkos_backend {

ExactResidual::ExactResidual(const Cloth& cloth)
    : nodes_(cloth.nodes.count),
      triangles_(cloth.mesh.triangle_shape.exists() ? cloth.mesh.triangles : 0),
      corner_force_(2 * static_cast<std::size_t>(triangles_)) {}

void ExactResidual::evaluate(const ClothSystem& s, const std::vector<Double3>& shift, std::vector<Double3>& residual) {
  const Double3* const u = shift.data();
  Double3* const on_corner = corner_force_.data();
  host_parallel("drench::cloth::exact_triangles", triangles_, [=](const Index t) {
    const Columns<double> stress =
        s.triangle_stress(t, u[s.triangle(3 * t)], u[s.triangle(3 * t + 1)], u[s.triangle(3 * t + 2)]);
    for (Index c = 1; c < 3; ++c)
      on_corner[2 * t + c - 1] = corner_force(stress, corner_gradient(s.triangle_shape(t), c));
  });
  Double3* const r = residual.data();
  host_parallel("drench::cloth::exact_residual", nodes_, [=](const Index n) {
    if (s.pinned(n)) {
      r[n] = {};
      return;
    }
    Double3 force = double(s.mass(n)) * double(s.inverse_dt2) * (widen(s.target(n)) - u[n]);
    force += s.link_force(n, [u](const Index m) { return u[m]; });
    if (s.triangle_start.exist())
      for (Index i = s.triangle_start(n); i < s.triangle_start(n + 1); ++i) {
        const Index t = s.triangle_item(i) / 4, corner = s.triangle_item(i) % 4;
        if (corner == 0)
          force -= on_corner[2 * t] + on_corner[2 * t + 1];
        else
          force += on_corner[2 * t + corner - 1];
      }
    r[n] = force;
  });
}

}  // namespace drench::kokkos_backend
