// Runs over MPI ranks as a user starts them: `mpirun -n N drench run SCENE` writes the bytes of one process.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "frame_reader.hpp"
#include "output/checkpoint.hpp"
#include "restart_scenes.hpp"
#include "run_results.hpp"

namespace drench::test {
namespace {

using Words = std::vector<std::string>;

/// Everything of the liquid that no scene of restart_scenes.hpp has: extrapolated walls, a source error, steps by their
/// error, wind on the liquid, a keyed container, a surface and a fitted pressure, in a block that the ranks' cut
/// divides.
constexpr const char* rich_scene = R"(drench: 1
time: {step: 0.004, end: 1, mode: error}
domain: {min: [-0.3, -0.1, -0.3], max: [0.3, 0.5, 0.3]}
output: {every: 0.01, measures: true, surface: true, fitted_pressure: true}
wind: {velocity: [4, 0, 1], liquid_drag: 0.47}
fluid:
  spacing: 0.02
  viscosity: 2.0e-3
  surface_tension: 0.05
  wall_pressure: extrapolated
  micropolar: {transfer: 2.0e-3, viscosity: 1.0e-4, reaction: 0.5}
  solver: {source_error: 0.25}
  sources:
    - block: {min: [-0.12, 0, -0.06], max: [0.12, 0.08, 0.06], velocity: [1, 0, 0]}
    - jet: {center: [0, 0.2, 0], radius: 0.03, velocity: [0, -3, 0]}
bodies:
  - box: {min: [-0.14, 0, -0.08], max: [0.14, 0.3, 0.08], inside: true, slip: 0.01, adhesion: 0.03,
          offset: {keys: [[0, [0, 0, 0]], [0.04, [0.01, 0.004, 0]]], interpolation: smooth}}
  - sphere: {center: [0.05, 0.11, 0], radius: 0.03, dynamic: true, density: 500}
  - sphere: {center: [0, 0.02, 0], radius: 0.03, spin: {axis: [0, 0, 1], degrees_per_second: 600}, slip: free}
)";

/// Two ranks' cut, at x = 0, goes through a dripping cloth, a jet, the drops and a turning body.
constexpr const char* cut_scene = R"(drench: 1
time: {step: 0.003, end: 1}
domain: {min: [-0.4, -0.1, -0.4], max: [0.4, 0.5, 0.4]}
output: {every: 0.01}
fluid:
  spacing: 0.02
  support: 2.2    # the second layer beyond the cut counts
  sources:
    - block: {min: [-0.14, 0.212, -0.04], max: [0.14, 0.252, 0.04], velocity: [1, 0, 0]}
    - jet: {center: [0, 0.3, 0], radius: 0.04, velocity: [0, -3, 0]}
cloth:
  - mesh: {grid: {size: [0.32, 0.16], nodes: [13, 7]}}
    place: {position: [0, 0.2, 0]}
    thickness: 0.004
    pin: [{corners: true}]
    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 1.17}]
    porous: {diffusivity: 1.0e-3, emission_velocity: 5}
bodies:
  - box: {min: [-0.1, 0.254, -0.02], max: [0.1, 0.27, 0.02], spin: {axis: [0, 1, 0], degrees_per_second: 720}}
)";

/// A jet two layers a step into an empty room: the first rank has all of it until the ranks cut anew, again and again.
constexpr const char* jet_scene = R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-0.2, -0.2, -0.2], max: [1, 0.2, 0.2]}
output: {every: 0.01}
fluid:
  spacing: 0.01
  sources: [{jet: {center: [0, 0, 0], radius: 0.025, velocity: [10, 0.5, 0]}}]
)";

/// Particles in a line of eight pairs of layers: a part of each of eight ranks is as wide as a cell.
constexpr const char* line_scene = R"(drench: 1
time: {step: 0.004, end: 1, mode: cfl}
output: {every: 0.01}
fluid:
  spacing: 0.02
  viscosity: 1.0e-3
  surface_tension: 0.05
  sources: [{block: {min: [0, 0, 0], max: [0.32, 0.06, 0.06], velocity: [2, 0, 0]}}]
bodies:
  - box: {min: [-0.02, 0, -0.02], max: [0.34, 0.3, 0.08], inside: true}
)";

/// Fewer particles than ranks.
constexpr const char* few_scene = R"(drench: 1
time: {step: 0.004, end: 1}
output: {every: 0.01}
fluid:
  spacing: 0.02
  sources: [{block: {min: [0, 0, 0], max: [0.06, 0.02, 0.02]}}]
bodies:
  - plane: {point: [0, -0.001, 0], normal: [0, 1, 0]}
)";

/// What runs over ranks need and is not here; "" if nothing. Checked once.
std::string what_is_missing() {
  const TempFolder folder;
  if (run_words(folder.path(), {"mpirun", "-n", "1", "true"}).code != 0) return "mpirun is not here, or starts nothing";
  if (run_drench(folder.path(), {"info"}).out.find("ranks: none") != std::string::npos)
    return "the program knows no MPI";
  return "";
}

/// As root, more ranks than cores, and ranks that wait give way: in the words of Open MPI 4 and 5.
void set_up_mpi() {
  for (const char* name :
       {"OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "PRTE_ALLOW_RUN_AS_ROOT",
        "PRTE_ALLOW_RUN_AS_ROOT_CONFIRM", "OMPI_MCA_rmaps_base_oversubscribe", "OMPI_MCA_mpi_yield_when_idle"})
    setenv(name, "1", 0);
  setenv("OMPI_MCA_hwloc_base_binding_policy", "none", 0);
  setenv("PRTE_MCA_hwloc_default_binding_policy", "none", 0);
  setenv("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe", 0);
}

class Ranks : public testing::Test {
 protected:
  void SetUp() override {
    set_up_mpi();
    static const std::string missing = what_is_missing();
    if (!missing.empty()) GTEST_SKIP() << missing;
  }
  const fs::path& here() const { return folder_.path(); }
  fs::path scene(const char* text) const {
    write_text(here() / "scene.yaml", text);
    return "scene.yaml";
  }
  /// The program on so many ranks; 1: without mpirun.
  Outcome on(int ranks, const Words& arguments, const std::function<bool()>& when = nullptr) const {
    Words words;
    if (ranks > 1) words = {"mpirun", "-n", std::to_string(ranks)};
    words.push_back(program());
    words.insert(words.end(), arguments.begin(), arguments.end());
    return run_words(here(), words, when);
  }
  static Words with(Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  static Words run_of(const fs::path& scene, const Words& more = {}, const std::string& threads = "1") {
    return with({"run", scene.string(), "--quiet", "--threads", threads, "--set", "output.checkpoint_every=0.01"},
                more);
  }
  void must(int ranks, const Words& arguments) const {
    const Outcome o = on(ranks, arguments);
    ASSERT_EQ(o.code, 0) << o.err;
    EXPECT_EQ(o.out + o.err, "") << "on " << ranks << " ranks";
  }
  /// Runs it in one process, into the folder "1", and on so many ranks each, and expects the same bytes.
  void expect_equal(const fs::path& scene, std::initializer_list<int> ranks, int steps, const Words& more = {}) {
    const Words words = run_of(scene, with(more, {"--overwrite", "--steps", std::to_string(steps)}));
    must(1, with(words, {"-o", "1"}));
    stats_ = read_table(here() / "1/stats.csv");
    ASSERT_EQ(stats_.rows.size(), static_cast<std::size_t>(steps));
    ASSERT_FALSE(checkpoints_in(here() / "1").empty());
    for (const int n : ranks) {
      must(n, with(words, {"-o", "n"}));
      EXPECT_EQ(difference(here() / "1", here() / "n"), "") << n << " ranks";
      const std::string log = read_text(here() / "n/run.log");
      EXPECT_NE(log.find(fmt::format("  {} ranks, ", n)), std::string::npos) << log;
    }
  }
  double first(const std::string& column) const { return stats_.number(0, column); }
  double last(const std::string& column) const { return stats_.number(stats_.rows.size() - 1, column); }
  /// One line of ours among the lines of mpirun, once.
  static void expect_line(const Outcome& o, const std::string& fragment) {
    std::size_t lines = 0;
    for (const std::string& line : split(o.err, '\n')) lines += line.find(fragment) != std::string::npos;
    EXPECT_EQ(lines, 1U) << fragment << " in:\n" << o.err;
    EXPECT_EQ(o.out.find(fragment), std::string::npos) << o.out;
  }

  Table stats_;  // of one process

 private:
  TempFolder folder_;
};

TEST_F(Ranks, WaterOnClothThatItSoaks) {
  expect_equal(scenes_folder() + "/water_on_cloth.yaml", {2, 3}, 15,
               {"--set", "fluid.spacing=0.02", "--set", "cloth.0.mesh.grid.nodes=[13,13]", "--set",
                "fluid.sources.0.jet.center=[0,0.03,0]", "--set", "time.mode=fixed"});
  EXPECT_GT(last("mass_cloth"), 1e-3);
}

TEST_F(Ranks, AJetABlockAndFloatingBodies) {
  expect_equal(scene(liquid_scene), {2, 3}, 12);
  EXPECT_GT(last("mass_supplied"), 0);
  EXPECT_GT(last("mass_drained"), 0);
}

TEST_F(Ranks, EverythingThatALiquidDoes) {
  expect_equal(scene(rich_scene), {2, 3}, 8);
  EXPECT_GT(last("particles"), first("particles"));
  std::set<std::string> lengths;
  for (std::size_t r = 0; r < stats_.rows.size(); ++r) lengths.insert(stats_.text(r, "dt"));
  EXPECT_GT(lengths.size(), 2U) << "steps of one length are no matter of the error";
}

TEST_F(Ranks, ClothThatTouchesItselfAndDrips) {
  expect_equal(scene(porous_scene), {2, 3}, 12);
  const HostState end = read_checkpoint(checkpoints_in(here() / "1").at(0)).state;
  const auto fresh =
      std::count(end.fluid_origin.begin(), end.fluid_origin.end(), static_cast<std::uint8_t>(Origin::cloth));
  EXPECT_GT(fresh, 0) << "no drops";
}

TEST_F(Ranks, FilmsThatRunAndDrip) {
  std::string text = porous_scene;
  for (const std::string from : {"max_saturation: 1.5,", "porous: {diffusivity: 1.0e-3,"})
    text.replace(text.find(from), from.size(),
                 (from[0] == 'p' ? "porous: {diffusivity: 1.0e-3, " : "") + std::string("film: 6.0e-4,"));
  expect_equal(scene(text.c_str()), {2}, 12);
}

TEST_F(Ranks, ClothThatIsSqueezed) {
  std::string text = porous_scene;
  text.replace(text.find("max_saturation: 1.5,"), 0, "compressibility: 0.5, ");
  expect_equal(scene(text.c_str()), {2}, 12);
}

TEST_F(Ranks, ClothWithHysteresis) {
  std::string text = porous_scene;
  text.replace(text.find("max_saturation: 1.5,"), 0,
               "drainage_height: 0.5, large_pores: 0.5, large_pore_height: 0.05, ");
  expect_equal(scene(text.c_str()), {2}, 12);
}

TEST_F(Ranks, ClothByXpbdUnderWater) {
  expect_equal(scene(porous_scene), {3}, 5, {"--set", "cloth_solver.method=xpbd"});
}

TEST_F(Ranks, ClothOfSeveralFabrics) {
  std::string text = porous_scene;
  text.insert(text.find("    pin: [{nodes"), scene_regions);
  expect_equal(scene(text.c_str()), {2}, 8);
}

TEST_F(Ranks, ClothAloneIsReplicated) { expect_equal(scene(cloth_scene), {2}, 6); }

TEST_F(Ranks, EverythingThatKeysMove) { expect_equal(scene(keyed_scene), {2}, 12); }

TEST_F(Ranks, EmittersThatMoveAndDrains) {
  std::string text = emitters_scene;
  text.insert(text.find("  drains:"), moving_spray);
  expect_equal(scene(text.c_str()), {2, 3}, 40);
  EXPECT_GT(last("mass_drained"), 0);
  EXPECT_GT(last("mass_supplied"), 0);
}

TEST_F(Ranks, HashedCellsAndAReservoir) {
  expect_equal(scene(filter_scene), {3}, 8);
  EXPECT_GT(last("mass_supplied"), 0);
}

TEST_F(Ranks, TheCutGoesThroughEverything) {
  expect_equal(scene(cut_scene), {2}, 14);
  EXPECT_GT(last("particles"), first("particles") + 20);
  EXPECT_GT(std::abs(last("mass_cloth") - first("mass_cloth")), 0) << "kg";
}

TEST_F(Ranks, PressureDrivesLiquidThroughClothAtTheCut) {
  expect_equal(scene(cut_scene), {2}, 14, {"--set", "cloth.0.porous.permeability=1.0e-8"});
  const HostState end = read_checkpoint(checkpoints_in(here() / "1").back()).state;
  EXPECT_TRUE(std::any_of(end.sample_flux.begin(), end.sample_flux.end(), [](double u) { return u != 0; }));
}

TEST_F(Ranks, LiquidAndClothDryAtTheCut) {
  expect_equal(scene(cut_scene), {2, 3}, 14, {"--set", "air={evaporation_rate: 0.5}"});
  EXPECT_GT(last("mass_evaporated"), 1e-6);
}

TEST_F(Ranks, DyeGoesThroughClothAtTheCut) {
  expect_equal(scene(cut_scene), {2}, 14, {"--set", "fluid.sources.0.block.concentration=0.01"});
  EXPECT_GT(last("solute_cloth"), 0);
  EXPECT_EQ(last("solute_error"), 0);
}

TEST_F(Ranks, AllLiquidOnOneRankIsSharedOut) {
  expect_equal(scene(jet_scene), {2, 3}, 15);
  EXPECT_GT(last("particles"), 400) << "at 142 two ranks cut anew, and at 101 three do";
}

TEST_F(Ranks, PartsAsWideAsACellAndNarrower) {
  expect_equal(scene(line_scene), {8}, 6);
  expect_equal(scene(line_scene), {8}, 4, {"--set", "fluid.sources.0.block.max=[0.16,0.06,0.06]"});
}

TEST_F(Ranks, RanksWithoutParticles) {
  expect_equal(scene(few_scene), {5}, 4);
  EXPECT_EQ(last("particles"), 3);
}

TEST_F(Ranks, NotWithLiquidOfFiles) {
  test::write_text(here() / "one.ply",
                   "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                   "end_header\n0 0 0\n");
  const Outcome refused =
      on(2, run_of(scene("drench: 1\nfluid: {sources: [{particles: {sequence: [one.ply]}}]}\n"), {"-o", "o"}));
  EXPECT_EQ(refused.code, 2) << refused.err;
  expect_line(refused, "runs on one rank");
}

TEST_F(Ranks, TwoThreadsARank) {
  expect_equal(scene(liquid_scene), {}, 4);
  must(2, run_of("scene.yaml", {"-o", "n", "--steps", "4"}, "2"));
  EXPECT_EQ(difference(here() / "1", here() / "n"), "");
}

TEST_F(Ranks, GoingOnWithOtherNumbersOfRanks) {
  for (const char* text : {porous_scene, liquid_scene}) {
    for (const char* folder : {"whole", "part"}) fs::remove_all(here() / folder);
    const Words words = run_of(scene(text), {"--until", "0.045"});
    must(1, with(words, {"-o", "whole"}));
    must(2, with(words, {"-o", "part", "--steps", "7"}));
    must(3, with(words, {"--resume", "part", "--steps", "4"}));
    must(1, with(words, {"--resume", "part", "--steps", "2"}));
    must(2, with(words, {"--resume", "part"}));
    EXPECT_EQ(difference(here() / "whole", here() / "part"), "");
  }
}

/// Liquid sloshes through the ranks' cut for hundreds of steps in a container that is shaken across it.
TEST_F(Ranks, NothingIsLostOrDoubledAtACutThatIsCrossedForLong) {
  std::string keys = "[0, [0, 0, 0]]";
  for (int k = 0; k < 16; ++k)
    keys += fmt::format(", [{:.3f}, [{}, 0, 0]]", 0.075 + 0.15 * k, k % 2 == 0 ? 0.06 : -0.06);
  const fs::path slosh = scene(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 2.4}}
domain: {{min: [-1, -0.2, -0.2], max: [1, 1, 0.2]}}
output: {{every: 0.02}}
fluid:
  spacing: 0.02
  sources: [{{block: {{min: [-0.16, 0, -0.04], max: [0.16, 0.1, 0.04]}}}}]
bodies:
  - box: {{min: [-0.16, 0, -0.04], max: [0.16, 0.9, 0.04], inside: true, offset: {{keys: [{}], interpolation: smooth}}}}
)",
                                           keys)
                                   .c_str());
  expect_equal(slosh, {2}, 600);
  for (std::size_t r = 0; r < stats_.rows.size(); ++r) {
    ASSERT_EQ(stats_.text(r, "mass_error"), "0") << r;
    ASSERT_EQ(stats_.text(r, "mass_fluid"), stats_.text(0, "mass_fluid")) << r;
    ASSERT_EQ(stats_.text(r, "particles"), "320") << r;
  }
  // Crossings of where the cut was at first; it moves when a rank has 64 more than the mean.
  std::map<std::int64_t, bool> right;
  int crossings = 0;
  for (const CollectionEntry& frame : read_collection(here() / "n/fluid.pvd")) {
    const auto grid = read_frame(here() / "n" / frame.file);
    std::set<std::int64_t> ids;
    for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) {
      const auto id = static_cast<std::int64_t>(field(grid, "id", i));
      ids.insert(id);
      const bool now = grid->GetPoint(i)[0] > 0;
      const auto [before, is_new] = right.try_emplace(id, now);
      crossings += !is_new && before->second != now;
      before->second = now;
    }
    ASSERT_EQ(ids.size(), 320U) << frame.file;
    ASSERT_EQ(*ids.rbegin() - *ids.begin(), 319) << frame.file;
  }
  EXPECT_GT(crossings, 1000);
  std::printf("%d crossings of the middle\n", crossings);
}

TEST_F(Ranks, ABadSceneIsRefusedOnce) {
  write_text(here() / "bad.yaml", "drench: 1\nfluid: {spacing: -1}\n");
  const Outcome o = on(3, {"run", "bad.yaml", "-o", "o"});
  EXPECT_EQ(o.code, 2) << o.err;
  expect_line(o, "bad.yaml:2:18: fluid.spacing: ");
  EXPECT_FALSE(fs::exists(here() / "o"));
  // Well written, and still no scene: known only when it is built.
  const Outcome built = on(2, run_of(scene(few_scene), {"-o", "o", "--set", "fluid.spacing=1e-6"}));
  EXPECT_EQ(built.code, 2) << built.err;
  expect_line(built, "scene.yaml:");
  const Outcome words = on(2, {"run", "scene.yaml", "--no-such-word"});
  EXPECT_NE(words.code, 0);
  EXPECT_NE(words.err.find("--no-such-word"), std::string::npos) << words.err;
  expect_line(on(2, run_of("scene.yaml", {"--resume", "nowhere"})), "nowhere: cannot be read");
}

TEST_F(Ranks, TheReferenceIsRefused) {
  const Outcome o = on(2, run_of(scene(few_scene), {"-o", "o", "--backend", "reference"}));
  EXPECT_EQ(o.code, 2) << o.err;
  expect_line(o, "drench: the reference runs on one rank: start it without mpirun");
  EXPECT_FALSE(fs::exists(here() / "o"));
}

/// Only the first rank writes: what it cannot write ends all of them.
TEST_F(Ranks, WhatCannotBeWrittenEndsAll) {
  const fs::path liquid = scene(liquid_scene);
  const Outcome nowhere = on(3, run_of(liquid, {"-o", "/proc/o"}));
  EXPECT_EQ(nowhere.code, 2) << nowhere.err;
  expect_line(nowhere, "/proc/o: cannot be made");
  // Frames: their folder goes while the run is on, for root too.
  const auto take_frames = [&] {
    std::error_code failed;
    if (!fs::exists(here() / "o/frames/fluid_000001.vtu")) return false;
    fs::rename(here() / "o/frames", here() / "o/away", failed);
    write_text(here() / "o/frames", "");
    return false;  // no signal
  };
  const Outcome frames = on(2, run_of(liquid, {"-o", "o", "--until", "100"}), take_frames);
  EXPECT_EQ(frames.code, 1) << frames.err;
  expect_line(frames, "o/frames");
  // A checkpoint: a folder is in the place of its temporary file.
  must(2, run_of(liquid, {"-o", "p", "--steps", "4"}));
  const std::string next = checkpoint_name(8);
  fs::create_directory(here() / "p" / ("." + next + ".part"));
  const Outcome checkpoint = on(2, run_of(liquid, {"--resume", "p", "--steps", "4"}));
  EXPECT_EQ(checkpoint.code, 1) << checkpoint.err;
  expect_line(checkpoint, next + ": cannot be written: ");
}

TEST_F(Ranks, AFullDiskEndsAllAndKeepsWhatIsThere) {
  const Words words = run_of(scene(liquid_scene), {"--until", "0.04"});
  must(1, with(words, {"-o", "whole"}));
  must(2, with(words, {"-o", "o", "--steps", "6"}));
  // The limit is the program's alone, in blocks of 512 bytes: mpirun has files of its own.
  const Words limited{"mpirun", "-n", "2", "sh", "-c", "ulimit -f 15; exec \"$0\" \"$@\"", program()};
  const Outcome full = run_words(here(), with(limited, with(words, {"--resume", "o"})));
  EXPECT_EQ(full.code, 1) << full.err;
  expect_line(full, "cannot be written: File too large; the last checkpoint is o/checkpoint_000006.drench");
  must(2, with(words, {"--resume", "o"}));
  EXPECT_EQ(difference(here() / "whole", here() / "o"), "");
}

/// What goes wrong is met on one rank, and all of them end with the line of one process, once.
TEST_F(Ranks, AFailingRunEndsAllWithOneLine) {
  const double nan = std::nan("");
  const std::pair<const char*, std::function<void(HostState&)>> edits[] = {
      {"a velocity", [=](HostState& s) { s.fluid_velocity.back()[1] = nan; }},
      {"a position",
       [=](HostState& s) {
         s.fluid_position.front() = {nan, nan, nan};
       }},
      {"one away",
       [=](HostState& s) {
         s.fluid_velocity.front() = {0, 0, 1e4};
       }},
      {"a node", [=](HostState& s) { s.node_velocity.at(40)[2] = nan; }},
      {"torn cloth", [=](HostState& s) { s.node_position.at(40)[1] += 50; }},
      {"a body", [=](HostState& s) { s.body_velocity.at(0)[0] = nan; }},
  };
  must(2, run_of(scene(porous_scene), {"-o", "start", "--steps", "4"}));
  for (const auto& [what, edit] : edits) {
    SCOPED_TRACE(what);
    for (const char* folder : {"1", "n"}) {
      fs::remove_all(here() / folder);
      fs::copy(here() / "start", here() / folder, fs::copy_options::recursive);
      const fs::path newest = checkpoints_in(here() / folder).at(0);
      Checkpoint c = read_checkpoint(newest);
      edit(c.state);
      write_checkpoint(newest, c);
    }
    const Words words = run_of("scene.yaml", {"--steps", "4"});
    const Outcome one = on(1, with(words, {"--resume", "1"})), three = on(3, with(words, {"--resume", "n"}));
    ASSERT_EQ(one.code, 1) << one.err;
    EXPECT_EQ(three.code, 1) << three.err;
    const std::string line = one.err.substr(0, one.err.find("; see 1/"));
    EXPECT_EQ(line.find("drench: the run failed in stage "), 0U) << one.err;
    expect_line(three, line.substr(0, line.find("; the last checkpoint is ")));
    EXPECT_EQ(read_text(here() / "1/failure.vtu"), read_text(here() / "n/failure.vtu"));
  }
}

}  // namespace
}  // namespace drench::test
