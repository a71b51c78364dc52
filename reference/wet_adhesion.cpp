// Stage wet_adhesion of the oracle: every node looks at every triangle; the law stands in src/stages/wet_adhesion.hpp.

#include "stages/wet_adhesion.hpp"

#include <algorithm>
#include <optional>

#include "body_reaction.hpp"
#include "common.hpp"
#include "proximity.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

/// A node and a triangle in reach of each other.
struct Pull {
  Index triangle;
  Near near;
};

class WetAdhesion {
 public:
  WetAdhesion(ReferenceState& state, const StepInfo& info)
      : state_(state), mesh_(state.model.mesh), info_(info), dt_(info.dt) {
    force_.assign(static_cast<std::size_t>(mesh_.nodes()), Vector3d::Zero());
    area_.assign(force_.size(), 0);
    for (const auto& t : mesh_.triangle) {
      const auto rest = [&](int c) { return vec(mesh_.rest_position[t[c]]); };
      for (const Index n : t) area_[n] += (rest(1) - rest(0)).cross(rest(2) - rest(0)).norm() / 6;
    }
    for (const double length : mesh_.edge_length) mean_edge_ += length / static_cast<double>(mesh_.edge.size());
    neighbors_.resize(force_.size());
    for (const auto* pairs : {&mesh_.edge, &mesh_.stitch})
      for (const auto& [a, b] : *pairs) {
        neighbors_[a].push_back(b);
        neighbors_[b].push_back(a);
      }
  }

  void run() {
    const std::vector<PlacedBody> bodies = placed_bodies(state_, info_);
    std::vector<Six> impulse(state_.model.bodies.size(), Six::Zero());
    for (Index p = 0; p < state_.model.samples.count(); ++p)
      for (const PlacedBody& body : bodies) stick_to(bodies, body, p, impulse[body.index]);
    for (Index b = 0; b < state_.s.body_count(); ++b) push_body(state_, b, impulse[b]);
    refresh_body_samples(state_);
    for (Index n = 0; n < mesh_.nodes(); ++n) {
      if (!material(n).self_collision) continue;
      const std::optional<Pull> first = nearest(n, std::nullopt);
      if (!first) continue;
      stick(n, *first);
      const std::optional<Pull> second = nearest(n, first);
      if (second) stick(n, *second);
    }
    for (Index n = 0; n < mesh_.nodes(); ++n) {
      HostState& s = state_.s;
      s.node_velocity[n] = arr(vec(s.node_velocity[n]) + dt_ * inverse_node_mass(state_, n) * force_[n]);
      if (mesh_.is_fixed(n)) s.node_pin_force[n] = arr(vec(s.node_pin_force[n]) - force_[n]);
    }
  }

 private:
  ReferenceState& state_;
  const ClothMesh& mesh_;
  StepInfo info_;
  double dt_, mean_edge_ = 0;
  Vectors force_;
  std::vector<double> area_;
  std::vector<std::vector<Index>> neighbors_;

  const ClothMaterial& material(Index n) const { return state_.model.material_of_node(n); }
  double range(double thickness) const { return std::max(2 * thickness, mean_edge_); }
  /// p of the work w s at a distance, Pa.
  double traction(double work, double distance, double thickness) const {
    const double a = range(thickness), gap = std::max(0.0, distance - thickness);
    return gap < a ? 2 * work / a * (1 - gap / a) : 0;
  }
  /// w s of a node.
  double stickiness(Index n) const { return material(n).wet_adhesion * node_saturation(state_, n); }

  // 1.
  /// `impulse`: what the body gets.
  void stick_to(const std::vector<PlacedBody>& bodies, const PlacedBody& body, Index p, Six& impulse) {
    const SampleSet& samples = state_.model.samples;
    const Vector3d x = sample_position(state_, p);
    const Vector3d ahead = body.body->moves() ? Vector3d(x + dt_ * body.velocity_at(x)) : x;
    Vector3d normal;
    const std::optional<double> distance = distance_to(body, ahead, normal);
    if (!distance) return;
    // Of parts of one mesh that do not face each other the nearest one acts.
    for (const PlacedBody& other : bodies) {
      if (other.index != body.index || &other == &body) continue;
      Vector3d other_normal;
      const std::optional<double> apart = distance_to(other, ahead, other_normal);
      const bool nearer = apart && (*apart < *distance || (*apart == *distance && &other < &body));
      if (nearer && other_normal.dot(normal) > 0) return;
    }
    const auto node = [&](int k) { return sample_node(state_, p, k); };
    double work = 0;
    for (int k = 0; k < 3; ++k) work += samples.weight[p][k] * stickiness(node(k));
    const Vector3d force =
        -traction(work, *distance, state_.model.material_of_sample(p).thickness) * samples.area[p] * normal;
    for (int k = 0; k < 3; ++k) force_[node(k)] += samples.weight[p][k] * force;
    impulse.head<3>() -= dt_ * force;
    impulse.tail<3>() -= dt_ * (ahead - body.pose.position).cross(force);
  }

  double reach(Index n, Index t) const {
    const double thickness = (material(n).thickness + material(mesh_.triangle[t][0]).thickness) / 2;
    return thickness + range(thickness);
  }

  /// Sewn nodes count as one.
  bool next_to(Index n, Index t) const {
    const auto same = [&](Index a, Index b) { return mesh_.joint.empty() ? a == b : mesh_.joint[a] == mesh_.joint[b]; };
    return std::any_of(mesh_.triangle[t].begin(), mesh_.triangle[t].end(), [&](Index corner) {
      return same(corner, n) ||
             std::any_of(neighbors_[n].begin(), neighbors_[n].end(), [&](Index other) { return same(corner, other); });
    });
  }

  // 2.
  std::optional<Pull> nearest(Index n, const std::optional<Pull>& first) const {
    std::optional<Pull> best;
    for (Index t = 0; t < mesh_.triangles(); ++t) {
      const auto& corner = mesh_.triangle[t];
      if (!material(corner[0]).self_collision || next_to(n, t)) continue;
      const auto x = [&](Index k) { return vec(state_.s.node_position[k]); };
      const Near near = near_triangle({x(n), x(corner[0]), x(corner[1]), x(corner[2])});
      const double distance = near.apart.norm();
      if (!(distance > 0) || distance >= reach(n, t)) continue;
      if (first && near.apart.dot(first->near.apart) >= 0) continue;
      if (!best || distance < best->near.apart.norm()) best = Pull{t, near};
    }
    return best;
  }

  void stick(Index n, const Pull& pull) {
    const auto& corner = mesh_.triangle[pull.triangle];
    double strength = stickiness(n);
    for (int c = 0; c < 3; ++c) strength -= pull.near.b[c + 1] * stickiness(corner[c]);
    const double thickness = (material(n).thickness + material(corner[0]).thickness) / 2;
    const Vector3d f =
        -traction(strength / 2, pull.near.apart.norm(), thickness) * area_[n] / 2 * pull.near.apart.normalized();
    force_[n] += f;
    for (int c = 0; c < 3; ++c) force_[corner[c]] += pull.near.b[c + 1] * f;
  }
};

}  // namespace

void wet_adhesion(ReferenceState& state, const StepInfo& info, StepReport&) { WetAdhesion(state, info).run(); }

}  // namespace drench::reference
