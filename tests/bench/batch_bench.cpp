// drench_bench_batch [WORLDS [STEPS]]: milliseconds per step of independent runs, one after the other and side by side:
// 2,000 particles that fall on a porous cloth of 20 x 20 nodes. Each world has a viscosity of its own.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <memory>

#include "drench/drench.hpp"

namespace drench {
namespace {

constexpr const char* scene = R"(drench: 1
time: {step: 0.002, end: 10}
domain: {min: [-0.2, -0.2, -0.2], max: [0.2, 0.4, 0.2]}
fluid:
  spacing: 0.01
  sources:
    - block: {min: [-0.06, 0.02, -0.06], max: [0.06, 0.16, 0.06]}
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [20, 20]}}
    pin: [{corners: true}]
    porous: {}
)";

std::vector<std::unique_ptr<Simulation>> worlds(int n) {
  std::vector<std::unique_ptr<Simulation>> runs;
  for (int k = 0; k < n; ++k)
    runs.push_back(
        std::make_unique<Simulation>(parse_scene(scene, "world", {fmt::format("fluid.viscosity={}", 1e-3 * (k + 1))})));
  return runs;
}

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

void measure(int n, int steps) {
  const auto alone = worlds(n), together = worlds(n);
  std::vector<Simulation*> all;
  for (const auto& run : together) all.push_back(run.get());
  const std::vector<double> longest(all.size(), 1.0);
  std::vector<double> in_turns, at_once;
  for (int k = 0; k < steps; ++k) {  // both in turns, so that neither has the quieter machine
    double begin = seconds();
    for (const auto& run : alone) run->step();
    in_turns.push_back(1e3 * (seconds() - begin));
    begin = seconds();
    for (const Stepped& result : step_together(all, longest))
      if (result.error) std::rethrow_exception(result.error);
    at_once.push_back(1e3 * (seconds() - begin));
  }
  int same = 0;
  for (int k = 0; k < n; ++k) {
    const HostState a = alone[static_cast<std::size_t>(k)]->state(), b = all[static_cast<std::size_t>(k)]->state();
    same += a.fluid_position == b.fluid_position && a.node_position == b.node_position;
  }
  fmt::print("{} worlds of {} particles and {} nodes, {} steps, {} at a time\n", n, all[0]->state().fluid_mass.size(),
             all[0]->state().node_position.size(), steps, runs_at_a_time());
  fmt::print(
      "one after the other  {:8.2f} ms per step of all\nside by side         {:8.2f} ms\nratio {:.2f}; {} of {} with "
      "the same bits\n",
      median(in_turns), median(at_once), median(in_turns) / median(at_once), same, n);
}

}  // namespace
}  // namespace drench

int main(int argc, char** argv) {
  const drench::BackendRuntime runtime(0, true);
  drench::measure(argc > 1 ? std::atoi(argv[1]) : 16, argc > 2 ? std::atoi(argv[2]) : 50);
}
