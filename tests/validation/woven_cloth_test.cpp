// Woven cloth against theory: strips under their own weight as orthotropic plane stress, and plates of any mesh.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "irregular_sheet.hpp"
#include "setup/cloth_mesh.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

double fastest_node(const HostState& s) {
  double fastest = 0;
  for (const Vec3& v : s.node_velocity) fastest = std::max(fastest, to_eigen(v).norm());
  return fastest;
}

/// `noise`: what rounding leaves, m/s.
HostState at_rest(SceneRun& run, double slow, double until, double noise) {
  HostState state = run.state();
  for (int n = 1; run.time() < until; ++n) {
    run.step();
    if (n % 20 != 0) continue;
    state = run.state();
    if (fastest_node(state) <= slow) break;
  }
  EXPECT_LE(fastest_node(state), noise);
  return state;
}

constexpr double length = 1, width = 0.2;                // m, of the strip
constexpr double warp = 2000, weft = 1000, shear = 200;  // N/m

SurfaceMesh regular_strip(double from, double to, double across, double size) {
  SurfaceMesh mesh = grid_mesh(
      {{to - from, across},
       {static_cast<Index>(std::lround((to - from) / size)) + 1, static_cast<Index>(std::lround(across / size)) + 1}});
  for (Vec3& x : mesh.points) x = {x[0] + 0.5 * (from + to), 0, x[2] + 0.5 * across};
  return mesh;
}

/// In the middle fifth of a strip, 1 and N/m.
struct Stretched {
  double strain = 0, tension = 0;
};

/// Along a strip that hangs in x by its end at x = 0: the tension is the weight below. `degrees`: of the warp from the
/// strip's axis.
Stretched hang(const SurfaceMesh& mesh, double degrees, const std::string& method, const std::string& membrane,
               double gravity) {
  const TempFolder folder;
  const double turn = degrees * std::numbers::pi / 180, areal = 0.2;
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 30}}
gravity: [{}, 0, 0]
cloth_solver: {{tolerance: 1.0e-4, method: {}, max_iterations: 4000}}
cloth:
  - mesh: {{file: "{}"}}
    areal_density: {}
    membrane: {{{}}}
    warp: [{}, 0, {}]
    bend: 0
    damping: 20
    pin: [{{box: {{min: [-1, -1, -1], max: [1.0e-6, 1, 1]}}}}]
)",
                           gravity, method, write_obj(folder, mesh), areal, membrane, std::cos(turn), std::sin(turn)));
  const HostState s = at_rest(run, 2e-6, 6, method == "xpbd" ? 1e-4 : 2e-5);
  double strain = 0, tension = 0, whole = 0;
  for (const auto& t : run.model().mesh.triangle) {
    const auto rest = [&](int c) {
      return run.model().mesh.rest_position[static_cast<std::size_t>(t[std::size_t(c)])];
    };
    const auto now = [&](int c) { return s.node_position[static_cast<std::size_t>(t[std::size_t(c)])]; };
    const double middle = (rest(0)[0] + rest(1)[0] + rest(2)[0]) / 3;
    if (std::fabs(middle - 0.5 * length) > 0.1 * length) continue;
    Eigen::Matrix2d before, after;
    for (int c = 1; c < 3; ++c)
      for (int a = 0; a < 2; ++a) {
        before(a, c - 1) = rest(c)[std::size_t(2 * a)] - rest(0)[std::size_t(2 * a)];
        after(a, c - 1) = now(c)[std::size_t(2 * a)] - now(0)[std::size_t(2 * a)];
      }
    const double area = 0.5 * std::fabs(before.determinant());
    strain += area * ((after * before.inverse())(0, 0) - 1);
    tension += area * areal * gravity * (length - middle);
    whole += area;
  }
  return {strain / whole, tension / whole};
}

double strain_over_theory(const SurfaceMesh& mesh, double degrees, const std::string& method) {
  const auto [strain, tension] =
      hang(mesh, degrees, method, fmt::format("warp: {}, weft: {}, shear: {}", warp, weft, shear), 9.81);
  const double turn = degrees * std::numbers::pi / 180, c = std::cos(turn), n = std::sin(turn);
  return strain / (tension * (std::pow(c, 4) / warp + std::pow(n, 4) / weft + c * c * n * n / shear));
}

}  // namespace

TEST(woven_cloth, hanging_strip_stretches_as_orthotropic_plane_stress) {
  for (const double degrees : {0.0, 90.0, 45.0}) {
    double least = 1e9, most = 0;
    for (const double size : {width / 5, width / 8}) {
      const SurfaceMesh regular = regular_strip(0, length, width, size);
      const SurfaceMesh irregular = irregular_strip(0, length, width, size, 3);
      for (const SurfaceMesh* mesh : {&regular, &irregular}) {
        const bool even = mesh == &regular;
        const double ratio = strain_over_theory(*mesh, degrees, "pd");
        least = std::min(least, ratio);
        most = std::max(most, ratio);
        report({fmt::format("strip cut at {}° to the warp, {} mesh, {} cells across: strain under its weight", degrees,
                            even ? "regular" : "irregular", std::lround(width / size)),
                "orthotropic plane stress, Poisson's ratio 0", std::fabs(ratio - 1), 0.02, "1"});
      }
    }
    report({fmt::format("strip cut at {}° to the warp: strain on four meshes", degrees), "the same", most - least, 0.02,
            "1"});
  }
}

TEST(woven_cloth, both_methods_stretch_alike) {
  const SurfaceMesh mesh = irregular_strip(0, length, width, width / 5, 3);
  for (const double degrees : {0.0, 45.0})
    report({fmt::format("strip cut at {}° to the warp, by xpbd: strain under its weight", degrees),
            "orthotropic plane stress, Poisson's ratio 0", std::fabs(strain_over_theory(mesh, degrees, "xpbd") - 1),
            0.02, "1"});
}

/// To strains of 0.1 to 0.2, where yarns pull up to twice as much as at first.
TEST(woven_cloth, hanging_strip_of_yarns_that_lock) {
  constexpr double slack = 60, lock = 0.3;  // N/m, 1
  const std::string yarns =
      fmt::format("warp: {0}, weft: {0}, shear: 20, warp_locking: {1}, weft_locking: {1}", slack, lock);
  const SurfaceMesh regular = regular_strip(0, length, width, width / 5);
  const SurfaceMesh irregular = irregular_strip(0, length, width, width / 5, 3);
  for (const auto& [name, mesh] : {std::pair{"regular", &regular}, {"irregular", &irregular}})
    for (const double degrees : {0.0, 90.0})
      for (const std::string method : {"pd", "xpbd"}) {
        if (method == "xpbd" && degrees > 0) continue;
        const auto [strain, tension] = hang(*mesh, degrees, method, yarns, 200);
        const double pull = slack * strain / (1 - strain * strain / (lock * lock));
        EXPECT_GT(pull, 1.5 * slack * strain);
        report({fmt::format("strip of yarns that lock, {}° to the warp, {} mesh, {}: tension at its mean strain",
                            degrees, name, method),
                "T = k e / (1 − (e/e_L)²)", std::fabs(pull / tension - 1), 0.02, "1"});
      }
}

/// A sheet without weight that is wet on one side grows there, of springs and of a membrane.
TEST(woven_cloth, wet_fabric_grows_by_its_expansion) {
  constexpr double expansion = 0.06, wetness = 0.5, side = 0.2;
  const TempFolder folder;
  const SurfaceMesh mesh = irregular_strip(0, length, side, side / 6, 3);
  const std::string file = write_obj(folder, mesh);
  for (const std::string yarns : {"stretch: 500", "membrane: {warp: 500, weft: 300, shear: 100}"}) {
    SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 10}}
gravity: [0, 0, 0]
cloth_solver: {{tolerance: 1.0e-4}}
cloth:
  - mesh: {{file: "{}"}}
    {}
    warp: [1, 0, 0]
    bending: {{warp: 1.0e-4, weft: 1.0e-4, twist: 1.0e-4}}
    damping: 20
    initial_saturation: [{{box: {{min: [0.5, -1, -1], max: [2, 1, 1]}}, value: {}}}]
    porous: {{diffusivity: 0, max_saturation: 1, hygral_expansion: {}}}
)",
                             file, yarns, wetness, expansion));
    const auto span = [](const HostState& s) {
      double most = -1e9, least = 1e9;
      for (const Vec3& x : s.node_position) most = std::max(most, x[0]), least = std::min(least, x[0]);
      return most - least;
    };
    const double dry = span(run.state());
    const HostState s = at_rest(run, 2e-6, 6, 2e-5);
    // Half of its length grows by half of the expansion.
    report({fmt::format("sheet that is half wet, {}: growth of its length", yarns.substr(0, yarns.find(':'))),
            "half of h s", std::fabs((span(s) / dry - 1) / (0.5 * expansion * wetness) - 1), 0.05, "1"});
  }
}

/// As cloth_mechanics/Cantilever, on meshes that are not even. The nodes at x ≤ 0 are held; between them and the first
/// free ones the slope is the mean of both, so the clamp acts half an edge before x = 0.
TEST(woven_cloth, plate_of_an_irregular_mesh_bends_as_theory_says) {
  constexpr double span = 0.1, areal = 0.2, gravity = 9.81, deflection = 0.02;  // m, kg/m², m/s², 1: w/L
  const double bend = areal * gravity * span * span * span / (8 * deflection);
  for (const int cells : {12, 20}) {
    const double size = span / (cells + 0.5);
    const SurfaceMesh regular = regular_strip(-2 * size, span - 0.5 * size, 5 * size, size);
    const SurfaceMesh smooth = irregular_strip(-2 * size, span - 0.5 * size, 5 * size, size, 5);
    const SurfaceMesh rough = irregular_strip(-2 * size, span - 0.5 * size, 5 * size, size, 1);
    const std::vector<std::pair<const char*, const SurfaceMesh*>> meshes = {
        {"regular", &regular}, {"irregular", &smooth}, {"rough", &rough}};
    for (const auto& [name, mesh] : meshes) {
      const TempFolder folder;
      SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.001, end: 10}}
cloth:
  - mesh: {{file: "{}"}}
    areal_density: {}
    stretch: 500
    bending: {{warp: {}, weft: {}, twist: {}}}
    damping: 20
    pin: [{{box: {{min: [-1, -1, -1], max: [1.0e-6, 1, 1]}}}}]
)",
                               write_obj(folder, *mesh), areal, bend, bend, bend));
      const HostState s = at_rest(run, 1e-5, 2, 3e-3);  // in float a sliver trembles by 2 µm
      double tip = 0, count = 0;
      for (std::size_t n = 0; n < s.node_position.size(); ++n) {
        if (run.model().mesh.rest_position[n][0] < span - 0.5 * size - 1e-6) continue;
        tip -= s.node_position[n][1];
        ++count;
      }
      const double ratio = tip / count / (deflection * span);
      std::printf("cantilever, %s mesh of %d cells: %.4f of theory\n", name, cells, ratio);
      report({fmt::format("cantilever, plate, {} mesh of {} cells: deflection of the tip", name, cells), "q L⁴/(8 k_b)",
              std::fabs(ratio - 1), 0.05, "1"});
    }
  }
}

}  // namespace drench::test
