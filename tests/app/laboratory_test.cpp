// Standard tests of textiles: their numbers against theory, and the command that runs them.

#include "laboratory/laboratory.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drench/drench.hpp"
#include "run_program.hpp"
#include "scene/load.hpp"
#include "setup/air.hpp"

namespace drench::test {
namespace {

/// The test in a folder of its own.
TestResult run(const std::string& name, const std::string& fabric, const std::vector<std::string>& overrides = {},
               int repeats = 1) {
  const TempFolder folder;
  TestRequest request;
  request.fabric = fabric;
  request.overrides = overrides;
  request.repeats = repeats;
  request.folder = folder.path();
  return run_test(*find_standard_test(name), request);
}

/// How high a strip of the fabric is a tenth full, m: ∂s/∂t = ∂/∂z (D sⁿ (∂s/∂z + 1/ℓ)) with s(0) = 1 in 0.5 mm cells.
double wicking_height(double diffusivity, double exponent, double height, double time) {
  constexpr double h = 0.0005;
  std::vector<double> s(320, 0.0), flux(321, 0.0);
  s[0] = 1;
  const double step = 0.2 * h * h / diffusivity;
  for (double t = 0; t < time; t += step) {
    for (std::size_t k = 1; k < s.size(); ++k) {
      const double drive = (s[k - 1] - s[k]) / h - 1 / height;
      const double donor = drive > 0 ? s[k - 1] : s[k], other = drive > 0 ? s[k] : s[k - 1];
      const double mean = 0.5 * (std::pow(donor, exponent) + std::pow(other, exponent));
      flux[k] = donor > 0 ? diffusivity * mean * drive : 0;
    }
    for (std::size_t k = 1; k < s.size(); ++k) s[k] += step / h * (flux[k] - (k + 1 < s.size() ? flux[k + 1] : 0));
  }
  for (std::size_t k = 1; k < s.size(); ++k)
    if (s[k] < 0.1) return h * (static_cast<double>(k) - (0.1 - s[k]) / (s[k - 1] - s[k]));
  return h * static_cast<double>(s.size());
}

}  // namespace

TEST(laboratory, every_name_and_alias_is_found_once) {
  std::vector<std::string> names;
  for (const StandardTest& t : standard_tests()) {
    names.emplace_back(t.name);
    for (const char* alias : t.aliases) names.emplace_back(alias);
    EXPECT_EQ(find_standard_test(t.name), &t);
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
  EXPECT_GE(standard_tests().size(), 13u);
  EXPECT_EQ(find_standard_test("aatcc"), nullptr);
}

TEST(laboratory, vertical_wicking_follows_its_equation) {
  const TestResult r = run("aatcc197", "none",
                           {"cloth.0.porous.diffusivity=2e-5", "cloth.0.porous.diffusion_exponent=2",
                            "cloth.0.porous.capillary_height=0.1", "time.end=120"});
  const double theory = 1e3 * wicking_height(2e-5, 2, 0.1, 120);
  EXPECT_NEAR(r.mean("height_2_min_warp") / theory, 1, 0.02) << theory;
  EXPECT_NEAR(r.mean("height_2_min_weft") / theory, 1, 0.02);
  EXPECT_THROW(r.mean("height_10_min_warp"), std::out_of_range);  // it ended before
}

TEST(laboratory, vertical_wicking_tells_warp_from_weft) {
  // Without gravity's pull a front is at c √(D t), so the ratio of heights is √(D_warp/D_weft).
  const TestResult r =
      run("aatcc197", "none",
          {"cloth.0.porous.diffusivity=4e-6", "cloth.0.porous.weft_diffusivity=1e-6",
           "cloth.0.porous.diffusion_exponent=1", "cloth.0.porous.capillary_height=100", "time.end=120"});
  EXPECT_NEAR(r.mean("height_2_min_warp") / r.mean("height_2_min_weft"), 2, 0.1);
}

TEST(laboratory, a_slower_fabric_wicks_less) {
  const auto height = [](const std::string& d) {
    return run("aatcc197", "sock_nylon", {"cloth.0.porous.diffusivity=" + d, "time.end=120"}).mean("height_2_min_warp");
  };
  EXPECT_GT(height("1e-5"), 1.3 * height("2.5e-6"));
}

TEST(laboratory, cantilever_returns_the_flexural_rigidity) {
  const TestResult plate = run("iso9073-7", "denim_11oz");
  EXPECT_NEAR(plate.mean("flexural_rigidity_warp") / 16.0, 1, 0.03);
  EXPECT_NEAR(plate.mean("flexural_rigidity_weft") / 24.2, 1, 0.03);
  // (B/(w g))^(1/3)
  EXPECT_NEAR(plate.mean("bending_length_warp") / (1e3 * std::cbrt(1.6e-5 / (0.324 * 9.81))), 1, 0.01);
  const TestResult hinges = run("cantilever", "none", {"cloth.0.bend=2e-5"});
  EXPECT_NEAR(hinges.mean("flexural_rigidity_warp") / 20, 1, 0.06);
}

TEST(laboratory, tensile_test_returns_the_stiffness) {
  const TestResult r = run("iso13934-1", "denim_11oz");
  EXPECT_NEAR(r.mean("stiffness_warp") / 2028, 1, 0.005);
  EXPECT_NEAR(r.mean("stiffness_weft") / 410.7, 1, 0.005);
  EXPECT_NEAR(r.mean("force_5_percent_warp") / (2028 * 0.05 * 0.05), 1, 0.01);
}

TEST(laboratory, hydrostatic_head_is_the_breakthrough_pressure) {
  const TestResult r = run("iso811", "polyester_weave", {"cloth.0.porous.breakthrough_pressure=1000"});
  EXPECT_NEAR(r.mean("pressure") / 1000, 1, 0.06);
  EXPECT_EQ(run("iso811", "polyester_weave").mean("head"), 0);  // it does not repel
}

TEST(laboratory, a_full_specimen_dries_at_the_rate_of_its_air) {
  // 0.3 mL fill 10 cm by 10 cm of this thin fabric to 0.86, far above the critical saturation.
  const TestResult r =
      run("iso17617", "none",
          {"cloth.0.thickness=5e-5", "cloth.0.porous.solid_fraction=0.3", "cloth.0.porous.diffusivity=1e-6",
           "cloth.0.porous.critical_saturation=0", "cloth.0.porous.capillary_height=100"});
  const Scene scene = parse_scene(
      "drench: 1\nair: {humidity: 0.65, temperature: 20, speed: 0, length: 0.1}\ncloth:\n  - mesh: {grid: "
      "{size: [1, 1], nodes: [2, 2]}}\n    porous: {}\n",
      "air");
  const double theory = 2 * 0.01 * wet_bulb(scene).flux * 3.6e6;  // g/h
  EXPECT_NEAR(r.mean("drying_rate") / theory, 1, 0.02) << theory;
  EXPECT_NEAR(r.mean("time_to_dry") / (60 * 0.27 / theory), 1, 0.06);
}

TEST(laboratory, stiff_fabric_drapes_less_than_limp_fabric) {
  const auto coefficient = [](const char* bend) {
    const std::string b = bend;
    return run("iso9073-9", "cotton_plain",
               {"cloth.0.bending.warp=" + b, "cloth.0.bending.weft=" + b, "cloth.0.bending.twist=" + b, "time.end=1"})
        .mean("drape_coefficient");
  };
  const double limp = coefficient("1e-6"), stiff = coefficient("3e-3");
  EXPECT_LT(limp, 60);
  EXPECT_GT(stiff, 95);  // a plate
  EXPECT_LE(stiff, 101);
}

TEST(laboratory, wetback_conserves_water_and_stops_at_a_tight_specimen) {
  const TestResult r = run("iso9073-14", "cotton_plain");
  const std::vector<double>&first = r.specimens[0].rows.front(), &last = r.specimens[0].rows.back();
  EXPECT_NEAR(last[1] + last[2] + last[3], first[1] + first[2] + first[3], 1e-4);
  EXPECT_GT(r.mean("wetback"), 0.1);
  EXPECT_LT(run("iso9073-14", "cotton_plain", {"cloth.0.porous.diffusivity=1e-12"}).mean("wetback"), 0.01);
}

TEST(laboratory, a_drop_is_absorbed_faster_by_thick_fabric) {
  const TestResult r = run("aatcc79", "cotton_interlock");
  EXPECT_GT(r.mean("wetting_time"), 0.01);
  EXPECT_LT(r.mean("wetting_time"), 1);
  // 50 mg cannot be in less than their volume of voids.
  EXPECT_GT(r.mean("spot"), 1e3 * std::sqrt(4 / std::numbers::pi * 50e-9 / (0.772 * 0.00056)));
}

TEST(laboratory, results_are_written_and_scenes_run) {
  const TempFolder folder;
  const Outcome test = run_drench(folder.path(), {"test", "tensile", "--repeats", "2", "-o", "out", "--json", "--quiet",
                                                  "--fabric", "denim_11oz", "--set", "time.end=1.2"});
  ASSERT_EQ(test.code, 0) << test.err;
  EXPECT_EQ(test.out, read_text(folder.path() / "out" / "result.json"));
  EXPECT_NE(test.out.find("\"key\": \"stiffness_warp\""), std::string::npos);
  EXPECT_NE(test.out.find("\"overrides\": [\"time.end=1.2\"]"), std::string::npos);
  const Table curve = read_table(folder.path() / "out" / "curve.csv");
  EXPECT_EQ(curve.header, (std::vector<std::string>{"specimen", "extension (mm)", "strain (%)", "force (N)"}));
  EXPECT_EQ(curve.rows.size(), 4u * 13);  // warp and weft, two of each, t = 0 to 1.2 s
  EXPECT_NEAR(curve.number(12, "force (N)"), 2028 * 0.05 * 0.01, 0.01);
  const Outcome again = run_drench(folder.path(), {"run", "out/scene_warp_1.yaml", "--no-output", "--quiet"});
  EXPECT_EQ(again.code, 0) << again.err;
}

TEST(laboratory, wrong_words_are_refused) {
  const TempFolder folder;
  const Outcome unknown = run_drench(folder.path(), {"test", "aatcc1"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.err.find("aatcc1 is not a test; allowed: aatcc197"), std::string::npos) << unknown.err;
  const Outcome fabric = run_drench(folder.path(), {"test", "tensile", "--fabric", "tweed"});
  EXPECT_EQ(fabric.code, 2);
  EXPECT_NE(fabric.err.find("tweed"), std::string::npos) << fabric.err;
  const Outcome key = run_drench(folder.path(), {"test", "tensile", "--set", "cloth.0.strech=3"});
  EXPECT_EQ(key.code, 2);
  EXPECT_NE(key.err.find("strech"), std::string::npos) << key.err;
  const Outcome list = run_drench(folder.path(), {"test"});
  EXPECT_EQ(list.code, 0);
  EXPECT_NE(list.out.find("iso811"), std::string::npos);
}

}  // namespace drench::test
