// Stage advection of the oracle; the law and the numbers of its parts stand in src/stages/advection.hpp.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "cloth_problem.hpp"
#include "collision.hpp"
#include "state/domain_border.hpp"
#include "transfer.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

/// One particle's last collision with the cloth.
struct Collision {
  Index triangle = -1;  // none
  Vector3d weight = Vector3d::Zero();
  Vector3d normal = Vector3d::Zero();  // unit, to the side from which the particle came
  bool crossed = false;                // it stays where a triangle is between it and where it came from
};

/// Momentum of the nodes in fixed point; `p` in kg m/s.
void add_impulse(const ReferenceState& state, std::vector<Momentum>& sums, Index n, const Vector3d& p) {
  add(sums[n], momentum_of(1 / state.model.quantum, p));
}

// 0. What moves particle i away from those that it coincides with, m.
Vector3d shift_apart(const ReferenceState& state, Index i) {
  const HostState& s = state.s;
  const double d = state.model.spacing, mi = fluid_mass(state, i);
  Vector3d shift = Vector3d::Zero();
  for (const Index j : state.fluid_fluid[i]) {
    const Vector3d r = vec(s.fluid_position[i]) - vec(s.fluid_position[j]);
    const double mj = fluid_mass(state, j), missing = 1e-3 * d - r.norm();
    if (!(missing > 0) || !(mi + mj > 0)) continue;
    Vector3d axis = r.normalized();
    if (r.norm() < 1e-6 * d)
      axis = Vector3d::Unit((s.fluid_id[i] + s.fluid_id[j]) % 3) * (s.fluid_id[i] > s.fluid_id[j] ? 1 : -1);
    shift += mj / (mi + mj) * missing * axis;
  }
  return shift;
}

// 1. Fresh particles must not shoot out of the cloth.
void slow_fresh_particles(ReferenceState& state, std::vector<Momentum>& impulse) {
  const Model& m = state.model;
  double ramp = 0;  // T, s
  for (const ClothMaterial& cloth : m.cloths) ramp = std::max(ramp, cloth.emission_ramp);
  for (Index i = 0; i < state.s.fluid_count(); ++i) {
    if (state.s.fluid_origin[i] != static_cast<std::uint8_t>(Origin::cloth) || !(state.s.fluid_age[i] < ramp)) continue;
    Index nearest = -1;
    double distance = 0;
    for (const Index p : state.fluid_sample[i]) {
      const double r = (sample_position(state, p) - vec(state.s.fluid_position[i])).norm();
      if (nearest >= 0 && r >= distance) continue;
      nearest = p;
      distance = r;
    }
    if (nearest < 0) continue;
    const Vector3d relative = vec(state.s.fluid_velocity[i]) - sample_velocity(state, nearest);
    const double limit = m.spacing / ramp + 2 * vec(m.scene.gravity).norm() * state.s.fluid_age[i];
    const double speed = relative.norm();
    if (speed <= limit) continue;
    const Vector3d removed = (1 - limit / speed) * relative;
    state.s.fluid_velocity[i] = arr(vec(state.s.fluid_velocity[i]) - removed);
    for (int k = 0; k < 3; ++k) {
      add_impulse(state, impulse, sample_node(state, nearest, k),
                  m.samples.weight[nearest][k] * fluid_mass(state, i) * removed);
    }
  }
}

/// The velocity of node n without what it gained as bodies pushed it out to x (docs/theory/cloth.md, (26b)).
Vector3d at_rest_outwards(const ReferenceState& state, const std::vector<PlacedBody>& bodies,
                          const Clearance& clearance, Index n, const Vector3d& x, double dt, Vector3d v) {
  const double touching = 0.01 * clearance.thickness;  // beyond the clearance: nodes so near rest on a body
  const Vector3d pushed = dt * inverse_node_mass(state, n) * vec(state.s.node_contact_force[n]);  // m/s
  for (const PlacedBody& body : bodies) {
    const std::optional<NearBody> near = clearance.near(body, x);
    if (!near || near->distance >= distance_to_keep(bodies, body, *near, clearance, x) + touching) continue;
    const Vector3d start = vec(state.s.node_position[n]);
    Vector3d unused;
    const std::optional<double> before = distance_to(body, start + dt * body.velocity_at(start), unused);
    if (!before) continue;
    const double outward = near->normal.dot(v - body.velocity_at(x));
    const double gained = std::min(near->normal.dot(pushed), (near->distance - *before) / dt);
    v -= std::max(0.0, std::min(outward, gained)) * near->normal;
  }
  return v;
}

// 2.
void move_cloth(ReferenceState& state, const std::vector<PlacedBody>& bodies, const StepInfo& info) {
  const Model& m = state.model;
  const double dt = info.dt;
  for (Index n = 0; n < state.s.node_count(); ++n) {
    if (m.mesh.pinned[n]) {
      state.s.node_position[n] = arr(pin_position(state, n, info.time + dt));
      continue;
    }
    Vector3d v = vec(state.s.node_velocity[n]);
    Vector3d x = vec(state.s.node_position[n]) + dt * v;
    const ClothMaterial& cloth = m.material_of_node(n);
    const Clearance clearance = clearance_of(state, bodies, n, dt);
    if (!cloth.self_collision) {
      for (const BodyContact& contact : project_out(bodies, clearance, x)) v = contact.stopped(v);
    }
    if (clearance.least < 0.999 * clearance.thickness) v = at_rest_outwards(state, bodies, clearance, n, x, dt, v);
    state.s.node_position[n] = arr(x);
    state.s.node_velocity[n] = arr(v);
  }
}

/// The cloth's motion in this step, as the collisions see it.
struct MovingCloth {
  std::vector<MovingTriangle> triangles;
  Vectors samples;   // positions at the start, m
  double reach = 0;  // m: how far from a sample's start position its triangle can be met
};

/// The largest singular value of any triangle's deformation since its rest shape, at least 1.
double largest_stretch(const Model& m, const std::vector<Vec3>& nodes) {
  double largest = 1;
  for (std::size_t t = 0; t < m.mesh.triangle.size(); ++t) {
    const auto [a, b, c] = m.mesh.triangle[t];
    Eigen::Matrix<double, 3, 2> edges;
    edges << vec(nodes[b]) - vec(nodes[a]), vec(nodes[c]) - vec(nodes[a]);
    const Eigen::Matrix<double, 3, 2> deformation = edges * rest_frame(m.mesh, static_cast<Index>(t)).inverse();
    largest = std::max(largest, std::sqrt(eigenvalues(deformation.transpose() * deformation)[1]));
  }
  return largest;
}

MovingCloth moving_cloth(const ReferenceState& state, const std::vector<Vec3>& start, const Vectors& samples) {
  const Model& m = state.model;
  MovingCloth cloth{{}, samples, 0};
  for (const auto& nodes : m.mesh.triangle) {
    MovingTriangle t;
    for (int k = 0; k < 3; ++k) {
      t.start[k] = vec(start[nodes[k]]);
      t.end[k] = vec(state.s.node_position[nodes[k]]);
    }
    cloth.triangles.push_back(t);
  }
  double moved = 0;
  for (Index n = 0; n < state.s.node_count(); ++n) {
    moved = std::max(moved, (vec(state.s.node_position[n]) - vec(start[n])).norm());
  }
  cloth.reach = m.samples.cover_radius * largest_stretch(m, start) + moved + 1e-3 * m.spacing;
  return cloth;
}

struct TriangleHit {
  Index triangle;
  Hit hit;
};

/// The earliest hit of all triangles near the path from x0 to x1; of equals, that of the first triangle.
std::optional<TriangleHit> earliest_hit(const Model& m, const MovingCloth& cloth, const Vector3d& x0,
                                        const Vector3d& x1) {
  const Vector3d low = x0.cwiseMin(x1).array() - cloth.reach;
  const Vector3d high = x0.cwiseMax(x1).array() + cloth.reach;
  std::optional<TriangleHit> earliest;
  Index last = -1;
  for (std::size_t p = 0; p < cloth.samples.size(); ++p) {
    const Index t = m.samples.triangle[p];
    const Vector3d& x = cloth.samples[p];
    // A triangle's samples follow one another.
    if (t == last || (x.array() < low.array()).any() || (x.array() > high.array()).any()) continue;
    last = t;
    const std::optional<Hit> hit = first_hit(cloth.triangles[t], x0, x1, 1e-6 * m.spacing);
    if (hit && (!earliest || hit->tau < earliest->hit.tau)) earliest = TriangleHit{t, *hit};
  }
  return earliest;
}

/// +1 or −1: the side of the triangle (by its normal) on which x lies at the start.
double side_of(const MovingTriangle& t, const Vector3d& x) {
  return (x - t.start[0]).dot(unit_normal(t.start)) < 0 ? -1 : 1;
}

/// 3. Moves x1 to where the cloth lets the particle go, and tells the last collision.
Collision stop_at_cloth(const Model& m, const MovingCloth& cloth, const Vector3d& x0, Vector3d& x1) {
  constexpr int slides = 3, carries = 6, squeezes = 12;  // up to which pass
  const double gap = 1e-2 * m.spacing;
  const Vector3d free = x1;
  Collision collision;
  for (int pass = 0; pass < squeezes; ++pass) {
    const std::optional<TriangleHit> found = earliest_hit(m, cloth, x0, x1);
    if (!found) break;
    const MovingTriangle& t = cloth.triangles[found->triangle];
    const Vector3d normal = side_of(t, x0) * unit_normal(t.end);
    const double above = (x1 - t.end[0]).dot(normal);
    if (pass < slides && above < gap) {
      x1 += (gap - above) * normal;
    } else if (pass < carries) {
      x1 = interpolate(t.end, found->hit.weight) + gap * normal;
    } else {
      // The particle stays where it was, relative to this triangle, or nearer to it.
      const Vector3d foot = barycentric(t.start, x0).value_or(found->hit.weight);
      const double distance = std::abs((x0 - t.start[0]).dot(unit_normal(t.start)));
      x1 = interpolate(t.end, foot) + std::max(distance, gap) / std::pow(4, pass - carries) * normal;
      collision.crossed = pass + 1 == squeezes && earliest_hit(m, cloth, x0, x1).has_value();
    }
    collision.triangle = found->triangle;
    collision.weight = found->hit.weight;
    const Vector3d change = x1 - free;
    collision.normal = change.norm() > 0 ? change.normalized() : normal;
  }
  return collision;
}

/// 3. What the stopped particles and the cloth do to each other.
void exchange_impulses(ReferenceState& state, const std::vector<Collision>& collisions,
                       std::vector<Momentum>& impulse) {
  const Model& m = state.model;
  std::vector<int> hits(state.s.node_count(), 0);  // c_k
  for (const Collision& c : collisions) {
    if (c.triangle < 0) continue;
    for (const Index n : m.mesh.triangle[c.triangle]) ++hits[n];
  }
  for (Index i = 0; i < state.s.fluid_count(); ++i) {
    const Collision& c = collisions[i];
    if (c.triangle < 0) continue;
    const auto& nodes = m.mesh.triangle[c.triangle];
    const double mass = fluid_mass(state, i);
    if (!(mass > 0)) continue;
    Vector3d v_hit = Vector3d::Zero();
    double inverse_mass = 1 / mass;
    for (int k = 0; k < 3; ++k) {
      v_hit += c.weight[k] * vec(state.s.node_velocity[nodes[k]]);
      inverse_mass += c.weight[k] * c.weight[k] * hits[nodes[k]] * inverse_node_mass(state, nodes[k]);
    }
    const double approach = (vec(state.s.fluid_velocity[i]) - v_hit).dot(c.normal);
    if (!(approach < 0)) continue;
    const double lambda = -approach / inverse_mass;  // the impulse, kg m/s
    state.s.fluid_velocity[i] = arr(vec(state.s.fluid_velocity[i]) + lambda / mass * c.normal);
    for (int k = 0; k < 3; ++k) add_impulse(state, impulse, nodes[k], -c.weight[k] * lambda * c.normal);
  }
}

constexpr double grazing = 0.25;  // spacings: how deep a path may be in a body that it only grazes

/// 4. Where the path enters a body that it does not only graze, a particle goes on along its surface: where it ends.
std::optional<Vector3d> end_outside(const PlacedBody& body, const Vector3d& start, const Vector3d& end, double d) {
  Vector3d normal;
  const auto at = [&](double share) -> Vector3d { return start + share * (end - start); };
  const auto depth = [&](const Vector3d& x) { return -distance_to(body, x, normal).value_or(1e30); };
  if (depth(start) > grazing * d) return std::nullopt;
  const int parts = std::min(64, static_cast<int>(1 + (end - start).norm() / (grazing * d)));
  double outside = 0, inside = 0;
  for (int k = 1; k <= parts && !(depth(at(inside)) > grazing * d); ++k) {
    if (!(depth(at(inside)) > 0)) outside = inside;
    inside = double(k) / parts;
  }
  if (!(depth(at(inside)) > grazing * d)) return std::nullopt;
  for (int k = 0; k < 8; ++k) {
    const double middle = (outside + inside) / 2;
    (depth(at(middle)) > 0 ? inside : outside) = middle;
  }
  const Vector3d entry = at(outside);
  depth(entry);  // its normal
  const Vector3d left = end - entry, along = entry + (left - left.dot(normal) * normal);
  return depth(along) < grazing * d ? along : entry;
}

/// 4. Puts a particle that came from x0 and is behind a body's surface, or beyond it, back. Returns whether one was.
bool put_back(const Model& m, const std::vector<PlacedBody>& bodies, const Vector3d& x0, double dt, Vector3d& x,
              Vec3& velocity) {
  Vector3d v = vec(velocity);
  bool any = false;
  for (const PlacedBody& body : bodies) {
    const bool has_far_side = body.body->kind != BodyScene::Kind::plane && !body.body->inside && !body.surface;
    const Vector3d start = x0 + dt * body.velocity_at(x0), way = x - start;
    Vector3d normal;
    std::optional<double> distance = distance_to(body, x, normal);
    if (!distance) continue;
    const bool may_enter = has_far_side && *distance < way.norm() &&
                           (*distance >= 0 || *distance < -grazing * m.spacing || normal.dot(way) > 0);
    const std::optional<Vector3d> place = may_enter ? end_outside(body, start, x, m.spacing) : std::nullopt;
    if (place) {
      x = *place;
      distance = distance_to(body, x, normal);
    } else if (*distance >= 0) {
      continue;
    }
    any = true;
    v = BodyContact{normal, body.velocity_at(x)}.stopped(v);
    if (*distance < 0) project_out({body}, {}, x);
  }
  velocity = arr(v);
  return any;
}

/// 6. Does a triangle, where it is at the end, lie between the two?
bool lies_between(const MovingCloth& cloth, const Vector3d& from, const Vector3d& to) {
  for (const MovingTriangle& t : cloth.triangles) {
    if (first_hit({t.end, t.end}, from, to)) return true;
  }
  return false;
}

/// Of the particles that leave those that are faster than `limit`, m/s; none if neither that nor their number is
/// suspicious.
SomeParticles escaped(const HostState& s, const std::vector<bool>& gone, double limit, double fastest) {
  const auto count = std::ranges::count(gone, true);
  const bool fast = fastest > limit;
  if (!fast && (count < 100 || 4 * count <= s.next_id)) return {};
  std::vector<std::int64_t> ids;
  for (std::size_t i = 0; i < gone.size(); ++i) {
    if (gone[i] && (!fast || vec(s.fluid_velocity[i]).norm() > limit)) ids.push_back(s.fluid_id[i]);
  }
  std::ranges::sort(ids);
  SomeParticles some{static_cast<std::int64_t>(ids.size()), {}};
  std::copy_n(ids.begin(), std::min(ids.size(), some.lowest.size()), some.lowest.begin());
  return some;
}

bool outside(const Box& box, const Vector3d& x) {
  for (int a = 0; a < 3; ++a) {
    if (x[a] < box.min[a] || x[a] > box.max[a]) return true;
  }
  return false;
}

/// Is x in a drain that is open at a time?
bool drained(const std::vector<DrainScene>& drains, const Vector3d& x, double time) {
  return std::ranges::any_of(drains, [&](const DrainScene& drain) {
    if (time < drain.start || time >= drain.end) return false;
    if (drain.shape == DrainScene::Shape::box) return !outside(drain.box, x);
    if (drain.shape == DrainScene::Shape::sphere) return (x - vec(drain.center)).norm() <= drain.radius;
    return (x - vec(drain.point)).dot(vec(drain.normal).normalized()) <= 0;
  });
}

}  // namespace

void advection(ReferenceState& state, const StepInfo& info, StepReport& report) {
  const Model& m = state.model;
  HostState& s = state.s;
  const Index particles = s.fluid_count();
  std::vector<Momentum> impulse(s.node_count(), Momentum{0, 0, 0});

  const bool baked = m.has_baked_liquid();
  slow_fresh_particles(state, impulse);
  Vectors shift;
  for (Index i = 0; i < particles; ++i) shift.push_back(baked ? Vector3d::Zero() : shift_apart(state, i));
  const std::vector<Vec3> start = s.node_position;
  const Vectors start_samples = sample_positions(state);
  const std::vector<PlacedBody> bodies = placed_bodies(state, info);
  move_cloth(state, bodies, info);
  const MovingCloth cloth = moving_cloth(state, start, start_samples);

  Vectors x1(particles);
  std::vector<Collision> collisions(particles);
  report.collisions = 0;
  report.clamped = 0;
  for (Index i = 0; i < particles; ++i) {
    const Vector3d x0 = vec(s.fluid_position[i]);
    x1[i] = x0 + info.dt * vec(s.fluid_velocity[i]) + shift[i];
    if (!baked) collisions[i] = stop_at_cloth(m, cloth, x0, x1[i]);
    if (collisions[i].triangle >= 0) ++report.collisions;
  }
  exchange_impulses(state, collisions, impulse);
  push_nodes(state, impulse, info.dt);

  const Box border = domain_border(m);
  std::vector<bool> gone(particles, false), in_drain(particles, false);
  report.tunnelled = 0;
  report.escaped_speed = 0;
  for (Index i = 0; i < particles; ++i) {
    const Vector3d swept = x1[i];
    bool crossed = collisions[i].crossed;
    if (!baked && put_back(m, bodies, vec(s.fluid_position[i]), info.dt, x1[i], s.fluid_velocity[i])) {
      ++report.clamped;
      crossed = crossed || lies_between(cloth, swept, x1[i]);
    }
    if (crossed) {
      const std::int64_t id = s.fluid_id[i];
      report.lowest_tunnelled = report.tunnelled++ == 0 ? id : std::min(report.lowest_tunnelled, id);
    }
    s.fluid_position[i] = arr(x1[i]);
    s.fluid_age[i] += info.dt;
    gone[i] = outside(border, x1[i]);
    in_drain[i] = !gone[i] && drained(m.scene.fluid.drains, x1[i], info.time + info.dt);
    if (m.has_solute() && s.fluid_mass[i] == 0 && !gone[i] && !in_drain[i]) s.solute_deposited += s.fluid_solute[i];
    if (gone[i]) report.escaped_speed = std::max(report.escaped_speed, vec(s.fluid_velocity[i]).norm());
    if (!gone[i] && !in_drain[i]) continue;
    s.drained += s.fluid_mass[i];
    if (m.has_solute()) s.solute_drained += s.fluid_solute[i];
  }
  report.escaped = escaped(s, gone, info.fluid_speed_limit, report.escaped_speed);
  for (Index i = 0; i < particles; ++i)
    gone[i] = gone[i] || in_drain[i] || s.fluid_mass[i] == 0;  // stage evaporation took them whole
  remove_particles(s, gone);
}

}  // namespace drench::reference
