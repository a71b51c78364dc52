// Several runs in one program: a step of each at a time, and each in a thread of its own.

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "drench/drench.hpp"
#include "test_ranks.hpp"

namespace drench {
namespace {

using test::bits_of;

/// Liquid on porous cloth beside a body; cloth that touches itself; liquid alone; a cloth that dries.
const std::vector<std::string>& scenes() {
  static const std::vector<std::string> all{R"(drench: 1
time: {step: 0.002, end: 1}
fluid: {spacing: 0.01, sources: [{block: {min: [-0.03, 0.01, -0.03], max: [0.03, 0.06, 0.03]}}]}
cloth:
  - mesh: {grid: {size: [0.1, 0.1], nodes: [11, 11]}}
    porous: {}
    pin: [{corners: true}]
bodies:
  - sphere: {center: [0, -0.03, 0], radius: 0.025}
)",
                                            R"(drench: 1
time: {step: 0.002, end: 1}
cloth:
  - mesh: {grid: {size: [0.1, 0.1], nodes: [17, 17]}}
    place: {position: [0, 0.03, 0]}
    self_collision: true
bodies:
  - box: {min: [-0.02, -0.02, -0.02], max: [0.02, 0.02, 0.02]}
)",
                                            R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-0.1, 0, -0.1], max: [0.1, 0.3, 0.1]}
fluid:
  spacing: 0.01
  surface_tension: 0.0728
  sources:
    - block: {min: [-0.05, 0.1, -0.05], max: [0.05, 0.2, 0.05]}
)",
                                            R"(drench: 1
time: {step: 0.01, end: 1}
cloth:
  - mesh: {grid: {size: [0.1, 0.1], nodes: [15, 15]}}
    dynamics: false
    porous: {diffusivity: 1.0e-5}
    initial_saturation: [{box: {min: [-0.1, -1, -0.1], max: [0, 1, 0.1]}, value: 0.8}]
)"};
  return all;
}

constexpr int steps = 15;
std::uint64_t alone(const Scene& scene) {
  Simulation run(scene);
  for (int k = 0; k < steps; ++k) run.step();
  return bits_of(run.state());
}

std::vector<Simulation*> pointers(const std::vector<std::unique_ptr<Simulation>>& runs) {
  std::vector<Simulation*> all;
  for (const auto& run : runs) all.push_back(run.get());
  return all;
}

}  // namespace

TEST(runs_together, have_the_bits_that_they_have_alone) {
  std::vector<std::unique_ptr<Simulation>> runs;
  std::vector<std::uint64_t> bits;
  for (int copies = 0; copies < 2; ++copies)
    for (const std::string& text : scenes()) {
      const Scene scene = parse_scene(text, "test");
      runs.push_back(std::make_unique<Simulation>(scene));
      bits.push_back(alone(scene));
    }
  const std::vector<double> longest(runs.size(), 1.0);
  for (int k = 0; k < steps; ++k)
    for (const Stepped& result : step_together(pointers(runs), longest, 3)) {
      EXPECT_EQ(result.error, nullptr);
      EXPECT_EQ(result.report.step, k + 1);
    }
  for (std::size_t k = 0; k < runs.size(); ++k) EXPECT_EQ(bits_of(runs[k]->state()), bits[k]) << k;
}

TEST(runs_together, may_have_a_thread_each) {
  std::vector<std::uint64_t> bits, found(scenes().size());
  for (const std::string& text : scenes()) bits.push_back(alone(parse_scene(text, "test")));
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 0; k < scenes().size(); ++k)
      threads.emplace_back([k, &found] { found[k] = alone(parse_scene(scenes()[k], "test")); });
  }
  EXPECT_EQ(found, bits);
}

TEST(runs_together, one_that_fails_does_not_keep_the_others_from_their_step) {
  const Scene scene = parse_scene(scenes()[1], "test");
  const Scene collapses = parse_scene(R"(drench: 1
time: {step: 0.1, end: 100}
fluid:
  spacing: 0.01
  solver: {max_iterations: 2, min_iterations: 1}
  sources:
    - block: {min: [-0.05, 0, -0.05], max: [0.05, 0.2, 0.05]}
bodies:
  - box: {min: [-0.08, 0, -0.05], max: [0.08, 0.4, 0.05], inside: true}
)",
                                      "test");
  std::vector<std::unique_ptr<Simulation>> runs;
  for (int k = 0; k < 3; ++k) runs.push_back(std::make_unique<Simulation>(k == 1 ? collapses : scene));
  std::vector<Stepped> results;
  int k = 0;
  for (bool failed = false; k < 50 && !failed; ++k) {
    results = step_together(pointers(runs), {0.002, 1, 0.002}, 2);
    failed = results[1].error != nullptr;
  }
  ASSERT_NE(results[1].error, nullptr);
  EXPECT_THROW(std::rethrow_exception(results[1].error), std::runtime_error);
  for (const std::size_t other : {0, 2}) {
    EXPECT_EQ(results[other].error, nullptr);
    EXPECT_EQ(runs[other]->steps(), k);
  }
  EXPECT_EQ(bits_of(runs[0]->state()), bits_of(runs[2]->state()));
}

TEST(runs_together, refuses_what_it_cannot_step) {
  Simulation run(parse_scene(scenes()[3], "test"));
  EXPECT_THROW(step_together({&run, &run}, {1, 1}), std::invalid_argument);
  EXPECT_THROW(step_together({&run}, {1, 1}), std::invalid_argument);
  EXPECT_THROW(step_together({&run}, {0}), std::invalid_argument);
  EXPECT_EQ(run.steps(), 0);
  EXPECT_TRUE(step_together({}, {}).empty());
}

}  // namespace drench
