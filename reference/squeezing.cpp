// Stage squeezing of the oracle: every pair is looked at. The law stands in src/stages/squeezing.hpp.

#include "stages/squeezing.hpp"

#include <algorithm>
#include <cmath>

#include "cloth_problem.hpp"
#include "common.hpp"
#include "proximity.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

struct Layers {
  std::array<Index, 4> node;
  std::array<double, 4> b;
  Vector3d normal;
  double force = 0, applied = 0;  // λ of the last pass, and what acts in this one, N
};

/// What presses the layers of a state together.
class Squeezing {
 public:
  Squeezing(ReferenceState& state, const StepInfo& info)
      : state_(state), mesh_(state.model.mesh), problem_(state, info), pull_(problem_.internal_force(problem_.start)) {
    const Vector3d gravity = vec(state.model.scene.gravity);
    for (Index n = 0; n < mesh_.nodes(); ++n) {
      pull_[n] += node_mass(state, n) * gravity;
      if (const double held = problem_.held[n]; held > 0)
        pull_[n] += held * (pin_position(state, n, info.time + info.dt) - problem_.start[n]);
      wall_.push_back(first_wall(n));
    }
    smooth_ = pull_;
    for (int k = 0; k < squeezing_law::spreads; ++k) smooth_ = spread(smooth_);
    pushed_.assign(pull_.size(), Vector3d::Zero());
    load_.assign(pull_.size(), 0.0);
    find_layers();
    for (int pass = 0; pass < squeezing_law::passes && !layers_.empty(); ++pass)
      balance(pass + 1 < squeezing_law::passes ? squeezing_law::momentum(pass) : 0);
    for (const Layers& l : layers_)
      for (int k = 0; k < 4; ++k) load_[l.node[k]] += std::abs(l.b[k]) * l.force;
  }
  /// N, half of what presses on both sides.
  double on_node(Index n) const {
    Vector3d push = pull_[n] + pushed_[n];
    return (load_[n] + problem_.contact(n, problem_.start[n], push, 1).press) / 2;
  }

 private:
  ReferenceState& state_;
  const ClothMesh& mesh_;
  ClothProblem problem_;
  Vectors pull_, smooth_, pushed_, wall_;
  std::vector<double> load_;
  std::vector<Layers> layers_;

  Vector3d first_wall(Index n) const {
    for (const PlacedBody& body : problem_.bodies) {
      const std::optional<NearBody> near = problem_.clearance[n].near(body, problem_.start[n]);
      const double range = 0.01 * problem_.material(n).thickness;
      if (problem_.is_free(n) && near && near->distance < near->kept + range) return near->normal;
    }
    return Vector3d::Zero();
  }

  void find_layers() {
    const auto takes_part = [&](Index n) { return problem_.material(n).self_collision; };
    const auto apart = [&](Index n, Index m) {
      return mesh_.joint.empty() ? n != m : mesh_.joint[n] != mesh_.joint[m];
    };
    const auto add = [&](const std::array<Index, 4>& n, bool edges) {
      Four x;
      for (int k = 0; k < 4; ++k) x[k] = problem_.start[n[k]];
      const Near near = edges ? near_edges(x) : near_triangle(x);
      const double distance = near.apart.norm(),
                   thickness = (problem_.material(n[0]).thickness + problem_.material(n[3]).thickness) / 2;
      if (distance > 0 && distance <= squeezing_law::touching * thickness)
        layers_.push_back({n, near.b, near.apart / distance});
    };
    for (const auto& t : mesh_.triangle)
      for (Index n = 0; n < mesh_.nodes(); ++n)
        if (takes_part(n) && takes_part(t[0]) && apart(n, t[0]) && apart(n, t[1]) && apart(n, t[2]))
          add({n, t[0], t[1], t[2]}, false);
    for (std::size_t i = 0; i < mesh_.edge.size(); ++i)
      for (std::size_t j = i + 1; j < mesh_.edge.size(); ++j) {
        const auto &a = mesh_.edge[i], &b = mesh_.edge[j];
        if (takes_part(a[0]) && takes_part(b[0]) && apart(a[0], b[0]) && apart(a[0], b[1]) && apart(a[1], b[0]) &&
            apart(a[1], b[1]))
          add({a[0], a[1], b[0], b[1]}, true);
      }
  }

  /// Each free node gives half of its force to its neighbours along edges and stitches, in equal parts, but nothing to
  /// pins.
  Vectors spread(const Vectors& from) const {
    Vectors to = from;
    for (Index n = 0; n < mesh_.nodes(); ++n) {
      if (!problem_.is_free(n)) continue;
      const Index first = mesh_.node_edges.start[n], last = mesh_.node_edges.start[n + 1];
      for (Index k = first; k < last; ++k) {
        const Index e = mesh_.node_edges.item[k] - static_cast<Index>(mesh_.edge.size());
        const auto [i, j] = e < 0 ? mesh_.edge[mesh_.node_edges.item[k]] : mesh_.stitch[e];
        const Index other = i == n ? j : i;
        if (!problem_.is_free(other)) continue;
        const Vector3d part = from[n] / (2.0 * (last - first));
        to[n] -= part;
        to[other] += part;
      }
    }
    return to;
  }

  Vector3d acceleration(Index n) const {
    const Vector3d a = inverse_free_mass(state_, n) * (smooth_[n] + pushed_[n]);
    return a - std::min(0.0, a.dot(wall_[n])) * wall_[n];
  }

  void balance(double momentum) {
    std::vector<double> opening;
    std::vector<int> share(pull_.size(), 0);
    for (const Layers& l : layers_) {
      double sum = 0;
      for (int k = 0; k < 4; ++k) sum += l.b[k] * l.normal.dot(acceleration(l.node[k]));
      opening.push_back(sum);
      for (int k = 0; k < 4 && (sum < 0 || l.applied > 0); ++k) share[l.node[k]] += l.b[k] != 0;
    }
    for (std::size_t i = 0; i < layers_.size(); ++i) {
      Layers& l = layers_[i];
      double inverse = 0;
      for (int k = 0; k < 4; ++k) inverse += l.b[k] * l.b[k] * share[l.node[k]] * inverse_free_mass(state_, l.node[k]);
      const bool acts = (opening[i] < 0 || l.applied > 0) && inverse > 0;
      const double after = acts ? std::max(0.0, l.applied - opening[i] / inverse) : l.applied;
      const double next = std::max(0.0, after + momentum * (after - l.force));
      for (int k = 0; k < 4; ++k) pushed_[l.node[k]] += l.b[k] * (next - l.applied) * l.normal;
      l.force = after;
      l.applied = next;
    }
  }
};

}  // namespace

void squeezing(ReferenceState& state, const StepInfo& info, StepReport&) {
  const Model& m = state.model;
  const Squeezing squeezing(state, info);
  const std::vector<double>& at_rest = m.samples.node_capacity;
  if (state.node_pores.empty()) state.node_pores = at_rest;
  for (Index n = 0; n < state.s.node_count(); ++n) {
    const ClothMaterial& c = m.material_of_node(n);
    if (!c.squeezes() || !(at_rest[n] > 0)) continue;
    const double area = at_rest[n] / (m.rest_density * (1 - c.solid_fraction) * c.thickness);
    double& p = state.s.node_contact_pressure[n];
    p += (1 - std::exp(-info.dt / squeezing_law::response_time)) * (squeezing.on_node(n) / area - p);
    const double taken = p > 0 ? c.compressibility * p / (p + c.compression) : 0;  // of the thickness
    state.node_pores[n] = at_rest[n] * std::max(squeezing_law::least_pores, 1 - taken / (1 - c.solid_fraction));
  }
}

}  // namespace drench::reference
