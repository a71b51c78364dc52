#include "setup/facing_parts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <queue>
#include <tuple>

#include "base/eigen_vec.hpp"
#include "base/for_ranges.hpp"
#include "setup/distance_field.hpp"
#include "setup/surface_distance.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;
using Triangles = std::vector<std::array<Index, 3>>;

enum class Part : std::uint8_t { none, first, second };

/// Two classes of triangles by constraints: which are in the same and which in different ones. A constraint that
/// contradicts earlier ones is left out.
class TwoClasses {
 public:
  explicit TwoClasses(std::size_t count) : parent_(count), differs_(count, 0) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  void constrain(std::size_t a, std::size_t b, bool differ) {
    const auto [root_a, of_a] = root(a);
    const auto [root_b, of_b] = root(b);
    if (root_a == root_b) return;
    const std::size_t low = std::min(root_a, root_b), high = std::max(root_a, root_b);
    parent_[high] = low;
    differs_[high] = of_a != of_b ? !differ : differ;
  }
  /// Is a in the other class than the first triangle of its component?
  bool differs(std::size_t a) { return root(a).second; }

 private:
  /// The first triangle of a's component, and whether a is in the other class than that.
  std::pair<std::size_t, bool> root(std::size_t a) {
    bool differs = false;
    while (parent_[a] != a) {
      const std::size_t parent = parent_[a];
      parent_[a] = parent_[parent];  // halves the path
      differs_[a] ^= differs_[parent];
      differs = differs != (differs_[a] != 0);
      a = parent_[a];
    }
    return {a, differs};
  }

  std::vector<std::size_t> parent_;
  std::vector<std::uint8_t> differs_;  // from the parent; 0 of a root
};

/// Centroids and normals of a body's triangles.
struct Surface {
  const Body& body;
  std::vector<Vector3d> middle, normal;

  explicit Surface(const Body& b) : body(b) {
    for (const auto& t : b.mesh_triangles) {
      const Vector3d x = corner(t, 0), y = corner(t, 1), z = corner(t, 2);
      middle.push_back((x + y + z) / 3);
      normal.push_back((y - x).cross(z - x).normalized());
    }
  }
  std::size_t count() const { return middle.size(); }
  Vector3d corner(const std::array<Index, 3>& t, std::size_t k) const { return to_eigen(body.mesh_points[at(t[k])]); }
  double distance_at(const Vector3d& x) const {
    Vec3 unused;
    return field_distance(body.field, to_vec3(x), unused);
  }
  /// May triangle t face another part of the surface within `range` (m)? By the lattice of distances, cheaply.
  bool may_face(std::size_t t, double range) const {
    const double cell = 0.25 * body.field.spacing;
    return distance_at(middle[t] + 0.5 * range * normal[t]) < 0.5 * range - cell || distance_at(middle[t]) < -cell;
  }
};

/// Which triangles have an edge in common.
class Adjacency {
 public:
  explicit Adjacency(const Body& body) : body_(body) {
    for (std::size_t t = 0; t < body.mesh_triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) edges_.emplace_back(edge(t, k), t);
    std::ranges::sort(edges_);
  }
  template <class F>
  void for_neighbors(std::size_t t, const F& f) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const Edge own = edge(t, k);
      for (auto it = std::ranges::lower_bound(edges_, std::pair{own, std::size_t{0}});
           it != edges_.end() && it->first == own; ++it)
        if (it->second != t) f(it->second);
    }
  }

 private:
  using Edge = std::pair<Index, Index>;  // of points
  Edge edge(std::size_t t, std::size_t k) const {
    const auto& corner = body_.mesh_triangles[t];
    return std::minmax(corner[k], corner[(k + 1) % 3]);
  }
  const Body& body_;
  std::vector<std::pair<Edge, std::size_t>> edges_;
};

/// The nearest triangle that triangle t faces within `range` (m): front to front, or back to back where parts overlap.
/// `tree`: of all triangles.
std::optional<std::size_t> faced_by(const Surface& surface, const TriangleTree& tree,
                                    const std::vector<std::uint8_t>& hidden, std::size_t t, double range) {
  constexpr double opposed = 0.2, touching = 1e-3;  // cosine; of the range
  const Vector3d &middle = surface.middle[t], &normal = surface.normal[t];
  const auto is_faced = [&](std::size_t u, const Vector3d& apart) {
    if (!(normal.dot(surface.normal[u]) < opposed)) return false;
    const bool ahead = apart.dot(normal) > 0, overlap = hidden[t] != 0 || hidden[u] != 0;
    // Not two sides of a thin wall, and not faces that touch.
    if (ahead == overlap || ahead != (apart.dot(surface.normal[u]) < 0)) return false;
    return !overlap || -apart.dot(normal) > touching * range;
  };
  std::optional<std::size_t> found;
  double nearest = std::numeric_limits<double>::infinity();  // the square, m²
  tree.visit_near(middle, range * range, [&](Index k) {
    const std::size_t u = at(tree.number_of(k));
    const Vector3d apart = surface.middle[u] - middle;
    const double square = apart.squaredNorm();
    if ((square < nearest || (square == nearest && u < *found)) && is_faced(u, apart)) {
      nearest = square;
      found = u;
    }
    return std::min(range * range, nearest);
  });
  return found;
}

/// The part of each triangle that faces another one within `range` (m); empty if none does.
std::vector<Part> facing_triangles(const Surface& surface, const Adjacency& adjacency,
                                   const std::vector<std::uint8_t>& hidden, double range, int threads) {
  const std::size_t count = surface.count();
  const TriangleTree tree(surface.body.mesh_points, surface.body.mesh_triangles);
  std::vector<std::optional<std::size_t>> faced(count);
  for_ranges(count, threads, [&](std::size_t t) {
    if (surface.may_face(t, range)) faced[t] = faced_by(surface, tree, hidden, t, range);
  });
  std::vector<Part> part(count, Part::none);
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t t = 0; t < count; ++t) {
    if (!faced[t]) continue;
    pairs.emplace_back((surface.middle[*faced[t]] - surface.middle[t]).norm(), t, *faced[t]);
    part[t] = part[*faced[t]] = Part::first;
  }
  if (pairs.empty()) return {};
  std::ranges::sort(pairs);
  TwoClasses classes(count);
  for (const auto& [distance, t, u] : pairs) classes.constrain(t, u, true);
  for (std::size_t t = 0; t < count; ++t)
    if (part[t] != Part::none)
      adjacency.for_neighbors(t, [&](std::size_t u) {
        if (u < t && part[u] != Part::none) classes.constrain(u, t, false);
      });
  for (std::size_t t = 0; t < count; ++t)
    if (part[t] != Part::none && classes.differs(t)) part[t] = Part::second;
  return part;
}

/// Adds the surface around the parts, up to `range` (m) along it, to the nearer part: where a gap ends, cloth slides
/// around the edges of both.
void widen_parts(const Surface& surface, const Adjacency& adjacency, const std::vector<std::uint8_t>& hidden,
                 double range, std::vector<Part>& part) {
  using Reached = std::pair<double, std::size_t>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next;
  std::vector<double> length(part.size(), std::numeric_limits<double>::infinity());  // along the surface, m
  for (std::size_t t = 0; t < part.size(); ++t) {
    if (part[t] == Part::none) continue;
    length[t] = 0;
    next.emplace(0.0, t);
  }
  while (!next.empty()) {
    const auto [so_far, t] = next.top();
    next.pop();
    if (so_far > length[t]) continue;
    adjacency.for_neighbors(t, [&, so_far = so_far, t = t](std::size_t u) {
      const double longer = so_far + (surface.middle[u] - surface.middle[t]).norm();
      if (longer > range || longer >= length[u] || hidden[u] != 0) return;
      length[u] = longer;
      part[u] = part[t];
      next.emplace(longer, u);
    });
  }
}

/// Distances to the two parts, each together with the rest of the surface, at points near them.
class PartDistances {
 public:
  PartDistances(const Surface& surface, const WindingNumber& winding, const std::vector<std::uint8_t>& hidden,
                const std::vector<Part>& part)
      : surface_(surface), winding_(winding) {
    const auto make = [&](Part own) {
      Tree made;
      Triangles triangles;
      for (std::size_t t = 0; t < part.size(); ++t) {
        if (part[t] != own || (own == Part::none && hidden[t] != 0)) continue;
        overlap_ = overlap_ || hidden[t] != 0;
        made.number.push_back(t);
        triangles.push_back(surface.body.mesh_triangles[t]);
      }
      made.tree.emplace(surface.body.mesh_points, triangles);
      return made;
    };
    own_[0] = make(Part::first);
    own_[1] = make(Part::second);
    rest_ = make(Part::none);
  }

  static constexpr double diagonals = 3.5;  // of two cells, over their edge

  /// Where a search for the next point of a row begins.
  using Near = std::array<Index, 3>;
  using Distances = std::array<double, 2>;  // m
  /// The distances of x, whose distance to the whole surface is `phi` (m); none where both equal that, and farther than
  /// `band` (m) from both parts. Inside of the mesh, a part in front of x is not there beyond `reach` (m).
  std::optional<Distances> at_point(const Vector3d& x, double phi, double band, double reach, Near& near) const {
    const double rounding = 8 * surface_.body.field.spacing;  // far from the surface phi is interpolated
    if (phi > band + rounding || (!overlap_ && phi < -band - rounding)) return std::nullopt;
    if (!is_within(own_[0], x, band, near[0]) && !is_within(own_[1], x, band, near[1])) return std::nullopt;
    const Distances own{distance(own_[0], x, near[0]), distance(own_[1], x, near[1])};
    const double rest = distance(rest_, x, near[2]);
    if (rest <= std::min(own[0], own[1])) return std::nullopt;
    const Distances with_rest{std::min(own[0], rest), std::min(own[1], rest)};
    const int around = phi < 0 || overlap_ ? winding_.around(to_vec3(x)) : 0;
    if (around <= 0) return with_rest;
    if (around > 1) return Distances{-with_rest[0], -with_rest[1]};
    // x is inside one of the two solids and in front of the other part. The nearest triangle shows which: x is behind
    // it or in front of it. Below the border between the parts x is behind both, and the same rule gives distances
    // without kinks (docs/dev/contacts.md) away from the border. Where the nearer part changes, both distances jump.
    // Therefore the part in front is there only as far as cloth reaches, and so far that no cell lacks both parts.
    const std::size_t nearer = own[0] < own[1] ? 0 : 1, inside = is_behind(nearer, near, x) ? nearer : 1 - nearer;
    const double front = own[1 - inside],
                 farthest = std::max(reach, own[inside] + diagonals * surface_.body.field.spacing);
    Distances found;
    found[inside] = -with_rest[inside];
    found[1 - inside] = front > farthest ? DistanceField::nowhere : front;
    return found;
  }

 private:
  struct Tree {
    std::vector<std::size_t> number;  // of the tree's triangles, in the mesh
    std::optional<TriangleTree> tree;
  };
  static double distance(const Tree& t, const Vector3d& x, Index& near) {
    return t.number.empty() ? std::numeric_limits<double>::infinity() : std::sqrt(t.tree->squared_distance(x, near));
  }
  /// Is x no farther than `bound` (m) from a part?
  static bool is_within(const Tree& t, const Vector3d& x, double bound, Index& near) {
    return !t.number.empty() && t.tree->squared_distance(x, near, bound * bound) <= bound * bound;
  }
  /// Is x behind the triangle of a part that is nearest to it?
  bool is_behind(std::size_t part, const Near& near, const Vector3d& x) const {
    const std::size_t t = own_[part].number[at(own_[part].tree->number_of(near[part]))];
    return (x - surface_.middle[t]).dot(surface_.normal[t]) < 0;
  }

  const Surface& surface_;
  const WindingNumber& winding_;
  bool overlap_ = false;  // do the parts overlap?
  std::array<Tree, 2> own_;
  Tree rest_;
};

/// The part of a body's lattice that is at most `margin` (m) away from a box, without values.
DistanceField cut_lattice(const DistanceField& field, const Eigen::AlignedBox3d& box, double margin) {
  DistanceField cut;
  cut.spacing = field.spacing;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto nearest_point = [&](double x) {
      const double steps = std::round((x - field.origin[a]) / field.spacing);
      return static_cast<Index>(std::clamp(steps, 0.0, static_cast<double>(field.points[a] - 1)));
    };
    const auto axis = static_cast<int>(a);
    const Index first = nearest_point(box.min()[axis] - margin), last = nearest_point(box.max()[axis] + margin);
    cut.origin[a] = field.origin[a] + first * field.spacing;
    cut.points[a] = last - first + 1;
  }
  return cut;
}

/// Calls f(i, j, k, near) for all points of a lattice, layers in parallel; `near` stays that of the layer.
template <class F>
void for_points(const DistanceField& field, int threads, const F& f) {
  for_ranges(at(field.points[2]), threads, [&](std::size_t layer) {
    PartDistances::Near near{};
    for (Index j = 0; j < field.points[1]; ++j)
      for (Index i = 0; i < field.points[0]; ++i) f(i, j, static_cast<Index>(layer), near);
  });
}

/// body.parts, where `distances` are: up to `band` (m) from the parts, which lie in `bounds`.
void fill_parts(Body& body, const PartDistances& distances, const Eigen::AlignedBox3d& bounds, double band,
                double reach, int threads) {
  const DistanceField& field = body.field;
  auto& [first, second] = body.parts;
  first = field;
  second = cut_lattice(field, bounds, band + 2 * field.spacing);
  second.value.assign(at(second.points[0]) * at(second.points[1]) * at(second.points[2]), DistanceField::nowhere);
  const std::array<Index, 3> offset = second.offset_in(field);
  const auto in_whole = [&](Index i, Index j, Index k) {
    return field.index(i + offset[0], j + offset[1], k + offset[2]);
  };
  std::vector<std::uint8_t> differs(second.value.size(), 0);
  for_points(second, threads, [&](Index i, Index j, Index k, PartDistances::Near& near) {
    const Vector3d x = to_eigen(second.origin) + field.spacing * Vector3d(i, j, k);
    const auto found = distances.at_point(x, field.value[in_whole(i, j, k)], band, reach, near);
    if (!found) return;
    const std::size_t p = second.index(i, j, k);
    first.value[in_whole(i, j, k)] = (*found)[0];
    second.value[p] = (*found)[1];
    differs[p] = 1;
  });
  // A cell with a point where the parts have distances of their own needs both at all its points.
  const auto shares_a_cell = [&](Index i, Index j, Index k) {
    const auto [nx, ny, nz] = second.points;
    for (Index c = std::max(k - 1, 0); c <= std::min(k + 1, nz - 1); ++c)
      for (Index b = std::max(j - 1, 0); b <= std::min(j + 1, ny - 1); ++b)
        for (Index a = std::max(i - 1, 0); a <= std::min(i + 1, nx - 1); ++a)
          if (differs[second.index(a, b, c)] != 0) return true;
    return false;
  };
  for_points(second, threads, [&](Index i, Index j, Index k, PartDistances::Near&) {
    const std::size_t p = second.index(i, j, k);
    if (differs[p] == 0 && shares_a_cell(i, j, k)) second.value[p] = field.value[in_whole(i, j, k)];
  });
}

}  // namespace

void find_facing_parts(Body& body, double thickness, int threads) {
  const DistanceField& field = body.field;
  // Beyond that range the ridge between two parts is out of the cloth's reach by more than the lattice's cells.
  const double range = 4 * (thickness + field.spacing), band = 0.5 * range + 2 * field.spacing;
  const double reach = 2 * (thickness + field.spacing);  // of cloth, with the cells around its points
  const Surface surface(body);
  bool any = false;
  for (std::size_t t = 0; t < surface.count() && !any; ++t) any = surface.may_face(t, range);
  if (!any) return;
  const WindingNumber winding(body.mesh_points, body.mesh_triangles);
  const std::vector<std::uint8_t> hidden = hidden_triangles(body, winding, threads);
  const Adjacency adjacency(body);
  std::vector<Part> part = facing_triangles(surface, adjacency, hidden, range, threads);
  if (part.empty()) return;
  widen_parts(surface, adjacency, hidden, range, part);
  const PartDistances distances(surface, winding, hidden, part);
  Eigen::AlignedBox3d bounds;
  for (std::size_t t = 0; t < part.size(); ++t)
    for (std::size_t k = 0; part[t] != Part::none && k < 3; ++k)
      bounds.extend(surface.corner(body.mesh_triangles[t], k));
  fill_parts(body, distances, bounds, band, reach, threads);
}

}  // namespace drench
