#include <fmt/format.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include "quanta_sum.hpp"
#include "stage_run.hpp"
#include "validation.hpp"
namespace drench::test {
TEST(diag2, fall) {
  const double d = atof(getenv("D")), width = 0.024, start = 0.048, end = atof(getenv("END")), dt = atof(getenv("DT"));
  const char* extra = getenv("X") ? getenv("X") : "";
  StageRun run(fmt::format(R"(drench: 1
time: {{step: {6}, end: 10}}
domain: {{min: [-0.1, -0.06, -0.1], max: [0.1, 0.2, 0.1]}}
fluid:
  spacing: {0}
  viscosity: 1.0e-6
  sources: [{{block: {{min: [-{1}, 0, -{1}], max: [{1}, {2}, {1}]}}}}]
cloth:
  - mesh: {{grid: {{size: [{3}, {3}], nodes: [{4}, {4}]}}}}
    dynamics: false
    thickness: 0.001
    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: 1}}]
    porous: {{uptake_velocity: 0.01, diffusivity: 0, permeability: 1.0193679918450562e-10{5}}}
bodies: [{{box: {{min: [-{1}, -0.2, -{1}], max: [{1}, 0.2, {1}], inside: true}}}}]
)", d, width / 2, start, width, std::lround(width / d) + 1, extra, dt));
  const Model& m = run.setup.model;
  const auto split = [](const HostState& s) { std::pair<double, double> a{0, 0}; for (std::size_t i = 0; i < s.fluid_mass.size(); ++i) (s.fluid_position[i][1] > 0 ? a.first : a.second) += double(s.fluid_mass[i]); return a; };
  const double unit = m.quantum / m.rest_density / width / width * 1e3;
  double asked = 0, inA = 0, inB = 0, outA = 0, outB = 0; int limited = 0;
  while (run.time < end - 1e-9) {
    std::pair<double, double> before;
    run.step([&](Stage stage, bool done) {
      if (stage != Stage::absorption && stage != Stage::emission) return;
      const HostState s = run.backend->download();
      const auto now = split(s);
      if (!done && stage == Stage::absorption) {
        for (std::size_t p = 0; p < s.sample_flux.size(); ++p) asked += std::fabs(s.sample_flux[p]) * m.samples.area[p] * dt / width / width * 1e3;
        double lo = 1e9, hi = 0; for (std::size_t n = 0; n < s.node_liquid.size(); ++n) { const double sat = double(s.node_liquid[n]) * m.quantum / m.samples.node_capacity[n]; lo = std::min(lo, sat); hi = std::max(hi, sat); limited += sat > 1.1; }
        if (run.steps % 50 == 0) {
          std::printf("t %.3f saturation %.4f to %.4f, nodes over 1.1 %d;", run.time, lo, hi, limited);
          limited = 0;
          double big = 0, all = 0, most = 0; for (std::size_t p = 0; p < s.sample_flux.size(); ++p) { const double u = std::fabs(s.sample_flux[p]); all += u; big += std::max(0.0, u - 0.108); most = std::max(most, u); }
          std::printf(" flux most %.3f m/s, over 0.108 %.2f;", most, big / all);
          double closest = 1; for (const auto& x : s.fluid_position) if (x[1] > 0) closest = std::min(closest, x[1]);
          int near = 0, tiny = 0; for (std::size_t i = 0; i < s.fluid_mass.size(); ++i) if (s.fluid_position[i][1] > 0 && s.fluid_position[i][1] < d) { ++near; tiny += s.fluid_mass[i] < quanta_per_particle / 8; }
          std::printf(" near %d tiny %d closest %.2f d\n", near, tiny, closest / d);
        }
      }
      if (done && stage == Stage::absorption) inA += before.first - now.first, inB += before.second - now.second;
      if (done && stage == Stage::emission) outA += now.first - before.first, outB += now.second - before.second;
      before = now;
    });
    if (run.steps % 50 == 0) { std::printf("   mm/s: asked %.2f, in from above %.2f below %.2f, out above %.2f below %.2f\n", asked / (50 * dt), unit * inA / (50 * dt), unit * inB / (50 * dt), unit * outA / (50 * dt), unit * outB / (50 * dt)); asked = inA = inB = outA = outB = 0; }
  }
}
}
