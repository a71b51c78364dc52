// A stage that a scene does not need launches nothing and allocates nothing: porous cloth.

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>

#include "watched_labels.hpp"
#include "watched_scenes.hpp"

namespace drench::test {
namespace {

constexpr const char* dry_cloth = R"(drench: 1
time: {step: 0.002, end: 1}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.05, 0.02, -0.05], max: [0.05, 0.1, 0.05]}}]}
cloth: [{mesh: {grid: {size: [0.2, 0.2], nodes: [6, 6]}}, pin: [{corners: true}]}]
)";

}  // namespace

TEST(only_what_is_needed, cloth_that_is_not_porous_runs_no_porous_stage) {
  const Watch watch(dry_cloth);
  EXPECT_GT(containing(launched, {"drench::pressure"}), 0);
  EXPECT_EQ(containing(launched, porous_labels), 0);
}

TEST(only_what_is_needed, layers_pass_liquid_only_where_asked_for) {
  const std::initializer_list<const char*> label = {"contact_wicking"};
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  {
    const Watch watch(with(wet_scene(), "porous: {", "porous: {contact_wicking: true, "));
    EXPECT_EQ(containing(launched, label), 6) << "find, clear, offer, limit, transfer, velocity";
    EXPECT_EQ(containing(allocated, label), 8);
  }
  const Watch watch(with(with(wet_scene(), "porous: {", "porous: {contact_wicking: true, "),
                         "output:", "processes: {diffusion: off}\noutput:"));
  EXPECT_EQ(containing(launched, label) + containing(launched, {"::diffusion"}) + containing(allocated, label), 0);
}

TEST(only_what_is_needed, films_have_arrays_only_where_asked_for_and_no_kernel) {
  const std::initializer_list<const char*> label = {"film", "hem"};
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  const Watch watch(with(wet_scene(), "porous: {", "porous: {film: 3.0e-4, "));
  EXPECT_EQ(containing(allocated, label), 3) << "pairs, hem, pull";
  EXPECT_EQ(containing(launched, label), 0);
}

TEST(only_what_is_needed, pores_are_pressed_only_where_asked_for) {
  const std::initializer_list<const char*> label = {"squeezing", "pores", "ceiling", "contact_pressure"};
  const std::string off = wet_scene(), on = with(off, "porous: {", "porous: {compressibility: 0.5, ");
  for (const std::string& scene : {off, with(on, "thickness: 0.002", "dynamics: false\n    thickness: 0.002")}) {
    const Watch watch(scene);
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  const Watch watch(on);
  EXPECT_EQ(containing(launched, label), 2) << "force, pores; without self_collision no pairs";
  EXPECT_EQ(containing(allocated, label), 11)
      << "pull, smooth, acceleration, wall, push, load, share, count; pores, ceiling, "
         "contact_pressure";
}

TEST(only_what_is_needed, only_fabric_with_hysteresis_turns) {
  const std::initializer_list<const char*> label = {"diffusion::turn", "scanning", "extreme"};
  const std::string off = with(wet_scene(), "diffusivity: 1.0e-3", "diffusion: degenerate, diffusivity: 1.0e-3");
  for (const char* same : {"porous: {", "porous: {drainage_height: 0.3, "}) {
    const Watch watch(with(off, "porous: {", same));
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  const Watch watch(with(off, "porous: {", "porous: {drainage_height: 0.5, "));
  EXPECT_EQ(containing(launched, label), 1);
  EXPECT_EQ(containing(allocated, label), 2) << "scanning, extreme";
}

TEST(only_what_is_needed, only_pores_of_two_sizes_have_suctions_of_their_own) {
  const std::initializer_list<const char*> label = {"diffusion::suction"};
  const std::string off = with(wet_scene(), "diffusivity: 1.0e-3", "diffusion: degenerate, diffusivity: 1.0e-3");
  {
    const Watch watch(off);
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  const Watch watch(with(off, "porous: {", "porous: {large_pores: 0.5, large_pore_height: 0.05, "));
  EXPECT_EQ(containing(launched, label), 1);
  EXPECT_EQ(containing(allocated, label), 1) << "suctions";
}

TEST(only_what_is_needed, only_pores_that_stretching_narrows_are_measured) {
  const std::initializer_list<const char*> label = {"diffusion::narrow", "rest_square"};
  const std::string off = with(wet_scene(), "diffusivity: 1.0e-3", "diffusion: degenerate, diffusivity: 1.0e-3");
  {
    const Watch watch(off);
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  const Watch watch(with(off, "porous: {", "porous: {pore_narrowing: 1, "));
  EXPECT_EQ(containing(launched, label), 1);
  EXPECT_EQ(containing(allocated, label), 2) << "rest_square, narrowing";
}

TEST(only_what_is_needed, only_fabric_that_expands_has_lengths_of_its_own) {
  const std::initializer_list<const char*> label = {"cloth::expand", "dry_l", "dry_shape"};
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  const Watch watch(with(wet_scene(), "porous: {", "porous: {hygral_expansion: 0.1, "));
  EXPECT_GT(containing(launched, label), 0);
  EXPECT_EQ(containing(allocated, label), 2) << "dry_length, dry_link_length; no triangle has a stress";
}

TEST(only_what_is_needed, only_liquid_with_a_solute_has_kernels_and_arrays_for_it) {
  const std::initializer_list<const char*> label = {"solute"};
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  {
    const Watch watch(with(wet_scene(), "velocity: [0, -1.5, 0.1]}", "velocity: [0, -1.5, 0.1], concentration: 0.01}"));
    EXPECT_EQ(containing(launched, label), 10) << "absorption 2, emission 2 where it drips, diffusion 2, reservoir 1, "
                                                  "ledger 2; and advection where liquid leaves";
    EXPECT_EQ(containing(allocated, label), 8) << "particles, nodes, transfer, emission 3, pairs, reservoir";
  }
}

TEST(only_what_is_needed, pressure_drives_liquid_through_only_where_asked_for) {
  const std::initializer_list<const char*> label = {"permeation", "absorption::pull", "sample_flux", "sample_passing"};
  const std::string scene = with(wet_scene(), "porous: {", "porous: {permeability: 1.0e-9, ");
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  {
    const Watch watch(scene);
    EXPECT_EQ(containing(launched, {"drench::permeation::", "drench::absorption::pull"}), 4)
        << "clear, sides, drive, pull";
    EXPECT_EQ(containing(allocated, label), 5) << "sides, supply, pull, the flux and what passes";
  }
  for (const char* process : {"direction", "absorption", "emission"}) {
    const Watch watch(with(scene, "output:", std::string("processes: {") + process + ": off}\noutput:"));
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0) << process;
  }
}

TEST(only_what_is_needed, liquid_and_cloth_dry_only_in_air) {
  const std::initializer_list<const char*> label = {"drench::evaporation::", "drench::drying::"};
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  {
    const Watch watch(with(wet_scene(), "output:", "air: {}\noutput:"));
    EXPECT_EQ(containing(launched, label), 9) << "colour, normal, flat, taken, loss; clear, sides, open, nodes";
    EXPECT_EQ(containing(allocated, label), 12)
        << "colour, number, solid, moment, normal, inside, flat, near_inside, moment_of_inside, taken; sides, open";
  }
  {
    const Watch watch(with(wet_scene(), "output:", "air: {humidity: 1}\noutput:"));
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
}

TEST(only_what_is_needed, diffusion_carries_momentum_only_in_cloth_that_moves) {
  const std::initializer_list<const char*> launches = {"::give_velocity", "wicking::velocity"};
  const std::initializer_list<const char*> arrays = {"diffusion::velocity", "diffusion::next_velocity",
                                                     "wicking::momentum"};
  const std::string scene = with(wet_scene(), "porous: {", "porous: {contact_wicking: true, ");
  {
    const Watch watch(scene);
    EXPECT_EQ(containing(launched, launches), 2);
    EXPECT_EQ(containing(allocated, arrays), 3);
  }
  const Watch watch(with(scene, "thickness: 0.002", "dynamics: false\n    thickness: 0.002"));
  EXPECT_GT(containing(launched, {"drench::contact_wicking", "drench::diffusion"}), 8);
  EXPECT_EQ(containing(launched, launches), 0);
  EXPECT_EQ(containing(allocated, arrays), 0);
}

TEST(only_what_is_needed, a_process_that_is_off_has_no_kernel_and_no_memory) {
  const auto run = [](const std::string& processes, std::initializer_list<const char*> parts) {
    SCOPED_TRACE(processes);
    const Watch watch(with(wet_scene(), "output:", "processes: {" + processes + "}\noutput:"));
    EXPECT_EQ(containing(launched, parts) + containing(allocated, parts), 0);
  };
  {
    const Watch watch(wet_scene());
    for (const char* part : {"drench::flow_direction", "drench::absorption", "drench::emission", "drench::diffusion",
                             "drench::advection::fresh"})
      EXPECT_GT(containing(launched, {part}), 0) << part;
  }
  run("direction: off", {"drench::flow_direction"});
  run("absorption: off", {"drench::absorption"});
  run("emission: off", {"drench::emission", "drench::advection::fresh"});
  run("diffusion: off", {"drench::diffusion"});
  run("absorption: off, emission: off, diffusion: off",
      {"drench::flow_direction", "drench::absorption", "drench::emission", "drench::diffusion", "drench::transfer"});
}

TEST(only_what_is_needed, numbers_of_fabric_only_where_asked_for) {
  const std::initializer_list<const char*> kernels = {"drench::fabric"}, label = {"drench::fabric", "taken_", "given_"};
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  const std::string scene = with(wet_scene(), "every: 0", "every: 0, fabric: true");
  {
    const Watch watch(scene);
    EXPECT_EQ(containing(launched, kernels), 6) << "clear, taken, given; liquid, patch, faces";
    EXPECT_EQ(containing(allocated, label), 7) << "front, four accounts, rest_uv, rest_area";
  }
  const Watch watch(with(scene, "output:", "processes: {absorption: off, emission: off}\noutput:"));
  EXPECT_EQ(containing(launched, kernels), 2) << "liquid, patch";
  EXPECT_EQ(containing(allocated, label), 2);
}

}  // namespace drench::test
