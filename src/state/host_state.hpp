#pragma once
// Everything that changes during a run, as named arrays in double precision: the one exchange format between
// set-up, both backends, output and tests. A stage's inputs and outputs are fields of this struct, so that any
// stage can be run alone from identical input on any backend.

#include <cstdint>
#include <string_view>
#include <vector>

#include "state/types.hpp"

namespace drench {

enum class Origin : std::uint8_t { block = 0, jet = 1, cloth = 2 };

struct HostState {
  // liquid particles
  std::vector<Vec3> fluid_position;            // m
  std::vector<Vec3> fluid_velocity;            // m/s
  std::vector<Quanta> fluid_mass;              // quanta
  std::vector<std::int64_t> fluid_id;          // persistent, never reused
  std::vector<double> fluid_age;               // s since creation
  std::vector<std::uint8_t> fluid_origin;      // Origin
  std::vector<double> fluid_density_ratio;     // δ, 1
  std::vector<double> fluid_kappa_density;     // κ of the density solve, m²/s² (p = ρ0 κ); warm start
  std::vector<double> fluid_kappa_divergence;  // κ of the divergence solve, m²/s²; warm start
  std::vector<Vec3> fluid_spin;                // ω, 1/s; empty without stage micropolar

  // samples of solid bodies
  std::vector<Vec3> boundary_position;  // m
  std::vector<Vec3> boundary_velocity;  // m/s
  std::vector<double> boundary_volume;  // V_b, m³

  // the solid bodies themselves, one entry each
  std::vector<Vec3> body_position;           // m: the centre (Body::center at t = 0)
  std::vector<Quaternion> body_orientation;  // from the body as it is at t = 0 to the body as it is now
  std::vector<Vec3> body_velocity;           // m/s, of the centre
  std::vector<Vec3> body_angular_velocity;   // rad/s, in the world's axes

  // cloth nodes
  std::vector<Vec3> node_position;        // m
  std::vector<Vec3> node_velocity;        // m/s
  std::vector<Quanta> node_liquid;        // m_f, quanta
  std::vector<Quanta> node_ripe;          // quanta: the part of the excess that is ripe for emission
  std::vector<Vec3> node_contact_force;  // N: what the body that the node touches does to it, along its normal; 0 if none
  std::vector<Vec3> node_friction_force;  // N: what it does to it along its surface
  std::vector<Vec3> node_pin_force;       // N: reaction of the pin, 0 on free nodes

  // samples of the cloths
  std::vector<double> sample_volume;        // Akinci V_b, m³; 0 without liquid
  std::vector<Vec3> sample_flow_direction;  // v_p of Eqs. 4–6, |v_p| < 1, or 0

  // the ledger's other accounts, quanta
  Quanta drained = 0;   // left the domain
  Quanta supplied = 0;  // came from jets and reservoirs (net)
  std::int64_t next_id = 0;
  std::vector<std::int64_t> jet_particles;  // that each jet has let go so far

  std::int64_t step = 0;
  double time = 0;              // s
  std::int64_t collapsing = 0;  // steps in a row at whose end the liquid collapsed (pipeline/failure.hpp)

  Index fluid_count() const { return static_cast<Index>(fluid_position.size()); }
  Index node_count() const { return static_cast<Index>(node_position.size()); }
  Index sample_count() const { return static_cast<Index>(sample_volume.size()); }
  Index body_count() const { return static_cast<Index>(body_position.size()); }
  Index boundary_count() const { return static_cast<Index>(boundary_position.size()); }
};

/// Calls visit(name, array) for every array of the state: for downloads, comparison and checkpoints.
template <class State, class Visitor>
void visit_fields(State& s, Visitor&& visit) {
  visit(std::string_view("fluid_position"), s.fluid_position);
  visit(std::string_view("fluid_velocity"), s.fluid_velocity);
  visit(std::string_view("fluid_mass"), s.fluid_mass);
  visit(std::string_view("fluid_id"), s.fluid_id);
  visit(std::string_view("fluid_age"), s.fluid_age);
  visit(std::string_view("fluid_origin"), s.fluid_origin);
  visit(std::string_view("fluid_density_ratio"), s.fluid_density_ratio);
  visit(std::string_view("fluid_kappa_density"), s.fluid_kappa_density);
  visit(std::string_view("fluid_kappa_divergence"), s.fluid_kappa_divergence);
  visit(std::string_view("fluid_spin"), s.fluid_spin);
  visit(std::string_view("boundary_position"), s.boundary_position);
  visit(std::string_view("boundary_velocity"), s.boundary_velocity);
  visit(std::string_view("boundary_volume"), s.boundary_volume);
  visit(std::string_view("body_position"), s.body_position);
  visit(std::string_view("body_orientation"), s.body_orientation);
  visit(std::string_view("body_velocity"), s.body_velocity);
  visit(std::string_view("body_angular_velocity"), s.body_angular_velocity);
  visit(std::string_view("node_position"), s.node_position);
  visit(std::string_view("node_velocity"), s.node_velocity);
  visit(std::string_view("node_liquid"), s.node_liquid);
  visit(std::string_view("node_ripe"), s.node_ripe);
  visit(std::string_view("node_contact_force"), s.node_contact_force);
  visit(std::string_view("node_friction_force"), s.node_friction_force);
  visit(std::string_view("node_pin_force"), s.node_pin_force);
  visit(std::string_view("sample_volume"), s.sample_volume);
  visit(std::string_view("sample_flow_direction"), s.sample_flow_direction);
}

}  // namespace drench
