// Derived quantities that several stages share: samples from nodes, inverse masses, node forces.

#include "device.hpp"
#include "primitives/gather.hpp"

namespace drench::kokkos_backend {

namespace {

/// A sample follows its triangle's nodes.
struct SampleFromNodes {
  Entries<Index> node;
  Entries<Real> weight;
  Entries<Real3> node_position, node_velocity, position, velocity, normal;

  explicit SampleFromNodes(const Device& d)
      : node(d.samples.node),
        weight(d.samples.weight),
        node_position(d.nodes.position),
        node_velocity(d.nodes.velocity),
        position(d.samples.position),
        velocity(d.samples.velocity),
        normal(d.samples.normal) {}

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

void refresh_samples(Device& d) {
  parallel("drench::samples::position", d.samples.count, SampleFromNodes(d));
  d.samples_fresh = true;
}

void place_samples(Device& d) {
  if (!d.samples_fresh) refresh_samples(d);
}

void refresh_samples_and_bounds(Device& d) {
  if (d.sample_bounds.data() == nullptr)
    d.sample_bounds = HostBounds(Kokkos::ViewAllocateWithoutInitializing("drench::sample_bounds"));
  Kokkos::parallel_reduce("drench::samples::position", Range(0, d.samples.count), SampleAndBounds{SampleFromNodes(d)},
                          d.sample_bounds);
  d.samples_fresh = true;
}

void refresh_sample_cells(Device& d) {
  if (d.sample_cells_fresh) return;
  d.sample_cells.build(d.samples.position, d.samples.count, d.support, {},
                       d.sample_bounds_fresh ? &d.sample_bounds() : nullptr);
  d.sample_cells_fresh = true;
}

void refresh_inverse_mass(Device& d) {
  const auto u = d.nodes.inverse_mass;
  const auto solid = d.nodes.solid_mass;
  const auto liquid = d.nodes.liquid;
  const auto pinned = d.nodes.pinned;
  const double q = d.quantum;
  parallel(
      "drench::nodes::inverse_mass", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        u(n) = pinned(n) ? Real(0) : Real(1) / (solid(n) + Real(double(liquid(n)) * q));
      });
}

void node_forces_from_samples(Device& d) {
  const Entries<Index> item = d.nodes.sample_item;
  const Entries<Real> weight = d.samples.weight;
  const Entries<Real3> fs = d.samples.force, f = d.nodes.force;
  gather_rows<Real3>(
      "drench::nodes::force", d.nodes.count, d.nodes.sample_start,
      KOKKOS_LAMBDA(const Index e) {
        const Index b = item(e) / 4;
        return weight(3 * b + item(e) % 4) * fs(b);
      },
      KOKKOS_LAMBDA(const Index n, const Real3& sum) { f(n) = sum; });
}

void node_bounds_from_samples(const char* label, const Device& d, const Array<Real>& of_sample) {
  const Entries<Index> item = d.nodes.sample_item;
  const Entries<Real> weight = d.samples.weight, u = d.nodes.inverse_mass, bound = d.nodes.row_bound, load = of_sample;
  gather_rows<Real>(
      label, d.nodes.count, d.nodes.sample_start,
      KOKKOS_LAMBDA(const Index e) {
        const Index b = item(e) / 4;
        return weight(3 * b + item(e) % 4) * load(b);
      },
      KOKKOS_LAMBDA(const Index n, const Real sum) { bound(n) = u(n) * sum; });
}

void apply_node_forces(Device& d, Real dt) {
  const auto f = d.nodes.force, v = d.nodes.velocity, pin = d.nodes.pin_force;
  const auto u = d.nodes.inverse_mass;
  const auto pinned = d.nodes.pinned;
  parallel(
      "drench::nodes::apply_force", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (pinned(n))
          pin(n) -= f(n);
        else
          v(n) += dt * u(n) * f(n);
      });
}

}  // namespace drench::kokkos_backend
