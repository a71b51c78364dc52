#include "setup/mesh_joins.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/eigen_vec.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

/// Pairs the half-edges of one edge that enclose solid between them: going about the edge, one of them begins it and
/// the next ends it.
void pair_by_angle(const std::vector<Vec3>& points, const HalfEdges& sides, const std::vector<Index>& place,
                   const std::vector<Index>& edge, std::vector<Index>& partner) {
  const Index a = std::min(place[at(sides.from(at(edge[0])))], place[at(sides.to(at(edge[0])))]),
              b = std::max(place[at(sides.from(at(edge[0])))], place[at(sides.to(at(edge[0])))]);
  const Vector3d along = (to_eigen(points[at(b)]) - to_eigen(points[at(a)])).normalized();
  int smallest = 0;
  along.cwiseAbs().minCoeff(&smallest);
  const Vector3d u = along.cross(Vector3d::Unit(smallest)).normalized(), v = along.cross(u);
  struct Side {
    double angle;
    bool begins;  // solid lies at larger angles
    Index half_edge;
  };
  std::vector<Side> around;
  for (const Index h : edge) {
    const Vector3d out = to_eigen(points[at(place[at(sides.opposite(at(h)))])]) - to_eigen(points[at(a)]);
    around.push_back({std::atan2(out.dot(v), out.dot(u)), place[at(sides.from(at(h)))] != a, h});
  }
  // Solids that touch along a face: one ends where the other begins.
  std::sort(around.begin(), around.end(), [](const Side& l, const Side& r) {
    return std::array<double, 3>{l.angle, l.begins ? 1.0 : 0.0, double(l.half_edge)} <
           std::array<double, 3>{r.angle, r.begins ? 1.0 : 0.0, double(r.half_edge)};
  });
  std::vector<Index> open;
  for (std::size_t k = 0; k < 2 * around.size(); ++k) {  // twice about the edge: the first angle is one of many
    const Side& s = around[k % around.size()];
    if (partner[at(s.half_edge)] >= 0) continue;
    if (s.begins) {
      if (k < around.size()) open.push_back(s.half_edge);
    } else if (!open.empty()) {
      partner[at(s.half_edge)] = open.back();
      partner[at(open.back())] = s.half_edge;
      open.pop_back();
    }
  }
}

}  // namespace

std::vector<Index> first_copies(const std::vector<Vec3>& points) {
  std::vector<Index> order(points.size()), first(points.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::sort(order.begin(), order.end(), [&](Index l, Index r) {
    return points[at(l)] < points[at(r)] || (!(points[at(r)] < points[at(l)]) && l < r);
  });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool copy = k > 0 && points[at(order[k])] == points[at(order[k - 1])];
    first[at(order[k])] = copy ? first[at(order[k - 1])] : order[k];
  }
  return first;
}

std::vector<std::vector<Index>> edges_by_place(const HalfEdges& sides, const std::vector<Index>& place) {
  struct Side {
    Index low, high, half_edge;
    bool operator<(const Side& o) const {
      return std::array{low, high, half_edge} < std::array{o.low, o.high, o.half_edge};
    }
  };
  std::vector<Side> all;
  all.reserve(sides.count());
  for (std::size_t h = 0; h < sides.count(); ++h) {
    const Index a = place[at(sides.from(h))], b = place[at(sides.to(h))];
    all.push_back({std::min(a, b), std::max(a, b), static_cast<Index>(h)});
  }
  std::sort(all.begin(), all.end());
  std::vector<std::vector<Index>> edges;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (k == 0 || all[k].low != all[k - 1].low || all[k].high != all[k - 1].high) edges.emplace_back();
    edges.back().push_back(all[k].half_edge);
  }
  return edges;
}

std::vector<Index> partners(const std::vector<Vec3>& points, const std::vector<std::array<Index, 3>>& triangles,
                            const std::vector<Index>& place, Branches branches) {
  const HalfEdges sides{triangles};
  std::vector<Index> partner(sides.count(), -1);
  const auto join_two = [&](Index g, Index h) {
    partner[at(g)] = h;
    partner[at(h)] = g;
  };
  for (std::vector<Index>& edge : edges_by_place(sides, place)) {
    if (edge.size() > 2) {
      const auto ends = [&](Index h) {
        return std::array{std::min(sides.from(at(h)), sides.to(at(h))), std::max(sides.from(at(h)), sides.to(at(h))),
                          h};
      };
      std::sort(edge.begin(), edge.end(), [&](Index l, Index r) { return ends(l) < ends(r); });
      const auto same = [&](Index l, Index r) { return ends(l)[0] == ends(r)[0] && ends(l)[1] == ends(r)[1]; };
      std::vector<Index> rest;
      for (std::size_t k = 0; k < edge.size();) {
        std::size_t end = k + 1;
        while (end < edge.size() && same(edge[k], edge[end])) ++end;
        if (end == k + 2)
          join_two(edge[k], edge[k + 1]);
        else
          rest.insert(rest.end(), edge.begin() + static_cast<std::ptrdiff_t>(k),
                      edge.begin() + static_cast<std::ptrdiff_t>(end));
        k = end;
      }
      edge = rest;
    }
    if (edge.size() == 2)
      join_two(edge[0], edge[1]);
    else if (edge.size() > 2 && branches == Branches::pair)
      pair_by_angle(points, sides, place, edge, partner);
  }
  return partner;
}

JoinedMesh join(const std::vector<std::array<Index, 3>>& triangles, const std::vector<Index>& place,
                const std::vector<Index>& partner) {
  const HalfEdges sides{triangles};
  std::vector<std::size_t> parent(sides.count());  // of corners
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t c) {
    while (parent[c] != c) c = parent[c] = parent[parent[c]];
    return c;
  };
  const auto unite = [&](std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    parent[std::max(a, b)] = std::min(a, b);
  };
  const auto next = [](std::size_t h) { return 3 * (h / 3) + (h + 1) % 3; };
  for (std::size_t h = 0; h < sides.count(); ++h) {
    if (partner[h] < static_cast<Index>(h)) continue;
    const std::size_t g = at(partner[h]);
    const bool turned_alike = place[at(sides.from(h))] == place[at(sides.to(g))];
    unite(h, turned_alike ? next(g) : g);
    unite(next(h), turned_alike ? g : next(g));
  }
  std::vector<Index> lowest(sides.count(), -1);  // of a class of corners: its first old point
  for (std::size_t c = 0; c < sides.count(); ++c) {
    Index& of_class = lowest[root(c)];
    if (of_class < 0 || sides.from(c) < of_class) of_class = sides.from(c);
  }
  std::vector<std::array<Index, 2>> classes;
  for (std::size_t c = 0; c < sides.count(); ++c)
    if (root(c) == c) classes.push_back({lowest[c], static_cast<Index>(c)});
  std::sort(classes.begin(), classes.end());
  std::vector<Index> number(sides.count(), -1);
  JoinedMesh mesh;
  for (const auto& [source, corner] : classes) {
    number[at(corner)] = static_cast<Index>(mesh.source.size());
    mesh.source.push_back(source);
  }
  for (std::size_t t = 0; t < triangles.size(); ++t)
    mesh.triangles.push_back({number[root(3 * t)], number[root(3 * t + 1)], number[root(3 * t + 2)]});
  return mesh;
}

}  // namespace drench
