#include "setup/worn.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>

#include "base/eigen_vec.hpp"
#include "base/sets.hpp"
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
    for (const Vec3& x : garment.mesh.points) all_.push_back(to_eigen(x));
    // Spread over the list by the golden ratio: a fixed stride might follow the rows of a mesh.
    const std::size_t count = std::min<std::size_t>(400, all_.size());
    for (std::size_t k = 0; k < count; ++k) {
      const double turns = (std::numbers::phi - 1) * static_cast<double>(k);
      some_.push_back(all_[static_cast<std::size_t>((turns - std::floor(turns)) * static_cast<double>(all_.size()))]);
    }
  }

  /// By all nodes.
  WornPlace at(const Vector3d& shift) const { return rate(all_, shift); }

  /// The best places, from the best on: those on a lattice where the middle of the garment is within the body's box,
  /// then by ever shorter steps from the best of these that are apart from each other.
  std::vector<WornPlace> best() const {
    const Box box = bounds_of(body_.mesh_points);
    const Vector3d middle = 0.5 * (to_eigen(garment_.box.min) + to_eigen(garment_.box.max)),
                   low = to_eigen(box.min) - middle, sides = to_eigen(box.max) - to_eigen(box.min);
    constexpr double most_places = 40000;
    double step = garment_.size / 20;
    const auto along = [&](int a) { return 1 + std::ceil(sides[a] / step); };
    while (along(0) * along(1) * along(2) > most_places) step *= 1.1;
    const std::array<int, 3> count{static_cast<int>(along(0)), static_cast<int>(along(1)), static_cast<int>(along(2))};
    std::vector<WornPlace> found;
    for (int k = 0; k < count[2]; ++k)
      for (int j = 0; j < count[1]; ++j)
        for (int i = 0; i < count[0]; ++i) found.push_back(rate(some_, low + step * Vector3d(i, j, k)));
    std::stable_sort(found.begin(), found.end(), nearer);
    std::vector<WornPlace> starts, refined;
    for (const WornPlace& place : found) {
      const auto is_near = [&](const WornPlace& o) {
        return (to_eigen(o.shift) - to_eigen(place.shift)).norm() < 3 * step;
      };
      if (starts.size() < 8 && std::none_of(starts.begin(), starts.end(), is_near)) starts.push_back(place);
    }
    for (const WornPlace& start : starts) refined.push_back(at(to_eigen(refine(start, step).shift)));
    std::stable_sort(refined.begin(), refined.end(), nearer);
    return refined;
  }

 private:
  static bool nearer(const WornPlace& a, const WornPlace& b) { return a.gap < b.gap; }

  WornPlace rate(const std::vector<Vector3d>& nodes, const Vector3d& shift) const {
    constexpr double weight_inside = 4;
    WornPlace place;
    place.shift = to_vec3(shift);
    for (const Vector3d& x : nodes) {
      Vec3 normal;
      const double distance = field_distance(body_.field, to_vec3(x + shift), normal),
                   counted = distance < 0 ? weight_inside * std::min(-distance, reach_) : std::min(distance, reach_);
      place.gap += counted * counted;
      place.inside += distance < 0 ? 1 : 0;
    }
    place.gap = std::sqrt(place.gap / static_cast<double>(nodes.size()));
    place.inside /= static_cast<double>(nodes.size());
    return place;
  }

  WornPlace refine(WornPlace best, double step) const {
    for (step /= 2; step > 0.002 * garment_.size;) {
      WornPlace nearest = best;
      for (int a = 0; a < 3; ++a)
        for (const double sign : {-1.0, 1.0}) {
          const WornPlace next = rate(some_, to_eigen(best.shift) + sign * step * Vector3d::Unit(a));
          if (nearer(next, nearest)) nearest = next;
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

constexpr double few_inside = 0.02, many_inside = 0.1;  // of the nodes

/// Does the body wear a garment where it is: does it go around a part of the body with hardly a node inside it?
bool is_worn(const Fitting& f) { return f.around && f.given.inside <= few_inside; }

/// m: the gap, larger where nodes are inside: across the body a garment is nearer to it than around it.
double misfit(const WornPlace& place) { return place.gap * (1 + 5 * place.inside); }
double misfit(const Fitting& f) { return f.moved ? misfit(*f.moved) : misfit(f.given) * (f.around ? 1 : 1.5); }

/// The translation that puts a garment on a body best: files of both often have different origins, one at the hips,
/// the other at the feet. None where no place goes around a part of the body.
std::optional<WornPlace> find_worn_place(const Garment& garment, const Body& body) {
  for (const WornPlace& place : PlaceSearch(garment, body).best())
    if (surrounds_at(garment, body.mesh_points, to_eigen(place.shift))) return place;
  return std::nullopt;
}

/// Is a place that was found so much better than another one that a garment should be moved to it?
bool is_worth_moving(const WornPlace& found, const WornPlace& given) {
  const bool nearer = found.gap <= 0.4 * given.gap;
  return nearer || (found.inside <= std::min(0.05, 0.25 * given.inside) && found.gap <= 0.8 * given.gap);
}

}  // namespace

bool surrounds(const Garment& garment, const std::vector<Vec3>& body) {
  return surrounds_at(garment, body, Vector3d::Zero());
}

std::size_t pieces_beside(const Garment& garment, const std::vector<Vec3>& body) {
  Sets joined(garment.mesh.points.size());
  for (const auto& t : garment.mesh.triangles)
    for (const Index n : t) joined.unite(n, t[0]);
  std::map<Index, std::vector<std::array<Index, 3>>> pieces;
  for (const auto& t : garment.mesh.triangles) pieces[joined.root(t[0])].push_back(t);
  if (pieces.size() == 1) return 0;
  Garment alone = garment;
  for (auto& [first, triangles] : pieces) {
    alone.mesh.triangles = std::move(triangles);
    if (surrounds(alone, body)) return 0;
  }
  return pieces.size();
}

WornPlace rate_place(const Garment& garment, const Body& body) {
  return PlaceSearch(garment, body).at(Vector3d::Zero());
}

std::optional<Fitting> fit_to(const Garment& garment, const SurfaceMesh& file, const std::string& label,
                              const Body& body) {
  constexpr double much_less = 0.9;  // misfit of another axis over that of the suggested one
  const auto fitting = [&](Garment of) {
    Fitting f{std::move(of), {}, false, {}};
    f.given = rate_place(f.garment, body);
    f.around = surrounds(f.garment, body.mesh_points);
    if (!is_worn(f)) f.moved = find_worn_place(f.garment, body);
    if (f.moved && !is_worth_moving(*f.moved, f.given)) f.moved.reset();
    return f;
  };
  const Fitting suggested = fitting(garment);
  if (is_worn(suggested)) return std::nullopt;
  Fitting best = suggested;
  for (const UpAxis up : {UpAxis::y, UpAxis::z}) {
    if (up == garment.guess.up) continue;
    MeshGuess guess = garment.guess;
    guess.up = up;
    guess.up_reason = up == UpAxis::y ? "" : "then it fits the body";
    Garment turned = measure_garment(file, label, guess, true);
    if (turned.flat) continue;
    Fitting other = fitting(std::move(turned));
    // A garment that is both turned and moved has to fit well: a tube can be put over any corner of a body.
    if (other.moved && other.moved->inside > few_inside) other.moved.reset();
    if (!other.around && !other.moved) continue;
    if (!other.moved && other.given.inside > many_inside) continue;  // it fits no better than before
    if (misfit(other) < std::min(misfit(best), much_less * misfit(suggested))) best = std::move(other);
  }
  if (best.garment.guess.up == garment.guess.up && !best.moved) return std::nullopt;
  return best;
}

}  // namespace drench
