// A stage that a scene does not need launches nothing and allocates nothing: liquid, bodies and the cloth's motion.

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>

#include "ball_on_sheet.hpp"
#include "mesh_sequence.hpp"
#include "watched_labels.hpp"
#include "watched_scenes.hpp"

namespace drench::test {
namespace {

constexpr const char* no_fluid = R"(drench: 1
time: {step: 0.002, end: 1}
cloth: [{mesh: {grid: {size: [0.2, 0.2], nodes: [6, 6]}}, pin: [{corners: true}]}]
)";

}  // namespace

TEST(only_what_is_needed, every_label_names_the_project) {
  const Watch watch(wet_scene());
  EXPECT_GT(launched.size(), 40u);
  for (const std::string& label : launched) {
    if (label.find("Kokkos::") == std::string::npos) {
      EXPECT_EQ(label.rfind("drench::", 0), 0u) << label;
    }
  }
  EXPECT_GT(containing(launched, porous_labels), 5);
  EXPECT_GT(containing(allocated, {"sample", "node"}), 10);
}

TEST(only_what_is_needed, without_cloth_no_cloth_or_porous_kernel_and_no_memory_for_them) {
  const Watch watch(no_cloth);
  EXPECT_GT(containing(launched, {"drench::pressure"}), 0);
  EXPECT_EQ(containing(launched, porous_labels), 0);
  EXPECT_EQ(containing(launched, {"::cloth", "::node", "sample"}), 0);
  for (const std::string& label : allocated)
    for (const char* part : {"sample", "node", "cloth", "edge", "hinge", "triangle"})
      EXPECT_EQ(label.find(part), std::string::npos) << label;
}

TEST(only_what_is_needed, bodies_at_rest_cost_no_kernel_of_moving_ones) {
  const std::initializer_list<const char*> moving = {"drench::bodies", "drench::body_", "distance_field"};
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, moving) + containing(allocated, moving), 0);
  }
  const std::string spinning =
      with(wet_scene(), "radius: 0.05}", "radius: 0.05, spin: {axis: [0, 1, 0], degrees_per_second: 90}}");
  {
    const Watch watch(spinning);
    EXPECT_EQ(containing(launched, {"drench::bodies"}), 3) << "solids, motion, samples";
  }
}

TEST(only_what_is_needed, only_bodies_that_change_their_shape_have_kernels_for_it) {
  const auto sphere = [](const std::string& files) {
    return with(wet_scene(), "  - sphere: {center: [0, -0.06, 0], radius: 0.05}",
                "  - mesh: {sequence: \"" + files + "\", fps: 100}");
  };
  const auto moving = [](double growth) {
    return [growth](int k, const Eigen::Vector3d& x) {
      return Eigen::Vector3d((1 + growth * k) * x + Eigen::Vector3d(0.01 * k, -0.06, 0));
    };
  };
  const std::initializer_list<const char*> labels = {"deforming"};
  {
    const Watch watch(sphere(write_boxes("watched_rigid", 3, {0.03, 0.03, 0.03}, moving(0))));
    EXPECT_EQ(containing(launched, labels) + containing(allocated, labels), 0);
  }
  {
    const Watch watch(sphere(write_boxes("watched_soft", 3, {0.03, 0.03, 0.03}, moving(0.01))));
    EXPECT_EQ(containing(launched, {"drench::deforming_body"}), 14) << "surface 3, lists 5, distances 3, samples 3";
  }
}

TEST(only_what_is_needed, moving_emitters_and_drains_cost_only_scenes_that_have_them) {
  const std::initializer_list<const char*> labels = {"jets::leaving", "advection::drains"};
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, labels) + containing(allocated, labels), 0);
    EXPECT_EQ(containing(launched, {"jets::particles"}), 1);
  }
  {
    const Watch watch(
        with(wet_scene(), "velocity: [0, -1.5, 0.1]}", "velocity: [0, -1.5, 0.1], motion: {velocity: [1, 0, 0]}}"));
    EXPECT_EQ(containing(launched, {"jets::leaving"}), 1);
    EXPECT_EQ(containing(allocated, {"jets::leaving"}), 1);
    EXPECT_EQ(containing(launched, {"jets::particles"}) + containing(allocated, {"jet_offsets"}), 0);
  }
  {
    const Watch watch(
        with(no_cloth, "spacing: 0.02,", "spacing: 0.02, drains: [{sphere: {center: [0, 0, 0], radius: 0.03}}],"));
    EXPECT_EQ(containing(allocated, {"advection::drains"}), 1);
  }
}

TEST(only_what_is_needed, without_fluid_no_fluid_or_porous_kernel) {
  const Watch watch(no_fluid);
  EXPECT_GT(containing(launched, {"drench::cloth"}), 0);
  EXPECT_EQ(containing(launched, porous_labels), 0);
  EXPECT_EQ(
      containing(launched, {"::density", "::divergence", "::pressure", "::forces", "::neighbors", "::cell_table"}), 0);
}

TEST(only_what_is_needed, strain_limits_weaves_and_moving_pins_cost_only_scenes_that_have_them) {
  const auto count = [](const std::set<std::string>& labels) {
    return containing(labels, {"limit", "membrane", "plate", "triangle_", "cloth::saturation", "pin_motion", "pin_step",
                               "::pins", "rest_position"});
  };
  {
    const Watch watch(no_fluid);
    EXPECT_EQ(count(launched) + count(allocated), 0);
  }
  {
    const Watch watch(with(no_fluid, "pin: [{corners: true}]", "strain_limit: 0.1, pin: [{corners: true}]"));
    EXPECT_EQ(containing(allocated, {"limit", "triangle_"}), 4);
    EXPECT_EQ(containing(allocated, {"membrane", "plate"}), 0);
  }
  {
    const Watch watch(with(no_fluid, "pin: [{corners: true}]",
                           "membrane: {warp: 500, weft: 400, shear: 100}, pin: [{corners: true}]"));
    EXPECT_EQ(containing(allocated, {"membrane", "triangle_"}), 4);
    EXPECT_EQ(containing(allocated, {"limit", "plate", "cloth::saturation"}), 0);
  }
  {
    const Watch watch(with(no_fluid, "pin: [{corners: true}]",
                           "bending: {warp: 1.0e-4, weft: 1.0e-4, twist: 1.0e-4}, pin: [{corners: true}]"));
    EXPECT_EQ(containing(allocated, {"plate"}), 1);
    EXPECT_EQ(containing(allocated, {"limit", "membrane", "triangle_"}), 0);
  }
  {
    const Watch watch(with(no_fluid, "corners: true", "corners: true, velocity: [0, 1, 0]"));
    EXPECT_EQ(containing(launched, {"::pins"}), 1);
    EXPECT_EQ(containing(allocated, {"pin_motion", "pin_steps", "node_rest_position"}), 3);
    EXPECT_EQ(containing(allocated, {"pin_stiffness"}), 0);
  }
  {
    const Watch watch(with(no_fluid, "corners: true", "corners: true, stiffness: 100"));
    EXPECT_EQ(containing(allocated, {"pin_stiffness"}), 1);
  }
}

TEST(only_what_is_needed, regions_cost_no_kernel_and_only_their_numbers) {
  { const Watch first(wet_scene()); }  // some arrays stay for the process
  const Watch without(wet_scene());
  const std::set<std::string> kernels = launched, arrays = allocated;
  EXPECT_EQ(containing(arrays, {"_material"}), 0);
  const Watch with_regions(with(
      wet_scene(), "    pin:", "    regions: [{box: {min: [0, -1, -1], max: [1, 1, 1]}, stretch: 900}]\n    pin:"));
  EXPECT_EQ(launched, kernels);
  std::set<std::string> more;
  std::set_difference(allocated.begin(), allocated.end(), arrays.begin(), arrays.end(),
                      std::inserter(more, more.end()));
  EXPECT_EQ(more, (std::set<std::string>{"drench::node_material", "drench::sample_material"}));
}

TEST(only_what_is_needed, cloth_collides_with_itself_only_where_asked_for) {
  const std::initializer_list<const char*> label = {"self_collision"};
  for (const std::string& scene : {wet_scene(), std::string(no_fluid)}) {
    const Watch watch(scene);
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  {
    const Watch watch(with(no_fluid, "pin: [{corners: true}]", "pin: [{corners: true}], self_collision: true"));
    EXPECT_GT(containing(launched, label), computes_on_host() ? 5 : 0);  // a GPU may have one kernel for all laws
    EXPECT_EQ(containing(launched, {"::zone", "::hook", "::push"}), 0) << "nothing touches";
  }
  const Watch still(with(no_fluid, "pin: [{corners: true}]", "dynamics: false, self_collision: true"));
  EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
}

TEST(only_what_is_needed, wet_cloth_sticks_only_where_asked_for) {
  const std::initializer_list<const char*> label = {"wet_adhesion"};
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  {
    const Watch watch(with(wet_scene(), "porous: {", "porous: {adhesion: 0.1, "));
    EXPECT_EQ(containing(launched, label), 1) << "solids; no search, for the scene has no self_collision";
    EXPECT_EQ(containing(allocated, label), 0);
  }
}

TEST(only_what_is_needed, surface_tension_takes_only_what_tension_or_adhesion_asks_for) {
  const auto count = [](const std::set<std::string>& labels) { return containing(labels, {"surface_tension"}); };
  for (const std::string& scene : {wet_scene(), std::string(no_cloth)}) {
    const Watch watch(scene);
    EXPECT_EQ(count(launched) + count(allocated), 0);
  }
  {
    const Watch watch(with(no_cloth, "spacing: 0.02,", "spacing: 0.02, surface_tension: 0.07,"));
    EXPECT_EQ(count(launched), 2);   // normals and forces
    EXPECT_EQ(count(allocated), 1);  // normals
  }
  {
    const Watch watch(with(no_cloth, "inside: true", "inside: true, adhesion: 0.07"));
    EXPECT_EQ(containing(launched, {"surface_tension::adhesion"}),
              1);  // and on a GPU a kernel that clears its strengths
    EXPECT_EQ(containing(launched, {"surface_tension::normal", "surface_tension::cohesion"}), 0);
    EXPECT_EQ(containing(allocated, {"surface_tension::normal"}), 0);
    EXPECT_EQ(containing(allocated, {"surface_tension::cloth_adhesion"}), 0);
  }
}

TEST(only_what_is_needed, slip_only_where_a_wall_slips_and_the_liquid_is_viscous) {
  const std::initializer_list<const char*> parts = {"_slip", "wall_plane"};
  { const Watch first(wet_scene()); }  // what a process makes once is there then
  for (const std::string& scene : {wet_scene(), std::string(no_cloth)}) {
    const bool sheet = scene.find("cloth:") != scene.npos;
    const auto slipping = [&](const std::string& slip) {
      const std::string body = sheet ? "radius: 0.05" : "inside: true";
      const std::string changed = with(scene, body, body + ", slip: " + slip);
      return sheet ? with(changed, "    thickness", "    slip: " + slip + "\n    thickness") : changed;
    };
    const Watch plain(scene);
    // Which kernels a cloth's solve launches depends on how it converges.
    const auto launched_beside_cloth = [] {
      std::set<std::string> kernels = launched;
      std::erase_if(kernels, [](const std::string& k) { return k.find("drench::cloth::") != k.npos; });
      return kernels;
    };
    const std::set<std::string> kernels = launched_beside_cloth(), arrays = allocated;
    EXPECT_EQ(containing(launched, parts) + containing(allocated, parts), 0);
    const Watch none(slipping("no"));
    EXPECT_EQ(launched_beside_cloth(), kernels);
    EXPECT_EQ(allocated, arrays);
    const Watch some(slipping("free"));
    EXPECT_EQ(launched_beside_cloth(),
              kernels);  // the walls of bodies that stand are placed when their arrays are made
    EXPECT_EQ(containing(allocated, parts), sheet ? 3 : 2);
    const std::string dry = sheet ? with(slipping("free"), "viscosity: 1.0e-3", "viscosity: 0")
                                  : with(slipping("free"), "spacing: 0.02", "spacing: 0.02, viscosity: 0");
    const Watch inviscid(dry);
    EXPECT_EQ(containing(launched, parts) + containing(allocated, parts), 0);
  }
  const Watch moving(with(wet_scene(), "radius: 0.05", "radius: 0.05, slip: 0.01, spin: {degrees_per_second: 20}"));
  EXPECT_EQ(containing(launched, parts), 1);
  EXPECT_EQ(containing(allocated, parts), 3);  // lengths, walls, walls at t = 0
}

TEST(only_what_is_needed, spins_only_where_asked_for) {
  const auto count = [](const std::set<std::string>& labels) { return containing(labels, {"micropolar", "spin"}); };
  for (const std::string& scene : {wet_scene(), std::string(no_cloth)}) {
    const Watch watch(scene);
    EXPECT_EQ(count(launched) + count(allocated), 0);
  }
  const std::string few = with(no_cloth, "spacing: 0.02,", "spacing: 0.02, micropolar: {transfer: 1.0e-3},");
  {
    const Watch watch(few);
    EXPECT_EQ(count(launched), 3);   // slip, bound, turn
    EXPECT_EQ(count(allocated), 3);  // the spins, slip, rate
  }
  const Watch watch(with(few, "transfer: 1.0e-3", "transfer: 1"));
  EXPECT_EQ(containing(allocated, {"micropolar::velocity_change", "micropolar::spin_change"}), 2) << "several stages";
}

TEST(only_what_is_needed, a_sort_has_no_memory_of_the_others) {
  const auto run = [](const char* sort, int counting, int radix, int bitonic) {
    SCOPED_TRACE(sort);
    const Watch watch(with(no_cloth, "end: 1}", std::string("end: 1}\nneighbors: {sort: ") + sort + "}"));
    EXPECT_EQ(containing(allocated, {"cell_bucket"}), counting);
    EXPECT_EQ(containing(allocated, {"cell_radix", "pair_sort"}), radix);
    EXPECT_EQ(containing(allocated, {"cell_bitonic"}), bitonic);
    EXPECT_EQ(containing(launched, {"cell_table::scatter"}) > 0, counting > 0);
    EXPECT_EQ(containing(launched, {"cell_table::radix"}) > 0, radix > 0);
    EXPECT_EQ(containing(launched, {"cell_table::bitonic"}) > 0, bitonic > 0);
  };
  run("auto", 1, 0, 0);
  run("counting", 1, 0, 0);
  run("radix", 0, 4, 0);  // keys and their exchange, the items' exchange, places
  run("bitonic", 0, 0, 1);
  run("bitonic_naive", 0, 0, 1);
}

TEST(only_what_is_needed, extrapolation_and_a_steps_own_compression_only_where_asked_for) {
  const std::initializer_list<const char*> walls = {"wall_gain"}, source = {"pressure::free_rate", "pressure::source"};
  {
    const Watch watch(with(wet_scene(), "fluid:\n", "fluid:\n  wall_pressure: mirrored\n"));
    for (const auto& labels : {walls, source})
      EXPECT_EQ(containing(launched, labels) + containing(allocated, labels), 0);
  }
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, walls), 1);
    EXPECT_EQ(containing(allocated, walls), 2);  // its diagonal, its shear
  }
  const std::initializer_list<const char*> reaction = {"wall_push", "wall_reaction", "body_couple", "body_ahead"};
  const std::string floating =
      with(no_cloth, "bodies: [",
           "bodies: [{sphere: {center: [0.1, 0.2, 0.05], radius: 0.04, dynamic: true, density: 300}}, ");
  {
    const Watch watch(with(floating, "spacing: 0.02,", "spacing: 0.02, wall_pressure: mirrored,"));
    EXPECT_EQ(containing(launched, reaction) + containing(allocated, reaction), 0) << "between mirrors";
  }
  {
    const Watch watch(floating);
    EXPECT_EQ(containing(launched, reaction), 5)
        << "changes, gifts, impulses; kept at the start of a solve, taken off at its end";
    EXPECT_EQ(containing(allocated, reaction), 3);
  }
  {
    const Watch watch(with(wet_scene(), "min_iterations: 6", "min_iterations: 6, source_error: 0.2"));
    EXPECT_EQ(containing(launched, source), 2);
    EXPECT_EQ(containing(allocated, source), 1);  // free_rate
  }
  const Watch watch(with(no_cloth, "bodies: [{box: {min: [0, 0, 0], max: [0.2, 0.2, 0.1], inside: true}}]\n", ""));
  EXPECT_EQ(containing(launched, walls) + containing(allocated, walls), 0) << "without walls";
}

TEST(only_what_is_needed, measures_only_where_asked_for) {
  const std::initializer_list<const char*> label = {"drench::measures"};
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  {
    const Watch watch(with(wet_scene(), "every: 0", "every: 0, measures: true"));
    EXPECT_EQ(containing(launched, label), 4);   // nearest, nearest_sums; patch_mean, patch_moment
    EXPECT_EQ(containing(allocated, label), 2);  // nearest, rest_uv
  }
  const Watch watch(with(no_cloth, "end: 1}", "end: 1}\noutput: {measures: true}"));
  EXPECT_EQ(containing(launched, label), 2);
}

TEST(only_what_is_needed, cloth_pushes_bodies_only_where_it_moves_and_they_answer) {
  const auto count = [] { return containing(launched, {"pushes"}) + containing(allocated, {"body_pushed"}); };
  const std::string scene = scene_of({});
  {
    const Watch watch(scene);
    EXPECT_EQ(count(), 4) << "clear, of the last step, of this one; the sums";
  }
  {
    const Watch watch(with(scene, "dynamic: true, density: 100, ", ""));
    EXPECT_EQ(count(), 0);
  }
  const Watch watch(
      with(with(scene, "thickness: 0.004", "thickness: 0.004\n    dynamics: false"), "pin: [{edges: true}]", ""));
  EXPECT_EQ(count(), 0);
}

TEST(only_what_is_needed, one_rank_alone_exchanges_nothing) {
  const Watch watch(wet_scene());
  EXPECT_EQ(containing(launched, {"drench::exchange", "::ghost_", "::node_answer", "::in_order"}), 0);
  EXPECT_EQ(containing(allocated, {"drench::exchange", "in_order"}), 0);
}

TEST(only_what_is_needed, only_steps_of_mode_error_look_back) {
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, {"density::found"}) + containing(allocated, {"kept_state"}), 0);
  }
  const Watch watch(with(wet_scene(), "end: 1.0", "end: 1.0, mode: error"));
  EXPECT_GT(containing(launched, {"density::found"}), 0);
}

TEST(only_what_is_needed, multipliers_only_with_xpbd) {
  const std::initializer_list<const char*> parts = {"multiplier", "cloth::edge_", "cloth::last_edge", "cloth::hinge_",
                                                    "cloth::last_hinge"};
  {
    const Watch watch(wet_scene());
    EXPECT_GT(containing(launched, {"cloth::jacobi", "cloth::resident", "cloth::newton"}), 0);
    EXPECT_EQ(containing(launched, parts) + containing(allocated, parts), 0);
  }
  const Watch watch(with(wet_scene(), "cloth:\n", "cloth_solver: {method: xpbd}\ncloth:\n"));
  EXPECT_EQ(containing(launched, {"cloth::jacobi", "cloth::resident", "cloth::newton"}), 0);
  EXPECT_EQ(containing(launched, {"multiplier"}), 5);
  EXPECT_EQ(containing(allocated, parts), 6);
}

}  // namespace drench::test
