#include "setup/weld.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "base/eigen_vec.hpp"
#include "scene/scene.hpp"
#include "setup/point_grid.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

constexpr double nearly = 1e-3;         // of the edges at the two points: they coincide
constexpr double narrow = 0.1;          // of these edges: a seam that is not quite closed
constexpr double on_each_other = 0.99;  // cosine between the directions in which two sheets leave a seam

/// Clusters of points, merged one pair after the other.
class Welder {
 public:
  Welder(const SurfaceMesh& mesh, double distance) : mesh_(mesh), distance_(distance) {
    const std::size_t points = mesh.points.size();
    of_.resize(points);
    std::iota(of_.begin(), of_.end(), 0);
    boundary_.assign(points, 0);
    shortest_.assign(points, std::numeric_limits<double>::infinity());
    inward_.assign(points, Vector3d::Zero());
    members_.resize(points);
    triangles_.resize(points);
    for (std::size_t p = 0; p < points; ++p) members_[p] = {static_cast<Index>(p)};
    for (const MeshEdge& e : mesh_edges(mesh.triangles)) {
      const double length = (x(e.a) - x(e.b)).norm();
      for (const Index p : {e.a, e.b}) {
        shortest_[at(p)] = std::min(shortest_[at(p)], length);
        if (e.triangles == 1) boundary_[at(p)] = 1;
      }
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& n = mesh.triangles[t];
      for (std::size_t c = 0; c < 3; ++c) {
        const Index p = n[c];
        triangles_[at(p)].push_back(static_cast<Index>(t));
        // All directions between the two sides, so that it does not matter how polygons are cut into triangles.
        const Vector3d u = (x(n[(c + 1) % 3]) - x(p)).normalized(), v = (x(n[(c + 2) % 3]) - x(p)).normalized();
        if (const double half = 1 + u.dot(v); half > 1e-12) inward_[at(p)] += u.cross(v).norm() / half * (u + v);
      }
    }
  }

  Weld run(const std::vector<Index>& copy_of) {
    const std::size_t in_file = of_.size() - copy_of.size();
    const auto original = [&](Index p) { return at(p) < in_file ? p : copy_of[at(p) - in_file]; };
    Weld weld;
    std::vector<std::array<Index, 2>> left;  // of points
    for (const Pair& pair : close_pairs(nearly)) {
      const Index a = of_[at(pair.a)], b = of_[at(pair.b)];
      if (a == b || original(pair.a) == original(pair.b)) continue;
      if (distance_ < 0 && lie_on_each_other(pair.a, pair.b)) {
        ++weld.layers;
      } else if (collapses(a, b)) {
        ++weld.refused;
      } else if (crowds_an_edge(a, b)) {
        left.push_back({pair.a, pair.b});
      } else {
        merge(std::min(a, b), std::max(a, b));
        ++weld.merged;
      }
    }
    if (distance_ < 0) find_open_pairs(weld);
    number_nodes(weld);
    for (const auto& [a, b] : left)
      if (const Index n = weld.node[at(a)], m = weld.node[at(b)]; n != m)
        weld.held.push_back({std::min(n, m), std::max(n, m)});
    std::sort(weld.held.begin(), weld.held.end());
    weld.held.erase(std::unique(weld.held.begin(), weld.held.end()), weld.held.end());
    return weld;
  }

 private:
  struct Pair {
    double apart;
    Index a, b;
  };
  const SurfaceMesh& mesh_;
  double distance_;
  std::vector<Index> of_;  // the cluster of each point, by its lowest
  std::vector<std::uint8_t> boundary_;
  std::vector<double> shortest_;
  std::vector<Vector3d> inward_;                         // of each point, into its own sheet
  std::vector<std::vector<Index>> members_, triangles_;  // of each cluster

  Vector3d x(Index p) const { return to_eigen(mesh_.points[at(p)]); }

  /// Of seams that are open in part or all along.
  void find_open_pairs(Weld& weld) const {
    std::vector<std::uint8_t> counted(of_.size(), 0);
    for (const Pair& pair : close_pairs(narrow)) {
      const Index a = of_[at(pair.a)], b = of_[at(pair.b)];
      if (a == b || counted[at(a)] || counted[at(b)] || pair.apart <= reach(pair.a, pair.b, nearly) ||
          lie_on_each_other(pair.a, pair.b) || collapses(a, b) || crowds_an_edge(a, b))
        continue;
      counted[at(a)] = counted[at(b)] = 1;
      ++weld.open;
      weld.widest = std::max(weld.widest, pair.apart);
    }
  }

  /// m; `share`: of the edges, where no distance is given.
  double reach(Index a, Index b, double share) const {
    return distance_ < 0 ? share * (shortest_[at(a)] + shortest_[at(b)]) / 2 : distance_;
  }

  /// The nearest first, so that a chain of near points does not run together.
  std::vector<Pair> close_pairs(double share) const {
    std::vector<Index> points;
    double farthest = 0;
    for (Index p = 0; p < static_cast<Index>(boundary_.size()); ++p) {
      if (!boundary_[at(p)] || !std::isfinite(shortest_[at(p)]) || !x(p).allFinite()) continue;
      points.push_back(p);
      farthest = std::max(farthest, reach(p, p, share));
    }
    std::vector<Pair> pairs;
    if (points.empty() || !(farthest > 0)) return pairs;
    PointGrid grid(farthest);
    for (const Index p : points) grid.add(mesh_.points[at(p)]);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Vec3& here = mesh_.points[at(points[k])];
      Vec3 low = here, high = here;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] -= farthest;
        high[axis] += farthest;
      }
      grid.for_box(low, high, [&](Index other) {
        if (other <= static_cast<Index>(k)) return;
        const Index a = points[k], b = points[at(other)];
        const double apart = (x(a) - x(b)).norm();
        if (apart <= reach(a, b, share)) pairs.push_back({apart, a, b});
      });
    }
    std::sort(pairs.begin(), pairs.end(), [](const Pair& l, const Pair& r) {
      return l.apart != r.apart ? l.apart < r.apart : std::array{l.a, l.b} < std::array{r.a, r.b};
    });
    return pairs;
  }

  /// Do both sheets leave the seam in the same direction?
  bool lie_on_each_other(Index a, Index b) const {
    const Vector3d &u = inward_[at(a)], &v = inward_[at(b)];
    return u.dot(v) > on_each_other * u.norm() * v.norm();
  }

  std::array<Index, 3> corners(Index t) const {
    const auto& n = mesh_.triangles[at(t)];
    return {of_[at(n[0])], of_[at(n[1])], of_[at(n[2])]};
  }

  /// Would a triangle lose a side or its area, or would two triangles be the same?
  bool collapses(Index a, Index b) const {
    std::set<std::array<Index, 3>> seen;
    for (const Index cluster : {a, b})
      for (const Index t : triangles_[at(cluster)]) {
        std::array<Index, 3> n = corners(t);
        if (std::count(n.begin(), n.end(), a) + std::count(n.begin(), n.end(), b) > 1) return true;
        std::replace(n.begin(), n.end(), std::max(a, b), std::min(a, b));
        const Vector3d u = x(n[1]) - x(n[0]), v = x(n[2]) - x(n[0]);
        const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (u - v).squaredNorm()});
        if (distance_ > 0 && !(0.5 * u.cross(v).norm() > 10 * cloth_min_area_ratio * longest)) return true;
        std::sort(n.begin(), n.end());
        if (!seen.insert(n).second) return true;
      }
    return false;
  }

  /// Would an edge have more than two triangles?
  bool crowds_an_edge(Index a, Index b) const {
    std::map<Index, int> count;  // of triangles at the edge to each neighbour
    for (const Index cluster : {a, b})
      for (const Index t : triangles_[at(cluster)])
        for (const Index n : corners(t))
          if (n != a && n != b && ++count[n] > 2) return true;
    return false;
  }

  void merge(Index into, Index from) {
    for (const Index p : members_[at(from)]) of_[at(p)] = into;
    for (auto* lists : {&members_, &triangles_}) {
      auto &to = (*lists)[at(into)], &of = (*lists)[at(from)];
      to.insert(to.end(), of.begin(), of.end());
      of.clear();
    }
  }

  void number_nodes(Weld& weld) const {
    weld.node.resize(of_.size());
    Index nodes = 0;
    for (std::size_t p = 0; p < of_.size(); ++p)
      weld.node[p] = of_[p] == static_cast<Index>(p) ? nodes++ : weld.node[at(of_[p])];
  }
};

}  // namespace

std::string Weld::text() const {
  const auto pairs = [](Index count) { return fmt::format("{} pair{}", count, count == 1 ? "" : "s"); };
  const Index sewn = merged + static_cast<Index>(held.size());
  std::string line = fmt::format("weld: {} of boundary points sewn", sewn > 0 ? pairs(sewn) : "no pairs");
  if (!held.empty())
    line += fmt::format(", {} of them by stitches, because more than two triangles would share an edge", held.size());
  if (layers > 0)
    line += fmt::format("; {} of points of overlapping sheets {} not sewn; a distance for weld would sew them",
                        pairs(layers), layers == 1 ? "is" : "are");
  if (open > 0)
    line += fmt::format("; {} {}pair{}, up to {:.2g} m apart, {} not sewn; weld: {:.2g} sews all pairs that near", open,
                        sewn > 0 ? "more " : "", open == 1 ? "" : "s", widest, open == 1 ? "is" : "are", 1.2 * widest);
  if (refused > 0)
    line += fmt::format("; {} {} not sewn, because a triangle would lose its area", pairs(refused),
                        refused == 1 ? "is" : "are");
  return line;
}

Weld weld_boundary(SurfaceMesh& mesh, double distance, const std::vector<Index>& copy_of) {
  Weld weld = Welder(mesh, distance).run(copy_of);
  if (weld.merged == 0) return weld;
  std::vector<Vec3> points;
  for (std::size_t p = 0; p < mesh.points.size(); ++p)
    if (at(weld.node[p]) == points.size()) points.push_back(mesh.points[p]);
  mesh.points = std::move(points);
  for (auto& t : mesh.triangles)
    for (Index& n : t) n = weld.node[at(n)];
  return weld;
}

}  // namespace drench
