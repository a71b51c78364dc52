#include "setup/fabric_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "base/eigen_vec.hpp"
#include "setup/cloth_mesh.hpp"

namespace drench {
namespace {

/// ω is the ratio of a cell's sides; what exceeds this belongs to two nodes that nearly coincide, and would only cost
/// sub-steps.
constexpr double most_conducting = 100;

/// ω of a stitch: its resistance is about a tenth of an edge's; more would only cost sub-steps.
constexpr double stitch_conducting = 8;

/// Sides of an edge may see its length this much apart, over the length; where the warp turns more, it stays a seam.
constexpr double same_length = 0.1;
/// A triangle keeps its shape if its area changes by no more than this factor when its edges take their mean lengths.
constexpr double same_area = 1.25;

/// How a triangle conducts.
struct Conducting {
  double stretch = 1;  // √(D_warp/D_weft): lengths along the warp are divided by its root, those across multiplied
  double part = 1;     // over what the cloth itself conducts
  Index material = 0;  // no edge between two of them is flipped
};

/// A triangulation known by the lengths of its edges alone. Half edge 3t + k leads from corner k of triangle t to the
/// next.
class IntrinsicMesh {
 public:
  /// `how`: of each of the triangles.
  IntrinsicMesh(const ClothMesh& mesh, const std::vector<Index>& triangles, const std::vector<Conducting>& how)
      : how_(how) {
    std::map<std::array<Index, 2>, Index> open;
    bool stretched = false;
    for (const Index t : triangles) {
      const double stretch = how_[node_.size() / 3].stretch;
      stretched = stretched || stretch != 1;
      const auto& corner = mesh.triangle[static_cast<std::size_t>(t)];
      for (std::size_t k = 0; k < 3; ++k) {
        const Index from = corner[k], to = corner[(k + 1) % 3], half = static_cast<Index>(node_.size());
        node_.push_back(from);
        const Eigen::Vector3d edge_vector = to_eigen(mesh.rest_position[static_cast<std::size_t>(to)]) -
                                            to_eigen(mesh.rest_position[static_cast<std::size_t>(from)]);
        length_.push_back(edge_vector.norm());
        if (stretch != 1) {
          const double along = edge_vector.dot(to_eigen(mesh.triangle_warp[static_cast<std::size_t>(t)]));
          const double across = std::sqrt(std::max(0.0, edge_vector.squaredNorm() - along * along));
          length_.back() = std::hypot(along / std::sqrt(stretch), across * std::sqrt(stretch));
        }
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
    seam_.assign(node_.size(), 0);
    for (std::size_t e = 0; e < node_.size(); ++e)
      if (twin_[e] >= 0 && of(static_cast<Index>(e)).material != of(twin_[e]).material) seam_[e] = 1;
    if (stretched) agree_on_lengths();
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
      if (o < 0 || seam_[static_cast<std::size_t>(e)] || e / 3 == o / 3 || node(e) != node(next(o)) ||
          cotangent(e) + cotangent(o) >= -1e-12)
        continue;
      flip(e, o);
      for (Index k = 0; k < 3; ++k) {
        work.push_back(e - e % 3 + k);
        work.push_back(o - o % 3 + k);
      }
    }
  }

  /// Of an edge: ω_ij = ½ (cot α + cot β), each angle times `part` of its triangle, and the larger of these.
  struct Weight {
    double conductance = 0, part = 0;
  };
  /// By (lower, higher) node.
  std::map<std::array<Index, 2>, Weight> weights() const {
    std::map<std::array<Index, 2>, Weight> sum;
    for (Index e = 0; e < static_cast<Index>(node_.size()); ++e) {
      const Index from = node(e), to = node(next(e));
      if (from == to) continue;
      Weight& weight = sum[{std::min(from, to), std::max(from, to)}];
      weight.conductance += of(e).part * (cotangent(e) / 2);
      weight.part = std::max(weight.part, of(e).part);
    }
    return sum;
  }

 private:
  std::vector<Index> node_, twin_;
  std::vector<double> length_;          // m, in the stretched metric
  std::vector<std::uint8_t> seam_;      // 1: both sides keep lengths of their own, and it is not flipped
  const std::vector<Conducting>& how_;  // of each triangle

  const Conducting& of(Index half) const { return how_[static_cast<std::size_t>(half / 3)]; }

  static Index next(Index e) { return e % 3 == 2 ? e - 2 : e + 1; }
  Index node(Index e) const { return node_[static_cast<std::size_t>(e)]; }
  Index twin(Index e) const { return twin_[static_cast<std::size_t>(e)]; }
  double length(Index e) const { return length_[static_cast<std::size_t>(e)]; }
  void join(Index a, Index b) {
    if (a >= 0) twin_[static_cast<std::size_t>(a)] = b;
    if (b >= 0) twin_[static_cast<std::size_t>(b)] = a;
  }
  void set(Index e, Index from, double size, std::uint8_t seam) {
    node_[static_cast<std::size_t>(e)] = from;
    length_[static_cast<std::size_t>(e)] = size;
    seam_[static_cast<std::size_t>(e)] = seam;
  }

  /// Edges whose sides see nearly the same length take the root mean square of both, the metric between them. The
  /// others are seams, and so are those that would deform a triangle.
  void agree_on_lengths() {
    const std::vector<double> own = length_;
    const auto size = [&](Index e) { return own[static_cast<std::size_t>(e)]; };
    const Index halves = static_cast<Index>(node_.size());
    for (Index e = 0; e < halves; ++e) {
      const Index o = twin(e);
      if (o < 0 || seam_[static_cast<std::size_t>(e)]) continue;
      const double mean = std::sqrt((size(e) * size(e) + size(o) * size(o)) / 2);
      if (std::abs(size(e) - size(o)) <= same_length * mean)
        length_[static_cast<std::size_t>(e)] = mean;
      else
        seam_[static_cast<std::size_t>(e)] = 1;
    }
    for (bool changed = true; changed;) {
      changed = false;
      for (Index t = 0; t < halves; t += 3) {
        const double before = area4(size(t), size(t + 1), size(t + 2)), now = area4(t);
        if (now <= same_area * before && before <= same_area * now) continue;
        for (const Index e : {t, t + 1, t + 2}) {
          const Index o = twin(e);
          if (o < 0 || seam_[static_cast<std::size_t>(e)]) continue;
          for (const Index side : {e, o}) {
            seam_[static_cast<std::size_t>(side)] = 1;
            length_[static_cast<std::size_t>(side)] = size(side);
          }
          changed = true;
        }
      }
    }
  }

  /// Four times the area (Heron's formula as Kahan orders it), m².
  double area4(Index e) const { return area4(length(e), length(next(e)), length(next(next(e)))); }
  static double area4(double a, double b, double c) {
    double s[3] = {a, b, c};
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
    const auto seam = [&](Index half) { return seam_[static_cast<std::size_t>(half)]; };
    const std::uint8_t s_bc = seam(bc), s_ca = seam(ca), s_ad = seam(ad), s_db = seam(db);
    // (a, d, c) and (d, b, c)
    const Index first = e - e % 3, second = o - o % 3;
    set(first, a, l_ad, s_ad);
    set(first + 1, d, across, 0);
    set(first + 2, c, l_ca, s_ca);
    set(second, d, l_db, s_db);
    set(second + 1, b, l_bc, s_bc);
    set(second + 2, c, across, 0);
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

/// (1−Φ) τ D
double conductivity(const ClothMaterial& m) { return (1 - m.solid_fraction) * m.thickness * m.diffusivity; }

Conducting conducting(const Model& model, const ClothMaterial& cloth, Index triangle) {
  const MaterialScene& given = model.fabric_of_triangle(triangle);
  Conducting how;
  if (given.weft_diffusivity) how.stretch = std::sqrt(given.diffusivity / *given.weft_diffusivity);
  if (!model.has_regions()) return how;
  const ClothMaterial& own = model.material_of_triangle(triangle);
  if (&own != &cloth) how.part = conductivity(own) / conductivity(cloth);
  how.material = model.mesh.triangle_material[static_cast<std::size_t>(triangle)];
  return how;
}

/// Per node: is it on an edge of one triangle alone, and not sewn?
std::vector<std::uint8_t> nodes_of_hems(const ClothMesh& mesh) {
  std::map<std::array<Index, 2>, int> sides;
  for (const auto& corner : mesh.triangle)
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = corner[k], b = corner[(k + 1) % 3];
      ++sides[{std::min(a, b), std::max(a, b)}];
    }
  std::vector<std::uint8_t> hem(mesh.rest_position.size(), 0);
  for (const auto& [nodes, count] : sides)
    if (count == 1)
      for (const Index n : nodes) hem[static_cast<std::size_t>(n)] = 1;
  for (const auto& stitch : mesh.stitch)
    for (const Index n : stitch) hem[static_cast<std::size_t>(n)] = 0;
  return hem;
}

}  // namespace

void build_fabric_pairs(Model& model) {
  FabricPairs& fabric = model.fabric;
  std::vector<std::array<Index, 2>> entries;
  const bool films = model.has_films(), narrowing = model.has_narrowing();
  if (films) fabric.hem = nodes_of_hems(model.mesh);
  for (std::size_t cloth = 0; cloth < model.cloths.size(); ++cloth) {
    const ClothMaterial& c = model.cloths[cloth];
    if (!c.wicks()) continue;
    std::vector<Index> triangles;
    std::vector<Conducting> how;
    for (Index t = c.first_triangle; t < c.first_triangle + c.triangle_count; ++t) {
      triangles.push_back(t);
      how.push_back(conducting(model, c, t));
    }
    IntrinsicMesh mesh(model.mesh, triangles, how);
    mesh.make_delaunay();
    for (const auto& [nodes, weight] : mesh.weights()) {
      // a rectangle's diagonal, an obtuse angle at the boundary
      if (!(weight.conductance > 1e-9 * weight.part)) continue;
      const Index pair = static_cast<Index>(fabric.weight.size());
      for (Index side = 0; side < 2; ++side)
        entries.push_back({nodes[static_cast<std::size_t>(side)], 2 * pair + side});
      fabric.nodes.push_back(nodes);
      fabric.weight.push_back(std::min(weight.conductance, most_conducting * weight.part));
      if (narrowing) {
        const auto at = [&](std::size_t side) {
          return to_eigen(model.mesh.rest_position[static_cast<std::size_t>(nodes[side])]);
        };
        fabric.rest_square.push_back((at(1) - at(0)).squaredNorm());
      }
      if (films) fabric.film.push_back(std::min(weight.conductance / weight.part, most_conducting));
    }
    for (const auto& stitch : model.mesh.stitch) {
      if (model.mesh.node_cloth[static_cast<std::size_t>(stitch[0])] != static_cast<Index>(cloth)) continue;
      const Index pair = static_cast<Index>(fabric.weight.size());
      for (Index side = 0; side < 2; ++side)
        entries.push_back({stitch[static_cast<std::size_t>(side)], 2 * pair + side});
      fabric.nodes.push_back(stitch);
      fabric.weight.push_back(stitch_conducting);
      if (narrowing) fabric.rest_square.push_back(0);
      if (films) fabric.film.push_back(stitch_conducting);
    }
  }
  fabric.of_node = rows_of(model.mesh.nodes(), entries);
}

}  // namespace drench
