// Stage ledger (src/stages/ledger.hpp).

#include "device.hpp"
#include "primitives/reduce.hpp"

namespace drench::kokkos_backend {
namespace {

KOKKOS_INLINE_FUNCTION bool finite(const Real3& a) {
  return Kokkos::isfinite(a.x) && Kokkos::isfinite(a.y) && Kokkos::isfinite(a.z);
}

/// What is summed over particles, or over nodes, in one pass; `saturation` is a maximum.
struct LedgerSums {
  Quanta mass = 0;
  std::int64_t nonfinite = 0;
  double energy = 0;  // J
  CompensatedSum mass_float;
  double saturation = 0;
  KOKKOS_INLINE_FUNCTION LedgerSums& operator+=(const LedgerSums& o) {
    mass += o.mass;
    nonfinite += o.nonfinite;
    energy += o.energy;
    mass_float += o.mass_float;
    if (o.saturation > saturation) saturation = o.saturation;
    return *this;
  }
};

void add(StepReport& report, const LedgerSums& sums) {
  report.nonfinite += sums.nonfinite;
  report.kinetic_energy += sums.energy;
  report.mass_float += sums.mass_float.sum + sums.mass_float.lost;
}

}  // namespace

void ledger(Device& d, const StepInfo& info, StepReport& report) {
  const double q = d.quantum, rho = double(d.rest_density);
  report.particles = d.fluid.count;
  report.mass_drained = d.drained;
  report.mass_supplied = d.supplied;
  report.mass_float = 0;
  report.kinetic_energy = 0;
  report.nonfinite = 0;
  if (d.fluid.count > 0) {
    const auto x = d.fluid.position, v = d.fluid.velocity;
    const auto mass = d.fluid.mass;
    const LedgerSums sums = ordered<LedgerSums>(
        "drench::ledger::fluid", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
          LedgerSums own;
          own.mass = mass(i);
          own.nonfinite = finite(x(i)) && finite(v(i)) ? 0 : 1;
          own.energy = 0.5 * q * double(mass(i)) * double(dot(v(i), v(i)));
          own.mass_float += rho * double(Real(double(mass(i)) * q / rho));
          return own;
        });
    report.mass_fluid = sums.mass;
    add(report, sums);
  }
  if (d.nodes.count > 0) {
    const auto x = d.nodes.position, v = d.nodes.velocity;
    const auto liquid = d.nodes.liquid;
    const auto capacity = d.nodes.capacity;
    const auto solid = d.nodes.solid_mass;
    const LedgerSums sums = ordered<LedgerSums>(
        "drench::ledger::nodes", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
          LedgerSums own;
          own.mass = liquid(n);
          own.nonfinite = finite(x(n)) && finite(v(n)) ? 0 : 1;
          own.energy = 0.5 * (double(solid(n)) + q * double(liquid(n))) * double(dot(v(n), v(n)));
          own.mass_float += double(Real(double(liquid(n)) * q));
          own.saturation = capacity(n) > 0 ? double(liquid(n)) * q / capacity(n) : 0;
          return own;
        });
    report.mass_cloth = sums.mass;
    if (d.model.has_porous()) report.saturation_max = sums.saturation;
    add(report, sums);
  }
  d.step = info.step + 1;
  d.time = info.time + info.dt;
}

}  // namespace drench::kokkos_backend
