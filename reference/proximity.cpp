#include "proximity.hpp"

#include <algorithm>
#include <vector>

#include "cloth_problem.hpp"
#include "collision.hpp"

namespace drench::reference {

using Eigen::Vector3d;

namespace {

/// Where along a b lies the point nearest to p: 0 to 1.
double along(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const double length = (b - a).squaredNorm();
  return length > 0 ? std::clamp((p - a).dot(b - a) / length, 0.0, 1.0) : 0;
}

}  // namespace

Near near_triangle(const Four& x) {
  // The foot point if it lies inside, else the nearest point of the three edges.
  const std::optional<Vector3d> w = barycentric({x[1], x[2], x[3]}, x[0]);
  if (w && w->minCoeff() >= 0) {
    return {{1, -(*w)[0], -(*w)[1], -(*w)[2]}, x[0] - (*w)[0] * x[1] - (*w)[1] * x[2] - (*w)[2] * x[3]};
  }
  Near best{{}, Vector3d::Constant(1e300)};
  for (int k = 0; k < 3; ++k) {
    const int a = 1 + k, b = 1 + (k + 1) % 3;
    const double s = along(x[0], x[a], x[b]);
    const Vector3d apart = x[0] - x[a] - s * (x[b] - x[a]);
    if (!(apart.squaredNorm() < best.apart.squaredNorm())) continue;
    best = {{1, 0, 0, 0}, apart};
    best.b[a] = s - 1;
    best.b[b] = -s;
  }
  return best;
}

Near near_edges(const Four& x) {
  const Vector3d p = x[1] - x[0], q = x[3] - x[2], r = x[2] - x[0];
  // Inside both edges where the lines' nearest points are, else one of them is an end.
  const double pp = p.squaredNorm(), qq = q.squaredNorm(), pq = p.dot(q), det = pp * qq - pq * pq;
  std::vector<std::array<double, 2>> trials;
  if (det > 1e-14 * pp * qq) {
    const double s = (qq * p.dot(r) - pq * q.dot(r)) / det, t = (pq * p.dot(r) - pp * q.dot(r)) / det;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) trials.push_back({s, t});
  }
  if (trials.empty()) {
    trials = {{0, along(x[0], x[2], x[3])},
              {1, along(x[1], x[2], x[3])},
              {along(x[2], x[0], x[1]), 0},
              {along(x[3], x[0], x[1]), 1}};
  }
  Near best{{}, Vector3d::Constant(1e300)};
  for (const auto& [s, t] : trials) {
    const Vector3d apart = -r + s * p - t * q;
    if (apart.squaredNorm() < best.apart.squaredNorm()) best = {{1 - s, s, t - 1, -t}, apart};
  }
  return best;
}

Near nearest(const Four& x, bool edges) { return edges ? near_edges(x) : near_triangle(x); }

double Pair::target_gap(double least) const { return std::min(least, distance + 0.1 * thickness); }

std::vector<Pair> all_pairs(const ReferenceState& state) {
  const ClothMesh& mesh = state.model.mesh;
  const auto material = [&](Index n) -> const ClothMaterial& { return state.model.cloths[mesh.node_cloth[n]]; };
  const auto friction = [&](Index n) {
    return material(n).friction + node_saturation(state, n) * (material(n).friction_wet - material(n).friction);
  };
  std::vector<Pair> pairs;
  const auto add = [&](const std::array<Index, 4>& n, bool edges) {
    Four x;
    for (int k = 0; k < 4; ++k) x[k] = vec(state.s.node_position[n[k]]);
    pairs.push_back({n, edges, nearest(x, edges).apart.norm(),
                     (material(n[0]).thickness + material(n[3]).thickness) / 2, (friction(n[0]) + friction(n[3])) / 2});
  };
  for (const auto& t : mesh.triangle) {
    for (Index n = 0; n < mesh.nodes() && material(t[0]).self_collision; ++n) {
      if (material(n).self_collision && n != t[0] && n != t[1] && n != t[2]) add({n, t[0], t[1], t[2]}, false);
    }
  }
  for (std::size_t i = 0; i < mesh.edge.size(); ++i) {
    for (std::size_t j = i + 1; j < mesh.edge.size(); ++j) {
      const auto &a = mesh.edge[i], &b = mesh.edge[j];
      if (!material(a[0]).self_collision || !material(b[0]).self_collision) continue;
      if (a[0] != b[0] && a[0] != b[1] && a[1] != b[0] && a[1] != b[1]) add({a[0], a[1], b[0], b[1]}, true);
    }
  }
  return pairs;
}

std::optional<Near> reaches(const Pair& pair, const Four& x, Four u, double gap) {
  constexpr int most_advances = 200;
  const Vector3d mean = (u[0] + u[1] + u[2] + u[3]) / 4;
  const int first = pair.edges ? 2 : 1;
  double l[2] = {0, 0};
  for (int k = 0; k < 4; ++k) {
    u[k] -= mean;
    l[k < first ? 0 : 1] = std::max(l[k < first ? 0 : 1], u[k].norm());
  }
  // Most pairs are far apart.
  if (pair.distance - gap >= l[0] + l[1] && pair.distance > 1.01 * gap) return std::nullopt;
  double t = 0;
  for (int advance = 0;; ++advance) {
    Four at;
    for (int k = 0; k < 4; ++k) at[k] = x[k] + t * u[k];
    const Near near = nearest(at, pair.edges);
    const double left = near.apart.norm() - gap;
    if (left <= 0.01 * gap || advance == most_advances) return near;
    if (left >= (1 - t) * (l[0] + l[1])) return std::nullopt;
    t += left / (l[0] + l[1]);
  }
}

}  // namespace drench::reference
