// The pressure that is fitted to the solver's: exact where it is linear, smooth where that scatters, and in the run's
// files.

#include "output/fitted_pressure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "frame_reader.hpp"
#include "output/vtu_series.hpp"
#include "output_example.hpp"
#include "run_program.hpp"

namespace drench::test {
namespace {

constexpr double d = 0.01, rho = 900;  // m, kg/m³
constexpr Vec3 slope{3, -9.81, 1.5};   // of κ, m/s²

/// Particles with κ = 2 + slope·x, shared out between both solves.
struct Liquid {
  Model model;
  HostState state;
  Liquid() {
    model.spacing = d;
    model.support = 2 * d;
    model.rest_density = rho;
  }
  static double kappa_at(const Vec3& x) { return 2 + slope[0] * x[0] + slope[1] * x[1] + slope[2] * x[2]; }
  void add(const Vec3& x) {
    state.fluid_position.push_back(x);
    state.fluid_mass.push_back(quanta_per_particle / (state.fluid_mass.size() % 3 == 0 ? 4 : 1));
    state.fluid_kappa_density.push_back(0.75 * kappa_at(x));
    state.fluid_kappa_divergence.push_back(0.25 * kappa_at(x));
  }
  /// nx × ny × nz particles of a lattice, each moved by up to `disorder` d along each axis.
  void fill(int nx, int ny, int nz, double disorder) {
    std::mt19937 random(11);
    const auto shift = [&] { return disorder * d * (2 * static_cast<double>(random()) / 4294967295.0 - 1); };
    for (int k = 0; k < nx * ny * nz; ++k)
      add({d * (k % nx) + shift(), d * (k / nx % ny) + shift(), d * (k / (nx * ny)) + shift()});
  }
  double largest_error() const {
    const std::vector<double> fitted = fitted_pressure(model, state);
    double most = 0;
    for (std::size_t i = 0; i < fitted.size(); ++i)
      most = std::max(most, std::fabs(fitted[i] - rho * kappa_at(state.fluid_position[i])));
    return most;
  }
};

constexpr double rounding = 1e-10;  // Pa, of some 2000 Pa

}  // namespace

// Its faces are a free surface or lie at a wall: the fit is the same, for walls have no pressure of their own.
TEST(FittedPressure, IsExactForALinearFieldUpToFacesEdgesAndCorners) {
  Liquid liquid;
  liquid.fill(8, 7, 6, 0.25);
  EXPECT_LT(liquid.largest_error(), rounding);
}

TEST(FittedPressure, IsExactWithinASheetAThreadAndAlone) {
  for (const auto& [nx, ny, nz] : {std::array{8, 8, 1}, {8, 1, 1}, {1, 1, 1}}) {
    Liquid liquid;
    liquid.fill(nx, ny, nz, 0);
    EXPECT_LT(liquid.largest_error(), rounding) << nx << " × " << ny << " × " << nz;
  }
  EXPECT_TRUE(fitted_pressure(Liquid{}.model, {}).empty());
}

TEST(FittedPressure, TakesTheScatterOfSingleParticlesAway) {
  Liquid liquid;
  liquid.fill(9, 9, 9, 0.2);
  std::mt19937 random(3);
  for (double& kappa : liquid.state.fluid_kappa_density) kappa += random() % 2 == 0 ? 0.1 : -0.1;
  const std::vector<double> fitted = fitted_pressure(liquid.model, liquid.state);
  double square = 0;
  for (std::size_t i = 0; i < fitted.size(); ++i)
    square += std::pow(fitted[i] / rho - Liquid::kappa_at(liquid.state.fluid_position[i]), 2);
  EXPECT_LT(std::sqrt(square / static_cast<double>(fitted.size())), 0.05) << "half of what was put on";
}

TEST(FittedPressure, DoesNotDependOnThreadsAndLeavesOutWhatIsNotFinite) {
  Liquid liquid;
  liquid.fill(6, 6, 6, 0.25);
  const std::vector<double> one = fitted_pressure(liquid.model, liquid.state, 1);
  EXPECT_EQ(one, fitted_pressure(liquid.model, liquid.state, 3));
  liquid.add({std::numeric_limits<double>::quiet_NaN(), 0, 0});
  const std::vector<double> more = fitted_pressure(liquid.model, liquid.state);
  EXPECT_TRUE(std::isnan(more.back()));
  EXPECT_EQ(one, std::vector<double>(more.begin(), more.end() - 1));
}

TEST(FittedPressure, StandsInTheFramesOnlyWhereTheSceneAsksForIt) {
  for (const bool asked : {false, true}) {
    const TempFolder folder;
    Example e;
    e.model.scene.output.fitted_pressure = asked;
    e.model.support = 2 * e.model.spacing;
    FrameWriter(folder.path(), e.model).write(e.state);
    auto grid = read_frame(folder.path() / "frames/fluid_000000.vtu");
    const auto fields = point_fields(grid);
    EXPECT_EQ(std::count(fields.begin(), fields.end(), "fitted_pressure"), asked ? 1 : 0);
    // The middle one of three in a row, an eighth as heavy as the others, has κ alone.
    if (!asked) continue;
    const double h = e.model.support / e.model.spacing, t = 1 - 1 / (h * h), w = t * t;
    EXPECT_FLOAT_EQ(field(grid, "fitted_pressure", 1), static_cast<float>(2000 * 0.125 / (0.125 + 2 * w)));
  }
}

}  // namespace drench::test
