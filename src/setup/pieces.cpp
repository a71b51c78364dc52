#include "setup/pieces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

#include "base/sets.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/forecast.hpp"

namespace drench {
namespace {

constexpr std::size_t most_listed = 12;  // pieces of a cloth

/// The lowest node of each node's piece.
std::vector<Index> connected(const ClothMesh& mesh) {
  Sets joined(mesh.rest_position.size());
  for (const auto& t : mesh.triangle) {
    joined.unite(t[0], t[1]);
    joined.unite(t[0], t[2]);
  }
  for (const auto& [a, b] : mesh.stitch) joined.unite(a, b);
  std::vector<Index> lowest;
  for (std::size_t n = 0; n < mesh.rest_position.size(); ++n) lowest.push_back(joined.root(static_cast<Index>(n)));
  return lowest;
}

}  // namespace

std::vector<ClothPiece> pieces_of(const Model& model) {
  const ClothMesh& mesh = model.mesh;
  const std::vector<Index> piece_of = connected(mesh);
  std::map<Index, std::vector<Index>> nodes;
  for (std::size_t n = 0; n < piece_of.size(); ++n) nodes[piece_of[n]].push_back(static_cast<Index>(n));
  std::vector<ClothPiece> pieces;
  for (const auto& [first, members] : nodes) {
    ClothPiece piece;
    piece.cloth = mesh.node_cloth[at(first)];
    piece.first = first;
    piece.nodes = static_cast<Index>(members.size());
    piece.box = {mesh.rest_position[at(first)], mesh.rest_position[at(first)]};
    for (const Index n : members) {
      piece.pinned += mesh.pinned[at(n)] || mesh.soft_pin(n) > 0;
      for (std::size_t a = 0; a < 3; ++a) {
        piece.box.min[a] = std::min(piece.box.min[a], mesh.rest_position[at(n)][a]);
        piece.box.max[a] = std::max(piece.box.max[a], mesh.rest_position[at(n)][a]);
      }
    }
    piece.held = !falls_freely(model, model.cloths[at(piece.cloth)], members);
    pieces.push_back(piece);
  }
  return pieces;
}

std::string text_of(const ClothPiece& piece, std::size_t number) {
  const auto side = [&](std::size_t a) { return piece.box.max[a] - piece.box.min[a]; };
  const std::string pins = piece.pinned > 0 ? fmt::format("{} pinned", piece.pinned) : "not pinned";
  return fmt::format("piece {}: {} nodes, {:.3g} × {:.3g} × {:.3g} m, {}", number, piece.nodes, side(0), side(1),
                     side(2), pins);
}

namespace {

/// Of pieces that nothing holds.
std::string warning_of(const std::vector<std::size_t>& loose, std::size_t pieces) {
  const std::size_t listed = std::min(loose.size(), most_listed);
  return fmt::format(
      "nothing holds piece{} {}{} of {}: cloth without a pin, a seam to another piece or a body below it falls; use "
      "weld or sew, a pin, or a body",
      loose.size() == 1 ? "" : "s", fmt::join(loose.begin(), loose.begin() + static_cast<std::ptrdiff_t>(listed), ", "),
      listed < loose.size() ? fmt::format(" and {} more", loose.size() - listed) : "", pieces);
}

}  // namespace

void list_pieces(const Model& model, std::vector<std::string>& notes, std::vector<std::string>& warnings) {
  const std::vector<ClothPiece> all = pieces_of(model);
  for (std::size_t c = 0; c < model.cloths.size(); ++c) {
    std::vector<ClothPiece> pieces;
    for (const ClothPiece& p : all)
      if (at(p.cloth) == c) pieces.push_back(p);
    if (pieces.size() < 2) continue;
    const std::string label = cloth_label(model.cloths[c].name);
    notes.push_back(fmt::format("{}: {} pieces that are not sewn together", label, pieces.size()));
    for (std::size_t k = 0; k < std::min(pieces.size(), most_listed); ++k)
      notes.push_back(fmt::format("{}: {}", label, text_of(pieces[k], k)));
    if (pieces.size() > most_listed)
      notes.push_back(fmt::format("{}: and {} more pieces", label, pieces.size() - most_listed));
    std::vector<std::size_t> loose;
    for (std::size_t k = 0; k < pieces.size(); ++k)
      if (!pieces[k].held) loose.push_back(k);
    if (loose.empty() || loose.size() == pieces.size()) continue;  // plan_warnings has a line for all of it
    warnings.push_back(label + ": " + warning_of(loose, pieces.size()));
  }
}

std::vector<Chain> loops_of(const Model& model, const ClothMaterial& cloth) {
  std::vector<std::array<Index, 3>> triangles;
  for (Index t = cloth.first_triangle; t < cloth.first_triangle + cloth.triangle_count; ++t) {
    triangles.push_back(model.mesh.triangle[at(t)]);
    for (Index& n : triangles.back()) n -= cloth.first_node;
  }
  return boundary_loops(triangles);
}

}  // namespace drench
