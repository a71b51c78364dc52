// Stage ledger (src/stages/ledger.hpp).

#include "ledger.hpp"

#include <algorithm>
#include <cmath>

#include "laws/rigid.hpp"
#include "laws/viscosity.hpp"

namespace drench::kokkos_backend {
namespace {

template <class Vector>
KOKKOS_INLINE_FUNCTION bool finite(const Vector& a) {
  return Kokkos::isfinite(a.x) && Kokkos::isfinite(a.y) && Kokkos::isfinite(a.z);
}

struct OfLiquid {
  Entries<Real3> x, v;
  Entries<Quanta> mass;
  double q, rho, step;
  Real3 gravity, center, square;
  bool speed, field;
  CrossedCloth* crossed;  // null without cloth

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
        field(d.model.scene.field.present),
        crossed(d.crossed.data()) {}
  KOKKOS_INLINE_FUNCTION LedgerSums operator()(const Index i) const {
    LedgerSums own;
    own.mass = mass(i);
    own.nonfinite = finite(x(i)) && finite(v(i)) ? 0 : 1;
    own.square = double(dot(v(i), v(i)));
    own.energy = 0.5 * q * double(mass(i)) * own.square;
    own.mass_float += rho * double(Real(double(mass(i)) * q / rho));
    own.bounds.add(x(i));
    if (speed) {
      const Real3 a = field ? gravity + central_field(x(i), center, square) : gravity;
      own.speed = double(norm(v(i))) + double(norm(a)) * step;
    }
    if (i == 0 && crossed != nullptr) {
      own.crossed = *crossed;
      *crossed = {};
    }
    return own;
  }
};

/// Nodes, edges and bodies, each for itself: one range serves them all.
struct OfNodes {
  Index nodes, edges, bodies;
  Entries<Real3> x, v;
  Entries<Quanta> liquid;
  Entries<double> capacity;
  Entries<Real> solid, length;
  Entries<Index> edge;
  Entries<RigidState> body;
  double q;

  explicit OfNodes(const Device& d)
      : nodes(d.nodes.count),
        edges(d.model.has_moving_cloth() ? d.mesh.edges : 0),
        bodies(d.model.has_moving_body() ? d.bodies.count : 0),
        x(d.nodes.position),
        v(d.nodes.velocity),
        liquid(d.nodes.liquid),
        capacity(d.nodes.capacity),
        solid(d.nodes.solid_mass),
        length(d.mesh.edge_length),
        edge(d.mesh.edge),
        body(d.bodies.state),
        q(d.quantum) {}
  Index count() const { return std::max({nodes, edges, bodies}); }
  KOKKOS_INLINE_FUNCTION LedgerSums operator()(const Index n) const {
    LedgerSums own;
    if (n < bodies) {
      const RigidState& s = body(n);
      const Turn& q4 = s.orientation;
      own.nonfinite =
          finite(s.position) && finite(s.velocity) && finite(s.spin) && Kokkos::isfinite(q4.w + q4.x + q4.y + q4.z) ? 0
                                                                                                                    : 1;
    }
    if (n < edges) {
      const Real3 way = x(edge(2 * n + 1)) - x(edge(2 * n));
      own.stretch = double(dot(way, way)) / (double(length(n)) * double(length(n)));
    }
    if (n >= nodes) return own;
    own.mass = liquid(n);
    own.nonfinite += finite(x(n)) && finite(v(n)) ? 0 : 1;
    own.square = double(dot(v(n), v(n)));
    own.energy = 0.5 * (double(solid(n)) + q * double(liquid(n))) * own.square;
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
  const OfNodes others(d);
  const auto sums =
      ordered_pair<LedgerSums>("drench::ledger::sums", d.fluid.count, OfLiquid(d), others.count(), others);
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
  report.passed = 0;
  report.lowest_passed = -1;
  report.fluid_speed = report.cloth_speed = report.cloth_stretch = 0;
  const SumPair<LedgerSums> sums = measure(d);
  if (d.fluid.count > 0) {
    report.mass_fluid = sums.first.mass;
    report.fluid_speed = std::sqrt(sums.first.square);
    report.passed = sums.first.crossed.count;
    report.lowest_passed = report.passed > 0 ? sums.first.crossed.lowest : -1;
    add(report, sums.first);
  }
  if (d.nodes.count > 0 || d.model.has_moving_body()) {
    report.mass_cloth = sums.second.mass;
    report.cloth_speed = std::sqrt(sums.second.square);
    report.cloth_stretch = std::sqrt(sums.second.stretch);
    if (d.model.has_porous()) report.saturation_max = sums.second.saturation;
    add(report, sums.second);
  }
  d.step = info.step + 1;
  d.time = info.time + info.dt;
}

}  // namespace drench::kokkos_backend
