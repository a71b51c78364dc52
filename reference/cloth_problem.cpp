#include "cloth_problem.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "state/keyed_motion.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr double contact_range = 0.01;  // of the thickness, beyond the clearance

/// −Σ_m B_nm x_m = Σ_m B_nm (x_n − x_m) of plates, N.
void add_plates(const ClothMesh& mesh, const Vectors& x, Vectors& force) {
  for (std::size_t k = 0; k < mesh.plate_pair.size(); ++k) {
    const auto [n, m] = mesh.plate_pair[k];
    const Vector3d pull = mesh.plate_weight[k] * (x[n] - x[m]);
    force[n] += pull;
    force[m] -= pull;
  }
}

/// A body within the range of contact of a node.
struct Touched {
  std::size_t body;
  NearBody near;
  double pressed = 0;
};

/// Adds a body that the node touches. Of two parts of one mesh that have nearly the same surface there the one that
/// leaves the node less room alone counts.
void add_touched(const std::vector<PlacedBody>& bodies, const Touched& t, std::vector<Touched>& touched) {
  for (Touched& other : touched) {
    if (bodies[other.body].index != bodies[t.body].index || other.near.normal.dot(t.near.normal) <= 0.9) continue;
    if (t.near.distance - t.near.kept < other.near.distance - other.near.kept) other = t;
    return;
  }
  touched.push_back(t);
}

/// The two bodies that squeeze a node into the narrowest gap.
struct SqueezingPair {
  bool exists = false;
  std::size_t first = 0, second = 0;
  Vector3d halfway = Vector3d::Zero();  // normal of the surface between them, away from the first
  double squeeze = 0;                   // of all pairs, on each body
  double across = 0;                    // what presses the node from the first, or, if negative, from the second

  bool holds(std::size_t body) const { return exists && (body == first || body == second); }
};

/// `half`: what squeezes the node to half of its thickness.
SqueezingPair squeezing_pair(const std::vector<PlacedBody>& bodies, const std::vector<Touched>& touched,
                             const ClothMaterial& m, double half, const Clearance& clearance, const Vector3d& x) {
  SqueezingPair pair;
  double narrowest = 2 * m.thickness;
  for (std::size_t k = 1; k < touched.size(); ++k)
    for (std::size_t j = 0; j < k; ++j) {
      const Touched &one = touched[j], &other = touched[k];
      const std::optional<double> gap = gap_between(bodies[one.body], bodies[other.body], clearance, x);
      if (!gap) continue;
      const double fibres = m.rigid_share;                                     // of τ: no pressure takes more
      const double width = std::max(fibres + 0.01, *gap / (2 * m.thickness));  // over the free one
      const auto own = [&](const NearBody& near) { return near.plane ? near.kept : m.thickness; };
      const double unsqueezed = (own(one.near) + own(other.near)) / (2 * m.thickness);  // over the free one as well
      pair.squeeze += half * std::max(0.0, unsqueezed - width) / (width - fibres);
      if (!(*gap < narrowest)) continue;
      narrowest = *gap;
      pair.exists = true;
      pair.first = one.body;
      pair.second = other.body;
      pair.halfway = (one.near.slope * one.near.normal - other.near.slope * other.near.normal).normalized();
    }
  return pair;
}

/// Takes from `push` all that presses across the surface halfway, and the least pressing forces that leave no part of
/// it inward of the other bodies: the normal equations with signs, one after the other.
void take_what_presses(std::vector<Touched>& touched, SqueezingPair& pair, Vector3d& push) {
  const double size = push.norm();
  constexpr int most_sweeps = 1000;
  double change = 1;
  for (int sweep = 0; sweep < most_sweeps && change > 1e-12 * size && size > 0; ++sweep) {
    const double across = -push.dot(pair.halfway);
    pair.across += across;
    push += across * pair.halfway;
    change = std::abs(across);
    for (Touched& t : touched) {
      if (pair.holds(t.body)) continue;
      const double before = t.pressed;
      t.pressed = std::max(0.0, before - push.dot(t.near.normal));
      push += (t.pressed - before) * t.near.normal;
      change = std::max(change, std::abs(t.pressed - before));
    }
    if (touched.size() == 1) break;
  }
}

}  // namespace

Eigen::Matrix2d rest_frame(const ClothMesh& mesh, Index t) {
  const auto [a, b, c] = mesh.triangle[t];
  const Vector3d first = vec(mesh.rest_position[b]) - vec(mesh.rest_position[a]),
                 second = vec(mesh.rest_position[c]) - vec(mesh.rest_position[a]);
  Eigen::Matrix2d frame;
  frame << first.norm(), first.normalized().dot(second), 0, first.normalized().cross(second).norm();
  return frame;
}

Eigen::Matrix<double, 3, 2> corner_gradients(const Eigen::Matrix2d& frame) {
  const Eigen::Matrix2d inverse = frame.inverse();
  Eigen::Matrix<double, 3, 2> rows;
  rows << -inverse.row(0) - inverse.row(1), inverse.row(0), inverse.row(1);
  return rows;
}

double node_saturation(const ReferenceState& state, Index n) {
  const auto& capacity = state.model.samples.node_capacity;
  if (capacity.empty() || !(capacity[n] > 0)) return 0;
  return std::min(1.0, static_cast<double>(state.s.node_liquid[n]) * state.model.quantum / capacity[n]);
}

Vector3d pin_position(const ReferenceState& state, Index n, double time) {
  const Model& m = state.model;
  const Index motion = m.mesh.pin_motion.empty() ? -1 : m.mesh.pin_motion[n];
  if (motion < 0) return vec(state.s.node_position[n]);
  const PinMotion& p = m.pin_motions[motion];
  if (p.body >= 0) return vec(carried_point(m.bodies[p.body], arr(vec(m.mesh.rest_position[n]) - vec(p.center)), time));
  const double now = std::min(std::max(time, p.start), p.end);
  const Eigen::AngleAxisd turn(p.rate.integral(p.start, now), vec(p.axis));
  const Eigen::Quaterniond before(p.rotated[0], p.rotated[1], p.rotated[2], p.rotated[3]);
  return vec(p.center) + vec(p.offset) + vec(p.velocity.integral(p.start, now)) + vec(p.path.at(now)) +
         turn * (before * (vec(m.mesh.rest_position[n]) - vec(p.center)));
}

ClothProblem::ClothProblem(const ReferenceState& s, const StepInfo& info)
    : state(s), dt(info.dt), bodies(placed_bodies(s, info)) {
  const ClothMesh& mesh = model().mesh;
  for (const Vec3& x : state.s.node_position) start.push_back(vec(x));
  target = start;
  for (Index n = 0; n < mesh.nodes(); ++n) {
    const double stiffness = mesh.soft_pin(n);
    held.push_back(stiffness > 0 && model().pin_motions[mesh.pin_motion[n]].holds(info.time, dt) ? stiffness : 0);
    mass.push_back(node_mass(state, n) + held[n] * dt * dt);
    diagonal.push_back(mass[n] / (dt * dt));
    clearance.push_back(clearance_of(state, bodies, n, dt));
    growth.push_back(material(n).porous ? material(n).hygral_expansion * node_saturation(state, n) : 0);
  }
  for (std::size_t e = 0; e < mesh.edge.size(); ++e) {
    for (const Index n : mesh.edge[e]) diagonal[n] += (1 + material(n).strain_damping / dt) * mesh.edge_stiffness[e];
  }
  for (std::size_t k = 0; k < mesh.stitch.size(); ++k) {
    const double left = mesh.stitch_time[k] > 0 ? std::max(0.0, 1 - (info.time + dt) / mesh.stitch_time[k]) : 0.0;
    const auto [i, j] = mesh.stitch[k];
    stitch_length.push_back(
        std::min(mesh.stitch_length[k] * left * left * (3 - 2 * left), (start[i] - start[j]).norm()));
    for (const Index n : mesh.stitch[k])
      diagonal[n] += (1 + material(n).strain_damping / dt) * mesh.stitch_stiffness[k];
  }
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    double sum = 0;
    for (const double weight : mesh.hinge_weight[h]) sum += std::abs(weight);
    for (int a = 0; a < 4; ++a) {
      diagonal[mesh.hinge[h][a]] += 0.5 * mesh.hinge_stiffness[h] * std::abs(mesh.hinge_weight[h][a]) * sum;
    }
  }
  for (std::size_t k = 0; k < mesh.plate_pair.size(); ++k) {
    for (const Index n : mesh.plate_pair[k]) diagonal[n] += std::max(0.0, -mesh.plate_weight[k]);
  }
  if (!model().has_triangle_stress()) return;
  for (Index t = 0; t < mesh.triangles(); ++t) {
    const Eigen::Matrix<double, 3, 2> rows = corner_gradients(frame(t));
    const Eigen::Vector3d share = rows.cwiseAbs() * rows.cwiseAbs().colwise().sum().transpose();
    double bound = model().has_strain_limit() ? mesh.limit_stiffness[t] : 0;
    if (model().has_membrane()) {
      const Membrane<double>& m = mesh.membrane[t];
      const auto [warp, weft] = yarn_reach(t);
      const auto steepest = [](double k, double lock, double e) {
        return lock > 0 ? k * (1 + std::pow(e / lock, 2)) / std::pow(1 - std::pow(e / lock, 2), 2) : k;
      };
      bound += (1 + material(mesh.triangle[t][0]).strain_damping / dt) *
               (std::max(steepest(m.warp, m.warp_locking, warp), steepest(m.weft, m.weft_locking, weft)) + 2 * m.shear);
    }
    for (int c = 0; c < 3; ++c) diagonal[mesh.triangle[t][c]] += 0.5 * bound * share[c];
  }
}

Eigen::Matrix2d ClothProblem::frame(Index t) const {
  const auto [a, b, c] = model().mesh.triangle[t];
  return (1 + (growth[a] + growth[b] + growth[c]) / 3) * rest_frame(model().mesh, t);
}

Index ClothProblem::springs() const {
  return static_cast<Index>(model().mesh.edge.size() + model().mesh.stitch.size());
}

Vector3d ClothProblem::spring_force(Index e, const Vectors& x) const {
  const ClothMesh& mesh = model().mesh;
  const Index stitch = e - static_cast<Index>(mesh.edge.size());
  const auto [i, j] = stitch < 0 ? mesh.edge[e] : mesh.stitch[stitch];
  const double rest_length =
      stitch < 0 ? mesh.edge_length[e] * (1 + (growth[i] + growth[j]) / 2) : stitch_length[stitch];
  const double stiffness = stitch < 0 ? mesh.edge_stiffness[e] : mesh.stitch_stiffness[stitch];
  const Vector3d along = x[i] - x[j];
  const double length = along.norm();
  const Vector3d rest = length > 0 ? Vector3d(rest_length / length * along) : Vector3d::Zero();
  // Kelvin–Voigt: the rate of stretching along the edge as it lay at the start of the step
  const Vector3d direction = (start[i] - start[j]).normalized();
  const double rate = ((along - (start[i] - start[j])) / dt).dot(direction);
  return -stiffness * (along - rest + material(i).strain_damping * rate * direction);
}

Vector3d ClothProblem::hinge_force(Index h, const Vectors& x) const {
  const ClothMesh& mesh = model().mesh;
  Vector3d bend = Vector3d::Zero();
  for (int a = 0; a < 4; ++a) bend += mesh.hinge_weight[h][a] * x[mesh.hinge[h][a]];
  return -mesh.hinge_stiffness[h] * bend;
}

Stress ClothProblem::limit_stress(Index t, const Vectors& x) const {
  const ClothMesh& mesh = model().mesh;
  const double limit = model().cloths[mesh.triangle_cloth[t]].strain_limit;
  const auto [a, b, c] = mesh.triangle[t];
  Eigen::Matrix<double, 3, 2> edges;
  edges << x[b] - x[a], x[c] - x[a];
  const Eigen::Matrix<double, 3, 2> deformation = edges * frame(t).inverse();
  // In axes of the deformed triangle's plane, along its first edge and across.
  const Vector3d along = deformation.col(0).stableNormalized(),
                 rest = deformation.col(1) - along * along.dot(deformation.col(1));
  Eigen::Matrix<double, 3, 2> axes;
  axes << along, rest.stableNormalized();
  const Eigen::JacobiSVD<Eigen::Matrix2d> svd(axes.transpose() * deformation,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector2d clamped = svd.singularValues();
  for (double& sigma : clamped) {
    if (sigma > 0) sigma = std::min(std::max(sigma, 1 - limit), 1 + limit);
  }
  const Eigen::Matrix<double, 3, 2> nearest = axes * svd.matrixU() * clamped.asDiagonal() * svd.matrixV().transpose();
  return -mesh.limit_stiffness[t] * (deformation - nearest);
}

std::array<double, 2> ClothProblem::yarn_reach(Index t) const {
  const ClothMesh& mesh = model().mesh;
  const Membrane<double>& m = mesh.membrane[t];
  const auto [a, b, c] = mesh.triangle[t];
  if (m.warp == 0) return {0, 0};
  Stress edges;
  edges << start[b] - start[a], start[c] - start[a];
  const Stress f = edges * frame(t).inverse();
  const Vector3d warp = m.cosine * f.col(0) + m.sine * f.col(1), weft = m.cosine * f.col(1) - m.sine * f.col(0);
  return {std::min(locking_part * m.warp_locking, std::max(0.0, warp.norm() - 1) + locking_margin),
          std::min(locking_part * m.weft_locking, std::max(0.0, weft.norm() - 1) + locking_margin)};
}

Stress ClothProblem::membrane_stress(Index t, const Vectors& x) const {
  const ClothMesh& mesh = model().mesh;
  const Membrane<double>& m = mesh.membrane[t];
  if (m.warp == 0) return Stress::Zero();
  const auto [a, b, c] = mesh.triangle[t];
  // Columns: along warp and weft, then along the lines halfway between them.
  Eigen::Matrix2d axes;
  axes << m.cosine, -m.sine, m.sine, m.cosine;
  const Eigen::Matrix2d diagonals = axes * Eigen::Rotation2Dd(std::numbers::pi / 4).toRotationMatrix();
  const auto columns = [&, a = a, b = b, c = c](const Vectors& at, const Eigen::Matrix2d& directions) {
    Stress edges;
    edges << at[b] - at[a], at[c] - at[a];
    return Stress(edges * frame(t).inverse() * directions);
  };
  const Stress yarns = columns(x, axes), lines = columns(x, diagonals);  // a second line of diagonals is −(u − v)/√2
  const Stress yarns0 = columns(start, axes), lines0 = columns(start, diagonals);
  const double rate = material(a).strain_damping / dt;
  // Of a stretch: its direction, that at the start of the step, and what it grows by.
  const auto growth = [](const Vector3d& now, const Vector3d& before) {
    return before.stableNormalized().dot(now - before);
  };
  const double wet =
      1 + (m.wet - 1) * (node_saturation(state, a) + node_saturation(state, b) + node_saturation(state, c)) / 3;
  const std::array<double, 2> reach = yarn_reach(t);
  Stress along_yarns, along_lines;
  for (int k = 0; k < 2; ++k) {
    const double stiffness = k == 0 ? m.warp : m.weft, lock = k == 0 ? m.warp_locking : m.weft_locking;
    const Vector3d now = yarns.col(k), before = yarns0.col(k);
    // Eq. 4c while it is stretched, from the reach on along the tangent
    const double strain = now.norm() - 1;
    double tension = strain;
    if (lock > 0 && strain > 0) {
      const double bent = std::min(strain, reach[k]), left = 1 - std::pow(bent / lock, 2);
      tension = bent / left + (2 - left) / (left * left) * (strain - bent);
    }
    along_yarns.col(k) =
        -stiffness * (tension * now.stableNormalized() + rate * growth(now, before) * before.stableNormalized());
  }
  const double shear = lines.col(0).norm() - lines.col(1).norm();
  const double shearing = growth(lines.col(0), lines0.col(0)) - growth(lines.col(1), lines0.col(1));
  for (int k = 0; k < 2; ++k) {
    const double sign = k == 0 ? 1 : -1;
    along_lines.col(k) = -m.shear * sign *
                         (shear * lines.col(k).stableNormalized() + rate * shearing * lines0.col(k).stableNormalized());
  }
  return wet * (along_yarns * axes.transpose() + along_lines * diagonals.transpose());
}

Stress ClothProblem::triangle_stress(Index t, const Vectors& x) const {
  Stress sum = Stress::Zero();
  if (model().has_strain_limit()) sum += limit_stress(t, x);
  if (model().has_membrane()) sum += membrane_stress(t, x);
  return sum;
}

Vectors ClothProblem::gathered(const Vectors& spring, const Vectors& hinge, const std::vector<Stress>& triangle) const {
  const ClothMesh& mesh = model().mesh;
  Vectors force(start.size(), Vector3d::Zero());
  for (std::size_t e = 0; e < mesh.edge.size(); ++e) {
    force[mesh.edge[e][0]] += spring[e];
    force[mesh.edge[e][1]] -= spring[e];
  }
  for (std::size_t k = 0; k < mesh.stitch.size(); ++k) {
    force[mesh.stitch[k][0]] += spring[mesh.edge.size() + k];
    force[mesh.stitch[k][1]] -= spring[mesh.edge.size() + k];
  }
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    for (int a = 0; a < 4; ++a) force[mesh.hinge[h][a]] += mesh.hinge_weight[h][a] * hinge[h];
  }
  for (std::size_t t = 0; t < triangle.size(); ++t) {
    const Eigen::Matrix3d f = triangle[t] * corner_gradients(frame(static_cast<Index>(t))).transpose();
    for (int k = 0; k < 3; ++k) force[mesh.triangle[t][k]] += f.col(k);
  }
  return force;
}

Vectors ClothProblem::internal_force(const Vectors& x) const {
  Vectors spring, hinge;
  for (Index e = 0; e < springs(); ++e) spring.push_back(spring_force(e, x));
  for (Index h = 0; h < static_cast<Index>(model().mesh.hinge.size()); ++h) hinge.push_back(hinge_force(h, x));
  std::vector<Stress> triangle;
  for (Index t = 0; model().has_triangle_stress() && t < model().mesh.triangles(); ++t)
    triangle.push_back(triangle_stress(t, x));
  Vectors force = gathered(spring, hinge, triangle);
  add_plates(model().mesh, x, force);
  return force;
}

Vectors ClothProblem::residual(const Vectors& x) const {
  Vectors r = internal_force(x);
  for (std::size_t n = 0; n < r.size(); ++n) r[n] += mass[n] / (dt * dt) * (target[n] - x[n]);
  return r;
}

void ClothProblem::project(Vectors& x) const {
  for (Index n = 0; n < model().mesh.nodes(); ++n) {
    if (is_free(n)) project_out(bodies, clearance[n], x[n]);
  }
}

Vector3d ClothProblem::before_planes(Index n, const Vector3d& now, Vector3d x) const {
  for (const PlacedBody& body : bodies) {
    const std::optional<NearBody> near = clearance[n].near(body, now);
    if (!near) continue;
    const bool closer = near->distance < near->kept;
    const double kept = closer ? distance_to_keep(bodies, body, *near, clearance[n], now) : near->kept;
    x += std::max(0.0, kept - near->distance - near->normal.dot(x - now)) * near->normal;
  }
  return x;
}

NodeContact ClothProblem::contact(Index n, const Vector3d& x, Vector3d& push, double stiffness,
                                  const OfBody& of_body) const {
  std::vector<Touched> touched;
  for (std::size_t b = 0; b < bodies.size() && is_free(n) && touched.size() < 4; ++b) {
    const std::optional<NearBody> near = clearance[n].near(bodies[b], x);
    if (near && near->distance < near->kept + contact_range * material(n).thickness)
      add_touched(bodies, {b, *near}, touched);
  }
  NodeContact found;
  if (touched.empty()) return found;
  const double half =
      material(n).compression_per_mass * model().mesh.solid_mass[n] / stiffness;  // squeezes to half of τ
  SqueezingPair pair = squeezing_pair(bodies, touched, material(n), half, clearance[n], x);
  take_what_presses(touched, pair, push);
  const auto press = [&](std::size_t b, double force, const Vector3d& normal) {
    if (of_body) of_body(b, -force * normal);
    found.press += force;
    found.surface += force * bodies[b].velocity_at(x);
  };
  // Of a normal, what is along the directions that are left; 0 for one as those before it.
  const auto fresh = [&](const Vector3d& normal) {
    const Vector3d along = found.free * normal;
    return along.norm() >= 0.05 ? Vector3d(along.normalized()) : Vector3d::Zero();
  };
  const auto hold = [&](const Vector3d& normal) {
    const Vector3d own = fresh(normal);
    found.free -= own * own.transpose();
  };
  if (pair.exists) {
    hold(pair.halfway);
    press(pair.first, pair.squeeze + std::max(0.0, pair.across), pair.halfway);
    press(pair.second, pair.squeeze + std::max(0.0, -pair.across), -pair.halfway);
    // Friction acts against the mean motion of both.
    found.surface = found.press / 2 * (bodies[pair.first].velocity_at(x) + bodies[pair.second].velocity_at(x));
  }
  for (const Touched& t : touched) {
    if (pair.holds(t.body)) continue;
    press(t.body, t.pressed, t.near.normal);
    if (t.pressed > 0) hold(t.near.normal);
  }
  if (found.press > 0) {
    found.surface /= found.press;
  } else if (!pair.exists) {
    const Vector3d& normal = touched[0].near.normal;
    found.free = Eigen::Matrix3d::Identity() - normal * normal.transpose();
    found.surface = bodies[touched[0].body].velocity_at(x);
    return found;
  }
  for (const Touched& t : touched) {
    if (pair.holds(t.body) || t.pressed > 0 || !found.beside.isZero(0)) continue;
    found.beside = fresh(t.near.normal);
  }
  return found;
}

double ClothProblem::friction(Index n) const {
  const ClothMaterial& m = material(n);
  return m.friction + node_saturation(state, n) * (m.friction_wet - m.friction);
}

Vector3d ClothProblem::with_friction(const NodeContact& contact, Index n, const Vector3d& from, Vector3d x,
                                     double loss) const {
  const auto slowed = [&](const Eigen::Matrix3d& free) {
    const Vector3d slip = free * (x - start[n] - dt * contact.surface);
    return Vector3d(x - std::min(1.0, loss / std::max(slip.norm(), 1e-300)) * slip);
  };
  const Vector3d& beside = contact.beside;
  const Vector3d alone = slowed(contact.free);
  if ((alone - from).dot(beside) >= 0) return alone;
  x -= (x - from).dot(beside) * beside;
  return slowed(contact.free - beside * beside.transpose());
}

Vector3d ClothProblem::unbalanced(Index n, const Vector3d& x, const Vector3d& r) const {
  Vector3d left = r;
  const NodeContact touched = contact(n, x, left, 1);
  if (touched.press == 0) return left;
  const Vector3d on = touched.free * left / diagonal[n];
  // A slip below a tenth of the displacement along the normal is not counted: normals of interpolated distances jump so
  // much.
  const Vector3d relative = x - start[n] - dt * touched.surface, slip = touched.free * relative;
  const Vector3d here = slip.norm() > 0.1 * (relative - slip).norm() ? x : Vector3d(x - slip);
  const Vector3d after = with_friction(touched, n, here, here + on, friction(n) * touched.press / diagonal[n]);
  return left + diagonal[n] * (after - here - on);
}

}  // namespace drench::reference
