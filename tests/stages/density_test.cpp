// Stage density: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(density, agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::density, .changes = "fluid_density_ratio"});
}

TEST(density, of_crowded_and_light_particles_agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::density, .prepare = crowd, .changes = "fluid_density_ratio"});
}

/// Squeezed, and with particles that a cloth has just given out.
TEST(density, finds_the_same_mean_compression) {
  compare_stage({.stage = Stage::density,
                 .scene = with(wet_scene(), "end: 1.0", "end: 1.0, mode: error"),
                 .prepare =
                     [](const Model& model, HostState& s) {
                       crowd(model, s);
                       for (std::size_t i = 0; i < s.fluid_origin.size(); i += 3) {
                         s.fluid_origin[i] = static_cast<std::uint8_t>(Origin::cloth);
                         s.fluid_age[i] = 1e-3 * static_cast<double>(i % 5);
                       }
                     },
                 .changes = "fluid_density_ratio"});
}

}  // namespace drench::test
