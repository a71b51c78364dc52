#pragma once
// How far a field may be from the reference's, field by field. docs/manual/compare.md has the rules in words.

#include <map>
#include <string>
#include <vector>

#include "compare/field_difference.hpp"

namespace drench {

/// Tolerances of the fields after one stage.
class FieldTolerances {
 public:
  /// `fields` are all fields of the state, with the reference's largest magnitudes; `dt` is the step's, s.
  FieldTolerances(const Model& model, Stage stage, double dt, const HostState& expected, const Precision& precision,
                  const std::vector<FieldDifference>& fields);
  /// Of field `d`, in its unit.
  double of(const FieldDifference& d) const;

 private:
  struct Allowed {
    double scale;      // the precision's share of this is allowed, in the field's unit
    double slack = 0;  // and this besides, in the field's unit
  };
  using Rule = Allowed (FieldTolerances::*)(const FieldDifference&) const;
  static Rule rule_for(const FieldDifference& d);

  Allowed share_of_largest(const FieldDifference& d) const;
  Allowed mass(const FieldDifference& d) const;
  Allowed solute(const FieldDifference& d) const;
  Allowed exact(const FieldDifference& d) const;
  Allowed unit_vector(const FieldDifference& d) const;
  Allowed fluid_velocity(const FieldDifference& d) const;
  Allowed kappa_density(const FieldDifference& d) const;
  Allowed kappa_divergence(const FieldDifference& d) const;
  Allowed node_velocity(const FieldDifference& d) const;
  Allowed contact_force(const FieldDifference& d) const;
  Allowed body_velocity(const FieldDifference& d) const;
  Allowed pin_force(const FieldDifference& d) const;
  Allowed contact_pressure(const FieldDifference& d) const;

  bool moves_cloth() const;
  double largest(const char* field) const;
  double two_quanta_in_the_lightest_node() const;
  double cancelling_velocities() const;
  double roundings_of_springs() const;

  const Model& model_;
  const HostState& expected_;
  Stage stage_;
  double dt_;
  Precision precision_;
  std::map<std::string, double> largest_;  // magnitude of each field
};

}  // namespace drench
