#pragma once
// The connected pieces of a cloth.

#include <string>
#include <vector>

#include "setup/boundary_loops.hpp"
#include "state/model.hpp"

namespace drench {

struct ClothPiece {
  Index cloth = 0;   // index into Model::cloths
  Index first = 0;   // its lowest node
  Index nodes = 0;   // how many
  Index pinned = 0;  // how many of them
  Box box;           // m, at rest
  bool held = true;  // by a pin, or by a body that it lies on or could fall on
};

/// Triangles that share a node, or nodes that are sewn together, are of one piece. By cloth, then by their lowest
/// nodes. Nothing holds a piece of a cloth that moves without a pin, unless a body lies in its way or moves (which may
/// come).
std::vector<ClothPiece> pieces_of(const Model& model);

/// "piece 1: 231 nodes, 0.4 × 0.2 × 0 m, 21 pinned"; `number` counts from 0.
std::string text_of(const ClothPiece& piece, std::size_t number);

/// Lines about cloths of several pieces, and a warning for each that nothing holds.
void list_pieces(const Model& model, std::vector<std::string>& notes, std::vector<std::string>& warnings);

/// Chains of a cloth's boundary, on its own node numbers: the loops of `sew`.
std::vector<Chain> loops_of(const Model& model, const ClothMaterial& cloth);

}  // namespace drench
