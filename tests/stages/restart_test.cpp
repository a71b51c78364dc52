// A step depends on HostState and nothing else: a backend made anew before every step gives the same bits as one that
// goes on.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <numeric>

#include "ball_mesh.hpp"
#include "pipeline/pipeline.hpp"
#include "restart_scenes.hpp"
#include "shirt_mesh.hpp"
#include "stage_compare.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

using MakeBackend = std::unique_ptr<Backend> (*)(const Model&);

/// What a stats row is made of.
std::vector<double> numbers(const StepReport& r) {
  return {r.dt_wanted,
          double(r.divergence_iterations),
          r.divergence_error,
          double(r.density_iterations),
          r.density_error,
          r.density_error_max,
          r.density_found,
          double(r.rejected),
          double(r.viscosity_stages),
          double(r.micropolar_stages),
          double(r.cloth_iterations),
          r.cloth_residual,
          double(r.cloth_contacts),
          double(r.cloth_zone_nodes),
          double(r.diffusion_substeps),
          double(r.collisions),
          double(r.clamped),
          double(r.mass_fluid),
          double(r.mass_cloth),
          double(r.mass_drained),
          double(r.mass_supplied),
          double(r.mass_evaporated),
          double(r.solute_fluid),
          double(r.solute_cloth),
          double(r.solute_supplied),
          r.mass_float,
          r.saturation_max,
          r.saturation_error,
          r.kinetic_energy,
          double(r.particles),
          r.nearest_variance,
          r.close_share,
          r.wet_isotropy};
}

Quanta before_cloth(const HostState& s) {
  return std::accumulate(s.node_liquid.begin(), s.node_liquid.end(), Quanta{0});
}

/// What happened in a run, so that no test compares steps in which nothing does.
struct Happened {
  bool fresh = false, jets = false, drained = false, absorbed = false, supplied = false, evaporated = false,
       contacts = false, substeps = false, scaled = false;
  int steps = 0;
  double fall = 0;  // m/s: mean of the nodes' velocities downwards, at the end
};

/// Runs a scene on, and beside it the same with a new backend every step that starts from what the last one left.
Happened expect_the_same_bits(MakeBackend make, const std::string& scene, int steps) {
  constexpr double frame = 0.01;  // s: steps end there
  const auto setup = setup_from(scene);
  const auto backend = make(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  HostState last = backend->download();
  Happened happened;
  int frames = 1;
  for (; happened.steps < steps; ++happened.steps) {
    const auto other = make(setup.model);
    Pipeline again(setup.model, *other, last);
    const double left = frames * frame - pipeline.time();
    const StepReport went_on = pipeline.step(left), restarted = again.step(left);
    HostState state = backend->download();
    pipeline.mark(state);
    EXPECT_EQ(numbers(went_on), numbers(restarted)) << "step " << happened.steps;
    EXPECT_EQ(different_bits(state, other->download()), "") << "step " << happened.steps;
    if (testing::Test::HasFailure()) break;
    if (pipeline.time() >= frames * frame - 1e-9) ++frames;
    for (const auto origin : state.fluid_origin) {
      happened.fresh = happened.fresh || origin == static_cast<std::uint8_t>(Origin::cloth);
      happened.jets = happened.jets || origin == static_cast<std::uint8_t>(Origin::jet) ||
                      origin == static_cast<std::uint8_t>(Origin::mouth);
    }
    happened.drained = happened.drained || state.drained > 0;
    happened.supplied = happened.supplied || state.supplied > setup.state.supplied;
    happened.evaporated = happened.evaporated || state.evaporated > 0;
    happened.absorbed = happened.absorbed || went_on.mass_cloth > before_cloth(last);
    happened.contacts = happened.contacts || went_on.cloth_contacts > 0;
    happened.scaled = happened.scaled || last.density_start > 2;
    happened.substeps = happened.substeps || went_on.diffusion_substeps > 0;
    last = std::move(state);
  }
  for (const Vec3& v : last.node_velocity) happened.fall -= v[1] / double(last.node_velocity.size());
  return happened;
}

/// The reference computes the pairs of everything with everything, and its state is the HostState itself: fewer steps.
class Restart : public testing::TestWithParam<MakeBackend> {
 protected:
  static Happened run(const std::string& scene, int steps) {
    return expect_the_same_bits(GetParam(), scene, GetParam() == &make_kokkos_backend ? steps : 8);
  }
  /// Only the backend takes enough steps for everything to happen.
  static void expect(bool happened, const char* what) {
    EXPECT_TRUE(happened || GetParam() != &make_kokkos_backend) << "no " << what;
  }
};

TEST_P(Restart, LiquidWithJetsAndBodies) {
  const Happened h = run(liquid_scene, 150);
  expect(h.jets, "jet");
  expect(h.drained, "particle has left");
}

/// After two steps a backend goes back by one and takes it again.
TEST_P(Restart, GoingBackIsExact) {
  const std::string in_air = with(porous_scene, "output:", "air: {evaporation_rate: 0.5}\noutput:");
  const std::string filmed =
      with(porous_scene, "porous: {max_saturation: 1.5,", "porous: {film: 6.0e-4, film_viscosity: 1.0e-6,");
  const std::string squeezed =
      with(porous_scene, "porous: {max_saturation: 1.5,", "porous: {compressibility: 0.5, max_saturation: 1.5,");
  const std::string drained = with(porous_scene, "adhesion: 0.1, contact_wicking: true",
                                   "adhesion: 0.1, drainage_height: 0.5, large_pores: 0.5, "
                                   "large_pore_height: 0.05");
  for (const std::string& scene : {std::string(liquid_scene), std::string(porous_scene), in_air, filmed, squeezed,
                                   drained, std::string(cloth_scene)}) {
    const auto setup = setup_from(scene);
    const auto backend = GetParam()(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    const auto step = [&](double dt) {
      StepReport report;
      for (const Stage stage : pipeline.stages()) backend->run(stage, {3, 0.01, dt, 100}, report);
      return report;
    };
    for (int k = 0; k < 3; ++k) step(0.002);
    backend->keep();
    const HostState before = backend->download();
    const StepReport first = step(0.003);
    const HostState once = backend->download();
    backend->go_back();
    EXPECT_EQ(different_bits(before, backend->download()), "");
    step(0.001);
    backend->go_back();
    EXPECT_EQ(numbers(first), numbers(step(0.003)));
    EXPECT_EQ(different_bits(once, backend->download()), "");
  }
}

TEST_P(Restart, StepsThatKnowTheirError) {
  run(with(liquid_scene, "mode: cfl", "mode: error, tolerance: 2.0e-3"), 100);
  run(with(porous_scene, "end: 1}", "end: 1, mode: error}"), 30);
}

TEST_P(Restart, StartsThatAreScaled) {
  const Happened h = run(R"(drench: 1
time: {step: 0.004, end: 1}
fluid:
  spacing: 0.05
  viscosity: 1.0e-3
  solver: {density_error: 1.0e-4, divergence_error: 1.0e-4}
  sources: [{block: {min: [0, 0, 0], max: [0.5, 0.5, 0.5]}}]
bodies: [{box: {min: [0, 0, 0], max: [0.5, 1, 0.5], inside: true}}]
)",
                         60);
  expect(h.scaled, "scaled start");
}

TEST_P(Restart, PorousCloth) {
  const Happened h = run(porous_scene, 40);
  expect(h.jets, "jet");
  expect(h.fresh, "fresh particles");
  expect(h.absorbed, "absorption");
  expect(h.supplied, "supply");
  expect(h.contacts, "contacts");
  expect(h.substeps, "diffusion");
}

TEST_P(Restart, ClothOfSeveralFabrics) {
  const Happened h = run(with(porous_scene, "    pin: [{nodes", std::string(scene_regions) + "    pin: [{nodes"), 40);
  expect(h.absorbed, "absorption");
  expect(h.contacts, "contacts");
  expect(h.substeps, "diffusion");
}

TEST_P(Restart, LiquidAndClothInAir) {
  const Happened h = run(with(porous_scene, "output:", "air: {evaporation_rate: 0.5}\noutput:"), 40);
  expect(h.fresh, "fresh particles");
  expect(h.evaporated, "evaporation");
}

TEST_P(Restart, ClothAlone) { expect(run(cloth_scene, 40).contacts, "contacts"); }

/// On a GPU Newton's kernel solves it: nodes of a patch that read each other while they are written would show here.
TEST_P(Restart, AGarmentOnABody) {
  const auto file = [](const std::string& name, const TestMesh& mesh) {
    const std::string path = own_file(name + ".obj").string();
    std::ofstream(path) << obj_of(mesh);
    return path;
  };
  const Happened h = run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 1}}
domain: {{min: [-0.7, -0.5, -0.7], max: [0.7, 1.2, 0.7]}}
cloth:
  - name: shirt
    mesh: {{file: {}}}
    place: {{position: [0, 0.02, 0]}}
    fabric: polyester_jersey
    warp: [0, 1, 0]
    friction: 0.4
bodies: [{{mesh: {{file: {}}}}}]
)",
                                     file("restarted_shirt", shirt_mesh(20)), file("restarted_form", form_mesh(40))),
                         40);
  expect(h.fall < 0.5 * 9.81 * 40 * 0.004, "contact");
}

TEST_P(Restart, WhatKeysMove) { expect(run(keyed_scene, 60).jets, "jet"); }

TEST_P(Restart, EmittersThatMoveAndDrains) {
  const std::string files = write_shapes("restarted_mouth", 4, ball_mesh(1), [](int k, const Eigen::Vector3d& x) {
    return Eigen::Vector3d((0.03 + 0.005 * k) * x + Eigen::Vector3d(0.02 * k, 0.2, 0.01 * k * k));
  });
  const Happened h =
      run(with(emitters_scene, "  drains:",
               "    - mesh_jet: {sequence: \"" + files + "\", fps: 40, speed: 0.7}\n" + moving_spray + "  drains:"),
          60);
  expect(h.jets, "jet");
  expect(h.drained, "drain");
}

TEST_P(Restart, BodiesThatChangeTheirShape) {
  const std::string files = write_shapes("restarted", 6, ball_mesh(2), [](int k, const Eigen::Vector3d& x) {
    return Eigen::Vector3d((0.03 + 0.004 * k) * Eigen::Vector3d(x[0], x[1], x[2] + 0.1 * k * x[1]) +
                           Eigen::Vector3d(0.03, 0.06 + 0.003 * k, 0));
  });
  const auto last = std::string(liquid_scene).rfind("  - sphere:");
  const std::string scene =
      std::string(liquid_scene).substr(0, last) + "  - mesh: {sequence: \"" + files + "\", fps: 80}\n";
  expect(run(scene, 60).jets, "jet");
  run(with(scene, "mode: cfl", "mode: error"), 30);
}

TEST_P(Restart, StillCloth) {
  const Happened h = run(filter_scene, 100);
  expect(h.absorbed, "absorption");
  expect(h.supplied, "supply");
  expect(h.substeps, "diffusion");
}

/// Had a checkpoint not got them, these tests would see it.
TEST(RestartSees, WhatAStepTakesFromTheOneBefore) {
  const auto setup = setup_from(porous_scene);
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  for (int k = 0; k < 20; ++k) pipeline.step(1);
  const HostState before = backend->download();
  pipeline.step(1);
  const HostState after = backend->download();
  for (const char* name : {"fluid_kappa_density", "fluid_kappa_divergence", "fluid_age", "fluid_spin", "fluid_solute",
                           "node_solute", "node_buffered", "node_velocity"}) {
    HostState without = before;
    visit_fields(without, [&](std::string_view field, auto& values) {
      if (field == name) std::fill(values.begin(), values.end(), typename std::decay_t<decltype(values)>::value_type{});
    });
    const auto other = make_kokkos_backend(setup.model);
    Pipeline again(setup.model, *other, without);
    again.step(1);
    EXPECT_NE(different_bits(after, other->download()), "") << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, Restart, testing::Values(&make_kokkos_backend, &make_reference_backend),
                         [](const auto& which) { return which.index == 0 ? "kokkos" : "reference"; });

}  // namespace
}  // namespace drench::test
