// Stage measures (src/stages/measures.hpp).

#include <algorithm>
#include <cmath>

#include "device.hpp"
#include "device_copy.hpp"
#include "primitives/reduce.hpp"

namespace drench::kokkos_backend {
namespace {

/// Per particle: the distance to the nearest one within h, m (2 h if there is none), and whether any is too close, 1 or 0.
void find_nearest(Device& d) {
  auto& w = d.measures_work;
  make_room(w.nearest, "drench::measures::nearest", 2 * static_cast<std::size_t>(d.fluid.count));
  w.cells.build(d.fluid.position, d.fluid.count, d.support, d.fluid.id);
  const CellTableView cells = w.cells.view();
  const auto x = d.fluid.position;
  const auto nearest = w.nearest;
  const auto mass = d.fluid.mass;
  const Real h = d.support, half = d.spacing / 4;  // of a full particle's radius
  parallel(
      "drench::measures::nearest", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
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

void crowding(Device& d, StepReport& report) {
  find_nearest(d);
  const auto nearest = d.measures_work.nearest;
  const Real h = d.support, spacing = d.spacing;
  const ThreeSums sums = ordered<ThreeSums>(
      "drench::measures::crowding", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Real r = nearest(2 * i);
        const double q = double(r) / double(spacing);
        return r < h ? ThreeSums{1, q, q * q} : ThreeSums{};
      });
  const std::int64_t close = integer_sum(
      "drench::measures::close", d.fluid.count,
      KOKKOS_LAMBDA(const Index i) { return std::int64_t(nearest(2 * i + 1)); });
  report.close_share = double(close) / double(d.fluid.count);
  if (!(sums.first > 0)) return;
  const double mean = sums.second / sums.first;
  report.nearest_variance = std::max(0.0, sums.third / sums.first - mean * mean);
}

/// (u, v) of every node, m.
void place_nodes(Device& d) {
  const ClothMesh& mesh = d.model.mesh;
  std::vector<double> place;
  for (std::size_t n = 0; n < mesh.rest_position.size(); ++n) {
    const ClothMaterial& cloth = d.model.cloths[static_cast<std::size_t>(mesh.node_cloth[n])];
    for (const Vec3& axis : cloth.rest_plane) {
      double sum = 0;
      for (std::size_t a = 0; a < 3; ++a) sum += axis[a] * (mesh.rest_position[n][a] - cloth.rest_center[a]);
      place.push_back(sum);
    }
  }
  d.measures_work.place = to_device<double>("drench::measures::place", place);
}

/// λ_min/λ_max of M = [uu, uv; uv, vv].
double eigenvalue_ratio(double uu, double uv, double vv, double size) {
  const double middle = (uu + vv) / 2, radius = std::hypot((uu - vv) / 2, uv);
  return middle + radius > 1e-12 * size ? std::max(0.0, (middle - radius) / (middle + radius)) : 0;
}

double isotropy(Device& d, const ClothMaterial& cloth, double& mass) {
  const auto place = d.measures_work.place;
  const auto liquid = d.nodes.liquid;
  const Index first = cloth.first_node;
  const ThreeSums mean = ordered<ThreeSums>(
      "drench::measures::patch_mean", cloth.node_count, KOKKOS_LAMBDA(const Index k) {
        const Index n = first + k;
        const double m = double(liquid(n));
        return ThreeSums{m, m * place(2 * n), m * place(2 * n + 1)};
      });
  mass = mean.first;
  if (!(mass > 0)) return 0;
  const double u = mean.second / mass, v = mean.third / mass;
  const ThreeSums moment = ordered<ThreeSums>(
      "drench::measures::patch_moment", cloth.node_count, KOKKOS_LAMBDA(const Index k) {
        const Index n = first + k;
        const double m = double(liquid(n)), a = place(2 * n) - u, b = place(2 * n + 1) - v;
        return ThreeSums{m * a * a, m * a * b, m * b * b};
      });
  const double uu = moment.first / mass, vv = moment.third / mass;
  return eigenvalue_ratio(uu, moment.second / mass, vv, uu + vv + u * u + v * v);
}

}  // namespace

void measures(Device& d, const StepInfo&, StepReport& report) {
  if (d.fluid.count > 0) crowding(d, report);
  if (!d.model.has_porous()) return;
  if (d.measures_work.place.extent(0) == 0) place_nodes(d);
  double all = 0, sum = 0;
  for (const ClothMaterial& cloth : d.model.cloths) {
    if (!cloth.porous) continue;
    double mass = 0;
    sum += isotropy(d, cloth, mass) * mass;
    all += mass;
  }
  if (all > 0) report.wet_isotropy = sum / all;
}

}  // namespace drench::kokkos_backend
