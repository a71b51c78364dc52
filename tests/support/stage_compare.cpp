#include "stage_compare.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "pipeline/pipeline.hpp"
#include "scene/load.hpp"

namespace drench::test {
namespace {

#ifdef DRENCH_DOUBLE
constexpr double tolerance = 1e-10, rounding = 1.1e-16;
#else
constexpr double tolerance = 1e-4, rounding = 6.0e-8;
#endif

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

struct FieldSummary {
  std::size_t size = 0;
  double largest = 0;
};

struct Worst {
  double difference = 0;
  std::size_t index = 0;
};

std::map<std::string, FieldSummary> summarize(const HostState& s) {
  std::map<std::string, FieldSummary> out;
  visit_fields(s, [&](std::string_view name, const auto& array) {
    FieldSummary f{array.size(), 0};
    for (const auto& value : array) f.largest = std::max(f.largest, magnitude(value));
    out[std::string(name)] = f;
  });
  return out;
}

/// The largest difference of one field; sizes must agree.
std::map<std::string, Worst> differences(const HostState& a, const HostState& b) {
  std::map<std::string, Worst> out;
  std::map<std::string, const void*> other;
  visit_fields(b, [&](std::string_view name, const auto& array) { other[std::string(name)] = &array; });
  visit_fields(a, [&](std::string_view name, const auto& left) {
    const auto& right = *static_cast<const std::remove_reference_t<decltype(left)>*>(other[std::string(name)]);
    Worst w;
    if (left.size() != right.size()) {
      w.difference = std::numeric_limits<double>::infinity();
    } else {
      for (std::size_t i = 0; i < left.size(); ++i) {
        const double d = magnitude(difference(left[i], right[i]));
        if (!(d <= w.difference)) w = {d, i};
      }
    }
    out[std::string(name)] = w;
  });
  return out;
}

bool after_advection(Stage s) { return s > Stage::porous_neighbors; }

/// The largest sum of spring constants and strain limits that meet at a node, N/m.
double stiffest_node(const ClothMesh& mesh) {
  std::vector<double> sum(mesh.rest_position.size(), 0);
  const auto add = [&](Index n, double stiffness) { sum[static_cast<std::size_t>(n)] += stiffness; };
  for (std::size_t e = 0; e < mesh.edge.size(); ++e)
    for (const Index n : mesh.edge[e]) add(n, mesh.edge_stiffness[e]);
  for (std::size_t t = 0; t < mesh.limit_stiffness.size(); ++t) {
    const auto [xx, xy, yy] = mesh.limit_shape[t];
    for (const Index n : mesh.triangle[t]) add(n, mesh.limit_stiffness[t] * (xx * xx + xy * xy + yy * yy));
  }
  return sum.empty() ? 0 : *std::max_element(sum.begin(), sum.end());
}

}  // namespace

std::string wet_scene() {
  return R"(drench: 1
time: {step: 0.002, end: 1.0}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
output: {every: 0}
fluid:
  spacing: 0.02
  viscosity: 1.0e-3
  solver: {max_iterations: 6, min_iterations: 6}
  sources:
    - block: {min: [-0.07, 0.012, -0.06], max: [0.07, 0.15, 0.06], velocity: [0.1, -0.6, 0.05]}
    - jet: {center: [0.06, 0.25, 0.0], radius: 0.025, velocity: [0, -1.5, 0.1]}
cloth:
  - name: sheet
    mesh: {grid: {size: [0.3, 0.3], nodes: [9, 9]}}
    thickness: 0.002
    pin: [{edges: true}]
    initial_saturation: [{box: {min: [-0.05, -1, -0.05], max: [0.05, 1, 0.05]}, value: 1.1}]
    hold_saturation: [{box: {min: [-0.2, -1, 0.12], max: [0.2, 1, 0.2]}, value: 0.6}]
    porous: {absorption: 0.02, diffusivity: 1.0e-3, capillary_height: 0.3, emission_velocity: 5}
bodies:
  - sphere: {center: [0, -0.06, 0], radius: 0.05}
  - plane: {point: [0, -0.2, 0], normal: [0, 1, 0]}
)";
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("the scene has no '" + from + "'");
  return text.replace(at, from.size(), to);
}

drench::Setup setup_from(const std::string& yaml) { return build(parse_scene(yaml, "test.yaml")); }

void crowd(const Model& model, HostState& s) {
  for (std::size_t i = 1; i < s.fluid_position.size(); ++i) {
    if (i % 5 == 0) s.fluid_mass[i] = s.fluid_mass[i] / 20;
    if (i % 7 != 0) continue;
    s.fluid_position[i] = s.fluid_position[i - 1];
    s.fluid_position[i][0] += 0.2 * model.spacing;
    s.fluid_position[i][2] -= 0.2 * model.spacing;
  }
}

void compare_stage(const Comparison& c) {
  drench::Setup setup = setup_from(c.scene);
  if (c.resolve) c.resolve(setup.model);
  const auto reference = make_reference_backend(setup.model);
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *reference, setup.state);
  for (int s = 0; s < c.steps_before; ++s) pipeline.step(1.0);

  StepInfo info{pipeline.step_index(), pipeline.time(), setup.model.scene.time.step};
  StepReport reference_report, backend_report;
  for (Stage s : pipeline.stages()) {
    if (s == c.stage) break;
    reference->run(s, info, reference_report);
  }
  HostState before = reference->download();
  if (c.prepare) c.prepare(setup.model, before);
  // Both start from the same arrays and make what a stage hands on internally (lists, α) from them.
  for (Backend* b : {reference.get(), backend.get()}) {
    StepReport& report = b == backend.get() ? backend_report : reference_report;
    b->upload(before);
    if (after_advection(c.stage)) {
      b->run(Stage::porous_neighbors, info, report);
    } else if (c.stage > Stage::neighbors && setup.model.has_fluid()) {
      b->run(Stage::neighbors, info, report);
      if (c.stage > Stage::density) b->run(Stage::density, info, report);
    }
    b->run(c.stage, info, report);
  }
  const HostState expected = reference->download(), actual = backend->download();

  const auto summary = summarize(expected);
  std::string changed;
  for (const auto& [name, worst] : differences(expected, before))
    if (worst.difference > 0) changed += " " + name;
  EXPECT_TRUE(c.changes.empty() || (changed + " ").find(" " + c.changes + " ") != std::string::npos)
      << "the stage was to change " << c.changes << " but changed" << changed;

  const double dt = info.dt;
  for (const auto& [name, worst] : differences(expected, actual)) {
    double scale = summary.at(name).largest;
    double slack = 0;
    if (name == "fluid_mass" || name == "node_liquid" || name == "node_ripe") {
      scale = static_cast<double>(quanta_per_particle);
      slack = 64;
    }
    if (name == "node_velocity" && (c.stage == Stage::absorption || c.stage == Stage::emission)) {
      // two quanta more or less, of the fastest liquid in the lightest node
      const auto& solid = setup.model.mesh.solid_mass;
      slack = 2 * setup.model.quantum * summary.at("fluid_velocity").largest /
              *std::min_element(solid.begin(), solid.end());
    }
    if (name == "node_velocity" && c.stage == Stage::diffusion) {
      // two quanta more or less, of the fastest node's liquid in the lightest node
      const auto& solid = setup.model.mesh.solid_mass;
      slack = 2 * setup.model.quantum * scale / *std::min_element(solid.begin(), solid.end());
    }
    if (name == "fluid_velocity" && c.stage == Stage::emission && worst.index < expected.fluid_mass.size()) {
      // a quantum more or less at twice the fastest speed in the particle that differs most
      slack = 2 * std::max(scale, summary.at("node_velocity").largest) /
              static_cast<double>(expected.fluid_mass[worst.index]);
    }
    if (name == "fluid_id" || name == "fluid_origin") scale = 0;
    if (name.find("flow_direction") != std::string::npos || name.find("normal") != std::string::npos) scale = 1;
    if (c.stage == Stage::cloth || c.stage == Stage::self_collision || c.stage == Stage::advection) {
      if (name == "node_velocity") scale = std::max(scale, summary.at("node_position").largest / dt);
      // what is left of spring forces that cancel: the stiffness of a node times the rounding of its place
      if (name == "node_contact_force" || name == "node_friction_force")
        slack = rounding * stiffest_node(setup.model.mesh) * summary.at("node_position").largest;
      if (name == "node_pin_force") {
        // a sum of spring forces k |x| that cancel
        double stiffest = 0;
        for (double k : setup.model.mesh.edge_stiffness) stiffest = std::max(stiffest, k);
        scale = std::max(scale, 6 * stiffest * setup.model.mesh.edge_length.front());
      }
    }
    EXPECT_LE(worst.difference, tolerance * scale + slack)
        << name << " at " << worst.index << " of " << summary.at(name).size << ", scale " << scale;
  }
  for (const HostState* s : {&expected, &actual})
    for (const std::vector<Quanta>* masses : {&s->fluid_mass, &s->node_liquid, &s->node_ripe})
      EXPECT_TRUE(std::all_of(masses->begin(), masses->end(), [](Quanta m) { return m >= 0; })) << "a mass below 0";
  EXPECT_EQ(expected.drained, actual.drained);
  EXPECT_EQ(expected.supplied, actual.supplied);
  EXPECT_EQ(expected.next_id, actual.next_id);
}

void compare_stage_with_every_kernel(Comparison c) {
  const std::string scene = c.scene;
  for (const std::string kernel : {"cubic", "wendland", "poly6"}) {
    SCOPED_TRACE(kernel);
    c.scene = with(scene, "fluid:\n", "fluid:\n  kernel: " + kernel + "\n");
    compare_stage(c);
  }
}

}  // namespace drench::test
