#include "setup/body_sampling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "base/eigen_vec.hpp"
#include "setup/deforming_body.hpp"
#include "setup/distance_field.hpp"
#include "setup/point_grid.hpp"
#include "setup/surface_mesh.hpp"
#include "state/keyed_motion.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

/// Lattice points min + i·step, i = 0 … n, of which [lo, hi] lie in the region.
struct Axis {
  double min, max, step;
  double n, lo, hi;  // whole numbers: a double counts what would overflow an integer
  Axis(const Box& box, const Box& region, int a, double spacing) : min(box.min[a]), max(box.max[a]) {
    n = std::max(1.0, std::ceil((max - min) / spacing - 1e-9));
    step = (max - min) / n;
    lo = std::clamp(std::ceil((region.min[a] - min) / step), 0.0, n + 1);
    hi = std::clamp(std::floor((region.max[a] - min) / step), -1.0, n);
  }
  double count() const { return std::max(0.0, hi - lo + 1); }
  double inner_count() const { return std::max(0.0, std::min(hi, n - 1) - std::max(lo, 1.0) + 1); }
  bool is_end(double i) const { return i == 0 || i == n; }
  double at(double i) const { return i == n ? max : min + i * step; }
};

struct BoxLattice {
  Axis x, y, z;
  BoxLattice(const Box& box, const Box& region, double d)
      : x(box, region, 0, d), y(box, region, 1, d), z(box, region, 2, d) {}
  double count() const {
    return x.count() * y.count() * z.count() - x.inner_count() * y.inner_count() * z.inner_count();
  }
};

/// A lattice with steps ≤ d on the six faces, edges and corners once.
std::vector<Vec3> sample_box(const BoxLattice& lattice) {
  const auto& [x, y, z] = lattice;
  std::vector<Vec3> samples;
  samples.reserve(static_cast<std::size_t>(lattice.count()));
  for (double i = x.lo; i <= x.hi; ++i) {
    for (double j = y.lo; j <= y.hi; ++j) {
      if (x.is_end(i) || y.is_end(j)) {
        for (double k = z.lo; k <= z.hi; ++k) samples.push_back({x.at(i), y.at(j), z.at(k)});
      } else {
        if (z.lo <= 0 && z.hi >= 0) samples.push_back({x.at(i), y.at(j), z.min});
        if (z.lo <= z.n && z.hi >= z.n) samples.push_back({x.at(i), y.at(j), z.max});
      }
    }
  }
  return samples;
}

double sphere_count(double radius, double d) {
  return std::max(1.0, std::round(4 * std::numbers::pi * radius * radius / (d * d)));
}

/// 4πR²/d² points of a Fibonacci lattice.
std::vector<Vec3> sample_sphere(const Body& body, double d, const Box& region) {
  const double n = sphere_count(body.radius, d);
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<Vec3> samples;
  for (double i = 0; i < n; ++i) {
    const double y = 1 - (2 * i + 1) / n, ring = std::sqrt(1 - y * y), phi = golden_angle * i;
    const Vec3 x{body.center[0] + body.radius * ring * std::cos(phi), body.center[1] + body.radius * y,
                 body.center[2] + body.radius * ring * std::sin(phi)};
    if (contains(region.min, region.max, x)) samples.push_back(x);
  }
  return samples;
}

/// Along two axes when the plane is normal to the third, so that the lattice is aligned with boxes.
std::array<Vector3d, 2> plane_tangents(const Body& body) {
  const Vector3d normal = to_eigen(body.normal);
  int smallest = 0;
  normal.cwiseAbs().minCoeff(&smallest);
  const Vector3d u = normal.cross(Vector3d::Unit(smallest)).normalized();
  return {u, normal.cross(u)};
}

/// Calls row(origin, step, first, last) for each row of the plane's lattice: points origin + j·step, first ≤ j ≤ last.
void plane_rows(const Body& body, double d, const Box& region,
                const std::function<void(const Vector3d&, const Vector3d&, double, double)>& row) {
  const Vector3d origin = to_eigen(body.point);
  const auto [u, v] = plane_tangents(body);
  double u_min = std::numeric_limits<double>::infinity(), u_max = -u_min;
  for (int corner = 0; corner < 8; ++corner) {
    Vector3d c;
    for (int a = 0; a < 3; ++a) c[a] = (corner >> a & 1 ? region.max : region.min)[a];
    u_min = std::min(u_min, u.dot(c - origin));
    u_max = std::max(u_max, u.dot(c - origin));
  }
  for (double i = std::ceil(u_min / d); i <= std::floor(u_max / d); ++i) {
    const Vector3d start = origin + i * d * u;
    double t_min = -std::numeric_limits<double>::infinity(), t_max = -t_min;
    for (int a = 0; a < 3; ++a) {
      if (std::abs(v[a]) < 1e-12) {
        if (start[a] < region.min[a] || start[a] > region.max[a]) t_max = -std::numeric_limits<double>::infinity();
        continue;
      }
      const double t0 = (region.min[a] - start[a]) / v[a], t1 = (region.max[a] - start[a]) / v[a];
      t_min = std::max(t_min, std::min(t0, t1));
      t_max = std::min(t_max, std::max(t0, t1));
    }
    const double first = std::ceil(t_min / d), last = std::floor(t_max / d);
    if (last >= first) row(start, d * v, first, last);
  }
}

double plane_count(const Body& body, double d, const Box& region) {
  // The rows alone could be too many to walk through.
  if ((to_eigen(region.max) - to_eigen(region.min)).norm() / d > 2 * max_body_samples) return 4 * max_body_samples;
  double count = 0;
  plane_rows(body, d, region,
             [&](const Vector3d&, const Vector3d&, double first, double last) { count += last - first + 1; });
  return count;
}

/// A lattice of step d through the body's point.
std::vector<Vec3> sample_plane(const Body& body, double d, const Box& region) {
  std::vector<Vec3> samples;
  plane_rows(body, d, region, [&](const Vector3d& start, const Vector3d& step, double first, double last) {
    for (double j = first; j <= last; ++j) samples.push_back(to_vec3(start + j * step));
  });
  return samples;
}

constexpr double mesh_candidates = 0.3;  // of d: candidates' distance in a face; 0.75 + 0.3/√2 < 1 gives the cover

double expected_mesh_samples(const Body& body, double d) {
  double area = 0;
  if (body.deforms())
    for (const double of_triangle : largest_areas(body)) area += of_triangle;
  else
    for (const auto& t : body.mesh_triangles) {
      area += triangle_area(body.mesh_points[static_cast<std::size_t>(t[0])],
                            body.mesh_points[static_cast<std::size_t>(t[1])],
                            body.mesh_points[static_cast<std::size_t>(t[2])]);
    }
  // The densest packing of a plane at the least distance; a strip or a speck of a mesh holds a few more at its
  // boundary.
  const double packed = area * 2 / (std::sqrt(3.0) * std::pow(mesh_min_distance * d, 2));
  double boundary = 0;  // m
  for (const MeshEdge& e : mesh_edges(body.mesh_triangles)) {
    boundary += (to_eigen(body.mesh_points[static_cast<std::size_t>(e.a)]) -
                 to_eigen(body.mesh_points[static_cast<std::size_t>(e.b)]))
                    .norm();
  }
  return packed + boundary / (mesh_min_distance * d) + 4;
}

}  // namespace

Vec3 sunk(const Body& body, double d, const Eigen::Vector3d& p) {
  if (body.field.empty()) return to_vec3(p);
  for (const double depth : {d / 2, d / 4}) {
    Vec3 normal, x = to_vec3(p);
    for (int step = 0; step < 8; ++step) {
      const double left = field_distance(body.field, x, normal) + depth;
      if (std::abs(left) < 1e-12 * d) break;  // rounding is left
      x = to_vec3(to_eigen(x) - left * to_eigen(normal));
    }
    if (std::abs(field_distance(body.field, x, normal) + depth) < 0.05 * d && (to_eigen(x) - p).norm() < 2 * depth)
      return x;
  }
  return to_vec3(p);
}

void for_surface_points(const Body& body, double d, const std::function<void(const Eigen::Vector3d&, Index)>& offer) {
  const auto point = [&](Index i) { return to_eigen(body.mesh_points[static_cast<std::size_t>(i)]); };
  const auto between = [&](Index triangle, const Vector3d& a, const Vector3d& b, double step, bool ends) {
    const double n = std::max(1.0, std::ceil((b - a).norm() / step - 1e-9));
    for (double i = ends ? 0 : 1; i <= (ends ? n : n - 1); ++i) offer(a + i / n * (b - a), triangle);
  };
  std::vector<Index> carrier(body.mesh_points.size(), -1);  // a triangle of each vertex
  for (std::size_t t = 0; t < body.mesh_triangles.size(); ++t)
    for (const Index n : body.mesh_triangles[t]) carrier[static_cast<std::size_t>(n)] = static_cast<Index>(t);
  for (std::size_t i = 0; i < body.mesh_points.size(); ++i) offer(point(static_cast<Index>(i)), carrier[i]);
  for (const MeshEdge& e : mesh_edges(body.mesh_triangles)) {
    const Vector3d a = point(e.a), b = point(e.b);
    // First at even steps near d, which fit between the ends; then finer, into gaps that thinning has left.
    between(e.triangle[0], a, b, (b - a).norm() / std::max(1.0, std::round((b - a).norm() / d)), false);
    between(e.triangle[0], a, b, mesh_candidates * d, false);
  }
  for (std::size_t k = 0; k < body.mesh_triangles.size(); ++k) {
    const auto& t = body.mesh_triangles[k];
    // Rows parallel to the longest side: few candidates also in a sliver.
    int longest = 0;
    for (int c = 1; c < 3; ++c) {
      if ((point(t[(c + 1) % 3]) - point(t[c])).norm() > (point(t[(longest + 1) % 3]) - point(t[longest])).norm())
        longest = c;
    }
    const Vector3d a = point(t[longest]), b = point(t[(longest + 1) % 3]), top = point(t[(longest + 2) % 3]);
    const double height = (b - a).cross(top - a).norm() / (b - a).norm();
    const double rows = std::max(1.0, std::ceil(height / (mesh_candidates * d)));
    for (double r = 0; r < rows; ++r) {
      between(static_cast<Index>(k), a + r / rows * (top - a), b + r / rows * (top - b), mesh_candidates * d, true);
    }
  }
}

namespace {

/// Vertices, then edges, then faces: none closer than 0.75 d to an earlier one, no point of the surface farther than d
/// from one.
std::vector<Vec3> sample_mesh(const Body& body, double d, const Box& region, std::vector<Index>* triangles = nullptr) {
  const double least = mesh_min_distance * d;
  PointGrid kept(least);
  for_surface_points(body, d, [&](const Vector3d& p, Index triangle) {
    const Vec3 x = sunk(body, d, p);
    if (!contains(region.min, region.max, x) || kept.any_within(x, least)) return;
    kept.add(x);
    if (triangles) triangles->push_back(triangle);
  });
  return kept.points();
}

/// Between mirrored walls a pool's pressure is too high, and a body floats too high. Samples that lie deeper make up
/// for it (measured: tests/validation/buoyancy_test.cpp). With extrapolated walls neither is so.
double first_depth(const Body& body, WallPressure walls) {
  return body.dynamic && walls == WallPressure::mirrored ? 0.67 : 0.5;  // of d
}

}  // namespace

/// Liquid of radius d/2 that touches the solid is one spacing away from the samples half a spacing inside it.
Body sampled_surface(Body body, double d, WallPressure walls, int layer) {
  const double depth = (first_depth(body, walls) + layer) * d;
  switch (body.kind) {
    case BodyScene::Kind::box:
      for (std::size_t a = 0; a < 3; ++a) {
        const double inset = body.inside ? -depth : std::min(depth, 0.25 * (body.box.max[a] - body.box.min[a]));
        body.box.min[a] += inset;
        body.box.max[a] -= inset;
      }
      break;
    case BodyScene::Kind::sphere:
      body.radius -= std::min(depth, body.radius / 2);
      break;
    case BodyScene::Kind::plane:
      for (std::size_t a = 0; a < 3; ++a) body.point[a] -= depth * body.normal[a];
      break;
    case BodyScene::Kind::mesh:
      break;
  }
  return body;
}

std::vector<Index> triangles_of_samples(const Body& body, double spacing, const Box& region) {
  std::vector<Index> triangles;
  sample_mesh(body, spacing, region, &triangles);
  return triangles;
}

std::array<Vec3, 2> plane_lattice(const Body& body, double spacing) {
  const auto [u, v] = plane_tangents(body);
  return {to_vec3(spacing * u), to_vec3(spacing * v)};
}

namespace {

/// The least and the most, along each axis, of how far a body comes within `duration` (s), m; of a plane, across its
/// surface.
std::array<Vec3, 2> way_of(const Body& body, double duration) {
  if (body.has_keys()) {
    std::array<Vec3, 2> way = bounds_of_way(body, duration);
    if (!body.slides) return way;
    double least = 0, most = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      least += std::min(way[0][a] * body.normal[a], way[1][a] * body.normal[a]);
      most += std::max(way[0][a] * body.normal[a], way[1][a] * body.normal[a]);
    }
    for (std::size_t a = 0; a < 3; ++a) {
      way[0][a] = std::min(least * body.normal[a], most * body.normal[a]);
      way[1][a] = std::max(least * body.normal[a], most * body.normal[a]);
    }
    return way;
  }
  std::array<Vec3, 2> way{};
  const Vec3& v = body.velocity.plain();
  for (std::size_t a = 0; a < 3; ++a) {
    const double along = to_eigen(v).dot(to_eigen(body.normal)) * body.normal[a],
                 path = (body.slides ? along : v[a]) * duration;
    way[0][a] = std::min(path, 0.0);
    way[1][a] = std::max(path, 0.0);
  }
  return way;
}

}  // namespace

Box sampled_region(const Body& body, const Box& region, double duration, int layer) {
  Box swept = region;
  if (body.slides && body.spins()) {
    const Vector3d normal = to_eigen(body.normal), middle = to_eigen(body.middle),
                   below = middle - normal * normal.dot(middle - to_eigen(body.point)),
                   half = 0.5 * (to_eigen(region.max) - to_eigen(region.min));
    const double step = to_eigen(body.lattice[0]).norm(), depth = (layer + 0.5) * step;
    for (int a = 0; a < 3; ++a) {
      // half the region's diagonal about the middle's foot in the layer, and 0.62 of both lattice steps: less than one
      const double reach = half.norm() + step + depth * std::abs(normal[a]);
      swept.min[static_cast<std::size_t>(a)] = below[a] - reach;
      swept.max[static_cast<std::size_t>(a)] = below[a] + reach;
    }
    return swept;
  }
  const bool turns = body.dynamic || body.spins();
  const std::array<Vec3, 2> way = way_of(body, duration);
  constexpr double all = 1e9;  // m: far beyond any scene's coordinates
  for (std::size_t a = 0; a < 3; ++a) {
    if (turns) {
      swept.min[a] = body.center[a] - all;
      swept.max[a] = body.center[a] + all;
      continue;
    }
    const double step = (1 - slide_offset) * (std::abs(body.lattice[0][a]) + std::abs(body.lattice[1][a]));
    swept.min[a] -= way[1][a] + step;
    swept.max[a] -= way[0][a] - step;
  }
  return swept;
}

int body_layers(const Body& body, double spacing, double support) {
  double depth = support;  // m: of the solid, at least
  if (body.kind == BodyScene::Kind::mesh) return 1;
  if (body.kind == BodyScene::Kind::sphere) depth = body.radius;
  if (body.kind == BodyScene::Kind::box && !body.inside)
    for (std::size_t a = 0; a < 3; ++a) depth = std::min(depth, 0.5 * (body.box.max[a] - body.box.min[a]));
  const double wanted = std::ceil(support / spacing - 1 - 1e-9), fitting = std::floor(depth / spacing - 0.5);
  return static_cast<int>(std::max(1.0, std::min(wanted, fitting)));
}

double expected_body_samples(const Body& solid, double spacing, WallPressure walls, const Box& region, int layer) {
  const Body body = sampled_surface(solid, spacing, walls, layer);
  switch (body.kind) {
    case BodyScene::Kind::box:
      return BoxLattice(body.box, region, spacing).count();
    case BodyScene::Kind::sphere:
      return sphere_count(body.radius, spacing);
    case BodyScene::Kind::plane:
      return plane_count(body, spacing, region);
    case BodyScene::Kind::mesh:
      return expected_mesh_samples(body, spacing);
  }
  return 0;
}

std::vector<Vec3> sample_body(const Body& solid, double spacing, WallPressure walls, const Box& region, int layer) {
  if (solid.kind == BodyScene::Kind::mesh) return sample_mesh(solid, spacing, region);  // no copy of its field
  const Body body = sampled_surface(solid, spacing, walls, layer);
  switch (body.kind) {
    case BodyScene::Kind::box:
      return sample_box(BoxLattice(body.box, region, spacing));
    case BodyScene::Kind::sphere:
      return sample_sphere(body, spacing, region);
    case BodyScene::Kind::plane:
      return sample_plane(body, spacing, region);
    case BodyScene::Kind::mesh:
      break;
  }
  return {};
}

}  // namespace drench
