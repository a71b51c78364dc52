// Slip of bodies and cloth in stage forces: backend against reference, its limits, and what it keeps.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "ball_mesh.hpp"
#include "precision.hpp"
#include "setup/body_sampling.hpp"
#include "stage_compare.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

/// The sheet, the sphere below it and the floor slip.
std::string slipping_scene(const std::string& sheet, const std::string& sphere) {
  std::string scene = with(wet_scene(), "    thickness: 0.002\n", "    thickness: 0.002\n    slip: " + sheet + "\n");
  scene = with(scene, "radius: 0.05}", "radius: 0.05, slip: " + sphere + "}");
  return with(scene, "normal: [0, 1, 0]}", "normal: [0, 1, 0], slip: free}");
}

/// A block within 2 spacings of all kinds of bodies, each with another slip: a container that tilts, a floating box and
/// ball, a ball and a floor that keys move, and one that does not slip.
const char* const many_bodies = R"(
    - block: {min: [-0.1, 0, -0.08], max: [0.1, 0.12, 0.08], velocity: [1.5, 0.2, -0.4]}
bodies:
  - box: {min: [-0.11, -0.01, -0.09], max: [0.11, 0.2, 0.09], inside: true,
        spin: {axis: [0, 0, 1], degrees_per_second: 200}, slip: 0.01}
  - box: {min: [-0.06, 0.13, -0.03], max: [0, 0.17, 0.03], dynamic: true, density: 400, slip: free}
  - sphere: {center: [0.06, 0.15, 0], radius: 0.03, dynamic: true, density: 700,
        spin: {axis: [0, 1, 1], degrees_per_second: 900}, slip: 0.02}
  - sphere: {center: [0.05, 0.05, 0], radius: 0.03, offset: [[0, [0, 0, 0]], [0.1, [0.01, 0.03, 0]]],
        spin: {degrees_per_second: [[0, 0], [0.05, 800]]}, slip: 0.05}
  - plane: {point: [0, -0.005, 0], normal: [0.1, 1, 0], spin: {axis: [1, 0, 0], degrees_per_second: [[0, 50], [1, 0]]},
        slip: 0.003}
  - sphere: {center: [-0.05, 0.05, 0], radius: 0.02}
)";

/// Keeps few particles of many and gives them noise.
void stir(const Model&, HostState& s) {
  for (std::size_t i = 0; i < s.fluid_velocity.size(); ++i)
    for (int a = 0; a < 3; ++a) s.fluid_velocity[i][static_cast<std::size_t>(a)] += noise(i, a);
}

double square(const Vec3& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

/// Of what the liquid does not hold fast: liquid, nodes, dynamic bodies. The pins' impulse is included.
struct Motion {
  Vec3 momentum{0, 0, 0};        // kg m/s
  double energy = 0, scale = 0;  // J; Σ m v, kg m/s
};

Motion motion(const Model& m, const HostState& s, double dt) {
  Motion out;
  const auto add = [&](double mass, const Vec3& v) {
    for (std::size_t a = 0; a < 3; ++a) out.momentum[a] += mass * v[a];
    out.scale += mass * std::sqrt(square(v));
    out.energy += 0.5 * mass * square(v);
  };
  for (std::size_t i = 0; i < s.fluid_velocity.size(); ++i)
    add(static_cast<double>(s.fluid_mass[i]) * m.quantum, s.fluid_velocity[i]);
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n) {
    if (m.mesh.pinned[n])
      for (std::size_t a = 0; a < 3; ++a) out.momentum[a] -= dt * s.node_pin_force[n][a];
    else
      add(m.mesh.solid_mass[n] + static_cast<double>(s.node_liquid[n]) * m.quantum, s.node_velocity[n]);
  }
  for (std::size_t k = 0; k < m.bodies.size(); ++k) {
    if (!m.bodies[k].dynamic) continue;
    add(m.bodies[k].mass, s.body_velocity[k]);
    const Vec3& w = s.body_angular_velocity[k];  // of balls, whose inertia has no direction
    out.energy += 0.5 * m.bodies[k].inertia[0] * square(w);
  }
  return out;
}

/// What the stage does from one state with a given slip of all walls.
HostState after_forces(Model model, const HostState& state, double slip, const Backend& like) {
  for (Body& body : model.bodies) body.slip = slip;
  for (ClothMaterial& cloth : model.cloths) cloth.slip = slip;
  const auto backend = like.name() == "reference" ? make_reference_backend(model) : make_kokkos_backend(model);
  backend->upload(state);
  StepReport report;
  for (const Stage stage : {Stage::neighbors, Stage::density, Stage::forces})
    backend->run(stage, {0, 0, model.scene.time.step}, report);
  return backend->download();
}

double largest_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max(most, std::sqrt(square({a[i][0] - b[i][0], a[i][1] - b[i][1], a[i][2] - b[i][2]})));
  return most;
}

}  // namespace

TEST(slip, agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::forces,
                                   .scene = slipping_scene("0.02", "0.01"),
                                   .prepare = stir,
                                   .changes = "fluid_velocity node_velocity"});
  compare_stage(
      {.stage = Stage::forces, .scene = slipping_scene("free", "free"), .prepare = stir, .changes = "fluid_velocity"});
  compare_stage(
      {.stage = Stage::forces, .scene = slipping_scene("no", "0.03"), .prepare = crowd, .changes = "fluid_velocity"});
}

TEST(slip, agrees_with_the_reference_in_many_stages) {
  const std::string scene = with(slipping_scene("0.02", "0.01"), "viscosity: 1.0e-3", "viscosity: 0.3");
  compare_stage({.stage = Stage::forces, .scene = scene, .prepare = stir, .changes = "fluid_velocity node_velocity"});
}

TEST(slip, agrees_with_the_reference_at_bodies_that_stand_move_and_float) {
  for (const std::string viscosity : {"1.0e-3", "0.1"}) {
    const std::string scene =
        with(std::string(few_iterations) + many_bodies, "viscosity: 1.0e-3", "viscosity: " + viscosity);
    compare_stage({.stage = Stage::forces,
                   .scene = scene,
                   .prepare = stir,
                   .changes = "fluid_velocity body_velocity body_angular_velocity"});
  }
}

TEST(slip, agrees_with_the_reference_at_meshes) {
  const auto wobbling = [](int k, const Eigen::Vector3d& x) {
    const double bump = 1 + 0.1 * std::sin(0.3 * k + 3 * x[0] - 2 * x[2]);
    return Eigen::Vector3d(Eigen::Vector3d(0.003 + 0.002 * k, -0.06, 0.002) + 0.045 * bump * x);
  };
  const std::string shapes = write_shapes("slip_shapes", 6, ball_mesh(2), wobbling);
  const std::string scene = slipping_scene("no", "0.01"), ball = "sphere: {center: [0, -0.06, 0], radius: 0.05, ";
  compare_stage({.stage = Stage::forces,
                 .scene = with(scene, ball, "mesh: {sequence: \"" + shapes + "\", fps: 100, "),
                 .prepare = stir,
                 .changes = "fluid_velocity"});

  const std::filesystem::path sheet = own_file("slip_open.obj");
  std::ofstream(sheet) << "v -0.1 -0.02 -0.1\nv 0.1 -0.02 -0.1\nv 0.1 -0.03 0.1\nv -0.1 -0.01 0.1\nf 1 2 3\nf 1 3 4\n";
  std::string open = with(scene, ball, "mesh: {file: \"" + sheet.string() + "\", spin: {degrees_per_second: 30}, ");
  open = with(open, "    thickness", "    dynamics: false\n    thickness");
  compare_stage({.stage = Stage::forces, .scene = open, .prepare = stir, .changes = "fluid_velocity"});
}

TEST(slip, its_limits_are_no_slip_and_free_slip) {
  const auto setup = setup_from(slipping_scene("0.02", "0.01"));
  HostState state = setup.state;
  stir(setup.model, state);
  for (Vec3& x : state.fluid_position) x[1] -= 0.03;  // around the sheet and above the sphere
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    SCOPED_TRACE(backend->name());
    const auto velocity = [&](double slip) { return after_forces(setup.model, state, slip, *backend).fluid_velocity; };
    const std::vector<Vec3> held = velocity(0), free = velocity(inf), half = velocity(0.01);
    const double most = largest_difference(held, free), tolerance = allowed(*backend, 1e-12, 1e-5);
    EXPECT_GT(most, 1e-3);
    EXPECT_LT(largest_difference(velocity(1e-12), held), (1e-9 + tolerance) * most);
    EXPECT_LT(largest_difference(velocity(1e9), free), (1e-9 + tolerance) * most);
    EXPECT_GT(largest_difference(half, held), 0.1 * most);
    EXPECT_GT(largest_difference(half, free), 0.1 * most);
  }
}

/// In float the hundreds of stages of 10 m²/s round off 2e-6, with slip and without.
TEST(slip, a_step_of_any_viscosity_keeps_momentum_and_adds_no_energy) {
  for (const double slip : {0.0, 0.003, 0.05, inf}) {
    int most_stages = 0;
    for (const std::string viscosity : {"1.0e-6", "1.0e-3", "0.1", "10"}) {
      SCOPED_TRACE(viscosity);
      std::string scene = with(slipping_scene("1", "1"), "viscosity: 1.0e-3", "viscosity: " + viscosity);
      scene = with(scene, "domain:", "gravity: [0, 0, 0]\ndomain:");
      scene = with(scene, "thickness: 0.002", "thickness: 0.002\n    areal_density: 0.005");
      scene = with(scene, "{min: [-0.07, 0.011, -0.06], max: [0.07, 0.151, 0.06]",
                   "{min: [-0.07, 0.01, -0.06], max: [0.07, 0.15, 0.06]");
      scene = with(scene, "  - plane: {point: [0, -0.2, 0], normal: [0, 1, 0], slip: free}",
                   "  - sphere: {center: [0.03, 0.08, 0], radius: 0.03, dynamic: true, density: 50}");
      auto setup = setup_from(scene);
      for (Body& body : setup.model.bodies) body.slip = slip;
      for (ClothMaterial& cloth : setup.model.cloths) cloth.slip = slip;
      HostState state = setup.state;
      std::fill(state.node_liquid.begin(), state.node_liquid.end(), Quanta{0});
      for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
        for (int a = 0; a < 3; ++a) state.fluid_velocity[i][static_cast<std::size_t>(a)] = noise(i, a);
        state.fluid_mass[i] = quanta_per_particle / static_cast<Quanta>(1 + i % 3);
      }
      // Away from the ball that stands still, which takes momentum.
      for (Index b = 0; b < setup.model.bodies[0].sample_count; ++b)
        state.boundary_position[static_cast<std::size_t>(b)][1] -= 0.5;
      std::vector<int> stages;
      const StepInfo info{0, 0, 0.004};
      run_on_both(
          setup.model, state, {Stage::neighbors, Stage::density, Stage::forces}, info,
          [&](const Backend& backend, const StepReport& report) {
            const HostState after = backend.download();
            stages.push_back(report.viscosity_stages);
            const Motion a = motion(setup.model, state, info.dt), b = motion(setup.model, after, info.dt);
            for (std::size_t k = 0; k < 3; ++k)
              EXPECT_NEAR(a.momentum[k], b.momentum[k], allowed(backend, 1e-12, 4e-6) * b.scale) << "slip " << slip;
            EXPECT_LT(b.energy, a.energy);
            EXPECT_GT(largest_difference(state.node_velocity, after.node_velocity), 0) << "the cloth feels nothing";
            EXPECT_GT(largest_difference(state.body_velocity, after.body_velocity), 0) << "the ball feels nothing";
          });
      EXPECT_EQ(stages.front(), stages.back());
      EXPECT_GE(stages.front(), std::max(1, most_stages));
      most_stages = stages.front();
    }
    EXPECT_GT(most_stages, 10);
  }
}

TEST(slip, a_free_wall_has_no_force_along_it_however_the_liquid_lies) {
  // A floor, a sheet in its own plane and a ball about its own middle, all in motion along themselves.
  std::string scene = with(std::string(few_iterations), "viscosity: 1.0e-3", "viscosity: 0.1");
  scene = with(scene, "domain:", "gravity: [0, 0, 0]\ndomain:") + R"(
    - block: {min: [-0.1, 0, -0.1], max: [0.1, 0.2, 0.1]}
cloth: [{mesh: {grid: {size: [0.3, 0.3], nodes: [9, 9]}}, place: {position: [0, 0.16, 0]}, dynamics: false, slip: free}]
bodies:
  - plane: {point: [0, 0, 0], normal: [0, 1, 0], velocity: [2, 0, 1], slip: free}
  - sphere: {center: [0.003, 0.08, 0.002], radius: 0.05, dynamic: true, density: 500,
        spin: {axis: [1, 2, 3], degrees_per_second: 700}, slip: free}
)";
  auto setup = setup_from(scene);
  HostState state = setup.state;
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i)
    for (int a = 0; a < 3; ++a) state.fluid_position[i][static_cast<std::size_t>(a)] += 0.005 * noise(i, a);
  for (Vec3& v : state.node_velocity) v = {-3, 0, 2};
  run_on_both(setup.model, state, {Stage::neighbors, Stage::density, Stage::forces}, {0, 0, 0.004},
              [&](const Backend& backend, const StepReport& report) {
                EXPECT_GT(report.viscosity_stages, 3);
                const HostState after = backend.download();
                // Only the ball's samples are not on its surface to the last bit.
                const double rounding = allowed(backend, 1e-13, 1e-5);
                EXPECT_LT(largest_difference(after.fluid_velocity, state.fluid_velocity), rounding);
                EXPECT_LT(largest_difference(after.body_angular_velocity, state.body_angular_velocity), rounding);
                for (const Vec3& f : after.node_pin_force) EXPECT_LT(std::sqrt(square(f)), rounding);
              });
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    const HostState held = after_forces(setup.model, state, 0, *backend);
    EXPECT_GT(largest_difference(held.fluid_velocity, state.fluid_velocity), 0.1);
    EXPECT_GT(largest_difference(held.body_angular_velocity, state.body_angular_velocity), 0.1);
  }
}

TEST(slip, every_sample_knows_its_wall) {
  // The distance of a point from the wall of a sample is the body's distance, where that is plane or a ball.
  const auto setup = setup_from(std::string(few_iterations) + many_bodies);
  const Model& m = setup.model;
  ASSERT_EQ(m.boundary.wall_normal.size(), m.boundary.position.size());
  const auto along = [&](std::size_t b, const Vec3& x) {
    double sum = 0;
    for (std::size_t a = 0; a < 3; ++a) sum += (x[a] - m.boundary.position[b][a]) * m.boundary.wall_normal[b][a];
    return sum - m.boundary.wall_depth[b];
  };
  const double d = m.spacing;
  std::array<int, 4> faces{};
  for (std::size_t b = 0; b < m.boundary.position.size(); ++b) {
    const Body& body = m.bodies[static_cast<std::size_t>(m.boundary.body[b])];
    EXPECT_NEAR(square(m.boundary.wall_normal[b]), 1, 1e-12);
    if (body.kind == BodyScene::Kind::box) {
      int on = 0;
      for (const double n : m.boundary.wall_normal[b]) on += n != 0;
      ++faces[static_cast<std::size_t>(on)];
      // The corner of the faces that it lies on is on its plane.
      Vec3 corner{};
      for (std::size_t a = 0; a < 3; ++a)
        corner[a] = (m.boundary.wall_normal[b][a] > 0) == body.inside ? body.box.min[a] : body.box.max[a];
      EXPECT_NEAR(along(b, corner), 0, 1e-12);
      for (std::size_t a = 0; a < 3; ++a) corner[a] += d * m.boundary.wall_normal[b][a];
      EXPECT_NEAR(along(b, corner), d, 1e-12);
    } else if (body.kind == BodyScene::Kind::plane) {
      EXPECT_NEAR(along(b, body.point), 0, 1e-12);
    } else {
      Vec3 x = body.center;
      for (std::size_t a = 0; a < 3; ++a) x[a] += (body.radius + d) * m.boundary.wall_normal[b][a];
      EXPECT_NEAR(along(b, x), d, 1e-12);
    }
  }
  EXPECT_EQ(faces[0], 0);
  EXPECT_GT(faces[1], 100);
  EXPECT_GT(faces[2], 10);
  EXPECT_GE(faces[3], 8);
}

}  // namespace drench::test
