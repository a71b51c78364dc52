// Stage ledger (src/stages/ledger.hpp).

#include "device.hpp"
#include "primitives/reduce.hpp"

namespace drench::kokkos_backend {
namespace {

KOKKOS_INLINE_FUNCTION bool finite(const Real3& a) {
  return Kokkos::isfinite(a.x) && Kokkos::isfinite(a.y) && Kokkos::isfinite(a.z);
}

}  // namespace

void ledger(Device& d, const StepInfo& info, StepReport& report) {
  const FluidArrays f = d.fluid;
  const double q = d.quantum, rho = double(d.rest_density);
  report.particles = f.count;
  report.mass_drained = d.drained;
  report.mass_supplied = d.supplied;
  report.mass_float = 0;
  report.kinetic_energy = 0;
  report.nonfinite = 0;
  if (f.count > 0) {
    report.mass_fluid = integer_sum(
        "drench::ledger::fluid_mass", f.count, KOKKOS_LAMBDA(const Index i) { return f.mass(i); });
    report.nonfinite += integer_sum(
        "drench::ledger::fluid_nonfinite", f.count,
        KOKKOS_LAMBDA(const Index i) { return std::int64_t(finite(f.position(i)) && finite(f.velocity(i)) ? 0 : 1); });
    report.kinetic_energy += ordered_sum(
        "drench::ledger::fluid_energy", f.count, KOKKOS_LAMBDA(const Index i) {
          return 0.5 * q * double(f.mass(i)) * double(dot(f.velocity(i), f.velocity(i)));
        });
    report.mass_float += compensated_sum(
        "drench::ledger::fluid_float", f.count,
        KOKKOS_LAMBDA(const Index i) { return rho * double(Real(double(f.mass(i)) * q / rho)); });
  }
  const Index n = d.nodes.count;
  if (n > 0) {
    const auto x = d.nodes.position, v = d.nodes.velocity;
    const auto liquid = d.nodes.liquid;
    const auto capacity = d.nodes.capacity;
    const auto solid = d.nodes.solid_mass;
    report.mass_cloth = integer_sum(
        "drench::ledger::cloth_mass", n, KOKKOS_LAMBDA(const Index k) { return liquid(k); });
    report.nonfinite += integer_sum(
        "drench::ledger::node_nonfinite", n,
        KOKKOS_LAMBDA(const Index k) { return std::int64_t(finite(x(k)) && finite(v(k)) ? 0 : 1); });
    report.kinetic_energy += ordered_sum(
        "drench::ledger::node_energy", n, KOKKOS_LAMBDA(const Index k) {
          return 0.5 * (double(solid(k)) + q * double(liquid(k))) * double(dot(v(k), v(k)));
        });
    report.mass_float += compensated_sum(
        "drench::ledger::node_float", n, KOKKOS_LAMBDA(const Index k) { return double(Real(double(liquid(k)) * q)); });
    if (d.model.has_porous())
      report.saturation_max = maximum(
          "drench::ledger::saturation", n,
          KOKKOS_LAMBDA(const Index k) { return capacity(k) > 0 ? double(liquid(k)) * q / capacity(k) : 0.0; });
  }
  d.step = info.step + 1;
  d.time = info.time + info.dt;
}

}  // namespace drench::kokkos_backend
