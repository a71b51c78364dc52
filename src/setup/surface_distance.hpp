#pragma once
// Distances to a triangle mesh, and how often it goes around a point.

#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <vector>

#include "base/types.hpp"

namespace drench {

/// A tree of boxes around triangles. Distances are those to the nearest triangle, whatever the order in which they are
/// asked for.
class TriangleTree {
 public:
  TriangleTree(const std::vector<Vec3>& points, const std::vector<std::array<Index, 3>>& triangles);
  /// The square of the distance from x to the nearest triangle, m². `near`: a triangle that may be the nearest, and the
  /// search is short if it is; becomes one that is.
  /// Where the square is larger than `bound`, any value above that, and any triangle as `near`.
  double squared_distance(const Eigen::Vector3d& x, Index& near,
                          double bound = std::numeric_limits<double>::infinity()) const;
  /// Calls visit(t) for triangles whose boxes are no farther from x than a bound, about the nearest first. visit
  /// returns the bound from then on. All bounds are squares, m².
  template <class Visit>
  void visit_near(const Eigen::Vector3d& x, double bound, const Visit& visit) const;
  /// Which of the triangles that the tree was made of `near` or `t` is.
  Index number_of(Index near) const { return number_[static_cast<std::size_t>(near)]; }

  /// Triangles that may be the nearest of a point in a small box, for many such points.
  struct Candidates {
    std::vector<Index> triangle;
    std::array<std::vector<float>, 3> min, max;  // their boxes, as those of nodes
    std::vector<float> square;                   // to these boxes, m²: room for a search
    void clear();
  };
  /// Those that are no farther from the box than `bound`, m.
  void find_candidates(const Eigen::AlignedBox3d& box, double bound, Candidates& found) const;
  /// The same, among candidates for a larger box.
  void find_candidates(const Eigen::AlignedBox3d& box, double bound, const Candidates& among, Candidates& found) const;
  /// As the function above, among candidates for the point.
  double squared_distance(const Eigen::Vector3d& x, Candidates& candidates, Index& near) const;

 private:
  struct Corners {
    Eigen::Vector3d a, ab, ac;
  };
  static constexpr int width = 4;  // children of a node
  struct Node {  // boxes a little wider than the triangles in them, m from `center_`; an empty one is infinitely far
    std::array<Eigen::Array<float, width, 1>, 3> min, max;
    std::array<Index, static_cast<std::size_t>(width)> child;  // a node; −1 − triangle
  };
  Index build(std::vector<Index>& order, const std::vector<Eigen::Vector3d>& middle, std::size_t begin,
              std::size_t end);
  double to_triangle(const Eigen::Vector3d& x, Index t) const;
  void set_box(Node& node, int child, const std::vector<Index>& order, std::size_t begin, std::size_t end) const;

  std::vector<Corners> triangles_;
  std::vector<Index> number_;
  std::vector<Node> nodes_;
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();
  float rounding_ = 0;  // m: of a place
};

template <class Visit>
void TriangleTree::visit_near(const Eigen::Vector3d& x, double bound, const Visit& visit) const {
  constexpr float smaller = 1 - 0x1p-18F;  // than rounding can make the square of a distance to a box
  struct Entry {
    Index node;    // −1 − triangle where negative
    float square;  // to its box, at most
  };
  std::array<Entry, 64> open;  // three more a level, and each level has a quarter of the triangles: 2³² of them at 16
  std::size_t count = 0;
  const Eigen::Vector3f place = (x - center_).cast<float>();
  open[count++] = {0, 0};
  while (count > 0) {
    const Entry entry = open[--count];
    if (entry.square > bound) continue;
    if (entry.node < 0) {
      bound = visit(-1 - entry.node);
      continue;
    }
    const Node& node = nodes_[static_cast<std::size_t>(entry.node)];
    Eigen::Array<float, width, 1> square = Eigen::Array<float, width, 1>::Zero();
    for (std::size_t a = 0; a < 3; ++a) {
      const float along = place[static_cast<int>(a)];
      square += (node.min[a] - along).max(along - node.max[a]).max(0.0F).square();
    }
    // The nearest one last: it is the next.
    const std::size_t first = count;
    for (int c = 0; c < width; ++c) {
      const Entry child{node.child[static_cast<std::size_t>(c)], square[c] * smaller};
      if (child.square > bound) continue;
      std::size_t k = count++;
      for (; k > first && open[k - 1].square < child.square; --k) open[k] = open[k - 1];
      open[k] = child;
    }
  }
}

/// The winding number of a closed mesh: along a line each triangle that it goes through changes it by 1. Triangles that
/// have an edge or a point in common see a line through that alike, as if it were moved a little, always the same way.
class WindingNumber {
 public:
  WindingNumber(const std::vector<Vec3>& points, const std::vector<std::array<Index, 3>>& triangles);

  struct Crossing {
    double x = 0;    // m
    int change = 0;  // of the winding number beyond it, seen from +x
  };
  /// Where the line along x through (y, z) meets the mesh, by descending x.
  void crossings(double y, double z, std::vector<Crossing>& found) const;
  /// At a point: 1 inside a mesh that is turned outwards, 0 outside.
  int around(const Vec3& x) const;

 private:
  using Point = Eigen::Vector3d;
  /// The corners of a triangle where the line goes through it: +1 or −1 as it leaves or enters there, else 0.
  int passes(const std::array<Index, 3>& t, double y, double z, double& x) const;
  int side(const Point& a, const Point& b, double y, double z, double& weight) const;

  std::vector<Point> points_;
  std::vector<std::array<Index, 3>> triangles_;
  double step_ = 1;  // m: of the cells that list triangles by y and z
  std::array<double, 2> origin_{};
  std::array<Index, 2> cells_{};
  std::vector<Index> start_, item_;
};

}  // namespace drench
