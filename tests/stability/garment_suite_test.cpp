// Garments and bodies as they come from other programs, from `drench new` to 100 steps.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "hard_scene.hpp"
#include "output/lost.hpp"
#include "paths.hpp"
#include "setup/first_scene.hpp"

namespace drench::test {
namespace {

/// A mesh with faces of any number of corners; `unit` metres, y or z up.
struct Faces {
  std::vector<Vec3> points;
  std::vector<std::vector<int>> faces;

  std::string write(const std::string& name, double unit = 1, bool z_up = false) const {
    const std::string path = ::testing::TempDir() + "drench_suite_" + name + ".obj";
    std::ofstream file(path);
    for (const Vec3& x : points)
      file << (z_up ? fmt::format("v {} {} {}\n", x[0] / unit, -x[2] / unit, x[1] / unit)
                    : fmt::format("v {} {} {}\n", x[0] / unit, x[1] / unit, x[2] / unit));
    for (const auto& face : faces) {
      file << "f";
      for (const int corner : face) file << ' ' << corner + 1;
      file << '\n';
    }
    return path;
  }
};

/// Half axes of the figure's ellipse at a height of 0 to 0.6 m: a chest, shoulders and a neck.
double radius_at(double height) {
  const double shoulders = 0.15 + 0.02 * std::sin(8 * height), t = std::clamp((height - 0.45) / 0.1, 0.0, 1.0);
  return shoulders + t * t * (3 - 2 * t) * (0.06 - shoulders);
}
Vec3 on_figure(double around, double height, double beyond) {
  const double angle = 2 * std::numbers::pi * around, r = radius_at(height) + beyond;
  return {1.15 * r * std::cos(angle), height, 0.8 * r * std::sin(angle)};
}

/// A closed figure, or one with an open neck; with `crossed` some of its faces are quads that cross themselves.
Faces figure(bool open = false, bool crossed = false) {
  constexpr int columns = 36, rows = 25;
  Faces f;
  for (int k = 0; k < rows; ++k)
    for (int i = 0; i < columns; ++i) f.points.push_back(on_figure(double(i) / columns, 0.6 * k / (rows - 1), 0));
  const auto at = [](int k, int i) { return k * columns + i % columns; };
  for (int k = 0; k + 1 < rows; ++k)
    for (int i = 0; i < columns; ++i) f.faces.push_back({at(k, i), at(k + 1, i), at(k + 1, i + 1), at(k, i + 1)});
  if (crossed)  // two corners of a quad at the hem change places, as at the toes of scanned bodies
    for (const int i : {4, 13, 27}) std::swap(f.points[at(0, i)], f.points[at(0, i + 1)]);
  const auto cap = [&](int row, double height, bool down) {
    const int center = int(f.points.size());
    f.points.push_back({0, height, 0});
    for (int i = 0; i < columns; ++i)
      f.faces.push_back(down ? std::vector<int>{center, at(row, i), at(row, i + 1)}
                             : std::vector<int>{center, at(row, i + 1), at(row, i)});
  };
  cap(0, 0, true);
  if (!open) cap(rows - 1, 0.6, false);
  return f;
}

/// A tube from the shoulders down, around the figure; of triangles, or of quads and hexagons.
Faces tunic(bool polygons = false, double flare = 0) {
  constexpr int columns = 40, rows = 25;
  Faces f;
  for (int k = 0; k < rows; ++k)
    for (int i = 0; i < columns; ++i) {
      const double height = 0.54 - 0.48 * k / (rows - 1);
      f.points.push_back(on_figure(double(i) / columns, height, 0.01 + flare * k * k / (rows * rows)));
    }
  const auto at = [](int k, int i) { return k * columns + i % columns; };
  for (int k = 0; k + 1 < rows; ++k)
    for (int i = 0; i < columns; ++i) {
      if (polygons && k % 2 == 0 && i % 2 == 0 && k + 1 < rows) {
        f.faces.push_back({at(k, i), at(k + 1, i), at(k + 1, i + 1), at(k + 1, i + 2), at(k, i + 2), at(k, i + 1)});
        ++i;
      } else if (polygons) {
        f.faces.push_back({at(k, i), at(k + 1, i), at(k + 1, i + 1), at(k, i + 1)});
      } else if ((i + k) % 2) {
        f.faces.push_back({at(k, i), at(k + 1, i), at(k, i + 1)});
        f.faces.push_back({at(k, i + 1), at(k + 1, i), at(k + 1, i + 1)});
      } else {
        f.faces.push_back({at(k, i), at(k + 1, i), at(k + 1, i + 1)});
        f.faces.push_back({at(k, i), at(k + 1, i + 1), at(k, i + 1)});
      }
    }
  return f;
}

/// The same as two panels whose seams have points of their own.
Faces panels(const Faces& whole) {
  Faces f;
  std::map<std::pair<int, int>, int> number;  // (panel, point)
  for (const auto& face : whole.faces) {
    double z = 0;
    for (const int corner : face) z += whole.points[corner][2];
    const int panel = z > 0;
    std::vector<int> own;
    for (const int corner : face) {
      const auto [at, fresh] = number.try_emplace({panel, corner}, int(f.points.size()));
      if (fresh) f.points.push_back(whole.points[corner]);
      own.push_back(at->second);
    }
    f.faces.push_back(own);
  }
  return f;
}

/// Some points 20 µm beside a neighbour.
Faces with_slivers(Faces f) {
  for (std::size_t n = 205; n + 45 < f.points.size(); n += 97) {
    const Vec3 next = f.points[n + 1];
    for (std::size_t a = 0; a < 3; ++a) f.points[n][a] = next[a] + 1e-3 * (f.points[n][a] - next[a]);
  }
  return f;
}

/// A first scene of these files, run for 100 steps: it converges, does not tear, and nothing ends inside the body.
void expect_to_run(const std::string& garment, const std::string& body, Index nodes) {
  const FirstScene first = first_scene({.mesh = garment, .body = body});
  SceneRun run(first.yaml);
  EXPECT_EQ(run.initial().node_count(), nodes);
  int unconverged = 0;
  double stretch = 0;
  for (int k = 0; k < 100; ++k) {
    const StepReport report = run.step();
    unconverged += !report.cloth_converged;
    stretch = std::max(stretch, report.cloth_stretch);
  }
  fmt::print("  {} nodes to {:.3g} s: {} steps not converged, stretch {:.3g}\n", nodes, run.time(), unconverged,
             stretch);
  EXPECT_LE(unconverged, 1);
  EXPECT_LT(stretch, 1.5);
  EXPECT_EQ(describe_nodes_inside(run.model(), run.state()), "");
}

}  // namespace

TEST(garment_suite, panels_with_doubled_seams_on_a_closed_body) {
  expect_to_run(panels(tunic()).write("panels"), figure().write("figure"), 1000);
}
TEST(garment_suite, centimetres_and_z_up) {
  expect_to_run(tunic().write("tunic_cm", 0.01, true), figure().write("figure_cm", 0.01, true), 1000);
}
TEST(garment_suite, polygons_on_a_body_with_an_open_neck) {
  expect_to_run(tunic(true).write("polygons"), figure(true).write("open"), 1000);
}
TEST(garment_suite, slivers_on_a_body_with_crossed_faces) {
  expect_to_run(with_slivers(tunic()).write("slivers"), figure(false, true).write("crossed"),
                992);  // eight are removed
}
TEST(garment_suite, a_dress_that_hangs) { expect_to_run(tunic(false, 0.1).write("dress"), "", 1000); }

}  // namespace drench::test
