// A stage that a scene does not need launches nothing and allocates nothing: watched through Kokkos Tools.

#include <gtest/gtest.h>

#include <Kokkos_Core.hpp>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "pipeline/pipeline.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

namespace Tools = Kokkos::Tools::Experimental;

constexpr bool on_host = std::is_same_v<Kokkos::DefaultExecutionSpace::memory_space, Kokkos::HostSpace>;
std::set<std::string> launched, allocated;
std::map<std::string, std::vector<std::string>> launched_in;  // per stage
std::map<std::string, int> waits_in;
std::string stage;

/// On a device Kokkos names the host's copy of an array after it.
bool is_copy(const char* name) { return std::string(name).find("_mirror") != std::string::npos; }
void on_launch(const char* name, const uint32_t, uint64_t* id) {
  if (!is_copy(name)) launched.insert(name);
  *id = 0;
}
void on_allocate(Kokkos_Profiling_SpaceHandle, const char* name, const void*, const uint64_t) {
  if (!is_copy(name)) allocated.insert(name);
}

/// Labels of kernels and arrays while a scene runs a few steps.
struct Watch {
  explicit Watch(const std::string& scene) {
    launched.clear();
    allocated.clear();
    Tools::set_begin_parallel_for_callback(on_launch);
    Tools::set_begin_parallel_reduce_callback(on_launch);
    Tools::set_begin_parallel_scan_callback(on_launch);
    Tools::set_allocate_data_callback(on_allocate);
    const auto setup = setup_from(scene);
    {
      const auto backend = make_kokkos_backend(setup.model);
      Pipeline pipeline(setup.model, *backend, setup.state);
      for (int s = 0; s < 4; ++s) pipeline.step(1.0);
    }
    Tools::set_begin_parallel_for_callback(nullptr);
    Tools::set_begin_parallel_reduce_callback(nullptr);
    Tools::set_begin_parallel_scan_callback(nullptr);
    Tools::set_allocate_data_callback(nullptr);
  }
};

/// What one step launches, and how often the host waits for the device, per stage.
StepReport watch_a_step(const std::string& scene, int steps_before,
                        const std::function<void(const Model&, HostState&)>& prepare) {
  const auto setup = setup_from(scene);
  const auto backend = make_kokkos_backend(setup.model);
  HostState state = setup.state;
  prepare(setup.model, state);
  Pipeline pipeline(setup.model, *backend, state);
  for (int s = 0; s < steps_before; ++s) pipeline.step(1.0);
  launched_in.clear();
  waits_in.clear();
  const auto launch = [](const char* name, const uint32_t, uint64_t* id) {
    launched_in[stage].push_back(name);
    *id = 0;
  };
  Tools::set_push_region_callback([](const char* name) { stage = name; });
  Tools::set_begin_parallel_for_callback(launch);
  Tools::set_begin_parallel_reduce_callback(launch);
  Tools::set_begin_parallel_scan_callback(launch);
  // Kokkos itself fences around what its tools hear of.
  Tools::set_begin_fence_callback([](const char* name, const uint32_t, uint64_t* id) {
    if (std::string(name).find("Tool") == std::string::npos && std::string(name).find("dealloc") == std::string::npos)
      ++waits_in[stage];
    *id = 0;
  });
  const StepReport report = pipeline.step(1.0);
  Tools::set_push_region_callback(nullptr);
  Tools::set_begin_parallel_for_callback(nullptr);
  Tools::set_begin_parallel_reduce_callback(nullptr);
  Tools::set_begin_parallel_scan_callback(nullptr);
  Tools::set_begin_fence_callback(nullptr);
  return report;
}

int containing(const std::set<std::string>& labels, std::initializer_list<const char*> parts) {
  int n = 0;
  for (const std::string& label : labels)
    for (const char* part : parts)
      if (label.find(part) != std::string::npos) {
        ++n;
        break;
      }
  return n;
}

constexpr const char* no_cloth = R"(drench: 1
time: {step: 0.002, end: 1}
fluid: {spacing: 0.02, sources: [{block: {min: [0, 0, 0], max: [0.1, 0.1, 0.1]}}]}
bodies: [{box: {min: [0, 0, 0], max: [0.2, 0.2, 0.1], inside: true}}]
)";
constexpr const char* no_fluid = R"(drench: 1
time: {step: 0.002, end: 1}
cloth: [{mesh: {grid: {size: [0.2, 0.2], nodes: [6, 6]}}, pin: [{corners: true}]}]
)";
constexpr const char* dry_cloth = R"(drench: 1
time: {step: 0.002, end: 1}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.05, 0.02, -0.05], max: [0.05, 0.1, 0.05]}}]}
cloth: [{mesh: {grid: {size: [0.2, 0.2], nodes: [6, 6]}}, pin: [{corners: true}]}]
)";

const std::initializer_list<const char*> porous_labels = {"::absorption",     "::emission",    "::diffusion",
                                                          "::flow_direction", "::reservoir",   "::transfer",
                                                          "saturation",       "flow_direction"};

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

TEST(only_what_is_needed, without_fluid_no_fluid_or_porous_kernel) {
  const Watch watch(no_fluid);
  EXPECT_GT(containing(launched, {"drench::cloth"}), 0);
  EXPECT_EQ(containing(launched, porous_labels), 0);
  EXPECT_EQ(
      containing(launched, {"::density", "::divergence", "::pressure", "::forces", "::neighbors", "::cell_table"}), 0);
}

TEST(only_what_is_needed, strain_limits_and_moving_pins_cost_only_scenes_that_have_them) {
  const auto count = [](const std::set<std::string>& labels) {
    return containing(labels, {"limit", "pin_motion", "pin_step", "::pins", "rest_position"});
  };
  {
    const Watch watch(no_fluid);
    EXPECT_EQ(count(launched) + count(allocated), 0);
  }
  {
    const Watch watch(with(no_fluid, "pin: [{corners: true}]", "strain_limit: 0.1, pin: [{corners: true}]"));
    EXPECT_EQ(containing(allocated, {"limit"}), 4);
  }
  {
    const Watch watch(with(no_fluid, "corners: true", "corners: true, velocity: [0, 1, 0]"));
    EXPECT_EQ(containing(launched, {"::pins"}), 1);
    EXPECT_EQ(containing(allocated, {"pin_motion", "pin_steps", "node_rest_position"}), 3);
  }
}

TEST(only_what_is_needed, cloth_that_is_not_porous_runs_no_porous_stage) {
  const Watch watch(dry_cloth);
  EXPECT_GT(containing(launched, {"drench::pressure"}), 0);
  EXPECT_EQ(containing(launched, porous_labels), 0);
}

TEST(only_what_is_needed, cloth_collides_with_itself_only_where_asked_for) {
  const std::initializer_list<const char*> label = {"self_collision"};
  for (const std::string& scene : {wet_scene(), std::string(no_fluid)}) {
    const Watch watch(scene);
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  {
    const Watch watch(with(no_fluid, "pin: [{corners: true}]", "pin: [{corners: true}], self_collision: true"));
    EXPECT_GT(containing(launched, label), 5);
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
    EXPECT_EQ(containing(launched, {"wet_adhesion::pull", "wet_adhesion::force", "wet_adhesion::centers"}), 2)
        << "pulls and forces; no search, for the scene has no self_collision";
  }
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

TEST(only_what_is_needed, spins_only_where_asked_for) {
  const auto count = [](const std::set<std::string>& labels) { return containing(labels, {"micropolar", "spin"}); };
  for (const std::string& scene : {wet_scene(), std::string(no_cloth)}) {
    const Watch watch(scene);
    EXPECT_EQ(count(launched) + count(allocated), 0);
  }
  const std::string few = with(no_cloth, "spacing: 0.02,", "spacing: 0.02, micropolar: {transfer: 1.0e-3},");
  {
    const Watch watch(few);
    EXPECT_EQ(count(launched), 4);   // clear at the upload, slip, bound, turn
    EXPECT_EQ(count(allocated), 2);  // slip, rate
  }
  const Watch watch(with(few, "transfer: 1.0e-3", "transfer: 1"));
  EXPECT_EQ(containing(allocated, {"micropolar::velocity_change", "micropolar::spin_change"}), 2) << "several stages";
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

TEST(only_what_is_needed, the_host_does_not_wait_for_what_it_can_do_without) {
  const auto waits = [](const char* name) { return waits_in[std::string("drench::") + name]; };
  const auto as_it_is = [](const Model&, HostState&) {};
  const auto of_liquid = [&](const std::string& scene) {
    SCOPED_TRACE(scene);
    const StepReport report = watch_a_step(scene, 6, as_it_is);
    EXPECT_EQ(waits("forces"), 1);  // for all bounds of the viscosity at once
    EXPECT_GE(report.divergence_iterations, 2);
    EXPECT_EQ(waits("divergence"), report.divergence_iterations - 1);  // the first goes on whatever comes out
    return report;
  };
  const StepReport report = of_liquid(no_cloth);
  EXPECT_EQ(waits("pressure"), report.density_iterations - 1);
  of_liquid(wet_scene());
  const std::string one =
      with(no_cloth, "fluid: {", "fluid: {solver: {min_iterations: 1, max_iterations: 1}, ");  // and it is the last
  watch_a_step(one, 6, as_it_is);
  EXPECT_EQ(waits("divergence"), 1);
  EXPECT_EQ(waits("pressure"), 1);
}

// A launch costs a GPU 5 µs and a wait of the host 20 µs: at 10⁵ particles the porous stages are made of nothing else.
TEST(only_what_is_needed, porous_stages_launch_and_wait_as_seldom_as_they_do) {
  const auto launches = [](const char* name) { return launched_in[std::string("drench::") + name].size(); };
  const auto waits = [](const char* name) { return waits_in[std::string("drench::") + name]; };
  const std::string scene =
      with(wet_scene(), "    hold_saturation: [{box: {min: [-0.2, -1, 0.12], max: [0.2, 1, 0.2]}, value: 0.6}]\n", "");
  const auto wet = [](const Model& m, HostState& s) {
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
      s.node_liquid[n] = static_cast<Quanta>(1.05 * m.samples.node_capacity[n] / m.quantum);
  };
  watch_a_step(scene, 6, wet);
  EXPECT_LE(launches("porous_neighbors"), 12u);  // cells of the samples 6, diffusion's rate, lists 3; two have grown
  EXPECT_LE(waits("porous_neighbors"), 2);       // one; another where there was too little room
  EXPECT_EQ(launches("flow_direction"), 1u);
  EXPECT_EQ(launches("absorption"), 5u);
  EXPECT_EQ(waits("absorption"), 0);
  EXPECT_LE(launches("emission"), 13u);  // with particles that absorption took whole
  EXPECT_GE(launches("emission"), 12u);
  EXPECT_EQ(waits("emission"), 1);
  EXPECT_EQ(waits("diffusion"), 0);
  EXPECT_EQ(launches("advection"), on_host ? 8u : 9u);  // on a GPU two for the collisions
  EXPECT_EQ(waits("advection"), 1);
  EXPECT_EQ(launches("ledger"), on_host ? 3u : 1u);
  EXPECT_EQ(waits("ledger"), 1);
  watch_a_step(with(scene, "initial_saturation: [{box: {min: [-0.05, -1, -0.05], max: [0.05, 1, 0.05]}, value: 1.1}]",
                    "initial_saturation: [{box: {min: [-0.05, -1, -0.05], max: [0.05, 1, 0.05]}, value: 0.5}]"),
               2, [](const Model&, HostState&) {});
  EXPECT_LE(launches("emission"), 2u);  // nothing is ripe
  EXPECT_EQ(waits("emission"), 1);
}

TEST(only_what_is_needed, a_sort_has_no_memory_of_the_others) {
  const auto run = [](const char* sort, int counting, int radix, int bitonic) {
    SCOPED_TRACE(sort);
    const Watch watch(with(no_cloth, "end: 1}", std::string("end: 1}\nneighbors: {sort: ") + sort + "}"));
    EXPECT_EQ(containing(allocated, {"cell_bucket"}), counting);
    EXPECT_EQ(containing(allocated, {"cell_radix"}), radix);
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

TEST(only_what_is_needed, measures_only_where_asked_for) {
  const std::initializer_list<const char*> label = {"drench::measures"};
  {
    const Watch watch(wet_scene());
    EXPECT_EQ(containing(launched, label) + containing(allocated, label), 0);
  }
  {
    const Watch watch(with(wet_scene(), "every: 0", "every: 0, measures: true"));
    EXPECT_EQ(containing(launched, label), 5);   // nearest, crowding, close; patch_mean, patch_moment
    EXPECT_EQ(containing(allocated, label), 2);  // nearest, place
  }
  const Watch watch(with(no_cloth, "end: 1}", "end: 1}\noutput: {measures: true}"));
  EXPECT_EQ(containing(launched, label), 3);
}

TEST(only_what_is_needed, multipliers_only_with_xpbd) {
  const std::initializer_list<const char*> parts = {"multiplier", "cloth::edge_", "cloth::last_edge", "cloth::hinge_",
                                                    "cloth::last_hinge"};
  {
    const Watch watch(wet_scene());
    EXPECT_GT(containing(launched, {"cloth::jacobi", "cloth::resident"}), 0);
    EXPECT_EQ(containing(launched, parts) + containing(allocated, parts), 0);
  }
  const Watch watch(with(wet_scene(), "cloth:\n", "cloth_solver: {method: xpbd}\ncloth:\n"));
  EXPECT_EQ(containing(launched, {"cloth::jacobi", "cloth::resident"}), 0);
  EXPECT_EQ(containing(launched, {"multiplier"}), 5);
  EXPECT_EQ(containing(allocated, parts), 6);
}

}  // namespace drench::test
