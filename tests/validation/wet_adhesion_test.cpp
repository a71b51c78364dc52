// Wet fabric sticks: what it holds, what it takes to peel it, and friction under its pull.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "validation.hpp"
#include "watched_energy.hpp"

namespace drench::test {
namespace {

const char* const soaked = "initial_saturation: [{box: {min: [-9, -9, -9], max: [9, 9, 9]}, value: 1}]";

/// Half of what the law takes for the range of the pull, m: in contact it is the work over this.
double range(const Model& m, double thickness) {
  double mean = 0;
  for (const double length : m.mesh.edge_length) mean += length / static_cast<double>(m.mesh.edge.size());
  return std::max(thickness, mean / 2);
}

/// kg of one cloth.
double wet_mass(const Model& m, const HostState& s, Index cloth) {
  double sum = 0;
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
    if (m.mesh.node_cloth[n] == cloth) sum += m.mesh.solid_mass[n] + m.quantum * double(s.node_liquid[n]);
  return sum;
}

double mean_height(const Model& m, const HostState& s, Index cloth) {
  double sum = 0, count = 0;
  for (std::size_t n = 0; n < s.node_position.size(); ++n) {
    if (m.mesh.node_cloth[n] != cloth) continue;
    sum += s.node_position[n][1];
    count += 1;
  }
  return sum / count;
}

/// How far a soaked sheet of 0.1 m has come down after 1 s that hangs from what is above it by adhesion alone.
/// `share`: the pull over its weight.
double comes_down(bool fabric, double share) {
  const std::string above =
      fabric
          ? fmt::format(
                "  - mesh: {{grid: {{size: [0.14, 0.14], nodes: [11, 11]}}}}\n    dynamics: false\n"
                "    self_collision: true\n    porous: {{adhesion: WORK, diffusivity: 0}}\n    name: upper\n    {}\n",
                soaked)
          : "";
  std::string text = fmt::format(R"(drench: 1
time: {{step: 0.004, end: 2}}
cloth:
  - mesh: {{grid: {{size: [0.1, 0.1], nodes: [9, 9]}}}}
    place: {{position: [0.003, -0.001, 0.002], rotate: {{axis: [0, 1, 0], degrees: 10}}}}
    thickness: 0.001
    self_collision: {}
    porous: {{adhesion: WORK, diffusivity: 0}}
    {}
{})",
                                 fabric, soaked, above);
  if (!fabric) text += "bodies: [{plane: {point: [0, 0, 0], normal: [0, -1, 0]}}]\n";
  const auto with_work = [&](double work) {
    std::string scene = text;
    for (std::size_t at = 0; (at = scene.find("WORK")) != std::string::npos;)
      scene.replace(at, 4, fmt::format("{:.9f}", work));
    return scene;
  };
  const SceneRun first(with_work(0.01));
  const double pressure = 9.81 * wet_mass(first.model(), first.initial(), 0) / 0.01;  // Pa
  SceneRun run(with_work(share * pressure * range(first.model(), 0.001)));
  const double start = mean_height(run.model(), run.initial(), 0);
  for (int n = 0; n < 250; ++n) run.step();
  return start - mean_height(run.model(), run.state(), 0);
}

}  // namespace

TEST(wet_adhesion, holds_what_weighs_less_than_its_pull) {
  for (const bool fabric : {false, true}) {
    const std::string what = fabric ? "a wet cloth under a wet cloth" : "a wet cloth under a plane";
    report({what + ", pull 1.1 of its weight: distance fallen in 1 s", "hangs", std::fabs(comes_down(fabric, 1.1)),
            1e-4, "m"});
    EXPECT_GT(comes_down(fabric, 0.9), 1) << what;
  }
}

namespace {

constexpr double peel_work = 0.1, peel_speed = 0.02;  // N/m, m/s

/// A wet strip of two meshes of `l` across on a plane, pulled off at a right angle by its end, without damping and
/// friction.
std::string strip(double l) {
  return fmt::format(R"(drench: 1
time: {{step: 0.002, end: 10}}
gravity: [0, 0, 0]
cloth_solver: {{max_iterations: 2000}}
cloth:
  - mesh: {{grid: {{size: [0.15, {}], nodes: [{}, 3]}}}}
    place: {{position: [0.075, 0.001, 0]}}
    thickness: 0.001
    stretch: 100
    bend: 1.0e-5
    damping: 0
    friction: 0
    pin: [{{box: {{min: [-0.001, -1, -1], max: [0.001, 1, 1]}}, velocity: [{}, {}, 0]}}]
    porous: {{adhesion: {}, diffusivity: 0}}
    {}
bodies: [{{plane: {{point: [0, 0, 0], normal: [0, 1, 0]}}}}]
)",
                     2 * l, std::lround(0.15 / l) + 1, peel_speed, peel_speed, peel_work, soaked);
}

/// Energy of the pull of the plane y = 0 on a soaked cloth, 0 when parted, J.
double energy_of_adhesion(const Model& m, const HostState& s) {
  const double thickness = m.cloths[0].thickness, a = 2 * range(m, thickness);
  double energy = 0;
  for (Index p = 0; p < m.samples.count(); ++p) {
    const auto sample = static_cast<std::size_t>(p);
    const auto& corner = m.mesh.triangle[static_cast<std::size_t>(m.samples.triangle[sample])];
    double y = 0;
    for (std::size_t k = 0; k < 3; ++k)
      y += m.samples.weight[sample][k] * s.node_position[static_cast<std::size_t>(corner[k])][1];
    const double left = std::min(1.0, std::max(0.0, 1 - (y - thickness) / a));
    energy -= m.cloths[0].wet_adhesion * m.samples.area[sample] * left * left;
  }
  return energy;
}

}  // namespace

TEST(wet_adhesion, a_strip_peels_at_its_work_per_width) {
  for (const double l : {0.01, 0.005, 0.0025}) {
    SceneRun run(strip(l));
    const Model& m = run.model();
    HostState before = run.initial();
    double pulled = 0, lost = 0, most_lost = 0, regained = 0, stored = 0, from = 0;  // J; s
    while (run.time() < 4) {
      run.step();
      HostState s = run.state();
      const double pins = energy_input(m, before, s, run.dt()).pins;
      lost += pins - (mechanical_energy(m, s) - mechanical_energy(m, before)) -
              (energy_of_adhesion(m, s) - energy_of_adhesion(m, before));
      most_lost = std::max(most_lost, lost);
      regained = std::max(regained, most_lost - lost);
      if (run.time() < 1.5) {
        stored = mechanical_energy(m, s);
        from = run.time();
      } else {
        pulled += pins;
      }
      before = std::move(s);
    }
    const double due = peel_work * 2 * l * peel_speed * (run.time() - from),
                 spent = pulled - (mechanical_energy(m, before) - stored);
    const std::string what = fmt::format("wet strip peeled off a plane at a right angle, mesh of {} mm: ", 1000 * l);
    report({what + "work of the pull that the strip does not store, per length", "work of adhesion × width",
            std::fabs(spent / due - 1), 0.05});
    report({what + "energy created, over the work of adhesion", "0", regained / due, 1e-3});
    std::printf("%.5f of the work of adhesion\n", spent / due);
  }
}

TEST(wet_adhesion, presses_and_so_adds_to_friction) {
  // A sheet on a plane that is tilted by 45° slides with friction 0.5; under a pull of twice its weight it sticks.
  for (const double share : {0.0, 2.0}) {
    const auto scene = [&](double work) {
      return fmt::format(R"(drench: 1
time: {{step: 0.004, end: 2}}
gravity: [6.9367, -6.9367, 0]
cloth:
  - mesh: {{grid: {{size: [0.1, 0.1], nodes: [9, 9]}}}}
    place: {{position: [0, 0.001, 0]}}
    thickness: 0.001
    friction: 0.5
    porous: {{adhesion: {:.9f}, diffusivity: 0}}
    {}
bodies: [{{plane: {{point: [0, 0, 0], normal: [0, 1, 0]}}}}]
)",
                         work, soaked);
    };
    const SceneRun first(scene(0.01));
    const double pressure = 9.81 * wet_mass(first.model(), first.initial(), 0) / 0.01;
    SceneRun run(scene(share * pressure * range(first.model(), 0.001)));
    for (int n = 0; n < 100; ++n) run.step();
    double slid = 0;
    for (std::size_t n = 0; n < run.initial().node_position.size(); ++n)
      slid = std::max(slid, std::fabs(run.state().node_position[n][0] - run.initial().node_position[n][0]));
    if (share > 0)
      report({"a wet cloth on a slope of 45°, friction 0.5, pull twice its weight: distance slid in 0.4 s", "sticks",
              slid, 1e-5, "m"});
    else
      EXPECT_GT(slid, 0.2);
  }
}

}  // namespace drench::test
