#pragma once
// Work arrays of stage squeezing, made on first use. Law: src/stages/squeezing.hpp.

#include "cloth/self_collision.hpp"
#include "cloth/solver.hpp"

namespace drench::kokkos_backend {

/// Two layers that touch: a node and a triangle, or two edges.
struct PressedPair {
  Index node[4];
  double b[4];
  Double3 normal;
  double force;    // λ of the last pass, N
  double applied;  // λ that acts in this pass, N: extrapolated from the last two
  double missing;  // m/s²: how fast the two would close in this pass; 0: does not act
};

struct SqueezingWork {
  // per node of all cloths
  Field<Double3> pull;          // what fabric and weight do to the node, N
  Field<Double3> smooth;        // the same, spread over neighbours: what layers hold against
  Field<Double3> acceleration;  // m/s², after solids and the pairs' forces
  Field<Double3> wall;          // normal of the first solid that it touches, or 0
  Field<std::int64_t> push;     // 3 each: Σ b λ n
  Field<std::int64_t> load;     // Σ |b| λ
  Field<Index> share;           // pairs that act on it in a pass
  // per pair
  Field<PressedPair> pair;
  Field<Index> count;  // 1
};

MemoryEstimate squeezing_bytes(const Sizing& s);

}  // namespace drench::kokkos_backend
