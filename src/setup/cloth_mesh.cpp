#include "setup/cloth_mesh.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/eigen_vec.hpp"
#include "setup/cloth_bending.hpp"
#include "setup/cloth_material.hpp"
#include "setup/cloth_regions.hpp"
#include "setup/cloth_warp.hpp"
#include "setup/file_place.hpp"
#include "setup/membrane.hpp"
#include "setup/mesh_sequence.hpp"
#include "setup/placed_mesh.hpp"
#include "setup/plate.hpp"
#include "setup/setup_error.hpp"
#include "setup/sewing.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

double cotangent(const Vector3d& a, const Vector3d& b) { return a.dot(b) / a.cross(b).norm(); }

/// Pins of one cloth, on its own node numbers.
struct Pins {
  std::vector<std::uint8_t> pinned;
  std::vector<Index> entry;  // of ClothScene::pins that holds the node: the last one; −1: none
};

/// `edges` are the mesh's.
Pins pinned_nodes(const ClothScene& cloth, const PlacedMesh& placed, const std::vector<MeshEdge>& edges,
                  std::vector<std::string>& warnings) {
  const std::string label = cloth_label(cloth.name);
  const SurfaceMesh& mesh = placed.mesh;
  Pins pins{std::vector<std::uint8_t>(mesh.points.size(), cloth.dynamics ? 0 : 1),
            std::vector<Index>(mesh.points.size(), -1)};
  std::vector<std::uint8_t> held(mesh.points.size(), 0);
  for (const auto& pair : placed.weld.held) held[at(pair[0])] = held[at(pair[1])] = 1;
  Index entry = -1;
  const auto pin = [&](Index i) {
    const bool soft = cloth.pins[static_cast<std::size_t>(entry)].stiffness.has_value();
    pins.pinned[static_cast<std::size_t>(i)] = !soft || !cloth.dynamics;
    pins.entry[static_cast<std::size_t>(i)] = entry;
  };
  for (const PinScene& p : cloth.pins) {
    ++entry;
    bool any = false;
    switch (p.kind) {
      case PinScene::Kind::corners: {
        if (!cloth.grid) throw SetupError(label + ": pin: a mesh file has no corners; allowed: edges, box, nodes");
        const auto [nx, nz] = cloth.grid->nodes;
        for (const Index i : {0, nx - 1, nx * (nz - 1), nx * nz - 1}) pin(i);
        any = true;
        break;
      }
      case PinScene::Kind::edges:
        for (const MeshEdge& e : edges) {
          if (e.triangles != 1 || (held[at(e.a)] && held[at(e.b)])) continue;  // a seam is no border
          pin(e.a);
          pin(e.b);
          any = true;
        }
        break;
      case PinScene::Kind::box:
        for (std::size_t i = 0; i < mesh.points.size(); ++i) {
          if (!contains(p.box.min, p.box.max, mesh.points[i])) continue;
          pin(static_cast<Index>(i));
          any = true;
        }
        break;
      case PinScene::Kind::nodes:
        for (const Index i : p.nodes) {
          if (i < 0 || at(i) >= placed.weld.file_points()) {
            throw SetupError(
                fmt::format("{}: pin: there is no node {}; allowed: 0 to {}", label, i, placed.weld.file_points() - 1));
          }
          pin(placed.weld.node[at(i)]);
          any = true;
        }
        break;
    }
    if (!any)
      warnings.push_back(
          fmt::format("{}: pin {} selects no node: move or enlarge its box, or remove it", label, entry));
  }
  return pins;
}

/// A motion of its own for each node whose pin follows a sequence of files.
void follow_sequences(Model& model, const ClothScene& cloth, const Pins& pins, const Weld& weld) {
  const std::size_t first = model.mesh.rest_position.size() - pins.entry.size();
  std::vector<std::uint8_t>& baked = model.mesh.baked;
  const bool absorbs = any_fabric(cloth, [](const MaterialScene& f) { return f.porous; });
  const std::vector<Vec3> rest(model.mesh.rest_position.begin() + static_cast<std::ptrdiff_t>(first),
                               model.mesh.rest_position.end());
  for (std::size_t entry = 0; entry < cloth.pins.size(); ++entry) {
    const PinScene& p = cloth.pins[entry];
    if (p.sequence.files.empty()) continue;
    const auto paths =
        node_paths(p.sequence, cloth.file, model.scene.path, rest, weld, file_place(cloth), cloth_label(cloth.name));
    for (std::size_t n = 0; n < rest.size(); ++n) {
      if (pins.entry[n] != static_cast<Index>(entry)) continue;
      model.mesh.pin_motion[first + n] = static_cast<Index>(model.pin_motions.size());
      baked.resize(model.mesh.rest_position.size(), 0);
      baked[first + n] = absorbs && cloth.dynamics && model.mesh.pinned[first + n];
      PinMotion motion;
      motion.center = rest[n];
      motion.path = paths[n];
      motion.end = p.end;
      motion.release = p.release;
      model.pin_motions.push_back(std::move(motion));
    }
  }
}

/// The stiffness of a cloth's soft pins, shared out by mass. Its mesh is the last that was appended.
void set_pin_stiffness(ClothMesh& mesh, const ClothScene& cloth, const Pins& pins) {
  const std::size_t first = mesh.rest_position.size() - pins.entry.size();
  for (std::size_t entry = 0; entry < cloth.pins.size(); ++entry) {
    const PinScene& p = cloth.pins[entry];
    if (!p.stiffness) continue;
    double held = 0;  // kg
    for (std::size_t n = 0; n < pins.entry.size(); ++n)
      if (pins.entry[n] == static_cast<Index>(entry)) held += mesh.solid_mass[first + n];
    mesh.pin_stiffness.resize(mesh.rest_position.size(), 0.0);
    for (std::size_t n = 0; n < pins.entry.size(); ++n)
      if (pins.entry[n] == static_cast<Index>(entry))
        mesh.pin_stiffness[first + n] = *p.stiffness * mesh.solid_mass[first + n] / held;
  }
}

/// The motions of a cloth's pins, and which of them each node has. Its mesh is the last that was appended.
void set_pins_in_motion(Model& model, const ClothScene& cloth, const Pins& pins, const Weld& weld) {
  const auto has_motion = [](const PinScene& p) { return moves(p) || p.stiffness; };  // what stands still has X(t) = X0
  if (std::none_of(cloth.pins.begin(), cloth.pins.end(), has_motion)) return;
  std::vector<Index> motion;  // of each entry
  for (const PinScene& p : cloth.pins) {
    const bool together = has_motion(p) && p.sequence.files.empty();
    motion.push_back(together ? static_cast<Index>(model.pin_motions.size()) : -1);
    if (!together) continue;
    model.pin_motions.push_back({p.velocity,
                                 to_vec3(to_eigen(p.spin.axis).normalized()),
                                 p.spin.degrees_per_second.scaled(std::numbers::pi / 180),
                                 p.center,
                                 p.start,
                                 p.end,
                                 {},
                                 {1, 0, 0, 0},
                                 p.offset});
    model.pin_motions.back().release = p.release;
    for (std::size_t b = 0; b < model.scene.bodies.size() && !p.body.empty(); ++b)
      if (model.scene.bodies[b].name == p.body) model.pin_motions.back().body = static_cast<Index>(b);
  }
  std::vector<Index>& of_node = model.mesh.pin_motion;
  of_node.resize(model.mesh.rest_position.size() - pins.entry.size(), -1);  // cloths before this one
  for (const Index entry : pins.entry) of_node.push_back(entry < 0 ? -1 : motion[static_cast<std::size_t>(entry)]);
  follow_sequences(model, cloth, pins, weld);
  for (std::size_t n = 0; n < of_node.size(); ++n) {
    if (of_node[n] < 0) continue;
    PinMotion& m = model.pin_motions[static_cast<std::size_t>(of_node[n])];
    if (m.body >= 0) continue;  // once there are bodies
    m.reach = std::max(m.reach, (to_eigen(model.mesh.rest_position[n]) - to_eigen(m.center)).norm());
  }
}

/// k of an edge's spring, N/m (Van Gelder 1998): its triangles' parts add up, and membranes have none.
double edge_stiffness(const Patchwork& fabric, const MeshEdge& e, const std::vector<double>& area, double around,
                      double length) {
  const MaterialScene& first = fabric(e.triangle[0]);
  if (fabric.same(e)) return first.membrane ? 0 : first.stretch * around / (length * length);
  double sum = 0;
  for (const Index t : e.triangle)
    if (!fabric(t).membrane) sum += fabric(t).stretch * area[static_cast<std::size_t>(t)];
  return sum / (length * length);
}

/// Appends one cloth's mesh; the model's index of it is `cloth`. Returns its triangles' areas.
std::vector<double> append_triangles(ClothMesh& mesh, const SurfaceMesh& own, const Patchwork& fabric, Index first_node,
                                     Index cloth) {
  std::vector<double> area;
  for (const auto& t : own.triangles) {
    const std::array<Index, 3> n{first_node + t[0], first_node + t[1], first_node + t[2]};
    mesh.triangle.push_back(n);
    mesh.triangle_cloth.push_back(cloth);
    const auto& x = mesh.rest_position;
    area.push_back(triangle_area(x[static_cast<std::size_t>(n[0])], x[static_cast<std::size_t>(n[1])],
                                 x[static_cast<std::size_t>(n[2])]));
    const double density = fabric(static_cast<Index>(area.size()) - 1).areal_density;
    for (const Index i : n) mesh.solid_mass[static_cast<std::size_t>(i)] += density * area.back() / 3;
  }
  return area;
}

void append(ClothMesh& mesh, const SurfaceMesh& own, const ClothScene& scene, const Patchwork& fabric,
            const std::vector<MeshEdge>& edges, const std::vector<std::uint8_t>& pinned, Index cloth) {
  const Index first_node = mesh.nodes();
  mesh.rest_position.insert(mesh.rest_position.end(), own.points.begin(), own.points.end());
  mesh.pinned.insert(mesh.pinned.end(), pinned.begin(), pinned.end());
  mesh.node_cloth.insert(mesh.node_cloth.end(), own.points.size(), cloth);
  mesh.solid_mass.resize(mesh.rest_position.size(), 0.0);
  const std::vector<double> area = append_triangles(mesh, own, fabric, first_node, cloth);
  const auto position = [&](Index i) -> const Vec3& { return mesh.rest_position[static_cast<std::size_t>(i)]; };
  for (const MeshEdge& e : edges) {
    const Index a = first_node + e.a, b = first_node + e.b;
    double around = 0;  // A0 + A1
    for (int s = 0; s < e.triangles; ++s) around += area[static_cast<std::size_t>(e.triangle[s])];
    const double length = (to_eigen(position(b)) - to_eigen(position(a))).norm();
    mesh.edge.push_back({a, b});
    mesh.edge_length.push_back(length);
    mesh.edge_stiffness.push_back(edge_stiffness(fabric, e, area, around, length));
    if (e.triangles != 2 || scene.grid || scene.material.bending) continue;
    const Index c = first_node + e.opposite[0], d = first_node + e.opposite[1];
    mesh.hinge.push_back({a, b, c, d});
    mesh.hinge_weight.push_back(hinge_cotangents(position(a), position(b), position(c), position(d)));
    mesh.hinge_stiffness.push_back(hinge_stiffness(fabric, e, area, around));
  }
  if (scene.grid && !scene.material.bending) add_grid_bending(mesh, *scene.grid, fabric, first_node);
}

void add_plate(ClothMesh& mesh, const std::vector<PlatePair>& pairs, Index first_node) {
  for (const PlatePair& p : pairs) {
    mesh.plate_pair.push_back({first_node + p.first, first_node + p.second});
    mesh.plate_weight.push_back(p.weight);
  }
}

}  // namespace

std::string cloth_label(const std::string& name) { return "cloth '" + name + "'"; }

Rows rows_of(Index nodes, const std::vector<std::array<Index, 2>>& entries) {
  Rows rows;
  rows.start.assign(static_cast<std::size_t>(nodes) + 1, 0);
  for (const auto& [node, item] : entries) ++rows.start[static_cast<std::size_t>(node) + 1];
  for (std::size_t i = 1; i < rows.start.size(); ++i) rows.start[i] += rows.start[i - 1];
  std::vector<Index> next(rows.start.begin(), rows.start.end() - 1);
  rows.item.resize(entries.size());
  for (const auto& [node, item] : entries)
    rows.item[static_cast<std::size_t>(next[static_cast<std::size_t>(node)]++)] = item;
  return rows;
}

SurfaceMesh grid_mesh(const GridScene& grid) {
  const auto [nx, nz] = grid.nodes;
  SurfaceMesh mesh;
  for (int j = 0; j < nz; ++j) {
    for (int i = 0; i < nx; ++i) {
      mesh.points.push_back({grid.size[0] * (static_cast<double>(i) / (nx - 1) - 0.5), 0,
                             grid.size[1] * (static_cast<double>(j) / (nz - 1) - 0.5)});
    }
  }
  for (int j = 0; j + 1 < nz; ++j) {
    for (int i = 0; i + 1 < nx; ++i) {
      const Index a = i + j * nx, b = a + 1, c = a + nx, d = c + 1;  // a b at z, c d at z + Δz
      if ((i + j) % 2 == 0) {
        mesh.triangles.push_back({a, c, d});
        mesh.triangles.push_back({a, d, b});
      } else {
        mesh.triangles.push_back({a, c, b});
        mesh.triangles.push_back({b, c, d});
      }
    }
  }
  return mesh;
}

std::array<double, 4> hinge_cotangents(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3) {
  const Vector3d a = to_eigen(x0), b = to_eigen(x1), c = to_eigen(x2), d = to_eigen(x3);
  const double c01 = cotangent(b - a, c - a), c02 = cotangent(b - a, d - a);  // angles at x0
  const double c03 = cotangent(a - b, c - b), c04 = cotangent(a - b, d - b);  // angles at x1
  return {c03 + c04, c01 + c02, -(c01 + c03), -(c02 + c04)};
}

namespace {

/// node → its springs, stitches after the edges, and its hinges.
void list_constraints(ClothMesh& mesh) {
  std::vector<std::array<Index, 2>> entries;
  Index number = 0;
  for (const auto* springs : {&mesh.edge, &mesh.stitch})
    for (const auto& ends : *springs) {
      for (const Index n : ends) entries.push_back({n, number});
      ++number;
    }
  mesh.node_edges = rows_of(mesh.nodes(), entries);
  entries.clear();
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    for (int c = 0; c < 4; ++c) entries.push_back({mesh.hinge[h][c], static_cast<Index>(4 * h) + c});
  }
  mesh.node_hinges = rows_of(mesh.nodes(), entries);
}

/// Appends one cloth to the model, and its triangles' warp to `warp`.
void build_cloth(const ClothScene& c, Model& model, std::vector<std::vector<std::array<double, 2>>>& warp,
                 SetupLines& lines) {
  ClothMesh& mesh = model.mesh;
  const std::string key = fmt::format("cloth.{}", model.cloths.size());
  const PlacedMesh placed = blaming(key + ".mesh", [&] { return placed_mesh(c, model.scene.path, lines); });
  const SurfaceMesh& own = placed.mesh;
  if (!own.left_out.empty()) lines.warnings.push_back(cloth_label(c.name) + ": " + own.left_out);
  const auto edges = mesh_edges(own.triangles);
  const Patchwork fabric(c, own, key);
  ClothMaterial material = resolve_material(c, c.material, model.scene.processes);
  material.first_node = mesh.nodes();
  material.node_count = static_cast<Index>(own.points.size());
  material.first_triangle = mesh.triangles();
  material.triangle_count = static_cast<Index>(own.triangles.size());
  const Pins pins = blaming(key + ".pin", [&] { return pinned_nodes(c, placed, edges, lines.warnings); });
  append(mesh, own, c, fabric, edges, pins.pinned, static_cast<Index>(model.cloths.size()));
  std::size_t unneeded = 0;
  const auto sewn = sewn_pairs(c, own, placed.weld, key, unneeded);
  append_stitches(mesh, c, own, fabric, sewn, placed.weld, material.first_node);
  if (!sewn.empty())
    lines.notes.push_back(
        fmt::format("{}: sew: {} stitches close in {} s", cloth_label(c.name), sewn.size(), c.sew_time));
  if (unneeded > 0)
    lines.notes.push_back(fmt::format(
        "{}: sew: {} of points {} no stitch: they are one node already or have a common edge", cloth_label(c.name),
        unneeded == 1 ? "1 pair" : fmt::format("{} pairs", unneeded), unneeded == 1 ? "gets" : "get"));
  append_patches(model, c, fabric);
  if (needs_warp(c)) blaming(key + ".warp", [&] { append_warp(mesh, own, c, fabric, rotation_of(c)); });
  warp.emplace_back();
  if (needs_warp(c))
    warp.back() = warp_in_triangles(mesh, own);
  else if (c.material.bending)  // alike in all directions
    warp.back().assign(own.triangles.size(), {1, 0});
  if (c.material.bending)
    add_plate(mesh,
              plate_pairs(
                  own, edges, [&](Index t) { return *fabric(t).bending; }, warp.back()),
              material.first_node);
  blaming(key + ".pin", [&] { set_pins_in_motion(model, c, pins, placed.weld); });
  set_pin_stiffness(mesh, c, pins);
  mesh.pin_entry.insert(mesh.pin_entry.end(), pins.entry.begin(), pins.entry.end());
  model.cloths.push_back(material);
}

}  // namespace

void build_cloths(const Scene& scene, Model& model, SetupLines& lines) {
  ClothMesh& mesh = model.mesh;
  std::vector<std::vector<std::array<double, 2>>> warp;  // of each cloth's triangles; empty: it has no use for it
  for (const ClothScene& c : scene.cloths) build_cloth(c, model, warp, lines);
  if (!mesh.triangle_warp.empty()) mesh.triangle_warp.resize(mesh.triangle.size(), Vec3{0, 0, 0});
  if (model.has_moving_pins()) mesh.pin_motion.resize(mesh.rest_position.size(), -1);
  if (model.has_soft_pins()) mesh.pin_stiffness.resize(mesh.rest_position.size(), 0.0);
  if (model.cloths.empty()) return;
  set_triangle_stiffness(model, warp);
  join_nodes(mesh);
  list_constraints(mesh);
}

double mean_edge_length(const Model& model) {
  double sum = 0, count = 0;
  for (std::size_t e = 0; e < model.mesh.edge.size(); ++e) {
    const Index cloth = model.mesh.node_cloth[static_cast<std::size_t>(model.mesh.edge[e][0])];
    if (model.has_porous() && !model.cloths[static_cast<std::size_t>(cloth)].porous) continue;
    sum += model.mesh.edge_length[e];
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace drench
