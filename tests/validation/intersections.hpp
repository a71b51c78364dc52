#pragma once
// Where cloth passes through cloth.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench::test {

using Vector80 = Eigen::Matrix<long double, 3, 1>;

inline Vector80 vec80(const Vec3& v) { return {v[0], v[1], v[2]}; }

/// Six times the signed volume of a tetrahedron. The nodes' coordinates are floats or doubles, so that in long double its
/// sign is wrong only within some 1e-19 of the size cubed.
inline long double volume(const Vector80& a, const Vector80& b, const Vector80& c, const Vector80& d) {
  return (b - a).cross(c - a).dot(d - a);
}

/// Does the segment p q pass through the triangle? It does where p and q lie on different sides and the line has the three
/// edges on one side.
inline bool passes_through(const Vector80& p, const Vector80& q, const std::array<Vector80, 3>& t) {
  const long double from = volume(t[0], t[1], t[2], p), to = volume(t[0], t[1], t[2], q);
  if ((from > 0) == (to > 0)) return false;
  const bool a = volume(p, q, t[0], t[1]) > 0, b = volume(p, q, t[1], t[2]) > 0, c = volume(p, q, t[2], t[0]) > 0;
  return a == b && b == c;
}

/// Pairs of an edge and a triangle without a common node that intersect: as two triangles meet, an edge of one passes
/// through the other. Exhaustive but for boxes that do not overlap.
inline int intersections(const Model& m, const HostState& s) {
  struct Item {
    std::array<double, 3> lo, hi;
  };
  const auto box = [&](const auto& nodes) {
    Item item{{1e9, 1e9, 1e9}, {-1e9, -1e9, -1e9}};
    for (const Index n : nodes) {
      for (std::size_t a = 0; a < 3; ++a) {
        const double x = s.node_position[static_cast<std::size_t>(n)][a];
        item.lo[a] = std::min(item.lo[a], x);
        item.hi[a] = std::max(item.hi[a], x);
      }
    }
    return item;
  };
  std::vector<Item> edges;
  for (const auto& e : m.mesh.edge) edges.push_back(box(e));
  const auto at = [&](Index n) { return vec80(s.node_position[static_cast<std::size_t>(n)]); };
  int found = 0;
  for (const auto& t : m.mesh.triangle) {
    const Item own = box(t);
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const Item& other = edges[k];
      if (own.lo[0] > other.hi[0] || other.lo[0] > own.hi[0] || own.lo[1] > other.hi[1] || other.lo[1] > own.hi[1] ||
          own.lo[2] > other.hi[2] || other.lo[2] > own.hi[2])
        continue;
      const auto& e = m.mesh.edge[k];
      if (std::count(t.begin(), t.end(), e[0]) + std::count(t.begin(), t.end(), e[1]) > 0) continue;
      found += passes_through(at(e[0]), at(e[1]), {at(t[0]), at(t[1]), at(t[2])});
    }
  }
  return found;
}

}  // namespace drench::test
