#include "setup/deforming_body.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "base/eigen_vec.hpp"
#include "base/free_cores.hpp"
#include "setup/body_sampling.hpp"
#include "setup/distance_field.hpp"
#include "setup/point_grid.hpp"
#include "setup/setup_error.hpp"
#include "setup/solid_mesh.hpp"
#include "setup/surface_mesh.hpp"
#include "state/deforming_body.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vec3>;
using CornerPoints = std::array<Vector3d, 3>;

CornerPoints corners_of(const Body& body, const Points& points, std::size_t triangle) {
  CornerPoints corners;
  for (std::size_t c = 0; c < 3; ++c)
    corners[c] = to_eigen(points[static_cast<std::size_t>(body.mesh_triangles[triangle][c])]);
  return corners;
}

Vector3d across(const CornerPoints& x) { return (x[1] - x[0]).cross(x[2] - x[0]); }

Eigen::AlignedBox3d box_around(const Points& points) {
  Eigen::AlignedBox3d bounds;
  for (const Vec3& x : points) bounds.extend(to_eigen(x));
  return bounds;
}

/// Does the triangle go from a to b along one of its edges?
bool goes(const std::array<Index, 3>& t, Index a, Index b) {
  for (std::size_t c = 0; c < 3; ++c)
    if (t[c] == a && t[(c + 1) % 3] == b) return true;
  return false;
}

/// Turns triangles so that neighbours agree; returns the number of each one's shell.
std::vector<Index> agree(std::vector<std::array<Index, 3>>& triangles, const std::string& label) {
  const std::vector<MeshEdge> edges = mesh_edges(triangles);
  std::vector<std::vector<std::size_t>> edges_of(triangles.size());
  for (std::size_t e = 0; e < edges.size(); ++e)
    for (const Index t : edges[e].triangle) edges_of[static_cast<std::size_t>(t)].push_back(e);
  std::vector<Index> shell(triangles.size(), -1);
  Index shells = 0;
  for (std::size_t first = 0; first < triangles.size(); ++first) {
    if (shell[first] >= 0) continue;
    std::vector<std::size_t> open{first};
    shell[first] = shells;
    while (!open.empty()) {
      const std::size_t t = open.back();
      open.pop_back();
      for (const std::size_t e : edges_of[t]) {
        const MeshEdge& edge = edges[e];
        const bool first_of_two = edge.triangle[0] == static_cast<Index>(t);
        const auto other = static_cast<std::size_t>(edge.triangle[first_of_two ? 1 : 0]);
        const bool agrees = goes(triangles[t], edge.a, edge.b) != goes(triangles[other], edge.a, edge.b);
        if (shell[other] < 0) {
          if (!agrees) std::swap(triangles[other][1], triangles[other][2]);
          shell[other] = shells;
          open.push_back(other);
        } else if (!agrees) {
          throw SetupError(label + ": its surface has one side only; allowed: a mesh with an inside and an outside");
        }
      }
    }
    ++shells;
  }
  return shell;
}

/// m³, of each shell.
std::vector<double> volumes(const Body& body, const Points& points, const std::vector<Index>& shell) {
  std::vector<double> volume(1 + static_cast<std::size_t>(*std::max_element(shell.begin(), shell.end())), 0.0);
  const Vector3d middle = box_around(points).center();
  for (std::size_t t = 0; t < shell.size(); ++t) {
    const CornerPoints x = corners_of(body, points, t);
    volume[static_cast<std::size_t>(shell[t])] += (x[0] - middle).dot((x[1] - middle).cross(x[2] - middle)) / 6;
  }
  return volume;
}

void turn_outwards(Body& body, const std::vector<Points>& points, const std::vector<std::string>& labels) {
  const std::vector<Index> shell = agree(body.mesh_triangles, labels.front());
  const std::vector<double> first = volumes(body, points.front(), shell);
  for (std::size_t t = 0; t < shell.size(); ++t)
    if (first[static_cast<std::size_t>(shell[t])] < 0) std::swap(body.mesh_triangles[t][1], body.mesh_triangles[t][2]);
  // A speck or a flat shell may turn over without harm.
  const double small =
      1e-6 * std::accumulate(first.begin(), first.end(), 0.0, [](double sum, double v) { return sum + std::abs(v); });
  for (std::size_t k = 0; k < points.size(); ++k) {
    const std::vector<double> now = volumes(body, points[k], shell);
    for (std::size_t s = 0; s < now.size(); ++s)
      if (!(std::abs(first[s]) <= small) && !(now[s] > 0))
        throw SetupError(
            labels[k] +
            ": it is turned inside out compared with the first file; allowed: a positive volume in all files");
  }
}

double fastest_between(const Points& from, const Points& to, double time) {
  double way = 0;
  for (std::size_t i = 0; i < from.size(); ++i) way = std::max(way, (to_eigen(to[i]) - to_eigen(from[i])).norm());
  return way / time;
}

}  // namespace

void deform(Body& body, std::vector<Points> points, std::vector<double> times, const std::vector<std::string>& labels) {
  if (!bounds_solid(body.mesh_triangles))
    throw SetupError(labels.front() +
                     ": it deforms from file to file, and it encloses no volume; allowed: "
                     "a closed mesh, or one that moves rigidly");
  for (const MeshEdge& e : mesh_edges(body.mesh_triangles))
    if (e.triangles > 2) {
      const Vector3d middle = 0.5 * (to_eigen(body.mesh_points[static_cast<std::size_t>(e.a)]) +
                                     to_eigen(body.mesh_points[static_cast<std::size_t>(e.b)]));
      throw SetupError(
          fmt::format("{}: it deforms from file to file, and {} triangles share the edge at "
                      "({:.4g}, {:.4g}, {:.4g}); allowed: a mesh without inner walls, or one that moves rigidly",
                      labels.front(), e.triangles, middle[0], middle[1], middle[2]));
    }
  turn_outwards(body, points, labels);
  Deformation& shape = body.shape;
  for (std::size_t k = 0; k < points.size(); ++k) {
    shape.center.push_back(to_vec3(box_around(points[k]).center()));
    for (const Vec3& x : points[k]) body.reach = std::max(body.reach, (to_eigen(x) - to_eigen(body.center)).norm());
    if (k > 0) shape.speed.push_back(fastest_between(points[k - 1], points[k], times[k] - times[k - 1]));
  }
  shape.points = std::move(points);
  shape.time = std::move(times);
}

std::vector<std::string> deformation_warnings(const Body& body, const std::string& name) {
  std::size_t worst = 0, most = 0;
  for (std::size_t k = 0; k + 1 < body.shape.points.size(); ++k) {
    std::size_t turned = 0;
    for (std::size_t t = 0; t < body.mesh_triangles.size(); ++t)
      if (across(corners_of(body, body.shape.points[k], t)).dot(across(corners_of(body, body.shape.points[k + 1], t))) <
          0)
        ++turned;
    if (turned > most) most = turned, worst = k;
  }
  if (most == 0) return {};
  return {
      fmt::format("{}: {} of its {} triangles turn by more than 90° from file {} to file {}, and points move in "
                  "straight lines between "
                  "files: it shrinks in between; use more files per second",
                  name, most, body.mesh_triangles.size(), worst + 1, worst + 2)};
}

void lay_deforming_field(Body& body, double spacing, double margin, double longest, double farthest) {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  for (const Points& points : body.shape.points) size = size.cwiseMax(box_around(points).sizes());
  const Vector3d middle = to_eigen(body.shape.center.front());
  body.field = lay_field(to_vec3(middle - 0.5 * size), to_vec3(middle + 0.5 * size), spacing, margin);
  const double passed = std::min(fastest_point(body.shape) * longest, farthest);
  body.shape.band = std::max(margin, passed) + std::sqrt(3.0) * body.field.spacing;
}

Body shape_at(const Body& body, double time) {
  Body now;  // no copy of all files
  now.kind = body.kind;
  now.center = body.center;
  now.reach = body.reach;
  now.mesh_points = points_at(body.shape, time);
  now.mesh_triangles = body.mesh_triangles;
  return now;
}

Body shape_with_field_at(const Body& body, double time) {
  Body now = shape_at(body, time);
  now.field.spacing = body.field.spacing;
  now.field.points = body.field.points;
  now.field.origin = lattice_origin(body, time);
  fill_field(now, now.field, host_threads());
  return now;
}

namespace {

constexpr double much = 1.1;    // an edge that is as many times as long as in all files before needs more samples
constexpr double farthest = 8;  // weights are not larger: of a sliver they would say nothing

/// Where sample s is when the mesh's points are at `points`.
Vec3 placed(const Body& body, const Points& points, std::size_t s) {
  const Deformation& shape = body.shape;
  const CornerPoints x = corners_of(body, points, static_cast<std::size_t>(shape.triangle[s]));
  const auto& w = shape.weight[s];
  return to_vec3(w[0] * x[0] + w[1] * x[1] + w[2] * x[2] - shape.depth[s] * across(x).normalized());
}

/// Affine weights of the foot of q in the plane of a triangle.
std::array<double, 3> weights_of(const CornerPoints& x, const Vector3d& q) {
  const Vector3d n = across(x);
  const double b = (q - x[0]).cross(x[2] - x[0]).dot(n) / n.squaredNorm(),
               c = (x[1] - x[0]).cross(q - x[0]).dot(n) / n.squaredNorm();
  return {1 - b - c, b, c};
}

/// Binds the sample x, which lies below the point p of the triangle.
void bind_to(Body& body, const CornerPoints& corners, Index triangle, const Vector3d& p, const Vector3d& x) {
  std::array<double, 3> weight = weights_of(corners, x);
  double depth = (corners[0] - x).dot(across(corners).normalized());
  const auto large = [](double w) { return !(std::abs(w) <= farthest); };
  if (std::any_of(weight.begin(), weight.end(), large)) {
    weight = weights_of(corners, p);
    depth = (x - p).norm();
  }
  body.shape.triangle.push_back(triangle);
  body.shape.weight.push_back(weight);
  body.shape.depth.push_back(depth);
}

/// Lengths of a triangle's edges, m².
std::array<double, 3> squares(const CornerPoints& x) {
  return {(x[1] - x[0]).squaredNorm(), (x[2] - x[1]).squaredNorm(), (x[0] - x[2]).squaredNorm()};
}

double area_of(const Body& body, const Points& points) {
  double area = 0;
  for (std::size_t t = 0; t < body.mesh_triangles.size(); ++t) area += 0.5 * across(corners_of(body, points, t)).norm();
  return area;
}

/// The first file, or the one with the largest surface if that is larger by much: samples lie evenly there, and crowd
/// elsewhere.
std::size_t evenly_sampled(const Body& body) {
  std::size_t largest = 0;
  const double first = area_of(body, body.shape.points.front());
  double most = much * much * first;
  for (std::size_t k = 1; k < body.shape.points.size(); ++k)
    if (const double area = area_of(body, body.shape.points[k]); area > most) most = area, largest = k;
  return largest;
}

/// Which files to lay samples in: that one, and those where an edge is longer by much than in all before it.
std::vector<std::size_t> stretched_files(const Body& body) {
  std::vector<std::array<double, 3>> longest(body.mesh_triangles.size());
  std::vector<std::size_t> files;
  const auto look_at = [&](std::size_t k) {
    bool longer = false;
    std::vector<std::array<double, 3>> now;
    for (std::size_t t = 0; t < longest.size(); ++t) {
      now.push_back(squares(corners_of(body, body.shape.points[k], t)));
      for (std::size_t c = 0; c < 3; ++c) longer = longer || now[t][c] > much * much * longest[t][c];
    }
    if (!longer) return;
    files.push_back(k);
    for (std::size_t t = 0; t < longest.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c) longest[t][c] = std::max(longest[t][c], now[t][c]);
  };
  look_at(evenly_sampled(body));
  for (std::size_t k = 0; k < body.shape.points.size(); ++k) look_at(k);
  return files;
}

}  // namespace

std::vector<Vec3> bind_samples(Body& body, double d) {
  const double least = mesh_min_distance * d;
  for (const std::size_t k : stretched_files(body)) {
    std::optional<Body> later;
    const Body& now = k == 0 ? body : later.emplace(shape_with_field_at(body, body.shape.time[k]));
    const Points& points = body.shape.points[k];
    PointGrid kept(least);
    for (std::size_t s = 0; s < body.shape.triangle.size(); ++s) kept.add(placed(body, points, s));
    for_surface_points(now, d, [&](const Vector3d& p, Index triangle) {
      if (triangle < 0 || !(across(corners_of(body, points, static_cast<std::size_t>(triangle))).norm() > 0)) return;
      const Vec3 x = sunk(now, d, p);
      if (kept.any_within(x, least)) return;
      bind_to(body, corners_of(body, points, static_cast<std::size_t>(triangle)), triangle, p, to_eigen(x));
      kept.add(placed(body, points, body.shape.triangle.size() - 1));
    });
  }
  std::vector<Vec3> samples;
  for (std::size_t s = 0; s < body.shape.triangle.size(); ++s)
    samples.push_back(placed(body, body.shape.points.front(), s));
  return samples;
}

std::vector<Vec3> first_velocities(const Body& body) {
  const double way = 1e-3;  // of the way to the second file: a difference quotient
  const std::vector<double>& time = body.shape.time;
  const Points later = points_at(body.shape, time[0] + way * (time[1] - time[0]));
  std::vector<Vec3> velocities;
  for (std::size_t s = 0; s < body.shape.triangle.size(); ++s)
    velocities.push_back(
        to_vec3((to_eigen(placed(body, later, s)) - to_eigen(placed(body, body.shape.points.front(), s))) *
                (rate_after(body.shape, 0) / way)));
  return velocities;
}

std::vector<double> largest_areas(const Body& body) {
  std::vector<double> areas(body.mesh_triangles.size(), 0.0);
  for (const Points& points : body.shape.points)
    for (std::size_t t = 0; t < areas.size(); ++t)
      areas[t] = std::max(areas[t], 0.5 * across(corners_of(body, points, t)).norm());
  return areas;
}

double near_pairs(const Body& body) {
  const double block = 2 * body.field.spacing, kept = 0.4;  // of those that a triangle's box meets; of a fish 0.35
  double pairs = 0;
  for (std::size_t t = 0; t < body.mesh_triangles.size(); ++t) {
    const CornerPoints x = corners_of(body, body.mesh_points, t);
    const Vector3d size = x[0].cwiseMax(x[1]).cwiseMax(x[2]) - x[0].cwiseMin(x[1]).cwiseMin(x[2]);
    pairs += kept * ((size.array() + 2 * body.shape.band) / block + 1).prod();
  }
  return pairs;
}

}  // namespace drench
