#include "setup/placed_mesh.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "base/eigen_vec.hpp"
#include "setup/cloth_material.hpp"
#include "setup/cloth_regions.hpp"
#include "setup/cloth_warp.hpp"
#include "setup/file_place.hpp"
#include "setup/mesh_clean.hpp"
#include "setup/mesh_guess.hpp"
#include "setup/mesh_io.hpp"
#include "setup/setup_error.hpp"
#include "setup/sheets.hpp"

namespace drench {
namespace {

std::vector<Index> own_numbers(const SurfaceMesh& mesh) {
  std::vector<Index> numbers(mesh.points.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

void sort_once(std::vector<std::array<Index, 2>>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

/// Separates sheets that share an edge, and sews seams of doubled points.
void sew_sheets(PlacedMesh& placed, const ClothScene& cloth, SetupLines& lines) {
  SurfaceMesh& mesh = placed.mesh;
  Weld& weld = placed.weld;
  SheetSplit split = split_sheets(mesh);
  if (split.found()) lines.warnings.push_back(cloth_label(cloth.name) + ": " + split.text());
  if (cloth.weld != 0) {
    weld = weld_boundary(mesh, cloth.weld, split.copy_of);
    if (weld.found()) lines.notes.push_back(cloth_label(cloth.name) + ": " + weld.text());
  } else {
    weld.node = own_numbers(mesh);
  }
  for (const auto& [a, b] : split.held) {
    const Index n = weld.node[at(a)], m = weld.node[at(b)];
    if (n != m) weld.held.push_back({std::min(n, m), std::max(n, m)});
  }
  sort_once(weld.held);
  weld.copy_of = std::move(split.copy_of);
}

/// A node has the place of its first point.
void find_places(const SurfaceMesh& mesh, Weld& weld) {
  weld.place_of.assign(mesh.points.size(), -1);
  for (std::size_t p = 0; p < weld.node.size(); ++p) {
    Index& place = weld.place_of[at(weld.node[p])];
    if (place < 0) place = p < weld.file_points() ? static_cast<Index>(p) : weld.copy_of[p - weld.file_points()];
  }
}

/// Removes slivers, and renumbers the nodes of the file's points and of the stitches.
void clean(PlacedMesh& placed, const ClothScene& cloth, SetupLines& lines) {
  const MeshCleaning cleaning = clean_mesh(placed.mesh, cloth.clean);
  if (!cleaning.found()) return;
  lines.notes.push_back(cloth_label(cloth.name) + ": " + cleaning.text());
  const auto now = [&](Index n) { return cleaning.node[at(n)]; };
  for (Index& n : placed.weld.node) n = now(n);
  auto& held = placed.weld.held;
  for (auto& [a, b] : held) std::tie(a, b) = std::minmax({now(a), now(b)});
  std::erase_if(held, [](const auto& pair) { return pair[0] == pair[1]; });
  sort_once(held);
  std::vector<Index> place_of;
  for (const Index n : cleaning.kept) place_of.push_back(placed.weld.place_of[at(n)]);
  placed.weld.place_of = std::move(place_of);
}

}  // namespace

Eigen::Matrix3d rotation_of(const ClothScene& cloth) {
  try {
    return rotation_about(cloth.rotate_axis, cloth.rotate_degrees);
  } catch (const SetupError& e) {
    throw SetupError(cloth_label(cloth.name) + ": " + e.what());
  }
}

PlacedMesh placed_mesh(const ClothScene& cloth, const std::string& scene_path, SetupLines& lines) {
  const std::string label = cloth_label(cloth.name);
  PlacedMesh placed;
  SurfaceMesh& mesh = placed.mesh;
  if (cloth.grid) {
    if (cloth.grid->nodes[0] < 2 || cloth.grid->nodes[1] < 2)
      throw SetupError(label + ": a grid needs at least 2 nodes in each direction");
    mesh = grid_mesh(*cloth.grid);
  } else {
    mesh = read_mesh(
        cloth.file, scene_path,
        {.texture = takes_warp_of_file(cloth), .groups = needs_groups(cloth), .attributes = painted_attributes(cloth)});
  }
  rotation_of(cloth);  // refuses an axis without length
  file_place(cloth)(mesh.points);
  check_points(mesh.points, cloth.grid ? label : label + " (" + cloth.file + ")");
  if (cloth.grid)
    placed.weld.node = own_numbers(mesh);
  else
    sew_sheets(placed, cloth, lines);
  find_places(mesh, placed.weld);
  if (!cloth.grid && cloth.clean != 0) clean(placed, cloth, lines);
  check_mesh(mesh, cloth.grid ? label : label + " (" + cloth.file + ")", cloth_min_area_ratio);
  if (!cloth.grid)
    if (std::string hint = unit_hint(mesh.points, cloth.unit, cloth.scale, label); !hint.empty())
      lines.hints.push_back(std::move(hint));
  return placed;
}

}  // namespace drench
