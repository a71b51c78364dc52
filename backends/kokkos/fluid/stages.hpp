#pragma once
// The liquid's stages: what each reads, what it writes, and its own work arrays, made on first use.

#include "core/cached.hpp"
#include "coupling/pressure_work.hpp"
#include "coupling/wall_slip.hpp"
#include "fluid/pressure_solve.hpp"
#include "state/host_state.hpp"

namespace drench::kokkos_backend {

/// Lists of all that is near the liquid, and its order in memory. `bounds`: around the liquid, if the host knows them.
void neighbors(const Constants& constants, Fluid& fluid, NeighborLists& lists, Bodies& bodies, Cloth& cloth,
               const PointBounds* bounds);
MemoryEstimate neighbor_bytes(const Sizing& s);

/// δ_i, α_i and what else the pairs of this step need.
void density(const Constants& constants, Fluid& fluid, NeighborLists& lists, Bodies& bodies, Cloth& cloth,
             StepReport& report);
MemoryEstimate density_bytes(const Sizing& s);

void divergence(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies, Cloth& cloth,
                PressureWork& work, const StepInfo& info, StepReport& report);
MemoryEstimate divergence_bytes(const Sizing& s);

void pressure(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies, Cloth& cloth,
              PressureWork& work, ClothSolverWork& solver, const StepInfo& info, StepReport& report);
/// Beside those of stage divergence.
MemoryEstimate pressure_bytes(const Sizing& s);

struct ForcesWork {
  Field<Real4> velocity_and_weight;  // v_i, m/s, and 1/√δ_i
  Field<Real4> change;               // D_k, m/s
  Field<Real> bound;                 // C_i, 1/s
  Field<Real> sample_bound;          // K_b, kg/s
  Field<Real3> impulse_change;       // per node: D_k of its impulse, N s (with more than one stage)
  WallSlip slip;                     // of walls that slip
};
/// Gravity, the field and viscosity, with what they do to cloth and bodies.
void forces(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies, Cloth& cloth,
            ForcesWork& work, const StepInfo& info, StepReport& report);
MemoryEstimate forces_bytes(const Sizing& s);

struct MicropolarWork {
  Field<Real4> slip;                          // s′_i, 1/s, and g_i, 1/m
  Field<Real4> rate;                          // dω_i/dt, 1/s², and k_i, 1
  Field<Real3> velocity_change, spin_change;  // D_k, m/s and 1/s (with more than one stage)
};
void micropolar(const Constants& constants, Fluid& fluid, const NeighborLists& lists, MicropolarWork& work,
                const StepInfo& info, StepReport& report);
MemoryEstimate micropolar_bytes(const Sizing& s);

MemoryEstimate surface_tension_bytes(const Sizing& s);

struct SurfaceTensionWork {
  Field<Real3> normal;                        // n_i, 1
  Field<Real> body_adhesion, cloth_adhesion;  // A_b, Pa, per body and per cloth
};
void surface_tension(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies, Cloth& cloth,
                     SurfaceTensionWork& work, const StepInfo& info);

struct EvaporationWork {
  Field<Real4> colour;           // ∇c, 1/m, and c, 1
  Field<Real4> normal;           // outward normal, 1, and how far the flat law holds, 0 to 1
  Field<Real> number;            // Σ W of the liquid, 1/m³; −1: nothing is within h of it
  Field<Real> solid;             // Σ V W of solids, 1
  Field<Real> moment;            // M, 1
  Field<Real> inside;            // (1 − f)(1 − t) V, m³
  Field<Real> flat;              // f F, m²
  Field<Real> near_inside;       // C, 1
  Field<Real> moment_of_inside;  // B, 1
  Field<Real> taken;             // Q, m³
};
/// Liquid goes from the free surface into the air; stage advection removes particles that are taken whole.
void evaporation(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                 const Cloth& cloth, EvaporationWork& work, Accounts& accounts, const StepInfo& info);
MemoryEstimate evaporation_bytes(const Sizing& s);

/// What the jets have let go so far, and their mouths' points.
struct Jets {
  std::vector<std::int64_t> particles;
  std::vector<Array<Real3>> offsets;  // m; of those that stand still
  Array<Real3> leaving;               // position (m) and velocity (m/s) of particles that leave one that moves
};
void jets(const Constants& constants, Fluid& fluid, Jets& jets, Accounts& accounts, const StepInfo& info);

}  // namespace drench::kokkos_backend
