// Bodies that change their shape: each stage that meets them against the reference, and what holds of their surface and
// samples.

#include "setup/deforming_body.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ball_mesh.hpp"
#include "base/eigen_vec.hpp"
#include "mesh_sequence.hpp"
#include "pipeline/pipeline.hpp"
#include "point_caches.hpp"
#include "precision.hpp"
#include "setup/body_geometry.hpp"
#include "setup/setup_error.hpp"
#include "stage_compare.hpp"
#include "state/deforming_body.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

using Eigen::Vector3d;

constexpr double fps = 100;

/// A ball under the sheet that swells, leans and has bumps; its middle is not on the lattice of anything.
Vector3d wobbling(int k, const Vector3d& x) {
  const double t = k / fps, bump = 1 + 0.15 * std::sin(30 * t + 3 * x[0] - 2 * x[2]) + 3 * t;
  return Vector3d(0.0031 + 0.2 * t, -0.0607, 0.0017) +
         0.045 * bump * Vector3d(x[0] + 4 * t * x[1], x[1], x[2] - 2 * t * x[1]);
}

std::string wobbling_ball(const char* name) { return write_shapes(name, 12, ball_mesh(2), wobbling); }

std::string with_mesh(const std::string& scene, const std::string& files) {
  return with(scene, "  - sphere: {center: [0, -0.06, 0], radius: 0.05}",
              "  - mesh: {sequence: \"" + files + "\", fps: 100}");
}

std::string wobbling_scene(const char* name) { return with_mesh(wet_scene(), wobbling_ball(name)); }

/// Nodes into the body, and some particles.
void into_the_body(const Model&, HostState& s) {
  for (Vec3& x : s.node_position) x[1] -= 0.0095;
  for (std::size_t i = 0; i < s.fluid_position.size(); i += 7)
    s.fluid_position[i] = {0.013, -0.031, 0.008 + 1e-5 * static_cast<double>(i)};
}

}  // namespace

TEST(deforming_body, samples_move_as_in_the_reference) {
  const std::string scene = wobbling_scene("wobbling_samples");
  compare_stage({.stage = Stage::prescribed_motion, .scene = scene, .changes = "boundary_velocity"});
  for (const char* field : {"boundary_position", "boundary_velocity", "boundary_volume"})
    compare_stage({.stage = Stage::bodies, .scene = scene, .changes = field});
}

/// Before the first of its times, between two that are far apart, or close, and after the last.
TEST(deforming_body, follows_a_point_cache_as_in_the_reference) {
  const std::string keys = write_mdd("wobbling_cache", ball_mesh(2), {0.012F, 0.02F, 0.025F, 0.055F}, wobbling),
                    scene = with(wet_scene(), "  - sphere: {center: [0, -0.06, 0], radius: 0.05}",
                                 "  - mesh: {" + keys + "}");
  for (const int steps : {2, 9, 12, 30})
    for (const char* field : {"boundary_position", "boundary_velocity"})
      compare_stage(
          {.stage = Stage::bodies, .scene = scene, .steps_before = steps, .changes = steps == 9 ? field : ""});
}

TEST(deforming_body, stops_cloth_and_liquid_as_in_the_reference) {
  const std::string scene = wobbling_scene("wobbling_contact");
  for (const Stage stage : {Stage::cloth, Stage::pressure, Stage::advection})
    compare_stage({.stage = stage,
                   .scene = scene,
                   .prepare = into_the_body,
                   .changes = stage == Stage::cloth ? "node_contact_force" : "fluid_velocity"});
}

/// After the last file: a mesh away from an edge its two triangles are equally near, and only their velocities would
/// differ.
TEST(deforming_body, wet_cloth_sticks_to_it_as_in_the_reference) {
  compare_stage(
      {.stage = Stage::wet_adhesion,
       .scene = with(wobbling_scene("wobbling_wet"), "emission_velocity: 5", "emission_velocity: 5, adhesion: 0.1"),
       .steps_before = 60,
       .prepare =
           [](const Model&, HostState& s) {
             for (Vec3& x : s.node_position) x[1] -= 0.006;
           },
       .changes = "node_velocity"});
}

TEST(deforming_body, stops_a_floating_body_as_in_the_reference) {
  const std::string scene =
      wobbling_scene("wobbling_float") +
      "  - sphere: {center: [0.02, 0.0, 0.01], radius: 0.025, velocity: [0, -1, 0], dynamic: true, density: 500}\n";
  compare_stage({.stage = Stage::bodies, .scene = scene, .steps_before = 3, .changes = "body_velocity"});
}

/// Scenes at a time in the middle of a file's interval, at one of its ends, and after the last file.
TEST(deforming_body, follows_its_files_at_any_time) {
  const std::string scene = wobbling_scene("wobbling_times");
  for (const int steps : {4, 5, 60})
    compare_stage({.stage = Stage::prescribed_motion, .scene = scene, .steps_before = steps});
  const auto setup = setup_from(scene);
  const Body& body = setup.model.bodies[0];
  ASSERT_TRUE(body.deforms());
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  for (int file = 1; file < 13; ++file) {
    while (pipeline.time() < file / fps - 1e-9) pipeline.step(std::min(0.0013, file / fps - pipeline.time()));
    const HostState s = backend->download();
    double worst = 0;
    for (std::size_t k = 0; k < body.shape.triangle.size(); ++k) {
      const auto& t = body.mesh_triangles[static_cast<std::size_t>(body.shape.triangle[k])];
      Vector3d at = Vector3d::Zero();
      std::array<Vector3d, 3> corner;
      for (std::size_t c = 0; c < 3; ++c) {
        corner[c] =
            to_eigen(body.shape.points[static_cast<std::size_t>(std::min(file, 11))][static_cast<std::size_t>(t[c])]);
        at += body.shape.weight[k][c] * corner[c];
      }
      at -= body.shape.depth[k] * (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
      worst =
          std::max(worst, (at - to_eigen(s.boundary_position[static_cast<std::size_t>(body.first_sample) + k])).norm());
    }
    EXPECT_LT(worst, double_precision ? 1e-14 : 2e-8) << file;
  }
}

TEST(deforming_body, the_velocity_of_its_samples_is_their_way_over_the_step) {
  const auto setup = setup_from(wobbling_scene("wobbling_way"));
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  for (int k = 0; k < 4; ++k) pipeline.step(1);
  const StepInfo info{4, pipeline.time(), 0.0035};  // over the end of a file's interval
  StepReport report;
  const HostState before = backend->download();
  backend->run(Stage::prescribed_motion, info, report);
  const HostState during = backend->download();
  backend->run(Stage::bodies, info, report);
  const HostState after = backend->download();
  const Body& body = setup.model.bodies[0];
  double worst = 0, farthest = 0;
  for (Index b = body.first_sample; b < body.first_sample + body.sample_count; ++b)
    for (std::size_t a = 0; a < 3; ++a) {
      const auto k = static_cast<std::size_t>(b);
      const double way = after.boundary_position[k][a] - before.boundary_position[k][a];
      worst = std::max(worst, std::abs(during.boundary_velocity[k][a] * info.dt - way));
      farthest = std::max(farthest, std::abs(way));
    }
  EXPECT_GT(farthest, 1e-4);
  EXPECT_LT(worst, double_precision ? 1e-15 : 4e-8);
}

TEST(deforming_body, the_time_step_looks_ahead_along_its_files) {
  const std::string files = write_shapes("jumping", 4, ball_mesh(1), [](int k, const Vector3d& x) {
    return Vector3d(0.05 * x +
                    Vector3d(0, -0.06 + (k == 3 && x[1] > 0.9 ? 0.04 : 0) + (k == 1 && x[1] < -0.9 ? -0.001 : 0), 0));
  });
  const auto setup = setup_from(with(with_mesh(wet_scene(), files), "end: 1.0}", "end: 1.0, mode: cfl}"));
  for (const double time : {0.0, 0.0185, 0.05}) {
    StepReport report;
    const auto backend = make_kokkos_backend(setup.model);
    backend->upload(setup.state);
    backend->run(Stage::time_step, {0, time, 0.002}, report);
    EXPECT_NEAR(report.dt_wanted, time == 0.0185 ? 0.4 * 0.02 / 4 : 0.002, 1e-6) << time;
  }
}

/// No point of the surface is far from a sample in any file, although it grows to 2.4 times its size.
TEST(deforming_body, a_body_that_grows_stays_covered_by_its_samples) {
  const std::string files = write_shapes("swelling", 15, ball_mesh(3), [](int k, const Vector3d& x) {
    return Vector3d(0.05 * (1 + 0.1 * k) * x + Vector3d(0, -0.2, 0));
  });
  const auto setup = setup_from(with_mesh(wet_scene(), files));
  const Body& body = setup.model.bodies[0];
  for (std::size_t k = 0; k < body.shape.points.size(); ++k) {
    std::vector<Vector3d> samples;
    for (std::size_t s = 0; s < body.shape.triangle.size(); ++s) {
      const auto& t = body.mesh_triangles[static_cast<std::size_t>(body.shape.triangle[s])];
      std::array<Vector3d, 3> corner;
      Vector3d at = Vector3d::Zero();
      for (std::size_t c = 0; c < 3; ++c) {
        corner[c] = to_eigen(body.shape.points[k][static_cast<std::size_t>(t[c])]);
        at += body.shape.weight[s][c] * corner[c];
      }
      samples.push_back(at - body.shape.depth[s] * (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized());
    }
    double farthest = 0;
    for (const Vec3& x : body.shape.points[k]) {
      double nearest = 1;
      for (const Vector3d& sample : samples) nearest = std::min(nearest, (sample - to_eigen(x)).norm());
      farthest = std::max(farthest, nearest);
    }
    EXPECT_LT(farthest, 1.21 * setup.model.spacing) << "file " << k;  // √(1.1² + 0.5²)
  }
}

namespace {

struct RigidAndSoft {
  double apart = 0, speed = 0, volume = 0,
         height = 0;  // largest differences of samples, m, m/s, 1; of the liquid's mean height, m
};

/// A rigid motion with a strain of 1e-4, too much to be taken for rigid, against the same motion without it.
RigidAndSoft compare_with_rigid(const std::string& name, double turning, int steps) {
  const auto moving = [&](double strain) {
    return [strain, turning](int k, const Vector3d& x) {
      const double t = k / fps;
      return Vector3d(Vector3d(0.002 + 0.4 * t, -0.06 + 0.3 * t, 0.001) +
                      Eigen::AngleAxisd(turning * t, Vector3d(1, 2, 3).normalized()) *
                          (x * (1 + (k > 0 ? strain : 0))));
    };
  };
  const Vector3d half(0.045, 0.035, 0.04);
  const auto rigid = setup_from(with_mesh(wet_scene(), write_boxes(name + "_rigid", 12, half, moving(0)))),
             soft = setup_from(with_mesh(wet_scene(), write_boxes(name + "_soft", 12, half, moving(1e-4))));
  EXPECT_FALSE(rigid.model.bodies[0].deforms());
  EXPECT_TRUE(soft.model.bodies[0].deforms());
  EXPECT_EQ(rigid.model.boundary.count(), soft.model.boundary.count());
  const auto one = make_kokkos_backend(rigid.model), other = make_kokkos_backend(soft.model);
  Pipeline first(rigid.model, *one, rigid.state), second(soft.model, *other, soft.state);
  for (int k = 0; k < steps; ++k) {
    first.step(1);
    second.step(1);
  }
  const HostState a = one->download(), b = other->download();
  RigidAndSoft d;
  for (std::size_t s = 0; s < a.boundary_position.size(); ++s) {
    d.apart = std::max(d.apart, (to_eigen(a.boundary_position[s]) - to_eigen(b.boundary_position[s])).norm());
    d.speed = std::max(d.speed, (to_eigen(a.boundary_velocity[s]) - to_eigen(b.boundary_velocity[s])).norm());
    d.volume = std::max(d.volume, std::abs(b.boundary_volume[s] / a.boundary_volume[s] - 1));
  }
  for (const Vec3& x : a.fluid_position) d.height += x[1] / a.fluid_count();
  for (const Vec3& x : b.fluid_position) d.height -= x[1] / b.fluid_count();
  return d;
}

}  // namespace

TEST(deforming_body, a_rigid_motion_agrees_with_a_rigid_body) {
  const RigidAndSoft shifted = compare_with_rigid("shifted", 0, 50), turned = compare_with_rigid("turned", 4, 30);
  EXPECT_LT(shifted.apart, 1e-5) << "the strain of 7 cm";
  EXPECT_LT(turned.apart, 3e-5) << "strain, and chords of arcs of 2.3° on 7 cm";
  EXPECT_LT(turned.speed, 0.01) << "of 0.5 m/s";
  EXPECT_LT(std::max(turned.volume, shifted.volume), 2e-3);
  // Liquid and cloth fall on it by some centimetres. Its lattice does not turn, so sharp edges are rounded in another
  // way.
  EXPECT_NEAR(shifted.height, 0, 1e-4);
  EXPECT_NEAR(turned.height, 0, 2.5e-4) << "1.3 % of a spacing";
}

/// The signs of distances: particles all over the lattice end outside of the mesh, and those outside stay where they
/// are.
TEST(deforming_body, the_failsafe_puts_all_particles_out_and_moves_no_other) {
  const std::string files = write_shapes("pear", 3, ball_mesh(3), [](int k, const Vector3d& x) {
    return Vector3d(0.08 *
                    Vector3d(x[0] * (1 + 0.5 * x[1]) + 0.02 * k, x[1] * 1.3, x[2] * (1 - 0.4 * x[1]) * (1 + 0.05 * k)));
  });
  const auto setup = setup_from(
      "drench: 1\ntime: {step: 0.002, end: 1}\ngravity: [0, 0, 0]\nfluid: {spacing: 0.02, sources: [{block: "
      "{min: [0.2, 0, 0], max: [0.4, 0.2, 0.2]}}]}\nbodies: [{mesh: {sequence: \"" +
      files + "\", fps: 100}}]\n");
  ASSERT_TRUE(setup.model.bodies[0].deforms());
  HostState s = setup.state;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> anywhere(-0.12, 0.12);
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    s.fluid_position[i] = {anywhere(random), anywhere(random), anywhere(random)};
    s.fluid_velocity[i] = {0, 0, 0};
  }
  const StepInfo info{0, 0.004, 0.002};
  const auto backend = make_kokkos_backend(setup.model);
  StepReport report;
  backend->upload(s);
  for (const Stage stage : until_advection) backend->run(stage, info, report);
  const HostState end = backend->download();
  Body now = shape_with_field_at(setup.model.bodies[0], info.time + info.dt);
  int inside = 0;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    Vec3 normal;
    const double before = signed_distance(now, s.fluid_position[i], normal),
                 after = signed_distance(now, end.fluid_position[i], normal);
    // Deeper than the band there is no gradient; so deep no particle comes in a step.
    if (before < -0.9 * setup.model.bodies[0].shape.band) continue;
    inside += before < 0 ? 1 : 0;
    EXPECT_GT(after, -2e-3 * setup.model.spacing) << before;
    if (before > 1e-3 * setup.model.spacing) {
      EXPECT_LT((to_eigen(end.fluid_position[i]) - to_eigen(s.fluid_position[i])).norm(), 1e-3 * setup.model.spacing);
    }
  }
  EXPECT_GT(inside, 40);
  EXPECT_GE(report.clamped, inside);
}

namespace {

std::string refusal(const std::string& files) {
  try {
    setup_from(
        "drench: 1\nfluid: {spacing: 0.02, sources: [{block: {min: [0.2, 0, 0], max: [0.3, 0.1, 0.1]}}]}\n"
        "bodies: [{mesh: {sequence: \"" +
        files + "\"}}]\n");
  } catch (const SetupError& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST(deforming_body, wrong_files_are_refused_by_name) {
  const auto growing = [](int k, const Vector3d& x) { return Vector3d((0.05 + 0.01 * k) * x); };
  TestMesh sheet = ball_mesh(1);
  sheet.triangles.resize(1);
  EXPECT_NE(refusal(write_shapes("sheet", 3, sheet, growing)).find("encloses no volume"), std::string::npos);
  const std::string inverted = refusal(write_shapes("inverted", 3, ball_mesh(1), [](int k, const Vector3d& x) {
    return Vector3d(0.05 * (k == 0 ? 1 : k == 1 ? 0.5 : -0.5) * x);
  }));
  EXPECT_NE(inverted.find("0002.obj"), std::string::npos) << inverted;
  EXPECT_NE(inverted.find("turned inside out"), std::string::npos) << inverted;
  const std::string flat = refusal(write_shapes("flat", 3, ball_mesh(1), [](int k, const Vector3d& x) {
    return Vector3d(0.05 * Vector3d(x[0], x[1] * (k == 1 ? 0 : 1), x[2]));
  }));
  EXPECT_NE(flat.find("0001.obj"), std::string::npos) << flat;
}

/// Its hole is covered, and the cover moves with its edge. A sliver in some file is no reason to refuse it.
TEST(deforming_body, an_open_one_with_a_sliver_agrees_with_the_reference) {
  TestMesh open = ball_mesh(2);
  std::erase_if(open.triangles, [&](const std::array<int, 3>& t) {
    return open.points[static_cast<std::size_t>(t[0])][1] > 0.7 ||
           open.points[static_cast<std::size_t>(t[1])][1] > 0.7 || open.points[static_cast<std::size_t>(t[2])][1] > 0.7;
  });
  const auto [a, b, c] = open.triangles[0];
  const auto flattening = [&, p = open.points[static_cast<std::size_t>(a)],
                           q = open.points[static_cast<std::size_t>(b)],
                           r = open.points[static_cast<std::size_t>(c)]](int k, const Vector3d& x) {
    return wobbling(k, k == 2 && x == r ? Vector3d(0.5 * (p + q)) : x);
  };
  const std::string scene = with_mesh(wet_scene(), write_shapes("open_wobbling", 12, open, flattening));
  const auto setup = setup_from(scene);
  EXPECT_TRUE(std::any_of(setup.warnings.begin(), setup.warnings.end(), [](const std::string& line) {
    return line.find("the mesh has 1 hole, 0.0") != std::string::npos;
  }));
  for (const Stage stage : {Stage::cloth, Stage::pressure, Stage::advection})
    compare_stage({.stage = stage,
                   .scene = scene,
                   .prepare =
                       [](const Model&, HostState& state) {  // onto the cover, and into the solid below it
                         for (Vec3& x : state.node_position) x[1] -= 0.0225;
                         for (std::size_t n = 0; n < state.fluid_position.size(); n += 7)
                           state.fluid_position[n] = {0.013, -0.037, 0.008 + 1e-5 * static_cast<double>(n)};
                       },
                   .changes = stage == Stage::cloth ? "node_contact_force" : "fluid_velocity"});
}

/// Triangles the wrong way round, or each as it likes: the same body.
TEST(deforming_body, the_order_of_its_corners_does_not_matter) {
  TestMesh mixed = ball_mesh(2);
  for (std::size_t t = 0; t < mixed.triangles.size(); ++t)
    if (t % 3 != 0) std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
  const auto setup = setup_from(with_mesh(wet_scene(), write_shapes("mixed", 12, mixed, wobbling)));
  const Body& body = setup.model.bodies[0];
  for (const auto& points : body.shape.points) {
    double volume = 0;
    const Vector3d middle(0, -0.06, 0);
    for (const auto& t : body.mesh_triangles) {
      const auto at = [&](std::size_t c) {
        return Vector3d(to_eigen(points[static_cast<std::size_t>(t[c])]) - middle);
      };
      const double part = at(0).dot(at(1).cross(at(2))) / 6;
      EXPECT_GT(part, 0);
      volume += part;
    }
    EXPECT_GT(volume, 2e-4);
  }
}

TEST(deforming_body, is_warned_of_where_triangles_turn_too_far_between_files) {
  const auto turning = [](int k, const Vector3d& x) {
    return Vector3d(0.05 * (1 + 0.01 * k) * (Eigen::AngleAxisd(2.5 * k, Vector3d::UnitY()) * x));
  };
  const auto setup = setup_from(with_mesh(wet_scene(), write_shapes("turning", 3, ball_mesh(1), turning)));
  const bool warned = std::any_of(setup.warnings.begin(), setup.warnings.end(), [](const std::string& line) {
    return line.find("turn by more than 90°") != std::string::npos;
  });
  EXPECT_TRUE(warned);
}

}  // namespace drench::test
