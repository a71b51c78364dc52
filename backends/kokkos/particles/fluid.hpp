#pragma once
// The liquid: its particles, their cells, and what stages neighbors and density find of each for the stages after them.

#include "core/cell_table.hpp"
#include "core/constants.hpp"
#include "particles/exchange.hpp"

namespace drench::kokkos_backend {

/// Particles that went through a cloth: how many, and the lowest of their ids; exact in any order.
struct Tunnelled {
  std::int64_t count = 0, lowest = INT64_MAX;
  KOKKOS_INLINE_FUNCTION Tunnelled& operator+=(const Tunnelled& o) {
    count += o.count;
    if (o.lowest < lowest) lowest = o.lowest;
    return *this;
  }
};

/// Liquid that touches a sheet (src/stages/pressure.hpp): from stage density, where there are sheets.
struct SheetContact {
  Field<Real3> gradient;   // Σ_b 2 γ_i V_b ∇W_ib, 1/m
  Field<Real> alpha;       // α'_i, m²; 0: does not touch
  Field<Real> compliance;  // C'_i, 1/m²
};

/// L_i, 1, symmetric: what a particle's acceleration is multiplied with beside walls whose pressure is extrapolated
/// (docs/theory/walls_and_sheets.md); from stage density, only with such walls.
struct WallGain {
  Field<Real3> diagonal, shear;  // xx yy zz; yz xz xy
  Field<Real3> push;  // m/s: what the walls gave, over the sum of the samples' shares; only with dynamic bodies
};

struct Fluid {
  explicit Fluid(const Constants& constants)
      : particles(constants.model, constants.ranks != nullptr),
        exchange(constants),
        cells(constants.model.scene.sort) {}

  ParticleSet particles;
  Exchange exchange;
  CellTable cells;
  // stage neighbors, where cloth parts liquid
  Field<Index> nearest_sample;  // −1: none within h
  // stage density
  Field<Real> volume;              // V_i, m³
  Field<Real4> position_volume;    // x_i, m, and V_i, m³: one load for the pairs
  Field<Real> alpha;               // α_i, m²
  Field<Real> compliance;          // C_i, 1/m²
  Field<Real3> separation;         // m: moves coincident particles apart
  Field<Real3> boundary_gradient;  // 1/m: what solids and sheets have in the gradient of δ_i, where there are any
  WallGain wall_gain;
  SheetContact contact;
  Kokkos::View<Tunnelled, MemSpace> tunnelled;  // since advection, until the ledger takes it; only with cloth
};

}  // namespace drench::kokkos_backend
