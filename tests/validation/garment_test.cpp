// Cloth from mesh files as garments come: several parts in one file, an opening, a tube, no two triangles alike.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "app/run_program.hpp"
#include "base/eigen_vec.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

/// An OBJ of two parts that share no node: a sleeve, a tube of 0.3 m and radius 0.08 m about the y axis with an opening
/// of half its girth in the middle, and a square flap of 0.1 m beside it. Nodes are off their lattice by up to a tenth
/// of it.
std::string garment() {
  std::string points, faces;
  int count = 0;
  const auto noise = [](int n) { return 0.1 * std::sin(12.9898 * n + 1); };
  const auto point = [&](double x, double y, double z) {
    points += fmt::format("v {:.9f} {:.9f} {:.9f}\n", x, y, z);
    return ++count;
  };
  constexpr int around = 24, along = 14;
  constexpr double radius = 0.08, step = 0.3 / (along - 1), arc = 2 * std::numbers::pi / around;
  std::vector<int> node;
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < around; ++i) {
      const bool boundary = j == 0 || j == along - 1;
      const double angle = (i + (boundary ? 0 : noise(2 * count))) * arc,
                   y = 0.15 - (j + (boundary ? 0 : noise(2 * count + 1))) * step;
      const bool opening = j > 5 && j < 9 && i > 5 && i < 18;
      node.push_back(opening ? 0 : point(radius * std::cos(angle), y, radius * std::sin(angle)));
    }
  const auto face = [&](int a, int b, int c) {
    if (a > 0 && b > 0 && c > 0) faces += fmt::format("f {} {} {}\n", a, b, c);
  };
  for (int j = 0; j + 1 < along; ++j)
    for (int i = 0; i < around; ++i) {
      const auto at = [&](int k, int l) { return node[static_cast<std::size_t>((j + l) * around + (i + k) % around)]; };
      face(at(0, 0), at(1, 0), at(0, 1));
      face(at(1, 0), at(1, 1), at(0, 1));
    }
  const int first = count + 1;
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < 6; ++i) point(0.15 + 0.02 * i, 0.15 - 0.02 * j, 0.01 * noise(i + 7 * j));
  for (int j = 0; j < 5; ++j)
    for (int i = 0; i < 5; ++i) {
      const int a = first + 6 * j + i;
      face(a, a + 1, a + 6);
      face(a + 1, a + 7, a + 6);
    }
  return points + faces;
}

}  // namespace

TEST(garment, parts_and_openings_hang_as_their_weight_says) {
  const TempFolder folder;
  write_text(folder.path() / "garment.obj", garment());
  for (const char* method : {"pd", "xpbd"}) {
    SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 10}}
cloth_solver: {{method: {}, max_iterations: 1000}}
cloth:
  - mesh: {{file: "{}"}}
    areal_density: 0.2
    stretch: 300
    bend: 1.0e-5
    damping: 8
    pin: [{{box: {{min: [-1, 0.1499, -1], max: [1, 0.2, 1]}}}}]
)",
                             method, (folder.path() / "garment.obj").string()));
    const ClothMesh& mesh = run.model().mesh;
    EXPECT_EQ(mesh.nodes(), 24 * 14 - 3 * 12 + 36);
    // An opening and two ends: V − E + F = −1 for the sleeve, 1 for the flap.
    EXPECT_EQ(mesh.nodes() - static_cast<Index>(mesh.edge.size()) + mesh.triangles(), 0);
    double weight[2] = {0, 0};
    for (std::size_t n = 0; n < mesh.solid_mass.size(); ++n)
      weight[mesh.rest_position[n][0] > 0.14] += 9.81 * mesh.solid_mass[n];
    int capped = 0;
    for (int n = 0; n < 250; ++n) capped += !run.step().cloth_converged;
    const HostState s = run.state();
    double force[2] = {0, 0}, fastest = 0;
    for (std::size_t n = 0; n < s.node_position.size(); ++n) {
      force[mesh.rest_position[n][0] > 0.14] += s.node_pin_force[n][1];
      fastest = std::max(fastest, to_eigen(s.node_velocity[n]).norm());
    }
    std::printf("%s: fastest node %.2g m/s, %d steps at the cap\n", method, fastest, capped);
    EXPECT_LT(fastest, 0.02);
    const std::string what = fmt::format("garment from a mesh file, by {}: force on the pins of its ", method);
    report({what + "sleeve with an opening", "its weight", std::fabs(force[0] / weight[0] - 1), 0.005});
    report({what + "second part", "its weight", std::fabs(force[1] / weight[1] - 1), 0.005});
  }
}

}  // namespace drench::test
