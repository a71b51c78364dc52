#include "collision.hpp"

#include <algorithm>
#include <cmath>

#include "common.hpp"
#include "mixed_slopes.hpp"
#include "setup/body_geometry.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

/// Six times the volume of the tetrahedron of triangle and point: its sign is the side on which x lies.
double signed_volume(const Triangle& t, const Vector3d& x) { return (x - t[0]).dot((t[1] - t[0]).cross(t[2] - t[0])); }

/// Is x no farther from the triangle's outline than 1e-6 of its longest edge? So also slivers thinner than their
/// rounding are hit.
bool on_an_edge(const Triangle& t, const Vector3d& x) {
  double nearest = 1e300, longest = 0;
  for (int k = 0; k < 3; ++k) {
    const Vector3d edge = t[(k + 1) % 3] - t[k];
    const double length = edge.norm(),
                 s = length > 0 ? std::clamp((x - t[k]).dot(edge) / (length * length), 0.0, 1.0) : 0;
    nearest = std::min(nearest, (x - t[k] - s * edge).norm());
    longest = std::max(longest, length);
  }
  return nearest <= 1e-6 * longest;
}

/// Times at which f's derivative is 0: f = (p + τ dp)·((u + τ du) × (v + τ dv)), all relative to the first corner.
std::vector<double> turning_points(const MovingTriangle& t, const Vector3d& x0, const Vector3d& x1) {
  const Vector3d p = x0 - t.start[0], u = t.start[1] - t.start[0], v = t.start[2] - t.start[0];
  const Vector3d dp = x1 - t.end[0] - p, du = t.end[1] - t.end[0] - u, dv = t.end[2] - t.end[0] - v;
  const Vector3d n0 = u.cross(v), n1 = du.cross(v) + u.cross(dv), n2 = du.cross(dv);
  const double c1 = p.dot(n1) + dp.dot(n0);
  const double c2 = p.dot(n2) + dp.dot(n1);
  const double c3 = dp.dot(n2);
  return quadratic_roots(c1, 2 * c2, 3 * c3);
}

/// Trilinear in the lattice's values, with mixed_slopes; none beyond the lattice, without one or where it has far
/// values. `slope`: how fast it grows along the normal.
std::optional<double> field_distance(const DistanceField& field, const Vector3d& x, Vector3d& normal, double& slope) {
  normal = Vector3d::Zero();
  slope = 1;
  if (field.empty()) return std::nullopt;
  const Vector3d at = (x - vec(field.origin)) / field.spacing;
  std::array<Index, 3> cell;
  for (int a = 0; a < 3; ++a) {
    if (!(at[a] >= 0 && at[a] <= field.points[a] - 1)) return std::nullopt;
    cell[a] = std::min(static_cast<Index>(std::floor(at[a])), field.points[a] - 2);
  }
  const auto value = [&](Index i, Index j, Index k) {
    return field.value[field.index(cell[0] + i, cell[1] + j, cell[2] + k)];
  };
  for (int k = 0; k < 8; ++k)
    if (value(k & 1, k >> 1 & 1, k >> 2) == DistanceField::nowhere) return std::nullopt;
  const double u = at[0] - cell[0], v = at[1] - cell[1], w = at[2] - cell[2];
  const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
  // Along x first, then y, then z; the slopes are those of the same interpolation.
  double row[2][2], step[2][2];
  for (int k = 0; k < 2; ++k) {
    for (int j = 0; j < 2; ++j) {
      row[k][j] = mix(value(0, j, k), value(1, j, k), u);
      step[k][j] = value(1, j, k) - value(0, j, k);
    }
  }
  const double low = mix(row[0][0], row[0][1], v), high = mix(row[1][0], row[1][1], v);
  const Vector3d own(mix(mix(step[0][0], step[0][1], v), mix(step[1][0], step[1][1], v), w),
                     mix(row[0][1] - row[0][0], row[1][1] - row[1][0], w), high - low);
  const Vector3d gradient = mixed_slopes(own, cell, {u, v, w}, field,
                                         [&](Index i, Index j, Index k) { return field.value[field.index(i, j, k)]; });
  if (gradient.norm() > 0) slope = std::max(0.5, gradient.norm() / field.spacing);
  normal = gradient.norm() > 0 ? Vector3d(gradient.normalized()) : Vector3d::UnitY();
  return mix(low, high, w);
}

const DistanceField& lattice_of(const PlacedBody& placed) {
  const Body& body = *placed.body;
  return body.has_parts() ? body.parts[static_cast<std::size_t>(placed.part)] : body.field;
}

/// x in the axes of the body at t = 0.
Vector3d own_place(const PlacedBody& placed, const Vector3d& x) {
  return vec(placed.body->center) + placed.pose.orientation.conjugate() * (x - placed.pose.position);
}

/// The body has no distance at x. Is that because a part of a mesh is absent there, and not because x is beyond its
/// lattice?
bool is_nowhere(const PlacedBody& placed, const Vector3d& x) {
  if (!placed.body->has_parts()) return false;
  const DistanceField& field = lattice_of(placed);
  const Vector3d at = (own_place(placed, x) - vec(field.origin)) / field.spacing;
  for (int a = 0; a < 3; ++a)
    if (!(at[a] >= 0 && at[a] <= field.points[a] - 1)) return false;
  return true;
}

}  // namespace

Triangle MovingTriangle::at(double tau) const {
  // At both ends exactly the given corners, so that the sides there are those that the next step sees.
  if (tau == 0) return start;
  if (tau == 1) return end;
  Triangle t;
  for (int k = 0; k < 3; ++k) t[k] = start[k] + tau * (end[k] - start[k]);
  return t;
}

Vector3d unit_normal(const Triangle& t) {
  const Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]);
  const double length = n.norm();
  return length > 0 ? Vector3d(n / length) : Vector3d::Zero();
}

std::optional<Vector3d> barycentric(const Triangle& t, const Vector3d& x) {
  const Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]);
  const double area = n.squaredNorm();
  if (!(area > 0)) return std::nullopt;
  const double w1 = (x - t[0]).cross(t[2] - t[0]).dot(n) / area;
  const double w2 = (t[1] - t[0]).cross(x - t[0]).dot(n) / area;
  return Vector3d(1 - w1 - w2, w1, w2);
}

Vector3d interpolate(const Triangle& t, const Vector3d& weight) {
  return weight[0] * t[0] + weight[1] * t[1] + weight[2] * t[2];
}

std::vector<double> quadratic_roots(double c0, double c1, double c2) {
  std::vector<double> roots;
  const auto add = [&](double tau) {
    if (tau > 0 && tau < 1) roots.push_back(tau);
  };
  const double discriminant = c1 * c1 - 4 * c2 * c0;
  if (discriminant < 0) return roots;
  // Without cancellation; a division by 0 gives an infinity or NaN, which is not in (0, 1).
  const double q = -0.5 * (c1 + std::copysign(std::sqrt(discriminant), c1));
  add(q / c2);
  if (c0 / q != q / c2) add(c0 / q);
  std::sort(roots.begin(), roots.end());
  return roots;
}

std::optional<Hit> first_hit(const MovingTriangle& triangle, const Vector3d& x0, const Vector3d& x1, double touch) {
  const auto point = [&](double tau) { return tau == 1 ? x1 : Vector3d(x0 + tau * (x1 - x0)); };
  // Evaluated from the geometry, not from the cubic's coefficients: a change of side from start to end is never lost.
  const auto side = [&](double tau) { return signed_volume(triangle.at(tau), point(tau)); };
  const auto try_hit = [&](double tau) -> std::optional<Hit> {
    const Triangle t = triangle.at(tau);
    const std::optional<Vector3d> w = barycentric(t, point(tau));
    if (!w || (w->minCoeff() < -1e-6 && !on_an_edge(t, point(tau)))) return std::nullopt;
    return Hit{tau, *w};
  };

  std::vector<double> ends{0};
  for (const double tau : turning_points(triangle, x0, x1)) ends.push_back(tau);
  ends.push_back(1);
  if (side(0) == 0) {
    if (auto hit = try_hit(0)) return hit;
  }
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
    double low = ends[k], high = ends[k + 1];
    const double at_low = side(low), at_high = side(high);
    // Between two turning points the cubic is monotone: at most one root.
    if (at_low != 0 && at_high != 0 && (at_low > 0) != (at_high > 0)) {
      while (true) {
        const double middle = 0.5 * (low + high);
        if (middle <= low || middle >= high) break;
        ((side(middle) > 0) == (at_low > 0) ? low : high) = middle;
      }
      if (auto hit = try_hit(high)) return hit;
    }
    if (at_high == 0) {
      if (auto hit = try_hit(ends[k + 1])) return hit;
    }
  }
  if (std::abs((x1 - triangle.end[0]).dot(unit_normal(triangle.end))) <= touch) return try_hit(1);
  return std::nullopt;
}

std::vector<PlacedBody> placed_bodies(const ReferenceState& state, const StepInfo& info) {
  std::vector<PlacedBody> placed;
  std::vector<Pose> poses;
  for (Index k = 0; k < state.s.body_count(); ++k) poses.push_back(pose_of(state.s, k));
  hold(state, info, poses);
  for (Index k = 0; k < static_cast<Index>(state.model.bodies.size()); ++k) {
    const Body& body = state.model.bodies[k];
    const Pose& pose = poses[k];
    placed.push_back({&body, k, body.moves() ? advanced(pose, info.dt) : pose});
    if (body.deforms()) placed.back().surface = std::make_shared<DeformedSurface>(body, info.time, info.dt);
  }
  for (Index k = 0; k < static_cast<Index>(state.model.bodies.size()); ++k) {
    if (!state.model.bodies[k].has_parts()) continue;
    placed.push_back(placed[k]);
    placed.back().part = 1;
  }
  return placed;
}

std::optional<double> distance_to(const PlacedBody& placed, const Vector3d& x, Vector3d& normal) {
  double slope;
  return distance_to(placed, x, normal, slope);
}

std::optional<double> distance_to(const PlacedBody& placed, const Vector3d& x, Vector3d& normal, double& slope) {
  slope = 1;
  if (placed.surface) return placed.surface->distance(x, normal, slope);
  const Body& body = *placed.body;
  const Vector3d own = own_place(placed, x);
  if (body.kind == BodyScene::Kind::mesh) {
    const std::optional<double> distance = field_distance(lattice_of(placed), own, normal, slope);
    normal = placed.pose.orientation * normal;
    return distance;
  }
  Vec3 n;
  const double distance = signed_distance(body, arr(own), n);
  normal = placed.pose.orientation * vec(n);
  return distance;
}

std::optional<NearBody> Clearance::near(const PlacedBody& body, const Vector3d& x) const {
  NearBody found;
  const auto look = [&](const Vector3d& at) {
    const std::optional<double> distance = distance_to(body, at, found.normal, found.slope);
    if (distance) found.distance = *distance;
    return distance.has_value();
  };
  found.kept = thickness;
  if (least >= thickness) return look(x) ? std::optional(found) : std::nullopt;
  // The body stands where it is at the end of the step: where the node lies relative to its start is that far on.
  const Vector3d moved = start + dt * body.velocity_at(start);
  if (look(moved)) {
    found.kept = std::min(thickness, found.distance + release);
    if (found.distance < 0 && found.kept < 0.999 * thickness) {
      found.distance += found.normal.dot(x - moved);
      found.slope = 1;
      found.plane = true;
      return found;
    }
  } else if (is_nowhere(body, moved)) {
    return std::nullopt;
  }
  return look(x) ? std::optional(found) : std::nullopt;
}

Clearance clearance_of(const ReferenceState& state, const std::vector<PlacedBody>& bodies, Index n, double dt) {
  const ClothMaterial& m = state.model.material_of_node(n);
  Clearance c{m.thickness, m.release * dt, dt, vec(state.s.node_position[n]), m.thickness};
  for (const PlacedBody& body : bodies) {
    Vector3d normal;
    const std::optional<double> before = distance_to(body, c.start + dt * body.velocity_at(c.start), normal);
    if (before) c.least = std::min(c.least, *before + c.release);
  }
  return c;
}

std::optional<double> gap_between(const PlacedBody& one, const PlacedBody& other, const Clearance& clearance,
                                  const Vector3d& x) {
  const std::optional<NearBody> a = clearance.near(one, x), b = clearance.near(other, x);
  if (!a || !b || a->normal.dot(b->normal) > 0.9) return std::nullopt;
  if (a->distance + b->distance >= a->kept + b->kept) return std::nullopt;
  if (a->normal.dot(b->normal) >= 0) {  // Is it the mouth of a gap? A little further in they face each other then.
    const Vector3d further = x - 1.5 * clearance.thickness * (a->normal + b->normal).normalized();
    Vector3d inner_n, inner_m;
    distance_to(one, further, inner_n);
    distance_to(other, further, inner_m);
    if (inner_n.dot(inner_m) >= -0.5) return std::nullopt;
  }
  return a->distance + b->distance;
}

double distance_to_keep(const std::vector<PlacedBody>& bodies, const PlacedBody& body, const NearBody& near,
                        const Clearance& clearance, const Vector3d& x) {
  double kept = near.kept;
  if (clearance.thickness == 0) return kept;  // of liquid
  for (const PlacedBody& other : bodies) {
    if (&other == &body) continue;
    if (const std::optional<double> gap = gap_between(body, other, clearance, x))
      kept = std::min(kept, (*gap + near.kept - clearance.near(other, x)->kept) / 2);
  }
  return kept;
}

std::vector<BodyContact> project_out(const std::vector<PlacedBody>& bodies, const Clearance& clearance, Vector3d& x) {
  std::vector<BodyContact> contacts;
  for (const PlacedBody& body : bodies) {
    const std::optional<NearBody> near = clearance.near(body, x);
    if (!near || near->distance >= near->kept) continue;
    const double kept = distance_to_keep(bodies, body, *near, clearance, x);
    if (near->distance >= kept) continue;
    contacts.push_back({near->normal, body.velocity_at(x)});
    x += (kept - near->distance) / near->slope * near->normal;
    if (near->plane || body.body->kind != BodyScene::Kind::mesh) continue;
    for (int k = 0; k < 2; ++k) {  // Newton's method, because φ is interpolated
      Vector3d normal;
      double slope;
      const std::optional<double> distance = distance_to(body, x, normal, slope);
      if (!distance || std::abs(kept - *distance) <= 1e-9 * kept) break;
      x += (kept - *distance) / slope * normal;
    }
  }
  return contacts;
}

}  // namespace drench::reference
