// The mouths of emitters: rectangles, faces of meshes, and where moving ones are.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <vector>

#include "build_scenes.hpp"
#include "mesh_folder.hpp"
#include "setup/emitting_faces.hpp"
#include "state/nozzle.hpp"

namespace drench::testing {
namespace {

using Eigen::Vector3d;

JetScene rectangle(double across, double up) {
  JetScene jet;
  jet.center = {0, 0.5, 0};
  jet.shape = JetScene::Shape::rectangle;
  jet.size = {across, up};
  jet.velocity = {0, -2, 0};
  return jet;
}

TEST(Emitters, RectanglesAreFilledByTheirLattice) {
  for (const auto& [across, up, points] :
       std::vector<std::array<double, 3>>{{4 * d, 3 * d, 12}, {d, 7 * d, 7}, {2.4 * d, 2.1 * d, 6}, {1.5 * d, d, 2}}) {
    Scene scene = wet_scene();
    scene.fluid.jets = {rectangle(across, up)};
    const drench::Setup setup = build(scene);
    const Jet& jet = setup.model.jets.at(0);
    EXPECT_EQ(static_cast<double>(jet.offsets.size()), points);
    EXPECT_DOUBLE_EQ(jet.area, across * up);
    EXPECT_NEAR(d * d * d / jet.interval, across * up * 2, 1e-12);
    Vector3d middle = Vector3d::Zero();
    for (const Vec3& o : jet.offsets) {  // with a vertical axis the second side is along z
      EXPECT_NEAR(o[1], 0, 1e-15);
      EXPECT_LT(std::abs(o[0]), across / 2);
      EXPECT_LT(std::abs(o[2]), up / 2);
      middle += to_eigen(o);
    }
    EXPECT_LT(middle.norm(), 1e-12);
    EXPECT_FALSE(jet.mouth.has_value());
  }
}

TEST(Emitters, RectanglesStandAsUpSays) {
  Scene scene = wet_scene();
  JetScene jet = rectangle(6 * d, 2 * d);
  jet.velocity = {0, 0, -1};
  const auto extent = [&] {
    scene.fluid.jets = {jet};
    const drench::Setup setup = build(scene);
    Vector3d most = Vector3d::Zero();
    for (const Vec3& o : setup.model.jets.at(0).offsets) most = most.cwiseMax(to_eigen(o).cwiseAbs());
    return most;
  };
  EXPECT_LT((extent() - Vector3d(2.5 * d, 0.5 * d, 0)).norm(), 1e-12);
  jet.up = {3, 0, 8};  // of which the part across the velocity counts
  EXPECT_LT((extent() - Vector3d(0.5 * d, 2.5 * d, 0)).norm(), 1e-12);
  jet.up = {0, 0, 1};
  scene.fluid.jets = {jet};
  EXPECT_EQ(error_of(scene),
            "fluid: jet 0: the velocity is along `up`; allowed: an `up` that points across the velocity");
  jet = rectangle(6 * d, 0.018);
  scene.fluid.jets = {jet};
  EXPECT_EQ(error_of(scene), "fluid: jet 0: the side 0.018 m is below the spacing, 0.02 m");
}

TEST(Emitters, StridesVisitEveryPoint) {
  for (const std::int64_t n : {1, 2, 3, 4, 6, 12, 100, 143, 1000, 4096}) {
    const std::int64_t stride = golden_stride(n);
    std::set<std::int64_t> visited;
    for (std::int64_t k = 0; k < n; ++k) visited.insert(k * stride % n);
    EXPECT_EQ(std::ssize(visited), n);
    if (n >= 100) {
      EXPECT_NEAR(static_cast<double>(stride), static_cast<double>(n) / 1.618034, 0.03 * static_cast<double>(n));
    }
  }
}

class Faces : public MeshFolder {
 protected:
  /// A plane of 0.3 m by 0.2 m in two triangles, which looks up.
  std::string plane() { return write("plane.obj", "v 0 0 0\nv 0.3 0 0\nv 0.3 0 -0.2\nv 0 0 -0.2\nf 1 2 3 4\n"); }
  Scene scene(const std::string& path) {
    Scene scene = wet_scene();
    MeshJetScene& jet = scene.fluid.mesh_jets.emplace_back();
    jet.placed.file = path;
    jet.speed = 1.5;
    return scene;
  }
};

TEST_F(Faces, EmitForTheirAreaFromEvenPoints) {
  const drench::Setup setup = build(scene(plane()));
  const Jet& jet = setup.model.jets.at(0);
  EXPECT_NEAR(jet.area, 0.06, 1e-15);
  const auto n = static_cast<double>(jet.offsets.size());
  EXPECT_GT(n, 0.95 * 0.06 / (d * d));
  EXPECT_LT(n, 1.25 * 0.06 / (d * d));
  for (const double away : nearest_distances(jet.offsets)) {
    EXPECT_GT(away, 0.7 * d);
    EXPECT_LT(away, 1.2 * d);
  }
  EXPECT_TRUE(jet.mouth->flow.empty());
  std::vector<int> times(jet.offsets.size(), 0);
  const auto particles = static_cast<std::int64_t>(20 * jet.offsets.size());
  for (std::int64_t k = 0; k < particles; ++k) {
    const Leaving p = leaving_particle(jet, k, 0.1);
    EXPECT_EQ(p.velocity, (Vec3{0, 1.5 * faces_speed_factor, 0}));
    for (std::size_t i = 0; i < jet.offsets.size(); ++i)
      if ((to_eigen(p.position) - to_eigen(jet.scene.center) - to_eigen(jet.offsets[i])).norm() < 1e-12) ++times[i];
  }
  EXPECT_EQ(times, std::vector<int>(jet.offsets.size(), 20));  // in turn
}

TEST_F(Faces, EmitAlongADirectionWhatIsSeenAlongIt) {
  Scene tilted = scene(plane());
  tilted.fluid.mesh_jets[0].direction = {3, 4, 0};
  const drench::Setup setup = build(tilted);
  EXPECT_NEAR(setup.model.jets.at(0).area, 0.8 * 0.06, 1e-15);
  const Leaving p = leaving_particle(setup.model.jets.at(0), 5, 0);
  EXPECT_LT((to_eigen(p.velocity) - 1.5 * faces_speed_factor * Vector3d(0.6, 0.8, 0)).norm(), 1e-12);
  tilted.fluid.mesh_jets[0].direction = {0, -1, 0};
  EXPECT_EQ(error_of(tilted),
            "fluid: mesh_jet 0: none of its faces looks along `direction`; allowed: the opposite direction, or none "
            "for flow along the normals");
}

TEST_F(Faces, MoveAndTurnWithTheirEmitter) {
  Scene moving = scene(plane());
  NozzleMotionScene& motion = moving.fluid.mesh_jets[0].motion;
  motion.velocity = {1, 0, 0};
  motion.spin = {{0, 0, 2}, 90};
  const drench::Setup setup = build(moving);
  const Jet& jet = setup.model.jets.at(0);
  // After a second it has turned by 90 degrees about its centre, (0.15, 0, −0.1), which has moved to (1.15, 0, −0.1).
  const double rate = std::numbers::pi / 2;
  for (std::int64_t k = 0; k < 10; ++k) {
    const Vector3d arm = to_eigen(leaving_particle(jet, k, 0).position) - to_eigen(jet.scene.center);
    const Leaving p = leaving_particle(jet, k, 1);
    const Vector3d turned(-arm.y(), arm.x(), arm.z());
    EXPECT_LT((to_eigen(p.position) - Vector3d(1.15, 0, -0.1) - turned).norm(), 1e-12);
    EXPECT_LT((to_eigen(p.velocity) - Vector3d(1, 0, 0) - rate * Vector3d(-turned.y(), turned.x(), 0) -
               1.5 * faces_speed_factor * Vector3d(-1, 0, 0))
                  .norm(),
              1e-12);
  }
  EXPECT_NEAR(fastest_leaving(jet), 1.5 * faces_speed_factor + 1 + rate * std::hypot(0.15, 0.1), 0.1);
  EXPECT_TRUE(any_has(setup.warnings, "points of its mouth are outside the domain at"));
}

/// Points in straight lines between two files that are half a turn apart: the square shrinks to a point, and grows.
TEST_F(Faces, EmitForTheAreaBetweenTheirFiles) {
  Scene moving = scene(write("far_0.obj", "v 0.1 0 0.1\nv 0.1 0 -0.1\nv -0.1 0 -0.1\nv -0.1 0 0.1\nf 1 2 3 4\n"));
  MeshJetScene& mesh = moving.fluid.mesh_jets[0];
  mesh.sequence = {
      {mesh.placed.file, write("far_1.obj", "v -0.1 0 -0.1\nv -0.1 0 0.1\nv 0.1 0 0.1\nv 0.1 0 -0.1\nf 1 2 3 4\n")}, 2};
  for (const bool along : {false, true}) {
    if (along) mesh.direction = {0, 1, 0};
    const drench::Setup setup = build(moving);
    const Jet& jet = setup.model.jets.at(0);
    for (const double part : {0.2, 0.5, 0.9, 1.0}) {
      const double exact = 1.5 * 0.04 * 0.5 * (1 - std::pow(1 - 2 * part, 3)) / 6;
      EXPECT_NEAR(volume_out(jet, 0.5 * part), exact, 1e-5 * exact) << part;
    }
    EXPECT_NEAR(jet.area, 0.04, 1e-15);
  }
  mesh.sequence.files[1] = mesh.sequence.files[0];
  EXPECT_LE(build(moving).model.jets.at(0).mouth->area.keys().size(), 5U) << "nothing changes";
}

TEST_F(Faces, SayWhatIsWrongWithThem) {
  Scene small = scene(write("speck.obj", "v 0 0 0\nv 0.001 0 0\nv 0 0 0.001\nf 1 2 3\n"));
  EXPECT_EQ(error_of(small),
            "fluid: mesh_jet 0: its faces have 5e-07 m², less than half a particle's 0.0004 m²; allowed: a larger mesh "
            "or a smaller spacing");
  Scene large = scene(plane());
  large.fluid.mesh_jets[0].placed.scale = 100;
  EXPECT_EQ(error_of(large),
            "fluid: mesh_jet 0: its mouth needs 1.5e+06 particles at spacing 0.02 m; allowed: at most 1e+05, so a "
            "smaller mesh or a larger spacing");
  Scene away = scene(plane());
  away.fluid.mesh_jets[0].placed.position = {0, 3, 0};
  EXPECT_EQ(
      error_of(away),
      "fluid: mesh_jet 0: the centre is outside the domain when it starts to flow; move it, or enlarge the domain");
  Scene other = scene(plane());
  other.fluid.mesh_jets[0].sequence.files = {plane(), write("other.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n")};
  EXPECT_EQ(error_of(other),
            "fluid: mesh_jet 0 (other.obj): its triangles differ from those of the first file; allowed: files that "
            "differ only in the positions of their points");
}

}  // namespace
}  // namespace drench::testing
