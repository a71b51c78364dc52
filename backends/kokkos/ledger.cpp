// Stage ledger (src/stages/ledger.hpp).

#include "ledger.hpp"

#include "laws/viscosity.hpp"

namespace drench::kokkos_backend {
namespace {

KOKKOS_INLINE_FUNCTION bool finite(const Real3& a) {
  return Kokkos::isfinite(a.x) && Kokkos::isfinite(a.y) && Kokkos::isfinite(a.z);
}

struct OfLiquid {
  Entries<Real3> x, v;
  Entries<Quanta> mass;
  double q, rho, step;
  Real3 gravity, center, square;
  bool speed, field;

  explicit OfLiquid(const Device& d)
      : x(d.fluid.position),
        v(d.fluid.velocity),
        mass(d.fluid.mass),
        q(d.quantum),
        rho(double(d.rest_density)),
        step(d.model.scene.time.step),
        gravity(d.gravity),
        center(d.field_center),
        square(d.field_square),
        speed(d.model.scene.time.mode == TimeMode::cfl),
        field(d.model.scene.field.present) {}
  KOKKOS_INLINE_FUNCTION LedgerSums operator()(const Index i) const {
    LedgerSums own;
    own.mass = mass(i);
    own.nonfinite = finite(x(i)) && finite(v(i)) ? 0 : 1;
    own.energy = 0.5 * q * double(mass(i)) * double(dot(v(i), v(i)));
    own.mass_float += rho * double(Real(double(mass(i)) * q / rho));
    own.bounds.add(x(i));
    if (speed) {
      const Real3 a = field ? gravity + central_field(x(i), center, square) : gravity;
      own.speed = double(norm(v(i))) + double(norm(a)) * step;
    }
    return own;
  }
};

struct OfNodes {
  Entries<Real3> x, v;
  Entries<Quanta> liquid;
  Entries<double> capacity;
  Entries<Real> solid;
  double q;

  explicit OfNodes(const Device& d)
      : x(d.nodes.position),
        v(d.nodes.velocity),
        liquid(d.nodes.liquid),
        capacity(d.nodes.capacity),
        solid(d.nodes.solid_mass),
        q(d.quantum) {}
  KOKKOS_INLINE_FUNCTION LedgerSums operator()(const Index n) const {
    LedgerSums own;
    own.mass = liquid(n);
    own.nonfinite = finite(x(n)) && finite(v(n)) ? 0 : 1;
    own.energy = 0.5 * (double(solid(n)) + q * double(liquid(n))) * double(dot(v(n), v(n)));
    own.mass_float += double(Real(double(liquid(n)) * q));
    own.saturation = capacity(n) > 0 ? double(liquid(n)) * q / capacity(n) : 0;
    own.speed = double(norm(v(n)));
    return own;
  }
};

void add(StepReport& report, const LedgerSums& sums) {
  report.nonfinite += sums.nonfinite;
  report.kinetic_energy += sums.energy;
  report.mass_float += sums.mass_float.sum + sums.mass_float.lost;
}

}  // namespace

SumPair<LedgerSums> measure(Device& d) {
  const auto sums =
      ordered_pair<LedgerSums>("drench::ledger::sums", d.fluid.count, OfLiquid(d), d.nodes.count, OfNodes(d));
  d.measured = {true, sums.first.bounds, sums.first.speed, sums.second.speed};
  return sums;
}

void ledger(Device& d, const StepInfo& info, StepReport& report) {
  report.particles = d.fluid.count;
  report.mass_drained = d.drained;
  report.mass_supplied = d.supplied;
  report.mass_float = 0;
  report.kinetic_energy = 0;
  report.nonfinite = 0;
  const SumPair<LedgerSums> sums = measure(d);
  if (d.fluid.count > 0) {
    report.mass_fluid = sums.first.mass;
    add(report, sums.first);
  }
  if (d.nodes.count > 0) {
    report.mass_cloth = sums.second.mass;
    if (d.model.has_porous()) report.saturation_max = sums.second.saturation;
    add(report, sums.second);
  }
  d.step = info.step + 1;
  d.time = info.time + info.dt;
}

}  // namespace drench::kokkos_backend
