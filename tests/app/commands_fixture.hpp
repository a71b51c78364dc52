#pragma once
// A folder with a small scene, and the program to try on it.

#include <gtest/gtest.h>

#include "run_program.hpp"

namespace drench::test {

/// A small cube of water high above a small damp cloth, with a floor; 20 steps.
inline constexpr const char* tiny_scene = R"(drench: 1
time: {step: 0.002, end: 0.04}
domain: {min: [-0.5, -0.1, -0.5], max: [0.5, 1, 0.5]}
output: {every: 0.01}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [-0.05, 0.6, -0.05], max: [0.05, 0.7, 0.05]}
cloth:
  - name: sheet
    mesh: {grid: {size: [0.2, 0.2], nodes: [9, 9]}}
    place: {position: [0, 0.3, 0]}
    pin: [{corners: true}]
    initial_saturation: [{box: {min: [-1, 0, -1], max: [1, 1, 1]}, value: 0.5}]
    porous: {absorption: 0.01}
bodies:
  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}
)";

/// A piston presses water out of half of its room, which nothing can.
inline constexpr const char* piston_scene = R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-0.2, -0.1, -0.2], max: [0.2, 0.6, 0.2]}
output: {every: 0.01}
fluid:
  spacing: 0.02
  solver: {max_iterations: 10}
  sources: [{block: {min: [-0.06, 0, -0.06], max: [0.06, 0.2, 0.06]}}]
bodies:
  - box: {min: [-0.06, 0, -0.06], max: [0.06, 0.4, 0.06], inside: true}
  - box: {min: [-0.1, 0.21, -0.1], max: [0.1, 0.5, 0.1], velocity: [0, -1, 0]}
)";

class Commands : public testing::Test {
 protected:
  Commands() { write_text(here() / "tiny.yaml", tiny_scene); }
  const fs::path& here() const { return folder_.path(); }
  Outcome drench(const std::vector<std::string>& arguments) const { return run_drench(here(), arguments); }
  void expect_refusal(const std::vector<std::string>& arguments, const std::string& fragment) const {
    std::string command = "drench";
    for (const auto& a : arguments) command += " " + a;
    SCOPED_TRACE(command);
    const Outcome o = drench(arguments);
    EXPECT_EQ(o.code, 2);
    EXPECT_EQ(o.out, "");
    EXPECT_NE(o.err.find(fragment), std::string::npos) << o.err;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_LT(o.err.size(), 400U) << o.err;
  }

 private:
  TempFolder folder_;
};

}  // namespace drench::test
