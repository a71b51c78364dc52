// From a scene to a model: liquid blocks, jets, and the memory that a scene needs. Bodies: build_geometry_test.cpp.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>

#include "build_scenes.hpp"
#include "pipeline/backend.hpp"
#include "setup/memory_estimate.hpp"
#include "setup/smoothing_kernel.hpp"

namespace drench::testing {
namespace {

TEST(FluidBlocks, WarnWhereAFixedStepIsLongerThanCapillaryWavesAllow) {
  Scene scene = wet_scene();
  scene.fluid.blocks.push_back({.box = {{0, 0, 0}, {0.1, 0.1, 0.1}}});
  scene.time.step = 0.8 * std::sqrt(scene.fluid.density * std::pow(scene.fluid.spacing, 3) / (2 * 3.14159265 * 0.1));
  const auto warned = [&] { return any_has(build(scene).warnings, "longer than surface tension or adhesion allows"); };
  EXPECT_FALSE(warned());
  scene.fluid.surface_tension = 0.1;
  EXPECT_TRUE(warned());
  scene.time.mode = TimeMode::cfl;
  EXPECT_FALSE(warned());
  scene.time.mode = TimeMode::fixed;
  scene.time.step *= 0.8;
  EXPECT_FALSE(warned());
}

TEST(FluidBlocks, WarnWhereTheLatticeIsDenserThanTheLiquid) {
  EXPECT_NEAR(lattice_density(KernelKind::cubic, 2), 1.000, 5e-4);
  EXPECT_NEAR(lattice_density(KernelKind::wendland, 2), 1.034, 5e-4);
  EXPECT_NEAR(lattice_density(KernelKind::poly6, 2), 1.010, 5e-4);
  Scene scene = wet_scene();
  scene.fluid.blocks.push_back({.box = {{0, 0, 0}, {0.1, 0.1, 0.1}}});
  const auto warned = [&] {
    for (const std::string& w : build(scene).warnings)
      if (w.find("use a support of 2.4") != std::string::npos) return true;
    return false;
  };
  EXPECT_FALSE(warned());
  scene.fluid.kernel = KernelKind::wendland;
  EXPECT_TRUE(warned());
  scene.fluid.support = 2.5;
  EXPECT_FALSE(warned());
}

TEST(FluidBlocks, AreLatticesInTheirBoxes) {
  Scene scene = wet_scene();
  scene.fluid.blocks.push_back({{{0, 0, 0}, {0.2, 0.1, 0.06}}, {1, 2, 3}});
  const drench::Setup setup = build(scene);
  const HostState& s = setup.state;
  ASSERT_EQ(s.fluid_count(), 10 * 5 * 3);
  EXPECT_NEAR(s.fluid_position[0][0], 0.01, 1e-15);
  EXPECT_NEAR(s.fluid_position[0][2], 0.01, 1e-15);
  EXPECT_EQ(s.fluid_velocity[7], (Vec3{1, 2, 3}));
  for (std::size_t i = 0; i < s.fluid_id.size(); ++i) {
    EXPECT_EQ(s.fluid_id[i], static_cast<std::int64_t>(i));
    EXPECT_EQ(s.fluid_mass[i], quanta_per_particle);
  }
  EXPECT_EQ(s.next_id, 150);
  EXPECT_TRUE(setup.warnings.empty());
  for (const auto* field : {&s.fluid_age, &s.fluid_density_ratio, &s.fluid_kappa_density, &s.fluid_kappa_divergence}) {
    EXPECT_EQ(*field, std::vector<double>(150, 0.0));
  }
}

/// Whatever their size, blocks fill their boxes and hold the mass that these enclose.
TEST(FluidBlocks, HoldTheMassThatTheyEnclose) {
  const Vec3 first{0.1, -0.2, 0.3};
  for (const Vec3& size : {Vec3{0.07, 0.07, 0.07}, Vec3{0.065, 0.1, 0.2}, Vec3{0.2, 0.201, 0.413},
                           Vec3{0.02, 0.011, 0.03}, Vec3{0.0209, 0.0211, 0.15}, Vec3{0.02, 0.04, 0.0600001}}) {
    Scene scene = wet_scene();
    scene.fluid.density = 870;
    Box box{first, first};
    for (std::size_t a = 0; a < 3; ++a) box.max[a] += size[a];
    scene.domain = box;  // no particle lies outside
    scene.fluid.blocks.push_back({box});
    const drench::Setup setup = build(scene);
    const HostState& s = setup.state;
    const double volume = size[0] * size[1] * size[2],
                 mass = setup.model.quantum *
                        static_cast<double>(std::accumulate(s.fluid_mass.begin(), s.fluid_mass.end(), Quanta{0}));
    EXPECT_NEAR(mass, 870 * volume, setup.model.quantum + 1e-14 * mass) << size[0] << " " << size[1] << " " << size[2];
    const auto [least, most] = std::minmax_element(s.fluid_mass.begin(), s.fluid_mass.end());
    EXPECT_LE(*most - *least, 1);
    std::array<std::set<double>, 3> layers;
    for (const Vec3& x : s.fluid_position)
      for (std::size_t a = 0; a < 3; ++a) layers[a].insert(x[a]);
    EXPECT_EQ(layers[0].size() * layers[1].size() * layers[2].size(), s.fluid_position.size());
    for (std::size_t a = 0; a < 3; ++a) {
      const double step = size[a] / static_cast<double>(layers[a].size());
      EXPECT_LE(step, 1.0501 * d) << "layers wider than the spacing";
      EXPECT_GE(step, 0.5 * d);
      EXPECT_NEAR(*layers[a].begin(), first[a] + 0.5 * step, 1e-12);
      EXPECT_NEAR(*layers[a].rbegin(), first[a] + size[a] - 0.5 * step, 1e-12);
    }
  }
}

TEST(FluidBlocks, WarnWhereTheirLayersAreMuchNarrowerThanTheSpacing) {
  const auto warned = [](const Vec3& size, const std::string& text) {
    Scene scene = wet_scene();
    scene.fluid.blocks.push_back({{{0, 0, 0}, {0.1, 0.1, 0.1}}});
    scene.fluid.blocks.push_back({{{0.5, 0.5, 0.5}, {0.5 + size[0], 0.5 + size[1], 0.5 + size[2]}}});
    return any_has(build(scene).warnings, text);
  };
  EXPECT_TRUE(warned({0.07, 0.07, 0.07}, "the size of block 1 is not a multiple of the spacing, 0.02 m"));
  EXPECT_TRUE(warned({0.07, 0.07, 0.07}, "closer along x, y and z (0.0175, 0.0175 and 0.0175 m) and have 0.67 of"));
  EXPECT_TRUE(warned({0.1, 0.03, 0.1}, "closer along y (0.02, 0.015 and 0.02 m) and have 0.75 of"));
  EXPECT_FALSE(warned({0.205, 0.41, 0.1}, "not a multiple")) << "2.5 % wider";
  EXPECT_FALSE(warned({0.1, 0.1, 0.1}, "not a multiple"));
}

/// Beside a block of narrow layers another one starts no closer than these are to each other.
TEST(FluidBlocks, OfNarrowLayersStandSideBySide) {
  Scene scene = wet_scene();
  scene.fluid.blocks = {{{{0, 0, 0}, {0.03, 0.1, 0.1}}}, {{{0.03, 0, 0}, {0.06, 0.1, 0.1}}}};
  const drench::Setup setup = build(scene);
  EXPECT_EQ(setup.state.fluid_count(), 2 * 2 * 5 * 5);
  EXPECT_FALSE(any_has(setup.warnings, "start closer"));
}

TEST(FluidBlocks, OfTooLightParticlesAreRefused) {
  Scene scene = wet_scene();
  scene.fluid.blocks.push_back({{{0, 0, 0}, {0.1, 0.0008, 0.1}}});
  EXPECT_NE(
      error_of(scene).find("fluid: block 0 is much thinner than the spacing, 0.02 m: each particle would have 0.04 of"),
      std::string::npos)
      << error_of(scene);
  scene.fluid.blocks[0].box.max[1] = 0.0011;
  EXPECT_EQ(error_of(scene), "");
}

TEST(FluidBlocks, OverlapsSolidsClothAndDomain) {
  Scene scene = wet_scene();
  const Box box{{0, 0, 0}, {0.2, 0.2, 0.2}};
  scene.fluid.blocks = {{box, {0, 0, 0}}, {{{0.1, 0, 0}, {0.3, 0.2, 0.2}}, {0, 0, 0}}};
  drench::Setup setup = build(scene);
  EXPECT_EQ(setup.state.fluid_count(), 1500);
  EXPECT_TRUE(any_has(setup.warnings, "500 particles are omitted where blocks overlap"));

  scene.fluid.blocks.resize(1);
  scene.bodies.push_back(box_body({{-0.1, -0.1, -0.1}, {0.3, 0.04, 0.3}}));  // swallows two layers
  setup = build(scene);
  EXPECT_EQ(setup.state.fluid_count(), 800);
  EXPECT_TRUE(any_has(setup.warnings, "200 of the blocks' 1000 particles removed: they start inside a solid"));
  scene.bodies[0] = box_body({{0, 0, 0}, {0.2, 0.1, 0.2}}, true);  // a container: only its inside is free
  EXPECT_EQ(build(scene).state.fluid_count(), 500);
  scene.bodies[0] = box_body(box, true);
  EXPECT_EQ(build(scene).state.fluid_count(), 1000);

  ClothScene cloth;
  cloth.grid = GridScene{{1, 1}, {4, 4}};
  cloth.position = {0, 0.112, 0};  // 2 mm off the layer at 0.11, which is 100 particles
  scene.cloths.push_back(cloth);
  setup = build(scene);
  EXPECT_EQ(setup.state.fluid_count(), 1000);
  EXPECT_TRUE(any_has(setup.warnings, "100 of the blocks' particles start within 0.01 m of a cloth"));
  scene.cloths[0].position[1] = 0.12;
  EXPECT_FALSE(any_has(build(scene).warnings, "start within"));

  scene.domain.max[1] = 0.1;
  EXPECT_NE(error_of(scene).find("500 of the blocks' 1000 particles are outside the domain"), std::string::npos);
}

TEST(Jets, CarryTheMeanFlow) {
  for (const double radius : {0.5 * d, 1.5 * d, 5 * d, 0.123}) {
    Scene scene = wet_scene();
    scene.fluid.jets.push_back({{0, 0.5, 0}, radius, {1, -2, 0.5}, 0.1, 2.0});
    const drench::Setup setup = build(scene);
    const Jet& jet = setup.model.jets.at(0);
    const double speed = std::sqrt(5.25), n = static_cast<double>(jet.offsets.size());
    EXPECT_NEAR(d * d * d / jet.interval, std::numbers::pi * radius * radius * speed, 1e-12);
    std::set<Vec3> distinct;
    for (const Vec3& o : jet.offsets) {
      EXPECT_NEAR(to_eigen(o).dot(Eigen::Vector3d(1, -2, 0.5)), 0, 1e-12);
      EXPECT_LE(to_eigen(o).norm(), radius + d);
      distinct.insert(o);
    }
    EXPECT_EQ(distinct.size(), jet.offsets.size());
    EXPECT_GE(n * jet.interval * speed, d * (1 - 1e-9));  // not compressed
    if (radius < 0.6 * d) {
      EXPECT_EQ(jet.offsets, std::vector<Vec3>(1, Vec3{0, 0, 0}));
    }
    if (radius == 5 * d) {
      EXPECT_EQ(jet.offsets.size(), 81u);  // whole shells, at least π 5² = 78.5
    }
    EXPECT_EQ(setup.state.jet_particles, std::vector<std::int64_t>(1, 0));
    EXPECT_EQ(setup.state.fluid_count(), 0);
  }
  Scene scene = wet_scene();
  scene.fluid.jets.push_back({{0, 0.5, 0}, 0.4 * d, {0, -1, 0}, 0, 1});
  EXPECT_NE(error_of(scene).find("jet 0: the radius 0.008 m is below half the spacing"), std::string::npos);
  scene.fluid.jets[0] = {{0, 0.5, 0}, d, {0, 0, 0}, 0, 1};
  EXPECT_NE(error_of(scene).find("the velocity must not be zero"), std::string::npos);
  scene.fluid.jets[0] = {{0, 1.5, 0}, d, {0, -1, 0}, 0, 1};
  EXPECT_NE(error_of(scene).find("outside the domain"), std::string::npos);
}

std::string refusal(const SetupSize& size, const MemoryBudget& budget) {
  try {
    refuse_too_large(size, budget);
  } catch (const SetupError& e) {
    return e.what();
  }
  return "";
}

ArrayBytes arrays_with(int real_bytes, bool gpu = false) {
  return [=](const SetupSize& size) { return kokkos_array_bytes(size, real_bytes, gpu); };
}

TEST(MemoryEstimate, RefusesWhatTheMachineOrTheDeviceCannotHold) {
  EXPECT_GT(machine_memory(), 1e8);
  EXPECT_GT(machine_memory_free(), 1e7);
  EXPECT_LE(machine_memory_free(), machine_memory());
  SetupSize size;
  size.fluid = 1e6;
  const ArrayBytes on_host = arrays_with(4), on_device = arrays_with(4, true);
  const MemoryEstimate estimate = estimate_memory(size, on_host);
  EXPECT_GT(estimate.backend(), 0.5e9);
  EXPECT_LT(estimate.backend(), 1.5e9);
  EXPECT_GT(estimate_memory(size, arrays_with(8)).lists, 1.4 * estimate.lists);
  EXPECT_EQ(refusal(size, {4, 1.01 * estimate.total(), "", 0, on_host}), "");
  EXPECT_NE(refusal(size, {4, 0.99 * estimate.total(), "", 0, on_host}).find("the machine has"), std::string::npos);
  EXPECT_EQ(refusal(size, {4, 1.01 * estimate.host, "", 0, {}}), "") << "nobody tells the arrays";
  // A device has the backend's part, the host the rest.
  const double on_gpu = estimate_memory(size, on_device).backend();
  EXPECT_GT(estimate_memory(size, arrays_with(8, true)).backend(), estimate_memory(size, arrays_with(8)).backend())
      << "bundles of a list are as wide as their longest row";
  EXPECT_LT(on_gpu, estimate.backend()) << "pairs are compact";
  EXPECT_EQ(refusal(size, {4, 1.01 * estimate.host, "GPU", 1.01 * on_gpu, on_device}), "");
  EXPECT_NE(refusal(size, {4, 0.99 * estimate.host, "GPU", 1e12, on_device}).find("the machine has"),
            std::string::npos);
  EXPECT_EQ(
      refusal(size, {4, 1e12, "GPU", 0.4 * 1073741824, on_device}),
      fmt::format(
          "the scene does not fit in the device's memory: 1000000 fluid particles, 0 boundary particles, 0 cloth nodes "
          "and 0 quadrature points of cloth need about {:.1f} GiB, GPU has 0.4 GiB free",
          on_gpu / 1073741824));
}

/// A GPU in float keeps 2 bytes of a pair of the liquid, and each bundle is whole groups of four wide: some 1.5 a row
/// more than its longest. In double it keeps an index and a gradient factor.
TEST(MemoryEstimate, KnowsHowAGpuKeepsPairs) {
  SetupSize size;
  size.fluid = 1e6;
  const auto lists = [&](double bundled, int real_bytes) {
    size.entries.fluid_fluid = {26, bundled};
    return estimate_memory(size, arrays_with(real_bytes, true)).lists;
  };
  constexpr double room = 1.25;
  const double rows = room * size.fluid * (4 + 8.0 / 32);  // count, and start of a bundle
  EXPECT_NEAR(lists(30, 4), rows + room * size.fluid * 31.5 * 2, 1);
  EXPECT_NEAR(lists(30, 8), rows + room * size.fluid * 30 * (4 + 8), 1);
}

TEST(Build, IsTheSameTwice) {
  Scene scene = wet_scene();
  scene.bodies = {sphere_body({0, -0.2, 0}, 0.2)};
  scene.fluid.blocks.push_back({{{-0.1, 0.1, -0.1}, {0.1, 0.3, 0.1}}, {0, 0, 0}});
  ClothScene cloth;
  cloth.grid = GridScene{};
  scene.cloths.push_back(cloth);
  const drench::Setup a = build(scene), b = build(scene);
  EXPECT_EQ(a.state.boundary_volume, b.state.boundary_volume);
  EXPECT_EQ(a.state.sample_volume, b.state.sample_volume);
  EXPECT_EQ(a.state.fluid_position, b.state.fluid_position);
}

}  // namespace
}  // namespace drench::testing
