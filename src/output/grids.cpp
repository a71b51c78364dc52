#include "output/grids.hpp"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkLongLongArray.h>
#include <vtkPointData.h>

#include <algorithm>
#include <cmath>

#include "output/fitted_pressure.hpp"
#include "output/grid_tools.hpp"
#include "setup/air.hpp"
#include "setup/solute.hpp"
#include "state/saturation.hpp"

namespace drench {
namespace {

bool finite(const Vec3& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

/// Mean flow direction of the samples at each node, weighted as the samples hang on it.
std::vector<Vec3> node_flow_direction(const SampleSet& samples, const HostState& state) {
  std::vector<Vec3> flow(state.node_position.size(), Vec3{0, 0, 0});
  if (state.sample_flow_direction.empty()) return flow;
  for (Index n = 0; n < samples.node_samples.rows(); ++n) {
    auto& mean = flow[static_cast<std::size_t>(n)];
    double weight_sum = 0;
    for (Index k = samples.node_samples.start[n]; k < samples.node_samples.start[n + 1]; ++k) {
      const Index item = samples.node_samples.item[k];
      const auto sample = static_cast<std::size_t>(item / 4), corner = static_cast<std::size_t>(item % 4);
      const double w = samples.weight[sample][corner];
      weight_sum += w;
      for (std::size_t c = 0; c < 3; ++c) mean[c] += w * state.sample_flow_direction[sample][c];
    }
    if (weight_sum > 0)
      for (double& c : mean) c /= weight_sum;
  }
  return flow;
}

std::string number_list(const char* what, std::size_t count, std::size_t limit, const auto& number) {
  std::string text = what;
  for (std::size_t i = 0; i < std::min(count, limit); ++i) text += fmt::format(" {}", number(i));
  if (count > limit) text += fmt::format(" and {} more", count - limit);
  return text;
}

}  // namespace

Grid fluid_grid(const Model& model, const HostState& state, int threads) {
  const std::size_t n = state.fluid_position.size();
  Grid grid = make_vertices(state.fluid_position);
  vtkDataSetAttributes* fields = grid->GetPointData();
  const double rho = model.rest_density;
  const double full = static_cast<double>(quanta_per_particle);
  add_field<vtkFloatArray>(fields, "velocity", n, [&](std::size_t i) { return state.fluid_velocity[i]; });
  add_field<vtkFloatArray>(fields, "density", n,
                           [&](std::size_t i) { return rho * value_or_zero(state.fluid_density_ratio, i); });
  add_field<vtkFloatArray>(fields, "pressure", n,
                           [&](std::size_t i) { return rho * value_or_zero(state.fluid_kappa_density, i); });
  if (model.scene.output.fitted_pressure) {
    const std::vector<double> fitted = fitted_pressure(model, state, threads);
    add_field<vtkFloatArray>(fields, "fitted_pressure", n, [&](std::size_t i) { return fitted[i]; });
  }
  add_field<vtkDoubleArray>(fields, "mass", n,
                            [&](std::size_t i) { return static_cast<double>(state.fluid_mass[i]) * model.quantum; });
  add_field<vtkFloatArray>(fields, "radius", n, [&](std::size_t i) {
    return 0.5 * model.spacing * std::cbrt(static_cast<double>(state.fluid_mass[i]) / full);
  });
  add_field<vtkLongLongArray>(fields, "id", n, [&](std::size_t i) { return state.fluid_id[i]; });
  add_field<vtkFloatArray>(fields, "age", n, [&](std::size_t i) { return value_or_zero(state.fluid_age, i); });
  if (model.has_micropolar())
    add_field<vtkFloatArray>(fields, "spin", n, [&](std::size_t i) { return value_or_zero(state.fluid_spin, i); });
  if (model.has_solute())
    add_field<vtkFloatArray>(fields, "concentration", n, [&](std::size_t i) {
      return model.concentration_unit * static_cast<double>(value_or_zero(state.fluid_solute, i)) /
             static_cast<double>(std::max<Quanta>(1, state.fluid_mass[i]));
    });
  return grid;
}

Grid cloth_grid(const Model& model, const HostState& state) {
  const std::size_t n = state.node_position.size();
  auto grid = Grid::New();
  grid->SetPoints(make_points(state.node_position));
  vtkNew<vtkCellArray> cells;
  for (const auto& t : model.mesh.triangle) cells->InsertNextCell({t[0], t[1], t[2]});
  grid->SetCells(VTK_TRIANGLE, cells);
  vtkDataSetAttributes* fields = grid->GetPointData();
  const auto liquid = [&](std::size_t i) {
    return static_cast<double>(value_or_zero(state.node_liquid, i)) * model.quantum;
  };
  const auto flow = node_flow_direction(model.samples, state);
  const auto saturation = node_saturation(model, state);
  add_field<vtkFloatArray>(fields, "velocity", n, [&](std::size_t i) { return state.node_velocity[i]; });
  add_field<vtkFloatArray>(fields, "saturation", n, [&](std::size_t i) { return saturation[i]; });
  add_field<vtkDoubleArray>(fields, "liquid_mass", n, liquid);
  add_field<vtkFloatArray>(fields, "flow_direction", n, [&](std::size_t i) { return flow[i]; });
  add_field<vtkFloatArray>(fields, "pin_force", n,
                           [&](std::size_t i) { return value_or_zero(state.node_pin_force, i); });
  if (model.has_squeezing())
    add_field<vtkFloatArray>(fields, "contact_pressure", n,
                             [&](std::size_t i) { return value_or_zero(state.node_contact_pressure, i); });
  if (model.cooling > 0) {
    const auto wet = [&](std::size_t i) {
      const double critical = model.material_of_node(static_cast<Index>(i)).critical_saturation;
      return critical > 0 ? std::min(1.0, saturation[i] / critical) : (saturation[i] > 0 ? 1.0 : 0.0);
    };
    add_field<vtkFloatArray>(fields, "temperature", n, [&](std::size_t i) {
      return cloth_temperature(model.scene.air.temperature, model.wet_bulb, model.cooling, wet(i));
    });
  }
  if (model.has_solute()) {
    const std::vector<double> area = node_area(model);
    add_field<vtkDoubleArray>(fields, "solute", n, [&](std::size_t i) {
      const double mass = static_cast<double>(value_or_zero(state.node_solute, i)) * model.solute_quantum();
      return area[i] > 0 ? mass / area[i] : 0.0;
    });
  }
  add_field<vtkIntArray>(grid->GetCellData(), "cloth", model.mesh.triangle.size(),
                         [&](std::size_t t) { return model.mesh.triangle_cloth[t]; });
  return grid;
}

Offenders find_offenders(const HostState& state) {
  Offenders bad;
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i)
    if (!finite(state.fluid_position[i]) || !finite(state.fluid_velocity[i]) || state.fluid_mass[i] <= 0 ||
        state.fluid_mass[i] > 2 * quanta_per_particle)  // blocks hold up to 1.16 (setup/block_lattice.hpp)
      bad.particles.push_back(static_cast<Index>(i));
  for (std::size_t i = 0; i < state.node_position.size(); ++i)
    if (!finite(state.node_position[i]) || !finite(state.node_velocity[i]) || value_or_zero(state.node_liquid, i) < 0)
      bad.nodes.push_back(static_cast<Index>(i));
  for (std::size_t b = 0; b < state.body_position.size(); ++b) {
    const Quaternion& q = state.body_orientation[b];
    if (!finite(state.body_position[b]) || !finite(state.body_velocity[b]) || !finite(state.body_angular_velocity[b]) ||
        !std::isfinite(q[0] + q[1] + q[2] + q[3]))
      bad.bodies.push_back(static_cast<Index>(b));
  }
  return bad;
}

std::string describe(const Offenders& offenders, const HostState& state, std::size_t limit) {
  std::string text;
  if (!offenders.particles.empty())
    text = number_list("particles", offenders.particles.size(), limit,
                       [&](std::size_t i) { return state.fluid_id[static_cast<std::size_t>(offenders.particles[i])]; });
  if (!offenders.nodes.empty())
    text += (text.empty() ? "" : ", ") +
            number_list("nodes", offenders.nodes.size(), limit, [&](std::size_t i) { return offenders.nodes[i]; });
  if (!offenders.bodies.empty())
    text += (text.empty() ? "" : ", ") +
            number_list("bodies", offenders.bodies.size(), limit, [&](std::size_t i) { return offenders.bodies[i]; });
  return text;
}

Grid offender_grid(const Model& model, const HostState& state, const Offenders& offenders) {
  struct Entry {
    int kind;
    std::int64_t id;
    Vec3 position, velocity;
    Quanta mass;
  };
  std::vector<Entry> entries;
  for (const Index p : offenders.particles) {
    const auto i = static_cast<std::size_t>(p);
    entries.push_back({0, state.fluid_id[i], state.fluid_position[i], state.fluid_velocity[i], state.fluid_mass[i]});
  }
  for (const Index p : offenders.nodes) {
    const auto i = static_cast<std::size_t>(p);
    entries.push_back({1, p, state.node_position[i], state.node_velocity[i], value_or_zero(state.node_liquid, i)});
  }
  for (const Index p : offenders.bodies) {
    const auto i = static_cast<std::size_t>(p);
    entries.push_back({2, p, state.body_position[i], state.body_velocity[i], 0});
  }
  std::vector<Vec3> shown;
  for (const auto& e : entries) {
    shown.push_back(e.position);
    for (double& c : shown.back())
      if (!std::isfinite(c)) c = 0;
  }
  Grid grid = make_vertices(shown);
  vtkDataSetAttributes* fields = grid->GetPointData();
  const std::size_t n = entries.size();
  add_field<vtkIntArray>(fields, "kind", n, [&](std::size_t i) { return entries[i].kind; });
  add_field<vtkLongLongArray>(fields, "id", n, [&](std::size_t i) { return entries[i].id; });
  add_field<vtkDoubleArray>(fields, "position", n, [&](std::size_t i) { return entries[i].position; });
  add_field<vtkDoubleArray>(fields, "velocity", n, [&](std::size_t i) { return entries[i].velocity; });
  add_field<vtkDoubleArray>(fields, "mass", n,
                            [&](std::size_t i) { return static_cast<double>(entries[i].mass) * model.quantum; });
  return grid;
}

}  // namespace drench
