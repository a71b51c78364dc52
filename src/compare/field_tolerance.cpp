#include "compare/field_tolerance.hpp"

#include <algorithm>
#include <limits>

namespace drench {
namespace {

/// Of a triangle's membrane between two of its corners, at most, N/m.
double membrane_stiffness(const ClothMesh& mesh, std::size_t t) {
  const auto [xx, xy, yy] = mesh.triangle_shape[t];
  const Membrane<double>& m = mesh.membrane[t];
  return (std::max(m.warp, m.weft) + 2 * m.shear) * (xx * xx + xy * xy + yy * yy);
}

/// The largest sum of spring constants, membranes and strain limits that meet at a node, N/m.
double stiffest_node(const ClothMesh& mesh) {
  std::vector<double> sum(mesh.rest_position.size(), 0);
  const auto add = [&](Index n, double stiffness) { sum[static_cast<std::size_t>(n)] += stiffness; };
  for (std::size_t e = 0; e < mesh.edge.size(); ++e)
    for (const Index n : mesh.edge[e]) add(n, mesh.edge_stiffness[e]);
  for (std::size_t k = 0; k < mesh.stitch.size(); ++k)
    for (const Index n : mesh.stitch[k]) add(n, mesh.stitch_stiffness[k]);
  for (std::size_t t = 0; t < mesh.limit_stiffness.size(); ++t) {
    const auto [xx, xy, yy] = mesh.triangle_shape[t];
    for (const Index n : mesh.triangle[t]) add(n, mesh.limit_stiffness[t] * (xx * xx + xy * xy + yy * yy));
  }
  for (std::size_t t = 0; t < mesh.membrane.size(); ++t)
    for (const Index n : mesh.triangle[t]) add(n, membrane_stiffness(mesh, t));
  return sum.empty() ? 0 : *std::max_element(sum.begin(), sum.end());
}

}  // namespace

FieldTolerances::FieldTolerances(const Model& model, Stage stage, double dt, const HostState& expected,
                                 const Precision& precision, const std::vector<FieldDifference>& fields)
    : model_(model), expected_(expected), stage_(stage), dt_(dt), precision_(precision) {
  for (const FieldDifference& d : fields) largest_[d.field] = d.largest;
}

double FieldTolerances::of(const FieldDifference& d) const {
  const Allowed allowed = (this->*rule_for(d))(d);
  // A GPU may leave a subnormal number where the reference has 0.
  constexpr double subnormal = std::numeric_limits<float>::min();
  return precision_.tolerance * allowed.scale + allowed.slack + subnormal;
}

FieldTolerances::Rule FieldTolerances::rule_for(const FieldDifference& d) {
  static const std::map<std::string, Rule> rules{
      {"fluid_id", &FieldTolerances::exact},
      {"fluid_origin", &FieldTolerances::exact},
      {"fluid_solute", &FieldTolerances::solute},
      {"node_solute", &FieldTolerances::solute},
      {"sample_flow_direction", &FieldTolerances::unit_vector},
      {"fluid_velocity", &FieldTolerances::fluid_velocity},
      {"fluid_kappa_density", &FieldTolerances::kappa_density},
      {"fluid_kappa_divergence", &FieldTolerances::kappa_divergence},
      {"node_velocity", &FieldTolerances::node_velocity},
      {"node_contact_force", &FieldTolerances::contact_force},
      {"node_friction_force", &FieldTolerances::contact_force},
      {"node_pin_force", &FieldTolerances::pin_force},
      {"node_contact_pressure", &FieldTolerances::contact_pressure},
      {"body_velocity", &FieldTolerances::body_velocity},
      {"body_angular_velocity", &FieldTolerances::body_velocity},
  };
  if (const auto found = rules.find(d.field); found != rules.end()) return found->second;
  return d.unit == "quanta" ? &FieldTolerances::mass : &FieldTolerances::share_of_largest;
}

FieldTolerances::Allowed FieldTolerances::share_of_largest(const FieldDifference& d) const { return {d.largest}; }
FieldTolerances::Allowed FieldTolerances::exact(const FieldDifference&) const { return {0}; }
FieldTolerances::Allowed FieldTolerances::unit_vector(const FieldDifference&) const { return {1}; }

FieldTolerances::Allowed FieldTolerances::mass(const FieldDifference&) const {
  return {static_cast<double>(quanta_per_particle), mass_slack};
}

// What is transferred goes with the concentration, which is above 1 quantum a quantum where liquid has gone.
/// A quantum of liquid more or less carries as many of solute as the strongest holder has for one.
FieldTolerances::Allowed FieldTolerances::solute(const FieldDifference& d) const {
  double strongest = 1;
  const auto look = [&](const std::vector<Quanta>& solute, const std::vector<Quanta>& liquid) {
    for (std::size_t k = 0; k < std::min(solute.size(), liquid.size()); ++k)
      if (liquid[k] > 0)
        strongest = std::max(strongest, static_cast<double>(solute[k]) / static_cast<double>(liquid[k]));
  };
  look(expected_.node_solute, expected_.node_liquid);
  look(expected_.fluid_solute, expected_.fluid_mass);
  return {std::max(d.largest, static_cast<double>(quanta_per_particle)), strongest * mass_slack};
}

FieldTolerances::Allowed FieldTolerances::fluid_velocity(const FieldDifference& d) const {
  // a quantum more or less at twice the fastest speed in the particle that differs most
  if (stage_ == Stage::emission && d.index < expected_.fluid_mass.size())
    return {d.largest,
            2 * std::max(d.largest, largest("node_velocity")) / static_cast<double>(expected_.fluid_mass[d.index])};
  if (stage_ == Stage::pressure)
    return {d.largest, precision_.solve_roundings * precision_.rounding * (model_.spacing / dt_ / 4) +
                           precision_.pair_rounding * cancelling_velocities()};
  return {d.largest};
}

FieldTolerances::Allowed FieldTolerances::kappa_density(const FieldDifference& d) const {
  if (stage_ != Stage::pressure) return {d.largest};
  const double speed = model_.spacing / dt_;
  return {d.largest, precision_.solve_roundings * precision_.rounding * (speed * speed)};
}

FieldTolerances::Allowed FieldTolerances::kappa_divergence(const FieldDifference& d) const {
  // a rounding of both velocities of a pair, over a spacing: in free fall κ is nothing else
  return {d.largest, 2 * precision_.rounding * largest("fluid_velocity") * model_.spacing / dt_};
}

FieldTolerances::Allowed FieldTolerances::node_velocity(const FieldDifference& d) const {
  if (stage_ == Stage::absorption || stage_ == Stage::emission)  // of the fastest liquid
    return {d.largest, two_quanta_in_the_lightest_node() * largest("fluid_velocity")};
  if (stage_ == Stage::diffusion)  // of the fastest node's liquid
    return {d.largest, two_quanta_in_the_lightest_node() * d.largest};
  // displacements over Δt: one rounding of a node's position
  if (stage_ == Stage::pressure && precision_.solve_roundings > 0)
    return {d.largest, precision_.rounding * largest("node_position") / dt_};
  if (moves_cloth()) return {std::max(d.largest, largest("node_position") / dt_)};
  return {d.largest};
}

FieldTolerances::Allowed FieldTolerances::contact_force(const FieldDifference& d) const {
  if (!moves_cloth()) return {d.largest};
  return {d.largest, roundings_of_springs()};
}

FieldTolerances::Allowed FieldTolerances::pin_force(const FieldDifference& d) const {
  const ClothMesh& mesh = model_.mesh;
  if (stage_ == Stage::pressure) return {d.largest, roundings_of_springs()};
  if (stage_ == Stage::absorption || stage_ == Stage::emission)  // the momentum of the liquid that `mass` allows
    return {d.largest,
            mass_slack * model_.quantum * std::max(largest("fluid_velocity"), largest("node_velocity")) / dt_};
  if (!moves_cloth() || mesh.edge_stiffness.empty()) return {d.largest};
  // a sum of spring forces k |x| that cancel
  double stiffest = *std::max_element(mesh.edge_stiffness.begin(), mesh.edge_stiffness.end());
  for (std::size_t t = 0; t < mesh.membrane.size(); ++t) stiffest = std::max(stiffest, membrane_stiffness(mesh, t));
  return {std::max(d.largest, 6 * stiffest * mesh.edge_length.front())};
}

/// Of the forces that press a node, on the least area.
FieldTolerances::Allowed FieldTolerances::contact_pressure(const FieldDifference& d) const {
  double least = std::numeric_limits<double>::infinity();  // m²
  for (std::size_t n = 0; n < model_.mesh.solid_mass.size(); ++n)
    least = std::min(least, model_.mesh.solid_mass[n] / model_.material_of_node(static_cast<Index>(n)).areal_density);
  return {d.largest, roundings_of_springs() / least};
}

FieldTolerances::Allowed FieldTolerances::body_velocity(const FieldDifference& d) const {
  if (stage_ != Stage::cloth || d.index >= model_.bodies.size() || !model_.bodies[d.index].dynamic) return {d.largest};
  // roundings of the forces of all nodes that touch, at random
  const auto touches = [](const Vec3& f) { return f != Vec3{0, 0, 0}; };
  const auto nodes = std::count_if(expected_.node_contact_force.begin(), expected_.node_contact_force.end(), touches);
  const Body& b = model_.bodies[d.index];
  const double impulse = dt_ * std::sqrt(static_cast<double>(nodes)) * roundings_of_springs();
  const double least = *std::min_element(b.inertia.begin(), b.inertia.end());
  return {d.largest, d.field == "body_velocity" ? impulse / b.mass : impulse * b.reach / least};
}

bool FieldTolerances::moves_cloth() const {
  return stage_ == Stage::cloth || stage_ == Stage::self_collision || stage_ == Stage::advection;
}

double FieldTolerances::largest(const char* field) const {
  const auto found = largest_.find(field);
  return found == largest_.end() ? 0 : found->second;
}

/// The share of the lightest node's velocity that two quanta make, 1.
double FieldTolerances::two_quanta_in_the_lightest_node() const {
  const auto& solid = model_.mesh.solid_mass;
  return solid.empty() ? 0 : 2 * model_.quantum / *std::min_element(solid.begin(), solid.end());
}

/// What pairs alone would do to a velocity in a step, m/s: 2κ Δt ∑ V|∇W|, with the sum 3/d of a full neighbourhood.
double FieldTolerances::cancelling_velocities() const {
  return 6 * dt_ * largest("fluid_kappa_density") / model_.spacing;
}

/// Of spring forces that cancel: the stiffness of a node times one rounding of its position, N.
double FieldTolerances::roundings_of_springs() const {
  return precision_.rounding * stiffest_node(model_.mesh) * largest("node_position");
}

}  // namespace drench
