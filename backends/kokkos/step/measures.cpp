// Stage measures (src/stages/measures.hpp).

#include "step/measures.hpp"

#include <algorithm>
#include <cmath>

#include "core/host_copy.hpp"
#include "core/reduce.hpp"
#include "setup/rest_plane.hpp"

namespace drench::kokkos_backend {
namespace {

/// Per particle: the distance to the nearest one within h, m (2 h if there is none), and whether any is too close, 1 or
/// 0.
void find_nearest(const Constants& constants, Fluid& particles, MeasuresWork& work) {
  particles.exchange.migrate(particles.particles);
  particles.exchange.find_ghosts(particles.particles);
  const Fluid& fluid = particles;
  make_room(work.nearest, "drench::measures::nearest", 2 * static_cast<std::size_t>(fluid.particles.count));
  work.cells.build(fluid.particles.position, fluid.particles.local(), constants.support, fluid.particles.id);
  const CellTableView cells = work.cells.view();
  const Entries<const Real3> x = fluid.particles.position;
  const Entries<Real> nearest = work.nearest;
  const Entries<const Quanta> mass = fluid.particles.mass;
  const Real h = constants.support, half = constants.spacing / 4;  // of a full particle's radius
  parallel(
      "drench::measures::nearest", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        Real least = h * h;
        bool close = false;
        const Real own = half * Kokkos::cbrt(Real(double(mass(i)) / double(quanta_per_particle)));
        cells.for_near(x(i), [&](const Index j) {
          if (j == i) return;
          const Real3 r = x(j) - x(i);
          const Real r2 = dot(r, r),
                     near = own + half * Kokkos::cbrt(Real(double(mass(j)) / double(quanta_per_particle)));
          if (r2 < near * near) close = true;
          if (r2 < least) least = r2;
        });
        nearest(2 * i) = least < h * h ? Kokkos::sqrt(least) : 2 * h;
        nearest(2 * i + 1) = close ? 1 : 0;
      });
}

/// Particles that have another one too close, and one within h; the distances to the nearest, over d, and their
/// squares.
struct NearestSums {
  std::int64_t close = 0, count = 0;
  ExactSum distance, square;
  KOKKOS_INLINE_FUNCTION NearestSums& operator+=(const NearestSums& o) {
    close += o.close;
    count += o.count;
    distance += o.distance;
    square += o.square;
    return *this;
  }
  void visit(OverRanks& all) { all.sum(close).sum(count).sum(distance).sum(square); }
};

void clumping(const Constants& constants, Fluid& fluid, MeasuresWork& work, StepReport& report) {
  find_nearest(constants, fluid, work);
  const Entries<const Real> nearest = work.nearest;
  const Real h = constants.support, spacing = constants.spacing;
  const ExactScale scale(static_cast<double>(fluid.particles.total), 1);
  const NearestSums sums = over_ranks(
      constants.ranks, ordered<NearestSums>(
                           "drench::measures::nearest_sums", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
                             const Real r = nearest(2 * i);
                             const double q = double(r) / double(spacing);
                             NearestSums own;
                             own.close = std::int64_t(nearest(2 * i + 1));
                             if (r < h) own = {own.close, 1, scale(q), scale(q * q)};
                             return own;
                           }));
  report.close_share = double(sums.close) / double(fluid.particles.total);
  if (sums.count == 0) return;
  const double mean = scale.value(sums.distance) / double(sums.count);
  report.nearest_variance = std::max(0.0, scale.value(sums.square) / double(sums.count) - mean * mean);
}

/// (u, v) of every node, m.
void place_nodes(const Constants& constants, MeasuresWork& work) {
  work.rest_uv = to_device<double>("drench::measures::rest_uv", places_in_rest_planes(constants.model));
}

/// λ_min/λ_max of M = [uu, uv; uv, vv].
double eigenvalue_ratio(double uu, double uv, double vv, double size) {
  const double middle = (uu + vv) / 2, radius = std::hypot((uu - vv) / 2, uv);
  return middle + radius > 1e-12 * size ? std::max(0.0, (middle - radius) / (middle + radius)) : 0;
}

double isotropy(const Cloth& cloth, const MeasuresWork& work, const ClothMaterial& material, double& mass) {
  const Entries<const double> rest_uv = work.rest_uv;
  const Entries<const Quanta> liquid = cloth.nodes.liquid;
  const Index first = material.first_node;
  const ThreeSums mean = ordered<ThreeSums>(
      "drench::measures::patch_mean", material.node_count, KOKKOS_LAMBDA(const Index k) {
        const Index n = first + k;
        const double m = double(liquid(n));
        return ThreeSums{m, m * rest_uv(2 * n), m * rest_uv(2 * n + 1)};
      });
  mass = mean.first;
  if (!(mass > 0)) return 0;
  const double u = mean.second / mass, v = mean.third / mass;
  const ThreeSums moment = ordered<ThreeSums>(
      "drench::measures::patch_moment", material.node_count, KOKKOS_LAMBDA(const Index k) {
        const Index n = first + k;
        const double m = double(liquid(n)), a = rest_uv(2 * n) - u, b = rest_uv(2 * n + 1) - v;
        return ThreeSums{m * a * a, m * a * b, m * b * b};
      });
  const double uu = moment.first / mass, vv = moment.third / mass;
  return eigenvalue_ratio(uu, moment.second / mass, vv, uu + vv + u * u + v * v);
}

}  // namespace

MemoryEstimate measures_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (!s.size.measures) return sum;
  sum.particles = particle_room(s) * 2 * s.real;
  sum.cells = cell_table_bytes(s.size.fluid, s.size.fluid_cells, s);
  sum.cloth = s.size.nodes * 2 * double_bytes;
  return sum;
}

void measures(const Constants& constants, Fluid& fluid, const Cloth& cloth, MeasuresWork& work, StepReport& report) {
  if (fluid.particles.total > 0) clumping(constants, fluid, work, report);
  if (!constants.model.has_porous()) return;
  if (work.rest_uv.extent(0) == 0) place_nodes(constants, work);
  double all = 0, sum = 0;
  for (const ClothMaterial& material : constants.model.cloths) {
    if (!material.porous) continue;
    double mass = 0;
    sum += isotropy(cloth, work, material, mass) * mass;
    all += mass;
  }
  if (all > 0) report.wet_isotropy = sum / all;
}

}  // namespace drench::kokkos_backend
