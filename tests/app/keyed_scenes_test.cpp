// Keyframes at their limits: every value that takes them runs with keys that are zero, equal, close together or only
// one.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "drench/drench.hpp"
#include "run_program.hpp"
#include "scene/load.hpp"

namespace drench::testing {
namespace {

/// What follows `key: ` in a scene, for vectors along `direction` or for numbers.
std::vector<std::string> keyed_values(const std::string& zero, const std::string& one, bool steps) {
  std::vector<std::string> all;
  const std::vector<std::vector<std::pair<double, std::string>>> lists{
      {{0, zero}},
      {{0.5, zero}},
      {{0, zero}, {0.5, zero}},
      {{0, zero}, {1e-12, zero}, {1e6, zero}},
      {{0, zero}, {1e-9, zero}, {0.5, one}},
      {{0, zero}, {0.004, one}, {0.004000001, one}, {0.5, zero}},
  };
  for (const auto& keys : lists)
    for (const char* how : {"linear", "smooth", "step"}) {
      if (!steps && std::string(how) == "step") continue;
      std::string text;
      for (const auto& [time, value] : keys) text += fmt::format("{}[{}, {}]", text.empty() ? "" : ", ", time, value);
      all.push_back(fmt::format("{{keys: [{}], interpolation: {}}}", text, how));
    }
  return all;
}

std::vector<std::string> vectors(bool steps = true) { return keyed_values("[0, 0, 0]", "[0.01, 0.02, 0]", steps); }
std::vector<std::string> numbers() { return keyed_values("0", "20", true); }

constexpr const char* liquid =
    "drench: 1\ntime: {{step: 0.002, end: 1}}\ndomain: {{min: [-0.2, -0.2, -0.2], max: [0.2, 0.3, 0.2]}}\n"
    "fluid: {{spacing: 0.02, sources: [{{block: {{min: [-0.03, 0.08, -0.03], max: [0.03, 0.14, 0.03]}}}}{}]}}\n{}";

/// Three steps.
void expect_runs(const std::string& scene) {
  SCOPED_TRACE(scene);
  ASSERT_NO_THROW({
    Simulation run(parse_scene(scene, "keyed.yaml"));
    for (int step = 0; step < 3; ++step) run.step();
  });
}

void expect_body_runs(const std::string& body) {
  expect_runs(fmt::format(fmt::runtime(liquid), "", "bodies: [" + body + "]\n"));
}

const std::vector<std::string> bodies{"sphere: {{center: [0, 0, 0], radius: 0.05, {}}}",
                                      "box: {{min: [-0.05, -0.05, -0.05], max: [0.05, 0.05, 0.05], {}}}",
                                      "box: {{min: [-0.1, 0, -0.1], max: [0.1, 0.2, 0.1], inside: true, {}}}",
                                      "plane: {{point: [0, 0, 0], normal: [0, 1, 0], {}}}"};

void expect_bodies_run(const std::string& motion) {
  for (const std::string& body : bodies) expect_body_runs("{" + fmt::format(fmt::runtime(body), motion) + "}");
}

TEST(KeyedScenes, BodiesRunWithEveryVelocity) {
  for (const std::string& keys : vectors()) expect_bodies_run("velocity: " + keys);
}

TEST(KeyedScenes, BodiesRunWithEveryOffset) {
  for (const std::string& keys : vectors(false)) expect_bodies_run("offset: " + keys);
}

TEST(KeyedScenes, BodiesRunWithEverySpin) {
  for (const std::string& keys : numbers()) expect_bodies_run("spin: {degrees_per_second: " + keys + "}");
}

/// One kind of motion is zero by keys, another is not, in one body or in two.
TEST(KeyedScenes, BodiesRunWithZeroKeysBesideOtherMotion) {
  const std::string zero = "velocity: [[0, [0, 0, 0]], [0.5, [0, 0, 0]]]";
  expect_bodies_run(zero + ", spin: {degrees_per_second: 90}");
  expect_bodies_run(zero + ", offset: [[0, [0, 0, 0]], [0.5, [0, 0.1, 0]]]");
  expect_bodies_run("velocity: [0, 0.1, 0], spin: {degrees_per_second: [[0, 0], [0.5, 0]]}");
  expect_bodies_run("offset: [[0, [0, 0, 0]]], spin: {degrees_per_second: [[0, 0]]}, " + zero);
  for (const char* other :
       {"sphere: {center: [0.1, 0, 0], radius: 0.03, velocity: [0, 0.1, 0]}",
        "sphere: {center: [0.1, 0, 0], radius: 0.03, dynamic: true, density: 500}",
        "box: {min: [0.1, 0, 0], max: [0.15, 0.1, 0.1], spin: {degrees_per_second: [[0, 0], [1, 9]]}}"})
    expect_body_runs("{sphere: {center: [0, 0, 0], radius: 0.05, " + zero + "}}, {" + other + "}");
}

TEST(KeyedScenes, JetsRunWithEveryVelocity) {
  for (const std::string& keys : vectors()) {
    const std::string scene = fmt::format(
        fmt::runtime(liquid), fmt::format(", {{jet: {{center: [0, 0.2, 0], radius: 0.02, velocity: {}}}}}", keys), "");
    if (keys.find("0.01") != std::string::npos)
      expect_runs(scene);
    else
      EXPECT_THROW(parse_scene(scene, "keyed.yaml"), SceneError) << scene;
  }
}

TEST(KeyedScenes, WindRunsWithEveryVelocity) {
  for (const std::string& keys : vectors())
    expect_runs(fmt::format(fmt::runtime(liquid), "",
                            "wind: {velocity: " + keys +
                                ", liquid_drag: 0.5}\ncloth: [{mesh: {grid: {size: [0.1, 0.1], nodes: [4, 4]}}}]\n"));
}

TEST(KeyedScenes, RotatingFramesRunWithEveryRate) {
  for (const std::string& keys : numbers())
    expect_runs(fmt::format(fmt::runtime(liquid), "",
                            "rotating_frame: {degrees_per_second: " + keys +
                                "}\ncloth: [{mesh: {grid: {size: [0.1, 0.1], nodes: [4, 4]}}}]\n"));
}

TEST(KeyedScenes, PinsRunWithEveryMotion) {
  std::vector<std::string> motions;
  for (const std::string& keys : vectors()) motions.push_back("velocity: " + keys);
  for (const std::string& keys : vectors(false)) motions.push_back("offset: " + keys);
  for (const std::string& keys : numbers())
    motions.push_back("spin: {axis: [0, 1, 0], degrees_per_second: " + keys + "}");
  motions.push_back("velocity: [[0, [0, 0, 0]]], spin: {axis: [0, 1, 0], degrees_per_second: [[0, 0], [1, 0]]}");
  for (const std::string& motion : motions)
    expect_runs(
        "drench: 1\ntime: {step: 0.002, end: 1}\ncloth: [{mesh: {grid: {size: [0.1, 0.1], nodes: [4, 4]}}, "
        "pin: [{corners: true, " +
        motion + "}]}]\n");
}

/// The files of a sequence are all alike, or one alone; with liquid, and with cloth alone whose pins follow the body.
TEST(KeyedScenes, BodiesRunWithASequenceThatDoesNotMove) {
  const test::TempFolder folder;
  for (const char* name : {"still_0.obj", "still_1.obj", "still_2.obj"})
    test::write_text(folder.path() / name,
                     "v 0 0 0\nv 0.05 0 0\nv 0 0.05 0\nv 0 0 0.05\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  for (const char* files : {"still_*.obj", "still_0.obj"}) {
    const std::string mesh = fmt::format("mesh: {{sequence: \"{}\", fps: 100}}", (folder.path() / files).string());
    expect_body_runs("{" + mesh + "}");
    expect_runs(
        "drench: 1\ntime: {step: 0.002, end: 1}\ncloth: [{mesh: {grid: {size: [0.1, 0.1], nodes: [4, 4]}}, "
        "pin: [{corners: true, body: block}]}]\nbodies: [{name: block, " +
        mesh + "}]\n");
  }
}

/// Two values at one time have no meaning, and an empty list has no value.
TEST(KeyedScenes, CoincidentAndMissingKeysAreRefused) {
  for (const char* keys :
       {"[[0, [0, 0, 0]], [0, [0, 0, 0]]]", "[[0.5, [0, 0, 0]], [0.5, [1, 0, 0]]]", "[]", "{keys: []}"})
    EXPECT_THROW(
        parse_scene(
            fmt::format(fmt::runtime(liquid), "",
                        fmt::format("bodies: [{{sphere: {{center: [0, 0, 0], radius: 0.05, velocity: {}}}}}]\n", keys)),
            "keyed.yaml"),
        SceneError)
        << keys;
}

}  // namespace
}  // namespace drench::testing
