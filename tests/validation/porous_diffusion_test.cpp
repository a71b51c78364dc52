// How liquid spreads and rises within a fabric, against theory and finite elements: cloth that does not move, no liquid
// particles. Without liquid the spacing d (which sets the quantum) is the mean edge of the mesh, and diffusion itself
// knows only the mesh: its edges are what a refinement halves.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/run_program.hpp"
#include "patches.hpp"
#include "watched_cloth.hpp"

namespace drench::test {
namespace {

constexpr double pi = std::numbers::pi;

/// ds/dt = D ∇²s by linear finite elements (cotangent Laplacian, consistent masses) and Crank–Nicolson.
Eigen::VectorXd finite_elements(const Patch& mesh, Eigen::VectorXd s, double diffusivity, double time, int steps) {
  std::vector<Eigen::Triplet<double>> mass, stiffness;
  for (const auto& t : mesh.t) {
    const auto x = [&](std::size_t k) { return mesh.x[static_cast<std::size_t>(t[k % 3])]; };
    const double area = (x(1) - x(0)).cross(x(2) - x(0)).norm() / 2;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d u = x(k + 1) - x(k), v = x(k + 2) - x(k);
      const double cotangent = u.dot(v) / u.cross(v).norm() / 2;
      const int a = t[(k + 1) % 3], b = t[(k + 2) % 3];
      for (const auto& [i, j, sign] :
           {std::tuple{a, a, 1}, std::tuple{b, b, 1}, std::tuple{a, b, -1}, std::tuple{b, a, -1}})
        stiffness.emplace_back(i, j, sign * cotangent);
      for (std::size_t l = 0; l < 3; ++l) mass.emplace_back(t[k], t[l], k == l ? area / 6 : area / 12);
    }
  }
  const auto n = static_cast<Eigen::Index>(mesh.x.size());
  Eigen::SparseMatrix<double> M(n, n), K(n, n);
  M.setFromTriplets(mass.begin(), mass.end());
  K.setFromTriplets(stiffness.begin(), stiffness.end());
  const double dt = time / steps;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> left(M + 0.5 * dt * diffusivity * K);
  const Eigen::SparseMatrix<double> right = M - 0.5 * dt * diffusivity * K;
  for (int k = 0; k < steps; ++k) s = left.solve(right * s);
  return s;
}

struct Decay {
  double amplitude;  // over e^{−1} of the first, − 1
  double worst;      // node, over the amplitude
};

/// s = 0.5 + 0.4 cos(π x/L), x from 0, after t = L²/(D π²).
Decay decay_of_cosine(Watched& run, double length, double left, int steps) {
  const auto mode = [&](const Vec3& x) { return std::cos(pi * (x[0] - left) / length); };
  run.start_from([&](const Vec3& x) { return 0.5 + 0.4 * mode(x); });
  run.steps(steps);
  double product = 0, square = 0, worst = 0;
  for (std::size_t n = 0; n < run.nodes(); ++n) {
    const double c = mode(run.place(n)), s = (run.saturation(n) - 0.5) / 0.4;
    product += run.capacity(n) * s * c;
    square += run.capacity(n) * c * c;
    worst = std::max(worst, std::fabs(s * std::exp(1.0) - c));
  }
  return {std::fabs(product / square * std::exp(1.0) - 1), worst};
}

constexpr double length = 0.2, diffusivity = 1e-3, decay_time = length * length / (diffusivity * pi * pi);

}  // namespace

TEST(porous_diffusion, a_cosine_decays_on_a_lattice_with_order_two) {
  std::vector<double> amplitude, worst;
  Books books;
  for (const int nodes : {11, 21, 41}) {
    Watched run(still_cloth(fmt::format("{{grid: {{size: [{}, 0.1], nodes: [{}, {}]}}}}", length, nodes, nodes / 2 + 1),
                            decay_time / 50, fmt::format("diffusivity: {}", diffusivity)),
                books);
    const Decay d = decay_of_cosine(run, length, -length / 2, 50);
    std::printf("lattice of %d: amplitude off by %.3g, worst node %.3g, %d sub-steps\n", nodes, d.amplitude, d.worst,
                run.substeps());
    const std::string what = fmt::format("cosine of saturation on a lattice of {} nodes: ", nodes);
    report({what + "amplitude after one e-fold, − 1", "e^(−Dπ²t/L²)", d.amplitude, 0.02});
    report({what + "worst node over the amplitude", "0", d.worst, 0.02});
    amplitude.push_back(d.amplitude);
    worst.push_back(d.worst);
  }
  books.print("cosine of saturation on lattices");
  for (const auto& [name, error] : {std::pair{"amplitude", amplitude}, std::pair{"worst node", worst}}) {
    const double order = std::log2(error[1] / error[2]);
    report({fmt::format("cosine of saturation on a lattice: 1.8 minus the order of the {} from 21 to 41 nodes", name),
            "order ≥ 1.8", 1.8 - order, 0});
  }
}

TEST(porous_diffusion, a_cosine_decays_on_an_irregular_mesh) {
  const TempFolder folder;
  Books books;
  for (const int nodes : {21, 41}) {
    write_text(folder.path() / "sheet.obj", irregular_sheet(nodes, nodes / 2 + 1, length, 0.1, 0.3).obj());
    Watched run(still_cloth(fmt::format("{{file: \"{}\"}}", (folder.path() / "sheet.obj").string()), decay_time / 50,
                            fmt::format("diffusivity: {}", diffusivity)),
                books);
    const Decay d = decay_of_cosine(run, length, 0, 50);
    std::printf("irregular, %d: amplitude off by %.3g, worst node %.3g, %d sub-steps\n", nodes, d.amplitude, d.worst,
                run.substeps());
    const std::string what = fmt::format("cosine of saturation on an irregular mesh, {} nodes along: ", nodes);
    report({what + "amplitude after one e-fold, − 1", "e^(−Dπ²t/L²)", d.amplitude, 0.02});
    report({what + "worst node over the amplitude", "0", d.worst, 0.02});
  }
  books.print("cosine of saturation on irregular meshes");
}

TEST(porous_diffusion, spreads_over_a_garment_as_finite_elements_say) {
  const TempFolder folder;
  const Patch mesh = sleeve(), fine = refined(refined(mesh));
  write_text(folder.path() / "sleeve.obj", mesh.obj());
  // Wet on one side and at one end, smoothly.
  const auto start = [](double x, double y) { return 0.5 + 0.25 * x / 0.08 + 0.2 * std::cos(pi * y / 0.3); };
  constexpr double time = 2.0;
  Eigen::VectorXd s(static_cast<Eigen::Index>(fine.x.size()));
  for (Eigen::Index n = 0; n < s.size(); ++n)
    s[n] = start(fine.x[static_cast<std::size_t>(n)][0], fine.x[static_cast<std::size_t>(n)][1]);
  const Eigen::VectorXd expected = finite_elements(fine, s, diffusivity, time, 200);
  Books books;
  Watched run(still_cloth(fmt::format("{{file: \"{}\"}}", (folder.path() / "sleeve.obj").string()), time / 100,
                          fmt::format("diffusivity: {}", diffusivity)),
              books);
  ASSERT_EQ(run.nodes(), mesh.x.size());
  run.start_from([&](const Vec3& x) { return start(x[0], x[1]); });
  run.steps(100);
  double low = 1e9, high = -1e9, worst = 0, squares = 0;
  for (std::size_t n = 0; n < run.nodes(); ++n) {
    const double e = expected[static_cast<Eigen::Index>(n)], off = run.saturation(n) - e;
    low = std::min(low, e);
    high = std::max(high, e);
    worst = std::max(worst, std::fabs(off));
    squares += off * off;
  }
  std::printf("sleeve: %zu nodes, saturation from %.3f to %.3f, %d sub-steps\n", run.nodes(), low, high,
              run.substeps());
  const std::string what = "saturation on a sleeve with an opening after 2 s: ";
  report({what + "rms error over the remaining range", "finite elements, 16 times the triangles",
          std::sqrt(squares / static_cast<double>(run.nodes())) / (high - low), 0.03});
  report({what + "worst node over the remaining range", "finite elements, 16 times the triangles", worst / (high - low),
          0.03});
  books.print("saturation on a sleeve with an opening");
}

namespace {

/// A strip of 0.3 m, four cells wide, that hangs in the plane x y with its hem at y = 0 held at `hem`.
std::string hanging_strip(const std::string& law, int cells, double hem, double height, double diffusivity_here,
                          double step) {
  return still_cloth(
      fmt::format("{{grid: {{size: [{}, 0.3], nodes: [5, {}]}}}}", 1.2 / cells, cells + 1), step,
      fmt::format("diffusivity: {}, capillary_height: {}, diffusion: {}", diffusivity_here, height, law),
      fmt::format("    place: {{position: [0, 0.15, 0], rotate: {{axis: [1, 0, 0], degrees: 90}}}}\n"
                  "    hold_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1.0e-4, 1]}}, value: {}}}]\n",
                  hem),
      "gravity: [0, -9.81, 0]");
}

}  // namespace

TEST(porous_diffusion, a_hanging_strip_wicks_up_to_the_capillary_height) {
  constexpr double height = 0.2;
  Books books;
  for (const std::string law : {"linear", "degenerate"})
    for (const double hem : {1.0, 0.6})
      for (const int cells : {30, 60})
        for (const bool full : {false, true}) {
          if (full + (cells > 30) + (hem < 1) > 1) continue;  // one change at a time
          Watched run(hanging_strip(law, cells, hem, height, 0.05, 0.02), books);
          if (full) run.start_from([](const Vec3&) { return 1.0; });
          run.steps(300);
          double worst = 0, highest = -1, top = 0;
          for (std::size_t n = 0; n < run.nodes(); ++n) {
            const double z = run.place(n)[1], expected = std::max(0.0, hem - z / height);
            worst = std::max(worst, std::fabs(run.saturation(n) - expected));
            // where the line through the highest wet node with the equilibrium's slope meets 0
            if (run.saturation(n) < 0.02 || z < highest) continue;
            highest = z;
            top = z + height * run.saturation(n);
          }
          std::printf("%s, hem %.1f, %d cells, %s: worst %.4f, top %.4f, %d sub-steps, supplied %.3g kg\n", law.c_str(),
                      hem, cells, full ? "full" : "dry", worst, top, run.substeps(), run.supplied());
          const std::string what = fmt::format("{} strip, {} cells of {:.0f} mm, hem at {}, from {}: ", law, cells,
                                               300.0 / cells, hem, full ? "full" : "dry");
          report({what + "worst error of saturation", "s_b − z/ℓ", worst, 0.02});
          report({what + "height where it reaches 0, − 1", "s_b ℓ", std::fabs(top / (hem * height) - 1), 0.02});
        }
  books.print("hanging strips");
}

TEST(porous_diffusion, holds_its_bounds_with_ten_times_the_diffusivity_at_20_ms) {
  const TempFolder folder;
  write_text(folder.path() / "sheet.obj", irregular_sheet(41, 21, length, 0.1, 0.3).obj());
  const std::string file = fmt::format("{{file: \"{}\"}}", (folder.path() / "sheet.obj").string());
  Books books;
  for (const std::string law : {"linear", "degenerate"}) {
    Watched strip(hanging_strip(law, 30, 1.0, 0.05, 0.5, 0.02), books);
    strip.steps(40);
    // A chequered start, full and dry, on the irregular mesh with gravity along it.
    Watched sheet(
        still_cloth(file, 0.02,
                    fmt::format("diffusivity: {}, capillary_height: 0.05, diffusion: {}", 10 * diffusivity, law), "",
                    "gravity: [9.81, 0, 0]"),
        books);
    sheet.start_from([](const Vec3& x) {
      return (static_cast<int>(x[0] / 0.02) + static_cast<int>(x[2] / 0.02)) % 2 ? 1.1799 : 0.0;
    });
    sheet.steps(40);
    std::printf("%s with 10 D: %d and %d sub-steps\n", law.c_str(), strip.substeps(), sheet.substeps());
  }
  books.print("strips and chequered irregular cloths with 10 D, ℓ/4 and Δt = 20 ms");
}

TEST(porous_diffusion, dry_cloth_wets_and_nothing_flows_up) {
  const TempFolder folder;
  write_text(folder.path() / "sheet.obj", irregular_sheet(21, 11, length, 0.1, 0.3).obj());
  const std::string grid = fmt::format("{{grid: {{size: [{}, 0.1], nodes: [21, 11]}}}}", length);
  const std::string file = fmt::format("{{file: \"{}\"}}", (folder.path() / "sheet.obj").string());
  constexpr double height = 0.1;
  Books books;
  double range = 0, risen = 0, gained = 0;
  for (const std::string& mesh : {grid, file})
    for (const std::string law : {"linear", "degenerate"}) {
      const double left = mesh == grid ? -length / 2 : 0;
      const auto half = [&](const Vec3& x) { return x[0] < left + length / 2 - 1e-6 ? 1.0 : 0.0; };
      const std::string porous =
          fmt::format("diffusivity: {}, diffusion: {}, capillary_height: {}", 4 * diffusivity, law, height);
      Watched still(still_cloth(mesh, 0.05, porous), books);
      still.start_from(half);
      still.steps(400);
      double low = 1e9, high = -1e9;
      for (std::size_t n = 0; n < still.nodes(); ++n) {
        low = std::min(low, still.saturation(n));
        high = std::max(high, still.saturation(n));
      }
      range = std::max(range, high - low);

      // The upper half wet: the liquid can only go down. The lower half wet: capillarity lifts it, but the free energy
      // Σ C (½ s² + s y/ℓ), y upwards, only falls.
      for (const bool upper : {true, false}) {
        const double up = upper ? -1 : 1;
        Watched fall(still_cloth(mesh, 0.05, porous, "", fmt::format("gravity: [{}, 0, 0]", -9.81 * up)), books);
        fall.start_from(half);
        double centre_before = 1e9, energy_before = 1e9;
        for (int n = 0; n < 200; ++n) {
          double centre = 0, energy = 0, mass = 0;
          for (std::size_t k = 0; k < fall.nodes(); ++k) {
            const double s = fall.saturation(k), y = up * fall.place(k)[0];
            mass += fall.capacity(k) * s;
            centre += fall.capacity(k) * s * y;
            energy += fall.capacity(k) * (0.5 * s * s + s * y / height);
          }
          if (upper) risen = std::max(risen, centre / mass - centre_before);
          gained = std::max(gained, energy / mass - energy_before);
          centre_before = centre / mass;
          energy_before = energy / mass;
          fall.steps(1);
        }
      }
    }
  // Lattice and irregular mesh, linear and degenerate; the bounds of the last two are the rounding of sums in double.
  report({"cloths with one wet half, no gravity: range of saturation after 20 s", "0", range, 1e-3});
  report({"cloths with the upper half wet: largest rise of the liquid's centre in a step", "0", risen, 1e-12, "m"});
  report(
      {"cloths with the upper or the lower half wet: largest rise of the free energy in a step", "0", gained, 1e-11});
  books.print("cloths with one wet half");
}

}  // namespace drench::test
