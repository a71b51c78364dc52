// Stage reservoir: backend against reference from identical input.

#include <gtest/gtest.h>

#include "pipeline/backend.hpp"
#include "pipeline/pipeline.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"

namespace drench::test {

TEST(reservoir, agrees_with_the_reference) { compare_stage({.stage = Stage::reservoir, .changes = "node_liquid"}); }

TEST(reservoir, takes_what_is_buffered_too) {
  compare_stage({.stage = Stage::reservoir,
                 .prepare =
                     [](const Model& m, HostState& s) {
                       for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
                         s.node_buffered[n] = s.node_liquid[n] =
                             static_cast<Quanta>(3 * m.samples.node_capacity[n] / m.quantum);
                     },
                 .changes = "node_buffered"});
}

TEST(reservoir, what_reservoirs_supply_is_compared_as_closely_as_masses) {
  // Every flow out of a reservoir is rounded to quanta, in every sub-step: in float some of them to one more or less.
  const auto setup = setup_from(R"(drench: 1
time: {step: 0.02, end: 1}
cloth:
  - mesh: {grid: {size: [0.05, 0.2], nodes: [11, 41]}}
    place: {position: [0, 0.1, 0], rotate: {axis: [1, 0, 0], degrees: 90}}
    dynamics: false
    hold_saturation: [{box: {min: [-1, -0.001, -1], max: [1, 0.011, 1]}, value: 1}]
    porous: {diffusivity: 2.0e-3, capillary_height: 0.15}
)");
  const auto reference = make_reference_backend(setup.model), backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *reference, setup.state);
  for (int s = 0; s < 20; ++s) pipeline.step(1.0);
  const HostState before = reference->download();
  StepReport report;
  for (Backend* b : {reference.get(), backend.get()})
    run_stage_from(*b, setup.model, Stage::diffusion, before, {0, 0.0, 0.02}, report);
  const HostState expected = reference->download(), actual = backend->download();
  const auto supplied_is_over = [&](const HostState& s) {
    for (const FieldDifference& d :
         compare_fields(setup.model, Stage::diffusion, 0.02, expected, s, backend_precision()))
      if (d.field == "supplied") return d.over();
    ADD_FAILURE() << "no row";
    return false;
  };
  EXPECT_FALSE(supplied_is_over(actual)) << expected.supplied - actual.supplied;
  HostState wrong = expected;
  wrong.supplied -=
      (expected.supplied - before.supplied) / report.diffusion_substeps / 2;  // half a sub-step's is missing
  EXPECT_TRUE(supplied_is_over(wrong));
}

/// A strip that begins full and can hold no more drains into a bath at its lower end, which is as full.
TEST(reservoir, a_full_strip_drains_into_a_full_bath) {
  const std::string scene = R"(drench: 1
time: {step: 0.05, end: 20}
cloth:
  - mesh: {grid: {size: [0.02, 0.1], nodes: [3, 21]}}
    place: {position: [0, 0.05, 0], rotate: {axis: [1, 0, 0], degrees: 90}}
    dynamics: false
    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 1}]
    hold_saturation: [{box: {min: [-1, -0.001, -1], max: [1, 0.001, 1]}, value: 1}]
    porous: {diffusivity: 2.0e-3, diffusion: degenerate, capillary_height: 0.05, max_saturation: 1}
)";
  for (const int steps : {0, 4})
    compare_stage({.stage = Stage::diffusion, .scene = scene, .steps_before = steps, .changes = "node_liquid"});
  const auto setup = setup_from(scene);
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  while (pipeline.time() < 20 - 1e-9) pipeline.step(20 - pipeline.time());
  const HostState s = backend->download();
  double held = 0, room = 0;
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
    const double capacity = setup.model.samples.node_capacity[n] / setup.model.quantum;
    EXPECT_LE(static_cast<double>(s.node_liquid[n]), capacity + 1);
    held += static_cast<double>(s.node_liquid[n]);
    room += capacity;
  }
  // In equilibrium s = 1 - y / 0.05 m up to 0.05 m: a quarter of the whole.
  EXPECT_NEAR(held / room, 0.25, 0.02);
}

}  // namespace drench::test
