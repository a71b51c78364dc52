#include "setup/fabric_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/eigen_vec.hpp"
#include "setup/cloth_mesh.hpp"

namespace drench {
namespace {

/// ω is the ratio of a cell's sides; what exceeds this belongs to two nodes that nearly coincide, and would only cost
/// sub-steps.
constexpr double most_conducting = 100;

/// A triangulation known by the lengths of its edges alone. Half edge 3t + k leads from corner k of triangle t to the next.
class IntrinsicMesh {
 public:
  IntrinsicMesh(const ClothMesh& mesh, const std::vector<Index>& triangles) {
    std::map<std::array<Index, 2>, Index> open;
    for (const Index t : triangles) {
      const auto& corner = mesh.triangle[static_cast<std::size_t>(t)];
      for (std::size_t k = 0; k < 3; ++k) {
        const Index from = corner[k], to = corner[(k + 1) % 3], half = static_cast<Index>(node_.size());
        node_.push_back(from);
        length_.push_back((to_eigen(mesh.rest_position[static_cast<std::size_t>(to)]) -
                           to_eigen(mesh.rest_position[static_cast<std::size_t>(from)]))
                              .norm());
        twin_.push_back(-1);
        const std::array<Index, 2> edge{std::min(from, to), std::max(from, to)};
        if (const auto other = open.find(edge); other != open.end()) {
          join(half, other->second);
          open.erase(other);
        } else {
          open[edge] = half;
        }
      }
    }
  }

  /// Edges whose opposite angles add up to more than 180° are flipped until there is none (Bobenko & Springborn 2007).
  void make_delaunay() {
    std::vector<Index> work(node_.size());
    for (std::size_t e = 0; e < work.size(); ++e) work[e] = static_cast<Index>(e);
    std::size_t left = 1000 * work.size();  // rounding must not make it go on for ever
    while (!work.empty() && left-- > 0) {
      const Index e = work.back();
      work.pop_back();
      const Index o = twin(e);
      if (o < 0 || e / 3 == o / 3 || node(e) != node(next(o)) || cotangent(e) + cotangent(o) >= -1e-12) continue;
      flip(e, o);
      for (Index k = 0; k < 3; ++k) {
        work.push_back(e - e % 3 + k);
        work.push_back(o - o % 3 + k);
      }
    }
  }

  /// ω_ij = ½ (cot α + cot β), 1, by (lower, higher) node.
  std::map<std::array<Index, 2>, double> weights() const {
    std::map<std::array<Index, 2>, double> sum;
    for (Index e = 0; e < static_cast<Index>(node_.size()); ++e) {
      const Index from = node(e), to = node(next(e));
      if (from != to) sum[{std::min(from, to), std::max(from, to)}] += cotangent(e) / 2;
    }
    return sum;
  }

 private:
  std::vector<Index> node_, twin_;
  std::vector<double> length_;  // m

  static Index next(Index e) { return e % 3 == 2 ? e - 2 : e + 1; }
  Index node(Index e) const { return node_[static_cast<std::size_t>(e)]; }
  Index twin(Index e) const { return twin_[static_cast<std::size_t>(e)]; }
  double length(Index e) const { return length_[static_cast<std::size_t>(e)]; }
  void join(Index a, Index b) {
    if (a >= 0) twin_[static_cast<std::size_t>(a)] = b;
    if (b >= 0) twin_[static_cast<std::size_t>(b)] = a;
  }
  void set(Index e, Index from, double size) {
    node_[static_cast<std::size_t>(e)] = from;
    length_[static_cast<std::size_t>(e)] = size;
  }

  /// Four times the area (Heron's formula as Kahan orders it), m².
  double area4(Index e) const {
    double s[3] = {length(e), length(next(e)), length(next(next(e)))};
    std::sort(s, s + 3, std::greater<>());
    const double product =
        (s[0] + (s[1] + s[2])) * (s[2] - (s[0] - s[1])) * (s[2] + (s[0] - s[1])) * (s[0] + (s[1] - s[2]));
    return std::sqrt(std::max(product, 1e-24 * std::pow(s[0], 4)));
  }
  /// Of the angle opposite to half edge e.
  double cotangent(Index e) const {
    const double a = length(e), b = length(next(e)), c = length(next(next(e)));
    return (b * b + c * c - a * a) / area4(e);
  }
  /// Of the angle where half edge e begins.
  double angle_at(Index e) const { return std::atan2(1.0, cotangent(next(e))); }

  /// e = a b in (a, b, c) and o = b a in (b, a, d) become c d.
  void flip(Index e, Index o) {
    const Index bc = next(e), ca = next(bc), ad = next(o), db = next(ad);
    const Index a = node(e), b = node(o), c = node(ca), d = node(db);
    const double l_bc = length(bc), l_ca = length(ca), l_ad = length(ad), l_db = length(db);
    const double angle = angle_at(e) + angle_at(ad);
    const double across =
        std::sqrt(std::max(0.0, std::pow(l_ca - l_ad, 2) + 4 * l_ca * l_ad * std::pow(std::sin(angle / 2), 2)));
    const Index t_bc = twin(bc), t_ca = twin(ca), t_ad = twin(ad), t_db = twin(db);
    // (a, d, c) and (d, b, c)
    const Index first = e - e % 3, second = o - o % 3;
    set(first, a, l_ad);
    set(first + 1, d, across);
    set(first + 2, c, l_ca);
    set(second, d, l_db);
    set(second + 1, b, l_bc);
    set(second + 2, c, across);
    // An outer edge may have been the twin of another one of these four.
    const Index old[4] = {ad, ca, db, bc}, now[4] = {first, first + 2, second, second + 1};
    const Index others[4] = {t_ad, t_ca, t_db, t_bc};
    for (int k = 0; k < 4; ++k) {
      Index other = others[k];
      for (int l = 0; l < 4; ++l)
        if (others[k] == old[l]) {
          other = now[l];
          break;
        }
      twin_[static_cast<std::size_t>(now[k])] = other;
      if (other >= 0) twin_[static_cast<std::size_t>(other)] = now[k];
    }
    join(first + 1, second + 2);
  }
};

}  // namespace

void build_fabric_pairs(Model& model) {
  FabricPairs& fabric = model.fabric;
  std::vector<std::array<Index, 2>> entries;
  for (const ClothMaterial& c : model.cloths) {
    if (!c.wicks()) continue;
    std::vector<Index> triangles;
    for (Index t = c.first_triangle; t < c.first_triangle + c.triangle_count; ++t) triangles.push_back(t);
    IntrinsicMesh mesh(model.mesh, triangles);
    mesh.make_delaunay();
    for (const auto& [nodes, weight] : mesh.weights()) {
      if (!(weight > 1e-9)) continue;  // a rectangle's diagonal, an obtuse angle at the boundary
      const Index pair = static_cast<Index>(fabric.weight.size());
      for (Index side = 0; side < 2; ++side)
        entries.push_back({nodes[static_cast<std::size_t>(side)], 2 * pair + side});
      fabric.nodes.push_back(nodes);
      fabric.weight.push_back(std::min(weight, most_conducting));
    }
  }
  fabric.of_node = rows_of(model.mesh.nodes(), entries);
}

}  // namespace drench
