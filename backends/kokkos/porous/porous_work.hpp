#pragma once
// Scratch arrays of the porous stages. They are allocated when first used, grow with the liquid and are never read
// across stages.

#include "cloth/retention_law.hpp"
#include "core/cached.hpp"
#include "core/double3.hpp"
#include "core/types.hpp"

namespace drench::kokkos_backend {

/// Sums of V W and of other shares are whole numbers of 2^-40, so that they do not depend on their order.
inline constexpr double share_units = 1099511627776.0;

/// Transfers on their way between liquid, samples and nodes: shared by absorption and emission.
struct TransferWork {
  Field<Quanta> offered, entering;  // per sample, quanta: what it may get; what it gets, less that without a limit
  Field<std::int64_t> momentum;     // 3 per sample, q · 2^-8 m/s: of what it gets
  Field<double> node_inflow_share;  // φ per node
  Field<int> limited;               // per sample: is φ < 1 at one of its nodes with w > 0?
  Field<Quanta>
      front;  // per sample, quanta: what of it is exchanged with liquid on its front; only where faces are counted
  Field<Quanta> solute;  // per sample, quanta: of what it gets; empty without a solute
};

/// Only with cloth that liquid passes through.
struct PermeationWork {
  // 5 per sample, 2^-40: Σ V W and Σ V W φ (m²/s²) where its normal leaves and where it points; its load (m²/s²)
  Field<std::int64_t> sides;
  Field<Real> supply;  // Σ V W upstream of the sample, 1; where the flux is not 0
};

/// Only where liquid may cover cloth that dries.
struct DryingWork {
  Field<std::int64_t> sides;  // 2 per sample, 2^-40: Σ V W of liquid where its normal leaves and where it points
  Field<Real> open;           // per sample, 1: how many of its sides the air reaches
};

struct AbsorptionWork {
  Field<Quanta> offer;                              // o_ij beside the entries of fluid_sample, quanta
  Field<Real4> position_saturation, flow_capacity;  // per sample: x_j, m, and s_j; v_j and C_j, kg
  Field<Real4> pull;  // per sample: upstream, 1, and kg/s for each V W there; empty without permeable cloth
  Kokkos::View<Index, Kokkos::SharedHostPinnedSpace> taken;  // particles taken whole; where there is no emission
};

struct EmissionCounts {
  Index empty = 0;     // particles that absorption took whole
  Index buffered = 0;  // not 0: something is buffered, or may become so
  KOKKOS_INLINE_FUNCTION EmissionCounts& operator+=(const EmissionCounts& o) {
    empty += o.empty;
    buffered += o.buffered;
    return *this;
  }
};

struct EmissionWork {
  // per sample
  Field<Quanta> share;        // 3 per sample: E_pk
  Field<Quanta> total, rest;  // E_p, and what is left of it: E′_p, E″_p
  Field<Quanta> room;         // Σ_j R_j of the liquid in its cone
  Field<Real3> velocity;      // v^e_p, m/s
  Field<Real3> direction;     // e_p; only with solids (leaving_directions)
  Field<std::uint8_t> blocked;
  Field<Index> layers;  // number of receiving samples of other layers
  Field<Index> target;  // the sample that it points to, −1: none
  Field<Quanta> pool;   // S of a collector that is a candidate, otherwise 0
  Field<Quanta> given;  // what left it in all
  // of the solute, where there is one: 3 per sample, of E_pk; of E_p, and what is left of it
  Field<Quanta> solute_share, solute_total, solute_rest;
  // of those that are candidates
  Field<Real3> position;        // of the new particle, m
  Field<std::int64_t> liquid;   // Σ_j V_j W there, 2^-40
  Field<std::uint8_t> created;  // has space
  Field<Index> rank;            // among those that have space
  Field<Index> next;            // the next candidate of the same cell, −1: none
  Field<Index> head;            // per bucket of sample_cells: a candidate; −1 between steps
  Field<int> any;               // 0: something is buffered; 1: there are candidates. Zero between steps
  // for the host
  Kokkos::View<EmissionCounts, Kokkos::SharedHostPinnedSpace> counts;
  Kokkos::View<Index, Kokkos::SharedHostPinnedSpace> new_particles;
  bool idle = true;  // nothing was buffered when last looked
};

/// The largest rate of an explicit step, where a kernel leaves it for the host.
struct DiffusionRate {
  Kokkos::View<double, Kokkos::SharedHostPinnedSpace> largest;  // 1/s
  bool waited = false;                                          // may the host read it?
};

struct DiffusionWork {
  Index pairs = 0;                     // of nodes
  Field<Index> pair;                   // 2 each
  Field<Index> node_start, node_item;  // node → items 2·pair + side
  Field<double> conductance;           // G_ij, kg/s
  Field<double> film;                  // ω of films, 1; empty without them
  Field<double> rest_square;           // m², of the length at rest; empty unless pores narrow
  Field<double> narrowing;             // ν per node, 1 (cloth/retention_law.hpp); empty likewise
  Field<laws::NodeSuction> suction;    // per node, in this sub-step; empty unless liquid flows by it
  Field<std::uint8_t> hem;             // per node: at the boundary; empty without films
  Field<double> drop;                  // (x_i − x_j)·ĝ/ℓ, 1
  Field<Quanta> flow;                  // to the pair's first node, quanta
  Field<double> out_share, in_share;   // φ per node
  Field<Quanta> solute_flow;           // to the pair's first node; empty without a solute
  Cached<DiffusionRate> rate;          // of the nodes' positions
  // per node, m/s: in double between sub-steps; empty unless liquid diffuses in cloth that moves
  Field<Double3> velocity, next_velocity;
};

/// Two a sample, one for each side of its triangle; only with contact_wicking.
struct ContactWork {
  Field<Index> triangle;            // that the sample touches, −1: none
  Field<double> weight;             // 3 each: b_k of the point that it touches
  Field<double> conductance, drop;  // G, kg/s; gravity term, 1
  Field<Quanta> flow;               // to the sample, quanta
  Field<Quanta> entering, leaving;  // per node, quanta
  Field<Quanta> solute_gain;        // per node, quanta; empty without a solute
  // of what enters, 3 per node; empty unless liquid diffuses in cloth that moves
  Field<std::int64_t> momentum;  // units of q/momentum_scale · 1 m/s
  double momentum_scale = 1;     // a power of two
};

struct ReservoirWork {
  Field<Index> node;
  Field<Quanta> target;
  Field<double> solute;  // quanta of solute for each of liquid that is supplied; empty without a solute
};

}  // namespace drench::kokkos_backend
