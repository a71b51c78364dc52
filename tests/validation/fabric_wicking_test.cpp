// How liquid spreads in fabric whose diffusivity grows with the saturation, or differs between warp and weft: against
// the exact solutions of Barenblatt and of the heat equation, Kissa's law of stains, and finite elements.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "app/run_program.hpp"
#include "patches.hpp"
#include "watched_cloth.hpp"

namespace drench::test {
namespace {

constexpr double pi = std::numbers::pi;

/// s = s_0 (1 − r²/R²)^{1/n} with R ~ t^{1/(dn + 2)}: the solution of ∂s/∂t = D ∇·(sⁿ ∇s) that starts from a point
/// (Barenblatt 1952), from where its radius and its saturation at the centre are as given.
struct Barenblatt {
  double n;
  int dimensions;
  double diffusivity, radius, centre;
  double retention = 1;  // β: with D/β and the exponent n + 1 − β the same equation holds
  std::string keys() const {
    return fmt::format("diffusivity: {}, diffusion_exponent: {}, retention_exponent: {}, max_saturation: 1",
                       diffusivity / retention, n + 1 - retention, retention);
  }
  /// s, from the point to the start.
  double age() const { return n * radius * radius / (2 * (dimensions * n + 2) * diffusivity * std::pow(centre, n)); }
  double radius_after(double time) const { return radius * std::pow(1 + time / age(), 1 / (dimensions * n + 2)); }
  double time_of_growth(double factor) const { return age() * (std::pow(factor, dimensions * n + 2) - 1); }
  /// At a distance, once it has the radius `now`.
  double saturation(double distance, double now) const {
    const double inside = 1 - distance * distance / (now * now);
    return inside > 0 ? centre * std::pow(radius / now, dimensions) * std::pow(inside, 1 / n) : 0;
  }
  /// ⟨r²⟩ over R².
  double second_moment() const { return dimensions / (dimensions + 2 + 2 / n); }
};

/// The mean of f over a node's cell, a rectangle h by w about it, cut at the sheet's left and lower ends. w = 0: along
/// a line.
template <class F>
double mean_in_cell(double x, double z, double h, double w, F f) {
  const int parts = w > 0 ? 60 : 600;
  const double left = std::max(0.0, x - h / 2), below = std::max(0.0, z - w / 2);
  const int across = w > 0 ? parts : 1;
  double sum = 0;
  for (int i = 0; i < parts; ++i)
    for (int j = 0; j < across; ++j)
      sum += f(
          std::hypot(left + (i + 0.5) / parts * (x + h / 2 - left), below + (j + 0.5) / across * (z + w / 2 - below)));
  return sum / (parts * across);
}

struct Spread {
  double first_radius = 0, last_radius = 0;               // m: from the second moment
  double radius = 0, centre = 0, inner = 0, profile = 0;  // errors, 1
  int substeps = 0;
};

/// A half line or a quarter of a plane from its centre on, `cells` to the first radius, until the radius has grown by
/// `growth`.
Spread spread(const Barenblatt& exact, int cells, double growth, Books& books) {
  const double h = exact.radius / cells, time = exact.time_of_growth(growth);
  const int along = static_cast<int>(std::ceil(cells * growth * 1.1)) + 2;
  const bool plane = exact.dimensions == 2;
  const int steps = std::max(40, static_cast<int>(std::ceil(time)));
  const std::string grid = fmt::format("{{grid: {{size: [{}, {}], nodes: [{}, {}]}}}}", along * h,
                                       plane ? along * h : h, along + 1, plane ? along + 1 : 2);
  Watched run(still_cloth(grid, time / steps, exact.keys()), books);
  const double corner = -along * h / 2;
  const auto distance = [&](std::size_t k) {
    return std::hypot(run.place(k)[0] - corner, plane ? run.place(k)[2] - corner : 0);
  };
  const auto expected = [&](const Vec3& x, double now) {
    return mean_in_cell(x[0] - corner, plane ? x[2] - corner : 0, h, plane ? h : 0,
                        [&](double r) { return exact.saturation(r, now); });
  };
  const auto radius = [&] {
    double mass = 0, moment = 0;
    for (std::size_t k = 0; k < run.nodes(); ++k) {
      mass += run.capacity(k) * run.saturation(k);
      moment += run.capacity(k) * run.saturation(k) * std::pow(distance(k), 2);
    }
    return std::sqrt(moment / mass / exact.second_moment());
  };
  run.start_from([&](const Vec3& x) { return expected(x, exact.radius); });
  Spread result{.first_radius = exact.radius};
  run.steps(steps);
  const double now = exact.radius_after(time);
  result.last_radius = radius();
  result.substeps = run.substeps();
  result.radius = std::fabs(result.last_radius / now - 1);
  double off = 0, mass = 0, squares = 0, inside = 0;
  for (std::size_t k = 0; k < run.nodes(); ++k) {
    const double e = expected(run.place(k), now);
    off += run.capacity(k) * std::fabs(run.saturation(k) - e);
    mass += run.capacity(k) * e;
    if (distance(k) < 1e-9) result.centre = std::fabs(run.saturation(k) / e - 1);
    if (distance(k) > 0.8 * now) continue;
    squares += run.capacity(k) * std::pow(run.saturation(k) / e - 1, 2);
    inside += run.capacity(k);
  }
  result.inner = std::sqrt(squares / inside);
  result.profile = off / mass;
  return result;
}

}  // namespace

TEST(fabric_wicking, drops_spread_as_barenblatt_says) {
  Books books;
  for (const int dimensions : {1, 2})
    for (const double n : {0.5, 1.0, 2.0, 3.0}) {
      if (dimensions == 2 && n < 1) continue;
      const Barenblatt exact{n, dimensions, 1e-4, 0.02, 0.9};
      const double growth = dimensions == 1 ? 1.8 : 1.5;
      const std::vector<int> cells = dimensions == 1 ? std::vector{8, 16, 32, 64} : std::vector{6, 12, 24};
      std::vector<Spread> runs;
      for (const int c : cells) {
        runs.push_back(spread(exact, c, growth, books));
        const Spread& r = runs.back();
        std::printf(
            "n %g in %d dimensions, %d cells: radius %.3g, centre %.3g, inner %.3g, profile %.3g, %d sub-steps\n", n,
            dimensions, c, r.radius, r.centre, r.inner, r.profile, r.substeps);
      }
      const Spread &first = runs.front(), &last = runs.back();
      const std::string what =
          fmt::format("drop that spreads {} with D sⁿ, n = {:g}: ", dimensions == 1 ? "along a line" : "in a plane", n);
      const auto order = [&](double Spread::*error) {
        return std::log2(first.*error / (last.*error)) / static_cast<double>(runs.size() - 1);
      };
      report({what + fmt::format("radius after growing by {:g}, − 1", growth), "Barenblatt", last.radius, 0.002});
      report({what + "saturation at the centre, − 1", "Barenblatt", last.centre, 0.002});
      report({what + "profile, mean error over the mean", "Barenblatt", last.profile, 0.005});
      report({what + "1.8 minus the order of the radius", "order ≥ 1.8", 1.8 - order(&Spread::radius), 0});
      report(
          {what + "1.8 minus the order of the rms error within 0.8 R", "order ≥ 1.8", 1.8 - order(&Spread::inner), 0});
      const double exponent =
          std::log(last.last_radius / last.first_radius) / std::log(1 + exact.time_of_growth(growth) / exact.age());
      report({what + "exponent of the radius in time, error", fmt::format("1/{:g}", dimensions * n + 2),
              std::fabs(exponent - 1 / (dimensions * n + 2)), 0.02});
    }
  books.print("drops that spread with D sⁿ");
}

// Without gravity a curve of retention is another exponent: ∂s/∂t = ∇·(D sⁿ ∇sᵝ).
TEST(fabric_wicking, drops_spread_by_their_curve_of_retention) {
  Books books;
  for (const double beta : {0.5, 2.5}) {
    const Barenblatt exact{2, 1, 1e-4, 0.02, 0.9, beta};
    const Spread r = spread(exact, 64, 1.8, books);
    const std::string what = fmt::format("drop that spreads along a line with D sⁿ ∇sᵝ, n + β = 3, β = {:g}: ", beta);
    report({what + "radius after growing by 1.8, − 1", "Barenblatt", r.radius, 0.002});
    report({what + "profile, mean error over the mean", "Barenblatt", r.profile, 0.005});
  }
  books.print("drops that spread by their retention curve");
}

namespace {

/// The area of the stain of a full patch of this radius in the plane, m², after each of the steps `at`: where the
/// saturation is above a quarter of its middle's. That is a fixed part of all that is wet, and no front smeared over a
/// cell counts.
std::vector<double> wet_areas(double patch, double h, double reach, double time, int steps, const std::vector<int>& at,
                              Books& books) {
  const int along = static_cast<int>(std::ceil(reach / h));
  Watched run(still_cloth(fmt::format("{{grid: {{size: [{}, {}], nodes: [{}, {}]}}}}", along * h, along * h, along + 1,
                                      along + 1),
                          time / steps, "diffusivity: 1.0e-4, diffusion_exponent: 2, max_saturation: 1"),
              books);
  const double corner = -along * h / 2;
  run.start_from([&](const Vec3& x) {
    return mean_in_cell(x[0] - corner, x[2] - corner, h, h, [&](double r) { return r < patch ? 1.0 : 0.0; });
  });
  const double load = 0.6;  // kg/m² at saturation 1, of the default fabric
  std::vector<double> areas;
  int done = 0;
  for (const int step : at) {
    run.steps(step - done);
    done = step;
    double area = 0, most = 0;
    for (std::size_t k = 0; k < run.nodes(); ++k) most = std::max(most, run.saturation(k));
    for (std::size_t k = 0; k < run.nodes(); ++k)
      if (run.saturation(k) > most / 4) area += run.capacity(k) / load;
    areas.push_back(4 * area);
  }
  return areas;
}

}  // namespace

TEST(fabric_wicking, stains_grow_as_kissa_measured) {
  constexpr double small = 0.01, h = 0.0016, time = 48;
  Books books;
  const auto a = wet_areas(small, h, 0.045, time, 64, {8, 16, 32, 64}, books);
  const auto b = wet_areas(1.4 * small, h, 0.057, time, 64, {64}, books);
  const double in_time = std::log(a[3] / a[0]) / std::log(8.0), in_volume = std::log(b[0] / a[3]) / std::log(1.4 * 1.4);
  std::printf("stains: %.2f to %.2f of the patch, exponents %.4f and %.4f\n", a[0] / (pi * small * small),
              a[3] / (pi * small * small), in_time, in_volume);
  report({"stain of a full patch with D s²: exponent of its area in time, error", "Kissa 1981: 1/3",
          std::fabs(in_time - 1.0 / 3), 0.02});
  report({"stain of a full patch with D s²: exponent of its area in the volume, error", "Kissa 1981: 2/3",
          std::fabs(in_volume - 2.0 / 3), 0.02});
  books.print("stains of full patches");
}

namespace {

/// A mesh in Wavefront's format whose texture runs along `warp` of each triangle, with corners of their own.
template <class Warp>
std::string textured(const Patch& mesh, Warp warp) {
  std::string text, faces;
  for (const auto& p : mesh.x) text += fmt::format("v {:.12f} {:.12f} {:.12f}\n", p[0], p[1], p[2]);
  for (std::size_t t = 0; t < mesh.t.size(); ++t) {
    const auto at = [&](std::size_t k) { return mesh.x[static_cast<std::size_t>(mesh.t[t][k])]; };
    const Eigen::Vector3d along = warp(t), across = (at(1) - at(0)).cross(at(2) - at(0)).normalized().cross(along);
    faces += "f";
    for (std::size_t k = 0; k < 3; ++k) {
      text += fmt::format("vt {:.12f} {:.12f}\n", at(k).dot(across), at(k).dot(along));
      faces += fmt::format(" {}/{}", mesh.t[t][k] + 1, 3 * t + k + 1);
    }
    faces += "\n";
  }
  return text + faces;
}

/// Files with texture coordinates have their points in another order.
double square_of_distance(const Vec3& a, const Vec3& b) {
  return std::pow(a[0] - b[0], 2) + std::pow(a[1] - b[1], 2) + std::pow(a[2] - b[2], 2);
}

/// Two half axes and the direction of the longer one.
struct Ellipse {
  double longer, shorter, degrees;
};

/// Root mean squares of the liquid's distance from `centre` along its principal axes in the plane x z.
Ellipse ellipse_of(const Watched& run, const Eigen::Vector2d& centre) {
  Eigen::Matrix2d moment = Eigen::Matrix2d::Zero();
  double mass = 0;
  for (std::size_t k = 0; k < run.nodes(); ++k) {
    const Eigen::Vector2d r = Eigen::Vector2d(run.place(k)[0], run.place(k)[2]) - centre;
    moment += run.capacity(k) * run.saturation(k) * r * r.transpose();
    mass += run.capacity(k) * run.saturation(k);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(moment / mass);
  const Eigen::Vector2d along = axes.eigenvectors().col(1);
  return {std::sqrt(axes.eigenvalues()[1]), std::sqrt(axes.eigenvalues()[0]),
          std::atan(along[1] / along[0]) * 180 / pi};
}

}  // namespace

TEST(fabric_wicking, a_drop_on_a_weave_wets_an_ellipse) {
  // The mesh is turned by 20° about y, which takes x away from z; the warp lies 50° from x towards z in it: 30° in
  // space.
  constexpr double side = 0.4, degrees = 30, along_warp = 4e-4, along_weft = 1e-4;
  const TempFolder folder;
  const Patch mesh = irregular_sheet(81, 81, side, side, 0.3);
  const Eigen::Vector3d in_mesh(std::cos(50 * pi / 180), 0, std::sin(50 * pi / 180));
  write_text(folder.path() / "plain.obj", mesh.obj());
  write_text(folder.path() / "textured.obj", textured(mesh, [&](std::size_t) { return in_mesh; }));
  const Eigen::Vector2d u(std::cos(degrees * pi / 180), std::sin(degrees * pi / 180)), t(-u[1], u[0]);
  const double turn = 20 * pi / 180;
  const Eigen::Vector2d centre(side / 2 * (std::cos(turn) + std::sin(turn)),
                               side / 2 * (std::cos(turn) - std::sin(turn)));
  Books books;
  double above = 0, apart = 0;
  std::vector<std::pair<Vec3, double>> plain;  // position, saturation
  const std::vector<std::pair<const char*, double>> cases = {{"plain", 0}, {"textured", 0}, {"plain", 1}, {"plain", 2}};
  for (const auto& [file, n] : cases) {
    const bool uses_texture = std::string(file) == "textured";
    const Barenblatt exact{std::max(n, 1.0), 2, std::sqrt(along_warp * along_weft), 0.045, 0.9};
    const double sigma = 0.015, time = n == 0 ? 1.6 : exact.time_of_growth(1.8), stretch = std::sqrt(2.0);
    const int steps = std::max(40, static_cast<int>(std::ceil(time)));
    Watched run(
        still_cloth(fmt::format("{{file: \"{}\"}}", (folder.path() / file).string() + ".obj"), time / steps,
                    fmt::format("diffusivity: {}, weft_diffusivity: {}, diffusion_exponent: {}, max_saturation: 1",
                                along_warp, along_weft, n),
                    "    place: {rotate: {axis: [0, 1, 0], degrees: 20}}\n" +
                        (uses_texture ? "" : fmt::format("    warp: [{}, 0, {}]\n", in_mesh[0], in_mesh[2]))),
        books);
    double most = 0;
    run.start_from([&](const Vec3& x) {
      const Eigen::Vector2d r = Eigen::Vector2d(x[0], x[2]) - centre;
      const double s = n == 0 ? 0.9 * std::exp(-r.squaredNorm() / (2 * sigma * sigma))
                              : exact.saturation(std::hypot(r.dot(u) / stretch, r.dot(t) * stretch), exact.radius);
      most = std::max(most, s);
      return s;
    });
    run.steps(steps);
    const double now = exact.radius_after(time) * std::sqrt(exact.second_moment() / 2);
    const Ellipse found = ellipse_of(run, centre),
                  expected = n == 0 ? Ellipse{std::sqrt(sigma * sigma + 2 * along_warp * time),
                                              std::sqrt(sigma * sigma + 2 * along_weft * time), degrees}
                                    : Ellipse{now * stretch, now / stretch, degrees};
    for (std::size_t k = 0; k < run.nodes(); ++k) {
      above = std::max(above, run.saturation(k) - most);
      if (n == 0 && !uses_texture) plain.emplace_back(run.place(k), run.saturation(k));
      if (!uses_texture) continue;
      const auto same = std::min_element(plain.begin(), plain.end(), [&](const auto& p, const auto& q) {
        return square_of_distance(p.first, run.place(k)) < square_of_distance(q.first, run.place(k));
      });
      apart = std::max(apart, std::fabs(run.saturation(k) - same->second));
    }
    std::printf("ellipse, n %g, %s: %.5f and %.5f m at %.3f°, expected %.5f and %.5f, %d sub-steps\n", n, file,
                found.longer, found.shorter, found.degrees, expected.longer, expected.shorter, run.substeps());
    if (uses_texture) continue;
    const std::string what = fmt::format("drop on a weave, D_warp = 4 D_weft, n = {:g}, irregular turned mesh: ", n);
    report({what + "half axis along the warp, − 1", n == 0 ? "√(σ² + 2 D t)" : "Barenblatt, stretched",
            std::fabs(found.longer / expected.longer - 1), 0.02});
    report({what + "half axis along the weft, − 1", n == 0 ? "√(σ² + 2 D t)" : "Barenblatt, stretched",
            std::fabs(found.shorter / expected.shorter - 1), 0.02});
    report({what + "angle, error", "the warp's", std::fabs(found.degrees - degrees), 1, "degrees"});
  }
  report({"drop on a weave: saturation above the highest at the start", "0", above, 0});
  report({"drop on a weave: warp by texture coordinates against the key `warp`, largest difference", "0", apart, 1e-6});
  books.print("drops on a weave");
}

namespace {

/// ∂s/∂t = ∇·(D ∇s) by linear finite elements with a tensor for each triangle, consistent masses and Crank–Nicolson.
template <class Tensor>
Eigen::VectorXd finite_elements(const Patch& mesh, Eigen::VectorXd s, Tensor tensor, double time, int steps) {
  std::vector<Eigen::Triplet<double>> mass, stiffness;
  for (std::size_t t = 0; t < mesh.t.size(); ++t) {
    const auto x = [&](std::size_t k) { return mesh.x[static_cast<std::size_t>(mesh.t[t][k % 3])]; };
    const Eigen::Vector3d doubled = (x(1) - x(0)).cross(x(2) - x(0)), normal = doubled.normalized();
    const double area = doubled.norm() / 2;
    const Eigen::Matrix3d D = tensor(t);
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t l = 0; l < 3; ++l) {
        const Eigen::Vector3d a = normal.cross(x(k + 2) - x(k + 1)) / (2 * area),
                              b = normal.cross(x(l + 2) - x(l + 1)) / (2 * area);
        stiffness.emplace_back(mesh.t[t][k], mesh.t[t][l], area * a.dot(D * b));
        mass.emplace_back(mesh.t[t][k], mesh.t[t][l], k == l ? area / 6 : area / 12);
      }
  }
  const auto n = static_cast<Eigen::Index>(mesh.x.size());
  Eigen::SparseMatrix<double> M(n, n), K(n, n);
  M.setFromTriplets(mass.begin(), mass.end());
  K.setFromTriplets(stiffness.begin(), stiffness.end());
  const double dt = time / steps;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> left(M + 0.5 * dt * K);
  const Eigen::SparseMatrix<double> right = M - 0.5 * dt * K;
  for (int k = 0; k < steps; ++k) s = left.solve(right * s);
  return s;
}

/// A run against finite elements on sixteen times its triangles. `start` takes a position, `warp` the number of a
/// triangle.
template <class Start, class Warp>
void compare_with_finite_elements(const std::string& name, const Patch& mesh, const std::string& scene, double time,
                                  double along_warp, double along_weft, Start start, Warp warp, Books& books) {
  const Patch fine = refined(refined(mesh));
  Eigen::VectorXd s(static_cast<Eigen::Index>(fine.x.size()));
  for (Eigen::Index n = 0; n < s.size(); ++n) {
    const Eigen::Vector3d& x = fine.x[static_cast<std::size_t>(n)];
    s[n] = start(Vec3{x[0], x[1], x[2]});
  }
  const Eigen::VectorXd expected = finite_elements(
      fine, s,
      [&](std::size_t t) {
        const auto x = [&](std::size_t k) { return fine.x[static_cast<std::size_t>(fine.t[t][k])]; };
        const Eigen::Vector3d u = warp(t / 16), n = (x(1) - x(0)).cross(x(2) - x(0)).normalized();
        const Eigen::Vector3d w = (u - u.dot(n) * n).normalized(), f = n.cross(w);
        return Eigen::Matrix3d(along_warp * w * w.transpose() + along_weft * f * f.transpose());
      },
      time, 200);
  Watched run(scene, books);
  ASSERT_EQ(run.nodes(), mesh.x.size());
  run.start_from(start);
  run.steps(100);
  double low = 1e9, high = -1e9, worst = 0, squares = 0;
  for (std::size_t n = 0; n < run.nodes(); ++n) {
    const auto same = std::min_element(mesh.x.begin(), mesh.x.end(), [&](const auto& p, const auto& q) {
      return square_of_distance({p[0], p[1], p[2]}, run.place(n)) <
             square_of_distance({q[0], q[1], q[2]}, run.place(n));
    });
    const double e = expected[same - mesh.x.begin()], off = run.saturation(n) - e;
    low = std::min(low, e);
    high = std::max(high, e);
    worst = std::max(worst, std::fabs(off));
    squares += off * off;
  }
  std::printf("%s: %zu nodes, saturation from %.3f to %.3f, %d sub-steps\n", name.c_str(), run.nodes(), low, high,
              run.substeps());
  report({name + ": rms error over the remaining range", "finite elements, 16 times the triangles",
          std::sqrt(squares / static_cast<double>(run.nodes())) / (high - low), 0.03});
  report({name + ": worst node over the remaining range", "finite elements, 16 times the triangles",
          worst / (high - low), 0.03});
}

}  // namespace

TEST(fabric_wicking, spreads_over_garments_as_finite_elements_say) {
  const TempFolder folder;
  Books books;
  constexpr double along_warp = 2e-3, along_weft = 5e-4, time = 1;
  const auto scene = [&](const char* file, const std::string& more) {
    return still_cloth(fmt::format("{{file: \"{}\"}}", (folder.path() / file).string()), time / 100,
                       fmt::format("diffusivity: {}, weft_diffusivity: {}", along_warp, along_weft), more);
  };
  // A sleeve whose warp winds around it: the direction bends from triangle to triangle.
  const Patch tube = sleeve();
  const Eigen::Vector3d winding(0.5, 1, 0.3);
  write_text(folder.path() / "sleeve.obj", tube.obj());
  compare_with_finite_elements(
      "saturation on a sleeve, D_warp = 4 D_weft, oblique warp, after 1 s", tube,
      scene("sleeve.obj", "    warp: [0.5, 1, 0.3]\n"), time, along_warp, along_weft,
      [](const Vec3& x) { return 0.5 + 0.25 * x[0] / 0.08 + 0.2 * std::cos(pi * x[1] / 0.3); },
      [&](std::size_t) { return winding; }, books);
  // Two pieces of cloth sewn together, their warps 60° apart.
  const Patch sheet = irregular_sheet(41, 21, 0.2, 0.1, 0.3);
  const auto warp = [&](std::size_t t) {
    const bool left = (t / 2) % 40 < 20;  // two triangles a cell, 40 cells in a row
    const double angle = (left ? 10 : 70) * pi / 180;
    return Eigen::Vector3d(std::cos(angle), 0, std::sin(angle));
  };
  write_text(folder.path() / "sewn.obj", textured(sheet, warp));
  compare_with_finite_elements(
      "saturation on two pieces, their warps 60° apart, after 1 s", sheet, scene("sewn.obj", ""), time, along_warp,
      along_weft,
      [](const Vec3& x) { return 0.5 + 0.25 * std::cos(pi * x[0] / 0.2) + 0.2 * std::cos(pi * x[2] / 0.1); }, warp,
      books);
  books.print("saturation on garments with warp and weft");
}

}  // namespace drench::test
