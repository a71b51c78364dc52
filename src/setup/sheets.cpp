#include "setup/sheets.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "base/eigen_vec.hpp"
#include "setup/mesh_joins.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

void omit_repeated(SurfaceMesh& mesh, SheetSplit& split) {
  const std::size_t count = mesh.triangles.size();
  std::vector<std::array<Index, 3>> sorted = mesh.triangles;
  for (auto& t : sorted) std::sort(t.begin(), t.end());
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t l, std::size_t r) { return sorted[l] < sorted[r]; });
  std::vector<Index> number(count, 0);  // of each triangle that stays; −1: omitted
  for (std::size_t k = 1; k < count; ++k)
    if (sorted[order[k]] == sorted[order[k - 1]]) number[order[k]] = -1;
  Index kept = 0;
  for (std::size_t t = 0; t < count; ++t) {
    if (number[t] < 0) {
      if (split.repeated++ == 0) split.first_repeated = mesh.triangles[t];
      continue;
    }
    number[t] = kept;
    mesh.triangles[at(kept)] = mesh.triangles[t];
    if (!mesh.texture.empty()) mesh.texture[at(kept)] = mesh.texture[t];
    ++kept;
  }
  if (split.repeated == 0) return;
  mesh.triangles.resize(at(kept));
  if (!mesh.texture.empty()) mesh.texture.resize(at(kept));
  for (auto& [name, triangles] : mesh.groups) {
    std::erase_if(triangles, [&](Index t) { return number[at(t)] < 0; });
    for (Index& t : triangles) t = number[at(t)];
  }
}

/// Pairs the half-edges of one edge, those first whose triangles are most nearly in one plane.
void pair_flattest(const SurfaceMesh& mesh, const HalfEdges& sides, const std::vector<Index>& edge,
                   std::vector<Index>& partner) {
  const Vector3d a = to_eigen(mesh.points[at(sides.from(at(edge[0])))]),
                 along = (to_eigen(mesh.points[at(sides.to(at(edge[0])))]) - a).normalized();
  std::vector<Vector3d> out;  // across the edge, into each triangle
  for (const Index h : edge) {
    const Vector3d to = to_eigen(mesh.points[at(sides.opposite(at(h)))]) - a;
    out.push_back((to - along * along.dot(to)).normalized());
  }
  struct Pair {
    double cosine;
    std::size_t first, second;
  };
  std::vector<Pair> pairs;
  for (std::size_t k = 0; k < edge.size(); ++k)
    for (std::size_t l = k + 1; l < edge.size(); ++l) pairs.push_back({out[k].dot(out[l]), k, l});
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& l, const Pair& r) { return l.cosine < r.cosine; });
  for (const Pair& p : pairs) {
    const Index g = edge[p.first], h = edge[p.second];
    if (partner[at(g)] >= 0 || partner[at(h)] >= 0) continue;
    partner[at(g)] = h;
    partner[at(h)] = g;
  }
}

/// The points of triangles that are joined across half-edges.
JoinedMesh joined(const SurfaceMesh& mesh, const std::vector<Index>& partner) {
  std::vector<Index> place(mesh.points.size());
  std::iota(place.begin(), place.end(), Index{0});
  return join(mesh.triangles, place, partner);
}

/// The triangles with copies of crowded points, which `split` lists. Other points stay whole, also where two fans of
/// triangles meet in one of them.
std::vector<std::array<Index, 3>> separated(const SurfaceMesh& mesh, const JoinedMesh& joined,
                                            const std::vector<bool>& crowded, SheetSplit& split) {
  split.copy_of.clear();
  split.held.clear();
  std::vector<Index> number(joined.source.size());
  for (std::size_t k = 0; k < joined.source.size(); ++k) {
    const Index point = joined.source[k];
    number[k] = point;
    if (k == 0 || joined.source[k - 1] != point || !crowded[at(point)]) continue;
    number[k] = static_cast<Index>(mesh.points.size() + split.copy_of.size());
    split.copy_of.push_back(point);
    split.held.push_back({point, number[k]});
  }
  std::vector<std::array<Index, 3>> triangles = joined.triangles;
  for (auto& t : triangles)
    for (Index& n : t) n = number[at(n)];
  return triangles;
}

/// Ends the joins of triangles that still crowd an edge, but for the join across it. False if there are none.
bool cut_loose(const SurfaceMesh& mesh, const std::vector<std::array<Index, 3>>& triangles,
               std::vector<Index>& partner) {
  std::vector<Index> place(mesh.points.size() + 3 * triangles.size());
  std::iota(place.begin(), place.end(), Index{0});
  bool any = false;
  for (const std::vector<Index>& edge : edges_by_place(HalfEdges{triangles}, place)) {
    if (edge.size() <= 2) continue;
    any = true;
    const auto paired = std::find_if(edge.begin(), edge.end(), [&](Index h) { return partner[at(h)] >= 0; });
    const Index first = paired == edge.end() ? edge[0] : *paired, second = partner[at(first)];
    for (const Index h : edge) {
      if (h == first || h == second) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t g = 3 * (at(h) / 3) + c;
        if (static_cast<Index>(g) == h || partner[g] < 0) continue;
        partner[at(partner[g])] = -1;
        partner[g] = -1;
      }
    }
  }
  return any;
}

}  // namespace

std::string SheetSplit::text() const {
  std::string line;
  if (repeated > 0)
    line = fmt::format(
        "triangles of the mesh that repeat an earlier one are omitted: {}, the first with points {}, {}, {}", repeated,
        first_repeated[0], first_repeated[1], first_repeated[2]);
  if (edges > 0)
    line += fmt::format(
        "{}edges of the mesh with more than two triangles: {}; the sheets there are held together by "
        "stitches ({}) and bend freely against each other",
        repeated > 0 ? "; " : "", edges, held.size());
  return line;
}

SheetSplit split_sheets(SurfaceMesh& mesh) {
  SheetSplit split;
  omit_repeated(mesh, split);
  std::vector<Index> place(mesh.points.size());
  std::iota(place.begin(), place.end(), Index{0});
  const HalfEdges sides{mesh.triangles};
  std::vector<Index> partner(sides.count(), -1);  // of each half-edge the one on the other side
  std::vector<bool> crowded(mesh.points.size(), false);
  for (const std::vector<Index>& edge : edges_by_place(sides, place)) {
    if (edge.size() == 2) {
      partner[at(edge[0])] = edge[1];
      partner[at(edge[1])] = edge[0];
    } else if (edge.size() > 2) {
      ++split.edges;
      pair_flattest(mesh, sides, edge, partner);
      crowded[at(sides.from(at(edge[0])))] = crowded[at(sides.to(at(edge[0])))] = true;
    }
  }
  if (split.edges == 0) return split;
  // Where fans of triangles go from sheet to sheet about both ends of an edge, it is as crowded as before: the
  // triangles beyond the first two are then cut loose from their other neighbours too.
  std::vector<std::array<Index, 3>> triangles;
  do triangles = separated(mesh, joined(mesh, partner), crowded, split);
  while (cut_loose(mesh, triangles, partner));
  for (const Index point : split.copy_of) mesh.points.push_back(mesh.points[at(point)]);
  mesh.triangles = std::move(triangles);
  return split;
}

}  // namespace drench
