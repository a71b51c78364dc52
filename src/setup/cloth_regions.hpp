#pragma once
// Regions of cloths: parts whose fabric differs from the rest (docs/theory/regions.md).

#include <set>
#include <string>
#include <vector>

#include "setup/surface_mesh.hpp"
#include "state/model.hpp"

namespace drench {

/// "region hem" by its group, "region 2 (box)" by its number, which counts from 0 in the scene.
std::string region_label(const RegionScene& region, int number);

/// Does the cloth take groups from its mesh file?
bool needs_groups(const ClothScene& cloth);
/// Attributes of the mesh file's points that its regions are painted by.
std::set<std::string> painted_attributes(const ClothScene& cloth);

/// The fabric of each triangle of a cloth's own mesh.
class Patchwork {
 public:
  /// `own`: placed. SetupError, with the key to blame: a group that the mesh lacks, a region without triangles.
  Patchwork(const ClothScene& cloth, const SurfaceMesh& own, const std::string& key);

  /// A region, or what is of a painted one at a level.
  struct Patch {
    Index region;
    int level;  // 0: the region is not painted
    MaterialScene fabric;
  };
  const MaterialScene& operator()(Index triangle) const {
    const Index patch = patch_of(triangle);
    return patch < 0 ? cloth_.material : patches_[static_cast<std::size_t>(patch)].fabric;
  }
  /// −1: none.
  Index patch_of(Index triangle) const { return patch_.empty() ? -1 : patch_[static_cast<std::size_t>(triangle)]; }
  /// Is it one fabric on both sides of the edge?
  bool same(const MeshEdge& e) const { return e.triangles < 2 || patch_of(e.triangle[0]) == patch_of(e.triangle[1]); }
  std::size_t triangles() const { return triangles_; }
  const std::vector<Patch>& patches() const { return patches_; }

 private:
  const ClothScene& cloth_;
  std::size_t triangles_;
  std::vector<Patch> patches_;  // in the order of the regions, then by level
  std::vector<Index> patch_;    // of each triangle; empty: no regions
};

/// Adds the triangles of the cloth after the last of model.cloths to mesh.triangle_material, and its regions to
/// model.patches, if any cloth of the scene has regions.
void append_patches(Model& model, const ClothScene& cloth, const Patchwork& fabric);

/// mesh.node_material, if there are regions. A node between them gets the mean of its triangles' fabrics, by area; what
/// belongs to its mass or its pores by these. Within a painted region it gets the level nearest to its triangles' mean.
void set_node_materials(Model& model);

}  // namespace drench
