// The cloth at its limits: strain limiting under ten times its weight, pins that move.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/eigen_vec.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

/// Largest and smallest singular value of any triangle's deformation.
std::pair<double, double> stretches(const Model& m, const HostState& s) {
  double most = 0, least = 1e9;
  const auto edges = [](const std::vector<Vec3>& x, const std::array<Index, 3>& t) {
    const auto at = [&](std::size_t c) { return to_eigen(x[static_cast<std::size_t>(t[c])]); };
    Eigen::Matrix<double, 3, 2> e;
    e << at(1) - at(0), at(2) - at(0);
    return e;
  };
  for (const auto& t : m.mesh.triangle) {
    const Eigen::Matrix<double, 3, 2> rest = edges(m.mesh.rest_position, t), now = edges(s.node_position, t);
    const Eigen::Matrix2d r = (rest.transpose() * rest).llt().matrixU();
    const Eigen::MatrixXd deformation = now * r.inverse();
    const Eigen::VectorXd sigma = deformation.jacobiSvd().singularValues();
    most = std::max(most, sigma(0));
    least = std::min(least, sigma(1));
  }
  return {most, least};
}

/// A sheet of 0.5 m that hangs in ten times gravity until it rests: from its upper edge, or from patches at its
/// corners.
std::pair<double, double> hung(const std::string& pin, double limit) {
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.002, end: 10}}
gravity: [0, -98.1, 0]
cloth:
  - mesh: {{grid: {{size: [0.5, 0.5], nodes: [17, 17]}}}}
    stretch: 500
    strain_limit: {}
    damping: 20
    pin: [{}]
)",
                           limit, pin));
  int capped = 0;
  for (int n = 0; n < 500; ++n) capped = run.step().cloth_converged ? 0 : capped + 1;
  const auto s = stretches(run.model(), run.state());
  std::printf("limit %g, %.20s: stretch %.5f to %.5f, last %d steps at the cap\n", limit, pin.c_str(), s.second,
              s.first, capped);
  return s;
}

}  // namespace

TEST(cloth_limits, strain_stays_within_its_limit_under_ten_times_the_weight) {
  const std::string row = "{box: {min: [-1, -1, -0.2501], max: [1, 1, -0.2499]}}";
  const auto patch = [](double x, double z) {
    return fmt::format("{{box: {{min: [{}, -1, {}], max: [{}, 1, {}]}}}}", x - 0.001, z - 0.001, x + 0.0635,
                       z + 0.0635);
  };
  const std::string patches =
      patch(-0.25, -0.25) + ", " + patch(0.1875, -0.25) + ", " + patch(-0.25, 0.1875) + ", " + patch(0.1875, 0.1875);
  struct Case {
    std::string where, pin;
    double limit;
  };
  for (const auto& [where, pin, limit] : {Case{"an edge", row, 0.01}, Case{"patches at its corners", patches, 0.02}}) {
    const double free = hung(pin, 0).first, held = hung(pin, limit).first;
    EXPECT_GT(free, 1 + 1.5 * limit) << "the limit would not matter";
    report({fmt::format("strain limit {}, ten times the weight, held at {}: stretch beyond the limit", limit, where),
            "σ ≤ 1 + ε", held - (1 + limit), 0.01, "1"});
  }
}

TEST(cloth_limits, moving_pins_carry_the_cloth_and_return_where_they_were) {
  SceneRun run(R"(drench: 1
time: {step: 0.004, end: 20}
cloth_solver: {tolerance: 1.0e-4}
cloth:
  - mesh: {grid: {size: [0.4, 0.4], nodes: [13, 13]}}
    place: {rotate: {axis: [1, 0, 0], degrees: 90}}
    damping: 5
    pin: [{box: {min: [-1, 0.1999, -1], max: [1, 0.2001, 1]}, velocity: [0.5, 0, 0.3]}]
)");
  double weight = 0, drag = 0;  // N; N s/m
  const Model& m = run.model();
  for (std::size_t n = 0; n < m.mesh.solid_mass.size(); ++n) {
    weight += 9.81 * m.mesh.solid_mass[n];
    if (!m.mesh.pinned[n]) drag += m.mesh.solid_mass[n] * (1 - std::exp(-5 * 0.004)) / 0.004;
  }
  for (int n = 0; n < 1000; ++n) run.step();
  const HostState s = run.state();
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  double astray = 0;
  for (std::size_t n = 0; n < s.node_position.size(); ++n) {
    force += to_eigen(s.node_pin_force[n]);
    if (!m.mesh.pinned[n]) continue;
    const Eigen::Vector3d moved = to_eigen(s.node_position[n]) - to_eigen(m.mesh.rest_position[n]);
    astray = std::max(astray, (moved - run.time() * Eigen::Vector3d(0.5, 0, 0.3)).norm());
  }
  report({"cloth hung from pins that move at 0.58 m/s: vertical force of the pins", "its weight",
          std::fabs(force.y() / weight - 1), 1e-3, "1"});
  // At the default tolerance, a thousandth of m |y − x⁰|/Δt², in which 0.58 m/s count fifteen times as much as gravity
  // does, 5e-3.
  report({"cloth hung from pins that move at 0.58 m/s: horizontal force of the pins", "damping × mass × velocity",
          (Eigen::Vector3d(force.x(), 0, force.z()) - drag * Eigen::Vector3d(0.5, 0, 0.3)).norm() / weight, 2e-3});
  report({"pins that move for 4 s: distance from the expected position", "X0 + v t", astray, 1e-6, "m"});

  // Four turns of 1 s about an axis beside the sheet, and 0.2 s more.
  SceneRun turned(R"(drench: 1
time: {step: 0.004, end: 20}
cloth:
  - mesh: {grid: {size: [0.4, 0.4], nodes: [5, 5]}}
    pin: [{edges: true, spin: {axis: [0, 1, 0], degrees_per_second: 360, center: [0.5, 0, 0]}, end: 4}]
)");
  double farthest = 0;
  for (int n = 0; n < 1050; ++n) turned.step();
  const HostState end = turned.state();
  for (std::size_t n = 0; n < end.node_position.size(); ++n) {
    if (!turned.model().mesh.pinned[n]) continue;
    farthest =
        std::max(farthest, (to_eigen(end.node_position[n]) - to_eigen(turned.model().mesh.rest_position[n])).norm());
  }
  report({"pins after four turns: distance from the initial position", "0", farthest, 1e-6, "m"});
}

}  // namespace drench::test
