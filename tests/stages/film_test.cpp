// Films on soaked fabric: backend against reference from identical input.

#include <gtest/gtest.h>

#include <cmath>

#include "stage_compare.hpp"
#include "states.hpp"
#include "two_layers.hpp"

namespace drench::test {
namespace {

/// A soaked sheet on a slope of 40°, whose film is up to 0.5 mm thick on each face.
std::string filmed() {
  return with(with(wet_scene(), "emission_velocity: 5", "emission_velocity: 5, film: 0.0005, film_viscosity: 1.0e-4"),
              "    thickness: 0.002\n",
              "    thickness: 0.002\n    settle: 1\n    place: {rotate: {axis: [1, 0, 0], degrees: 40}}\n");
}

/// From half-filled pores to the thickest film.
void soak(const Model& m, HostState& s) {
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
    const double most = m.material_of_node(static_cast<Index>(n)).max_saturation;
    const double saturation = 0.5 + (most - 0.5) * double(n * 7 % 11) / 10;
    s.node_liquid[n] = static_cast<Quanta>(saturation * m.samples.node_capacity[n] / m.quantum);
    s.node_velocity[n] = {noise(n, 0), noise(n, 1), noise(n, 2)};
  }
}

}  // namespace

TEST(film, runs_down_as_in_the_reference) {
  for (const char* law : {"diffusion: linear", "diffusion_exponent: 3, retention_exponent: 1.5"}) {
    SCOPED_TRACE(law);
    compare_stage({.stage = Stage::diffusion,
                   .scene = with(filmed(), "film:", std::string(law) + ", film:"),
                   .prepare = soak,
                   .changes = "node_liquid node_velocity"});
  }
}

TEST(film, in_regions_runs_as_in_the_reference) {
  compare_stage({.stage = Stage::diffusion,
                 .scene = with(filmed(), "    settle: 1\n",
                               "    settle: 1\n    regions: [{box: {min: [-1, -1, -1], max: [0.03, 1, 1]}, "
                               "thickness: 0.003, porous: {solid_fraction: 0.6, diffusivity: 3.0e-4}}]\n"),
                 .prepare = soak,
                 .changes = "node_liquid node_velocity"});
}

TEST(film, passes_to_layers_by_contact_as_in_the_reference) {
  compare_stage({.stage = Stage::diffusion,
                 .scene = with(with(two_layers("film: 0.0004, film_viscosity: 1.0e-5"), "cloth:\n",
                                    "fluid: {spacing: 0.02}\ncloth:\n"),
                               "diffusivity: 3.0e-5,", "diffusivity: 3.0e-5, film: 0.0002,"),
                 .prepare = soak,
                 .changes = "node_liquid"});
}

TEST(film, drips_as_in_the_reference) {
  compare_stage({.stage = Stage::emission,
                 .scene = filmed(),
                 .steps_before = 2,
                 .prepare =
                     [](const Model& m, HostState& s) {
                       soak(m, s);
                       for (Vec3& x : s.fluid_position) x[1] += 0.3;
                     },
                 .changes = "node_liquid node_buffered"});
}

TEST(film, takes_up_liquid_as_in_the_reference) {
  compare_stage(
      {.stage = Stage::absorption, .scene = filmed(), .steps_before = 2, .prepare = soak, .changes = "node_liquid"});
}

TEST(film, on_permeable_cloth_agrees_with_the_reference) {
  // Some of its points are open.
  const std::string scene = with(filmed(), "film:", "permeability: 1.0e-9, film:");
  for (const Stage stage : {Stage::absorption, Stage::emission}) {
    SCOPED_TRACE(name_of(stage));
    compare_stage({.stage = stage,
                   .scene = scene,
                   .steps_before = 3,
                   .prepare =
                       [](const Model& m, HostState& s) {
                         soak(m, s);
                         for (std::size_t p = 0; p < s.sample_flux.size(); ++p)
                           s.sample_flux[p] = p % 5 == 0 ? 0.02 : 0;
                       },
                   .changes = "node_liquid"});
  }
}

}  // namespace drench::test
