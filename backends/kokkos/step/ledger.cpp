// Stage ledger (src/stages/ledger.hpp).

#include "step/ledger.hpp"

#include <algorithm>
#include <cmath>

#include "cloth/wet_cloth.hpp"
#include "particles/viscosity.hpp"
#include "step/stages.hpp"

namespace drench::kokkos_backend {
namespace {

template <class Vector>
KOKKOS_INLINE_FUNCTION bool finite(const Vector& a) {
  return Kokkos::isfinite(a.x) && Kokkos::isfinite(a.y) && Kokkos::isfinite(a.z);
}

struct OfLiquid {
  Entries<const Real3> x, v;
  Entries<const Quanta> mass;
  double q, rho, step;
  Real3 gravity, center, square;
  bool speed, field;
  Tunnelled* tunnelled;  // null without cloth
  LedgerScale scale;

  OfLiquid(const Constants& constants, const Fluid& fluid, const LedgerScale& scales)
      : x(fluid.particles.position),
        v(fluid.particles.velocity),
        mass(fluid.particles.mass),
        q(constants.quantum),
        rho(double(constants.rest_density)),
        step(constants.model.scene.time.step),
        gravity(constants.gravity),
        center(constants.field_center),
        square(constants.field_square),
        speed(constants.model.scene.time.mode == TimeMode::cfl),
        field(constants.model.scene.field.present),
        tunnelled(fluid.tunnelled.data()),
        scale(scales) {}
  KOKKOS_INLINE_FUNCTION LedgerSums operator()(const Index i) const {
    LedgerSums own;
    own.mass = mass(i);
    own.nonfinite = finite(x(i)) && finite(v(i)) ? 0 : 1;
    own.square = double(dot(v(i), v(i)));
    own.energy = scale.energy(0.5 * q * double(mass(i)) * own.square);
    own.mass_float = scale.mass(rho * double(Real(double(mass(i)) * q / rho)));
    own.bounds.add(x(i));
    if (speed) {
      const Real3 a = field ? gravity + central_field(x(i), center, square) : gravity;
      own.speed = double(norm(v(i))) + double(norm(a)) * step;
    }
    if (i == 0 && tunnelled != nullptr) {
      own.tunnelled = *tunnelled;
      *tunnelled = {};
    }
    return own;
  }
};

/// Nodes, edges and bodies, each for itself: one range serves them all.
struct OfNodes {
  Index nodes, edges, bodies;
  Entries<const Real3> x, v;
  NodeLiquid wet;
  Entries<const Real> solid, length;
  Entries<const Index> edge;
  Entries<const RigidState> body;
  LedgerScale scale;

  OfNodes(const Constants& constants, const Bodies& solids, const Cloth& cloth, const LedgerScale& scales)
      : nodes(cloth.nodes.count),
        edges(constants.model.has_moving_cloth() ? cloth.mesh.edges - cloth.mesh.stitches : 0),
        bodies(constants.model.has_moving_body() ? solids.count : 0),
        x(cloth.nodes.position),
        v(cloth.nodes.velocity),
        wet(constants, cloth),
        solid(cloth.nodes.solid_mass),
        length(cloth.mesh.dry_length.exists() ? cloth.mesh.dry_length : cloth.mesh.edge_length),
        edge(cloth.mesh.edge),
        body(solids.state),
        scale(scales) {}
  Index count() const { return std::max({nodes, edges, bodies}); }
  KOKKOS_INLINE_FUNCTION LedgerSums operator()(const Index n) const {
    LedgerSums own;
    if (n < bodies) {
      const RigidState& s = body(n);
      const Quaternion& q4 = s.orientation;
      own.nonfinite =
          finite(s.position) && finite(s.velocity) && finite(s.spin) && Kokkos::isfinite(q4.w + q4.x + q4.y + q4.z) ? 0
                                                                                                                    : 1;
    }
    if (n < edges) {
      const Real3 way = x(edge(2 * n + 1)) - x(edge(2 * n));
      own.stretch = double(dot(way, way)) / (double(length(n)) * double(length(n)));
    }
    if (n >= nodes) return own;
    own.mass = wet.liquid(n);
    own.nonfinite += finite(x(n)) && finite(v(n)) ? 0 : 1;
    own.square = double(dot(v(n), v(n)));
    own.energy = scale.energy(0.5 * (double(solid(n)) + wet.quantum * double(wet.liquid(n))) * own.square);
    own.mass_float = scale.mass(double(Real(double(wet.liquid(n)) * wet.quantum)));
    own.saturation = wet.capacity(n) > 0 ? wet.filling_at_rest(n) : 0;
    own.speed = double(norm(v(n)));
    return own;
  }
};

void add(StepReport& report, const LedgerSums& sums, const LedgerScale& scale) {
  report.nonfinite += sums.nonfinite;
  report.kinetic_energy += scale.energy.value(sums.energy);
  report.mass_float += scale.mass.value(sums.mass_float);
}

/// Cloth and bodies are the same on all ranks.
void add_ranks(const Communicator* ranks, LedgerSums& liquid) {
  if (!ranks) return;
  BoundsOverRanks bounds(liquid.bounds);
  double lowest = -static_cast<double>(liquid.tunnelled.lowest);
  OverRanks all(ranks);
  all.sum(liquid.mass).sum(liquid.nonfinite).sum(liquid.energy).sum(liquid.mass_float).sum(liquid.tunnelled.count);
  all.maximum(liquid.speed).maximum(liquid.square).maximum(lowest);
  bounds.visit(all);
  all.reduce();
  liquid.tunnelled.lowest = liquid.tunnelled.count > 0 ? static_cast<std::int64_t>(-lowest) : Tunnelled{}.lowest;
  liquid.bounds = bounds.bounds();
}

LedgerScale scale_of(const Constants& constants, const Fluid& fluid, const Cloth& cloth) {
  return {constants, std::max(static_cast<double>(fluid.particles.total), static_cast<double>(cloth.nodes.count))};
}

/// The sum of an array of quanta; it waits.
Quanta sum_of(const char* label, const Entries<const Quanta>& quanta, Index count) {
  Quanta sum = 0;
  if (count > 0)
    Kokkos::parallel_reduce(
        label, range(count), KOKKOS_LAMBDA(const Index i, Quanta& all) { all += quanta(i); }, sum);
  return sum;
}

void count_solute(const Constants& constants, const Fluid& fluid, const Cloth& cloth, const Accounts& accounts,
                  StepReport& report) {
  report.solute_fluid = sum_of("drench::ledger::solute_fluid", fluid.particles.solute, fluid.particles.count);
  OverRanks(constants.ranks).sum(report.solute_fluid).reduce();
  report.solute_cloth = sum_of("drench::ledger::solute_cloth", cloth.nodes.solute, cloth.nodes.count);
  report.solute_drained = accounts.solute_drained;
  report.solute_supplied = accounts.solute_supplied;
  report.solute_deposited = accounts.solute_deposited;
}

}  // namespace

static_assert(sizeof(LedgerSums) == 12 * sizeof(double) + 6 * sizeof(Real));

MemoryEstimate ledger_bytes(const Sizing& s) {
  const double edges = s.size.moving_cloth ? s.size.edges : 0, others = std::max(s.size.nodes, edges);
  MemoryEstimate sum;
  sum.particles =
      sum_room_bytes(partial_sums(s.size.fluid, s) + partial_sums(others, s), 12 * double_bytes + 6 * s.real);
  return sum;
}

SumPair<LedgerSums> measure(const Constants& constants, const Fluid& fluid, const Bodies& bodies, const Cloth& cloth,
                            Cached<StateMeasures>& measured) {
  const LedgerScale scale = scale_of(constants, fluid, cloth);
  const OfNodes others(constants, bodies, cloth, scale);
  auto sums = ordered_pair<LedgerSums>("drench::ledger::sums", fluid.particles.count, OfLiquid(constants, fluid, scale),
                                       others.count(), others);
  if (constants.ranks && fluid.particles.count == 0 &&
      fluid.tunnelled.data() != nullptr) {  // no particle has taken them
    copy_now(sums.first.tunnelled, fluid.tunnelled);
    Kokkos::deep_copy(exec(), fluid.tunnelled, Tunnelled{});
  }
  add_ranks(constants.ranks, sums.first);
  measured.fluid = sums.first.bounds;
  measured.fluid_speed = sums.first.speed;
  measured.node_speed = sums.second.speed;
  measured.set_made_from(fluid.particles.moved);
  return sums;
}

void ledger(const Constants& constants, const Fluid& fluid, const Bodies& bodies, const Cloth& cloth,
            Cached<StateMeasures>& measured, Accounts& accounts, const StepInfo& info, StepReport& report) {
  std::int64_t particles = fluid.particles.count;
  OverRanks(constants.ranks).sum(particles).reduce();
  report.particles = particles;
  report.mass_drained = accounts.drained;
  report.mass_supplied = accounts.supplied;
  report.mass_evaporated = accounts.evaporated;
  report.mass_float = 0;
  report.kinetic_energy = 0;
  report.nonfinite = 0;
  report.tunnelled = 0;
  report.lowest_tunnelled = -1;
  report.fluid_speed = report.cloth_speed = report.cloth_stretch = 0;
  const SumPair<LedgerSums> sums = measure(constants, fluid, bodies, cloth, measured);
  const LedgerScale scale = scale_of(constants, fluid, cloth);
  if (particles > 0) {
    report.mass_fluid = sums.first.mass;
    report.fluid_speed = std::sqrt(sums.first.square);
    report.tunnelled = sums.first.tunnelled.count;
    report.lowest_tunnelled = report.tunnelled > 0 ? sums.first.tunnelled.lowest : -1;
    add(report, sums.first, scale);
  }
  if (cloth.nodes.count > 0 || constants.model.has_moving_body()) {
    report.mass_cloth = sums.second.mass;
    report.cloth_speed = std::sqrt(sums.second.square);
    report.cloth_stretch = std::sqrt(sums.second.stretch);
    if (constants.model.has_porous()) report.saturation_max = sums.second.saturation;
    add(report, sums.second, scale);
  }
  if (constants.model.has_solute()) count_solute(constants, fluid, cloth, accounts, report);
  accounts.step = info.step + 1;
  accounts.time = info.time + info.dt;
}

}  // namespace drench::kokkos_backend
