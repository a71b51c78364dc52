// `drench run` as a user meets it: what it writes, where, and how it ends. The other commands: commands_test.cpp.

#include <gtest/gtest.h>

#include <sstream>

#include "commands_fixture.hpp"
#include "frame_reader.hpp"
#include "pipeline/runtime.hpp"

namespace drench::test {
namespace {

TEST_F(Commands, RunWritesEverythingAndKeepsTheLedger) {
  const Outcome o = drench({"run", "tiny.yaml"});
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("output in out/tiny"), std::string::npos) << o.out;
  const fs::path out = here() / "out" / "tiny";
  EXPECT_EQ(names_in(out), (std::vector<std::string>{"bodies.pvd", "cloth.pvd", "energy.csv", "fluid.pvd", "frames",
                                                     "run.log", "scene.yaml", "stats.csv"}));
  const Table stats = read_table(out / "stats.csv");
  ASSERT_EQ(stats.rows.size(), 20U);
  for (std::size_t r = 0; r < stats.rows.size(); ++r) {
    ASSERT_EQ(stats.rows[r].size(), stats.header.size());
    EXPECT_EQ(stats.text(r, "step"), std::to_string(r + 1));
    EXPECT_EQ(stats.text(r, "mass_error"), "0");
    EXPECT_EQ(stats.text(r, "mass_total"), stats.text(0, "mass_total"));
  }
  EXPECT_NEAR(stats.number(19, "time"), 0.04, 1e-12);
  EXPECT_EQ(read_text(out / "run.log").find("warning: particles"), std::string::npos);
  EXPECT_NE(read_text(out / "run.log").find("all stages"), std::string::npos);
}

TEST_F(Commands, FramesMatchTheStatistics) {
  ASSERT_EQ(drench({"run", "tiny.yaml", "--quiet"}).code, 0);
  const fs::path out = here() / "out" / "tiny";
  const Table stats = read_table(out / "stats.csv");
  const auto fluid = read_collection(out / "fluid.pvd"), cloth = read_collection(out / "cloth.pvd");
  ASSERT_EQ(fluid.size(), 5U);
  ASSERT_EQ(cloth.size(), 5U);
  for (std::size_t f = 0; f < fluid.size(); ++f) {
    EXPECT_NEAR(fluid[f].time, 0.01 * static_cast<double>(f), 1e-9);
    EXPECT_EQ(fluid[f].time, cloth[f].time);
    auto water = read_frame(out / fluid[f].file), sheet = read_frame(out / cloth[f].file);
    ASSERT_EQ(sheet->GetNumberOfPoints(), 81);
    ASSERT_EQ(sheet->GetNumberOfCells(), 128);
    double fluid_mass = 0, cloth_mass = 0, fall = 0;
    for (vtkIdType i = 0; i < water->GetNumberOfPoints(); ++i) {
      fluid_mass += field(water, "mass", i);
      if (water->GetPoint(i)[1] > 0.45) fall += field(water, "velocity", i, 1) / 125;  // not what the cloth lets go
    }
    for (vtkIdType n = 0; n < 81; ++n) cloth_mass += field(sheet, "liquid_mass", n);
    EXPECT_NEAR(fall, -9.81 * fluid[f].time, 1e-3 * 9.81 * 0.04) << "free fall, f = " << f;
    if (f == 0) continue;  // the statistics begin after the first step
    const std::size_t row = 5 * f - 1;
    EXPECT_EQ(water->GetNumberOfPoints(), static_cast<vtkIdType>(stats.number(row, "particles")));
    EXPECT_NEAR(fluid_mass, stats.number(row, "mass_fluid"), 1e-12 * stats.number(row, "mass_total"));
    EXPECT_NEAR(cloth_mass, stats.number(row, "mass_cloth"), 1e-12 * stats.number(row, "mass_total"));
    EXPECT_GT(cloth_mass, 0);
  }
}

TEST_F(Commands, ASecondRunLeavesTheFirstAlone) {
  ASSERT_EQ(drench({"run", "tiny.yaml", "--steps", "3"}).code, 0);
  const std::string first = read_text(here() / "out/tiny/stats.csv");
  const Outcome o = drench({"run", "tiny.yaml", "--steps", "2"});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("out/tiny-2"), std::string::npos) << o.out;
  EXPECT_EQ(read_text(here() / "out/tiny/stats.csv"), first);
  EXPECT_EQ(read_table(here() / "out/tiny-2/stats.csv").rows.size(), 2U);
}

TEST_F(Commands, AFolderThatIsNotEmptyIsNotTouched) {
  fs::create_directory(here() / "mine");
  write_text(here() / "mine/stats.csv", "my own");
  expect_refusal({"run", "tiny.yaml", "-o", "mine"}, "mine: is not empty");
  expect_refusal({"run", "tiny.yaml", "-o", "mine", "--overwrite"}, "mine: is not empty");
  expect_refusal({"run", "tiny.yaml", "-o", "tiny.yaml"}, "tiny.yaml: is not a folder");
  EXPECT_EQ(read_text(here() / "mine/stats.csv"), "my own");
  EXPECT_EQ(names_in(here() / "mine"), std::vector<std::string>{"stats.csv"});
}

TEST_F(Commands, OverwriteReplacesARunAndNothingElse) {
  ASSERT_EQ(drench({"run", "tiny.yaml", "-o", "o"}).code, 0);
  ASSERT_TRUE(fs::exists(here() / "o/frames/fluid_000004.vtu"));
  write_text(here() / "o/notes.txt", "keep");
  write_text(here() / "o/frames/mine.vtu", "keep");
  expect_refusal({"run", "tiny.yaml", "-o", "o"}, "o: is not empty");
  const Outcome o = drench({"run", "tiny.yaml", "-o", "o", "--overwrite", "--steps", "1"});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(read_text(here() / "o/notes.txt"), "keep");
  EXPECT_EQ(read_text(here() / "o/frames/mine.vtu"), "keep");
  EXPECT_FALSE(fs::exists(here() / "o/frames/fluid_000004.vtu"));
  EXPECT_EQ(read_table(here() / "o/stats.csv").rows.size(), 1U);
}

TEST_F(Commands, AFrameThatCannotBeWrittenStopsTheRun) {
  const fs::path out = here() / "o";
  int looks = 0;
  const auto block = [&] {  // a file in place of the folder, once the run is on its way
    if (!fs::exists(out / "bodies.pvd") || fs::is_regular_file(out / "frames")) return false;  // the first is written
    std::error_code again;  // the run writes on: what fails here is tried at the next look
    fs::rename(out / "frames", here() / ("frames_before_" + std::to_string(++looks)), again);
    write_text(here() / "in_the_way", "");
    fs::rename(here() / "in_the_way", out / "frames", again);
    return false;
  };
  const Outcome o = run_drench(
      here(), {"run", "tiny.yaml", "-o", "o", "--set", "time.end=1000", "--set", "output.every=0.1", "--quiet"}, block);
  EXPECT_EQ(o.code, 1) << o.out << o.err;
  EXPECT_NE(o.err.find("frames"), std::string::npos) << o.err;
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  EXPECT_NE(read_text(out / "run.log").find("stopped at step "), std::string::npos);
  EXPECT_FALSE(read_collection(out / "fluid.pvd").empty()) << "the collection of before is still there";
}

TEST_F(Commands, NoOutputLeavesNothing) {
  const Outcome o = drench({"run", "tiny.yaml", "--no-output", "--steps", "12"});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("12 steps"), std::string::npos) << o.out;
  EXPECT_EQ(names_in(here()), std::vector<std::string>{"tiny.yaml"});
}

TEST_F(Commands, QuietSaysNothing) {
  const Outcome o = drench({"run", "tiny.yaml", "--quiet", "--steps", "2"});
  EXPECT_EQ(o.code, 0);
  EXPECT_EQ(o.out, "");
  EXPECT_EQ(o.err, "");
}

TEST_F(Commands, UntilAndStepsEndTheRunWithALastFrame) {
  ASSERT_EQ(drench({"run", "tiny.yaml", "-o", "a", "--until", "0.013"}).code, 0);
  const Table a = read_table(here() / "a/stats.csv");
  EXPECT_NEAR(a.number(a.rows.size() - 1, "time"), 0.013, 1e-12);
  EXPECT_NEAR(read_collection(here() / "a/fluid.pvd").back().time, 0.013, 1e-9);
  ASSERT_EQ(drench({"run", "tiny.yaml", "-o", "b", "--steps", "7"}).code, 0);
  const auto frames = read_collection(here() / "b/fluid.pvd");
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_NEAR(frames.back().time, 0.014, 1e-9);
  ASSERT_EQ(drench({"run", "tiny.yaml", "-o", "c", "--steps", "0"}).code, 0);
  EXPECT_EQ(read_collection(here() / "c/fluid.pvd").size(), 1U);
}

TEST_F(Commands, SetReplacesValuesAndIsRecorded) {
  const Outcome o = drench({"run", "--set", "output.every=0", "--set", "time.end=0.01", "tiny.yaml", "-o", "o"});
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(names_in(here() / "o"), (std::vector<std::string>{"run.log", "scene.yaml", "stats.csv"}));
  EXPECT_EQ(read_table(here() / "o/stats.csv").rows.size(), 5U);
  const std::string scene = read_text(here() / "o/scene.yaml");
  for (const char* text : {"# version: ", "# commit: ", "# precision: ", "# backend: ", "# device: ", "end: 0.01"})
    EXPECT_NE(scene.find(text), std::string::npos) << text;
  EXPECT_EQ(drench({"check", "o/scene.yaml"}).code, 0) << "the resolved scene is a scene";
}

TEST_F(Commands, ProfilePrintsATableOfTheStages) {
  const Outcome o = drench({"run", "tiny.yaml", "--profile", "--no-output", "--steps", "2"});
  EXPECT_EQ(o.code, 0) << o.err;
  for (const char* row : {"\ntime_step ", "\npressure ", "\nledger ", "\nall stages "})
    EXPECT_NE(o.out.find(row), std::string::npos) << row << " is missing in:\n" << o.out;
}

TEST_F(Commands, ProfilePrintsTheMemoryOfTheLargestArrays) {
  const Outcome o = drench({"run", "tiny.yaml", "--profile", "--no-output", "--steps", "2"});
  EXPECT_EQ(o.code, 0) << o.err;
  std::istringstream lines(o.out);
  double rows = 0, total = 0;  // MiB
  for (std::string line; std::getline(lines, line);) {
    if (line.find(" MiB ") == std::string::npos || line.find("B/particle") == std::string::npos) continue;
    const double mebibytes = std::stod(line.substr(42));
    if (line.starts_with("all arrays at the end"))
      total = mebibytes;
    else
      rows += mebibytes;
  }
  EXPECT_GT(total, 0) << o.out;
  EXPECT_NEAR(rows, total, 0.2) << o.out;  // of roundings
  const Outcome plain = drench({"run", "tiny.yaml", "--no-output", "--steps", "2"});
  EXPECT_EQ(plain.out.find("B/particle"), std::string::npos) << plain.out;
}

TEST_F(Commands, AClothSolveThatEndsAtItsCapIsLogged) {
  write_text(here() / "sheet.yaml",
             "drench: 1\noutput: {every: 0}\ncloth_solver: {max_iterations: 2}\n"
             "cloth: [{mesh: {grid: {}}, pin: [{corners: true, velocity: [3, 2, 0]}]}]\n");
  ASSERT_EQ(drench({"run", "sheet.yaml", "-o", "o", "--steps", "3"}).code, 0);
  const std::string log = read_text(here() / "o/run.log");
  const std::string iterations = computes_on_host() ? "2" : "4";  // a GPU's, and those of Newton's method after them
  EXPECT_NE(
      log.find("warning: step 1 (t = 0.004 s): the cloth solve did not converge in " + iterations + " iterations"),
      std::string::npos)
      << log;
  EXPECT_NE(log.find("the cloth solve did not converge in 3 of 3 steps"), std::string::npos) << log;
  EXPECT_EQ(read_table(here() / "o/stats.csv").text(2, "cloth_iterations"), iterations);
}

// The density solve goes on from where the cloth's ended, to its own end: that is not what the cloth's has left.
TEST_F(Commands, AClothSolveThatEndsAtItsCapBesideLiquidIsLoggedWithWhatItLeft) {
  for (const char* backend : {"kokkos", "reference"}) {
    std::vector<std::string> run{"run", "tiny.yaml", "-o", backend, "--steps", "3"};
    for (const char* key :
         {"cloth_solver.max_iterations=2", "cloth_solver.tolerance=1e-4", "cloth.0.pin.0.velocity=[3,2,0]"}) {
      run.push_back("--set");
      run.push_back(key);
    }
    if (backend == std::string("reference")) run.insert(run.end(), {"--backend", backend});
    ASSERT_EQ(drench(run).code, 0);
    EXPECT_NE(read_text(here() / backend / "run.log").find("the cloth solve did not converge in 3 of 3 steps"),
              std::string::npos);
    const Table stats = read_table(here() / backend / "stats.csv");
    for (std::size_t row = 0; row < 3; ++row) EXPECT_GT(stats.number(row, "cloth_residual"), 1) << backend;
  }
}

TEST_F(Commands, TheReferenceRunsThroughTheSamePipeline) {
  ASSERT_EQ(drench({"run", "tiny.yaml", "-o", "k", "--steps", "2"}).code, 0);
  const Outcome o = drench({"run", "tiny.yaml", "-o", "r", "--steps", "2", "--backend", "reference"});
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(read_text(here() / "r/scene.yaml").find("# backend: reference"), std::string::npos);
  const Table k = read_table(here() / "k/stats.csv"), r = read_table(here() / "r/stats.csv");
  EXPECT_EQ(k.header, r.header);
  EXPECT_EQ(k.text(1, "mass_total"), r.text(1, "mass_total"));
}

TEST_F(Commands, CtrlCFinishesTheStepAndWritesALastFrame) {
  const fs::path out = here() / "o";
  const auto three_steps_done = [&] { return read_table(out / "stats.csv").rows.size() >= 3; };
  const Outcome o = run_drench(
      here(), {"run", "tiny.yaml", "-o", "o", "--set", "time.end=1000", "--set", "output.every=500"}, three_steps_done);
  EXPECT_EQ(o.code, 130) << o.out << o.err;
  EXPECT_NE(o.out.find("interrupted"), std::string::npos) << o.out;
  const Table stats = read_table(out / "stats.csv");
  ASSERT_GE(stats.rows.size(), 3U);
  EXPECT_EQ(stats.rows.back().size(), stats.header.size()) << "the last row is whole";
  for (const char* name : {"fluid", "cloth"}) {
    const auto frames = read_collection(out / (std::string(name) + ".pvd"));
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_NEAR(frames[1].time, stats.number(stats.rows.size() - 1, "time"), 1e-6 * frames[1].time);
    EXPECT_GT(read_frame(out / frames[1].file)->GetNumberOfPoints(), 0);
  }
}

}  // namespace
}  // namespace drench::test
