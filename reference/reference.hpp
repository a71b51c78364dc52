#pragma once
// The serial oracle: double precision, std::vector and Eigen, one plain function a stage. It includes nothing from
// backends/.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "pipeline/backend.hpp"
#include "state/rigid_contacts.hpp"

namespace drench::reference {

using NeighborLists = std::vector<std::vector<Index>>;

/// All that the reference keeps: the model, the state, and what stages hand on within a step.
struct ReferenceState {
  explicit ReferenceState(const Model& of) : model(of) {
    if (of.has_dynamic_body()) contacts = std::make_shared<RigidContacts>(of);
  }
  const Model& model;
  HostState s;
  NeighborLists fluid_fluid, fluid_boundary, fluid_sample, sample_fluid, sample_sample, sample_boundary;
  // Per liquid particle (stage density): C_i, 1/m²; the Jacobi diagonal of the pressure solves, m²; those of its
  // contact with sheets, α' = 0 where it touches none.
  std::vector<double> compliance, alpha, contact_compliance, contact_alpha;
  std::vector<Eigen::Matrix3d> wall_gain;           // L_i, 1; empty where walls mirror (stage density)
  std::vector<double> sample_supply;                // Σ V W upstream of each sample, 1 (stage permeation)
  std::vector<double> sample_passing;               // what passes each sample in this step, m/s (stage permeation)
  std::vector<double> node_pores;                   // what pores hold under pressure, kg; empty: as at rest
  std::vector<Eigen::Vector3d> boundary_predicted;  // m/s, per boundary sample: after a pressure (in-stage)
  std::shared_ptr<RigidContacts> contacts;          // null unless a body is dynamic
};

#define DRENCH_REFERENCE_STAGE(name, when) void name(ReferenceState& state, const StepInfo& info, StepReport& report);
DRENCH_STAGES(DRENCH_REFERENCE_STAGE)
#undef DRENCH_REFERENCE_STAGE

}  // namespace drench::reference
