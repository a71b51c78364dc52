// Runs drench from a C++ program: a block of water above a pinned cloth, defined in code. Prints the position of the
// water, the liquid in the cloth and the steps every tenth of a second. Exit code 0 if the cloth absorbed liquid and
// none was lost.

#include <algorithm>
#include <cstdio>
#include <drench/drench.hpp>
#include <exception>
#include <numeric>

namespace {

drench::Scene water_over_cloth() {
  drench::Scene scene;
  scene.time = {.step = 0.002, .end = 0.3};
  scene.domain = {{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};
  scene.fluid.present = true;
  scene.fluid.spacing = 0.02;
  scene.fluid.blocks.push_back({.box = {{-0.08, 0.03, -0.08}, {0.08, 0.15, 0.08}}});
  drench::ClothScene cloth;
  cloth.grid = drench::GridScene{.size = {0.4, 0.4}, .nodes = {17, 17}};
  cloth.pins.emplace_back().kind = drench::PinScene::Kind::edges;
  cloth.material.porous = true;  // with every default
  scene.cloths.push_back(cloth);
  return scene;
}

double kilograms(const drench::Simulation& run, const std::vector<drench::Quanta>& masses) {
  return run.quantum() * static_cast<double>(std::accumulate(masses.begin(), masses.end(), drench::Quanta{0}));
}

/// Steps to `time`, s. Prints how long the steps were and how many iterations the density solve took.
void step_until(drench::Simulation& run, double time) {
  double longest = 0, compression = 0;
  int iterations = 0, steps = 0;
  for (; run.time() < time - 1e-9; ++steps) {
    const drench::StepReport report = run.step(time - run.time());
    longest = std::max(longest, report.dt);
    iterations += report.density_iterations;
    compression = std::max(compression, report.density_error);
  }
  std::printf("%d steps of up to %.4f s, %.1f iterations each, mean compression up to %.2g\n", steps, longest,
              static_cast<double>(iterations) / std::max(steps, 1), compression);
}

void print(const drench::Simulation& run, const drench::HostState& now) {
  double height = 0;
  for (const drench::Vec3& x : now.fluid_position) height += x[1] / static_cast<double>(now.fluid_position.size());
  const auto wet = run.saturation(now);
  std::printf("t = %.2f s: %d particles, mean height %6.3f m, %.3f kg in the cloth, saturation up to %.2f\n", now.time,
              now.fluid_count(), height, kilograms(run, now.node_liquid), *std::max_element(wet.begin(), wet.end()));
}

}  // namespace

int main() try {
  const drench::BackendRuntime runtime(1, true);   // one thread, no notices; outlives every Simulation
  const drench::Scene scene = water_over_cloth();  // or drench::load_scene("scene.yaml")
  drench::Simulation run(scene);
  for (const std::string& warning : run.warnings()) std::printf("warning: %s\n", warning.c_str());
  const drench::HostState start = run.state();
  for (double t = 0.1; t < scene.time.end + 0.05; t += 0.1) {
    step_until(run, t);
    print(run, run.state());
  }
  const drench::HostState end = run.state();
  const auto all = [&](const drench::HostState& s) {
    return kilograms(run, s.fluid_mass) + kilograms(run, s.node_liquid);
  };
  const double lost = all(start) - all(end) - run.quantum() * static_cast<double>(end.drained);
  std::printf("%lld steps, %.3g kg lost\n", static_cast<long long>(run.steps()), lost);
  return kilograms(run, end.node_liquid) > 0 && lost < 1e-9 && -lost < 1e-9 ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "embed: %s\n", error.what());
  return 1;
}
