#include "coinciding_layers.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace drench::reference {

using Eigen::Vector3d;

namespace {

/// The mean normal of both sides, to the front of side `own`.
Vector3d front(const std::array<Vector3d, 2>& normals, int own) {
  const double turn = normals[0].dot(normals[1]) < 0 ? -1 : 1;
  return (normals[own] + turn * normals[1 - own]).normalized();
}

}  // namespace

CoincidingLayers::CoincidingLayers(const ReferenceState& state) : state_(state) {
  piece_.resize(state.model.mesh.nodes());
  std::iota(piece_.begin(), piece_.end(), 0);
  for (bool changes = true; changes;) {
    changes = false;
    for (const auto& t : state.model.mesh.triangle) {
      const Index least = std::min({piece_[t[0]], piece_[t[1]], piece_[t[2]]});
      for (const Index n : t) {
        changes = changes || piece_[n] != least;
        piece_[n] = least;
      }
    }
  }
}

Vector3d CoincidingLayers::start(Index n) const { return vec(state_.s.node_position[n]); }

/// Of the triangles at the nodes, weighted by area; of one twice that has two of them. Zero: there is none.
Vector3d CoincidingLayers::normal_at(std::initializer_list<Index> nodes) const {
  Vector3d sum = Vector3d::Zero();
  for (const auto& t : state_.model.mesh.triangle) {
    const auto times = std::count_if(t.begin(), t.end(),
                                     [&](Index n) { return std::find(nodes.begin(), nodes.end(), n) != nodes.end(); });
    if (times > 0) sum += static_cast<double>(times) * (start(t[1]) - start(t[0])).cross(start(t[2]) - start(t[0]));
  }
  return sum.norm() > 0 ? Vector3d(sum.normalized()) : sum;
}

/// None if nothing tells, and of parallel edges: their ends are pairs of their own.
std::optional<CoincidingLayers::Normals> CoincidingLayers::normals(const Nodes& n, bool edges) const {
  Normals found;
  if (edges) {
    const Vector3d along = start(n[1]) - start(n[0]), beside = start(n[3]) - start(n[2]);
    if (along.cross(beside).norm() < 1e-3 * along.norm() * beside.norm()) return std::nullopt;
    found = {normal_at({n[0], n[1]}), normal_at({n[2], n[3]})};
  } else {
    found = {normal_at({n[0]}), (start(n[2]) - start(n[1])).cross(start(n[3]) - start(n[1])).normalized()};
  }
  if (found[0].isZero(0) || found[1].isZero(0)) return std::nullopt;
  return found;
}

void CoincidingLayers::leave(const Nodes& pair, const Vector3d& way) {
  const Index first = piece_[pair[0]], second = piece_[pair[3]];
  if (first == second) return;
  const auto of_side = normals(pair, false);
  if (!of_side) return;
  const int later = later_side(pair);
  to_front_[std::max(first, second)] += front(*of_side, later).dot(later == 0 ? way : Vector3d(-way));
}

std::optional<Vector3d> CoincidingLayers::parting_direction(const Nodes& pair, bool edges) const {
  const auto of_side = normals(pair, edges);
  if (!of_side) return std::nullopt;
  const Index first = piece_[pair[0]], second = piece_[pair[3]];
  if (first == second) {  // folded: each goes to its front
    if ((*of_side)[0].dot((*of_side)[1]) >= 0) return std::nullopt;
    return front(*of_side, 0);
  }
  const int later = later_side(pair);
  const auto found = to_front_.find(std::max(first, second));
  const bool to_back = found != to_front_.end() && found->second < 0;
  return front(*of_side, later) * ((later == 0) != to_back ? 1 : -1);
}

}  // namespace drench::reference
