// Stage density (src/stages/density.hpp).

#include "device.hpp"
#include "laws/crowding.hpp"
#include "laws/rim.hpp"
#include "laws/wall.hpp"
#include "pressure_system.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {
namespace {

// Of the absolute row sum: with the solves' relaxation ω ≤ 0.32 half of that bounds the iteration (Gershgorin).
constexpr Real row_share = Real(0.16);
// Of (Σ |gradients|)² at the sheets: where the square of the sum is less, the contact yields.
constexpr Real least_push = Real(0.1);

/// α of a diagonal, m²; 0 where it is less than the smallest or the particle has no volume.
KOKKOS_INLINE_FUNCTION Real inverse(Real diagonal, Real smallest, Real volume) {
  return diagonal < smallest || volume == 0 ? Real(0) : 1 / diagonal;
}

/// Volumes of the cloth samples, V_b = d³ S/Σ_k W_bk, and what the liquid's pairs read of them.
void sample_volumes(Device& d) {
  const Kernel kernel = d.kernel;
  const Real half = Real(0.5) * d.spacing;
  const Entries<Real3> x = d.samples.position, normal = d.samples.normal;
  const Entries<Real4> place = d.samples.place, back = d.samples.back;
  const Entries<Real> volume = d.samples.volume;
  const Neighbors list(d.sample_sample);
  const Real share = Real(d.model.layer_share);
  parallel(
      "drench::density::sample_volume", d.samples.count, KOKKOS_LAMBDA(const Index b) {
        Real sum = kernel.value(0);
        const Real3 here = x(b);
        const NeighborRow near = list.row(b);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) sum += kernel.value(norm(here - x(near(k))));
        volume(b) = share / sum;
        place(b) = {x(b), volume(b)};
        back(b) = {half * normal(b), Real(0)};
      });
}

/// Room beside each of a list's entries; what was there is lost if it grows.
template <class T>
void make_room_beside(const NeighborList& list, Array<T>& kept, const char* label) {
  const std::size_t entries = list.entry.extent(0);
  if (kept.extent(0) == entries) return;
  kept = {};  // free before allocating
  kept = Array<T>(Kokkos::ViewAllocateWithoutInitializing(label), entries);
}

/// c_b of the Jacobi diagonal (src/stages/density.hpp), in samples.row_bound.
void sample_row_bounds(Device& d) {
  const Kernel kernel = d.kernel;
  const Real rho = d.rest_density;
  const Entries<Real4> xs = d.samples.place, back = d.samples.back, xf = d.work.place;
  const Neighbors list(d.sample_fluid);
  const auto load = d.samples.row_load, bound = d.samples.row_bound;
  parallel(
      "drench::density::row_load", d.samples.count, KOKKOS_LAMBDA(const Index b) {
        Real g = 0;
        const Real4 at = xs(b);
        const Real3 behind = back(b).xyz();
        const NeighborRow near = list.row(b);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Real4 particle = xf(near(k));
          const Real r = norm(from_behind(particle.xyz() - at.xyz(), behind));
          g -= rho * particle.w * kernel.slope(r) * r;
        }
        load(b) = at.w * g;
      });
  node_bounds_from_samples("drench::density::node_row", d, load);
  const auto weight = d.samples.weight, node_bound = d.nodes.row_bound;
  const auto node = d.samples.node;
  parallel(
      "drench::density::row_bound", d.samples.count, KOKKOS_LAMBDA(const Index b) {
        Real c = 0;
        for (int k = 0; k < 3; ++k) c += weight(3 * b + k) * node_bound(node(3 * b + k));
        bound(b) = c;
      });
}

void density_and_alpha(Device& d) {
  const Kernel kernel = d.kernel;
  const Real smallest = Real(1e-6) / (d.spacing * d.spacing);
  const Entries<Real3> xb = d.boundary.position, shift = d.work.shift;
  const Entries<Real> vb = d.boundary.volume, bound = d.samples.row_bound, ratio = d.fluid.density_ratio,
                      alpha = d.work.alpha, compliance = d.work.compliance;
  const Entries<Real4> place = d.work.place, xs = d.samples.place, back = d.samples.back;
  const Crowding crowding(d.spacing);
  const Entries<std::int64_t> id = d.fluid.id;
  const bool solids = d.boundary.count > 0, cloth = d.samples.count > 0, touching = has_contact(d);
  const Entries<Real> contact = d.work.contact.alpha, contact_yields = d.work.contact.compliance;
  make_room_beside(d.fluid_fluid, d.fluid_fluid.slope, "drench::pair_slope");
  if (cloth) make_room_beside(d.fluid_sample, d.fluid_sample.gradient, "drench::sample_gradient");
  const Entries<Real3> sheet_gradient = d.fluid_sample.gradient;
  const Neighbors lf = d.fluid_fluid, lb = d.fluid_boundary, ls = d.fluid_sample;
  parallel(
      "drench::density::ratio_alpha", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = place(i).xyz();
        const Real vi = place(i).w;
        Real delta = vi * kernel.value(0), squares = 0, yielded = 0, coupling = 0;
        Real3 gradient, apart;
        const NeighborRow near = lf.row(i);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Index j = near(k);
          const Real4 at = place(j);
          const Real3 r = xi - at.xyz();
          const Real square = dot(r, r);
          const Kernel::Pair pair = kernel.pair(square);
          const Real weighted = at.w * pair.slope;
          near.slope(k) = weighted;
          delta += at.w * pair.value;
          gradient += weighted * r;
          const Real steep = weighted * pair.slope * square;
          squares += steep;
          yielded += Kokkos::fmax(Real(0), at.w - vi) * steep;
          if (pair.length < crowding.least) apart += crowding.shift(r, pair.length, vi, at.w, id(i), id(j));
        }
        squares *= vi;
        if (solids) {
          const NeighborRow walls = lb.row(i);
          for (Index k = 0; k < walls.count; ++k) {
            const Index b = walls(k);
            const Real3 r = xi - xb(b);
            const Real length = norm(r);
            delta += vb(b) * kernel.value(length);
            gradient += mirrored * vb(b) * kernel.slope(length) * r;
          }
        }
        if (cloth) {
          Real3 sheet;
          Real lengths = 0;  // of what `sheet` sums up
          const NeighborRow sheets = ls.row(i);
          for (Index k = 0; k < sheets.count; ++k) {
            const Index b = sheets(k);
            const Real4 at = xs(b);
            const Real3 r = from_behind(xi - at.xyz(), back(b).xyz());
            const Real length = norm(r), slope = at.w * kernel.slope(length);
            const Real3 g = slope * r;
            sheet_gradient(sheets.place(k)) = g;
            delta += at.w * kernel.value(length);
            sheet += mirrored * g;
            lengths -= mirrored * slope * length;
            coupling -= mirrored * mirrored * row_share * slope * length * bound(b);
          }
          const Real dense = image_density(delta);
          sheet = dense * sheet;
          lengths *= dense;
          gradient += sheet;
          coupling *= dense * dense;
          if (touching) {
            const Real square = dot(sheet, sheet), yields = least_push * lengths * lengths - square;
            contact_yields(i) = Kokkos::fmax(yields, Real(0));
            contact(i) = inverse(square + contact_yields(i) + coupling, smallest, vi);
          }
        }
        ratio(i) = delta;
        compliance(i) = yielded;
        shift(i) = apart;
        alpha(i) = inverse(dot(gradient, gradient) + squares + yielded + coupling, smallest, vi);
      });
}

/// Leaves α' only to liquid that touches a sheet (src/stages/pressure.hpp).
void find_contact(Device& d) {
  const Rims rims{d.samples.rim, d.mesh.rim, d.nodes.position};
  const Entries<Index> nearest = d.work.nearest_sample;
  const Entries<Real3> x = d.fluid.position, xs = d.samples.position, normal = d.samples.normal;
  const Entries<Real> contact = d.work.contact.alpha;
  const Real touch = Real(0.1) * d.spacing, reach = Real(1.25) * d.spacing, limit = reach * reach;
  parallel(
      "drench::density::touch", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Index p = nearest(i);
        if (p >= 0) {
          const Real3 r = x(i) - xs(p), n = normal(p);
          const Real height = dot(r, n);
          if (Kokkos::fabs(height) < touch && rims.on_sheet(p, xs(p), r - height * n, limit)) return;
        }
        contact(i) = 0;
      });
}

/// The arrays of the contact, as long as those of the liquid.
void make_contact(SheetContact& contact, Index capacity) {
  if (static_cast<Index>(contact.alpha.extent(0)) == capacity) return;
  for (Array<Real>* a :
       {&contact.alpha, &contact.compliance, &contact.push, &contact.next, &contact.last, &contact.rate}) {
    *a = {};  // free before allocating
    *a = Array<Real>(Kokkos::ViewAllocateWithoutInitializing("drench::sheet_contact"), capacity);
  }
}

}  // namespace

void density(Device& d, const StepInfo&, StepReport&) {
  const auto volume = d.work.volume;
  const auto mass = d.fluid.mass;
  const auto x = d.fluid.position;
  const auto place = d.work.place;
  const double scale = d.quantum / double(d.rest_density);
  parallel(
      "drench::density::volume", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        volume(i) = Real(double(mass(i)) * scale);
        place(i) = {x(i), volume(i)};
      });
  if (d.samples.count > 0) {
    refresh_inverse_mass(d);
    sample_volumes(d);
    sample_row_bounds(d);
  }
  if (has_contact(d)) make_contact(d.work.contact, static_cast<Index>(d.work.alpha.extent(0)));
  density_and_alpha(d);
  if (has_contact(d)) find_contact(d);
  add_body_rows(d);
}

}  // namespace drench::kokkos_backend
