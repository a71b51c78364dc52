// What a rounding decides (compare/decisions.hpp): provoked, it puts backend and reference far apart; left, they agree,
// and what is wrong still shows.

#include "compare/decisions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "base/eigen_vec.hpp"
#include "stage_compare.hpp"
#include "state/domain_border.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

using Eigen::Vector3d;

/// Liquid on both sides of a sheet that lies askew, so that nothing about its plane is exact.
std::string askew_scene() {
  std::string scene = wet_scene();
  scene = with(scene, "mesh: {grid: {size: [0.3, 0.3], nodes: [9, 9]}}",
               "mesh: {grid: {size: [0.3, 0.3], nodes: [9, 9]}}\n"
               "    place: {position: [0.311, 0.107, -0.213], rotate: {axis: [1, 0.3, 0.2], degrees: 23}}");
  scene = with(scene, "    pin: [{edges: true}]", "    dynamics: false");
  scene = with(scene, "    - block: {min: [-0.07, 0.011, -0.06], max: [0.07, 0.151, 0.06]",
               "    - block: {min: [0.24, 0.05, -0.27], max: [0.38, 0.17, -0.15]");
  return with(scene, "center: [0, -0.06, 0], radius: 0.05", "center: [0.311, -0.06, -0.213], radius: 0.05");
}

/// A rounding of what the backend stores, m.
double rounding_at(double x) { return 2 * backend_precision().rounding * std::fabs(x); }

/// Every fourth particle that is near the sheet goes into the plane of its nearest sample, or a rounding beside it.
std::size_t into_the_plane(const Model& model, HostState& s) {
  std::mt19937 random(3);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < s.fluid_position.size(); i += 4) {
    const NearestSample sample = nearest_sample(model, s, s.fluid_position[i], 0.7 * model.support);
    if (sample.normal == Vec3{0, 0, 0}) continue;
    Vector3d x = to_eigen(s.fluid_position[i]);
    x -= (x - to_eigen(sample.position)).dot(to_eigen(sample.normal)) * to_eigen(sample.normal);
    for (int a = 0; a < 3; ++a) x[a] += (static_cast<int>(random() % 3) - 1) * rounding_at(x[a]);
    s.fluid_position[i] = to_vec3(x);
    ++moved;
  }
  return moved;
}

/// Both backends with the same model.
struct Both {
  drench::Setup setup;
  std::unique_ptr<Backend> reference, backend;
  StepInfo info;
  Precision precision = backend_precision();

  explicit Both(const std::string& scene)
      : setup(setup_from(scene)),
        reference(make_reference_backend(setup.model)),
        backend(make_kokkos_backend(setup.model)) {
    info.dt = setup.model.scene.time.step;
    precision.solve_roundings = 64;  // as in drench compare
  }

  /// What the backend can hold.
  HostState rounded(const HostState& s) {
    backend->upload(s);
    return backend->download();
  }

  std::size_t leave(Stage stage, HostState& s) {
    return leave_decisions(*reference, setup.model, stage, info, precision, s);
  }

  /// The fields and lists that are over their tolerance after the stage.
  std::vector<std::string> over(Stage stage, const HostState& before) {
    StepReport report;
    run_stage_from(*reference, setup.model, stage, before, info, report);
    run_stage_from(*backend, setup.model, stage, before, info, report);
    std::vector<std::string> names;
    auto rows = compare_fields(setup.model, stage, info.dt, reference->download(), backend->download(), precision);
    for (const auto& row : compare_lists(setup.model, stage, before, *reference, *backend, precision))
      rows.push_back(row);
    for (const auto& row : rows)
      if (row.over()) names.push_back(row.field);
    return names;
  }
};

}  // namespace

TEST(decisions, a_particle_in_the_plane_of_the_cloth_counts_on_one_side) {
  Both both(askew_scene());
  HostState state = both.setup.state;
  ASSERT_GT(into_the_plane(both.setup.model, state), 20u);
  state = both.rounded(state);
  EXPECT_EQ(both.over(Stage::neighbors, state), std::vector<std::string>{"list.fluid_fluid"}) << "nothing is provoked";

  const HostState provoked = state;
  EXPECT_GT(both.leave(Stage::neighbors, state), 20u);
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i)
    EXPECT_LT((to_eigen(state.fluid_position[i]) - to_eigen(provoked.fluid_position[i])).norm(),
              1e-2 * both.setup.model.spacing);
  state = both.rounded(state);
  EXPECT_EQ(both.leave(Stage::neighbors, state), 0u) << "it does not stay left";
  for (const Stage stage : {Stage::neighbors, Stage::density, Stage::divergence, Stage::forces, Stage::pressure})
    EXPECT_EQ(both.over(stage, state), std::vector<std::string>{}) << name_of(stage);
}

TEST(decisions, what_is_not_in_the_plane_stays) {
  Both both(askew_scene());
  HostState state = both.rounded(both.setup.state);
  const HostState before = state;
  both.leave(Stage::neighbors, state);
  std::size_t same = 0;
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i)
    same += state.fluid_position[i] == before.fluid_position[i];
  EXPECT_GT(same, state.fluid_position.size() * 9 / 10);
}

TEST(decisions, a_pair_that_is_missing_is_found_whatever_lies_in_the_plane) {
  Both both(askew_scene());
  HostState state = both.setup.state;
  into_the_plane(both.setup.model, state);
  both.leave(Stage::neighbors, state);
  state = both.rounded(state);
  EXPECT_EQ(both.over(Stage::neighbors, state), std::vector<std::string>{});

  /// Forgets one pair in both directions.
  class Forgetful final : public Backend {
   public:
    Forgetful(Backend& b, Index i, Index j) : b_(b), i_(i), j_(j) {}
    std::string name() const override { return b_.name(); }
    std::string description() const override { return b_.description(); }
    void upload(const HostState& s) override { b_.upload(s); }
    void run(Stage stage, const StepInfo& info, StepReport& report) override { b_.run(stage, info, report); }
    void fence() override { b_.fence(); }
    HostState download() const override { return b_.download(); }
    void keep() override { b_.keep(); }
    void go_back() override { b_.go_back(); }
    std::vector<std::pair<Index, Index>> neighbor_pairs(const std::string& list) const override {
      auto pairs = b_.neighbor_pairs(list);
      if (list == "fluid_fluid") {
        std::erase(pairs, std::pair(i_, j_));
        std::erase(pairs, std::pair(j_, i_));
      }
      return pairs;
    }

   private:
    Backend& b_;
    Index i_, j_;
  };
  const auto over_without = [&](Index i, Index j) {
    const Forgetful forgetful(*both.backend, i, j);
    const auto rows =
        compare_lists(both.setup.model, Stage::neighbors, state, *both.reference, forgetful, backend_precision());
    return rows.front().field == "list.fluid_fluid" ? rows.front().absolute : -1;
  };
  for (const auto& [i, j] : both.reference->neighbor_pairs("fluid_fluid")) {
    const Vector3d apart =
        to_eigen(state.fluid_position[std::size_t(i)]) - to_eigen(state.fluid_position[std::size_t(j)]);
    if (i > j || i % 16 != 0 || apart.norm() > 0.99 * both.setup.model.support) continue;
    ASSERT_EQ(over_without(i, j), 2) << i << ' ' << j;
  }

  // A backend that lets everything through the cloth.
  Model leaky = both.setup.model;
  leaky.scene.through_cloth = true;
  both.backend = make_kokkos_backend(leaky);
  EXPECT_EQ(both.over(Stage::neighbors, state), std::vector<std::string>{"list.fluid_fluid"});
  EXPECT_EQ(both.over(Stage::density, state), std::vector<std::string>{"fluid_density_ratio"});
}

namespace {

/// Liquid and cloth above a floor and a turning box.
std::string landing_scene() {
  std::string scene = with(wet_scene(), "pin: [{edges: true}]", "pin: [{corners: true}]");
  scene = with(scene, "  - sphere: {center: [0, -0.06, 0], radius: 0.05}",
               "  - box: {min: [-0.2, -0.06, -0.2], max: [0.2, -0.03, 0.2], velocity: [0.1, 0.2, 0.05], "
               "spin: {axis: [0.1, 0.2, 1], degrees_per_second: 300}}");
  return with(scene, "domain: {min: [-1, -1, -1], max: [1, 1, 1]}", "domain: {min: [-1, -1, -1], max: [1, 0.4, 1]}");
}

/// The velocity with which x gets to `end` in Δt, give or take a rounding or two of the position.
Vec3 velocity_to(const Vec3& x, const Vector3d& end, double dt, std::mt19937& random) {
  Vector3d v = (end - to_eigen(x)) / dt;
  for (int a = 0; a < 3; ++a) v[a] += (static_cast<int>(random() % 5) - 2) * rounding_at(end[a]) / dt;
  return to_vec3(v);
}

/// Where the box's upper face is at the end of the step, under x; m.
struct Face {
  Vector3d point, normal;
  Face(const Model& model, const HostState& s, double dt) {
    const Body& body = model.bodies[0];
    const auto& q = s.body_orientation[0];
    const Vector3d angle = dt * to_eigen(s.body_angular_velocity[0]);
    const Eigen::Quaterniond turn =
        Eigen::AngleAxisd(angle.norm(), angle.normalized()) * Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
    normal = turn * Vector3d::UnitY();
    point = to_eigen(s.body_position[0]) + dt * to_eigen(s.body_velocity[0]) +
            0.5 * (body.box.max[1] - body.box.min[1]) * normal;
  }
  Vector3d above(const Vec3& x, double distance) const {
    const Vector3d at = to_eigen(x);
    return at + (distance - (at - point).dot(normal)) * normal;
  }
};

using Prepare = std::function<void(const Model&, double dt, HostState&)>;

/// Expects that `prepare` puts the two apart in one of the fields, that leaving the decisions brings them together, and
/// that a wrong velocity is still found.
void expect_left(const Prepare& prepare, const std::string& field) {
  Both both(landing_scene());
  HostState state = both.setup.state;
  prepare(both.setup.model, both.info.dt, state);
  state = both.rounded(state);
  const auto provoked = both.over(Stage::advection, state);
  // In double both compute an end alike, in every bit where nothing turns.
  if (both.precision.rounding > 1e-10) {
    EXPECT_TRUE(std::find(provoked.begin(), provoked.end(), field) != provoked.end())
        << "nothing is provoked: " << testing::PrintToString(provoked);
  }

  HostState left = state;
  EXPECT_GT(both.leave(Stage::advection, left), 5u);
  left = both.rounded(left);
  for (std::size_t n = 0; n < left.node_velocity.size(); ++n)
    EXPECT_LT((to_eigen(left.node_velocity[n]) - to_eigen(state.node_velocity[n])).norm(),
              1e-2 * both.setup.model.spacing / both.info.dt);
  for (std::size_t i = 0; i < left.fluid_velocity.size(); ++i)
    EXPECT_LT((to_eigen(left.fluid_velocity[i]) - to_eigen(state.fluid_velocity[i])).norm(),
              1e-2 * both.setup.model.spacing / both.info.dt);
  EXPECT_EQ(both.over(Stage::advection, left), std::vector<std::string>{});

  StepReport report;
  run_stage_from(*both.reference, both.setup.model, Stage::advection, left, both.info, report);
  const HostState expected = both.reference->download();
  HostState wrong = expected;
  for (std::size_t n = 0; n < wrong.node_velocity.size(); n += 3)
    for (double& v : wrong.node_velocity[n]) v *= 0.9;
  std::size_t over = 0;
  for (const auto& row :
       compare_fields(both.setup.model, Stage::advection, both.info.dt, expected, wrong, backend_precision()))
    over += row.over();
  EXPECT_EQ(over, 1u);
}

}  // namespace

TEST(decisions, nodes_that_arrive_at_contact) {
  expect_left(
      [](const Model& model, double dt, HostState& s) {
        std::mt19937 random(5);
        const Face face(model, s, dt);
        for (std::size_t n = 0; n < s.node_position.size(); ++n)
          s.node_velocity[n] = velocity_to(s.node_position[n], face.above(s.node_position[n], 0.002), dt, random);
      },
      "node_velocity");
}

TEST(decisions, liquid_that_arrives_at_a_body) {
  expect_left(
      [](const Model& model, double dt, HostState& s) {
        std::mt19937 random(6);
        const Face face(model, s, dt);
        for (Vec3& x : s.node_position) x[1] += 0.3;  // out of the way
        for (std::size_t i = 0; i < s.fluid_position.size(); ++i)
          s.fluid_velocity[i] = velocity_to(s.fluid_position[i], face.above(s.fluid_position[i], 0), dt, random);
        for (Vec3& v : s.node_velocity) v = {0.3, 0.2, -0.1};
      },
      "fluid_velocity");
}

TEST(decisions, liquid_that_arrives_at_the_border) {
  expect_left(
      [](const Model& model, double dt, HostState& s) {
        std::mt19937 random(7);
        for (std::size_t i = 0; i < s.fluid_position.size(); i += 2) {
          Vector3d end = to_eigen(s.fluid_position[i]);
          end[1] = domain_border(model).max[1];
          s.fluid_velocity[i] = velocity_to(s.fluid_position[i], end, dt, random);
        }
        for (Vec3& v : s.node_velocity) v = {0.3, 0.2, -0.1};
      },
      "fluid_position");
}

TEST(decisions, liquid_that_arrives_in_the_plane_of_the_cloth) {
  expect_left(
      [](const Model& model, double dt, HostState& s) {
        std::mt19937 random(8);
        for (std::size_t n = 0; n < s.node_position.size(); ++n) {
          Vec3& x = s.node_position[n];
          if (!model.mesh.pinned[n]) x[1] += 0.02 * x[0] - 0.013 * x[2] + 1e-3 * std::sin(40 * x[0]);
          s.node_velocity[n] = {0.013, -0.21, 0.017};
        }
        // to random points of the triangles, where they will be: as far from the plane as still counts as in it
        for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
          const auto t = model.mesh.triangle[random() % model.mesh.triangle.size()];
          double w[3], sum = 0;
          for (double& one : w) sum += one = 0.1 + double(random()) / 4294967295.0;
          Vector3d end = Vector3d::Zero(), corner[3];
          bool pinned = false;
          for (std::size_t k = 0; k < 3; ++k) {
            const auto n = static_cast<std::size_t>(t[k]);
            pinned = pinned || model.mesh.pinned[n];
            corner[k] = to_eigen(s.node_position[n]) + dt * to_eigen(s.node_velocity[n]);
            end += w[k] / sum * corner[k];
          }
          end += (i % 2 == 0 ? 1e-6 : -1e-6) * model.spacing *
                 (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
          if (!pinned) s.fluid_velocity[i] = velocity_to(s.fluid_position[i], end, dt, random);
        }
      },
      "fluid_velocity");
}

}  // namespace drench::test
