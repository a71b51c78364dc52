// Derived quantities that several stages share: samples from nodes, inverse masses, node forces.

#include "device.hpp"

namespace drench::kokkos_backend {

void refresh_samples(Device& d) {
  const auto node = d.samples.node;
  const auto weight = d.samples.weight;
  const auto x = d.nodes.position, v = d.nodes.velocity;
  const auto xs = d.samples.position, vs = d.samples.velocity, normal = d.samples.normal;
  parallel(
      "drench::samples::position", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        Real3 position, velocity;
        for (int k = 0; k < 3; ++k) {
          const Index n = node(3 * p + k);
          position += weight(3 * p + k) * x(n);
          velocity += weight(3 * p + k) * v(n);
        }
        xs(p) = position;
        vs(p) = velocity;
        const Real3 corner = x(node(3 * p));
        const Real3 across = cross(x(node(3 * p + 1)) - corner, x(node(3 * p + 2)) - corner);
        const Real length = norm(across);
        normal(p) = length > 0 ? (1 / length) * across : Real3{};
      });
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

void refresh_saturation(Device& d) {
  const auto node = d.samples.node;
  const auto weight = d.samples.weight;
  const auto liquid = d.nodes.liquid;
  const auto capacity = d.nodes.capacity;
  const auto s = d.samples.saturation;
  const double q = d.quantum;
  parallel(
      "drench::samples::saturation", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        double sum = 0;
        for (int k = 0; k < 3; ++k) {
          const Index n = node(3 * p + k);
          if (capacity(n) > 0) sum += double(weight(3 * p + k)) * (double(liquid(n)) * q / capacity(n));
        }
        s(p) = Real(sum);
      });
}

void node_forces_from_samples(Device& d) {
  const auto start = d.nodes.sample_start, item = d.nodes.sample_item;
  const auto weight = d.samples.weight;
  const auto fs = d.samples.force;
  const auto f = d.nodes.force;
  parallel(
      "drench::nodes::force", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Real3 sum;
        for (Index e = start(n); e < start(n + 1); ++e)
          sum += weight(3 * (item(e) / 4) + item(e) % 4) * fs(item(e) / 4);
        f(n) = sum;
      });
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
