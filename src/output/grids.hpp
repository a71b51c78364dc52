#pragma once
// HostState → VTK grids: what ParaView is shown of the liquid, the cloths and the bodies. SI units.

#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <string>
#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

using Grid = vtkSmartPointer<vtkUnstructuredGrid>;

/// One vertex per particle; point fields velocity (m/s), density (kg/m³), pressure (Pa), mass (kg), radius (m), id,
/// age (s); where the scene asks for it fitted_pressure (Pa), found by some threads.
Grid fluid_grid(const Model& model, const HostState& state, int threads = 1);

/// The triangles of all cloths; point fields velocity (m/s), saturation (1), liquid_mass (kg), flow_direction (1),
/// pin_force (N), and contact_pressure (Pa), temperature (°C) and solute (kg/m²) where they count; cell field cloth
/// (index).
Grid cloth_grid(const Model& model, const HostState& state);

/// The surfaces of the bodies that move, as they lie in `state`, or without one of those that stand still; cell fields
/// body (index), container (1: the free side is inside) and plane (1: one side only, its face points to the free side).
Grid bodies_grid(const Model& model, const HostState* state);

/// What made a run fail.
struct Offenders {
  std::vector<Index> particles;  // not finite, or with a mass that no particle can have
  std::vector<Index> nodes;      // not finite, or with a negative mass
  std::vector<Index> bodies;     // not finite
  bool empty() const { return particles.empty() && nodes.empty() && bodies.empty(); }
};
/// Those that the comments above name. A failure of another kind has others (app/failure_report.hpp).
Offenders find_offenders(const HostState& state);

/// "particles 3 17 (ids), nodes 5, bodies 0": at most `limit` numbers of each.
std::string describe(const Offenders& offenders, const HostState& state, std::size_t limit = 8);

/// One vertex per offender; point fields kind (0 particle, 1 node, 2 body), id (particle id, node or body index),
/// position and velocity as they are. The points themselves have 0 for a coordinate that is not finite, so that they
/// can be shown.
Grid offender_grid(const Model& model, const HostState& state, const Offenders& offenders);

}  // namespace drench
