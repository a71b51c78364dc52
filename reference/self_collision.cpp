// Stage self_collision of the oracle: every pair is looked at; the law stands in src/stages/self_collision.hpp.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "cloth_problem.hpp"
#include "coinciding_layers.hpp"
#include "collision.hpp"
#include "common.hpp"
#include "proximity.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr int rounds = 3, passes = 8, most_advances = 200;
constexpr double longest_lever = 2;
constexpr double coincidence = 1e-3;  // of τ: no distance, no direction

/// A node and a triangle, or two edges.
struct Pair {
  std::array<Index, 4> node;
  bool edges;
  double distance;   // δ⁰, m
  double thickness;  // τ, m
  double friction;   // μ
};

struct Contact {
  const Pair* pair;
  std::array<double, 4> b;
  Vector3d normal;
  double target_gap;        // θ, m
  double pair_impulse = 0;  // λ, kg m/s
};

Near nearest(const Four& x, bool edges) { return edges ? near_edges(x) : near_triangle(x); }

/// The stage's work on one state.
class SelfCollision {
 public:
  SelfCollision(ReferenceState& state, const StepInfo& info)
      : state_(state),
        mesh_(state.model.mesh),
        dt_(info.dt),
        share_(info.correction_share),
        bodies_(placed_bodies(state, info)),
        layers_(state) {
    for (Index n = 0; n < mesh_.nodes(); ++n) {
      velocity_.push_back(vec(state.s.node_velocity[n]));
      if (mesh_.pinned[n]) velocity_[n] = (pin_position(state, n, info.time + dt_) - start(n)) / dt_;
      if (member(n)) keep_out(n);
    }
    list_pairs();
    watch_layers();
  }

  void run(StepReport& report) {
    report.cloth_contacts = report.cloth_zone_nodes = 0;
    for (int round = 0; round < rounds; ++round) {
      std::vector<Contact> contacts = find_contacts();
      if (contacts.empty()) break;
      if (round == 0) report.cloth_contacts = static_cast<std::int64_t>(contacts.size());
      for (int pass = 0; pass < passes; ++pass) push_apart(contacts);
      apply_friction(contacts);
    }
    if (report.cloth_contacts > 0) report.cloth_zone_nodes = join_zones();
    for (Index n = 0; n < mesh_.nodes(); ++n) {
      if (member(n) && !mesh_.pinned[n]) state_.s.node_velocity[n] = arr(velocity_[n]);
    }
  }

 private:
  ReferenceState& state_;
  const ClothMesh& mesh_;
  double dt_, share_;  // share_: s of docs/theory/liquid.md, Eq. 24
  std::vector<PlacedBody> bodies_;
  Vectors velocity_;
  std::vector<Pair> pairs_;
  CoincidingLayers layers_;

  const ClothMaterial& material(Index n) const { return state_.model.material_of_node(n); }
  bool member(Index n) const { return material(n).self_collision; }
  double friction(Index n) const {
    return material(n).friction + node_saturation(state_, n) * (material(n).friction_wet - material(n).friction);
  }
  /// Neither the same node nor sewn together.
  bool apart(Index n, Index m) const { return mesh_.joint.empty() ? n != m : mesh_.joint[n] != mesh_.joint[m]; }
  Vector3d start(Index n) const { return vec(state_.s.node_position[n]); }
  Vector3d end(Index n) const { return start(n) + dt_ * velocity_[n]; }

  // 1.
  void keep_out(Index n) {
    if (mesh_.pinned[n]) return;
    Vector3d x = end(n);
    if (!project_out(bodies_, clearance_of(state_, bodies_, n, dt_), x).empty()) velocity_[n] = (x - start(n)) / dt_;
  }

  void list_pairs() {
    const auto add = [&](const std::array<Index, 4>& n, bool edges) {
      Four x;
      for (int k = 0; k < 4; ++k) x[k] = start(n[k]);
      pairs_.push_back({n, edges, nearest(x, edges).apart.norm(),
                        (material(n[0]).thickness + material(n[3]).thickness) / 2,
                        (friction(n[0]) + friction(n[3])) / 2});
    };
    for (const auto& t : mesh_.triangle) {
      for (Index n = 0; n < mesh_.nodes(); ++n) {
        if (member(n) && member(t[0]) && apart(n, t[0]) && apart(n, t[1]) && apart(n, t[2]))
          add({n, t[0], t[1], t[2]}, false);
      }
    }
    for (std::size_t i = 0; i < mesh_.edge.size(); ++i) {
      for (std::size_t j = i + 1; j < mesh_.edge.size(); ++j) {
        const auto &a = mesh_.edge[i], &b = mesh_.edge[j];
        if (!member(a[0]) || !member(b[0])) continue;
        if (apart(a[0], b[0]) && apart(a[0], b[1]) && apart(a[1], b[0]) && apart(a[1], b[1]))
          add({a[0], a[1], b[0], b[1]}, true);
      }
    }
  }

  static bool coincides(const Pair& pair) { return pair.distance <= coincidence * pair.thickness; }

  /// Tells the layers that coincide how they move, so that they know to which side they part.
  void watch_layers() {
    for (const Pair& pair : pairs_) {
      if (pair.edges || !coincides(pair)) continue;
      Four x;
      for (int k = 0; k < 4; ++k) x[k] = start(pair.node[k]);
      const Near near = nearest(x, false);
      Vector3d parts = Vector3d::Zero();  // the first from the second
      for (int k = 0; k < 4; ++k) parts += near.b[k] * (end(pair.node[k]) - x[k]);
      layers_.leave(pair.node, parts);
    }
  }

  // 2.
  std::optional<Near> reaches(const Pair& pair, double target_gap) const {
    Four x, u;
    Vector3d mean = Vector3d::Zero();
    for (int k = 0; k < 4; ++k) {
      x[k] = start(pair.node[k]);
      u[k] = end(pair.node[k]) - x[k];
      mean += u[k] / 4;
    }
    const int first = pair.edges ? 2 : 1;
    double l[2] = {0, 0};
    for (int k = 0; k < 4; ++k) {
      u[k] -= mean;
      l[k < first ? 0 : 1] = std::max(l[k < first ? 0 : 1], u[k].norm());
    }
    // Most pairs are far apart.
    if (pair.distance - target_gap >= l[0] + l[1] && pair.distance > 1.01 * target_gap) return std::nullopt;
    double t = 0;
    for (int advance = 0;; ++advance) {
      Four at;
      for (int k = 0; k < 4; ++k) at[k] = x[k] + t * u[k];
      const Near near = nearest(at, pair.edges);
      const double left = near.apart.norm() - target_gap;
      if (left <= 0.01 * target_gap || advance == most_advances) return near;
      if (left >= (1 - t) * (l[0] + l[1])) return std::nullopt;
      t += left / (l[0] + l[1]);
    }
  }

  // 3.
  std::vector<Contact> find_contacts() const {
    std::vector<Contact> contacts;
    for (const Pair& pair : pairs_) {
      std::optional<Near> near;
      if (pair.distance <= pair.thickness) {
        Four x;
        for (int k = 0; k < 4; ++k) x[k] = start(pair.node[k]);
        near = nearest(x, pair.edges);
      } else {
        near = reaches(pair, pair.thickness);
      }
      if (!near || throws(pair, near->b)) continue;
      std::optional<Vector3d> normal;
      if (coincides(pair))
        normal = layers_.parting_direction(pair.node, pair.edges);
      else if (near->apart.norm() > 0)
        normal = near->apart.normalized();
      if (!normal) continue;
      const double target_gap = pair.distance < pair.thickness
                                    ? std::min(pair.thickness, pair.distance + 0.1 * share_ * pair.thickness)
                                    : pair.thickness;
      contacts.push_back({&pair, near->b, *normal, target_gap});
    }
    return contacts;
  }

  /// Would an impulse move a node farther than `longest_lever` times the gap that it opens?
  bool throws(const Pair& pair, const std::array<double, 4>& b) const {
    double gap = 0, most = 0;
    for (int k = 0; k < 4; ++k) {
      const double inverse = inverse_free_mass(state_, pair.node[k]);
      gap += b[k] * b[k] * inverse;
      most = std::max(most, std::abs(b[k]) * inverse);
    }
    return most > longest_lever * gap;
  }

  double gap(const Contact& c) const {
    const Vector3d origin = start(c.pair->node[0]);
    double sum = 0;
    for (int k = 0; k < 4; ++k) sum += c.b[k] * c.normal.dot(end(c.pair->node[k]) - origin);
    return sum;
  }

  /// c_k of the given contacts.
  std::vector<int> shares(const std::vector<const Contact*>& active) const {
    std::vector<int> share(velocity_.size(), 0);
    for (const Contact* c : active) {
      for (int k = 0; k < 4; ++k) share[c->pair->node[k]] += c->b[k] != 0;
    }
    return share;
  }

  double inverse(const Contact& c, const std::vector<int>& share) const {
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
      const Index n = c.pair->node[k];
      sum += c.b[k] * c.b[k] * share[n] * inverse_free_mass(state_, n);
    }
    return sum;
  }

  /// Impulses in fixed point.
  struct Impulses {
    double unit;  // kg m/s
    std::vector<std::array<std::int64_t, 3>> sum;
    void add(const Contact& c, const Vector3d& j) {
      for (int k = 0; k < 4; ++k)
        for (int a = 0; a < 3; ++a)
          sum[c.pair->node[k]][a] += static_cast<std::int64_t>(std::floor(c.b[k] * j[a] / unit + 0.5));
    }
  };
  Impulses no_impulses() const {
    const std::vector<double>&solid = mesh_.solid_mass, &capacity = state_.model.samples.node_capacity;
    double heaviest = 0;  // kg, of a node with the liquid that fits
    for (std::size_t n = 0; n < solid.size(); ++n)
      heaviest = std::max(heaviest, solid[n] + (n < capacity.size() ? capacity[n] : 0));
    return {heaviest * 0x1p-47, std::vector<std::array<std::int64_t, 3>>(velocity_.size(), {0, 0, 0})};
  }
  void apply(const Impulses& impulses, const std::vector<int>& share) {
    for (Index n = 0; n < mesh_.nodes(); ++n) {
      if (share[n] == 0) continue;
      const auto& p = impulses.sum[n];
      velocity_[n] += inverse_free_mass(state_, n) * impulses.unit * Vector3d(double(p[0]), double(p[1]), double(p[2]));
      keep_out(n);
    }
  }

  void push_apart(std::vector<Contact>& contacts) {
    std::vector<const Contact*> active;
    std::vector<double> missing(contacts.size());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      missing[i] = contacts[i].target_gap - gap(contacts[i]);
      if (missing[i] > 0 || contacts[i].pair_impulse > 0) active.push_back(&contacts[i]);
    }
    const std::vector<int> share = shares(active);
    Impulses impulses = no_impulses();
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      Contact& c = contacts[i];
      if (!(missing[i] > 0 || c.pair_impulse > 0)) continue;
      const double inverse_mass = inverse(c, share);
      if (!(inverse_mass > 0)) continue;
      const double pair_impulse = std::max(0.0, c.pair_impulse + missing[i] / (dt_ * inverse_mass));
      impulses.add(c, (pair_impulse - c.pair_impulse) * c.normal);
      c.pair_impulse = pair_impulse;
    }
    apply(impulses, share);
  }

  void apply_friction(const std::vector<Contact>& contacts) {
    std::vector<const Contact*> pressed;
    for (const Contact& c : contacts) {
      if (c.pair_impulse > 0) pressed.push_back(&c);
    }
    const std::vector<int> share = shares(pressed);
    Impulses impulses = no_impulses();
    for (const Contact* c : pressed) {
      Vector3d u = Vector3d::Zero();
      for (int k = 0; k < 4; ++k) u += c->b[k] * velocity_[c->pair->node[k]];
      u -= c->normal * c->normal.dot(u);
      const double inverse_mass = inverse(*c, share);
      if (!(u.norm() > 0) || !(inverse_mass > 0)) continue;
      const double pair_impulse = std::min(c->pair->friction * c->pair_impulse, u.norm() / inverse_mass);
      impulses.add(*c, -pair_impulse * u.normalized());
    }
    apply(impulses, share);
  }

  // 4.
  std::int64_t join_zones() {
    const Index count = mesh_.nodes();
    std::vector<Index> zone(count);
    std::iota(zone.begin(), zone.end(), 0);
    std::vector<bool> joined(count, false), stopped(count, false), at_rest(count, false);
    while (true) {
      bool any = false;
      const std::vector<Index> zone_before = zone;
      const std::vector<bool> joined_before = joined;
      for (const Pair& pair : pairs_) {
        bool one = true;
        for (const Index n : pair.node) {
          one = one && joined_before[n] && zone_before[n] == zone_before[pair.node[0]];
        }
        if (one && at_rest[pair.node[0]]) continue;
        if (coincides(pair) || !reaches(pair, std::min(0.25 * pair.thickness, 0.8 * pair.distance))) continue;
        any = true;
        if (one) stopped[pair.node[0]] = true;
        for (const Index n : pair.node) {
          joined[n] = true;
          const Index from = zone[n], to = zone[pair.node[0]];
          std::replace(zone.begin(), zone.end(), std::max(from, to), std::min(from, to));
        }
      }
      if (!any) break;
      for (Index z = 0; z < count; ++z) move_zone(z, zone, joined, stopped, at_rest);
    }
    return std::count(joined.begin(), joined.end(), true);
  }

  void move_zone(Index z, const std::vector<Index>& zone, const std::vector<bool>& joined,
                 const std::vector<bool>& stopped, std::vector<bool>& at_rest) {
    std::vector<Index> nodes;  // free ones
    std::optional<Index> pin;  // the first
    bool still = false;
    for (Index n = 0; n < mesh_.nodes(); ++n) {
      if (zone[n] != z || !joined[n]) continue;
      if (!mesh_.pinned[n]) nodes.push_back(n);
      if (mesh_.pinned[n] && !pin) pin = n;
      still = still || stopped[n];
    }
    for (Index n = 0; n < mesh_.nodes(); ++n) {
      if (zone[n] == z && joined[n] && still) at_rest[n] = true;
    }
    if (nodes.empty()) return;
    Vector3d v = Vector3d::Zero();
    if (pin && !still) {
      v = velocity_[*pin];
    } else if (!still) {
      double mass = 0;
      for (const Index n : nodes) {
        v += node_mass(state_, n) * velocity_[n];
        mass += node_mass(state_, n);
      }
      v /= mass;
      Vector3d up = Vector3d::Zero(), down = Vector3d::Zero();
      for (const Index n : nodes) {
        Vector3d x = start(n) + dt_ * v;
        const Vector3d before = x;
        project_out(bodies_, clearance_of(state_, bodies_, n, dt_), x);
        up = up.cwiseMax(x - before);
        down = down.cwiseMax(before - x);
      }
      v += (up - down) / dt_;
    }
    for (const Index n : nodes) velocity_[n] = v;
  }
};

}  // namespace

void self_collision(ReferenceState& state, const StepInfo& info, StepReport& report) {
  SelfCollision(state, info).run(report);
}

}  // namespace drench::reference
