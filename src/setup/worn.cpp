#include "setup/worn.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "base/eigen_vec.hpp"
#include "setup/distance_field.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

/// How a mesh lies around a point.
struct Around {
  double winding = 0;   // its solid angle over 4π: 1 inside a closed mesh, a good part of it inside an open garment
  double lopsided = 0;  // length of the mean direction to it: 0 all around, 0.5 at a plane, 1 far away
};

Around around(const SurfaceMesh& mesh, const Vector3d& x) {
  double angle = 0;                       // half the solid angle
  Vector3d direction = Vector3d::Zero();  // integral over the solid angle, by its border: great circles
  for (const auto& t : mesh.triangles) {
    const auto side = [&](std::size_t k) -> Vector3d {
      return to_eigen(mesh.points[static_cast<std::size_t>(t[k])]) - x;
    };
    const Vector3d corner[3] = {side(0), side(1), side(2)};
    const auto& [a, b, c] = corner;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    for (int k = 0; k < 3; ++k) {
      const Vector3d& from = corner[k];
      const Vector3d& to = corner[(k + 1) % 3];
      const Vector3d across = from.cross(to);
      const double length = across.norm();
      if (length > 0) direction += 0.5 * std::atan2(length, from.dot(to)) / length * across;
    }
  }
  const double solid_angle = 2 * std::abs(angle);
  return {solid_angle / (4 * std::numbers::pi), solid_angle > 0 ? direction.norm() / solid_angle : 1};
}

/// The same where the garment is moved by `shift`, m.
bool surrounds_at(const Garment& garment, const std::vector<Vec3>& body, const Vector3d& shift) {
  constexpr double least_winding = 0.3, most_lopsided = 0.45;  // 0.5 at a plane
  std::vector<Vec3> near;
  for (const Vec3& point : body)
    if (const Vec3 x = to_vec3(to_eigen(point) - shift); contains(garment.box.min, garment.box.max, x))
      near.push_back(x);
  const std::size_t stride = 1 + near.size() / 200;
  std::size_t seen = 0, inside = 0;
  for (std::size_t k = 0; k < near.size(); k += stride, ++seen) {
    const Around found = around(garment.mesh, to_eigen(near[k]));
    inside += found.winding > least_winding && found.lopsided < most_lopsided ? 1 : 0;
  }
  return seen > 0 && 10 * inside > seen;
}

/// Rates places of a garment by some of its nodes.
class PlaceSearch {
 public:
  PlaceSearch(const Garment& garment, const Body& body) : garment_(garment), body_(body), reach_(0.15 * garment.size) {
    const std::size_t stride = 1 + garment.mesh.points.size() / 400;
    for (std::size_t k = 0; k < garment.mesh.points.size(); k += stride)
      some_.push_back(to_eigen(garment.mesh.points[k]));
    for (const Vec3& x : garment.mesh.points) all_.push_back(to_eigen(x));
  }

  /// By all nodes.
  WornPlace at(const Vector3d& shift) const { return rate(all_, shift); }

  /// The best on a lattice of places where the middle of the garment is within the body's box, then by ever shorter
  /// steps from the best of these.
  WornPlace best() const {
    const Box box = bounds_of(body_.mesh_points);
    const Vector3d middle = 0.5 * (to_eigen(garment_.box.min) + to_eigen(garment_.box.max)),
                   low = to_eigen(box.min) - middle, sides = to_eigen(box.max) - to_eigen(box.min);
    constexpr double most_places = 40000;
    const double step = std::max(garment_.size / 20, std::cbrt(sides.prod() / most_places));
    std::array<int, 3> count{};
    for (int a = 0; a < 3; ++a) count[static_cast<std::size_t>(a)] = 1 + static_cast<int>(std::ceil(sides[a] / step));
    std::vector<WornPlace> found;
    for (int k = 0; k < count[2]; ++k)
      for (int j = 0; j < count[1]; ++j)
        for (int i = 0; i < count[0]; ++i) found.push_back(rate(some_, low + step * Vector3d(i, j, k)));
    constexpr std::size_t starts = 8;
    const auto end = found.begin() + static_cast<std::ptrdiff_t>(std::min(starts, found.size()));
    std::partial_sort(found.begin(), end, found.end(),
                      [](const WornPlace& a, const WornPlace& b) { return a.gap < b.gap; });
    WornPlace best = refine(found.front(), step);
    for (auto start = found.begin() + 1; start != end; ++start)
      if (const WornPlace refined = refine(*start, step); refined.gap < best.gap) best = refined;
    return at(to_eigen(best.shift));
  }

  double reach() const { return reach_; }

 private:
  WornPlace rate(const std::vector<Vector3d>& nodes, const Vector3d& shift) const {
    constexpr double weight_inside = 4;
    WornPlace place;
    place.shift = to_vec3(shift);
    for (const Vector3d& x : nodes) {
      Vec3 normal;
      const double distance = field_distance(body_.field, to_vec3(x + shift), normal);
      place.gap += distance < 0 ? weight_inside * std::min(-distance, reach_) : std::min(distance, reach_);
      if (distance >= 0) continue;
      place.inside += 1;
      place.deep = std::max(place.deep, -distance);
    }
    place.gap /= static_cast<double>(nodes.size());
    place.inside /= static_cast<double>(nodes.size());
    return place;
  }

  WornPlace refine(WornPlace best, double step) const {
    for (step /= 2; step > 0.002 * garment_.size;) {
      WornPlace nearest = best;
      for (int a = 0; a < 3; ++a)
        for (const double sign : {-1.0, 1.0}) {
          const WornPlace next = rate(some_, to_eigen(best.shift) + sign * step * Vector3d::Unit(a));
          if (next.gap < nearest.gap) nearest = next;
        }
      if (nearest.gap < best.gap)
        best = nearest;
      else
        step /= 2;
    }
    return best;
  }

  const Garment& garment_;
  const Body& body_;
  double reach_;                      // m: farther nodes count as if they were there
  std::vector<Vector3d> some_, all_;  // m: nodes
};

}  // namespace

bool surrounds(const Garment& garment, const std::vector<Vec3>& body) {
  return surrounds_at(garment, body, Vector3d::Zero());
}

std::optional<WornPlace> find_worn_place(const Garment& garment, const Body& body) {
  const PlaceSearch search(garment, body);
  const WornPlace given = search.at(Vector3d::Zero());
  const bool worn = surrounds(garment, body.mesh_points);
  if (constexpr double few = 0.02; worn && given.inside <= few) return std::nullopt;
  const WornPlace best = search.best();
  if (best.gap > 0.5 * (worn ? given.gap : search.reach())) return std::nullopt;
  if (!surrounds_at(garment, body.mesh_points, to_eigen(best.shift))) return std::nullopt;
  return best;
}

}  // namespace drench
