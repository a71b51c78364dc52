// The program as a user meets it: commands, exit codes, messages. What a run writes: run_command_test.cpp.

#include <gtest/gtest.h>

#include "commands_fixture.hpp"

namespace drench::test {
namespace {

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
  write_text(here() / "garment.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n");
  write_text(here() / "figure.obj", "v 0 0 -1\nv 1 0 -1\nv 0 1 -1\nv 0 0 -2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  for (const std::string command : {"", "run", "check", "compare", "new", "export", "info", "schema"}) {
    const Outcome help =
        drench(command.empty() ? std::vector<std::string>{"--help"} : std::vector<std::string>{command, "--help"});
    ASSERT_EQ(help.code, 0) << help.err;
    int of_command = 0;
    for (const std::string& line : split(help.out.substr(help.out.find("Examples:\n")), '\n')) {
      if (line.rfind("  drench ", 0) != 0) continue;
      std::vector<std::string> words = split(line.substr(9, line.find(" |") - 9), ' ');
      if (words == std::vector<std::string>{"run", "scene.yaml"})
        words.push_back("--overwrite");     // it stands there twice
      if (words.back() == "usd") continue;  // needs usd-core: export_test.py
      const Outcome o = drench(words);
      EXPECT_EQ(o.code, 0) << line << "\n" << o.err;
      ++of_command;
    }
    EXPECT_GE(of_command, 2) << command;
    examples += of_command;
  }
  EXPECT_GE(examples, 17);
}

TEST_F(Commands, PatternsOfFilesAreSearchedBesideASceneOfTheFolderOneIsIn) {
  for (const char* file : {"beat_0.obj", "beat_1.obj"})
    write_text(here() / file, "v 0 0 0\nv 0.3 0 0\nv 0 0.3 0\nv 0 0 0.3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  for (const std::string pattern : {"beat_*.obj", "beat_{}.obj"}) {
    write_text(here() / "beat.yaml",
               "drench: 1\nfluid: {spacing: 0.05, sources: [{block: {min: [0.5, 0, 0], max: [0.7, 0.2, 0.2]}}]}\n"
               "bodies: [{mesh: {sequence: \"" +
                   pattern + "\", fps: 2}}]\n");
    for (const std::string scene : {"beat.yaml", "./beat.yaml"}) {
      const Outcome check = drench({"check", scene});
      EXPECT_EQ(check.code, 0) << pattern << " in " << scene << ": " << check.err;
    }
  }
}

TEST_F(Commands, CheckPrintsWhatARunWouldBeAndWritesNothing) {
  const Outcome o = drench({"check", "tiny.yaml"});
  EXPECT_EQ(o.code, 0) << o.err;
  for (const char* text : {"fluid: 125 particles", "cloth sheet: 81 nodes, 128 triangles", "4 pinned", "memory: about",
                           "spacings per step", "steps: 20 ", "diffusion in sheet", " absorption", " ledger"})
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

/// The cut goes along a plane of the block's lattice: two of its layers below it are ghosts above, and three above it
/// are below.
TEST_F(Commands, CheckTellsWhatARankWouldHave) {
  write_text(here() / "column.yaml",
             "drench: 1\nfluid: {spacing: 0.02, sources: [{block: {min: [0, 0, 0], max: [0.2, 0.4, 0.2]}}]}\n"
             "bodies: [{plane: {point: [0, 0, 0], normal: [0, 1, 0]}}]\n");
  const Outcome one = drench({"check", "column.yaml"}), same = drench({"check", "column.yaml", "--ranks", "1"}),
                two = drench({"check", "column.yaml", "--ranks", "2"});
  EXPECT_EQ(two.code, 0) << two.err;
  EXPECT_EQ(one.out, same.out);
  EXPECT_EQ(one.out.find("rank"), std::string::npos) << one.out;
  for (const char* text :
       {"ranks: 2, with 1000 particles each on average; the fullest has 1000 and 300 ghosts",
        "ghosts (copies of other ranks' particles): 250 per rank on average, 300 at most",
        "memory of the fullest rank: about ", "assumed: ", "replicated: every rank computes all cloth"})
    EXPECT_NE(two.out.find(text), std::string::npos) << text << " is missing in:\n" << two.out;
  // Ghosts come from as far beside cloth as a triangle is long more.
  const Outcome cloth = drench({"check", "tiny.yaml", "--ranks", "2"});
  EXPECT_NE(cloth.out.find("the fullest has 75 and 50 ghosts"), std::string::npos) << cloth.out;
}

/// Where all liquid comes later, its shares are those of a compact body.
TEST_F(Commands, CheckForeseesTheRanksOfAJet) {
  write_text(
      here() / "jet.yaml",
      "drench: 1\ntime: {end: 0.1}\nfluid: {spacing: 0.02, sources: [{jet: {center: [0, 0, 0], radius: 0.1, velocity: "
      "[0, -1, 0]}}]}\n");
  const Outcome jet = drench({"check", "jet.yaml", "--ranks", "3"});
  EXPECT_EQ(jet.code, 0) << jet.err;
  EXPECT_NE(jet.out.find("ranks: 3; the scene starts without liquid"), std::string::npos) << jet.out;
  EXPECT_NE(jet.out.find("memory at the end"), std::string::npos) << jet.out;
}

TEST_F(Commands, BadCommandLinesAreRefusedInOneLine) {
  expect_refusal({}, "subcommand");
  expect_refusal({"fly"}, "fly");
  expect_refusal({"run"}, "SCENE");
  expect_refusal({"check"}, "SCENE");
  for (const char* ranks : {"0", "65537", "two", "1.5"})
    expect_refusal({"check", "tiny.yaml", "--ranks", ranks}, "allowed: a whole number from 1 to 65536");
  expect_refusal({"run", "tiny.yaml", "--frobnicate"}, "drench run: there is no option --frobnicate; see drench run");
  expect_refusal({"run", "tiny.yaml", "--out", "a", "--force"}, "no option --out; did you mean --output?");
  expect_refusal({"check", "tiny.yaml", "--sett=a"}, "no option --sett; did you mean --set?");
  expect_refusal({"check", "tiny.yaml", "other.yaml"}, "'other.yaml' is one argument too many; see drench check");
  expect_refusal({"run", "tiny.yaml", "--backend", "abacus"}, "abacus");
  expect_refusal({"run", "tiny.yaml", "--until", "soon"}, "soon");
  expect_refusal({"run", "tiny.yaml", "--until", "nan"}, "nan");
  expect_refusal({"run", "tiny.yaml", "--until", "0"}, "--until");
  expect_refusal({"run", "tiny.yaml", "--steps", "-1"}, "--steps");
  expect_refusal({"run", "tiny.yaml", "--steps", "2.5"}, "--steps");
  expect_refusal({"run", "tiny.yaml", "--threads", "0"}, "--threads");
  expect_refusal({"run", "tiny.yaml", "--resume", "checkpoint_1"}, "checkpoint_1: cannot be read: No such file");
  expect_refusal({"export"}, "OUT");
  expect_refusal({"export", "out"}, "--to");
  expect_refusal({"export", "out", "--to", "ply"}, "out: no such folder");
  expect_refusal({"export", "out", "--to", "abc"}, "abc");
  expect_refusal({"export", "out", "--to", "ply", "--fps", "fast"}, "fast");
  expect_refusal({"import"}, "FILE");
  expect_refusal({"import", "away.usdc"}, "away.usdc: no such file");
  expect_refusal({"import", "tiny.yaml", "--fps", "0"}, "--fps");
  expect_refusal({"import", "tiny.yaml"},
                 "tiny.yaml: cannot be imported; allowed: .usd, .usda, .usdc, .usdz, .fbx, .gltf, .glb, .abc, .blend, "
                 ".xml, .json");
  expect_refusal({"import", "."}, ".: it is a folder; allowed: .usd, ");
  expect_refusal({"new", "shirt.obj", "--body-prim", "/World/figure"}, "--body-prim: applies only with --body FILE");
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

/// Counts alone look small here: a cloth far finer than the liquid has all its samples in every particle's
/// neighbourhood.
TEST_F(Commands, ListsThatDoNotFitAreRefused) {
  write_text(
      here() / "dense.yaml",
      "drench: 1\nfluid:\n  spacing: 0.001\n  sources: [{block: {min: [0.5, 0.5, 0.5], max: [0.55, 0.55, 0.55]}}]\n"
      "cloth:\n  - mesh: {grid: {size: [1.0e-3, 1.0e-3], nodes: [501, 501]}}\n    porous: {}\n");
  for (const char* command : {"check", "run"})
    expect_refusal({command, "dense.yaml"}, "dense.yaml:3:12: fluid.spacing: the scene does not fit");
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
  EXPECT_NE(strict.out.find("fields exceed their tolerance\n"), std::string::npos) << strict.out;
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

}  // namespace
}  // namespace drench::test
