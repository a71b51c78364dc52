#include "setup/surface_distance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/eigen_vec.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

constexpr Index leaf = 4;                // triangles at most
constexpr double wider = 1 + 0x1p-40;    // than rounding can be

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

/// The square of the distance from a + p to the triangle a, a + ab, a + ac (Ericson 2005, section 5.1.5); a triangle without area
/// is its edges.
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

double squared_distance_to_box(const Vector3d& min, const Vector3d& max, const Vector3d& x) {
  return (min - x).cwiseMax(x - max).cwiseMax(0.0).squaredNorm();
}

}  // namespace

TriangleTree::TriangleTree(const std::vector<Vec3>& points, const std::vector<std::array<Index, 3>>& triangles) {
  std::vector<Vector3d> middle;
  std::vector<Index> order(triangles.size());
  std::iota(order.begin(), order.end(), Index{0});
  for (const auto& t : triangles) {
    const Vector3d a = to_eigen(points[at(t[0])]), b = to_eigen(points[at(t[1])]), c = to_eigen(points[at(t[2])]);
    triangles_.push_back({a, b - a, c - a});
    middle.push_back((a + b + c) / 3);
  }
  if (triangles.empty()) return;
  build(order, middle, 0, order.size());
  std::vector<Corners> sorted;
  for (const Index t : order) sorted.push_back(triangles_[at(t)]);
  triangles_ = std::move(sorted);
}

Index TriangleTree::build(std::vector<Index>& order, const std::vector<Vector3d>& middle, std::size_t begin, std::size_t end) {
  const auto number = static_cast<Index>(nodes_.size());
  nodes_.emplace_back();
  Eigen::AlignedBox3d bounds, middles;
  for (std::size_t k = begin; k < end; ++k) {
    const Corners& t = triangles_[at(order[k])];
    bounds.extend(t.a);
    bounds.extend(Vector3d(t.a + t.ab));
    bounds.extend(Vector3d(t.a + t.ac));
    middles.extend(middle[at(order[k])]);
  }
  // The corners of ab and ac are rounded.
  const double margin = 1e-15 * bounds.min().cwiseAbs().cwiseMax(bounds.max().cwiseAbs()).maxCoeff();
  nodes_[at(number)].min = bounds.min().array() - margin;
  nodes_[at(number)].max = bounds.max().array() + margin;
  if (end - begin <= leaf) {
    nodes_[at(number)].first = static_cast<Index>(begin);
    nodes_[at(number)].count = static_cast<Index>(end - begin);
    return number;
  }
  int axis = 0;
  middles.sizes().maxCoeff(&axis);
  const std::size_t half = begin + (end - begin) / 2;
  const auto place = [&](std::size_t k) { return order.begin() + static_cast<std::ptrdiff_t>(k); };
  std::nth_element(place(begin), place(half), place(end), [&](Index l, Index r) {
    const double a = middle[at(l)][axis], b = middle[at(r)][axis];
    return a < b || (a == b && l < r);
  });
  build(order, middle, begin, half);
  const Index second = build(order, middle, half, end);
  nodes_[at(number)].first = second;
  return number;
}

double TriangleTree::squared_distance(const Vector3d& x, Index& near) const {
  struct Entry {
    Index node;
    double square;
  };
  std::array<Entry, 96> open;  // two a level, and a level halves the triangles
  std::size_t count = 0;
  const auto to_triangle = [&](Index t) {
    const Corners& corners = triangles_[at(t)];
    return squared_distance_to(corners.ab, corners.ac, x - corners.a);
  };
  double best = to_triangle(near);
  open[count++] = {0, 0};
  while (count > 0) {
    const Entry entry = open[--count];
    if (entry.square > best * wider) continue;
    const Node& node = nodes_[at(entry.node)];
    for (Index t = node.first; t < node.first + node.count; ++t) {
      const double square = to_triangle(t);
      if (square < best) near = t;
      best = std::min(best, square);
    }
    if (node.count > 0) continue;
    Entry first{entry.node + 1, 0}, second{node.first, 0};
    for (Entry* child : {&first, &second})
      child->square = squared_distance_to_box(nodes_[at(child->node)].min, nodes_[at(child->node)].max, x);
    if (first.square > second.square) std::swap(first, second);
    if (second.square <= best * wider) open[count++] = second;
    if (first.square <= best * wider) open[count++] = first;
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
  step_ = std::max({std::sqrt(size[1] * size[2] / static_cast<double>(triangles_.size())), 1e-4 * size[1], 1e-4 * size[2]});
  if (!(step_ > 0)) step_ = 1;
  origin_ = {bounds.min()[1], bounds.min()[2]};
  for (std::size_t a = 0; a < 2; ++a) cells_[a] = static_cast<Index>(size[static_cast<Index>(a) + 1] / step_) + 1;
  const auto for_cells = [&](const std::array<Index, 3>& t, const auto& visit) {
    std::array<Index, 2> low{}, high{};
    for (std::size_t a = 0; a < 2; ++a) {
      const auto cell = [&](Index i) {
        return std::clamp(static_cast<Index>((points_[at(i)][static_cast<Index>(a) + 1] - origin_[a]) / step_), Index{0},
                          cells_[a] - 1);
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

/// On which side of the edge from a to b the line is: +1 left, −1 right, 0 of an edge along the line. `weight`: twice the area
/// that the three enclose, with that sign. Both triangles of an edge compute the same numbers. A line through the edge counts as
/// moved by ε in y and ε² in z.
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
  const double sum = weight[0] + weight[1] + weight[2], low = std::min({a[0], b[0], c[0]}), high = std::max({a[0], b[0], c[0]});
  x = sum != 0 ? std::clamp((weight[0] * a[0] + weight[1] * b[0] + weight[2] * c[0]) / sum, low, high) : 0.5 * (low + high);
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
