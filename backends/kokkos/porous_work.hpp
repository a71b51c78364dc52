#pragma once
// Scratch arrays of the porous stages. They are allocated when first used, grow with the liquid and are never read
// across stages.

#include "laws/collision.hpp"
#include "primitives/bucket_sort.hpp"
#include "types.hpp"

namespace drench::kokkos_backend {

/// Transfers on their way between liquid, samples and nodes: shared by absorption and emission.
struct TransferWork {
  Array<Quanta> offered, entering;  // per sample, quanta: what it may get; what it gets, less that without a limit
  Array<std::int64_t> momentum;     // 3 per sample, q · 2^-8 m/s: of what it gets
  Array<double> node_inflow_share;  // φ per node
  Array<int> limited;               // per sample: is φ < 1 at one of its nodes with w > 0?
};

struct AbsorptionWork {
  Array<Quanta> offer;                                       // o_ij beside the entries of fluid_sample, quanta
  Array<Real4> place, course;                                // per sample: x_j, m, and s_j; v_j and C_j, kg
  Kokkos::View<Index, Kokkos::SharedHostPinnedSpace> taken;  // particles taken whole; where there is no emission
};

struct EmissionCounts {
  Index empty = 0;  // particles that absorption took whole
  Index ripe = 0;   // not 0: something is ripe, or may become so
  KOKKOS_INLINE_FUNCTION EmissionCounts& operator+=(const EmissionCounts& o) {
    empty += o.empty;
    ripe += o.ripe;
    return *this;
  }
};

struct EmissionWork {
  // per sample
  Array<Quanta> share;        // 3 per sample: E_pk, in the end what leaves node k
  Array<Quanta> total, rest;  // E_p, and what is left of it: E′_p, E″_p
  Array<Quanta> room;         // Σ_j R_j of the liquid in its cone
  Array<Real3> velocity;      // v^e_p, m/s
  Array<Real3> direction;     // e_p; the samples' flow_direction itself in scenes without solids
  Array<std::uint8_t> blocked;
  Array<Index> layers;  // number of receiving samples of other layers
  Array<Index> target;  // the sample that it points to, −1: none
  Array<Quanta> pool;   // S of a collector that is a candidate, otherwise 0
  // of those that are candidates
  Array<Real3> position;        // of the new particle, m
  Array<std::int64_t> liquid;   // Σ_j V_j W there, 2^-40
  Array<std::uint8_t> created;  // has space
  Array<Index> rank;            // among those that have space
  Array<Index> next;            // the next candidate of the same cell, −1: none
  Array<Index> head;            // per bucket of sample_cells: a candidate; −1 between steps
  Array<int> any;               // 0: something is ripe; 1: there are candidates. Zero between steps
  // for the host
  Kokkos::View<EmissionCounts, Kokkos::SharedHostPinnedSpace> counts;
  Kokkos::View<Index, Kokkos::SharedHostPinnedSpace> new_particles;
  bool idle = true;  // nothing was ripe when last looked
};

struct DiffusionWork {
  Index pairs = 0;                                           // of nodes
  Array<Index> pair;                                         // 2 each
  Array<Index> node_start, node_item;                        // node → items 2·pair + side
  Array<double> conductance;                                 // G_ij, kg/s
  Array<double> drop;                                        // (x_i − x_j)·ĝ/ℓ, 1
  Array<Quanta> flow;                                        // to the pair's first node, quanta
  Array<double> out_share, in_share;                         // φ per node
  Kokkos::View<double, Kokkos::SharedHostPinnedSpace> rate;  // the largest, 1/s
  bool rate_launched = false, rate_waited = false;           // of the nodes where they are; the host may read it
  // per node, m/s: in double between sub-steps; empty unless liquid diffuses in cloth that moves
  Array<Double3> velocity, next_velocity;
};

/// Two a sample, one for each side of its triangle; only with contact_wicking.
struct ContactWork {
  Array<Index> triangle;            // that the sample touches, −1: none
  Array<double> weight;             // 3 each: b_k of the point that it touches
  Array<double> conductance, drop;  // G, kg/s; gravity term, 1
  Array<Quanta> flow;               // to the sample, quanta
  Array<Quanta> entering, leaving;  // per node, quanta
  // of what enters, 3 per node; empty unless liquid diffuses in cloth that moves
  Array<std::int64_t> momentum;  // units of q/momentum_scale · 1 m/s
  double momentum_scale = 1;     // a power of two
};

struct MeasuresWork {
  CellTable cells;      // of the liquid
  Array<Real> nearest;  // 2 per liquid particle: m; 1
  Array<double> place;  // 2 per node: (u, v), m
};

struct ReservoirWork {
  Array<Index> node;
  Array<Quanta> target;
};

/// Makes room for `n` entries; contents are undefined after growth.
template <class T>
void make_room(Array<T>& a, const char* label, std::size_t n) {
  if (a.extent(0) >= n) return;
  a = {};  // free before allocating
  a = Array<T>(Kokkos::ViewAllocateWithoutInitializing(label), n);
}

}  // namespace drench::kokkos_backend
