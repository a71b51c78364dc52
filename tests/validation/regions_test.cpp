// Cloth of several fabrics against theory: strips in series, a cantilever with a stiff patch, and wicking across a
// seam.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "irregular_sheet.hpp"
#include "setup/cloth_mesh.hpp"
#include "watched_cloth.hpp"

namespace drench::test {
namespace {

constexpr const char* right_half = "box: {min: [0, -1, -1], max: [9, 1, 1]}";

double fastest_node(const HostState& s) {
  double fastest = 0;
  for (const Vec3& v : s.node_velocity) fastest = std::max(fastest, to_eigen(v).norm());
  return fastest;
}

/// A mesh file whose faces beyond x = 0 are named.
std::string write_halves(const TempFolder& folder, const SurfaceMesh& mesh) {
  std::string obj;
  for (const Vec3& x : mesh.points) obj += fmt::format("v {} {} {}\n", x[0], x[1], x[2]);
  for (const auto& t : mesh.triangles) {
    double sum = 0;
    for (const Index n : t) sum += mesh.points[static_cast<std::size_t>(n)][0];
    obj += fmt::format("g {}\nf {} {} {}\n", sum > 0 ? "right" : "left", t[0] + 1, t[1] + 1, t[2] + 1);
  }
  write_text(folder.path() / "halves.obj", obj);
  return (folder.path() / "halves.obj").string();
}

/// A strip from x = −½ to ½ whose end is pulled: how far its seam moves, of the pull, and the pins' force, N.
struct Strip {
  double seam = 0, force = 0;
};

constexpr double width = 0.2, pull = 0.01;  // m

Strip pulled(const std::string& mesh, const std::string& region, const std::string& method, bool woven, double left,
             double right) {
  const auto law = [&](double k) {
    return woven ? fmt::format("membrane: {{warp: {}, weft: {}, shear: {}}}", k, k, 0.3 * k)
                 : fmt::format("stretch: {}", k);
  };
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 30}}
gravity: [0, 0, 0]
cloth_solver: {{tolerance: 1.0e-4, method: {}, max_iterations: 4000}}
cloth:
  - mesh: {}
    areal_density: 0.2
    {}
    {}
    bend: 0
    damping: 20
    pin:
      - {{box: {{min: [-1, -1, -1], max: [-0.499999, 1, 1]}}}}
      - {{box: {{min: [0.499999, -1, -1], max: [1, 1, 1]}}, offset: [[0, [0, 0, 0]], [0.4, [{}, 0, 0]]]}}
    regions: [{{{}, {}}}]
)",
                           method, mesh, law(left), woven ? "warp: [1, 0, 0]" : "slip: no", pull, region, law(right)));
  while (run.time() < 1.6) run.step();
  const HostState s = run.state();
  EXPECT_LE(fastest_node(s), 1e-3);
  double moved = 0, count = 0, force = 0;
  for (std::size_t n = 0; n < s.node_position.size(); ++n) {
    const Vec3& rest = run.model().mesh.rest_position[n];
    if (rest[0] > 0.4999) force += std::fabs(s.node_pin_force[n][0]);
    if (std::fabs(rest[0]) > 1e-6) continue;
    moved += s.node_position[n][0] - rest[0];
    ++count;
  }
  return {moved / count / pull, force};
}

}  // namespace

/// A membrane is as stiff as its keys say on any mesh. Springs depend on the mesh: each half is compared with its own.
TEST(region_mechanics, strips_in_series_stretch_as_springs) {
  constexpr double left = 2000, right = 500;  // N/m
  const TempFolder folder;
  const std::string grid = fmt::format("{{grid: {{size: [1, {}], nodes: [21, 5]}}}}", width);
  const std::string file =
      fmt::format("{{file: \"{}\"}}", write_halves(folder, irregular_strip(-0.5, 0.5, width, width / 4, 3)));
  for (const char* method : {"pd", "xpbd"})
    for (const bool woven : {true, false})
      for (const bool even : {true, false}) {
        const auto found = [&](const char* by, double b) {
          return pulled(even ? grid : file, even ? right_half : "group: right", by, woven, left, b);
        };
        const double half =
            woven || even ? 0.5 : found("pd", left).seam;  // of the compliance, where both have the same key
        const double compliance = half / left + (1 - half) / right;
        const Strip strip = found(method, right);
        const std::string name = fmt::format("two fabrics in series, {}, {}, {}", woven ? "woven" : "springs",
                                             even ? "grid with a box" : "irregular mesh with a group", method);
        report({name + ": displacement of the seam", "springs in series",
                std::fabs(strip.seam / (half / left / compliance) - 1), 0.02, "1"});
        if (woven)
          report({name + ": force of the pins", "springs in series",
                  std::fabs(strip.force / (pull * width / compliance) - 1), 0.02, "1"});
        else
          std::printf("%s: half %.4f, seam %.4f\n", name.c_str(), half, strip.seam);
      }
}

namespace {

constexpr double span = 0.1, areal = 0.2, load = areal * 9.81;  // m, kg/m², N/m²

/// How far the tip of a beam sinks whose first part, `patch` m long, has the rigidity `stiff` and the rest `soft`.
double sinks(double patch, double stiff, double soft) {
  const double rest = std::pow(span - patch, 4);
  return load / 8 * ((std::pow(span, 4) - rest) / stiff + rest / soft);
}

/// The same of a cloth at rest.
double tip(const std::string& mesh, const std::string& bending, const std::string& of_patch, double held,
           double patch_end) {
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.001, end: 10}}
cloth:
  - mesh: {}
    areal_density: {}
    stretch: 500
    {}
    damping: 20
    pin: [{{box: {{min: [-1, -1, -1], max: [{}, 1, 1]}}}}]
    regions: [{{box: {{min: [-1, -1, -1], max: [{}, 1, 1]}}, {}}}]
)",
                           mesh, areal, bending, held, patch_end, of_patch));
  while (run.time() < 3) run.step();
  const HostState s = run.state();
  const std::vector<Vec3>& rest = run.model().mesh.rest_position;
  double end = -1, down = 0, count = 0;
  for (const Vec3& x : rest) end = std::max(end, x[0]);
  for (std::size_t n = 0; n < rest.size(); ++n) {
    if (rest[n][0] < end - 1e-6) continue;
    down -= s.node_position[n][1];
    ++count;
  }
  return down / count;
}

}  // namespace

TEST(region_mechanics, a_cantilever_with_a_stiff_patch_bends_as_a_beam_of_two_sections) {
  constexpr double soft = 3e-3, stiff = 5 * soft;  // N·m: its tip sinks by 2 % of its length
  for (const int cells : {16, 32}) {
    // As woven_cloth's cantilever: the clamp acts half a cell before the line x = 0, up to which nodes are held.
    const double size = span / cells;
    const TempFolder folder;
    const auto plate = [](double b) { return fmt::format("bending: {{warp: {0}, weft: {0}, twist: {0}}}", b); };
    const SurfaceMesh mesh = irregular_strip(-2 * size, span - 0.5 * size, 5 * size, size, 3);
    const double of_plate = tip(fmt::format("{{file: \"{}\"}}", write_obj(folder, mesh)), plate(soft), plate(stiff),
                                1e-6, 0.5 * span - 0.5 * size) /
                            sinks(0.5 * span, stiff, soft);
    // As cloth_mechanics' cantilever: the clamp acts at x = 0, between the two rows that are held.
    const double l = span / (cells - 0.5), patch = (cells / 2 - 0.5) * l;
    const std::string grid =
        fmt::format("{{grid: {{size: [{}, {}], nodes: [{}, 4]}}}}\n    place: {{position: [{}, 0, 0]}}", cells * l,
                    3 * l, cells + 1, 0.5 * (cells - 1) * l);
    const double of_grid = tip(grid, fmt::format("bend: {}", soft), fmt::format("bend: {}", stiff), 0.6 * l, patch) /
                           sinks(patch, stiff, soft);
    std::printf("cantilever of two sections, %d cells: plate %.4f, grid %.4f of theory\n", cells, of_plate, of_grid);
    report({fmt::format("cantilever with a stiff patch, plate on an irregular mesh of {} cells: tip", cells),
            "beam of two sections", std::fabs(of_plate - 1), 0.05, "1"});
    report({fmt::format("cantilever with a stiff patch, grid of {} cells: tip", cells), "beam of two sections",
            std::fabs(of_grid - 1), 0.05, "1"});
  }
}

namespace {

struct Seam {
  double flux = 0, saturation = 0;  // errors, 1
};

/// Liquid goes from a reservoir at saturation 0.8 to one at 0.4 across the seam, until nothing changes.
Seam across_the_seam(const std::string& mesh, const std::string& region, double exponent, Books& books) {
  constexpr double d[2] = {2e-4, 5e-5}, thickness[2] = {0.001, 0.002}, solid[2] = {0.4, 0.7}, length = 0.05,
                   across = 0.02;  // m²/s, m
  const std::string held = fmt::format(
      "    thickness: {}\n    hold_saturation: [{{box: {{min: [-1, -1, -1], max: [{}, 1, 1]}}, value: 0.8}}, "
      "{{box: {{min: [{}, -1, -1], max: [1, 1, 1]}}, value: 0.4}}]\n    regions: [{{{}, thickness: {}, porous: "
      "{{diffusivity: {}, solid_fraction: {}}}}}]\n",
      thickness[0], -length + 1e-6, length - 1e-6, region, thickness[1], d[1], solid[1]);
  Watched run(
      still_cloth(mesh, 0.05,
                  fmt::format("diffusivity: {}, solid_fraction: {}, diffusion_exponent: {}", d[0], solid[0], exponent),
                  held),
      books);
  run.steps(8000);
  const double before = run.supplied();
  // Both reservoirs are accounted for together, so the flux is read off the saturations of the first half.
  double moment = 0, weight = 0, seam = 0, nodes = 0;
  const double m = exponent + 1;
  for (std::size_t n = 0; n < run.nodes(); ++n) {
    const double x = run.place(n)[0];
    if (std::fabs(x) < 1e-9) {
      seam += std::pow(run.saturation(n), m);
      ++nodes;
    }
    if (x > -1e-9) continue;
    moment += (x + length) * (std::pow(0.8, m) - std::pow(run.saturation(n), m));
    weight += (x + length) * (x + length);
  }
  run.steps(1);
  EXPECT_NEAR(run.supplied(), before, 1e-6 * std::fabs(before) + 1e-9);  // steady: one gives what the other takes
  double conduct[2];
  for (int k = 0; k < 2; ++k) conduct[k] = run.model().rest_density * (1 - solid[k]) * thickness[k] * d[k] / m;
  const double drop = std::pow(0.8, m) - std::pow(0.4, m);
  const double flux = drop * across / (length / conduct[0] + length / conduct[1]);  // kg/s
  const double expected = std::pow(0.8, m) - flux / across * length / conduct[0];
  return {std::fabs(moment / weight * conduct[0] * across / flux - 1),
          std::fabs(std::pow(seam / nodes, 1 / m) / std::pow(expected, 1 / m) - 1)};
}

}  // namespace

TEST(region_wicking, steady_flux_across_a_seam_is_that_of_layers_in_series) {
  Books books;
  const TempFolder folder;
  const std::string file =
      fmt::format("{{file: \"{}\"}}", write_halves(folder, irregular_strip(-0.05, 0.05, 0.02, 0.005, 3)));
  for (const double exponent : {0.0, 2.0})
    for (const bool even : {true, false}) {
      const Seam found = across_the_seam(even ? "{grid: {size: [0.1, 0.02], nodes: [21, 5]}}" : file,
                                         even ? right_half : "group: right", exponent, books);
      const std::string name = fmt::format("two fabrics with a seam across the flow, D s^{:g}, {}", exponent,
                                           even ? "grid with a box" : "irregular mesh with a group");
      report({name + ": steady flux", "layers in series", found.flux, 0.02, "1"});
      report({name + ": saturation at the seam", "continuous, by the same flux", found.saturation, 0.02, "1"});
    }
  books.print("two fabrics with a seam across the flow");
}

namespace {

/// The slowest wave of two closed layers of 5 cm: cos(k₁x) from one end, cos(k₂x) from the other, with D₁k₁² = D₂k₂²
/// and one saturation and flux where they meet.
struct SlowestWave {
  static constexpr double length = 0.05;
  double k[2], amplitude[2], rate;  // 1/m, 1, 1/s

  /// Of the left and the right layer: D, m²/s, and (1 − Φ) τ D. The right one conducts less, and D₁ is 4 D₂ at most.
  SlowestWave(const std::array<double, 2>& d, const std::array<double, 2>& conductivity) {
    const double share = std::sqrt(d[1] / d[0]);
    double low = std::numbers::pi / 2 / length, high = std::numbers::pi / length;
    for (int n = 0; n < 200; ++n) {
      const double mid = 0.5 * (low + high), other = share * mid;
      const double flux =
          conductivity[0] * other * std::tan(other * length) + conductivity[1] * mid * std::tan(mid * length);
      (flux < 0 ? low : high) = mid;
    }
    k[0] = share * low;
    k[1] = low;
    amplitude[0] = 1;
    amplitude[1] = std::cos(k[0] * length) / std::cos(k[1] * length);
    rate = d[1] * k[1] * k[1];
  }
  double at(double x) const {
    return x < 0 ? amplitude[0] * std::cos(k[0] * (x + length)) : amplitude[1] * std::cos(k[1] * (length - x));
  }
};

}  // namespace

/// That it decays at its rate takes both conductances and both capacities.
TEST(region_wicking, the_slowest_wave_decays_as_in_two_layers) {
  constexpr std::array<double, 2> d{2e-4, 5e-5}, thickness{0.001, 0.003}, solid{0.4, 0.7};
  std::array<double, 2> conductivity{};
  for (std::size_t k = 0; k < 2; ++k) conductivity[k] = (1 - solid[k]) * thickness[k] * d[k];
  const SlowestWave wave(d, conductivity);
  Books books;
  const TempFolder folder;
  const std::string file =
      fmt::format("{{file: \"{}\"}}", write_halves(folder, irregular_strip(-0.05, 0.05, 0.02, 0.0025, 3)));
  for (const bool even : {true, false}) {
    const std::string keys = fmt::format(
        "    thickness: {}\n    regions: [{{{}, thickness: {}, porous: {{diffusivity: {}, solid_fraction: {}}}}}]\n",
        thickness[0], even ? right_half : "group: right", thickness[1], d[1], solid[1]);
    Watched run(still_cloth(even ? "{grid: {size: [0.1, 0.02], nodes: [41, 9]}}" : file, 0.02,
                            fmt::format("diffusivity: {}, solid_fraction: {}", d[0], solid[0]), keys),
                books);
    run.start_from([&](const Vec3& x) { return 0.5 + 0.15 * wave.at(x[0]); });
    const auto size = [&] {
      double sum = 0;
      for (std::size_t n = 0; n < run.nodes(); ++n)
        sum += run.capacity(n) * wave.at(run.place(n)[0]) * (run.saturation(n) - 0.5);
      return sum;
    };
    const double before = size(), time = std::round(1 / wave.rate / 0.02) * 0.02;
    run.steps(static_cast<int>(std::lround(time / 0.02)));
    const double rate = std::log(before / size()) / time;
    std::printf("slowest wave of two layers: %.6f 1/s, in theory %.6f\n", rate, wave.rate);
    report({fmt::format("two fabrics, closed, {}: rate at which the slowest wave decays",
                        even ? "grid with a box" : "irregular mesh with a group"),
            "eigenvalue of two layers", std::fabs(rate / wave.rate - 1), 0.02, "1"});
  }
  books.print("two closed fabrics");
}

/// Without gravity the pressure is one at rest, and so is the saturation, whatever each fabric can hold.
TEST(region_wicking, at_rest_the_saturation_is_one_on_both_sides_of_a_seam) {
  Books books;
  const std::string keys = fmt::format(
      "    regions: [{{{}, thickness: 0.003, porous: {{diffusivity: 2.0e-5, solid_fraction: 0.2}}}}]\n", right_half);
  Watched run(still_cloth("{grid: {size: [0.1, 0.02], nodes: [21, 5]}}", 0.1, "diffusivity: 2.0e-4", keys), books);
  run.start_from([](const Vec3& x) { return x[0] < 0 ? 0.9 : 0.1; });
  run.steps(3000);
  double least = 1, most = 0;
  for (std::size_t n = 0; n < run.nodes(); ++n) {
    least = std::min(least, run.saturation(n));
    most = std::max(most, run.saturation(n));
  }
  report({"two fabrics, at rest without gravity: largest difference of saturation", "0: equal pressure", most - least,
          1e-3, "1"});
  books.print("two fabrics, at rest");
}

}  // namespace drench::test
