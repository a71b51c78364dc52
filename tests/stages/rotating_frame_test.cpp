// Stage rotating_frame: backend against reference from identical input, the forces against their law, and its keys.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "pipeline/pipeline.hpp"
#include "precision.hpp"
#include "scene/load.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

/// Every key; the frame speeds up.
const char* const spinning = R"(drench: 1
fluid: {spacing: 0.01, sources: [{block: {min: [0, 0, 0], max: [0.1, 0.1, 0.1]}}]}
rotating_frame: {axis: [0, 2, 0], center: [0.05, 0, -0.02], degrees_per_second: [[0, 100], [0.2, 700]]}
)";
const char* const sheet = R"(drench: 1
time: {step: 0.001, end: 10}
gravity: [0, 0, 0]
cloth: [{mesh: {grid: {size: [0.2, 0.2], nodes: [5, 5]}}, pin: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}}]}]
)";
/// One full particle, without gravity.
const char* const drop = R"(drench: 1
time: {step: 0.001, end: 10}
gravity: [0, 0, 0]
fluid: {spacing: 0.01, viscosity: 0, sources: [{block: {min: [0.1, 0, 0], max: [0.11, 0.01, 0.01]}}]}
)";

/// The last line of `spinning`.
std::string frame_alone() { return std::string(spinning).substr(std::string(spinning).find("rotating_frame:")); }

std::string in_frame(const std::string& scene, const std::string& frame) {
  return scene + "rotating_frame: " + frame + "\n";
}

bool has_stage(const std::string& scene) {
  const auto stages = stages_for(setup_from(scene).model);
  return std::find(stages.begin(), stages.end(), Stage::rotating_frame) != stages.end();
}

/// How far a particle that is at rest outside the frame ends from its place after 1 rad, as a part of its radius.
double error_after_one_radian(double step) {
  const double rate = 10, radius = 0.105;
  auto setup = setup_from(in_frame(with(drop, "step: 0.001", "step: " + std::to_string(step)),
                                   "{degrees_per_second: " + std::to_string(rate * 180 / std::numbers::pi) + "}"));
  setup.state.fluid_position[0] = {radius, 0, 0};
  setup.state.fluid_velocity[0] = {0, 0, rate * radius};  // −Ω a × r
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  while (pipeline.time() < 1 / rate - 1e-9) pipeline.step(1);
  const Vec3 x = backend->download().fluid_position[0];
  return std::hypot(x[0] - radius * std::cos(1.0), x[1], x[2] - radius * std::sin(1.0)) / radius;
}

}  // namespace

TEST(rotating_frame, agrees_with_the_reference) {
  for (const char* field : {"node_velocity", "fluid_velocity", "node_pin_force"}) {
    SCOPED_TRACE(field);
    compare_stage({.stage = Stage::rotating_frame, .scene = wet_scene() + frame_alone(), .changes = field});
  }
}

TEST(rotating_frame, moves_a_free_particle_as_if_it_did_not_rotate) {
  const double error = error_after_one_radian(0.001);
  EXPECT_LT(error, 1.5 * 10 * 0.001);
  EXPECT_NEAR(error_after_one_radian(0.0005) / error, 0.5, 0.05);
}

TEST(rotating_frame, pulls_at_pins_as_its_law_says) {
  const auto setup = setup_from(in_frame(sheet, "{center: [0.3, 0, 0], degrees_per_second: [[0, 0], [1, 600]]}"));
  const double rate = 300 * std::numbers::pi / 180, faster = 600 * std::numbers::pi / 180, dt = 1e-4;
  run_on_both(setup.model, setup.state, {Stage::rotating_frame}, {0, 0.5 - 0.5 * dt, dt},
              [&](const Backend& backend, const StepReport&) {
                const HostState s = backend.download();
                for (std::size_t n = 0; n < s.node_pin_force.size(); ++n) {
                  const double x = s.node_position[n][0] - 0.3, z = s.node_position[n][2];
                  const double scale = setup.model.mesh.solid_mass[n] * rate * rate * 0.5;
                  const Vec3 law{rate * rate * x - faster * z, 0, rate * rate * z + faster * x};
                  for (std::size_t a = 0; a < 3; ++a)
                    EXPECT_NEAR(s.node_pin_force[n][a], -setup.model.mesh.solid_mass[n] * law[a],
                                allowed(backend, 1e-9, 1e-5) * scale);
                }
              });
}

TEST(rotating_frame, raises_water_to_a_paraboloid) {
  const double rate = 12, spacing = 0.01;
  const auto setup = setup_from(R"(drench: 1
time: {step: 0.002, end: 10}
fluid: {spacing: 0.01, viscosity: 0.002, sources: [{block: {min: [-0.1, 0, -0.1], max: [0.1, 0.08, 0.1]}}]}
bodies: [{box: {min: [-0.1, 0, -0.1], max: [0.1, 0.4, 0.1], inside: true}}]
rotating_frame: {degrees_per_second: [[0, 0], [0.5, 687.549]]}
)");
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  while (pipeline.time() < 3) pipeline.step(1);
  const HostState s = backend->download();
  std::map<std::pair<int, int>, double> top;  // by columns of one spacing, a spacing away from the walls
  double fastest = 0;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    const Vec3 &x = s.fluid_position[i], &v = s.fluid_velocity[i];
    fastest = std::max(fastest, std::hypot(v[0], v[1], v[2]));
    if (std::max(std::abs(x[0]), std::abs(x[2])) > 0.1 - spacing) continue;
    double& height = top[{int(std::floor(x[0] / spacing)), int(std::floor(x[2] / spacing))}];
    height = std::max(height, x[1]);
  }
  // The slope of the heights against r², by least squares.
  double mean_r2 = 0, mean_height = 0, covariance = 0, variance = 0;
  const auto r2 = [&](const auto& column) {
    return std::pow((column.first + 0.5) * spacing, 2) + std::pow((column.second + 0.5) * spacing, 2);
  };
  for (const auto& [column, height] : top) {
    mean_r2 += r2(column) / double(top.size());
    mean_height += height / double(top.size());
  }
  for (const auto& [column, height] : top) {
    covariance += (r2(column) - mean_r2) * (height - mean_height);
    variance += std::pow(r2(column) - mean_r2, 2);
  }
  const double law = rate * rate / (2 * 9.81);  // 1/m
  EXPECT_NEAR(covariance / variance, law, 0.05 * law);
  EXPECT_LT(fastest, 0.1 * rate * 0.1);
}

TEST(rotating_frame, is_a_stage_only_where_it_acts) {
  EXPECT_FALSE(has_stage(sheet));
  EXPECT_TRUE(has_stage(in_frame(sheet, "{degrees_per_second: 1}")));
  EXPECT_TRUE(has_stage(in_frame(drop, "{degrees_per_second: 1}")));
}

TEST(rotating_frame, is_read_and_saved) {
  const Scene scene = parse_scene(spinning, "test.yaml");
  EXPECT_TRUE(scene.rotating_frame.present);
  EXPECT_EQ(scene.rotating_frame.axis, (Vec3{0, 2, 0}));
  EXPECT_EQ(scene.rotating_frame.center, (Vec3{0.05, 0, -0.02}));
  EXPECT_EQ(scene.rotating_frame.degrees_per_second.at(0.1), 400);
  EXPECT_EQ(parse_scene(to_yaml(scene), "saved.yaml").rotating_frame, scene.rotating_frame);
  EXPECT_FALSE(parse_scene(drop, "test.yaml").rotating_frame.present);
}

TEST(rotating_frame, is_rejected_with_its_place) {
  const auto message = [](const std::string& scene) -> std::string {
    try {
      parse_scene(scene, "test.yaml");
    } catch (const std::exception& e) {
      return e.what();
    }
    return "";
  };
  const std::string falling = with(drop, "gravity: [0, 0, 0]", "gravity: [0, -9.81, 0]");
  EXPECT_EQ(message(in_frame(falling, "{degrees_per_second: 1}")), "");
  EXPECT_NE(message(in_frame(falling, "{degrees_per_second: 1, axis: [1, 0, 0]}")).find("test.yaml:5:"),
            std::string::npos);
  EXPECT_NE(message(in_frame(falling, "{degrees_per_second: 1, axis: [1, 0, 0]}")).find("parallel to gravity"),
            std::string::npos);
  EXPECT_NE(message(in_frame(drop, "{axis: [1, 0, 0]}")).find("degrees_per_second"), std::string::npos);
  EXPECT_NE(message(in_frame(drop,
                             "{degrees_per_second: 1}\nbodies: [{sphere: {center: [0, 1, 0], radius: 0.1, "
                             "dynamic: true}}]"))
                .find("is dynamic; allowed: bodies that are at rest or move as prescribed"),
            std::string::npos);
}

}  // namespace drench::test
