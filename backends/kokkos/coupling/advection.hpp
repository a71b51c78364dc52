#pragma once
// Stage advection: liquid and cloth move, and liquid does not pass cloth. Law: src/stages/advection.hpp.

#include "cloth/cloth.hpp"
#include "core/ranks.hpp"
#include "coupling/collision.hpp"
#include "particles/fluid.hpp"
#include "state/host_state.hpp"

namespace drench::kokkos_backend {

/// A region that removes liquid, while it is open.
struct Drain {
  DrainScene::Shape shape;
  Double3 a, b;       // m: corners of a box; centre of a sphere; point of a plane, and its normal (1)
  double radius;      // m
  double start, end;  // s

  KOKKOS_INLINE_FUNCTION bool takes(const Double3& x, double time) const {
    if (!(time >= start && time < end)) return false;
    const Double3 from = minus(x, a);
    switch (shape) {
      case DrainScene::Shape::box:
        return x.x >= a.x && x.y >= a.y && x.z >= a.z && x.x <= b.x && x.y <= b.y && x.z <= b.z;
      case DrainScene::Shape::sphere:
        return inner(from, from) <= radius * radius;
      case DrainScene::Shape::plane:
        return inner(from, b) <= 0;
    }
    return false;
  }
};

/// What stage advection counts; exact in any order.
struct AdvectionCounts {
  std::int64_t collisions = 0, clamped = 0;
  std::int64_t removed = 0;        // particles beyond the border
  std::int64_t drained = 0;        // quanta: of these, and of those in a drain
  std::int64_t gone = 0;           // particles that do not stay
  std::int64_t put_back_near = 0;  // clamped ones that had cloth within h
  double square = 0;               // m²/s²: the largest |v|² of those beyond the border
  KOKKOS_INLINE_FUNCTION AdvectionCounts& operator+=(const AdvectionCounts& o) {
    collisions += o.collisions;
    clamped += o.clamped;
    removed += o.removed;
    drained += o.drained;
    gone += o.gone;
    put_back_near += o.put_back_near;
    if (o.square > square) square = o.square;
    return *this;
  }
  void visit(OverRanks& all) {
    all.sum(collisions).sum(clamped).sum(removed).sum(drained).sum(gone).sum(put_back_near).maximum(square);
  }
};

/// The largest stretch of a triangle at the start, 1, and the bounds of the nodes' displacements, m.
struct ClothMotion {
  double stretch = 0;
  Double3 least, most;
};

/// Work arrays, made on first use. `momentum` and `hits` are zero between steps.
struct AdvectionWork {
  Field<Real3> start;            // per node: x⁰_n, m
  Field<std::int64_t> momentum;  // 3 per node (core/fixed_point.hpp)
  Field<Index> hits;             // per node: c_k
  Field<Box> box;                // per triangle: of its way in the step
  Field<Index> ordered;          // triangles as they lie together on the cloth, −1 up to whole groups
  Field<Box> cluster_box;        // around each 32 of these, then around each 32 of those
  Kokkos::View<ClothMotion, MemSpace> motion;
  Kokkos::View<AdvectionCounts, Kokkos::SharedHostPinnedSpace> counts;
  Field<Real3> end, hit_weight, hit_normal;  // per liquid particle: x1, m; barycentric; towards x0
  Field<Index> hit_triangle;                 // −1: none
  Field<Index> near;                         // on a GPU: particles that may hit, in no order
  Kokkos::View<Index, MemSpace> near_count;  // zero between steps
  Field<Index> far;                          // of a GPU: particles whose list does not have all that they can hit
  Kokkos::View<Index, MemSpace> far_count;   // zero between steps
  Field<std::uint8_t> gone;                  // 1: beyond the border; 2: in a drain
  Field<Drain> drains;                       // of a scene that has some
};

MemoryEstimate advection_bytes(const Sizing& s);

void advection(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies, Cloth& cloth,
               AdvectionWork& work, Accounts& accounts, const StepInfo& info, StepReport& report);

}  // namespace drench::kokkos_backend
