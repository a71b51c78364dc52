#include "setup/close_gaps.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include "base/eigen_vec.hpp"
#include "base/sets.hpp"
#include "setup/mesh_joins.hpp"
#include "setup/point_grid.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

constexpr double narrow = 0.1;  // of the shortest edge at a point
constexpr int most_rounds = 8;  // in each of which a triangle is cut along one of its edges

class GapClosing {
 public:
  explicit GapClosing(const SurfaceMesh& mesh) : x_(mesh.points) {
    closed_.triangles = mesh.triangles;
    closed_.place = first_copies(mesh.points);
  }

  ClosedGaps merge_rounded() {
    find_boundary();
    double farthest = 0;
    for (const Vec3& x : x_) farthest = std::max(farthest, to_eigen(x).cwiseAbs().maxCoeff());
    for (double& reach : reach_) reach = std::min(reach, 0x1p-23 * farthest);
    merge_points();
    return std::move(closed_);
  }

  ClosedGaps run() {
    find_boundary();
    merge_points();
    for (int round = 0; round < most_rounds; ++round) {
      find_boundary();
      if (!cut_edges()) break;
    }
    return std::move(closed_);
  }

 private:
  Vector3d at_place(Index p) const { return to_eigen(x_[at(p)]); }

  void find_boundary() {
    boundary_.clear();
    points_.clear();
    reach_.assign(x_.size(), std::numeric_limits<double>::infinity());
    const HalfEdges sides{closed_.triangles};
    double length = 0;
    for (const std::vector<Index>& edge : edges_by_place(sides, closed_.place)) {
      const Index a = closed_.place[at(sides.from(at(edge[0])))], b = closed_.place[at(sides.to(at(edge[0])))];
      const double long_as = (at_place(a) - at_place(b)).norm();
      for (const Index p : {a, b}) reach_[at(p)] = std::min(reach_[at(p)], narrow * long_as);
      if (edge.size() > 1) continue;
      boundary_.push_back(edge[0]);
      points_.insert(points_.end(), {a, b});
      length += long_as;
    }
    std::sort(points_.begin(), points_.end());
    points_.erase(std::unique(points_.begin(), points_.end()), points_.end());
    if (boundary_.empty()) return;
    grid_.emplace(std::max(length / static_cast<double>(boundary_.size()), std::numeric_limits<double>::min()));
    for (const Index p : points_) grid_->add(x_[at(p)]);
  }

  /// Calls f(place) for boundary points that may be nearer to a box than `reach`.
  template <class F>
  void for_points_near(Eigen::AlignedBox3d box, double reach, const F& f) const {
    box.min().array() -= reach;
    box.max().array() += reach;
    const PointGrid::Cell low = grid_->cell_of(to_vec3(box.min())), high = grid_->cell_of(to_vec3(box.max()));
    double cells = 1;
    for (std::size_t a = 0; a < 3; ++a) cells *= static_cast<double>(high[a] - low[a] + 1);
    if (cells > static_cast<double>(points_.size()))
      for (const Index p : points_) f(p);
    else
      grid_->for_box(to_vec3(box.min()), to_vec3(box.max()), [&](Index k) { f(points_[at(k)]); });
  }

  void merge_points() {
    std::vector<std::tuple<double, Index, Index>> pairs;  // the nearest first
    for (const Index p : points_)
      for_points_near(Eigen::AlignedBox3d(at_place(p), at_place(p)), reach_[at(p)], [&](Index q) {
        const double apart = (at_place(p) - at_place(q)).norm();
        if (p < q && apart <= std::min(reach_[at(p)], reach_[at(q)])) pairs.emplace_back(apart, p, q);
      });
    std::sort(pairs.begin(), pairs.end());
    std::vector<Index>& place = closed_.place;
    Sets joined(place.size());
    for (std::size_t p = 0; p < place.size(); ++p) joined.unite(static_cast<Index>(p), place[p]);
    for (const auto& [apart, p, q] : pairs) {
      if (joined.root(p) == joined.root(q)) continue;
      joined.unite(p, q);
      add(apart);
    }
    for (Index& p : place) p = joined.root(p);
    std::erase_if(closed_.triangles, [&](const auto& t) {
      return place[at(t[0])] == place[at(t[1])] || place[at(t[1])] == place[at(t[2])] ||
             place[at(t[2])] == place[at(t[0])];
    });
  }

  bool cut_edges() {
    std::vector<bool> is_cut(closed_.triangles.size(), false);
    const std::size_t before = closed_.triangles.size();
    for (const Index h : boundary_) {
      const std::size_t t = at(h) / 3, c = at(h) % 3;
      const auto n = closed_.triangles[t];
      if (is_cut[t]) continue;
      const Index from = n[c], to = n[(c + 1) % 3], beyond = n[(c + 2) % 3];
      const Vector3d a = at_place(closed_.place[at(from)]), along = at_place(closed_.place[at(to)]) - a;
      std::vector<std::tuple<double, double, Index>> on;  // where, how far away, point
      for_points_near(Eigen::AlignedBox3d(a.cwiseMin(a + along), a.cwiseMax(a + along)), narrow * along.norm(),
                      [&](Index p) {
                        for (const Index corner : n)
                          if (closed_.place[at(corner)] == p) return;
                        const double where = (at_place(p) - a).dot(along) / along.squaredNorm(),
                                     apart = (at_place(p) - a - where * along).norm();
                        if (where > 0 && where < 1 && apart <= reach_[at(p)]) on.emplace_back(where, apart, p);
                      });
      if (on.empty()) continue;
      is_cut[t] = true;
      std::sort(on.begin(), on.end());
      Index last = from;
      for (const auto& [where, apart, p] : on) {
        closed_.triangles.push_back({last, p, beyond});
        last = p;
        add(apart);
      }
      closed_.triangles[t] = {last, to, beyond};
    }
    return closed_.triangles.size() > before;
  }

  void add(double apart) {
    ++closed_.joined;
    closed_.widest = std::max(closed_.widest, apart);
  }

  const std::vector<Vec3>& x_;
  ClosedGaps closed_;
  std::vector<Index> boundary_, points_;  // half-edges and places
  std::vector<double> reach_;             // m, of each place
  std::optional<PointGrid> grid_;
};

}  // namespace

ClosedGaps close_rounding(const SurfaceMesh& mesh) { return GapClosing(mesh).merge_rounded(); }

ClosedGaps close_gaps(const SurfaceMesh& mesh) { return GapClosing(mesh).run(); }

}  // namespace drench
