// Where parts of one mesh face each other, the distance to each of them.

#include "setup/facing_parts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ball_mesh.hpp"
#include "base/eigen_vec.hpp"
#include "mesh_folder.hpp"
#include "setup/body_fields.hpp"
#include "setup/distance_field.hpp"
#include "two_legs.hpp"

namespace drench::testing {
namespace {

constexpr double thickness = 0.002;  // m

class FacingParts : public MeshFolder {
 protected:
  /// The only body of a scene with that mesh and a cloth beside it.
  Body body_beside_cloth(const std::string& obj, const std::string& dynamics = "true") const {
    write("body.obj", obj);
    return built(
               "drench: 1\ntime: {step: 0.002, end: 1}\ncloth:\n"
               "  - mesh: {grid: {size: [0.1, 0.1], nodes: [11, 11]}}\n    thickness: 0.002\n"
               "    place: {position: [0, 0.5, 0]}\n    dynamics: " +
               dynamics + "\nbodies:\n  - mesh: {file: body.obj}\n")
        .model.bodies.front();
  }
};

struct Reading {
  double phi[2];
  Vec3 normal[2];
};
Reading read(const Body& body, const Vec3& x) {
  Reading r{};
  r.phi[0] = field_distance(body.parts[0], x, r.normal[0]);
  r.phi[1] = field_distance(body.parts[1], x, r.normal[1]);
  return r;
}

}  // namespace

TEST_F(FacingParts, EachLegHasItsOwnDistance) {
  const double gap = 0.003;
  const Body body = body_beside_cloth(test::two_legs(gap));
  ASSERT_TRUE(body.has_parts());
  // From inside of one leg through the gap into the other.
  for (const double x : {-0.004, -0.001, 0.0, 0.0007, 0.004}) {
    Reading r = read(body, {x, -0.03, 0.005});
    if (r.normal[0][0] < 0) {
      std::swap(r.phi[0], r.phi[1]);
      std::swap(r.normal[0], r.normal[1]);
    }
    EXPECT_NEAR(r.phi[0], x + 0.5 * gap, 1e-6) << "m, from the leg at negative x, at " << x;
    EXPECT_NEAR(r.phi[1], 0.5 * gap - x, 1e-6) << "m, from the other leg, at " << x;
    EXPECT_NEAR(r.normal[0][0], 1, 1e-6);
    EXPECT_NEAR(r.normal[1][0], -1, 1e-6);
  }
}

TEST_F(FacingParts, LegsThatOverlapHaveTheirOwnDistances) {
  const double overlap = 0.002;
  const Body body = body_beside_cloth(test::two_legs(-overlap));
  ASSERT_TRUE(body.has_parts());
  for (const double x : {-0.004, -0.0005, 0.0, 0.0008, 0.004}) {
    Reading r = read(body, {x, -0.03, 0.005});
    if (r.normal[0][0] < 0) std::swap(r.phi[0], r.phi[1]);
    EXPECT_NEAR(r.phi[0], x - 0.5 * overlap, 1e-6) << "m, at " << x;
    EXPECT_NEAR(r.phi[1], -0.5 * overlap - x, 1e-6) << "m, at " << x;
  }
}

TEST_F(FacingParts, TheNearerPartIsTheWholeSurface) {
  const Body body = body_beside_cloth(test::two_legs(0.003));
  const std::function<double(const Vec3&)> exact = exact_distance(body);
  std::mt19937 random(5);
  const auto draw = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  int seen = 0;
  double worst = 0;  // m
  for (int k = 0; k < 20000; ++k) {
    const Vec3 x{draw(-0.045, 0.045), draw(-0.075, 0.035), draw(-0.055, 0.055)};
    const double distance = exact(x);
    if (distance < 0 || distance > 0.006) continue;
    const Reading r = read(body, x);
    if (!(std::max(r.phi[0], r.phi[1]) < 1)) continue;  // there is only the whole distance
    worst = std::max(worst, std::abs(std::min(r.phi[0], r.phi[1]) - distance));
    ++seen;
  }
  EXPECT_GT(seen, 1000);
  EXPECT_LT(worst, 0.5 * body.field.spacing) << "m: the lattice rounds edges";
}

TEST_F(FacingParts, APartIsNotThereDeepBehindTheOther) {
  const Body body = body_beside_cloth(test::two_legs(0.003));
  const double reach = 2 * (thickness + body.field.spacing), cells = 3.5 * body.field.spacing;
  const std::array<Index, 3> offset = body.parts[1].offset_in(body.field);
  int absent = 0;
  for (Index k = 0; k < body.parts[1].points[2]; ++k)
    for (Index j = 0; j < body.parts[1].points[1]; ++j)
      for (Index i = 0; i < body.parts[1].points[0]; ++i) {
        const std::size_t whole = body.field.index(i + offset[0], j + offset[1], k + offset[2]);
        if (!(body.field.value[whole] < 0)) continue;
        const double first = body.parts[0].value[whole], second = body.parts[1].value[body.parts[1].index(i, j, k)];
        absent += first == DistanceField::nowhere ? 1 : 0;
        EXPECT_TRUE(first <= std::max(reach, cells - second) || first == DistanceField::nowhere) << first << " m";
        EXPECT_TRUE(second <= std::max(reach, cells - first) || second == DistanceField::nowhere) << second << " m";
      }
  EXPECT_GT(absent, 0);
}

TEST_F(FacingParts, OtherMeshesHaveNone) {
  EXPECT_FALSE(body_beside_cloth(test::obj_of(test::ball_mesh(3), 0.05)).has_parts());
  // The two sides of a wall face away from each other.
  EXPECT_FALSE(
      body_beside_cloth(test::obj_of(test::box_mesh({-0.05, -0.05, -0.004}, {0.05, 0.05, 0.004}))).has_parts());
  // Far apart they face nothing but what joins them, in the notches at its ends.
  const Reading between = read(body_beside_cloth(test::two_legs(0.1)), {0, -0.03, 0});
  EXPECT_NEAR(between.phi[0], 0.03, 1e-6) << "m: of the whole";
  EXPECT_GT(between.phi[1], 1) << "m";
  EXPECT_FALSE(body_beside_cloth(test::two_legs(0.003), "false").has_parts()) << "no cloth moves";
}

TEST_F(FacingParts, AreTheSameWithAnyNumberOfThreads) {
  const Body body = body_beside_cloth(test::two_legs(0.003));
  for (const int threads : {1, 3}) {
    Body again = body;
    again.parts = {};
    find_facing_parts(again, thickness, threads);
    for (const std::size_t k : {0, 1}) EXPECT_EQ(again.parts[k].value, body.parts[k].value);
  }
}

TEST_F(FacingParts, AndDistancesAreTakenFromAnEarlierSetUpWithTheSameMeshAndLattice) {
  const Body body = body_beside_cloth(test::two_legs(0.003));
  FilledBodies filled;
  Body marked = body;
  marked.field.value[0] = 7;
  marked.parts[1].value[0] = 8;
  filled.keep(marked, thickness);
  Body same = body, thicker = body, moved = body, bent = body;
  moved.field.origin[0] += 1e-9;
  bent.mesh_points[0][1] += 1e-9;
  ASSERT_TRUE(filled.fill(same, thickness));
  EXPECT_EQ(same.field.value, marked.field.value);
  EXPECT_EQ(same.parts[1].value, marked.parts[1].value);
  EXPECT_FALSE(filled.fill(thicker, 2 * thickness));
  EXPECT_FALSE(filled.fill(moved, thickness));
  EXPECT_FALSE(filled.fill(bent, thickness));
  EXPECT_EQ(thicker.field.value, body.field.value);
}

}  // namespace drench::testing
