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

/// What the theory of a test's number is for the first specimen.
std::optional<double> theory(const TestResult& result, const std::string& key) {
  for (const TestNumber& n : result.specimens.at(0).numbers)
    if (n.key == key) return n.expected;
  ADD_FAILURE() << "no " << key;
  return std::nullopt;
}

bool has_note(const TestResult& result, const std::string& part) {
  const std::vector<std::string>& notes = result.specimens.at(0).notes;
  return std::any_of(notes.begin(), notes.end(), [&](const std::string& n) { return n.find(part) != n.npos; });
}

const std::vector<std::string> repels{"cloth.0.porous.permeability=1e-11", "cloth.0.porous.breakthrough_pressure=6000"};

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
  EXPECT_EQ(find_standard_test("AATCC197"), find_standard_test("aatcc197"));
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
  const TestResult springs = run("iso13934-1", "none", {"cloth.0.stretch=800"});
  EXPECT_NEAR(springs.mean("stiffness_warp") / 960, 1, 0.005);
  EXPECT_NEAR(theory(springs, "stiffness_warp").value_or(0), 960, 1e-9);
}

/// A membrane that would lock the folds of the mesh makes the drape hardly stiffer.
TEST(laboratory, drape_hardly_depends_on_stretch) {
  const auto drape = [](const std::string& membrane) {
    return run("drape", "none",
               {"cloth.0.areal_density=0.12", "cloth.0.thickness=3e-4", "cloth.0.membrane=" + membrane,
                "cloth.0.bending={warp: 1.2e-6, weft: 1.2e-6, twist: 1.0e-6}"});
  };
  const TestResult stiff = drape("{warp: 2000, weft: 1500, shear: 30}");
  EXPECT_TRUE(has_note(stiff, "limited to 133 N/m"));
  EXPECT_NEAR(stiff.mean("drape_coefficient"), 18, 5);
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

TEST(laboratory, repellent_fabric_neither_wicks_nor_wets_paper) {
  const TestResult strip = run("aatcc197", "cotton_plain", repels);
  EXPECT_EQ(strip.mean("height_2_min_warp"), 0);
  EXPECT_EQ(strip.mean("height_10_min_weft"), 0);
  EXPECT_EQ(strip.mean("absorbed_warp"), 0);
  EXPECT_TRUE(has_note(strip, "repels water"));
  const TestResult pad = run("iso9073-14", "cotton_plain", repels);
  EXPECT_EQ(pad.mean("wetback"), 0);
  EXPECT_TRUE(has_note(pad, "repels water"));
  const TestResult spread = run("aatcc198", "cotton_plain", repels);
  EXPECT_EQ(spread.mean("length"), 0);
  EXPECT_EQ(spread.mean("time"), 300);
  EXPECT_TRUE(has_note(spread, "the water is not absorbed within 300 s"));
  EXPECT_LT(spread.specimens[0].rows.back()[0], 12);
}

TEST(laboratory, fabric_that_does_not_wick_has_no_height) {
  const TestResult none = run("aatcc197", "cotton_plain", {"cloth.0.porous.diffusivity=0", "time.end=120"});
  EXPECT_EQ(none.mean("height_2_min_warp"), 0);
  EXPECT_TRUE(has_note(none, "no diffusivity"));
  const TestResult slow = run("aatcc197", "cotton_plain", {"cloth.0.porous.diffusivity=1e-12", "time.end=60"});
  EXPECT_LT(slow.specimens[0].rows.back()[1], 0.01);
  EXPECT_TRUE(has_note(slow, "heights are reported from 2 min on; time.end is 60 s"));
  EXPECT_EQ(run("iso9073-14", "cotton_plain", {"cloth.0.porous.diffusivity=0"}).mean("wetback"), 0);
  const TestResult full =
      run("aatcc197", "none", {"cloth.0.porous.diffusivity=5e-4", "cloth.0.porous.capillary_height=10", "time.end=10"});
  EXPECT_TRUE(has_note(full, "the water reaches the upper end of the strip, 161 mm above"));
}

TEST(laboratory, strike_through_theory_has_quadratic_drag) {
  const double fibre = 1e-6, solid = 0.228, thickness = 0.00056, permeability = 1e-10, viscosity = 1e-6;
  const TestResult r = run("iso9073-8", "none",
                           {"time.end=0.05", "cloth.0.porous.fibre_diameter=1e-6", "cloth.0.porous.permeability=1e-10",
                            "cloth.0.porous.solid_fraction=0.228", "cloth.0.thickness=0.00056"});
  const double beta = 1.75 * solid / (std::pow(1 - solid, 3) * 1.5 * fibre);
  const double dose = 5e-6 / 0.0222 / 0.0222 * (0.0222 * 0.0222) / (0.022 * 0.022);
  double time = 0;
  const double low = 0.05 * dose, high = dose - (1 - solid) * thickness;
  constexpr int parts = 10000;
  for (int k = 0; k < parts; ++k) {
    const double h = low + (k + 0.5) * (high - low) / parts, drive = 9.81 * (h + thickness / 2);
    const double g = permeability / (viscosity * thickness);
    const double u = 2 * g * drive / (1 + std::sqrt(1 + 4 * beta * thickness * g * g * drive));
    time += (high - low) / parts / u;
  }
  EXPECT_NEAR(theory(r, "time").value() / time, 1, 0.03) << time;
  const double darcy =
      viscosity * thickness / (permeability * 9.81) * std::log((high + thickness / 2) / (low + thickness / 2));
  EXPECT_GT(time, 1.2 * darcy);
}

TEST(laboratory, spreading_theory_is_the_contour_of_what_counts_as_wet) {
  const double diffusivity = 5e-4, exponent = 2, capacity = 0.6e-3 * 0.77;  // m²/s, 1, m
  const TestResult r = run("aatcc198", "none",
                           {"time.end=6", "cloth.0.porous.diffusivity=5e-4", "cloth.0.porous.diffusion_exponent=2",
                            "cloth.0.porous.solid_fraction=0.23", "cloth.0.thickness=0.6e-3"});
  // Barenblatt's profile C (1 − r²/R²)^(1/n) on rings: its mass is that of the liquid, and R follows Eq. 16c.
  const double length = 1e-3 * theory(r, "length").value(), time = 6 - 2.5, filled = 1e-6 / capacity;
  const double front = std::pow(4 * diffusivity * time * (exponent + 1) / exponent *
                                    std::pow(filled * (exponent + 1) / (exponent * std::numbers::pi), exponent),
                                1 / (2 * exponent + 2));
  double sum = 0;
  constexpr int rings = 20000;
  for (int k = 0; k < rings; ++k) {
    const double x = (k + 0.5) / rings;
    sum += std::pow(1 - x * x, 1 / exponent) * 2 * std::numbers::pi * x / rings;
  }
  const double centre = filled / (sum * front * front);
  EXPECT_NEAR(centre * std::pow(1 - std::pow(length / 2 / front, 2), 1 / exponent), 0.1, 1e-3);
}

TEST(laboratory, tensile_test_has_no_theory_beyond_the_strain_limit) {
  const TestResult r = run("iso13934-1", "denim_11oz", {"cloth.0.strain_limit=0.02", "time.end=2.5"});
  EXPECT_TRUE(theory(r, "force_1_percent_warp"));
  EXPECT_FALSE(theory(r, "force_2_percent_warp"));
  EXPECT_TRUE(has_note(r, "from 2 % on the force is that of strain_limit"));
}

TEST(laboratory, drying_reports_the_water_that_fits) {
  const std::vector<std::string> thin{"cloth.0.thickness=3e-5", "cloth.0.porous.solid_fraction=0.5"};
  const TestResult r = run("iso17617", "none", thin);
  EXPECT_NEAR(r.mean("water"), 0.015 * 0.09375 * 0.09375 * 1e3, 1e-3);
  EXPECT_TRUE(has_note(r, "the specimen holds 0.132 mL"));
  EXPECT_NEAR(run("iso17617", "cotton_plain", {"time.end=300"}).mean("water"), 0.3, 1e-3);
}

TEST(laboratory, tests_leave_out_what_they_do_not_use) {
  const std::vector<std::string> keys{"cloth.0.porous.film=3e-4",
                                      "cloth.0.porous.film_viscosity=1e-6",
                                      "cloth.0.porous.drainage_height=2",
                                      "cloth.0.porous.large_pores=0.5",
                                      "cloth.0.porous.large_pore_height=0.1",
                                      "cloth.0.porous.diffusion_exponent=1",
                                      "cloth.0.porous.contact_wicking=true",
                                      "cloth.0.porous.permeability=1e-10",
                                      "cloth.0.porous.weft_diffusivity=1e-5"};
  const TestResult head = run("iso811", "cotton_plain", keys);
  EXPECT_EQ(head.mean("head"), 0);
  EXPECT_TRUE(has_note(head,
                       "does not use weft_diffusivity, film, film_viscosity, drainage_height, large_pores, "
                       "large_pore_height, contact_wicking"));
  std::vector<std::string> brief = keys;
  brief.emplace_back("time.end=0.02");
  EXPECT_NO_THROW(run("iso9073-8", "cotton_plain", brief));
}

TEST(laboratory, head_of_water_gives_no_warnings_of_its_own_frames) {
  const TestResult r = run("iso811", "polyester_weave", {"cloth.0.porous.breakthrough_pressure=500"});
  EXPECT_TRUE(r.warnings.empty()) << r.warnings.front();
}

TEST(laboratory, equal_specimens_do_not_scatter) {
  TestResult r;
  r.test = find_standard_test("iso811");
  for (const double x : {0.1 + 0.2, 0.3, 0.3}) {
    TestedSpecimen s;
    s.numbers = {{"equal", "equal", "cm", x, {}},
                 {"near", "near", "cm", 20.03 + 1e-6 * static_cast<double>(r.specimens.size()), {}},
                 {"apart", "apart", "cm", 1000 * x * x + 10 * static_cast<double>(r.specimens.size()), {}}};
    r.specimens.push_back(s);
  }
  EXPECT_EQ(r.summary()[0].deviation, 0);
  EXPECT_GT(r.summary()[1].deviation, 0);
  const std::string text = to_text(r);
  EXPECT_NE(text.find("0.3 ± 0        cm"), std::string::npos) << text;
  EXPECT_NE(text.find("20.03 ± 0        cm"), std::string::npos) << text;
  EXPECT_NE(text.find("100 ± 10       cm"), std::string::npos) << text;
}

TEST(laboratory, long_runs_are_foreseen) {
  const TempFolder folder;
  TestRequest request;
  request.overrides = {"cloth.0.porous.diffusivity=1"};
  request.folder = folder.path();
  request.takes_long = [](const std::string& line) { throw std::runtime_error(line); };
  try {
    run_test(*find_standard_test("aatcc197"), request);
    ADD_FAILURE() << "nothing was foreseen";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("about 1.2e+03 steps with"), std::string::npos) << e.what();
  }
}

TEST(laboratory, the_geometry_of_specimens_stays) {
  EXPECT_THROW(run("iso9073-7", "denim_11oz", {"cloth.0.mesh.grid.size=[1,1]"}), SceneError);
  EXPECT_THROW(run("iso9073-7", "denim_11oz", {"cloth.0.mesh.grid.nodes=[9,9]"}), SceneError);
  EXPECT_THROW(run("tensile", "denim_11oz", {"cloth.0.pin.0.start=1"}), SceneError);
  EXPECT_NO_THROW(run("tensile", "denim_11oz", {"cloth.0.mesh.grid.nodes=[5,17]", "time.end=0.6"}));
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
  EXPECT_NE(unknown.err.find("aatcc1 is not a test;"), std::string::npos) << unknown.err;
  EXPECT_NE(unknown.err.find("allowed: aatcc197"), std::string::npos) << unknown.err;
  const Outcome misspelt = run_drench(folder.path(), {"test", "tensyle"});
  EXPECT_NE(misspelt.err.find("did you mean 'tensile'?"), std::string::npos) << misspelt.err;
  const Outcome missing = run_drench(folder.path(), {"test", "tensile", "--fabric", "none.yaml"});
  EXPECT_NE(missing.err.find("none.yaml: there is no file"), std::string::npos) << missing.err;
  EXPECT_EQ(missing.err.find("drench test:"), std::string::npos) << missing.err;
  std::filesystem::create_directory(folder.path() / "full");
  write_text(folder.path() / "full" / "a.txt", "x");
  const Outcome taken = run_drench(folder.path(), {"test", "tensile", "-o", "full"});
  EXPECT_EQ(taken.code, 2);
  EXPECT_NE(taken.err.find("full: is not empty; choose another folder with -o"), std::string::npos) << taken.err;
  EXPECT_EQ(taken.err.find("--overwrite"), std::string::npos) << taken.err;
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
