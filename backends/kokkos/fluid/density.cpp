// Stage density (src/stages/density.hpp).

#include <cmath>
#include <cstring>

#include "cloth/boundary_edges.hpp"
#include "core/liquid_pairs.hpp"
#include "core/neighbor_search.hpp"
#include "coupling/body_response.hpp"
#include "coupling/sheet_rows.hpp"
#include "coupling/wall.hpp"
#include "coupling/wall_push.hpp"
#include "fluid/stages.hpp"
#include "fluid/wall_gain.hpp"
#include "host/isa.hpp"
#include "particles/coincident_pairs.hpp"
#include "particles/source_ramp.hpp"

namespace drench::kokkos_backend {
namespace {

// Where |Σ ∇W|² < 0.1 (Σ |∇W|)² at the sheets, the gradients nearly cancel (between two sheets): the contact yields.
constexpr Real least_push = Real(0.1);
constexpr Real same_volume = Real(1e-6);  // volumes that differ by less of themselves are the same

/// α of a diagonal, m²; 0 where it is less than the smallest or the particle has no volume.
KOKKOS_INLINE_FUNCTION Real inverse(Real diagonal, Real smallest, Real volume) {
  return diagonal < smallest || volume == 0 ? Real(0) : 1 / diagonal;
}

/// The part of ω for liquid at this density ratio, in scenes without cloth: eigenvalues grow with it.
KOKKOS_INLINE_FUNCTION Real crowd_share(Real ratio) { return smaller(Real(1), 2 / ratio); }

/// Volumes of the cloth samples, V_b = d³ S/Σ_k W_bk, and what the liquid's pairs read of them.
void sample_volumes(const Constants& constants, const NeighborLists& lists, Cloth& cloth) {
  const Kernel kernel = constants.kernel;
  const Real half = Real(0.5) * constants.spacing;
  const Entries<const Real3> x = cloth.samples.position, normal = cloth.samples.normal;
  const Entries<Real4> position = cloth.samples.position_volume, offset = cloth.samples.normal_offset;
  const Entries<Real> volume = cloth.samples.volume;
  const Neighbors list(lists.sample_sample);
  const Real share = Real(constants.model.layer_share);
  parallel(
      "drench::density::sample_volume", cloth.samples.count, KOKKOS_LAMBDA(const Index b) {
        Real sum = kernel.value(0);
        const Real3 here = x(b);
        list.for_each(b, [&](Index j) { sum += kernel.value(norm(here - x(j))); });
        volume(b) = share / sum;
        position(b) = {x(b), volume(b)};
        offset(b) = {half * normal(b), Real(0)};
      });
}

/// c_b of the Jacobi diagonal (src/stages/density.hpp), in samples.row_bound.
void sample_row_bounds(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, Cloth& cloth) {
  const Kernel kernel = constants.kernel;
  const Real rho = constants.rest_density;
  const Entries<const Real4> xs = cloth.samples.position_volume, offset = cloth.samples.normal_offset,
                             xf = fluid.position_volume;
  const Neighbors list(lists.sample_fluid);
  const Entries<Real> load = cloth.samples.row_load, bound = cloth.samples.row_bound;
  parallel(
      "drench::density::row_load", cloth.samples.count, KOKKOS_LAMBDA(const Index b) {
        Real g = 0;
        const Real4 at = xs(b);
        const Real3 behind = offset(b).xyz();
        const NeighborRow near = list.row(b);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Real4 particle = xf(near(k));
          const Real r = norm(from_behind(particle.xyz() - at.xyz(), behind));
          g -= rho * particle.w * kernel.grad_factor(r) * r;
        }
        load(b) = at.w * g;
      });
  fluid.exchange.share(cloth.samples.row_load, cloth.samples.count);
  node_bounds_from_samples("drench::density::node_row", cloth, load);
  const Entries<const Real> weight = cloth.samples.weight, node_bound = cloth.nodes.row_bound;
  const Entries<const Index> node = cloth.samples.node;
  parallel(
      "drench::density::row_bound", cloth.samples.count, KOKKOS_LAMBDA(const Index b) {
        Real c = 0;
        for (int k = 0; k < 3; ++k) c += weight(3 * b + k) * node_bound(node(3 * b + k));
        bound(b) = c;
      });
}

/// What the kernel sums up around a particle.
struct DensitySum {
  Real delta = 0;                                     // δ_i
  Real squares = 0, yielded = 0;                      // of the Jacobi diagonal, 1/m²
  Real coupling = 0;                                  // the sheets' share of it
  Real3 gradient, separation;                         // Σ V ∇W, 1/m; m
  Real3 walls, sheets;                                // of the gradient, 1/m: what solids and sheets have in it
  Real contact_diagonal = 0, contact_compliance = 0;  // of liquid that can touch sheets
  bool mixed = false;                                 // a neighbour has another volume
};

/// δ_i, the Jacobi diagonal, and what the pairs keep for the step.
struct DensityPairs {
  Kernel kernel;
  Real row_share;  // of the absolute row sums of cloth, in the Jacobi diagonal
  CoincidentPairs coincident;
  Entries<const Real4> position, xs, offset;  // x_i and V_i; x_b and V_b; ½ d n_b
  Entries<const Real3> xb;
  Entries<const Real> vb, bound;
  Entries<const std::int64_t> id;
  WritableLiquidNeighbors lf;
  WritableNeighbors lb;
  Neighbors ls;

#ifdef DRENCH_LANES
  /// Moves coincident particles apart; few rows have any.
  KOKKOS_INLINE_FUNCTION void add_separation(Index i, DensitySum& sum) const {
    const Real4 own = position(i);
    const NeighborRow near = lf.row(i);
    for (Index k = 0; k < near.count; ++k) {
      const Index j = near(k);
      const Real3 r = own.xyz() - position(j).xyz();
      const Real length = kernel.pair(dot(r, r)).length;
      if (length < coincident.least)
        sum.separation += coincident.displacement(r, length, own.w, position(j).w, id(i), id(j));
    }
  }
#else
  /// The liquid's pairs; a host takes several at once (density_rows.inl).
  KOKKOS_INLINE_FUNCTION void add_liquid(Index i, DensitySum& sum) const {
    const Real3 xi = position(i).xyz();
    const Real vi = position(i).w;
    sum.delta = vi * kernel.value(0);
    lf.keep_factors(i, [&](Index j) {
      const Real4 at = position(j);
      const Real3 r = xi - at.xyz();
      const Real square = dot(r, r);
      const Kernel::Pair pair = kernel.pair(square);
      const Real weighted = at.w * pair.grad_factor;
      sum.delta += at.w * pair.value;
      sum.gradient += weighted * r;
      const Real steep = weighted * pair.grad_factor * square;
      sum.squares += steep;
      sum.yielded += larger(Real(0), at.w - vi) * steep;
      if (Kokkos::fabs(at.w - vi) > same_volume * vi) sum.mixed = true;
      if (pair.length < coincident.least)
        sum.separation += coincident.displacement(r, pair.length, vi, at.w, id(i), id(j));
      return weighted;
    });
    sum.squares *= vi;
  }
#endif
  KOKKOS_INLINE_FUNCTION void add_walls(Index i, DensitySum& sum) const {
    const Real3 xi = position(i).xyz();
    const WritableRow walls = lb.row(i);
    for (Index k = 0; k < walls.count; ++k) {
      const Index b = walls(k);
      const Real3 r = xi - xb(b);
      const Real length = norm(r);
      const Real factor = vb(b) * kernel.grad_factor(length);
      walls.grad_factor(k) = factor;
      sum.delta += vb(b) * kernel.value(length);
      sum.walls += mirrored * factor * r;
    }
    sum.gradient += sum.walls;
  }
  KOKKOS_INLINE_FUNCTION void set_flags(Index i, bool solids, bool sheets, const DensitySum& sum) const {
    if (!compact_pairs) return;
    const bool is_bounded = (solids && lb.count(i) > 0) || (sheets && ls.count(i) > 0);
    lf.flags(i) = static_cast<std::uint8_t>((sum.mixed ? mixed_volumes : 0) | (is_bounded ? bounded : 0));
  }
  KOKKOS_INLINE_FUNCTION void add_sheets(Index i, bool touching, DensitySum& sum) const {
    const Real3 xi = position(i).xyz();
    Real3 sheet;
    Real lengths = 0;  // of what `sheet` sums up, with `mirrored`
    ls.for_each(i, [&](Index b) {
      const Real4 at = xs(b);
      const Real3 r = from_behind(xi - at.xyz(), offset(b).xyz());
      const Real length = norm(r), factor = at.w * kernel.grad_factor(length);
      sum.delta += at.w * kernel.value(length);
      sheet += (mirrored * factor) * r;
      lengths -= mirrored * factor * length;
      sum.coupling -= mirrored * mirrored * row_share * factor * length * bound(b);
    });
    const Real dense = image_density(sum.delta);
    sheet = dense * sheet;
    lengths *= dense;
    sum.sheets = sheet;
    sum.gradient += sheet;
    sum.coupling *= dense * dense;
    if (!touching) return;
    const Real square = dot(sheet, sheet), yields = least_push * lengths * lengths - square;
    sum.contact_compliance = larger(yields, Real(0));
    sum.contact_diagonal = square + sum.contact_compliance + sum.coupling;
  }
};

}  // namespace
}  // namespace drench::kokkos_backend

#define DRENCH_ISA_FILE "fluid/density_rows.inl"
#include "host/for_each_isa.hpp"

namespace drench::kokkos_backend {
namespace {

void density_and_alpha(const Constants& constants, Fluid& fluid, NeighborLists& lists, const Bodies& bodies,
                       const Cloth& cloth) {
  const Real smallest = Real(1e-6) / (constants.spacing * constants.spacing);
  const bool solids = bodies.boundary.count > 0, sheets = cloth.samples.count > 0,
             touching = has_sheet_contact(constants, cloth);
  LiquidList& liquid = lists.fluid_fluid;
  if constexpr (compact_pairs)
    make_room(liquid.flags, "drench::pair_flags", fluid.particles.capacity());
  else
    make_room(liquid.grad_factor, "drench::pair_grad_factor", liquid.entry.extent(0));
  if (solids)
    make_room(lists.fluid_boundary.grad_factor, "drench::wall_grad_factor", lists.fluid_boundary.entry.extent(0));
  const DensityPairs pairs{.kernel = constants.kernel,
                           .row_share = Real(constants.model.row_share()),
                           .coincident = CoincidentPairs(constants.spacing),
                           .position = fluid.position_volume,
                           .xs = cloth.samples.position_volume,
                           .offset = cloth.samples.normal_offset,
                           .xb = bodies.boundary.position,
                           .vb = bodies.boundary.volume,
                           .bound = cloth.samples.row_bound,
                           .id = fluid.particles.id,
                           .lf = WritableLiquidNeighbors(liquid),
                           .lb = WritableNeighbors(lists.fluid_boundary),
                           .ls = Neighbors(lists.fluid_sample)};
  const bool extrapolates = constants.model.extrapolates_walls();
  const Entries<const Real3> diagonal = std::as_const(fluid).wall_gain.diagonal,
                             shear = std::as_const(fluid).wall_gain.shear;
  const Entries<Real> ratio = fluid.particles.density_ratio, alpha = fluid.alpha, compliance = fluid.compliance,
                      contact = fluid.contact.alpha, contact_yields = fluid.contact.compliance;
  const Entries<Real3> separation = fluid.separation, boundary = fluid.boundary_gradient,
                       sheet = fluid.contact.gradient;
#ifdef DRENCH_LANES
  const auto add_liquid = DRENCH_BY_ISA(add_liquid_lanes);
#endif
  parallel(
      "drench::density::ratio_alpha", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Real vi = pairs.position(i).w;
        DensitySum sum;
#ifdef DRENCH_LANES
        add_liquid(pairs, i, sum);
#else
        pairs.add_liquid(i, sum);
#endif
        pairs.set_flags(i, solids, sheets, sum);
        if (solids) pairs.add_walls(i, sum);
        const Real stiffer = extrapolates ? largest_gain(diagonal(i), shear(i)) : Real(1);
        if (sheets) pairs.add_sheets(i, touching, sum);
        if (solids || sheets) boundary(i) = sum.walls + sum.sheets;
        if (touching) {
          sheet(i) = sum.sheets;
          contact_yields(i) = sum.contact_compliance;
          contact(i) = inverse(sum.contact_diagonal + (stiffer - 1) * dot(sum.sheets, sum.sheets), smallest, vi);
        }
        ratio(i) = sum.delta;
        compliance(i) = sum.yielded;
        separation(i) = sum.separation;
        alpha(i) = (sheets ? Real(1) : crowd_share(sum.delta)) *
                   inverse(stiffer * (dot(sum.gradient, sum.gradient) + sum.squares) + sum.yielded + sum.coupling,
                           smallest, vi);
      });
}

/// Leaves α' only to liquid that touches a sheet (src/stages/pressure.hpp).
void find_contact(const Constants& constants, const Cloth& cloth, Fluid& fluid) {
  const BoundaryEdges edges(cloth);
  const Entries<const Index> nearest = fluid.nearest_sample;
  const Entries<const Real3> x = fluid.particles.position, xs = cloth.samples.position, normal = cloth.samples.normal;
  const Entries<Real> contact = fluid.contact.alpha;
  const Real touch = Real(0.1) * constants.spacing, reach = Real(1.25) * constants.spacing, limit = reach * reach;
  parallel(
      "drench::density::touch", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Index p = nearest(i);
        if (p >= 0) {
          const Real3 r = x(i) - xs(p), n = normal(p);
          const Real height = dot(r, n);
          if (Kokkos::fabs(height) < touch && edges.on_sheet(p, xs(p), r - height * n, limit)) return;
        }
        contact(i) = 0;
      });
}

/// Mean of β_i max(0, δ_i − 1) over the liquid. Waits for the device.
double mean_compression(const Communicator* ranks, const Fluid& fluid, Real ramp) {
  if (fluid.particles.total == 0) return 0;
  const ErrorScale scale(static_cast<double>(fluid.particles.total), 1);
  const Entries<const std::uint8_t> origin = fluid.particles.origin;
  const Entries<const Real> age = fluid.particles.age, alpha = fluid.alpha, ratio = fluid.particles.density_ratio;
  const auto term = KOKKOS_LAMBDA(const Index i) {
    if (alpha(i) == 0) return std::int64_t{0};
    return scale(source_ramp(origin(i), age(i), ramp) * larger(ratio(i) - 1, Real(0)));
  };
  std::int64_t sum = ordered<std::int64_t>("drench::density::found", fluid.particles.count, term);
  OverRanks(ranks).sum(sum).reduce();
  return scale.value(sum) / static_cast<double>(fluid.particles.total);
}

void allocate(Fluid& fluid, bool boundary, bool extrapolates, bool touching) {
  const std::size_t n = fluid.particles.capacity();
  make_room(fluid.volume, "drench::fluid_volume", n);
  make_room(fluid.position_volume, "drench::fluid_position_volume", n);
  make_room(fluid.alpha, "drench::fluid_alpha", n);
  make_room(fluid.compliance, "drench::fluid_compliance", n);
  make_room(fluid.separation, "drench::fluid_separation", n);
  if (boundary) make_room(fluid.boundary_gradient, "drench::fluid_boundary_gradient", n);
  if (extrapolates) {
    make_room(fluid.wall_gain.diagonal, "drench::fluid_wall_gain", n);
    make_room(fluid.wall_gain.shear, "drench::fluid_wall_gain_shear", n);
  }
  if (!touching) return;
  make_room(fluid.contact.gradient, "drench::contact_gradient", n);
  make_room(fluid.contact.alpha, "drench::contact_alpha", n);
  make_room(fluid.contact.compliance, "drench::contact_compliance", n);
}

}  // namespace

MemoryEstimate density_bytes(const Sizing& s) {
  const double r = s.real;
  double particle = 10 * r;
  if (s.size.samples > 0 || s.size.boundary > 0) particle += 3 * r;  // boundary_gradient
  const bool extrapolates = s.size.scene.fluid.wall_pressure == WallPressure::extrapolated;
  if (s.size.boundary > 0 && extrapolates) particle += 6 * r;  // wall_gain
  if (s.size.samples > 0) particle += 5 * r;                   // contact
  particle += wall_push_bytes(s);
  if (s.compact_pairs()) particle += 1;  // flags
  MemoryEstimate sum;
  sum.particles = particle_room(s) * particle;
  if (!(s.size.fluid > 0)) return sum;
  if (s.size.samples > 0) sum.lists += sheet_row_bytes(s);
  if (s.size.boundary > 0) sum.lists += room_for_entries(s.entries.fluid_boundary) * r;
  return sum;
}

void density(const Constants& constants, Fluid& fluid, NeighborLists& lists, Bodies& bodies, Cloth& cloth,
             StepReport& report) {
  const bool touching = has_sheet_contact(constants, cloth);
  allocate(fluid, bodies.boundary.count > 0 || cloth.samples.count > 0, constants.model.extrapolates_walls(), touching);
  const Entries<Real> volume = fluid.volume;
  const Entries<const Quanta> mass = fluid.particles.mass;
  const Entries<const Real3> x = fluid.particles.position;
  const Entries<Real4> position = fluid.position_volume;
  const double scale = constants.quantum / double(constants.rest_density);
  parallel(
      "drench::density::volume", fluid.particles.local(), KOKKOS_LAMBDA(const Index i) {
        volume(i) = Real(double(mass(i)) * scale);
        position(i) = {x(i), volume(i)};
      });
  if (cloth.samples.count > 0) {
    refresh_inverse_mass(constants, cloth);
    if (fluid.particles.total > 0) {
      sample_volumes(constants, lists, cloth);
      sample_row_bounds(constants, fluid, lists, cloth);
    }
  }
  if (constants.model.extrapolates_walls()) find_wall_gain(constants, lists, bodies, fluid);
  density_and_alpha(constants, fluid, lists, bodies, cloth);
  if (touching) find_contact(constants, cloth, fluid);
  if (cloth.samples.count > 0) {
    fluid.exchange.halo(fluid.particles.density_ratio);
    make_sheet_rows(constants, fluid, cloth, lists);
  }
  add_body_rows(constants, lists, bodies, fluid);
  if (constants.model.scene.time.mode == TimeMode::error)
    report.density_found = mean_compression(constants.ranks, fluid, cloth.emission_ramp);
}

}  // namespace drench::kokkos_backend
