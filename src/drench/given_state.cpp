#include "drench/given_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include "scene/describe.hpp"
#include "scene/scalars.hpp"
#include "state/fastest.hpp"
#include "state/mass_budget.hpp"
#include "state/needed_fields.hpp"

namespace drench {
namespace {

[[noreturn]] void refuse(std::string_view field, std::size_t row, std::string_view what) {
  throw std::invalid_argument(fmt::format("{}[{}]: {}", field, row, what));
}

template <class T>
bool is_finite(const T& value) {
  if constexpr (std::floating_point<T>)
    return std::isfinite(value);
  else if constexpr (std::integral<T>)
    return true;
  else
    return std::all_of(value.begin(), value.end(), [](double x) { return std::isfinite(x); });
}

/// Of the fields whose names begin like this one.
Index rows_of(const Model& m, std::string_view field, const HostState& s) {
  if (field.starts_with("fluid_")) return s.fluid_count();
  if (field.starts_with("boundary_")) return m.boundary.count();
  if (field.starts_with("body_")) return static_cast<Index>(m.bodies.size());
  if (field.starts_with("node_")) return m.mesh.nodes();
  return m.samples.count();
}

void check_masses(std::string_view field, const std::vector<Quanta>& masses, Quanta least) {
  // Sums of all masses stay far below what 64 bits hold.
  constexpr Quanta most = std::numeric_limits<Quanta>::max() / 4;
  Quanta sum = 0;
  for (std::size_t i = 0; i < masses.size(); ++i) {
    if (masses[i] < least || masses[i] > most - sum)
      refuse(field, i, fmt::format("{} mass units; allowed: at least {}, at most {}", masses[i], least, most - sum));
    sum += masses[i];
  }
}

}  // namespace

HostState checked_state(const Model& m, const HostState& state) {
  HostState s = state;
  visit_fields(s, [&](std::string_view field, auto& values) {
    if (!needs_field(m, field)) values.clear();
  });
  if (state.fluid_count() > 0 && !m.has_fluid())
    throw std::invalid_argument(
        "fluid_position: the scene has no liquid; allowed: no particles, or a scene with fluid");
  visit_fields(s, [&](std::string_view field, const auto& values) {
    const auto rows = static_cast<std::size_t>(needs_field(m, field) ? rows_of(m, field, s) : 0);
    if (values.size() != rows)
      throw std::invalid_argument(fmt::format("{}: {} rows; this run needs {}", field, values.size(), rows));
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!is_finite(values[i])) refuse(field, i, "not a finite number");
  });
  const Box& domain = m.scene.domain;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a)  // a particle may be on its way out
      if (!(s.fluid_position[i][a] >= domain.min[a] - m.spacing && s.fluid_position[i][a] <= domain.max[a] + m.spacing))
        refuse("fluid_position", i, "outside the domain");
  check_masses("fluid_mass", s.fluid_mass, 1);
  for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
    if (s.fluid_mass[i] > 2 * quanta_per_particle)
      refuse("fluid_mass", i,
             fmt::format("{} mass units; allowed: up to {}, two full particles", s.fluid_mass[i],
                         2 * quanta_per_particle));
  for (std::size_t n = 0; n < s.node_scanning.size(); ++n) {
    if (std::abs(s.node_scanning[n]) > 1)
      refuse("node_scanning", n, fmt::format("{:g}; allowed: [-1, 1]", s.node_scanning[n]));
    if (s.node_extreme[n] < 0) refuse("node_extreme", n, fmt::format("{:g}; allowed: at least 0", s.node_extreme[n]));
  }
  for (std::size_t i = 0; i < s.fluid_id.size(); ++i) {
    if (i > 0 && s.fluid_id[i] <= s.fluid_id[i - 1]) refuse("fluid_id", i, "ids have to ascend");
    if (s.fluid_id[i] < 0 || s.fluid_id[i] >= s.next_id)
      refuse("fluid_id", i, fmt::format("{}; allowed: 0 to next_id − 1 = {}", s.fluid_id[i], s.next_id - 1));
  }
  const auto last = static_cast<std::uint8_t>(Origin::mouth);
  for (std::size_t i = 0; i < s.fluid_origin.size(); ++i)
    if (s.fluid_origin[i] > last)
      refuse("fluid_origin", i, fmt::format("{}; allowed: 0 to {}", s.fluid_origin[i], last));
  check_masses("node_liquid", s.node_liquid, 0);
  check_masses("node_buffered", s.node_buffered, 0);
  for (std::size_t i = 0; i < s.node_liquid.size(); ++i) {
    if (s.node_buffered[i] > s.node_liquid[i])
      refuse("node_buffered", i, "more than node_liquid of this node, which contains it");
    if (s.node_liquid[i] > 0 && (m.samples.node_capacity.empty() || !(m.samples.node_capacity[i] > 0)))
      refuse("node_liquid", i, "the cloth is not porous here; allowed: 0");
  }
  check_masses("fluid_solute", s.fluid_solute, 0);
  check_masses("node_solute", s.node_solute, 0);
  for (std::size_t b = 0; b < s.body_orientation.size(); ++b) {
    const auto& q = s.body_orientation[b];
    if (std::abs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) > 1e-6)
      refuse("body_orientation", b, "the length of the quaternion is not 1");
  }
  if (s.jet_particles.size() != m.jets.size())
    throw std::invalid_argument(
        fmt::format("jet_particles: {} entries; the scene has {} jets", s.jet_particles.size(), m.jets.size()));
  if (!std::isfinite(s.time) || s.time < 0 || s.step < 0)
    throw std::invalid_argument(fmt::format("time {} s, step {}; allowed: 0 or more", s.time, s.step));
  return s;
}

void require_prescribed_motion(const Model& m, const HostState& next, const HostState& before) {
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    if (m.bodies[b].dynamic) continue;
    if (next.body_position[b] != before.body_position[b] || next.body_orientation[b] != before.body_orientation[b] ||
        next.body_velocity[b] != before.body_velocity[b] ||
        next.body_angular_velocity[b] != before.body_angular_velocity[b])
      throw std::invalid_argument(
          fmt::format("body {} is not dynamic: the scene or commands move it; allowed: set_body_pose and "
                      "set_body_velocity for a body with commanded: true",
                      b));
  }
}

void require_possible(const Model& m, const HostState& next, const HostState& before) {
  const auto check = [](std::string_view field, const auto& now, const auto& old, const char* range, const char* unit) {
    const Range allowed = parse_range(range);
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (now.size() == old.size() && now[i] == old[i]) continue;
      for (const double x : now[i])
        if (!allowed.contains(x)) refuse(field, i, fmt::format("{:g} {}; allowed: {}", x, unit, range));
    }
  };
  check("fluid_velocity", next.fluid_velocity, before.fluid_velocity, speed_range, "m/s");
  check("node_position", next.node_position, before.node_position, coordinate_range, "m");
  check("node_velocity", next.node_velocity, before.node_velocity, speed_range, "m/s");
  check("body_position", next.body_position, before.body_position, coordinate_range, "m");
  check("body_velocity", next.body_velocity, before.body_velocity, speed_range, "m/s");
  check("body_angular_velocity", next.body_angular_velocity, before.body_angular_velocity, turn_range, "rad/s");
  for (std::size_t n = 0; n < next.node_liquid.size(); ++n) {
    if (next.node_liquid[n] <= before.node_liquid[n]) continue;
    const double full = m.samples.node_capacity[n] / m.quantum,
                 most = m.cloths[static_cast<std::size_t>(m.mesh.node_cloth[n])].most_saturation;
    if (static_cast<double>(next.node_liquid[n]) > most * full + 1)
      refuse("node_liquid", n,
             fmt::format("a saturation of {:g}; allowed: up to {:g}, which is {:.0f} mass units",
                         static_cast<double>(next.node_liquid[n]) / full, most, most * full));
  }
}

void continue_budget(HostState& next, const HostState& before) {
  const Quanta more = liquid_budget(next) - liquid_budget(before);
  (more > 0 ? next.supplied : next.drained) += std::abs(more);
  const Quanta more_solute = solute_budget(next) - solute_budget(before);
  (more_solute > 0 ? next.solute_supplied : next.solute_drained) += std::abs(more_solute);
}

double fastest_of(const HostState& s) { return std::max(fastest_of(s.fluid_velocity), fastest_of(s.node_velocity)); }

}  // namespace drench
