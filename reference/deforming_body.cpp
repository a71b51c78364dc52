#include "deforming_body.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <numbers>

#include "mixed_slopes.hpp"
#include "neighbor_search.hpp"
#include "state/deforming_body.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

/// The file before a time, the first one before it, and how far it is to the next, 1.
std::pair<std::size_t, double> file_before(const Deformation& shape, double time) {
  std::size_t file = 0;
  while (file + 1 < shape.time.size() && shape.time[file + 1] <= time) ++file;
  if (file + 1 == shape.time.size()) return {file, 0.0};
  return {file, std::max(0.0, time - shape.time[file]) / (shape.time[file + 1] - shape.time[file])};
}

Corners corners_of(const Body& body, const Vectors& values, Index triangle) {
  const auto& n = body.mesh_triangles[triangle];
  return {values[n[0]], values[n[1]], values[n[2]]};
}

/// Weights of the point of a triangle that is nearest to x: the foot in its plane, or on the nearest of its edges.
Vector3d nearest_weights(const Corners& t, const Vector3d& x) {
  const Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]);
  Vector3d inside;
  for (int c = 0; c < 3; ++c)
    inside[c] = n.dot((t[(c + 2) % 3] - t[(c + 1) % 3]).cross(x - t[(c + 1) % 3])) / n.squaredNorm();
  if (inside.minCoeff() >= 0) return inside;
  Vector3d best = Vector3d::Zero();
  double least = INFINITY;
  for (int c = 0; c < 3; ++c) {
    const Vector3d edge = t[(c + 1) % 3] - t[c];
    const double s = std::clamp((x - t[c]).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    const double distance = (x - t[c] - s * edge).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    best = (1 - s) * Vector3d::Unit(c) + s * Vector3d::Unit((c + 1) % 3);
  }
  return best;
}

Vector3d mixed(const Corners& t, const Vector3d& w) { return w[0] * t[0] + w[1] * t[1] + w[2] * t[2]; }

/// How much of the whole sphere a triangle covers, seen from x: positive from inside (van Oosterom and Strackee 1983).
double solid_angle(const Corners& t, const Vector3d& x) {
  const Vector3d a = t[0] - x, b = t[1] - x, c = t[2] - x;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb) /
         (2 * std::numbers::pi);
}

}  // namespace

Vectors shape_points(const Body& body, double time) {
  const auto [file, part] = file_before(body.shape, time);
  Vectors points;
  for (std::size_t n = 0; n < body.mesh_points.size(); ++n) {
    points.push_back(vec(body.shape.points[file][n]));
    if (part > 0) points.back() = (1 - part) * points.back() + part * vec(body.shape.points[file + 1][n]);
  }
  return points;
}

Vectors shape_velocities(const Body& body, double time) {
  const std::size_t file = file_before(body.shape, time).first;
  Vectors velocities(body.mesh_points.size(), Vector3d::Zero());
  const std::vector<double>& times = body.shape.time;
  if (file + 1 == times.size() || time < times.front()) return velocities;
  for (std::size_t n = 0; n < velocities.size(); ++n)
    velocities[n] =
        (vec(body.shape.points[file + 1][n]) - vec(body.shape.points[file][n])) / (times[file + 1] - times[file]);
  return velocities;
}

DeformedSurface::DeformedSurface(const Body& body, double time, double dt)
    : body_(body),
      points_(shape_points(body, time + dt)),
      velocities_(points_),
      origin_(vec(lattice_origin(body, time + dt))),
      spacing_(body.field.spacing) {
  const Vectors before = shape_points(body, time);
  for (std::size_t n = 0; n < before.size(); ++n) velocities_[n] = (points_[n] - before[n]) / dt;
}

const DeformedSurface::LatticePoint& DeformedSurface::at(Index i, Index j, Index k) const {
  const std::int64_t number = (static_cast<std::int64_t>(k) * body_.field.points[1] + j) * body_.field.points[0] + i;
  const auto [found, fresh] = known_.try_emplace(number);
  if (!fresh) return found->second;
  const Vector3d x = origin_ + spacing_ * Vector3d(i, j, k);
  double least = body_.shape.band, around = 0;
  LatticePoint& point = found->second;
  for (Index t = 0; t < static_cast<Index>(body_.mesh_triangles.size()); ++t) {
    const Corners corners = corners_of(body_, points_, t);
    if (!((corners[1] - corners[0]).cross(corners[2] - corners[0]).norm() > 0))
      continue;  // its edges are those of others
    around += solid_angle(corners, x);
    const double distance = (x - mixed(corners, nearest_weights(corners, x))).norm();
    if (distance >= least) continue;
    least = distance;
    point.triangle = t;
  }
  point.distance = around > 0.5 ? -least : least;
  return point;
}

std::optional<double> DeformedSurface::distance(const Vector3d& x, Vector3d& normal, double& slope) const {
  normal = Vector3d::Zero();
  slope = 1;
  const Vector3d place = where(x);
  std::array<Index, 3> cell;
  for (int a = 0; a < 3; ++a) {
    if (!(place[a] >= 0 && place[a] <= body_.field.points[a] - 1)) return std::nullopt;
    cell[a] = std::min(static_cast<Index>(std::floor(place[a])), body_.field.points[a] - 2);
  }
  double value = 0;
  Vector3d gradient = Vector3d::Zero();
  for (int c = 0; c < 8; ++c) {
    const std::array<int, 3> on{c & 1, c >> 1 & 1, c >> 2};
    const double corner = at(cell[0] + on[0], cell[1] + on[1], cell[2] + on[2]).distance;
    Vector3d w, sign;
    for (int a = 0; a < 3; ++a) {
      w[a] = on[a] ? place[a] - cell[a] : 1 - (place[a] - cell[a]);
      sign[a] = on[a] ? 1 : -1;
    }
    value += corner * w.prod();
    for (int a = 0; a < 3; ++a) gradient[a] += corner * sign[a] * w[(a + 1) % 3] * w[(a + 2) % 3];
  }
  const Vector3d in_cell = place - Vector3d(cell[0], cell[1], cell[2]);
  gradient = mixed_slopes(gradient, cell, in_cell, body_.field,
                          [&](Index i, Index j, Index k) { return at(i, j, k).distance; });
  normal = gradient.norm() > 0 ? Vector3d(gradient.normalized()) : Vector3d::UnitY();
  if (gradient.norm() > 0) slope = std::max(0.5, gradient.norm() / spacing_);
  return value;
}

Vector3d DeformedSurface::velocity(const Vector3d& x) const {
  const Vector3d place = where(x);
  std::array<Index, 3> nearest;
  for (int a = 0; a < 3; ++a) {
    if (!(place[a] >= 0 && place[a] <= body_.field.points[a] - 1)) return Vector3d::Zero();
    nearest[a] = static_cast<Index>(std::floor(place[a] + 0.5));
  }
  const Index t = at(nearest[0], nearest[1], nearest[2]).triangle;
  if (t < 0) return Vector3d::Zero();
  return mixed(corners_of(body_, velocities_, t), nearest_weights(corners_of(body_, points_, t), x));
}

namespace {

Vector3d sample_place(const Body& body, const Vectors& points, Index s) {
  const Corners t = corners_of(body, points, body.shape.triangle[s]);
  return mixed(t, vec(body.shape.weight[s])) - body.shape.depth[s] * (t[1] - t[0]).cross(t[2] - t[0]).normalized();
}

}  // namespace

void move_shape_samples(ReferenceState& state, const StepInfo& info) {
  for (const Body& body : state.model.bodies) {
    if (!body.deforms()) continue;
    const Vectors begin = shape_points(body, info.time), end = shape_points(body, info.time + info.dt);
    for (Index s = 0; s < body.sample_count; ++s)
      state.s.boundary_velocity[body.first_sample + s] =
          arr((sample_place(body, end, s) - sample_place(body, begin, s)) / info.dt);
  }
}

void place_shape_samples(ReferenceState& state, double time) {
  const Model& m = state.model;
  const Smoothing w(m);
  for (const Body& body : m.bodies) {
    if (!body.deforms() || body.sample_count == 0) continue;
    const Vectors points = shape_points(body, time), rates = shape_velocities(body, time);
    Vectors places;
    for (Index s = 0; s < body.sample_count; ++s) {
      places.push_back(sample_place(body, points, s));
      const Corners x = corners_of(body, points, body.shape.triangle[s]),
                    v = corners_of(body, rates, body.shape.triangle[s]);
      // The normal's rate of change: of n = c/|c| with c = e₁ × e₂.
      const Vector3d c = (x[1] - x[0]).cross(x[2] - x[0]), n = c.normalized();
      const Vector3d rate = (v[1] - v[0]).cross(x[2] - x[0]) + (x[1] - x[0]).cross(v[2] - v[0]);
      const Vector3d turning =
          c.norm() > 0 ? Vector3d((rate - n * n.dot(rate)) / c.norm()) : Vector3d(Vector3d::Zero());
      state.s.boundary_position[body.first_sample + s] = arr(places.back());
      state.s.boundary_velocity[body.first_sample + s] =
          arr(mixed(v, vec(body.shape.weight[s])) - body.shape.depth[s] * turning);
    }
    const NeighborLists near = SortedCells(places, m.support).around(places, true);
    for (Index s = 0; s < body.sample_count; ++s) {
      double sum = w.value(0);
      for (const Index other : near[s]) sum += w.value((places[s] - places[other]).norm());
      state.s.boundary_volume[body.first_sample + s] = m.layer_share / sum;
    }
  }
}

}  // namespace drench::reference
