#include "stage_compare.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "compare/decisions.hpp"
#include "pipeline/pipeline.hpp"
#include "precision.hpp"
#include "scene/load.hpp"

namespace drench::test {

Precision backend_precision() { return precision_named(double_precision ? "double" : "float"); }

std::string wet_scene() {
  return std::string(few_iterations) + R"(
    - block: {min: [-0.07, 0.011, -0.06], max: [0.07, 0.151, 0.06], velocity: [0.1, -0.6, 0.05]}
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

void overfill(const Model& m, HostState& s, Quanta parts) {
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
    s.node_liquid[n] = static_cast<Quanta>((1.02 + 0.1 * double(n % 7) / 7) * m.samples.node_capacity[n] / m.quantum);
    s.node_buffered[n] = s.node_liquid[n] / parts;
  }
}

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
  // Contact has many states within a tolerance: both take the same iterations.
  if (!setup.model.bodies.empty()) setup.model.cloth_engine = ClothEngine::reference;
  if (c.resolve) c.resolve(setup.model);
  const auto reference = make_reference_backend(setup.model);
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *reference, setup.state);
  for (int s = 0; s < c.steps_before; ++s) pipeline.step(1.0);

  StepInfo info{pipeline.step_index(), pipeline.time(), setup.model.scene.time.step};
  info.divergence_start = info.density_start = c.last_start;
  StepReport so_far, reference_report, backend_report;
  for (Stage s : pipeline.stages()) {
    if (s == c.stage) break;
    reference->run(s, info, so_far);
  }
  HostState before = reference->download();
  if (c.prepare) c.prepare(setup.model, before);
  leave_decisions(*reference, setup.model, c.stage, info, backend_precision(), before);
  // Both start from the same arrays and make what a stage hands on internally (lists, α) from them.
  run_stage_from(*reference, setup.model, c.stage, before, info, reference_report);
  run_stage_from(*backend, setup.model, c.stage, before, info, backend_report);
  const HostState expected = reference->download(), actual = backend->download();

  const auto iterations = [](const StepReport& r) {
    return fmt::format("{} of the divergence, {} of the density, {} of the cloth (residual {:.4g})",
                       r.divergence_iterations, r.density_iterations, r.cloth_iterations, r.cloth_residual);
  };
  SCOPED_TRACE("iterations: reference " + iterations(reference_report) + "; backend " + iterations(backend_report));
  const std::vector<std::string> changed = changed_fields(before, expected);
  std::istringstream wanted(c.changes);
  for (std::string name; wanted >> name;)
    EXPECT_TRUE(std::find(changed.begin(), changed.end(), name) != changed.end())
        << "the stage was to change " << name << " but changed " << testing::PrintToString(changed);
  for (const FieldDifference& d : compare_fields(setup.model, c.stage, info.dt, expected, actual, backend_precision()))
    EXPECT_LE(d.absolute, d.tolerance) << d.field << " at " << d.index << " of " << d.size << " (the backend's "
                                       << d.actual_size << "), largest " << d.largest;
  for (const HostState* s : {&expected, &actual})
    for (const std::vector<Quanta>* masses : {&s->fluid_mass, &s->node_liquid, &s->node_buffered})
      EXPECT_TRUE(std::all_of(masses->begin(), masses->end(), [](Quanta m) { return m >= 0; })) << "a mass below 0";
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
