#include "setup/garment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "base/eigen_vec.hpp"
#include "setup/file_place.hpp"
#include "setup/mesh_clean.hpp"
#include "setup/setup_error.hpp"
#include "setup/sheets.hpp"
#include "setup/weld.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

constexpr double smallest = 0.02;  // m; less is likelier another unit

double longest_side(const Box& box) { return (to_eigen(box.max) - to_eigen(box.min)).maxCoeff(); }

/// Fills unit_warning.
void judge_unit(Garment& garment, const std::string& label, double size) {
  const MeshGuess& guess = garment.guess;
  const char* names[] = {"metres", "decimetres", "centimetres", "millimetres", "inches"};
  const char* name = names[static_cast<std::size_t>(guess.unit)];
  if (guess.unit != LengthUnit::m)
    garment.unit_warning =
        fmt::format("{} is {:.3g} units long: assumed to be in {}; otherwise change unit", label, size, name);
  else if (size < smallest)
    garment.unit_warning = fmt::format(
        "{} is {:.3g} units long: assumed to be in metres; otherwise set unit or scale in the scene", label, size);
}

/// Closes its seams: also such as are a little open, where the distance for them collapses no triangle.
void sew(Garment& garment) {
  const SheetSplit split = split_sheets(garment.mesh);
  const SurfaceMesh apart = garment.mesh;
  const Weld closed = weld_boundary(garment.mesh, weld_automatically, split.copy_of);
  if (closed.open == 0 || closed.layers > 0) return;
  const double digit = std::pow(10, std::floor(std::log10(closed.widest)) - 1);
  const double distance = std::ceil(1.2 * closed.widest / digit - 1e-6) * digit;
  SurfaceMesh wider = apart;
  const Weld all = weld_boundary(wider, distance, split.copy_of);
  const auto sewn = [](const Weld& weld) { return weld.merged + static_cast<Index>(weld.held.size()); };
  // Nor points of layers that lie near each other, which the distance sews as well.
  if (all.refused > closed.refused || all.merged <= closed.merged || sewn(all) > sewn(closed) + closed.open) return;
  garment.mesh = std::move(wider);
  garment.weld = distance;
  garment.welded = all.merged - closed.merged;
}

void place(Garment& garment, bool on_body) {
  FilePlace{metres_in(garment.guess.unit) * upright(garment.guess.up), Vector3d::Zero()}(garment.mesh.points);
  sew(garment);
  clean_mesh(garment.mesh, clean_automatically);
  const Box box = bounds_of(garment.mesh.points);
  const double size = longest_side(box);
  const Vector3d middle = 0.5 * (to_eigen(box.min) + to_eigen(box.max));
  if (!on_body && middle.cwiseAbs().maxCoeff() > 5 * size) garment.shift = to_vec3(-middle);
  for (Vec3& x : garment.mesh.points) x = to_vec3(to_eigen(x) + to_eigen(garment.shift));
  garment.box = bounds_of(garment.mesh.points);
  garment.size = size;
  const Vector3d sides = to_eigen(garment.box.max) - to_eigen(garment.box.min);
  garment.flat = sides[1] < 0.1 * size;
}

void measure_triangles(Garment& garment) {
  const auto point = [&](Index i) { return to_eigen(garment.mesh.points[static_cast<std::size_t>(i)]); };
  double length = 0;
  const std::vector<MeshEdge> edges = mesh_edges(garment.mesh.triangles);
  for (const MeshEdge& e : edges) {
    length += (point(e.a) - point(e.b)).norm();
    garment.open = garment.open || e.triangles == 1;
  }
  garment.edge = length / static_cast<double>(edges.size());
  garment.least_height = std::numeric_limits<double>::infinity();
  for (const auto& t : garment.mesh.triangles) {
    const auto corner = [&](std::size_t k) { return garment.mesh.points[static_cast<std::size_t>(t[k])]; };
    garment.area += triangle_area(corner(0), corner(1), corner(2));
    garment.least_height = std::min(garment.least_height, triangle_height(corner(0), corner(1), corner(2)));
  }
}

}  // namespace

Garment measure_garment(SurfaceMesh mesh, const std::string& label, const MeshGuess& guess, bool on_body) {
  check_points(mesh.points, label);
  Garment garment;
  garment.mesh = std::move(mesh);
  garment.guess = guess;
  judge_unit(garment, label, longest_side(bounds_of(garment.mesh.points)));
  place(garment, on_body);
  check_mesh(garment.mesh, label, cloth_min_area_ratio);
  measure_triangles(garment);
  return garment;
}

int front_axis(const Garment& garment) {
  const Vector3d sides = to_eigen(garment.box.max) - to_eigen(garment.box.min);
  return sides[0] < sides[2] ? 0 : 2;
}

Vec3 front_point(const Garment& garment, double height) {
  const int front = front_axis(garment), across = 2 - front;
  const Eigen::Vector2d target(0.5 * (garment.box.min[across] + garment.box.max[across]), height);
  const auto seen = [&](const Vec3& x) { return Eigen::Vector2d(x[across], x[1]); };
  double farthest = -std::numeric_limits<double>::infinity();
  for (const auto& t : garment.mesh.triangles) {
    const auto corner = [&](std::size_t k) { return garment.mesh.points[static_cast<std::size_t>(t[k])]; };
    const Vec3 a = corner(0), b = corner(1), c = corner(2);
    Eigen::Matrix2d sides;
    sides << seen(b) - seen(a), seen(c) - seen(a);
    if (std::abs(sides.determinant()) < 1e-12 * sides.squaredNorm()) continue;  // seen from the side
    const Eigen::Vector2d w = sides.inverse() * (target - seen(a));
    if (w[0] < 0 || w[1] < 0 || w[0] + w[1] > 1) continue;
    farthest = std::max(farthest, a[front] + w[0] * (b[front] - a[front]) + w[1] * (c[front] - a[front]));
  }
  Vec3 found{0, 0, 0};
  if (std::isfinite(farthest)) {
    found[across] = target[0];
    found[1] = height;
    found[front] = farthest;
    return found;
  }
  return *std::min_element(garment.mesh.points.begin(), garment.mesh.points.end(), [&](const Vec3& x, const Vec3& y) {
    return (seen(x) - target).squaredNorm() < (seen(y) - target).squaredNorm();
  });
}

Box top_band(const Garment& garment) {
  const double height = garment.box.max[1] - garment.box.min[1], margin = 0.5 * garment.edge;
  std::vector<double> heights;
  for (const Vec3& x : garment.mesh.points) heights.push_back(x[1]);
  const std::size_t fourth = std::min<std::size_t>(3, heights.size() - 1);
  std::nth_element(heights.begin(), heights.begin() + static_cast<std::ptrdiff_t>(fourth), heights.end(),
                   std::greater<>());
  const double lowest = std::min(garment.box.max[1] - 0.02 * height, heights[fourth]);
  Box band{garment.box.min, garment.box.max};
  for (const std::size_t a : {0, 2}) {
    band.min[a] -= margin;
    band.max[a] += margin;
  }
  band.min[1] = lowest - 1e-3 * garment.size;
  band.max[1] += margin;
  return band;
}

}  // namespace drench
