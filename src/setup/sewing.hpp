#pragma once
// Seams that stitches close during the run (`cloth.N.sew`).

#include <array>
#include <string>
#include <vector>

#include "setup/boundary_loops.hpp"
#include "setup/cloth_regions.hpp"
#include "setup/surface_mesh.hpp"
#include "setup/weld.hpp"
#include "state/model.hpp"

namespace drench {

/// Pairs of nodes of the cloth's own mesh that are sewn, lower first, each once and in rising order. A pair that is one
/// node or has an edge needs no stitch: `unneeded` is increased by their number. SetupError, with the key to blame
/// below `key`: a loop, group or point that there is not, a file that cannot be read.
std::vector<std::array<Index, 2>> sewn_pairs(const ClothScene& cloth, const SurfaceMesh& own, const Weld& weld,
                                             const std::string& key, std::size_t& unneeded);

/// Stitches of the last cloth that was appended: `sewn` close until sew_time, those of `weld` hold from the start. As
/// stiff as the fabric at their nodes. Nodes are numbered from first_node.
void append_stitches(ClothMesh& mesh, const ClothScene& cloth, const SurfaceMesh& own, const Patchwork& fabric,
                     const std::vector<std::array<Index, 2>>& sewn, const Weld& weld, Index first_node);

/// mesh.joint, if there are stitches.
void join_nodes(ClothMesh& mesh);

/// Pairs that sew chain a along chain b, each by its length; closed chains where they lie nearest to each other.
std::vector<std::array<Index, 2>> along_each_other(const Chain& a, const Chain& b, const std::vector<Vec3>& points);

}  // namespace drench
