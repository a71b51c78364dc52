// Where the Newton steps of a few nodes do not settle: nonlinear Gauss-Seidel there (docs/theory/cloth.md, section 8).

#include <Eigen/LU>
#include <algorithm>
#include <numeric>

#include "cloth/newton.hpp"
#include "cloth/solver.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr double most_of_it = 0.8;  // of what is left: on so few nodes it is worth while
constexpr std::size_t most_nodes = 100;
constexpr int sweeps = 20, turns = 8;  // turns: of the direction of friction

}  // namespace

/// The nodes that hold most of what is left, and those around them; none if they are many.
std::vector<Index> NewtonCloth::unbalanced_nodes(const ClothSystem& s) const {
  std::vector<Index> order(at(nodes_));
  std::iota(order.begin(), order.end(), Index(0));
  std::vector<double> left(at(nodes_));
  double all = 0, found = 0;
  for (Index n = 0; n < nodes_; ++n) all += left[at(n)] = double(at_node(now_.left, n).norm());
  const std::size_t few = std::min(most_nodes, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(few), order.end(),
                    [&](Index a, Index b) { return left[at(a)] != left[at(b)] ? left[at(a)] > left[at(b)] : a < b; });
  std::vector<Index> nodes;
  for (std::size_t k = 0; k < few && found < most_of_it * all; ++k) {
    found += left[at(order[k])];
    nodes.push_back(order[k]);
  }
  if (found < most_of_it * all) return {};
  for (std::size_t k = 0, end = nodes.size(); k < end; ++k)
    for (Index l = s.link_start(nodes[k]); l < s.link_start(nodes[k] + 1); ++l)
      if (!s.pinned(s.link(l).other)) nodes.push_back(s.link(l).other);
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

/// What a node moves by if its neighbours rest: its own block, one plane, Coulomb's law.
Double3 NewtonCloth::local_step(const ClothSystem& s, Index n, const Double3& residual, const NodeNearby& near) const {
  const Eigen::Matrix3d own = tangent_.own(n).cast<double>(), inverse = own.inverse();
  const Eigen::Vector3d r(residual.x, residual.y, residual.z);
  Eigen::Vector3d step = inverse * r;
  if (near.count != 1) return {step[0], step[1], step[2]};
  const Eigen::Vector3d normal(near.normal[0].x, near.normal[0].y, near.normal[0].z);
  const double gap = near.gap[0] + normal.dot(step), friction = double(s.friction(n));
  if (!near.pinched && gap >= 0) return {step[0], step[1], step[2]};
  const Double3 moved = now_.shift[at(n)] - near.moved;
  Eigen::Vector3d slip(moved.x, moved.y, moved.z);
  slip -= normal * normal.dot(slip);
  // Does it stick? What the solid has to do for that:
  Eigen::Vector3d stuck = -slip - near.gap[0] * normal;
  const Eigen::Vector3d force = own * stuck - r;
  const double extra = near.pinched ? near.contact.press : 0, press = std::max(0.0, force.dot(normal)) + extra;
  Eigen::Vector3d along = force - normal * force.dot(normal);
  if (along.norm() <= friction * press) return {stuck[0], stuck[1], stuck[2]};
  for (int k = 0; k < turns; ++k) {
    const Eigen::Vector3d toward = -along.normalized();
    Eigen::Vector3d by = inverse * (normal - friction * toward);
    if (!(normal.dot(by) > 0)) by = inverse * normal;
    const Eigen::Vector3d free = inverse * (r - friction * extra * toward);
    stuck = free - (near.gap[0] + normal.dot(free)) / normal.dot(by) * by;
    const Eigen::Vector3d way = slip + stuck;
    along = -(way - normal * normal.dot(way));
    if (!(along.norm() > 0)) break;
  }
  return {stuck[0], stuck[1], stuck[2]};
}

bool NewtonCloth::relax_locally(const ClothSystem& s) {
  const std::vector<Index> nodes = unbalanced_nodes(s);
  if (nodes.empty()) return false;
  kept_ = now_;
  const auto shift = [this](const Index m) { return now_.shift[at(m)]; };
  NodeNearby near;
  for (int k = 0; k < sweeps; ++k)
    for (const Index n : nodes) {
      const NodeTerms t = s.terms(n);
      Double3& u = now_.shift[at(n)];
      const Double3 r = double(t.inertia) * (widen(t.target) - u) + s.elastic_force(n, shift);
      if (s.solids.count > 0) see_solids(s, n, u, r, near);
      u = project_out(s.solids, t.start, u + local_step(s, n, r, near), t.clearance);
    }
  now_.has_elastic = false;
  measure(s, now_);
  anderson_.clear();
  if (now_.over_goal < kept_.over_goal) return true;
  std::swap(now_, kept_);
  return false;
}

}  // namespace drench::kokkos_backend
