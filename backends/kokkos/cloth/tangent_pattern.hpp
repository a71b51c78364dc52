#pragma once
// Which nodes share blocks of the cloth's tangent stiffness, and what adds to them (docs/theory/cloth.md, section 8).

#include <vector>

#include "cloth/node_vectors.hpp"

namespace drench::kokkos_backend {

struct ClothSystem;

/// K between a node and another that shares an edge with it.
struct TangentPair {
  Index other, edge;  // edge: as TangentPattern::edge_of
  Real bend;          // N/m
};
/// What only bending joins.
struct BendingPair {
  Index other;
  Real bend;  // N/m
};
/// What a triangle adds to an edge: its block (triangle · 6 + 3 + pair), or that turned over.
struct EdgePart {
  std::size_t block;
  bool transposed;
};

/// Of the mesh alone: made once, on a host.
struct TangentPattern {
  /// `s` points to a host's arrays.
  TangentPattern(const ClothSystem& s, Index nodes, Index edges, Index triangles);

  std::vector<Index> edge_of;  // of each link: 2 · edge, + 1 on the edge's second node; −1: it only bends
  std::vector<Index> pair_of;  // of each link that has an edge
  std::vector<Index> pair_start, bending_start;  // of each node
  std::vector<TangentPair> pairs;
  std::vector<BendingPair> bending_pairs;
  std::vector<Index> part_start;  // of each edge, in parts
  std::vector<EdgePart> parts;
  std::vector<Real> bending;  // of each node, N/m: B_nn
};

}  // namespace drench::kokkos_backend
