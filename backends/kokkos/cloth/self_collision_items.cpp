// Clusters of stage self_collision: what lies together on the cloth at rest lies together later, too.

#include "cloth/self_collision_items.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/host_copy.hpp"
#include "core/z_curve.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr Index width = CollisionItems::width, group = width * width;

/// Of one sort, in the order of the mesh.
struct Sort {
  std::vector<Index> corner;  // 3 each
  std::vector<Index> rank;
  std::vector<Vec3> middle;  // at rest, m
  std::vector<Index> cloth;

  Index count() const { return static_cast<Index>(rank.size()); }
  void add(const ClothMesh& mesh, Index number, std::initializer_list<Index> nodes) {
    Vec3 sum{0, 0, 0};
    for (const Index n : nodes)
      for (std::size_t a = 0; a < 3; ++a)
        sum[a] += mesh.rest_position[static_cast<std::size_t>(n)][a] / static_cast<double>(nodes.size());
    corner.insert(corner.end(), nodes);
    corner.insert(corner.end(), 3 - nodes.size(), -1);
    rank.push_back(number);
    middle.push_back(sum);
    cloth.push_back(mesh.node_cloth[static_cast<std::size_t>(*nodes.begin())]);
  }
};

/// Appends a sort, filled up to whole groups.
void append(const Sort& sort, double cell, std::vector<Index>& corner, std::vector<Index>& rank) {
  for (const Index i : along_z_curve(sort.middle, sort.cloth, cell)) {
    for (Index k = 0; k < 3; ++k) corner.push_back(sort.corner[static_cast<std::size_t>(3 * i + k)]);
    rank.push_back(sort.rank[static_cast<std::size_t>(i)]);
  }
  while (rank.size() % group != 0) {
    corner.insert(corner.end(), 3, -1);
    rank.push_back(-1);
  }
}

/// Nodes with triangles, and edges with edges.
std::vector<Couple> pairs_of_groups(const CollisionItems& items) {
  std::vector<Couple> pairs;
  const Index triangles = items.first_triangle / group, edges = items.first_edge / group;
  for (Index a = 0; a < triangles; ++a)
    for (Index b = triangles; b < edges; ++b) pairs.push_back({a, b});
  for (Index a = edges; a < items.groups(); ++a)
    for (Index b = a; b < items.groups(); ++b) pairs.push_back({a, b});
  return pairs;
}

/// The least node of each connected piece, at all of its nodes.
std::vector<Index> pieces_of(const ClothMesh& mesh) {
  std::vector<Index> least(static_cast<std::size_t>(mesh.nodes()));
  std::iota(least.begin(), least.end(), Index{0});
  const auto root = [&](Index n) {
    while (least[static_cast<std::size_t>(n)] != n) {
      Index& next = least[static_cast<std::size_t>(n)];
      n = next = least[static_cast<std::size_t>(next)];
    }
    return n;
  };
  for (const auto& t : mesh.triangle)
    for (const Index n : {t[1], t[2]}) {
      const Index a = root(t[0]), b = root(n);
      least[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  for (Index n = 0; n < mesh.nodes(); ++n) least[static_cast<std::size_t>(n)] = root(n);
  return least;
}

/// SelfCollisionWork::around.
void list_corners_around(const ClothMesh& mesh, SelfCollisionWork& work) {
  std::vector<Index> start(static_cast<std::size_t>(mesh.nodes()) + 1, 0);
  for (const auto& t : mesh.triangle)
    for (const Index n : t) ++start[static_cast<std::size_t>(n) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<Index> at(start.begin(), start.end() - 1), around(6 * mesh.triangle.size());
  for (const auto& t : mesh.triangle)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto row = static_cast<std::size_t>(at[static_cast<std::size_t>(t[k])]++);
      around[2 * row] = t[(k + 1) % 3];
      around[2 * row + 1] = t[(k + 2) % 3];
    }
  work.around_start = to_device<Index>("drench::self_collision::around_start", start);
  work.around = to_device<Index>("drench::self_collision::around", around);
}

double whole_groups(double items) { return group * std::ceil(items / group); }

}  // namespace

void list_items(const Constants& constants, SelfCollisionWork& work) {
  const ClothMesh& mesh = constants.model.mesh;
  std::vector<std::uint8_t> member;
  for (Index n = 0; n < mesh.nodes(); ++n) {
    const auto cloth = static_cast<std::size_t>(mesh.node_cloth[static_cast<std::size_t>(n)]);
    member.push_back(constants.model.cloths[cloth].self_collision ? 1 : 0);
  }
  const auto takes_part = [&](Index node) { return member[static_cast<std::size_t>(node)] != 0; };
  Sort nodes, triangles, edges;
  for (Index n = 0; n < mesh.nodes(); ++n)
    if (takes_part(n)) nodes.add(mesh, n, {n});
  Index number = 0;
  for (const auto& t : mesh.triangle) {
    if (takes_part(t[0])) triangles.add(mesh, number, {t[0], t[1], t[2]});
    ++number;
  }
  number = 0;
  double length = 0;
  for (const auto& e : mesh.edge) {
    if (takes_part(e[0])) edges.add(mesh, number, {e[0], e[1]});
    ++number;
    const Vec3 &a = mesh.rest_position[static_cast<std::size_t>(e[0])],
               &b = mesh.rest_position[static_cast<std::size_t>(e[1])];
    length += std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]) / static_cast<double>(mesh.edge.size());
  }
  constants.model.for_materials([&](const ClothMaterial& c) {
    if (c.self_collision) work.thickness = std::max(work.thickness, static_cast<double>(c.thickness));
  });
  CollisionItems& items = work.items;
  std::vector<Index> corner, rank;
  append(nodes, length, corner, rank);
  items.first_triangle = static_cast<Index>(rank.size());
  append(triangles, length, corner, rank);
  items.first_edge = static_cast<Index>(rank.size());
  append(edges, length, corner, rank);
  items.count = static_cast<Index>(rank.size());
  work.nodes = nodes.count();
  work.piece = to_device<Index>("drench::self_collision::piece", pieces_of(mesh));
  list_corners_around(mesh, work);
  work.member = to_device<std::uint8_t>("drench::self_collision::member", member);
  items.corner = to_device<Index>("drench::self_collision::corner", corner);
  items.rank = to_device<Index>("drench::self_collision::rank", rank);
  items.group_pair = to_device<Couple>("drench::self_collision::group_pair", pairs_of_groups(items));
  make_room(items.box, "drench::self_collision::box",
            static_cast<std::size_t>(items.count + items.clusters() + items.groups()));
}

double item_bytes(const Sizing& s) {
  const double nodes = whole_groups(s.size.nodes), triangles = whole_groups(s.size.triangles),
               edges = whole_groups(s.size.edges);
  const double items = nodes + triangles + edges, boxes = items + items / width + items / group;
  const double pairs = nodes / group * triangles / group + edges / group * (edges / group + 1) / 2;
  const double corners = 2 * s.size.nodes + 6 * s.size.triangles;  // piece, around_start, around
  return (items * 4 + corners) * index_bytes + boxes * 8 * s.real + pairs * 2 * index_bytes;
}

}  // namespace drench::kokkos_backend
