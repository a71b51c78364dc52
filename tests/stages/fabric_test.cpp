// Stage fabric: patches that are known, and what comes and goes on the two faces of cloth; backend against reference.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "pipeline/pipeline.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

constexpr const char* asked = "output: {every: 0, fabric: true}";
std::string counted(const std::string& scene = wet_scene()) { return with(scene, "output: {every: 0}", asked); }

/// Two sheets, the first of 0.4 m by 0.3 m (x, z) and turned; between them one that is not porous.
std::string sheets(double wet_above) {
  return fmt::format(R"(drench: 1
time: {{step: 0.002, end: 1}}
output: {{every: 0, fabric: true, wet_above: {}}}
cloth:
  - name: first
    mesh: {{grid: {{size: [0.4, 0.3], nodes: [41, 31]}}}}
    place: {{position: [0.3, 0.1, 0], rotate: {{axis: [1, 2, 3], degrees: 50}}}}
    porous: {{}}
  - {{name: dry, mesh: {{grid: {{size: [0.1, 0.1], nodes: [5, 5]}}}}, place: {{position: [0, 2, 0]}}}}
  - {{name: last, mesh: {{grid: {{size: [0.2, 0.2], nodes: [21, 21]}}}}, place: {{position: [0, 3, 0]}}, porous: {{}}}}
)",
                     wet_above);
}

/// Gives node (i, j) of the first sheet, at x and z (m) from its middle, the saturation f(x, z).
template <class Function>
HostState wetted(const drench::Setup& setup, Function f) {
  HostState s = setup.state;
  const Model& m = setup.model;
  for (Index j = 0; j < 31; ++j)
    for (Index i = 0; i < 41; ++i) {
      const auto n = static_cast<std::size_t>(i + 41 * j);
      const double saturation = f(0.01 * i - 0.2, 0.01 * j - 0.15);
      s.node_liquid[n] = static_cast<Quanta>(saturation * m.samples.node_capacity[n] / m.quantum);
    }
  return s;
}

template <class Check>
void on_both(const drench::Setup& setup, const HostState& state, Check check) {
  run_on_both(setup.model, state, {Stage::fabric}, {},
              [&](const Backend&, const StepReport& report) { check(report.fabrics); });
}

}  // namespace

TEST(fabric, a_half_plane_is_as_large_as_it_is) {
  const auto setup = setup_from(sheets(0.3));
  const HostState state = wetted(setup, [](double x, double) { return 0.5 + 2 * x; });  // wet where x > -0.1
  on_both(setup, state, [&](const std::vector<FabricNumbers>& fabrics) {
    ASSERT_EQ(fabrics.size(), 2U);
    EXPECT_EQ(fabrics[0].cloth, 0);
    EXPECT_EQ(fabrics[1].cloth, 2);
    EXPECT_NEAR(fabrics[0].wet_area, 0.3 * 0.3, 1e-9);
    EXPECT_NEAR(fabrics[0].wet_weft, 0.3, 1e-9);
    EXPECT_NEAR(fabrics[0].wet_warp, 0.3, 1e-9);
    EXPECT_EQ(fabrics[0].liquid, std::accumulate(state.node_liquid.begin(), state.node_liquid.end(), Quanta{0}));
    EXPECT_EQ(fabrics[1].wet_area, 0);
    EXPECT_EQ(fabrics[1].wet_warp, 0);
    EXPECT_EQ(fabrics[1].liquid, 0);
  });
}

TEST(fabric, warp_and_weft_are_told_apart) {
  const auto setup = setup_from(sheets(0.05));
  const HostState state = wetted(setup, [](double x, double z) {
    return std::abs(z) < 0.1051 ? std::max(0.0, 0.05 + 8 * (0.05 - std::abs(x))) : 0;
  });
  on_both(setup, state, [&](const std::vector<FabricNumbers>& fabrics) {
    EXPECT_NEAR(fabrics[0].wet_weft, 0.1, 1e-6) << "along x";
    EXPECT_GT(fabrics[0].wet_warp, 0.2) << "along z";
    EXPECT_LT(fabrics[0].wet_warp, 0.22);
  });
}

TEST(fabric, a_patch_converges_to_its_circle) {
  for (const double radius : {0.03, 0.11}) {
    const auto setup = setup_from(sheets(0.05));
    const HostState state =
        wetted(setup, [&](double x, double z) { return std::max(0.0, 0.05 + 4 * (radius - std::hypot(x, z))); });
    on_both(setup, state, [&](const std::vector<FabricNumbers>& fabrics) {
      EXPECT_NEAR(fabrics[0].wet_area, M_PI * radius * radius, 0.02 * 0.03 / radius * M_PI * radius * radius);
      EXPECT_NEAR(fabrics[0].wet_warp, 2 * radius, 1e-6);
      EXPECT_NEAR(fabrics[0].wet_weft, 2 * radius, 1e-6);
    });
  }
}

TEST(fabric, agrees_with_the_reference) {
  compare_stage({.stage = Stage::absorption, .scene = counted(), .changes = "sample_taken_front"});
  const auto overfilled = [](const Model& m, HostState& s) { overfill(m, s, 4); };
  compare_stage({.stage = Stage::emission, .scene = counted(), .prepare = overfilled, .changes = "sample_given_back"});
  const auto setup = setup_from(counted());
  const auto reference = make_reference_backend(setup.model);
  Pipeline pipeline(setup.model, *reference, setup.state);
  for (int s = 0; s < 12; ++s) pipeline.step(1.0);
  std::vector<FabricNumbers> found;
  on_both(setup, reference->download(),
          [&](const std::vector<FabricNumbers>& fabrics) { found.push_back(fabrics.at(0)); });
  EXPECT_GT(found[0].wet_area, 1e-3);
  EXPECT_NEAR(found[1].wet_area, found[0].wet_area, 1e-9 * found[0].wet_area);
  EXPECT_NEAR(found[1].wet_warp, found[0].wet_warp, 1e-9);
  EXPECT_EQ(found[1].liquid, found[0].liquid);
  EXPECT_EQ(found[1].taken_front, found[0].taken_front);
  EXPECT_GT(found[0].taken_front, 0) << "water falls onto the upper face";
}

TEST(fabric, what_came_less_what_went_is_what_is_there) {
  for (const char* keys : {"", "permeability: 1.0e-8, "}) {
    const std::string reservoir =
        "    hold_saturation: [{box: {min: [-0.2, -1, 0.12], max: [0.2, 1, 0.2]}, value: 0.6}]\n";
    const std::string scene = with(wet_scene(), reservoir, "");
    const auto setup = setup_from(counted(with(scene, "porous: {", std::string("porous: {") + keys)));
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    const Quanta before = std::accumulate(setup.state.node_liquid.begin(), setup.state.node_liquid.end(), Quanta{0});
    Quanta through = 0;
    for (int s = 0; s < 150; ++s) {
      const StepReport r = pipeline.step(1.0);
      ASSERT_EQ(r.fabrics.size(), 1U);
      const FabricNumbers& f = r.fabrics[0];
      ASSERT_EQ(f.liquid - before, f.taken_front + f.taken_back - f.given_front - f.given_back) << "step " << s;
      ASSERT_EQ(f.liquid, r.mass_cloth);
      ASSERT_GE(f.through(), through) << "step " << s;
      through = f.through();
    }
    EXPECT_GT(through, 0) << keys;
  }
}

}  // namespace drench::test
