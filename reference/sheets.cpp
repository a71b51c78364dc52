#include "sheets.hpp"

#include <algorithm>
#include <cmath>

namespace drench::reference {

using Eigen::Vector3d;

namespace {

/// Whether c, in the plane of sample p, is beyond the boundary of its sheet.
bool beyond_boundary(const ReferenceState& state, Index p, const Vector3d& c) {
  if (state.model.samples.boundary_edges.empty()) return false;
  struct Near {
    double distance, side;
    Index corner;  // the node that is nearest to c, −1: within the edge
    Vector3d outward;
  };
  std::vector<Near> near;
  for (const Index e : state.model.samples.boundary_edges[p]) {
    if (e < 0) continue;
    const auto& nodes = state.model.mesh.boundary_edge[e];
    const Vector3d a = vec(state.s.node_position[nodes[0]]), b = vec(state.s.node_position[nodes[1]]),
                   o = vec(state.s.node_position[nodes[2]]), along = b - a;
    const double where = (c - a).dot(along) / along.squaredNorm();
    const Vector3d outward = ((a - o) - (a - o).dot(along) / along.squaredNorm() * along).normalized();
    const Index corner = where <= 0 ? nodes[0] : where >= 1 ? nodes[1] : -1;
    near.push_back({(c - a - std::clamp(where, 0.0, 1.0) * along).norm(), (c - a).dot(outward), corner, outward});
  }
  if (near.empty()) return false;
  if (near.size() == 2 && near[0].corner >= 0 && near[0].corner == near[1].corner)
    return (c - vec(state.s.node_position[near[0].corner])).dot(near[0].outward + near[1].outward) > 0;
  return near[near.size() == 2 && near[1].distance < near[0].distance ? 1 : 0].side > 0;
}

}  // namespace

Index nearest_sample(const ReferenceState& state, Index i) {
  const Vector3d x = vec(state.s.fluid_position[i]);
  Index best = -1;
  double least = 0;
  for (const Index p : state.fluid_sample[i]) {
    const double distance = (x - sample_position(state, p)).norm();
    if (best >= 0 && distance >= least) continue;
    best = p;
    least = distance;
  }
  return best;
}

Vector3d sample_normal(const ReferenceState& state, Index p) {
  const auto corner = [&](int k) { return vec(state.s.node_position[sample_node(state, p, k)]); };
  return (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
}

bool on_sheet(const ReferenceState& state, Index p, const Vector3d& c) {
  return (c - sample_position(state, p)).norm() < 1.25 * state.model.spacing && !beyond_boundary(state, p, c);
}

bool touches_sheet(const ReferenceState& state, Index i) {
  const Index p = nearest_sample(state, i);
  if (p < 0) return false;
  const Vector3d x = vec(state.s.fluid_position[i]), n = sample_normal(state, p);
  const double height = (x - sample_position(state, p)).dot(n);
  return std::fabs(height) < 0.1 * state.model.spacing && on_sheet(state, p, x - height * n);
}

}  // namespace drench::reference
