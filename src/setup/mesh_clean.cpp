#include "setup/mesh_clean.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "base/eigen_vec.hpp"
#include "scene/scene.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<Index, 3>;
using Texture = std::array<std::array<double, 2>, 3>;

constexpr double low = 0.01;          // of the mean edge: the height of a sliver
constexpr double least_cosine = 0.5;  // between a triangle's normals before and after
constexpr int most_passes = 10;

class Cleaner {
 public:
  Cleaner(SurfaceMesh& mesh, double height) : mesh_(mesh) {
    const std::vector<MeshEdge> edges = mesh_edges(mesh.triangles);
    double length = 0;
    for (const MeshEdge& e : edges) length += (x(e.a) - x(e.b)).norm();
    height_ = height < 0 ? low * length / std::max<double>(1, double(edges.size())) : height;
    gone_.assign(mesh.triangles.size(), false);
    of_.resize(mesh.points.size());
    std::iota(of_.begin(), of_.end(), Index(0));
    around_.resize(mesh.points.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (const Index n : mesh.triangles[t]) around_[at(n)].push_back(static_cast<Index>(t));
    groups_.resize(mesh.triangles.size());
    int number = 0;
    for (const auto& [name, triangles] : mesh.groups) {
      for (const Index t : triangles) groups_[at(t)].push_back(number);
      ++number;
    }
  }

  MeshCleaning run() {
    MeshCleaning done;
    done.height = height_;
    for (int pass = 0; pass < most_passes; ++pass) {
      bool any = false;
      for (Index t = 0; t < static_cast<Index>(gone_.size()); ++t)
        if (!gone_[at(t)] && height_of(corners(t)) < height_) any = treat(t, done) || any;
      if (!any) break;
    }
    for (Index t = 0; t < static_cast<Index>(gone_.size()); ++t)
      done.left += !gone_[at(t)] && height_of(corners(t)) < height_;
    for (Index n = 0; n < static_cast<Index>(of_.size()); ++n)
      if (of_[at(n)] == n) done.kept.push_back(n);
    if (done.collapsed + done.flipped + done.dropped > 0) renumber();
    done.node = of_;
    return done;
  }

 private:
  SurfaceMesh& mesh_;
  double height_ = 0;
  std::vector<bool> gone_;                  // of each triangle
  std::vector<Index> of_;                   // what each node has become
  std::vector<std::vector<Index>> around_;  // triangles at each node
  std::vector<std::vector<int>> groups_;    // of each triangle

  Vector3d x(Index n) const { return to_eigen(mesh_.points[at(n)]); }
  Triangle& corners(Index t) { return mesh_.triangles[at(t)]; }
  /// Its length is twice the area.
  Vector3d normal(const Triangle& t) const { return (x(t[1]) - x(t[0])).cross(x(t[2]) - x(t[0])); }
  double length(const Triangle& t, int k) const { return (x(t[at(k % 3)]) - x(t[at((k + 1) % 3)])).norm(); }
  double height_of(const Triangle& t) const {
    return triangle_height(mesh_.points[at(t[0])], mesh_.points[at(t[1])], mesh_.points[at(t[2])]);
  }

  std::vector<Index> at_edge(Index a, Index b) {
    std::vector<Index> found;
    for (const Index t : around_[at(a)])
      if (std::count(corners(t).begin(), corners(t).end(), b)) found.push_back(t);
    return found;
  }
  std::set<Index> neighbours(Index n) {
    std::set<Index> found;
    for (const Index t : around_[at(n)]) found.insert(corners(t).begin(), corners(t).end());
    found.erase(n);
    return found;
  }
  bool on_boundary(Index n) {
    for (const Index m : neighbours(n))
      if (at_edge(n, m).size() == 1) return true;
    return false;
  }

  /// Of a triangle that is too low: its shortest edge collapses, or its longest is flipped.
  bool treat(Index t, MeshCleaning& done) {
    int shortest = 0, longest = 0;
    for (int k = 1; k < 3; ++k) {
      if (length(corners(t), k) < length(corners(t), shortest)) shortest = k;
      if (length(corners(t), k) > length(corners(t), longest)) longest = k;
    }
    const Triangle n = corners(t);
    if (length(n, shortest) < 2 * height_ && collapse(n[at(shortest)], n[at((shortest + 1) % 3)])) {
      ++done.collapsed;
      return true;
    }
    const std::vector<Index> sides = at_edge(n[at(longest)], n[at((longest + 1) % 3)]);
    if (sides.size() == 1 && drop(t, n[at((longest + 2) % 3)])) {
      ++done.dropped;
      return true;
    }
    if (sides.size() != 2 || !flip(t, sides[0] == t ? sides[1] : sides[0], longest)) return false;
    ++done.flipped;
    return true;
  }

  bool turns_over(const Triangle& before, const Triangle& after) const {
    const Vector3d u = normal(before), v = normal(after);
    // The normal of a sliver is too uncertain to compare with.
    if (height_of(before) < height_) return !(v.norm() > 0);
    return !(u.dot(v) > least_cosine * u.norm() * v.norm());
  }

  bool collapse(Index a, Index b) {
    const std::vector<Index> between = at_edge(a, b);
    const bool boundary[2] = {on_boundary(a), on_boundary(b)};
    if (between.empty() || between.size() > 2 || (boundary[0] && boundary[1] && between.size() == 2)) return false;
    std::set<Index> common;
    const std::set<Index> of_a = neighbours(a), of_b = neighbours(b);
    std::set_intersection(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), std::inserter(common, common.end()));
    if (common.size() != between.size()) return false;  // else two triangles would have the same corners
    const bool keeps_b = boundary[1] && !boundary[0];
    const Index kept = keeps_b ? b : a, lost = keeps_b ? a : b;
    for (const Index t : around_[at(lost)]) {
      if (std::count(between.begin(), between.end(), t)) continue;
      Triangle after = corners(t);
      std::replace(after.begin(), after.end(), lost, kept);
      if (turns_over(corners(t), after)) return false;
    }
    if (around_[at(a)].size() + around_[at(b)].size() <= 2 * between.size()) return false;  // nothing would be left
    for (const Index t : between) remove(t);
    for (const Index t : around_[at(lost)]) {
      std::replace(corners(t).begin(), corners(t).end(), lost, kept);
      around_[at(kept)].push_back(t);
    }
    around_[at(lost)].clear();
    for (Index& n : of_)
      if (n == lost) n = kept;
    return true;
  }

  /// A triangle whose longest edge is on the boundary, opposite to an inner node.
  bool drop(Index t, Index opposite) {
    if (on_boundary(opposite)) return false;
    remove(t);
    return true;
  }

  bool flip(Index t, Index other, int longest) {
    if (groups_[at(t)] != groups_[at(other)]) return false;
    const Triangle n = corners(t), m = corners(other);
    const int k = longest;
    const Index a = n[at(k)], b = n[at((k + 1) % 3)], c = n[at((k + 2) % 3)];
    const auto place = [&](Index p) { return static_cast<int>(std::find(m.begin(), m.end(), p) - m.begin()); };
    const int of_a = place(a), of_b = place(b), of_d = 3 - of_a - of_b;
    if ((of_b + 1) % 3 != of_a) return false;  // the two do not have the same orientation
    const Index d = m[at(of_d)];
    if (c == d || !at_edge(c, d).empty()) return false;
    const Triangle first{c, a, d}, second{d, b, c};
    if (std::min(height_of(first), height_of(second)) <= height_of(n) || turns_over(m, first) || turns_over(m, second))
      return false;
    if (!mesh_.texture.empty()) {
      Texture &u = mesh_.texture[at(t)], &v = mesh_.texture[at(other)];
      if (u[at(k)] != v[at(of_a)] || u[at((k + 1) % 3)] != v[at(of_b)]) return false;  // a seam of the texture
      const auto ua = u[at(k)], ub = u[at((k + 1) % 3)], uc = u[at((k + 2) % 3)], ud = v[at(of_d)];
      u = {uc, ua, ud};
      v = {ud, ub, uc};
    }
    corners(t) = first;
    corners(other) = second;
    std::erase(around_[at(b)], t);
    std::erase(around_[at(a)], other);
    around_[at(d)].push_back(t);
    around_[at(c)].push_back(other);
    return true;
  }

  void remove(Index t) {
    gone_[at(t)] = true;
    for (const Index n : corners(t)) std::erase(around_[at(n)], t);
  }

  void renumber() {
    std::vector<Index> node(of_.size(), -1), triangle(gone_.size(), -1);
    std::vector<Vec3> points;
    for (Index n = 0; n < static_cast<Index>(of_.size()); ++n)
      if (of_[at(n)] == n) {
        node[at(n)] = static_cast<Index>(points.size());
        points.push_back(mesh_.points[at(n)]);
      }
    mesh_.points = std::move(points);
    for (Index& n : of_) n = node[at(n)];
    std::vector<Triangle> triangles;
    std::vector<Texture> texture;
    for (std::size_t t = 0; t < gone_.size(); ++t) {
      if (gone_[t]) continue;
      triangle[t] = static_cast<Index>(triangles.size());
      Triangle corner = mesh_.triangles[t];
      for (Index& n : corner) n = node[at(n)];
      triangles.push_back(corner);
      if (!mesh_.texture.empty()) texture.push_back(mesh_.texture[t]);
    }
    mesh_.triangles = std::move(triangles);
    mesh_.texture = std::move(texture);
    for (auto& [name, members] : mesh_.groups) {
      std::erase_if(members, [&](Index t) { return triangle[at(t)] < 0; });
      for (Index& t : members) t = triangle[at(t)];
    }
  }
};

}  // namespace

std::string MeshCleaning::text() const {
  std::string line =
      fmt::format("clean: removed triangles lower than {:.3g} m: {} short edges collapsed, {} long edges flipped",
                  height, collapsed, flipped);
  if (dropped > 0) line += fmt::format(", {} removed at the boundary", dropped);
  if (left > 0) line += fmt::format("; {} remain", left);
  return line + "; clean: off keeps them";
}

MeshCleaning clean_mesh(SurfaceMesh& mesh, double height) { return Cleaner(mesh, height).run(); }

}  // namespace drench
