#include "cloth/exact_residual.hpp"

#include "core/host_parallel.hpp"

namespace drench::kokkos_backend {

ExactResidual::ExactResidual(const Cloth& cloth, const ClothSystem& s)
    : nodes_(cloth.nodes.count),
      triangles_(cloth.mesh.triangle_shape.exists() ? cloth.mesh.triangles : 0),
      corner_force_(2 * at(triangles_)),
      bending_start_(1, 0),
      spring_start_(1, 0),
      bending_at_x0_(at(nodes_)) {
  for (Index n = 0; n < nodes_; ++n) {
    for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l) {
      const Link link = s.link(l);
      if (link.bend != 0) bending_.push_back({link.other, link.bend});
      if (link.stiffness > 0) springs_.push_back(l);
    }
    bending_start_.push_back(static_cast<Index>(bending_.size()));
    spring_start_.push_back(static_cast<Index>(springs_.size()));
  }
}

void ExactResidual::begin_step(const ClothSystem& s) {
  host_parallel("drench::cloth::exact_bending", nodes_, [=, this](const Index n) {
    bending_at_x0_[at(n)] = bending_force(n, [&s](const Index m) { return widen(s.start(m)); });
  });
}

void ExactResidual::evaluate_elastic(const ClothSystem& s, const std::vector<Double3>& shift,
                                     std::vector<Double3>& elastic) {
  const Double3* const u = shift.data();
  Double3* const on_corner = corner_force_.data();
  host_parallel("drench::cloth::exact_triangles", triangles_, [=](const Index t) {
    const Columns<double> stress =
        s.triangle_stress(t, u[s.triangle(3 * t)], u[s.triangle(3 * t + 1)], u[s.triangle(3 * t + 2)]);
    for (Index c = 1; c < 3; ++c)
      on_corner[2 * t + c - 1] = corner_force(stress, corner_gradient(s.triangle_shape(t), c));
  });
  Double3* const all = elastic.data();
  host_parallel("drench::cloth::exact_elastic", nodes_, [=, this](const Index n) {
    if (s.pinned(n)) {
      all[n] = {};
      return;
    }
    Double3 force = bending_at_x0_[at(n)] + bending_force(n, [u](const Index m) { return u[m]; });
    for (Index k = spring_start_[at(n)]; k < spring_start_[at(n + 1)]; ++k) {
      Link spring = s.link(springs_[at(k)]);
      spring.bend = 0;
      const Real3 apart = s.start(n) - s.start(spring.other);
      const Real rate = s.strain_damping_rate(n);
      ClothSystem::add_link(force, spring, widen(s.start(n)) - widen(s.start(spring.other)), u[n] - u[spring.other],
                            0.0, rate > 0 ? strain_damping(apart, spring.stiffness, rate) : Real(0));
    }
    if (s.triangle_start.exist())
      for (Index i = s.triangle_start(n); i < s.triangle_start(n + 1); ++i) {
        const Index t = s.triangle_item(i) / 4, corner = s.triangle_item(i) % 4;
        if (corner == 0)
          force -= on_corner[2 * t] + on_corner[2 * t + 1];
        else
          force += on_corner[2 * t + corner - 1];
      }
    all[n] = force;
  });
}

void ExactResidual::add_inertia(const ClothSystem& s, const std::vector<Double3>& shift,
                                const std::vector<Double3>& elastic, std::vector<Double3>& residual) const {
  host_parallel("drench::cloth::exact_residual", nodes_, [&](const Index n) {
    if (s.pinned(n))
      residual[at(n)] = {};
    else
      residual[at(n)] =
          double(s.mass(n)) * double(s.inverse_dt2) * (widen(s.target(n)) - shift[at(n)]) + elastic[at(n)];
  });
}

}  // namespace drench::kokkos_backend
