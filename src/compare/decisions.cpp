#include "compare/decisions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <set>

#include "base/eigen_vec.hpp"
#include "setup/body_geometry.hpp"
#include "setup/deforming_body.hpp"
#include "setup/point_grid.hpp"
#include "state/domain_border.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

double largest_coordinate(const Vec3& x) { return std::max({std::fabs(x[0]), std::fabs(x[1]), std::fabs(x[2])}); }

/// The decision of stage neighbors on a pair.
enum class Culled { no, yes, by_rounding };

/// The cloths' samples as the liquid meets them.
class Sheet {
 public:
  Sheet(const Model& model, const HostState& state, const Precision& precision)
      : h_(model.support), reach_(1.25 * model.spacing), touch_(0.1 * model.spacing), grid_(1.01 * model.support) {
    for (std::size_t p = 0; p < model.samples.triangle.size(); ++p) {
      const auto& nodes = model.mesh.triangle[static_cast<std::size_t>(model.samples.triangle[p])];
      Vector3d corner[3], x = Vector3d::Zero();
      double farthest = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& node = state.node_position[static_cast<std::size_t>(nodes[k])];
        corner[k] = to_eigen(node);
        x += model.samples.weight[p][k] * corner[k];
        farthest = std::max(farthest, largest_coordinate(node));
      }
      const Vector3d e = corner[1] - corner[0], f = corner[2] - corner[0], n = e.cross(f);
      const double u = precision.rounding, ratio = n.norm() > 0 ? e.norm() * f.norm() / n.norm() : 0;
      position_.push_back(x);
      normal_.push_back(n.norm() > 0 ? Vector3d(n / n.norm()) : Vector3d::Zero());
      // of the plane's position, and of its normal over the length of a pair beyond h
      rounding_.push_back(separation_rounding(model, precision, farthest) + 2 * h_ * u * (6 * ratio + 4));
      grid_.add(to_vec3(x));
    }
    for (const auto& edge : model.mesh.boundary_edge)
      boundary_.push_back({position_of(state, edge[0]), position_of(state, edge[1]), position_of(state, edge[2])});
    near_edges_ = model.samples.boundary_edges;
  }

  /// Those that a particle at x may have for its nearest one within h; `none`: perhaps it has none.
  struct Nearest {
    std::vector<Index> samples;
    bool none = true;
  };
  Nearest nearest(const Vec3& x) const {
    std::vector<std::pair<double, Index>> near;
    for_near(x, [&](double distance, Index p) { near.emplace_back(distance, p); });
    std::sort(near.begin(), near.end());
    Nearest found;
    for (const auto& [distance, p] : near) {
      const double rounding = at(rounding_, p);
      if (distance > h_ + rounding || distance > near.front().first + 2 * rounding) continue;
      found.samples.push_back(p);
      if (distance < h_ - rounding) found.none = false;
    }
    return found;
  }

  /// Is x in the plane of a sample that it has within h, or as far from it as what touches it may be?
  bool in_a_plane(const Vec3& x) const {
    bool found = false;
    for_near(x, [&](double distance, Index p) {
      const double height = std::fabs((to_eigen(x) - at(position_, p)).dot(at(normal_, p))),
                   rounding = at(rounding_, p);
      found = found || (distance <= h_ + rounding && (height <= rounding || std::fabs(height - touch_) <= rounding));
    });
    return found;
  }

  /// Whether the nearest sample of xi parts it from xj.
  Culled between(const Nearest& nearest_of_i, const Vec3& xi, const Vec3& xj) const {
    std::set<Culled> answers;
    if (nearest_of_i.none) answers.insert(Culled::no);
    for (const Index p : nearest_of_i.samples) answers.insert(crosses(p, to_eigen(xi), to_eigen(xj)));
    return answers.size() == 1 ? *answers.begin() : Culled::by_rounding;
  }

 private:
  template <class T>
  static const T& at(const std::vector<T>& values, Index p) {
    return values[static_cast<std::size_t>(p)];
  }

  template <class F>
  void for_near(const Vec3& x, F&& f) const {
    Vec3 low = x, high = x;
    for (std::size_t c = 0; c < 3; ++c) low[c] -= 1.01 * h_, high[c] += 1.01 * h_;
    grid_.for_box(low, high, [&](Index p) { f((to_eigen(x) - at(position_, p)).norm(), p); });
  }

  Culled crosses(Index p, const Vector3d& xi, const Vector3d& xj) const {
    const Vector3d n = at(normal_, p), ri = xi - at(position_, p), rj = xj - at(position_, p);
    if (n.isZero(0)) return Culled::no;
    const double si = ri.dot(n), sj = rj.dot(n), rounding = at(rounding_, p), apart = std::fabs(si - sj);
    const bool known = std::fabs(si) > rounding && std::fabs(sj) > rounding;
    if (known && (si < 0) == (sj < 0)) return Culled::no;
    // How far the crossing, if there is one, can be from where it seems to be.
    const double slack = rounding + (apart > rounding ? std::min(1.0, 2 * rounding / apart) : 1) * (ri - rj).norm();
    const double along = apart > 0 ? std::clamp(si / (si - sj), 0.0, 1.0) : 0;
    const Vector3d c = ri + along * (rj - ri);
    if (c.norm() > reach_ + slack) return Culled::no;
    const bool beyond = beyond_boundary(p, at(position_, p) + c);
    for (int corner = 0; corner < 8 && !near_edges_.empty(); ++corner) {  // of a cube that holds the slack
      const Vector3d to(corner & 1 ? slack : -slack, corner & 2 ? slack : -slack, corner & 4 ? slack : -slack);
      if (beyond_boundary(p, at(position_, p) + c + to) != beyond) return Culled::by_rounding;
    }
    if (beyond) return Culled::no;
    return known && c.norm() < reach_ - slack ? Culled::yes : Culled::by_rounding;
  }

  /// Whether c is beyond the boundary of sample p's sheet.
  bool beyond_boundary(Index p, const Vector3d& c) const {
    if (near_edges_.empty()) return false;
    double least = 0, side = 0;
    Vector3d last_foot = Vector3d::Zero(), last_outward = Vector3d::Zero();
    bool any = false;
    for (const Index e : at(near_edges_, p)) {
      if (e < 0) continue;
      const auto& [a, b, o] = at(boundary_, e);
      const Vector3d along = b - a, inward = o - a;
      const double where = std::clamp((c - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
      const Vector3d outward = (inward.dot(along) / along.squaredNorm() * along - inward).normalized(),
                     foot = where == 1 ? b : Vector3d(a + where * along);
      const double distance = (c - foot).norm();
      if (any && foot == last_foot) return (c - foot).dot(outward + last_outward) > 0;
      if (!any || distance < least) {
        least = distance;
        side = (c - a).dot(outward);
      }
      any = true;
      last_foot = foot;
      last_outward = outward;
    }
    return side > 0;
  }

  static Vector3d position_of(const HostState& state, Index node) {
    return to_eigen(state.node_position[static_cast<std::size_t>(node)]);
  }

  double h_, reach_, touch_;
  std::vector<Vector3d> position_, normal_;
  std::vector<double> rounding_;
  std::vector<std::array<Vector3d, 3>> boundary_;  // m
  std::vector<std::array<Index, 2>> near_edges_;
  PointGrid grid_;
};

Culled culled(const Sheet& sheet, const std::vector<Sheet::Nearest>& nearest, const HostState& s, Index i, Index j) {
  const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
  const Culled one = sheet.between(nearest[a], s.fluid_position[a], s.fluid_position[b]);
  const Culled other = sheet.between(nearest[b], s.fluid_position[b], s.fluid_position[a]);
  if (one == Culled::yes || other == Culled::yes) return Culled::yes;
  return one == Culled::no && other == Culled::no ? Culled::no : Culled::by_rounding;
}

/// Particles near the cloth for which a rounding decides on which side of it they are, or whether it culls a pair.
std::set<Index> sided_by_rounding(const Model& model, const HostState& s, const Sheet& sheet) {
  std::set<Index> found;
  std::vector<Sheet::Nearest> nearest;
  for (const Vec3& x : s.fluid_position) nearest.push_back(sheet.nearest(x));
  PointGrid grid(1.01 * model.support);
  std::vector<Index> near;
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    grid.add(s.fluid_position[i]);
    if (!nearest[i].samples.empty()) near.push_back(static_cast<Index>(i));
  }
  for (const Index i : near) {
    const Vec3& x = s.fluid_position[static_cast<std::size_t>(i)];
    if (sheet.in_a_plane(x)) found.insert(i);
    if (model.scene.through_cloth) continue;
    Vec3 low = x, high = x;
    for (std::size_t c = 0; c < 3; ++c) low[c] -= 1.01 * model.support, high[c] += 1.01 * model.support;
    grid.for_box(low, high, [&](Index j) {
      if (j == i || (j < i && !nearest[static_cast<std::size_t>(j)].samples.empty())) return;  // seen from j
      const Vec3& y = s.fluid_position[static_cast<std::size_t>(j)];
      if ((to_eigen(x) - to_eigen(y)).norm() > 1.001 * model.support) return;
      if (culled(sheet, nearest, s, i, j) == Culled::by_rounding) found.insert({i, j});
    });
  }
  return found;
}

std::size_t leave_planes(const Model& model, const Precision& precision, HostState& s) {
  constexpr int attempts = 30;  // the first leaves about an eighth of them
  const Sheet sheet(model, s, precision);
  std::mt19937 random(1);  // the same numbers everywhere
  std::set<Index> moved;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    const std::set<Index> now = sided_by_rounding(model, s, sheet);
    if (now.empty()) break;
    for (const Index i : now) {
      Vec3& x = s.fluid_position[static_cast<std::size_t>(i)];
      const double far = 8 * (1 + attempt) * separation_rounding(model, precision, largest_coordinate(x));
      for (double& axis : x) axis += far * (2.0 * random() / 4294967295.0 - 1);
    }
    moved.insert(now.begin(), now.end());
  }
  return moved.size();
}

/// A body where it is at the end of the step.
struct PlacedBody {
  const Body& body;
  Vector3d position;
  Eigen::Quaterniond turn;
  std::optional<Body> shape = {};  // of one that changes it

  PlacedBody(const Body& b, const HostState& s, std::size_t k, double dt)
      : body(b), position(to_eigen(s.body_position[k])), turn(Eigen::Quaterniond::Identity()) {
    if (!b.moves()) return;
    if (b.deforms()) shape = shape_with_field_at(b, s.time + dt);
    const auto& q = s.body_orientation[k];
    const Vector3d angle = dt * to_eigen(s.body_angular_velocity[k]);
    position += dt * to_eigen(s.body_velocity[k]);
    turn = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
    if (angle.norm() > 0) turn = Eigen::AngleAxisd(angle.norm(), angle.normalized()) * turn;
  }

  /// Distance (m) of x and its gradient; 1e30 where there is none.
  double distance(const Vector3d& x, Vector3d& normal) const {
    Vec3 n{0, 0, 0};
    if (!body.moves() || shape) {
      const double phi = signed_distance(shape ? *shape : body, to_vec3(x), n);
      normal = to_eigen(n);
      return phi;
    }
    const double phi = signed_distance(body, to_vec3(to_eigen(body.center) + turn.conjugate() * (x - position)), n);
    normal = turn * to_eigen(n);
    return phi;
  }
};

/// Ends of paths, kept off surfaces.
class Ends {
 public:
  Ends(const Model& model, const HostState& state, double dt, const Precision& precision)
      : model_(model), dt_(dt), precision_(precision) {
    for (std::size_t k = 0; k < model.bodies.size(); ++k) bodies_.emplace_back(model.bodies[k], state, k, dt);
  }

  /// Some roundings of the largest number at hand, m.
  double rounding(const Vector3d& end, double size = 0) const { return 16 * precision_.rounding * (end.norm() + size); }

  /// What brings `end` off the distance `clearance` from the bodies, m.
  Vector3d off_bodies(Vector3d end, double clearance) const {
    const Vector3d begin = end;
    for (int sweep = 0; sweep < 5; ++sweep) {
      for (const PlacedBody& body : bodies_) {
        Vector3d normal;
        const double phi = body.distance(end, normal) - clearance,
                     slack = rounding(end, body.position.norm() + clearance);
        if (std::fabs(phi) <= slack) end += (4 * slack - phi) * normal;
      }
    }
    return end - begin;
  }

  Vector3d off_border(Vector3d end) const {
    const Vector3d begin = end;
    const Box border = domain_border(model_);
    const double slack = rounding(end);
    for (int a = 0; a < 3; ++a) {
      const auto k = static_cast<std::size_t>(a);
      if (std::fabs(end[a] - border.min[k]) <= slack) end[a] = border.min[k] + 4 * slack;
      if (std::fabs(end[a] - border.max[k]) <= slack) end[a] = border.max[k] - 4 * slack;
    }
    return end - begin;
  }

  /// Changes the velocity of a path by what `correction` says of its end; returns whether it did.
  bool correct(const Vec3& begin, Vec3& velocity, const std::function<Vector3d(const Vector3d&)>& correction) const {
    const Vector3d v = to_eigen(velocity), change = correction(to_eigen(begin) + dt_ * v);
    if (change.isZero(0)) return false;
    velocity = to_vec3(v + change / dt_);
    return true;
  }

 private:
  const Model& model_;
  double dt_;
  Precision precision_;
  std::vector<PlacedBody> bodies_;
};

/// The cloth's triangles at the end of the step.
class EndTriangles {
 public:
  EndTriangles(const Model& model, const std::vector<Vec3>& nodes) : model_(model), nodes_(nodes) {
    double longest = model.support;
    for (const auto& t : model.mesh.triangle)
      for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, (corner(t[k]) - corner(t[(k + 1) % 3])).norm());
    reach_ = longest;
    grid_ = PointGrid(reach_);
    for (const auto& t : model.mesh.triangle) grid_.add(to_vec3((corner(t[0]) + corner(t[1]) + corner(t[2])) / 3));
  }

  Vector3d off_planes(const Ends& ends, Vector3d end) const {
    const Vector3d begin = end;
    for (int sweep = 0; sweep < 5; ++sweep) {
      const Vector3d low = end.array() - reach_, high = end.array() + reach_;
      bool moved = false;
      grid_.for_box(to_vec3(low), to_vec3(high), [&](Index triangle) {
        const auto& t = model_.mesh.triangle[static_cast<std::size_t>(triangle)];
        const Vector3d e = corner(t[1]) - corner(t[0]), f = corner(t[2]) - corner(t[0]), n = e.cross(f);
        const double square = n.squaredNorm();
        if (!(square > 0)) return;
        const Vector3d p = end - corner(t[0]), normal = n / std::sqrt(square);
        const double height = p.dot(normal), slack = ends.rounding(end) + 1.01e-6 * model_.spacing;
        if (std::fabs(height) > slack) return;
        const double v = p.cross(f).dot(n) / square, w = e.cross(p).dot(n) / square, margin = -0.01;
        if (v < margin || w < margin || 1 - v - w < margin) return;
        end += ((height < 0 ? -4 : 4) * slack - height) * normal;
        moved = true;
      });
      if (!moved) break;
    }
    return end - begin;
  }

 private:
  Vector3d corner(Index n) const { return to_eigen(nodes_[static_cast<std::size_t>(n)]); }

  const Model& model_;
  const std::vector<Vec3>& nodes_;
  double reach_ = 0;
  PointGrid grid_{1};
};

std::size_t leave_ends(Backend& reference, const Model& model, const StepInfo& info, const Precision& precision,
                       HostState& s) {
  const Ends ends(model, s, info.dt, precision);
  std::size_t moved = 0;
  for (std::size_t n = 0; n < s.node_position.size() && model.has_moving_cloth(); ++n) {
    const ClothMaterial& cloth = model.material_of_node(static_cast<Index>(n));
    if (model.mesh.pinned[n] || cloth.self_collision) continue;
    moved += ends.correct(s.node_position[n], s.node_velocity[n],
                          [&](const Vector3d& end) { return ends.off_bodies(end, cloth.thickness); });
  }
  if (s.fluid_position.empty()) return moved;
  std::vector<Vec3> nodes = s.node_position;
  if (model.has_moving_cloth()) {  // where they end does not depend on what the liquid does
    StepReport report;
    run_stage_from(reference, model, Stage::advection, s, info, report);
    nodes = reference.download().node_position;
  }
  const EndTriangles triangles(model, nodes);
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    bool changed = ends.correct(s.fluid_position[i], s.fluid_velocity[i],
                                [&](const Vector3d& end) { return triangles.off_planes(ends, end); });
    changed |= ends.correct(s.fluid_position[i], s.fluid_velocity[i],
                            [&](const Vector3d& end) { return ends.off_bodies(end, 0); });
    changed |= ends.correct(s.fluid_position[i], s.fluid_velocity[i],
                            [&](const Vector3d& end) { return ends.off_border(end); });
    moved += changed;
  }
  return moved;
}

}  // namespace

double separation_rounding(const Model& model, const Precision& precision, double largest_coordinate) {
  return 2 * precision.rounding * (9 * (largest_coordinate + 2 * model.support) + 2 * model.support);
}

std::size_t leave_decisions(Backend& reference, const Model& model, Stage stage, const StepInfo& info,
                            const Precision& precision, HostState& state) {
  std::size_t moved = 0;
  if (stage >= Stage::neighbors && stage <= Stage::advection && model.samples.count() > 0 &&
      !state.fluid_position.empty())
    moved += leave_planes(model, precision, state);
  if (stage == Stage::advection) moved += leave_ends(reference, model, info, precision, state);
  return moved;
}

}  // namespace drench
