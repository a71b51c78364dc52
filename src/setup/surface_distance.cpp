#include "setup/surface_distance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/eigen_vec.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

constexpr float larger = 1 + 0x1p-17F;

/// The square of the distance from a + p to the triangle a, a + ab, a + ac (Ericson 2005, section 5.1.5); a triangle
/// without area is its edges.
double squared_distance_to(const Vector3d& ab, const Vector3d& ac, const Vector3d& p) {
  const double d1 = ab.dot(p), d2 = ac.dot(p);
  if (d1 <= 0 && d2 <= 0) return p.squaredNorm();
  const Vector3d bp = p - ab;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.squaredNorm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return (p - d1 / (d1 - d3) * ab).squaredNorm();
  const Vector3d cp = p - ac;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.squaredNorm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return (p - d2 / (d2 - d6) * ac).squaredNorm();
  const double va = d3 * d6 - d5 * d4, s = d4 - d3, u = d5 - d6;
  if (va <= 0 && s >= 0 && u >= 0 && s + u > 0) return (bp - s / (s + u) * (ac - ab)).squaredNorm();
  const Vector3d normal = ab.cross(ac);
  const double square = normal.squaredNorm();
  if (!(square > 0)) return std::min({p.squaredNorm(), bp.squaredNorm(), cp.squaredNorm()});
  const double height = normal.dot(p);
  return height * height / square;
}

}  // namespace

TriangleTree::TriangleTree(const std::vector<Vec3>& points, const std::vector<std::array<Index, 3>>& triangles) {
  std::vector<Vector3d> middle;
  std::vector<Index> order(triangles.size());
  std::iota(order.begin(), order.end(), Index{0});
  Eigen::AlignedBox3d bounds;
  for (const auto& t : triangles) {
    const Vector3d a = to_eigen(points[at(t[0])]), b = to_eigen(points[at(t[1])]), c = to_eigen(points[at(t[2])]);
    triangles_.push_back({a, b - a, c - a});
    middle.push_back((a + b + c) / 3);
    for (const Vector3d& x : {a, b, c}) bounds.extend(x);
  }
  if (triangles.empty()) return;
  center_ = bounds.center();
  rounding_ = static_cast<float>(0x1p-22 * bounds.sizes().maxCoeff() + 0x1p-50 * center_.cwiseAbs().maxCoeff());
  build(order, middle, 0, order.size());
  std::vector<Corners> sorted;
  for (const Index t : order) sorted.push_back(triangles_[at(t)]);
  triangles_ = std::move(sorted);
  number_ = std::move(order);
}

void TriangleTree::set_box(Node& node, int child, const std::vector<Index>& order, std::size_t begin,
                           std::size_t end) const {
  Eigen::AlignedBox3d bounds;
  for (std::size_t k = begin; k < end; ++k) {
    const Corners& t = triangles_[at(order[k])];
    for (const Vector3d& x : {t.a, Vector3d(t.a + t.ab), Vector3d(t.a + t.ac)}) bounds.extend(Vector3d(x - center_));
  }
  for (std::size_t a = 0; a < 3; ++a) {
    node.min[a][child] = static_cast<float>(bounds.min()[static_cast<Index>(a)]) - rounding_;
    node.max[a][child] = static_cast<float>(bounds.max()[static_cast<Index>(a)]) + rounding_;
  }
}

Index TriangleTree::build(std::vector<Index>& order, const std::vector<Vector3d>& middle, std::size_t begin,
                          std::size_t end) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  const auto number = at(static_cast<Index>(nodes_.size()));
  nodes_.emplace_back();
  const auto halve = [&](std::size_t from, std::size_t to) {
    Eigen::AlignedBox3d middles;
    for (std::size_t k = from; k < to; ++k) middles.extend(middle[at(order[k])]);
    int axis = 0;
    middles.sizes().maxCoeff(&axis);
    const std::size_t half = from + (to - from + 1) / 2;
    const auto place = [&](std::size_t k) { return order.begin() + static_cast<std::ptrdiff_t>(k); };
    std::nth_element(place(from), place(half), place(to), [&](Index l, Index r) {
      const double a = middle[at(l)][axis], b = middle[at(r)][axis];
      return a < b || (a == b && l < r);
    });
    return half;
  };
  std::array<std::size_t, 5> part{begin, begin, begin, begin, end};
  part[2] = end - begin > 1 ? halve(begin, end) : end;
  part[1] = part[2] - begin > 1 ? halve(begin, part[2]) : part[2];
  part[3] = end - part[2] > 1 ? halve(part[2], end) : end;
  for (std::size_t a = 0; a < 3; ++a) {
    nodes_[number].min[a].setConstant(infinite);
    nodes_[number].max[a].setConstant(-infinite);
  }
  nodes_[number].child.fill(0);
  for (std::size_t c = 0; c + 1 < part.size(); ++c) {
    if (part[c] == part[c + 1]) continue;
    set_box(nodes_[number], static_cast<int>(c), order, part[c], part[c + 1]);
    const Index child =
        part[c + 1] - part[c] == 1 ? -1 - static_cast<Index>(part[c]) : build(order, middle, part[c], part[c + 1]);
    nodes_[number].child[c] = child;
  }
  return static_cast<Index>(number);
}

double TriangleTree::to_triangle(const Vector3d& x, Index t) const {
  const Corners& corners = triangles_[at(t)];
  return squared_distance_to(corners.ab, corners.ac, x - corners.a);
}

double TriangleTree::squared_distance(const Vector3d& x, Index& near, double bound) const {
  double best = to_triangle(x, near);
  visit_near(x, std::min(best, bound), [&](Index t) {
    const double square = to_triangle(x, t);
    if (square < best) near = t;
    best = std::min(best, square);
    return std::min(best, bound);
  });
  return best;
}

void TriangleTree::Candidates::clear() {
  triangle.clear();
  for (std::size_t a = 0; a < 3; ++a) {
    min[a].clear();
    max[a].clear();
  }
}

namespace {

/// A box from `center`, and how far from it to look, in floats: no box that is near enough is missed.
struct Reach {
  std::array<float, 3> low{}, high{};  // m
  float square = 0;                    // m²
  Reach(const Eigen::AlignedBox3d& box, const Vector3d& center, double bound)
      : square(static_cast<float>(bound * bound) * larger) {
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = static_cast<float>((box.min() - center)[static_cast<Index>(a)]);
      high[a] = static_cast<float>((box.max() - center)[static_cast<Index>(a)]);
    }
  }
  /// Is the box near? min(a) and max(a) are its bounds along an axis.
  template <class Min, class Max>
  bool has(const Min& min, const Max& max) const {
    float sum = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const float beyond = std::max(std::max(min(a) - high[a], low[a] - max(a)), 0.0F);
      sum += beyond * beyond;
    }
    return sum <= square;
  }
};

}  // namespace

void TriangleTree::find_candidates(const Eigen::AlignedBox3d& box, double bound, Candidates& found) const {
  found.clear();
  const Reach reach(box, center_, bound);
  std::array<Index, 64> open;
  std::size_t count = 0;
  open[count++] = 0;
  while (count > 0) {
    const Node& node = nodes_[at(open[--count])];
    for (int c = 0; c < width; ++c) {
      if (!reach.has([&](std::size_t a) { return node.min[a][c]; }, [&](std::size_t a) { return node.max[a][c]; }))
        continue;
      const Index child = node.child[static_cast<std::size_t>(c)];
      if (child >= 0) {
        open[count++] = child;
        continue;
      }
      found.triangle.push_back(-1 - child);
      for (std::size_t a = 0; a < 3; ++a) {
        found.min[a].push_back(node.min[a][c]);
        found.max[a].push_back(node.max[a][c]);
      }
    }
  }
  found.square.resize(found.triangle.size());
}

void TriangleTree::find_candidates(const Eigen::AlignedBox3d& box, double bound, const Candidates& among,
                                   Candidates& found) const {
  found.clear();
  const Reach reach(box, center_, bound);
  for (std::size_t c = 0; c < among.triangle.size(); ++c) {
    if (!reach.has([&](std::size_t a) { return among.min[a][c]; }, [&](std::size_t a) { return among.max[a][c]; }))
      continue;
    found.triangle.push_back(among.triangle[c]);
    for (std::size_t a = 0; a < 3; ++a) {
      found.min[a].push_back(among.min[a][c]);
      found.max[a].push_back(among.max[a][c]);
    }
  }
  found.square.resize(found.triangle.size());
}

double TriangleTree::squared_distance(const Vector3d& x, Candidates& candidates, Index& near) const {
  const Vector3d from_center = x - center_;
  const std::size_t count = candidates.triangle.size();
  using Row = Eigen::Map<const Eigen::ArrayXf>;
  const auto length = static_cast<Eigen::Index>(count);
  const float px = static_cast<float>(from_center[0]), py = static_cast<float>(from_center[1]),
              pz = static_cast<float>(from_center[2]);
  const auto& [min_x, min_y, min_z] = candidates.min;
  const auto& [max_x, max_y, max_z] = candidates.max;
  Eigen::Map<Eigen::ArrayXf>(candidates.square.data(), length) =
      (Row(min_x.data(), length) - px).max(px - Row(max_x.data(), length)).max(0.0F).square() +
      (Row(min_y.data(), length) - py).max(py - Row(max_y.data(), length)).max(0.0F).square() +
      (Row(min_z.data(), length) - pz).max(pz - Row(max_z.data(), length)).max(0.0F).square();
  const float* const square = candidates.square.data();
  double best = to_triangle(x, near);
  float limit = static_cast<float>(best) * larger;
  for (std::size_t c = 0; c < count; ++c) {
    if (square[c] > limit) continue;
    const double to_this = to_triangle(x, candidates.triangle[c]);
    if (!(to_this < best)) continue;
    near = candidates.triangle[c];
    best = to_this;
    limit = static_cast<float>(best) * larger;
  }
  return best;
}

WindingNumber::WindingNumber(const std::vector<Vec3>& points, const std::vector<std::array<Index, 3>>& triangles)
    : triangles_(triangles) {
  for (const Vec3& x : points) points_.push_back(to_eigen(x));
  Eigen::AlignedBox3d bounds;
  for (const auto& t : triangles_)
    for (const Index i : t) bounds.extend(points_[at(i)]);
  if (triangles_.empty()) return;
  const Vector3d size = bounds.sizes();
  // About as many cells as triangles.
  step_ =
      std::max({std::sqrt(size[1] * size[2] / static_cast<double>(triangles_.size())), 1e-4 * size[1], 1e-4 * size[2]});
  if (!(step_ > 0)) step_ = 1;
  origin_ = {bounds.min()[1], bounds.min()[2]};
  for (std::size_t a = 0; a < 2; ++a) cells_[a] = static_cast<Index>(size[static_cast<Index>(a) + 1] / step_) + 1;
  const auto for_cells = [&](const std::array<Index, 3>& t, const auto& visit) {
    std::array<Index, 2> low{}, high{};
    for (std::size_t a = 0; a < 2; ++a) {
      const auto cell = [&](Index i) {
        return std::clamp(static_cast<Index>((points_[at(i)][static_cast<Index>(a) + 1] - origin_[a]) / step_),
                          Index{0}, cells_[a] - 1);
      };
      low[a] = std::min({cell(t[0]), cell(t[1]), cell(t[2])});
      high[a] = std::max({cell(t[0]), cell(t[1]), cell(t[2])});
    }
    for (Index k = low[1]; k <= high[1]; ++k)
      for (Index j = low[0]; j <= high[0]; ++j) visit(at(k * cells_[0] + j));
  };
  start_.assign(at(cells_[0]) * at(cells_[1]) + 1, 0);
  for (const auto& t : triangles_) for_cells(t, [&](std::size_t cell) { ++start_[cell + 1]; });
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  item_.resize(at(start_.back()));
  std::vector<Index> next(start_.begin(), start_.end() - 1);
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for_cells(triangles_[t], [&](std::size_t cell) { item_[at(next[cell]++)] = static_cast<Index>(t); });
}

/// On which side of the edge from a to b the line is: +1 left, −1 right, 0 of an edge along the line. `weight`: twice
/// the area that the three enclose, with that sign. Both triangles of an edge compute the same numbers. A line through
/// the edge counts as moved by ε in y and ε² in z.
int WindingNumber::side(const Point& a, const Point& b, double y, double z, double& weight) const {
  const bool swapped = std::array{b[1], b[2], b[0]} < std::array{a[1], a[2], a[0]};
  const Point &from = swapped ? b : a, &to = swapped ? a : b;
  const double along_y = to[1] - from[1], along_z = to[2] - from[2];
  const double left = along_y * (z - from[2]), right = along_z * (y - from[1]), area = left - right;
  int sign = area > 0 ? 1 : -1;
  if (std::abs(area) <= 1e-15 * (std::abs(left) + std::abs(right)))
    sign = along_z != 0 ? (along_z > 0 ? -1 : 1) : along_y > 0 ? 1 : along_y < 0 ? -1 : 0;
  weight = swapped ? -area : area;
  return swapped ? -sign : sign;
}

int WindingNumber::passes(const std::array<Index, 3>& t, double y, double z, double& x) const {
  const Point &a = points_[at(t[0])], &b = points_[at(t[1])], &c = points_[at(t[2])];
  std::array<double, 3> weight{};
  const int s = side(b, c, y, z, weight[0]);
  if (s == 0 || side(c, a, y, z, weight[1]) != s || side(a, b, y, z, weight[2]) != s) return 0;
  const double sum = weight[0] + weight[1] + weight[2], low = std::min({a[0], b[0], c[0]}),
               high = std::max({a[0], b[0], c[0]});
  x = sum != 0 ? std::clamp((weight[0] * a[0] + weight[1] * b[0] + weight[2] * c[0]) / sum, low, high)
               : 0.5 * (low + high);
  return s;
}

void WindingNumber::crossings(double y, double z, std::vector<Crossing>& found) const {
  found.clear();
  const double along = (y - origin_[0]) / step_, up = (z - origin_[1]) / step_;
  if (!(along >= 0 && up >= 0 && along < cells_[0] && up < cells_[1])) return;
  const std::size_t cell = at(static_cast<Index>(up)) * at(cells_[0]) + at(static_cast<Index>(along));
  for (Index k = start_[cell]; k < start_[cell + 1]; ++k) {
    Crossing c;
    c.change = passes(triangles_[at(item_[at(k)])], y, z, c.x);
    if (c.change != 0) found.push_back(c);
  }
  std::sort(found.begin(), found.end(), [](const Crossing& l, const Crossing& r) { return l.x > r.x; });
}

int WindingNumber::around(const Vec3& x) const {
  std::vector<Crossing> found;
  crossings(x[1], x[2], found);
  int winding = 0;
  for (const Crossing& c : found)
    if (c.x > x[0]) winding += c.change;
  return winding;
}

}  // namespace drench
