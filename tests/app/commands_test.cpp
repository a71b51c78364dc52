// The program as a user meets it: commands, exit codes, messages, folders.

#include <gtest/gtest.h>

#include "frame_reader.hpp"
#include "run_program.hpp"

namespace drench::test {
namespace {

/// A small cube of water high above a small damp cloth, with a floor; 20 steps.
constexpr const char* tiny_scene = R"(drench: 1
time: {step: 0.002, end: 0.04}
domain: {min: [-0.5, -0.1, -0.5], max: [0.5, 1, 0.5]}
output: {every: 0.01}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [-0.05, 0.6, -0.05], max: [0.05, 0.7, 0.05]}
cloth:
  - name: sheet
    mesh: {grid: {size: [0.2, 0.2], nodes: [9, 9]}}
    place: {position: [0, 0.3, 0]}
    pin: [{corners: true}]
    initial_saturation: [{box: {min: [-1, 0, -1], max: [1, 1, 1]}, value: 0.5}]
    porous: {absorption: 0.01}
bodies:
  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}
)";

class Commands : public testing::Test {
 protected:
  Commands() { write_text(here() / "tiny.yaml", tiny_scene); }
  const fs::path& here() const { return folder_.path(); }
  Outcome drench(const std::vector<std::string>& arguments) const { return run_drench(here(), arguments); }
  void expect_refusal(const std::vector<std::string>& arguments, const std::string& fragment) const {
    std::string command = "drench";
    for (const auto& a : arguments) command += " " + a;
    SCOPED_TRACE(command);
    const Outcome o = drench(arguments);
    EXPECT_EQ(o.code, 2);
    EXPECT_EQ(o.out, "");
    EXPECT_NE(o.err.find(fragment), std::string::npos) << o.err;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_LT(o.err.size(), 400U) << o.err;
  }

 private:
  TempFolder folder_;
};

TEST_F(Commands, InfoNamesVersionPrecisionAndBackend) {
  const Outcome o = drench({"info"});
  EXPECT_EQ(o.code, 0) << o.err;
  for (const char* word :
       {"version: ", "commit: ", "precision: ", "backend: ", "device: ", "memory: ", " free\n", "threads: ", "Kokkos"})
    EXPECT_NE(o.out.find(word), std::string::npos) << word << " is missing in:\n" << o.out;
}

TEST_F(Commands, HelpAndVersionExitWithZero) {
  for (const char* flag : {"--help", "--version"}) {
    const Outcome o = drench({flag});
    EXPECT_EQ(o.code, 0);
    EXPECT_NE(o.out.find("drench"), std::string::npos);
    EXPECT_EQ(o.err, "");
  }
}

/// What the help shows as examples is what one can type.
TEST_F(Commands, TheExamplesOfTheHelpRun) {
  write_text(here() / "scene.yaml", tiny_scene);
  int examples = 0;
  for (const std::string command : {"", "run", "check", "compare", "info", "schema"}) {
    const Outcome help =
        drench(command.empty() ? std::vector<std::string>{"--help"} : std::vector<std::string>{command, "--help"});
    ASSERT_EQ(help.code, 0) << help.err;
    int of_command = 0;
    for (const std::string& line : split(help.out.substr(help.out.find("Examples:\n")), '\n')) {
      if (line.rfind("  drench ", 0) != 0) continue;
      std::vector<std::string> words = split(line.substr(9, line.find(" |") - 9), ' ');
      if (words == std::vector<std::string>{"run", "scene.yaml"})
        words.push_back("--overwrite");  // it stands there twice
      const Outcome o = drench(words);
      EXPECT_EQ(o.code, 0) << line << "\n" << o.err;
      ++of_command;
    }
    EXPECT_GE(of_command, 2) << command;
    examples += of_command;
  }
  EXPECT_GE(examples, 13);
}

TEST_F(Commands, CheckPrintsWhatARunWouldBeAndWritesNothing) {
  const Outcome o = drench({"check", "tiny.yaml"});
  EXPECT_EQ(o.code, 0) << o.err;
  for (const char* text : {"fluid: 125 particles", "cloth sheet: 81 nodes, 128 triangles", "4 pinned", "memory: about",
                           "spacings a step", "steps: 20 ", "diffusion in sheet", " absorption", " ledger"})
    EXPECT_NE(o.out.find(text), std::string::npos) << text << " is missing in:\n" << o.out;
  EXPECT_EQ(o.out.find("reservoir"), std::string::npos) << o.out;
  EXPECT_EQ(names_in(here()), std::vector<std::string>{"tiny.yaml"});
}

TEST_F(Commands, CheckNamesOnlyTheStagesThatTheSceneNeeds) {
  write_text(here() / "sheet.yaml", "drench: 1\ncloth:\n  - mesh: {grid: {size: [1, 1], nodes: [5, 5]}}\n");
  const Outcome o = drench({"check", "sheet.yaml"});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("stages: time_step cloth advection ledger\n"), std::string::npos) << o.out;
  EXPECT_EQ(o.out.find("fluid"), std::string::npos) << o.out;
}

TEST_F(Commands, CheckWarnsOfStepsThatDoNotFitTheFrames) {
  const Outcome o = drench({"check", "tiny.yaml", "--set", "time.step=0.003"});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("warning: output.every"), std::string::npos) << o.out;
}

TEST_F(Commands, BadCommandLinesAreRefusedInOneLine) {
  expect_refusal({}, "subcommand");
  expect_refusal({"fly"}, "fly");
  expect_refusal({"run"}, "SCENE");
  expect_refusal({"check"}, "SCENE");
  expect_refusal({"run", "tiny.yaml", "--frobnicate"}, "--frobnicate");
  expect_refusal({"run", "tiny.yaml", "--backend", "abacus"}, "abacus");
  expect_refusal({"run", "tiny.yaml", "--until", "soon"}, "soon");
  expect_refusal({"run", "tiny.yaml", "--until", "nan"}, "nan");
  expect_refusal({"run", "tiny.yaml", "--until", "0"}, "--until");
  expect_refusal({"run", "tiny.yaml", "--steps", "-1"}, "--steps");
  expect_refusal({"run", "tiny.yaml", "--steps", "2.5"}, "--steps");
  expect_refusal({"run", "tiny.yaml", "--threads", "0"}, "--threads");
  expect_refusal({"run", "tiny.yaml", "--resume", "checkpoint_1"}, "checkpoint_1: cannot be read: No such file");
  expect_refusal({"compare"}, "SCENE");
  expect_refusal({"compare", "tiny.yaml", "--steps", "0"}, "--steps");
  expect_refusal({"compare", "tiny.yaml", "--tolerance-scale", "-1"}, "--tolerance-scale");
  expect_refusal({"compare", "missing.yaml"}, "missing.yaml");
  EXPECT_EQ(names_in(here()), std::vector<std::string>{"tiny.yaml"});
}

TEST_F(Commands, BadScenesAreRefusedWithTheirPlace) {
  write_text(here() / "bad.yaml", "drench: 1\nfluid:\n  spacin: 0.02\n");
  expect_refusal({"run", "bad.yaml"}, "bad.yaml:3:3: ");
  expect_refusal({"check", "bad.yaml"}, "spacing");
  expect_refusal({"run", "missing.yaml"}, "missing.yaml");
  expect_refusal({"run", "tiny.yaml", "--set", "time.step=-1"}, "time.step");
  expect_refusal({"run", "tiny.yaml", "--set", "nonsense"}, "nonsense");
  EXPECT_EQ(names_in(here()), (std::vector<std::string>{"bad.yaml", "tiny.yaml"}));
}

/// Counts alone look small here: a cloth far finer than the liquid has all its samples in every particle's neighbourhood.
TEST_F(Commands, ListsThatDoNotFitAreRefused) {
  write_text(
      here() / "dense.yaml",
      "drench: 1\nfluid:\n  spacing: 0.001\n  sources: [{block: {min: [0.5, 0.5, 0.5], max: [0.55, 0.55, 0.55]}}]\n"
      "cloth:\n  - mesh: {grid: {size: [1.0e-3, 1.0e-3], nodes: [501, 501]}}\n    porous: {}\n");
  for (const char* command : {"check", "run"})
    expect_refusal({command, "dense.yaml"}, "dense.yaml:3:12: fluid.spacing: the scene does not fit");
}

TEST_F(Commands, RunWritesEverythingAndKeepsTheLedger) {
  const Outcome o = drench({"run", "tiny.yaml"});
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("output in out/tiny"), std::string::npos) << o.out;
  const fs::path out = here() / "out" / "tiny";
  EXPECT_EQ(names_in(out), (std::vector<std::string>{"bodies.pvd", "cloth.pvd", "fluid.pvd", "frames", "run.log",
                                                     "scene.yaml", "stats.csv"}));
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

TEST_F(Commands, ScenesThatFitNoMemoryAreRefusedBeforeAnythingRuns) {
  // 10^8 liquid particles are below the numbers that an Index holds, and need some hundred GiB.
  write_text(here() / "huge.yaml",
             "drench: 1\ndomain: {min: [-9, -9, -9], max: [9, 9, 9]}\n"
             "fluid: {spacing: 0.01, sources: [{block: {min: [-3, -3, -3], max: [3, 3, 3]}}]}\n");
  for (const char* command : {"check", "run", "compare"})
    expect_refusal({command, "huge.yaml", "--set", "fluid.spacing=0.0100001"}, "does not fit in");
  expect_refusal({"run", "huge.yaml", "--backend", "reference"}, "does not fit in");
  expect_refusal({"check", "huge.yaml", "--set", "fluid.spacing=0.0001"}, "the scene is too large");
  EXPECT_EQ(names_in(here()), (std::vector<std::string>{"huge.yaml", "tiny.yaml"}));
}

TEST_F(Commands, WarningsStandInTheLogOnce) {
  const Outcome check = drench({"check", "tiny.yaml", "--set", "time.step=0.003"}),
                run = drench({"run", "tiny.yaml", "--set", "time.step=0.003", "--steps", "2"});
  ASSERT_EQ(run.code, 0) << run.err;
  const std::string log = read_text(here() / "out/tiny/run.log"),
                    line = "warning: output.every is 3.333 times time.step";
  for (const std::string& text : {check.out, run.err, log}) {
    const auto at = text.find(line);
    EXPECT_NE(at, std::string::npos) << text;
    EXPECT_EQ(text.find(line, at + 1), std::string::npos) << text;
  }
}

TEST_F(Commands, CompareAgreesWithinTheTolerancesAndNotExactly) {
  const Outcome o = drench({"compare", "tiny.yaml", "--steps", "2", "--after", "3"});
  EXPECT_EQ(o.code, 0) << o.out << o.err;
  EXPECT_NE(o.out.find("2 steps from step 3, t = 0.006 s"), std::string::npos) << o.out;
  for (const char* row : {"\nneighbors         list.fluid_fluid ", "\ndensity           fluid_density_ratio ",
                          "\ncloth             node_velocity ", "\nadvection         fluid_position ",
                          "\ndiffusion         node_liquid ", "\nledger            report.mass_total ", "\nall "})
    EXPECT_NE(o.out.find(row), std::string::npos) << row << " is missing in:\n" << o.out;
  EXPECT_EQ(o.out.find("  over"), std::string::npos) << o.out;
  // The backend rounds, the reference does not: with no tolerance something is over.
  const Outcome strict = drench({"compare", "tiny.yaml", "--steps", "1", "--tolerance-scale", "0"});
  EXPECT_EQ(strict.code, 1);
  EXPECT_NE(strict.out.find("  over\n"), std::string::npos) << strict.out;
  EXPECT_NE(strict.out.find("fields are over their tolerance\n"), std::string::npos) << strict.out;
  EXPECT_EQ(strict.out.find(
                "list.fluid_fluid                        0           0            0   pairs         0      0  over"),
            std::string::npos)
      << "what is equal is not over";
  EXPECT_EQ(names_in(here()), std::vector<std::string>{"tiny.yaml"});
}

// In free fall the divergence solve's κ is made of the velocities' rounding alone, and no two precisions agree on it.
TEST_F(Commands, CompareTakesRoundingForRounding) {
  const Outcome o = drench({"compare", scenes_folder() + "/drop_on_cloth.yaml"});
  EXPECT_EQ(o.code, 0) << o.out << o.err;
  EXPECT_NE(o.out.find("\ndivergence        fluid_kappa_divergence "), std::string::npos) << o.out;
}

TEST_F(Commands, AFrameThatCannotBeWrittenStopsTheRun) {
  const fs::path out = here() / "o";
  const auto block = [&] {  // a file in place of the folder, once the run is on its way
    if (!fs::exists(out / "bodies.pvd") || fs::is_regular_file(out / "frames")) return false;  // the first is written
    fs::remove_all(out / "frames");
    write_text(out / "frames", "");
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

TEST_F(Commands, AClothSolveThatEndsAtItsCapIsLogged) {
  write_text(here() / "sheet.yaml",
             "drench: 1\noutput: {every: 0}\ncloth_solver: {max_iterations: 2}\n"
             "cloth: [{mesh: {grid: {}}, pin: [{corners: true}]}]\n");
  ASSERT_EQ(drench({"run", "sheet.yaml", "-o", "o", "--steps", "3"}).code, 0);
  const std::string log = read_text(here() / "o/run.log");
  EXPECT_NE(log.find("warning: step 1 (t = 0.004 s): the cloth solve did not converge in 2 iterations"),
            std::string::npos)
      << log;
  EXPECT_NE(log.find("the cloth solve did not converge in 3 of 3 steps"), std::string::npos) << log;
  EXPECT_EQ(read_table(here() / "o/stats.csv").text(2, "cloth_iterations"), "2");
}

// The density solve goes on from where the cloth's ended, to its own end: that is not what the cloth's has left.
TEST_F(Commands, AClothSolveThatEndsAtItsCapBesideLiquidIsLoggedWithWhatItLeft) {
  for (const char* backend : {"kokkos", "reference"}) {
    std::vector<std::string> run{"run", "tiny.yaml", "-o", backend, "--steps", "3"};
    for (const char* key : {"cloth_solver.max_iterations=2", "cloth_solver.tolerance=1e-4"}) {
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
