// Derived quantities that several stages share: samples from nodes, inverse masses, node forces.

#include "cloth/cloth.hpp"
#include "core/gather.hpp"

namespace drench::kokkos_backend {

namespace {

/// A sample follows its triangle's nodes.
struct SampleFromNodes {
  Entries<const Index> node;
  Entries<const Real> weight;
  Entries<const Real3> node_position, node_velocity;
  Entries<Real3> position, velocity, normal;

  explicit SampleFromNodes(Cloth& cloth)
      : node(cloth.samples.node),
        weight(cloth.samples.weight),
        node_position(cloth.nodes.position),
        node_velocity(cloth.nodes.velocity),
        position(cloth.samples.position),
        velocity(cloth.samples.velocity),
        normal(cloth.samples.normal) {}

  KOKKOS_INLINE_FUNCTION void operator()(const Index p) const {
    Real3 x, v;
    for (int k = 0; k < 3; ++k) {
      const Index n = node(3 * p + k);
      x += weight(3 * p + k) * node_position(n);
      v += weight(3 * p + k) * node_velocity(n);
    }
    position(p) = x;
    velocity(p) = v;
    const Real3 corner = node_position(node(3 * p));
    const Real3 across = cross(node_position(node(3 * p + 1)) - corner, node_position(node(3 * p + 2)) - corner);
    const Real length = norm(across);
    normal(p) = length > 0 ? (1 / length) * across : Real3{};
  }
};

struct SampleAndBounds {
  using value_type = PointBounds;
  SampleFromNodes sample;

  KOKKOS_INLINE_FUNCTION void init(PointBounds& b) const { b.clear(); }
  KOKKOS_INLINE_FUNCTION void join(PointBounds& b, const PointBounds& o) const { b.add(o); }
  KOKKOS_INLINE_FUNCTION void operator()(const Index p, PointBounds& b) const {
    sample(p);
    b.add(sample.position(p));
  }
};

}  // namespace

void refresh_samples(Cloth& cloth) {
  parallel("drench::samples::position", cloth.samples.count, SampleFromNodes(cloth));
  cloth.samples_placed = cloth.moved;
}

void place_samples(Cloth& cloth) {
  if (cloth.samples_placed != cloth.moved) refresh_samples(cloth);
}

void refresh_samples_and_bounds(Cloth& cloth) {
  make_room_for_one(cloth.sample_bounds.box, "drench::sample_bounds");
  Kokkos::parallel_reduce("drench::samples::position", range(cloth.samples.count),
                          SampleAndBounds{SampleFromNodes(cloth)}, cloth.sample_bounds.box);
  cloth.samples_placed = cloth.moved;
}

void refresh_sample_cells(const Constants& constants, Cloth& cloth) {
  if (cloth.sample_cells.is_of(cloth.moved)) return;
  const PointBounds* const bounds = cloth.sample_bounds.is_of(cloth.moved) ? &cloth.sample_bounds.box() : nullptr;
  cloth.sample_cells.build(cloth.samples.position, cloth.samples.count, constants.support, {}, bounds);
  cloth.sample_cells.set_made_from(cloth.moved);
}

void refresh_inverse_mass(const Constants& constants, Cloth& cloth) {
  if (cloth.weighed == cloth.soaked) return;
  cloth.weighed = cloth.soaked;
  const Entries<Real> u = cloth.nodes.inverse_mass;
  const Entries<const Real> solid = cloth.nodes.solid_mass;
  const Entries<const Quanta> liquid = cloth.nodes.liquid;
  const Entries<const std::uint8_t> fixed = cloth.nodes.fixed;
  const double q = constants.quantum;
  parallel(
      "drench::nodes::inverse_mass", cloth.nodes.count,
      KOKKOS_LAMBDA(const Index n) { u(n) = fixed(n) ? Real(0) : Real(1) / (solid(n) + Real(double(liquid(n)) * q)); });
}

void node_forces_from_samples(Cloth& cloth) {
  const Entries<const Index> item = cloth.nodes.sample_item;
  const Entries<const Real> weight = cloth.samples.weight;
  const Entries<const Real3> fs = cloth.samples.force;
  const Entries<Real3> f = cloth.nodes.force;
  gather_rows<Real3>(
      "drench::nodes::force", cloth.nodes.count, cloth.nodes.sample_start,
      KOKKOS_LAMBDA(const Index e) {
        const Index b = item(e) / 4;
        return weight(3 * b + item(e) % 4) * fs(b);
      },
      KOKKOS_LAMBDA(const Index n, const Real3& sum) { f(n) = sum; });
}

void node_bounds_from_samples(const char* label, Cloth& cloth, const Entries<const Real>& of_sample) {
  const Entries<const Index> item = cloth.nodes.sample_item;
  const Entries<const Real> weight = cloth.samples.weight, u = cloth.nodes.inverse_mass;
  const Entries<Real> bound = cloth.nodes.row_bound;
  gather_rows<Real>(
      label, cloth.nodes.count, cloth.nodes.sample_start,
      KOKKOS_LAMBDA(const Index e) {
        const Index b = item(e) / 4;
        return weight(3 * b + item(e) % 4) * of_sample(b);
      },
      KOKKOS_LAMBDA(const Index n, const Real sum) { bound(n) = u(n) * sum; });
}

void apply_node_forces(Cloth& cloth, Real dt) {
  const Entries<const Real3> f = cloth.nodes.force;
  const Entries<Real3> v = cloth.nodes.velocity, pin = cloth.nodes.pin_force;
  const Entries<const Real> u = cloth.nodes.inverse_mass;
  const Entries<const std::uint8_t> fixed = cloth.nodes.fixed;
  parallel(
      "drench::nodes::apply_force", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (fixed(n))
          pin(n) -= f(n);
        else
          v(n) += dt * u(n) * f(n);
      });
}

}  // namespace drench::kokkos_backend
