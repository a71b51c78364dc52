#include "compare/field_difference.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "compare/field_tolerance.hpp"

namespace drench {
namespace {

double magnitude(const Vec3& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }
double magnitude(const Quaternion& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2] + a[3] * a[3]); }
double magnitude(double a) { return std::fabs(a); }
double magnitude(std::int64_t a) { return std::fabs(static_cast<double>(a)); }
double magnitude(std::uint8_t a) { return a; }
Vec3 difference(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Quaternion difference(const Quaternion& a, const Quaternion& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]};
}
double difference(double a, double b) { return a - b; }
std::int64_t difference(std::int64_t a, std::int64_t b) { return a - b; }
std::int64_t difference(std::uint8_t a, std::uint8_t b) { return std::int64_t(a) - b; }

/// The worst difference, with the largest magnitude of `a`.
std::vector<FieldDifference> raw_differences(const HostState& a, const HostState& b) {
  std::vector<FieldDifference> out;
  std::map<std::string, const void*> other;
  visit_fields(b, [&](std::string_view name, const auto& array) { other[std::string(name)] = &array; });
  visit_fields(a, [&](std::string_view name, const auto& left) {
    const auto& right = *static_cast<const std::remove_reference_t<decltype(left)>*>(other[std::string(name)]);
    FieldDifference d;
    d.field = name;
    d.unit = unit_of_field(name);
    d.size = left.size();
    d.actual_size = right.size();
    for (const auto& value : left) d.largest = std::max(d.largest, magnitude(value));
    if (left.size() != right.size()) d.absolute = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < std::min(left.size(), right.size()) && std::isfinite(d.absolute); ++i) {
      const double one = magnitude(difference(left[i], right[i]));
      if (one <= d.absolute) continue;
      d.absolute = one;
      d.index = i;
      if (!std::isfinite(one)) d.absolute = std::numeric_limits<double>::infinity();  // also NaN
    }
    out.push_back(d);
  });
  return out;
}

/// A number that has to be the same in both.
FieldDifference exact_row(const char* name, const char* unit, std::int64_t a, std::int64_t b) {
  return {name, unit, magnitude(a - b), magnitude(a), 0, 0, 1, 1};
}

}  // namespace

Precision precision_named(std::string_view name) {
  if (name == "double") return {1e-10, 1.1e-16};
  if (name == "float") return {1e-4, 6.0e-8};
  throw std::invalid_argument("no such precision: " + std::string(name));
}

std::vector<FieldDifference> compare_fields(const Model& model, Stage stage, double dt, const HostState& expected,
                                            const HostState& actual, const Precision& precision) {
  std::vector<FieldDifference> rows = raw_differences(expected, actual);
  const FieldTolerances tolerances(model, stage, dt, expected, precision, rows);
  for (FieldDifference& d : rows) d.tolerance = tolerances.of(d);
  rows.push_back(exact_row("drained", "quanta", expected.drained, actual.drained));
  rows.push_back(exact_row("evaporated", "quanta", expected.evaporated, actual.evaporated));
  if (stage == Stage::evaporation || stage == Stage::drying)  // each of them rounds once
    rows.back().tolerance = precision.tolerance * magnitude(expected.evaporated) +
                            mass_slack * static_cast<double>(expected.fluid_mass.size() + expected.node_liquid.size());
  rows.push_back(exact_row("supplied", "quanta", expected.supplied, actual.supplied));
  if (stage == Stage::diffusion && model.has_reservoirs()) {
    double held = 0;  // by the reservoirs: a sub-step moves no more than half of it
    for (const Reservoir& r : model.reservoirs)
      for (const Quanta target : r.target) held += magnitude(target);
    rows.back().tolerance = precision.tolerance * held + mass_slack;
  }
  if (model.has_solute()) {
    rows.push_back(exact_row("solute_drained", "quanta", expected.solute_drained, actual.solute_drained));
    rows.push_back(exact_row("solute_deposited", "quanta", expected.solute_deposited, actual.solute_deposited));
    FieldDifference supplied = exact_row("solute_supplied", "quanta", expected.solute_supplied, actual.solute_supplied);
    const auto mass =
        std::find_if(rows.begin(), rows.end(), [](const FieldDifference& d) { return d.field == "supplied"; });
    supplied.tolerance = mass->tolerance;
    rows.push_back(supplied);
  }
  rows.push_back(exact_row("next_id", "1", expected.next_id, actual.next_id));
  return rows;
}

std::vector<FieldDifference> compare_reports(Stage stage, const StepReport& expected, const StepReport& actual,
                                             const Precision& precision) {
  std::vector<FieldDifference> rows;
  const auto close = [&](const char* name, const char* unit, double a, double b, double scale) {
    rows.push_back({name, unit, std::isfinite(a - b) ? std::fabs(a - b) : std::numeric_limits<double>::infinity(),
                    std::fabs(a), precision.tolerance * scale, 0, 1, 1});
  };
  const auto equal = [&](const char* name, const char* unit, std::int64_t a, std::int64_t b) {
    rows.push_back(exact_row(name, unit, a, b));
  };
  switch (stage) {
    case Stage::time_step:
      close("report.dt_wanted", "s", expected.dt_wanted, actual.dt_wanted, expected.dt_wanted);
      break;
    case Stage::density:
      close("report.density_found", "1", expected.density_found, actual.density_found, 1);
      break;
    case Stage::divergence:  // errors are differences of densities, whose ratio is 1
      close("report.divergence_error", "1", expected.divergence_error, actual.divergence_error, 1);
      break;
    case Stage::forces:
      equal("report.viscosity_stages", "1", expected.viscosity_stages, actual.viscosity_stages);
      break;
    case Stage::micropolar:
      equal("report.micropolar_stages", "1", expected.micropolar_stages, actual.micropolar_stages);
      break;
    case Stage::pressure:
      close("report.density_error", "1", expected.density_error, actual.density_error, 1);
      close("report.density_error_max", "1", expected.density_error_max, actual.density_error_max,
            1 + expected.density_error_max);
      break;
    case Stage::diffusion:
      equal("report.diffusion_substeps", "1", expected.diffusion_substeps, actual.diffusion_substeps);
      break;
    case Stage::measures:
      close("report.nearest_variance", "1", expected.nearest_variance, actual.nearest_variance, 1);
      close("report.close_share", "1", expected.close_share, actual.close_share, 1);
      close("report.wet_isotropy", "1", expected.wet_isotropy, actual.wet_isotropy, 1);
      break;
    case Stage::fabric:
      for (std::size_t k = 0; k < std::min(expected.fabrics.size(), actual.fabrics.size()); ++k) {
        const FabricNumbers &e = expected.fabrics[k], &a = actual.fabrics[k];
        equal("report.fabrics.liquid", "quanta", e.liquid, a.liquid);
        close("report.fabrics.wet_area", "m²", e.wet_area, a.wet_area, e.wet_area);
        close("report.fabrics.wet_warp", "m", e.wet_warp, a.wet_warp, e.wet_warp);
        close("report.fabrics.wet_weft", "m", e.wet_weft, a.wet_weft, e.wet_weft);
      }
      break;
    case Stage::ledger:
      equal("report.mass_fluid", "quanta", expected.mass_fluid, actual.mass_fluid);
      equal("report.mass_cloth", "quanta", expected.mass_cloth, actual.mass_cloth);
      equal("report.mass_total", "quanta", expected.mass_total(), actual.mass_total());
      equal("report.solute_fluid", "quanta", expected.solute_fluid, actual.solute_fluid);
      equal("report.solute_cloth", "quanta", expected.solute_cloth, actual.solute_cloth);
      equal("report.solute_total", "quanta", expected.solute_total(), actual.solute_total());
      equal("report.particles", "1", expected.particles, actual.particles);
      equal("report.nonfinite", "1", expected.nonfinite, actual.nonfinite);
      close("report.fluid_speed", "m/s", expected.fluid_speed, actual.fluid_speed, expected.fluid_speed);
      close("report.cloth_speed", "m/s", expected.cloth_speed, actual.cloth_speed, expected.cloth_speed);
      close("report.cloth_stretch", "1", expected.cloth_stretch, actual.cloth_stretch, 1);
      close("report.mass_float", "kg", expected.mass_float, actual.mass_float, expected.mass_float);
      close("report.saturation_max", "1", expected.saturation_max, actual.saturation_max, 1);
      close("report.kinetic_energy", "J", expected.kinetic_energy, actual.kinetic_energy, expected.kinetic_energy);
      break;
    default:
      break;
  }
  return rows;
}

void drop_unmatched_remainders(HostState& expected, HostState& actual, const Precision& precision) {
  if (expected.fluid_id == actual.fluid_id) return;
  const double most = precision.tolerance * static_cast<double>(quanta_per_particle) + mass_slack;
  const auto drop = [&](HostState& s, const std::set<std::int64_t>& others) {
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < s.fluid_id.size(); ++i)
      if (others.count(s.fluid_id[i]) > 0 || magnitude(s.fluid_mass[i]) > most) kept.push_back(i);
    visit_fields(s, [&](std::string_view name, auto& array) {
      if (name.substr(0, 6) != "fluid_" || array.empty()) return;
      std::remove_reference_t<decltype(array)> part;
      for (const std::size_t i : kept) part.push_back(array[i]);
      array = std::move(part);
    });
  };
  const std::set<std::int64_t> left(expected.fluid_id.begin(), expected.fluid_id.end()),
      right(actual.fluid_id.begin(), actual.fluid_id.end());
  drop(expected, right);
  drop(actual, left);
}

std::vector<std::string> changed_fields(const HostState& before, const HostState& after) {
  std::vector<std::string> names;
  for (const FieldDifference& d : raw_differences(after, before))
    if (d.absolute > 0) names.push_back(d.field);
  return names;
}

void run_stage_from(Backend& backend, const Model& model, Stage stage, const HostState& before, const StepInfo& info,
                    StepReport& report) {
  backend.upload(before);
  if (stage > Stage::porous_neighbors) {
    if (model.meets_porous() || model.has_diffusion()) backend.run(Stage::porous_neighbors, info, report);
    const bool passes = stage == Stage::absorption || stage == Stage::emission;
    if (passes && model.has_permeation()) backend.run(Stage::permeation, info, report);
  } else if (stage > Stage::neighbors && stage <= Stage::advection && model.has_fluid()) {
    backend.run(Stage::neighbors, info, report);
    if (stage > Stage::density) backend.run(Stage::density, info, report);
  }
  backend.run(stage, info, report);
}

}  // namespace drench
