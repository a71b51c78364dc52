// How often a step launches kernels, and how often the host waits for them: watched through Kokkos Tools.

#include <gtest/gtest.h>

#include <Kokkos_Core.hpp>
#include <functional>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "pipeline/pipeline.hpp"
#include "stage_compare.hpp"
#include "watched_scenes.hpp"

namespace drench::test {
namespace {

namespace Tools = Kokkos::Tools::Experimental;

constexpr bool on_host = std::is_same_v<Kokkos::DefaultExecutionSpace::memory_space, Kokkos::HostSpace>;
std::map<std::string, std::vector<std::string>> launched_in;  // per stage
std::map<std::string, int> waits_in;
std::string stage;

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

}  // namespace

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
  EXPECT_EQ(launches("advection"), on_host ? 8u : 11u);  // on a GPU four for the collisions
  EXPECT_EQ(waits("advection"), 1);
  EXPECT_EQ(launches("ledger"), on_host ? 2u : 1u);
  EXPECT_EQ(waits("ledger"), 1);
  watch_a_step(with(scene, "initial_saturation: [{box: {min: [-0.05, -1, -0.05], max: [0.05, 1, 0.05]}, value: 1.1}]",
                    "initial_saturation: [{box: {min: [-0.05, -1, -0.05], max: [0.05, 1, 0.05]}, value: 0.5}]"),
               2, [](const Model&, HostState&) {});
  EXPECT_LE(launches("emission"), 2u);  // nothing is buffered
  EXPECT_EQ(waits("emission"), 1);
}

}  // namespace drench::test
