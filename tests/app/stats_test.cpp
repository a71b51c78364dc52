// stats.csv, its columns, and what a run says of its steps. Frames: output_test.cpp.

#include <gtest/gtest.h>

#include "output/fabric_summary.hpp"
#include "output/run_log.hpp"
#include "output/stats_csv.hpp"
#include "output_example.hpp"
#include "pipeline/pipeline.hpp"
#include "run_program.hpp"

namespace drench::test {
namespace {

TEST(Output, StatisticsHaveTheirColumns) {
  const TempFolder folder;
  const Example e;
  const auto stages = stages_for(e.model);
  const Quanta total = 3 * quanta_per_particle;
  StatsCsv stats(folder.path() / "stats.csv", stages, e.model.quantum, total);
  StepReport report{.step = 1, .time = 0.004, .dt = 0.004};
  report.mass_fluid = quanta_per_particle;
  report.mass_cloth = quanta_per_particle;
  report.mass_drained = 2 * quanta_per_particle;
  report.mass_supplied = quanta_per_particle;
  report.density_iterations = 17;
  std::array<double, stage_count> ms{};
  ms[static_cast<std::size_t>(Stage::pressure)] = 2.5;
  stats.write({report, ms, 4.5});
  report.step = 2;
  report.mass_fluid += 1;
  stats.write({report, ms, 4.5});

  const Table table = read_table(folder.path() / "stats.csv");
  const std::vector<std::string> first = split(
      "step,time,dt,particles,density_iterations,divergence_iterations,density_error,density_error_max,mass_fluid,"
      "mass_cloth,mass_drained,mass_supplied,mass_total,mass_error,saturation_max,kinetic_energy",
      ',');
  ASSERT_GE(table.header.size(), first.size() + stages.size());
  EXPECT_TRUE(std::equal(first.begin(), first.end(), table.header.begin()));
  for (std::size_t s = 0; s < stages.size(); ++s)
    EXPECT_EQ(table.header[table.header.size() - stages.size() + s], "ms_" + std::string(name_of(stages[s])));
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[0].size(), table.header.size());
  EXPECT_EQ(table.text(1, "step"), "2");
  EXPECT_DOUBLE_EQ(table.number(1, "time"), 0.004);
  EXPECT_DOUBLE_EQ(table.number(1, "dt"), 0.004);
  EXPECT_DOUBLE_EQ(table.number(0, "mass_total"), 2.4);
  EXPECT_EQ(table.text(0, "mass_error"), "0");
  EXPECT_EQ(table.text(0, "density_iterations"), "17");
  EXPECT_DOUBLE_EQ(table.number(0, "ms_pressure"), 2.5);
  EXPECT_DOUBLE_EQ(table.number(0, "ms_step"), 4.5);
  EXPECT_EQ(table.number(1, "mass_error"), e.model.quantum) << "one quantum too many shows";
}

/// Those of a fabric end with its number.
TEST(Output, ColumnsOfAStageStandWhereItRuns) {
  const TempFolder folder;
  StepReport report;
  report.viscosity_stages = 3;
  report.micropolar_stages = 4;
  report.cloth_contacts = 5;
  report.cloth_zone_nodes = 6;
  report.fluid_speed = 1.5;
  report.cloth_speed = 2.5;
  report.cloth_stretch = 1.25;
  report.cloth_iterations = 30;
  report.cloth_residual = 0.25;
  report.nearest_variance = 0.5;
  report.close_share = 0.25;
  report.wet_isotropy = 0.75;
  report.mass_evaporated = 6;
  report.fabrics.resize(2);
  report.fabrics[1] = {.cloth = 2,
                       .liquid = 8,
                       .taken_front = 1,
                       .taken_back = 5,
                       .given_front = 2,
                       .given_back = 3,
                       .wet_area = 0.25,
                       .wet_warp = 0.5,
                       .wet_weft = 0.75};
  const auto table = [&](Stage stage) {
    StatsCsv(folder.path() / "stats.csv", {Stage::time_step, stage, Stage::ledger}, 0.5, 6, -1, {.fabrics = {0, 2}})
        .write({report, {}, 0});
    return read_table(folder.path() / "stats.csv");
  };
  const std::pair<Stage, std::vector<std::pair<std::string, std::string>>> columns[] = {
      {Stage::forces, {{"viscosity_stages", "3"}, {"fluid_speed", "1.5"}}},
      {Stage::micropolar, {{"micropolar_stages", "4"}}},
      {Stage::cloth,
       {{"cloth_speed", "2.5"}, {"cloth_stretch", "1.25"}, {"cloth_iterations", "30"}, {"cloth_residual", "0.25"}}},
      {Stage::self_collision, {{"cloth_contacts", "5"}, {"cloth_zone_nodes", "6"}}},
      {Stage::measures,
       {{"nearest_variance", "0.5"}, {"close_share", "0.25"}, {"wet_isotropy", "0.75"}, {"ms_measures", "0.0000"}}},
      {Stage::evaporation, {{"mass_evaporated", "3"}}},
      {Stage::drying, {{"mass_evaporated", "3"}}},
      {Stage::fabric,
       {{"liquid_2", "4"},
        {"taken_front_2", "0.5"},
        {"taken_back_2", "2.5"},
        {"through_2", "1"},
        {"returned_2", "1.5"},
        {"wet_area_2", "0.25"},
        {"wet_warp_2", "0.5"},
        {"wet_weft_2", "0.75"},
        {"liquid_0", "0"}}}};
  const Table without = table(Stage::absorption);
  EXPECT_EQ(without.text(0, "mass_error"), "0");
  for (const auto& [stage, its_own] : columns) {
    const Table with = table(stage);
    EXPECT_EQ(with.text(0, "mass_error"), "0");
    for (const auto& [column, text] : its_own) {
      EXPECT_EQ(with.text(0, column), text) << column;
      EXPECT_EQ(std::count(without.header.begin(), without.header.end(), column), 0) << column;
    }
  }
}

TEST(Output, StatisticsOfASoluteStandWhereThereIsOne) {
  const TempFolder folder;
  StepReport report;
  report.solute_fluid = 7;
  report.solute_cloth = 5;
  report.solute_supplied = 2;
  const std::array<double, stage_count> ms{};
  const auto table = [&](const SoluteTotal& solute) {
    StatsCsv(folder.path() / "stats.csv", {Stage::ledger}, 1, 0, -1, {.solute = solute}).write({report, ms, 0});
    return read_table(folder.path() / "stats.csv");
  };
  const Table dyed = table({0.5, 9});
  EXPECT_DOUBLE_EQ(dyed.number(0, "solute_fluid"), 3.5);
  EXPECT_DOUBLE_EQ(dyed.number(0, "solute_cloth"), 2.5);
  EXPECT_DOUBLE_EQ(dyed.number(0, "solute_total"), 5);
  EXPECT_DOUBLE_EQ(dyed.number(0, "solute_error"), 0.5);
  const Table clear = table({});
  EXPECT_EQ(std::find(clear.header.begin(), clear.header.end(), "solute_total"), clear.header.end());
}

TEST(Output, ASummaryOfFabricKnowsWhenLiquidStruckThroughAndWhenItWasDry) {
  const Example e;
  Model model = e.model;
  model.cloths.resize(1);
  model.cloths[0].name = "towel";
  FabricSummary summary;
  EXPECT_EQ(summary.lines(model), "");
  FabricNumbers f{.liquid = 1000, .taken_front = 1000};
  summary.add(0.1, {f});
  f.given_back = 10;
  f.wet_area = 0.02;
  summary.add(0.2, {f});
  f.wet_area = 0.01;
  f.liquid = 20;
  summary.add(0.3, {f});
  EXPECT_EQ(summary.lines(model).find("dry at"), std::string::npos);
  f.liquid = 9;
  summary.add(0.4, {f});
  summary.add(0.5, {f});
  const std::string text = summary.lines(model);
  for (const char* part : {"towel", "wet at most 200 cm²", "first at 0.2 s", "; dry at 0.4 s\n"})
    EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
  FabricSummary goes_on;
  goes_on.add(0.5, {f});
  EXPECT_NE(goes_on.lines(model).find("first before 0.5 s"), std::string::npos);
}

TEST(Output, StatisticsGoOnWithTheColumnsOfTheirFile) {
  const TempFolder folder;
  const fs::path path = folder.path() / "stats.csv";
  const StepReport report{.step = 3, .time = 0.3, .density_iterations = 7};
  write_text(path, "step,density_iterations,time\n1,5,0.1\n2,6,0.2\n3,9,0.9\n");
  StatsCsv(path, {Stage::forces}, 1, 0, 2).write({report, {}, 0});
  EXPECT_EQ(read_text(path), "step,density_iterations,time\n1,5,0.1\n2,6,0.2\n3,7,0.3\n");
  write_text(path, "step,of_a_later_drench\n1,5\n");
  EXPECT_THROW(StatsCsv(path, {Stage::forces}, 1, 0, 1), std::runtime_error);
}

TEST(Output, ARunSaysOnceThatClothIsStretchedTooFar) {
  RunTotals totals(1.6);
  StepReport report;
  report.cloth_stretch = 1.6;
  EXPECT_EQ(totals.add(1, 0.1, report, {}), "");
  EXPECT_EQ(totals.warnings(), "");
  report.cloth_stretch = 1.7;
  EXPECT_TRUE(
      totals.add(2, 0.2, report, {}).starts_with("warning: step 2 (t = 0.2 s): cloth is stretched to 1.70 times"));
  report.cloth_stretch = 1.9;
  EXPECT_EQ(totals.add(3, 0.3, report, {}), "");
  report.cloth_stretch = 1;
  totals.add(4, 0.4, report, {});
  EXPECT_TRUE(totals.warnings().starts_with("cloth was stretched to 1.90 times its length at most; beyond 1.60 "));
}

}  // namespace
}  // namespace drench::test
