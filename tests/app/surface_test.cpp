// The liquid's surface: closed, where the liquid is, and in the run's files.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <random>

#include "frame_reader.hpp"
#include "output/liquid_field.hpp"
#include "output/liquid_surface.hpp"
#include "output/vtu_series.hpp"
#include "run_program.hpp"
#include "setup/body_geometry.hpp"
#include "setup/surface_mesh.hpp"

namespace drench::test {
namespace {

constexpr double d = 0.01;  // m, spacing
constexpr SurfaceKernel both[] = {SurfaceKernel::isotropic, SurfaceKernel::anisotropic};

struct Liquid {
  Model model;
  HostState state;
  explicit Liquid(SurfaceKernel kernel = OutputScene{}.surface_kernel) {
    model.scene.output.surface_kernel = kernel;
    model.scene.fluid.present = true;
    model.scene.output.surface = true;
    model.spacing = d;
    model.rest_density = 1000;
    model.particle_mass = 1000 * d * d * d;
    model.quantum = model.particle_mass / static_cast<double>(quanta_per_particle);
  }
  void add(const Vec3& x, double full = 1) {
    state.fluid_position.push_back(x);
    state.fluid_velocity.push_back({1, 2, 3});
    state.fluid_mass.push_back(static_cast<Quanta>(full * static_cast<double>(quanta_per_particle)));
    state.fluid_id.push_back(state.next_id++);
  }
  /// The particles of a lattice whose place in it is `inside`, each moved by up to `disorder` d along each axis.
  template <class Inside>
  void fill(const Vec3& min, const Vec3& max, double disorder, Inside&& inside) {
    std::mt19937 random(7);
    const auto shift = [&] { return disorder * d * (2 * static_cast<double>(random()) / 4294967295.0 - 1); };
    for (double z = min[2] + d / 2; z < max[2]; z += d)
      for (double y = min[1] + d / 2; y < max[1]; y += d)
        for (double x = min[0] + d / 2; x < max[0]; x += d)
          if (inside(Vec3{x, y, z})) add({x + shift(), y + shift(), z + shift()});
  }
  void add_ball(const Vec3& c, double radius, double disorder) {
    const auto at = [&](double s) { return Vec3{c[0] + s * radius, c[1] + s * radius, c[2] + s * radius}; };
    fill(at(-1), at(1), disorder,
         [&](const Vec3& x) { return std::hypot(x[0] - c[0], x[1] - c[1], x[2] - c[2]) < radius; });
  }
  /// A sheet of 80 spacings' side at this height.
  void lay_sheet(double height) {
    const double side = 40 * d;
    model.cloths.emplace_back().name = "sheet";
    model.mesh.triangle = {{0, 2, 1}, {0, 3, 2}};
    model.mesh.rest_position = {
        {-side, height, -side}, {side, height, -side}, {side, height, side}, {-side, height, side}};
    state.node_position = model.mesh.rest_position;
  }
  double volume() const {  // m³
    const double quanta =
        static_cast<double>(std::accumulate(state.fluid_mass.begin(), state.fluid_mass.end(), Quanta{0}));
    return quanta * model.quantum / model.rest_density;
  }
};

struct Shape {
  SurfaceMesh mesh;
  double volume = 0, area = 0;  // m³, m²
  int parts = 0;
  bool closed = false;  // and every edge has its two triangles turned the same way
};

Shape shape_of(const Grid& grid) {
  Shape s;
  std::map<std::pair<Index, Index>, int> sides;
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) {
    s.mesh.points.emplace_back();
    grid->GetPoint(i, s.mesh.points.back().data());
  }
  std::vector<std::size_t> part(s.mesh.points.size());
  std::iota(part.begin(), part.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (part[i] != i) i = part[i] = part[part[i]];
    return i;
  };
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    vtkIdType size = 0;
    const vtkIdType* p = nullptr;
    grid->GetCellPoints(c, size, p);
    if (size != 3) throw std::runtime_error("not a triangle");
    s.mesh.triangles.push_back({static_cast<Index>(p[0]), static_cast<Index>(p[1]), static_cast<Index>(p[2])});
    const auto& t = s.mesh.triangles.back();
    const auto x = [&](std::size_t k) { return s.mesh.points[static_cast<std::size_t>(t[k])]; };
    const Vec3 a = x(0), b = x(1), e = x(2);
    s.volume +=
        (a[0] * (b[1] * e[2] - b[2] * e[1]) + a[1] * (b[2] * e[0] - b[0] * e[2]) + a[2] * (b[0] * e[1] - b[1] * e[0])) /
        6;
    s.area += triangle_area(a, b, e);
    for (std::size_t k = 0; k < 3; ++k) {
      ++sides[{t[k], t[(k + 1) % 3]}];
      part[root(static_cast<std::size_t>(t[k]))] = root(static_cast<std::size_t>(t[0]));
    }
  }
  s.closed = !sides.empty();
  for (const auto& [side, count] : sides) {
    const auto other = sides.find({side.second, side.first});
    s.closed = s.closed && count == 1 && other != sides.end() && other->second == 1;
  }
  for (std::size_t i = 0; i < part.size(); ++i) s.parts += root(i) == i;
  return s;
}

TEST(Surface, OfABallIsClosedWithItsVolumeAndArea) {
  for (int k = 0; k < 4; ++k) {
    const double disorder = k / 2 == 0 ? 0 : 0.15;
    Liquid liquid(both[k % 2]);
    liquid.add_ball({0.3, -0.2, 0.1}, 10 * d, disorder);  // of 4 to 5 blocks along each axis
    const Shape s = shape_of(surface_grid(liquid.model, liquid.state));
    EXPECT_TRUE(s.closed);
    EXPECT_EQ(s.parts, 1);
    EXPECT_NEAR(s.volume / liquid.volume(), 1, 0.05);
    const double radius = std::cbrt(liquid.volume() * 3 / (4 * std::numbers::pi));
    EXPECT_NEAR(s.area / (4 * std::numbers::pi * radius * radius), 1, 0.05);
  }
}

TEST(Surface, NormalsPointOutwardAndVelocitiesAreTheLiquids) {
  Liquid liquid;
  liquid.add_ball({0, 0, 0}, 6 * d, 0);
  const Grid grid = surface_grid(liquid.model, liquid.state);
  ASSERT_GT(grid->GetNumberOfPoints(), 500);
  EXPECT_EQ(grid->GetPointData()->GetNormals(), grid->GetPointData()->GetArray("normal"));
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) {
    const double* x = grid->GetPoint(i);
    double along = 0;
    for (int k = 0; k < 3; ++k) {
      along += field(grid, "normal", i, k) * x[k] / std::hypot(x[0], x[1], x[2]);
      EXPECT_NEAR(field(grid, "velocity", i, k), 1 + k, 1e-5);
    }
    EXPECT_GT(along, 0.8) << "point " << i;
  }
}

TEST(Surface, DropsFarApartAreSeparateAndTheSpaceBetweenCostsNothing) {
  Liquid liquid;
  liquid.add_ball({0, 0, 0}, 4 * d, 0.1);
  const double one = liquid.volume();
  liquid.add_ball({2000, 30, -400}, 4 * d, 0.1);
  const Shape s = shape_of(surface_grid(liquid.model, liquid.state));
  EXPECT_TRUE(s.closed);
  EXPECT_EQ(s.parts, 2);
  int blocks = 0;
  LiquidField(liquid.model, liquid.state, 0.5 * d).for_blocks([&](const LiquidField::Block&) { ++blocks; });
  EXPECT_LE(blocks, 2 * 27);

  Liquid near;  // a spacing and a half of air between them
  near.add_ball({0, 0, 0}, 4 * d, 0);
  near.add_ball({10 * d, 0, 0}, 4 * d, 0);
  const Shape two = shape_of(surface_grid(near.model, near.state));
  EXPECT_EQ(two.parts, 2) << "no sheet between them";
  EXPECT_NEAR(two.volume / (2 * one), 1, 0.05);
}

TEST(Surface, OfAPoolIsLevelAndWithinItsWalls) {
  for (int k = 0; k < 4; ++k) {
    const double disorder = k / 2 == 0 ? 0 : 0.1;
    Liquid liquid(both[k % 2]);
    Body tank;
    tank.box = {{0, 0, 0}, {24 * d, 20 * d, 24 * d}};
    tank.inside = true;
    tank.center = {12 * d, 10 * d, 12 * d};
    liquid.model.bodies = {tank};
    start_bodies(liquid.model, liquid.state);
    liquid.fill({0, 0, 0}, {24 * d, 6 * d, 24 * d}, disorder, [](const Vec3&) { return true; });
    const Shape s = shape_of(surface_grid(liquid.model, liquid.state));
    EXPECT_TRUE(s.closed);
    int seen = 0;
    for (const Vec3& x : s.mesh.points) {
      for (const std::size_t a : {0U, 2U}) EXPECT_TRUE(x[a] > 0 && x[a] < 24 * d) << x[a] / d;
      EXPECT_GT(x[1], 0);
      if (x[1] < 4 * d || x[0] < 4 * d || x[0] > 20 * d || x[2] < 4 * d || x[2] > 20 * d) continue;
      EXPECT_NEAR(x[1], 6 * d, 0.1 * d);
      ++seen;
    }
    EXPECT_GT(seen, 800);
  }
}

TEST(Surface, OfALoneParticleIsAClosedBlobAroundIt) {
  std::mt19937 random(3);
  for (const double full : {1.0, 0.3, 0.05})
    for (int k = 0; k < 20; ++k) {  // wherever it lies in the lattice
      Liquid liquid;
      Vec3 c{};
      for (double& x : c) x = d * static_cast<double>(random()) / 4294967295.0;
      liquid.add(c, full);
      const Shape s = shape_of(surface_grid(liquid.model, liquid.state));
      EXPECT_TRUE(s.closed);
      EXPECT_EQ(s.parts, 1);
      for (const Vec3& x : s.mesh.points) EXPECT_LT(std::hypot(x[0] - c[0], x[1] - c[1], x[2] - c[2]), 0.7 * d);
      EXPECT_GT(s.volume / liquid.volume(), 0.2);
      EXPECT_LT(s.volume / liquid.volume(), full < 0.1 ? 2.5 : 1.0) << "the smallest are as large as the lattice shows";
    }
}

/// A level pool of noisy particles: RMS height of its middle about its mean, m.
double unevenness(SurfaceKernel kernel) {
  Liquid liquid(kernel);
  liquid.fill({0, 0, 0}, {30 * d, 6 * d, 30 * d}, 0.25, [](const Vec3&) { return true; });
  double sum = 0, squares = 0;
  int count = 0;
  for (const Vec3& x : shape_of(surface_grid(liquid.model, liquid.state)).mesh.points) {
    if (x[1] < 4 * d || std::min(x[0], x[2]) < 5 * d || std::max(x[0], x[2]) > 25 * d) continue;
    sum += x[1];
    squares += x[1] * x[1];
    ++count;
  }
  EXPECT_GT(count, 1000);
  EXPECT_NEAR(sum / count, 6 * d, 0.06 * d);
  return std::sqrt(squares / count - sum / count * sum / count);
}

TEST(Surface, OfANoisyPoolIsFlatterByAnisotropicKernels) {
  const double isotropic = unevenness(SurfaceKernel::isotropic), anisotropic = unevenness(SurfaceKernel::anisotropic);
  EXPECT_LT(isotropic, 0.08 * d);
  EXPECT_LT(anisotropic, 0.8 * isotropic);
}

TEST(Surface, OfAThinSheetIsClosedWithoutHolesAndAsThick) {
  for (const SurfaceKernel kernel : both)
    for (const int layers : {1, 2, 3}) {
      Liquid liquid(kernel);
      liquid.fill({0, 0, 0}, {24 * d, layers * d, 24 * d}, 0.1, [](const Vec3&) { return true; });
      const Shape s = shape_of(surface_grid(liquid.model, liquid.state));
      EXPECT_TRUE(s.closed);
      EXPECT_EQ(s.parts, 1);
      const auto edges = s.mesh.triangles.size() * 3 / 2;
      EXPECT_EQ(s.mesh.points.size() + s.mesh.triangles.size() - edges, 2U) << "a hole in it";
      double thickness = 0;  // m, in the middle
      int count = 0;
      for (const Vec3& x : s.mesh.points) {
        if (std::min(x[0], x[2]) < 5 * d || std::max(x[0], x[2]) > 19 * d) continue;
        thickness += 2 * std::abs(x[1] - 0.5 * layers * d);
        ++count;
      }
      EXPECT_GT(count, 500);
      EXPECT_NEAR(thickness / count / (layers * d), 1, 0.06)
          << layers << " layers, kernel " << static_cast<int>(kernel);
      EXPECT_NEAR(s.volume / liquid.volume(), 1, 0.12) << "a rim lies further in";
    }
}

TEST(Surface, OfASmallDropIsRoundWithItsVolume) {
  for (const double radius : {2.0, 3.0, 5.0}) {
    Liquid liquid(SurfaceKernel::anisotropic);
    liquid.add_ball({0.003, 0.001, -0.002}, radius * d, 0.1);
    const Shape s = shape_of(surface_grid(liquid.model, liquid.state));
    EXPECT_TRUE(s.closed);
    EXPECT_EQ(s.parts, 1);
    EXPECT_NEAR(s.volume / liquid.volume(), 1, radius < 3 ? 0.2 : 0.05) << radius << "; the least has 32 particles";
    const double sphere = std::cbrt(36 * std::numbers::pi * s.volume * s.volume);  // m², the least area
    EXPECT_LT(s.area / sphere, 1.05) << radius;
  }
}

TEST(Surface, HasTheSameBitsForAnyNumberOfThreads) {
  for (const SurfaceKernel kernel : both) {
    Liquid liquid(kernel);
    liquid.add_ball({0, 0, 0}, 5 * d, 0.2);
    liquid.fill({10 * d, 0, 0}, {25 * d, d, 20 * d}, 0.2, [](const Vec3&) { return true; });
    liquid.add({1, 0, 0}, 0.3);
    liquid.lay_sheet(-0.8 * d);  // cuts the ball and the pool
    Body& ball = liquid.model.bodies.emplace_back();
    ball.kind = BodyScene::Kind::sphere;
    ball.center = {10 * d, 0, 0};
    ball.radius = 4 * d;
    liquid.state.body_position = {{10 * d, 0, 0}};
    liquid.state.body_orientation = {{1, 0, 0, 0}};
    const Shape one = shape_of(surface_grid(liquid.model, liquid.state));
    for (const int threads : {2, 3, 7}) {
      const Shape more = shape_of(surface_grid(liquid.model, liquid.state, threads));
      EXPECT_EQ(one.mesh.points, more.mesh.points);
      EXPECT_EQ(one.mesh.triangles, more.mesh.triangles);
    }
  }
}

TEST(Surface, DoesNotGoThroughASheetThatTheLiquidLiesOn) {
  Liquid liquid;
  liquid.lay_sheet(0);
  // Pressed against it: the outermost particles lie a third of a spacing above.
  liquid.fill({0, -d / 6, 0}, {16 * d, 4 * d, 16 * d}, 0.1, [](const Vec3&) { return true; });
  const auto lowest = [&] {
    double low = 1;
    for (const Vec3& x : shape_of(surface_grid(liquid.model, liquid.state)).mesh.points) low = std::min(low, x[1]);
    return low;
  };
  EXPECT_GT(lowest(), 0);
  liquid.model.cloths.clear();
  EXPECT_LT(lowest(), -0.05 * d) << "without the sheet it would";
}

TEST(Surface, WithoutLiquidIsEmptyAndReadable) {
  const TempFolder folder;
  const Liquid none;
  FrameWriter(folder.path(), none.model).write(none.state);
  auto grid = read_frame(folder.path() / "frames/surface_000000.vtu");
  EXPECT_EQ(grid->GetNumberOfPoints(), 0);
  ASSERT_EQ(grid->GetNumberOfCells(), 1) << "which other readers require";
  EXPECT_EQ(grid->GetCell(0)->GetNumberOfPoints(), 0);
}

TEST(Surface, ParticlesThatAreNoNumbersAreLeftOut) {
  Liquid liquid;
  liquid.add_ball({0, 0, 0}, 3 * d, 0);
  const vtkIdType before = surface_grid(liquid.model, liquid.state)->GetNumberOfPoints();
  liquid.add({std::nan(""), 0, 0});
  liquid.add({0, INFINITY, 0});
  EXPECT_EQ(surface_grid(liquid.model, liquid.state)->GetNumberOfPoints(), before);
}

/// Files and what they hold.
std::map<std::string, std::string> files_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder).string()] = read_text(entry.path());
  return files;
}

TEST(Surface, SeriesGoOnAfterAnInterruptionWithTheSameBytes) {
  Liquid liquid;
  liquid.add_ball({0, 0, 0}, 4 * d, 0.1);
  const auto write = [&](FrameWriter& writer, int first, int last) {
    for (int f = first; f < last; ++f) {
      HostState state = liquid.state;
      state.time = 0.25 * f;
      for (Vec3& x : state.fluid_position) x[1] -= 0.3 * d * f;
      writer.write(state);
    }
  };
  const TempFolder whole, part;
  FrameWriter all(whole.path(), liquid.model);
  write(all, 0, 5);
  EXPECT_EQ(all.collections(), (std::vector<std::string>{"fluid.pvd", "surface.pvd"}));
  {
    FrameWriter begun(part.path(), liquid.model);
    write(begun, 0, 4);  // the last two of them after the checkpoint
  }
  FrameWriter resumed(part.path(), liquid.model, 2);
  EXPECT_EQ(read_collection(part.path() / "surface.pvd").size(), 2U);
  EXPECT_FALSE(fs::exists(part.path() / "frames/surface_000002.vtu"));
  write(resumed, 2, 5);
  const auto entries = read_collection(part.path() / "surface.pvd");
  ASSERT_EQ(entries.size(), 5U);
  for (std::size_t f = 0; f < 5; ++f) {
    EXPECT_DOUBLE_EQ(entries[f].time, 0.25 * static_cast<double>(f));
    EXPECT_EQ(point_fields(read_frame(part.path() / entries[f].file)),
              (std::vector<std::string>{"normal", "velocity"}));
  }
  EXPECT_TRUE(files_in(whole.path()) == files_in(part.path()));
}

}  // namespace
}  // namespace drench::test
