// Checkpoints and --resume as a user meets them: a run that goes on equals one that was never interrupted, whatever
// ended it.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <random>

#include "frame_reader.hpp"
#include "good_scenes.hpp"
#include "output/checkpoint.hpp"
#include "restart_scenes.hpp"
#include "run_results.hpp"
#include "scene/load.hpp"
#include "scene/scene_difference.hpp"

namespace drench::test {
namespace {

using Words = std::vector<std::string>;

class Restart : public ::testing::Test {
 protected:
  Restart() {
    write_text(here() / "liquid.yaml", liquid_scene);
    write_text(here() / "porous.yaml", porous_scene);
    write_text(here() / "cloth.yaml", cloth_scene);
    write_text(here() / "filter.yaml", filter_scene);
    write_text(here() / "keyed.yaml", keyed_scene);
    std::string error(porous_scene);
    write_text(here() / "error.yaml", error.replace(error.find("end: 1}"), 7, "end: 1, mode: error}"));
  }
  const fs::path& here() const { return folder_.path(); }
  static Words words(const std::string& scene, const Words& more) {
    Words all{"run", scene + ".yaml", "--quiet", "--set", "output.checkpoint_every=0.01"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Outcome run(const std::string& scene, const Words& more) const { return run_drench(here(), words(scene, more)); }
  /// Runs that must do what they are asked to.
  void must(const std::string& scene, const Words& more) const {
    const Outcome o = run(scene, more);
    ASSERT_EQ(o.code, 0) << o.err;
    EXPECT_EQ(o.out + o.err, "");
  }
  void expect_refusal(const Outcome& o, const std::string& fragment, int code = 2) const {
    EXPECT_EQ(o.code, code) << o.out;
    EXPECT_NE(o.err.find(fragment), std::string::npos) << o.err;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  }
  fs::path newest(const std::string& folder) const { return checkpoints_in(here() / folder).at(0); }

 private:
  TempFolder folder_;
};

TEST_F(Restart, GoingOnEqualsNotHavingStopped) {
  const std::pair<const char*, const char*> scenes[] = {{"liquid", "0.1"},  {"porous", "0.05"}, {"cloth", "0.08"},
                                                        {"filter", "0.05"}, {"keyed", "0.08"},  {"error", "0.06"}};
  for (const auto& [scene, end] : scenes) {
    SCOPED_TRACE(scene);
    const std::string whole = std::string(scene) + "_whole", part = std::string(scene) + "_part";
    must(scene, {"-o", whole, "--until", end});
    for (const char* steps : {"0", "7", "5", "1000000"}) {  // the third ends between two checkpoints' times
      const bool first = !fs::exists(here() / part);
      must(scene, {first ? "-o" : "--resume", part, "--until", end, "--steps", steps});
    }
    EXPECT_EQ(difference(here() / whole, here() / part), "");
    EXPECT_EQ(checkpoints_in(here() / part).size(), 2U);
    // Without checkpoints the same is computed.
    const Outcome plain =
        run_drench(here(), {"run", std::string(scene) + ".yaml", "-o", "plain", "--until", end, "--quiet"});
    ASSERT_EQ(plain.code, 0) << plain.err;
    EXPECT_EQ(difference(here() / whole, here() / "plain", false), "");
    EXPECT_TRUE(checkpoints_in(here() / "plain").empty());
    fs::remove_all(here() / "plain");
  }
}

TEST_F(Restart, TheSurfaceGoesOnToo) {
  const Words on{"--set", "output.surface=true", "--until", "0.03"};
  const auto with = [&](Words more) {
    more.insert(more.end(), on.begin(), on.end());
    return more;
  };
  must("filter", with({"-o", "whole"}));
  EXPECT_EQ(read_collection(here() / "whole/surface.pvd").size(), 4U);
  must("filter", with({"-o", "part", "--steps", "8"}));
  must("filter", with({"--resume", "part"}));
  EXPECT_EQ(difference(here() / "whole", here() / "part"), "");
  // What was there at the checkpoint has to be there still.
  const auto older = checkpoints_in(here() / "part").at(1);
  for (int f = 0; f < 4; ++f) fs::remove(here() / fmt::format("part/frames/surface_{:06}.vtu", f));
  expect_refusal(run("filter", with({"--resume", older.string()})), ".vtu is missing");
}

TEST_F(Restart, TheReferenceGoesOnToo) {
  must("filter", {"-o", "whole", "--until", "0.02", "--backend", "reference"});
  must("filter", {"-o", "part", "--until", "0.02", "--backend", "reference", "--steps", "4"});
  must("filter", {"--resume", "part", "--until", "0.02", "--backend", "reference"});
  EXPECT_EQ(difference(here() / "whole", here() / "part"), "");
}

TEST_F(Restart, WhatWasWrittenAfterTheCheckpointIsCutOff) {
  must("liquid", {"-o", "whole", "--until", "0.08"});
  fs::copy(here() / "whole", here() / "again", fs::copy_options::recursive);
  write_text(here() / "again/notes.txt", "mine");
  write_text(here() / "again/frames/fluid_mine.vtu", "mine");
  write_text(here() / "again/.fluid.pvd.part", "half of a file");
  const auto older = checkpoints_in(here() / "again").at(1);
  must("liquid", {"--resume", older.string(), "--until", "0.08"});
  EXPECT_EQ(read_text(here() / "again/notes.txt") + read_text(here() / "again/frames/fluid_mine.vtu"), "minemine");
  EXPECT_FALSE(fs::exists(here() / "again/.fluid.pvd.part"));
  fs::remove(here() / "again/notes.txt");
  fs::remove(here() / "again/frames/fluid_mine.vtu");
  EXPECT_EQ(difference(here() / "whole", here() / "again"), "");
  const std::string log = read_text(here() / "again/run.log");
  EXPECT_NE(log.find("continuing from " + older.string()), std::string::npos) << log;
  EXPECT_LT(log.find("scene liquid.yaml"), log.find("continuing from")) << "the log goes on";
}

TEST_F(Restart, ALaterEndAndAnotherFolder) {
  must("liquid", {"-o", "long", "--until", "0.09"});
  must("liquid", {"-o", "short", "--until", "0.055"});
  const Outcome warned = run("liquid", {"--resume", newest("short").string(), "--until", "0.09", "-o", "other"});
  EXPECT_EQ(warned.code, 0) << warned.err;
  EXPECT_NE(read_text(here() / "other/run.log").find("time.end shortened its last step"), std::string::npos);
  EXPECT_EQ(read_table(here() / "short/stats.csv").text(read_table(here() / "short/stats.csv").rows.size() - 1, "time"),
            "0.055")
      << "the folder of before is not touched";
  // The checkpoint before that is one of the longer run as well.
  must("liquid", {"--resume", checkpoints_in(here() / "short").at(1).string(), "--until", "0.09"});
  EXPECT_EQ(difference(here() / "long", here() / "short"), "");
  // A run that has come to its end has nothing to do.
  must("liquid", {"--resume", "short", "--until", "0.09"});
  expect_refusal(run("liquid", {"--resume", "short", "--until", "0.03"}), "the run is already at 0.09 s");
  EXPECT_EQ(difference(here() / "long", here() / "short"), "");
}

TEST_F(Restart, FramesAtOtherTimes) {
  must("liquid", {"-o", "o", "--until", "0.05", "--steps", "12"});
  const auto kept = read_collection(here() / "o/fluid.pvd").size() - 1;  // the last one was not on schedule
  must("liquid", {"--resume", "o", "--until", "0.07", "--steps", "12", "--set", "output.every=0"});
  EXPECT_EQ(read_collection(here() / "o/fluid.pvd").size(), kept);
  must("liquid", {"--resume", "o", "--until", "0.12", "--set", "output.every=0.03"});
  const auto frames = read_collection(here() / "o/fluid.pvd");
  ASSERT_GT(frames.size(), kept + 1);
  EXPECT_NEAR(frames.back().time, 0.12, 1e-12);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    EXPECT_EQ(frames[f].file, fmt::format("frames/fluid_{:06}.vtu", f));
    EXPECT_TRUE(fs::exists(here() / "o" / frames[f].file));
    const double every = f < kept ? 0.01 : 0.03;
    EXPECT_NEAR(std::remainder(frames[f].time, every), 0, 1e-9) << f;
  }
  EXPECT_EQ(read_table(here() / "o/stats.csv").rows.size(), static_cast<std::size_t>(checkpoint_step(newest("o"))));
}

TEST_F(Restart, AFailingRunNamesTheLastCheckpoint) {
  must("liquid", {"-o", "o", "--until", "0.03"});
  Checkpoint c = read_checkpoint(newest("o"));
  c.state.fluid_velocity.at(3)[1] = std::nan("");
  write_checkpoint(newest("o"), c);
  const Outcome o = run("liquid", {"--resume", "o", "--until", "0.05"});
  expect_refusal(o, "the run failed in stage ", 1);
  EXPECT_NE(o.err.find("; see o/failure.vtu; the last checkpoint is o/checkpoint_"), std::string::npos) << o.err;
  must("liquid", {"--resume", checkpoints_in(here() / "o").at(1).string(), "--until", "0.05"});
  must("liquid", {"-o", "whole", "--until", "0.05"});
  EXPECT_EQ(difference(here() / "whole", here() / "o"), "");
}

TEST_F(Restart, CtrlCLeavesACheckpointWithoutBeingAskedForAny) {
  const auto rows = [&] { return read_table(here() / "o/stats.csv").rows.size(); };
  const Words words{"run", "liquid.yaml", "-o", "o", "--until", "0.6"};
  const Outcome stopped = run_drench(here(), words, [&] { return rows() >= 5; });
  ASSERT_EQ(stopped.code, 130) << stopped.out << stopped.err;
  EXPECT_NE(stopped.out.find("to continue: drench run liquid.yaml --resume o\n"), std::string::npos) << stopped.out;
  ASSERT_EQ(checkpoints_in(here() / "o").size(), 1U);
  EXPECT_EQ(checkpoint_step(newest("o")), static_cast<std::int64_t>(rows()));
  for (const Words& more : {Words{"--resume", "o"}, Words{"-o", "whole"}}) {
    Words all{"run", "liquid.yaml", "--until", "0.6", "--quiet"};
    all.insert(all.end(), more.begin(), more.end());
    ASSERT_EQ(run_drench(here(), all).code, 0);
  }
  EXPECT_EQ(difference(here() / "whole", here() / "o", false), "");
}

TEST_F(Restart, OtherRunsAreRefusedWithTheDifference) {
  must("filter", {"-o", "o", "--until", "0.02"});
  const auto before = results_in(here() / "o");
  const auto resumed = [&](Words more) {
    more.insert(more.begin(), {"--resume", "o", "--until", "0.02"});
    return run("filter", more);
  };
  expect_refusal(resumed({"--set", "fluid.viscosity=2.0e-6"}),
                 ".drench: is of another scene: fluid.viscosity was 1e-06, "
                 "is 2e-06; only time.end, output.every, "
                 "output.checkpoint_every, output.report may change");
  expect_refusal(resumed({"--set", "cloth.0.porous.diffusivity=0.5"}), "cloth.0.porous.diffusivity was 0.001, is 0.5");
  expect_refusal(resumed({"--set", "fluid.sources.1.block.min=[3, 2.98, 3]"}),
                 "fluid.sources.1.block.min was [3, 3, 3], is [3, 2.98, 3]");
  expect_refusal(resumed({"--set", "bodies=[{sphere: {center: [1, 1, 1], radius: 0.1}}]"}),
                 "bodies.0.sphere.center was not given and is");
  expect_refusal(resumed({"--set", "output.measures=false"}), "output.measures was true, is false");
  expect_refusal(resumed({"--backend", "reference"}), "o/checkpoint_");
  expect_refusal(run("liquid", {"--resume", "o"}), "is of another scene: ");
  expect_refusal(run("filter", {"--resume", "nowhere"}), "nowhere: cannot be read: No such file");
  expect_refusal(run("filter", {"--resume", "filter.yaml"}), "filter.yaml: is not a checkpoint of drench");
  fs::create_directory(here() / "empty");
  expect_refusal(run("filter", {"--resume", "empty"}), "empty: holds no checkpoint");
  EXPECT_EQ(results_in(here() / "o"), before);
}

TEST_F(Restart, DamagedCheckpointsAreRefusedAndTheOneBeforeIsTaken) {
  must("liquid", {"-o", "whole", "--until", "0.05"});
  const std::string text = read_text(newest("whole"));
  std::string flipped = text;
  flipped[text.size() / 2] = static_cast<char>(flipped[text.size() / 2] ^ 4);
  for (const std::string& bad : {flipped, text.substr(0, text.size() - 9), text.substr(0, 22), text + "x"}) {
    const fs::path folder = here() / "damaged";
    fs::remove_all(folder);
    fs::copy(here() / "whole", folder, fs::copy_options::recursive);
    const fs::path damaged = newest("damaged");
    write_text(damaged, bad);
    expect_refusal(run("liquid", {"--resume", damaged.string(), "--until", "0.05"}), "is damaged: ");
    const Outcome o = run_drench(here(), {"run", "liquid.yaml", "--set", "output.checkpoint_every=0.01", "--resume",
                                          "damaged", "--until", "0.05"});
    EXPECT_EQ(o.code, 0) << o.err;
    EXPECT_NE(o.err.find("; continuing from the previous one\n"), std::string::npos) << o.err;
    EXPECT_EQ(difference(here() / "whole", folder), "");
  }
  // As after a loss of power: the checkpoint is there, what was written just before it is not.
  for (const fs::path& lost : {fs::path("stats.csv"), fs::path("frames/fluid_000004.vtu")}) {
    const fs::path folder = here() / "lost";
    fs::remove_all(folder);
    fs::copy(here() / "whole", folder, fs::copy_options::recursive);
    if (lost == "stats.csv")
      fs::resize_file(folder / lost, fs::file_size(folder / lost) - 20);
    else
      fs::remove(folder / "frames/fluid_000005.vtu");
    must("liquid", {"--resume", "lost", "--until", "0.05"});
    EXPECT_EQ(difference(here() / "whole", folder), "") << lost;
  }
}

/// kill -9 again and again, a random number of steps after each start and a random time more, so that it hits anything
/// from the set-up to the writing of files. DRENCH_KILLS: how often (CI: 8).
TEST_F(Restart, KillsAtRandomMomentsLoseAtMostAnInterval) {
  const int wanted = std::atoi(from_environment("DRENCH_KILLS", "8").c_str());
  const double interval = 0.01, step = 0.003;  // s
  const fs::path out = here() / "o";
  must("porous", {"-o", "whole", "--until", "0.09"});
  std::mt19937 random(7);
  int kills = 0, ended = 0, from_scratch = 0;
  while (kills < wanted || fs::exists(out)) {
    const auto kept = fs::is_directory(out) ? checkpoints_in(out) : std::vector<fs::path>();
    if (kept.empty()) fs::remove_all(out);
    from_scratch += kept.empty();
    const std::size_t from = kept.empty() ? 0 : static_cast<std::size_t>(checkpoint_step(kept[0]));
    const std::size_t rows = from + std::uniform_int_distribution<std::size_t>(0, 12)(random);
    const auto more = std::chrono::microseconds(std::uniform_int_distribution<>(0, 100000)(random));
    std::optional<std::chrono::steady_clock::time_point> reached;
    const auto now_or_never = [&] {
      if (kills >= wanted) return false;
      const auto now = std::chrono::steady_clock::now();
      if (!reached && (rows == from || read_table(out / "stats.csv").rows.size() >= rows)) reached = now;
      return reached && now >= *reached + more;
    };
    const Outcome o = run_drench(here(), words("porous", {kept.empty() ? "-o" : "--resume", "o", "--until", "0.09"}),
                                 now_or_never, SIGKILL);
    if (o.code == 0) {
      ++ended;
      ASSERT_EQ(difference(here() / "whole", out), "") << "after " << kills << " kills";
      fs::remove_all(out);
      continue;
    }
    ASSERT_EQ(o.code, 1000 + SIGKILL) << o.err;
    ++kills;
    const Table stats = read_table(out / "stats.csv");
    if (stats.rows.size() < 2) continue;
    const auto left = checkpoints_in(out);
    const double done = stats.number(stats.rows.size() - 2, "time"),  // the last row may be half a one
        safe = left.empty() ? 0 : stats.number(static_cast<std::size_t>(checkpoint_step(left[0]) - 1), "time");
    EXPECT_LE(done - safe, interval + step);
  }
  std::printf("%d kills, %d runs to the end, %d starts without a checkpoint\n", kills, ended, from_scratch);
}

TEST_F(Restart, ADiskThatIsFullStopsTheRunAndKeepsWhatIsThere) {
  must("porous", {"-o", "o", "--until", "0.03"});
  must("porous", {"-o", "whole", "--until", "0.06"});
  const auto size = fs::file_size(newest("o"));
  // Frames are shorter than checkpoints: of those the next one does not fit, as fresh particles and the jet make it
  // longer.
  const Outcome full =
      run_drench(here(), words("porous", {"--resume", "o", "--until", "0.06"}), nullptr, SIGINT, size + 100);
  expect_refusal(full, ".drench: cannot be written: File too large; the last checkpoint is o/checkpoint_", 1);
  EXPECT_EQ(fs::file_size(newest("o")), size) << "the last one is whole";
  for (const std::string& name : names_in(here() / "o")) EXPECT_FALSE(name.ends_with(".part")) << name;
  must("porous", {"--resume", "o", "--until", "0.06"});
  EXPECT_EQ(difference(here() / "whole", here() / "o"), "");
}

TEST_F(Restart, NoWriterOutlivesAFullDisk) {
  for (const rlim_t longest : {100, 1000, 3000, 6000, 9000, 12000, 20000}) {
    SCOPED_TRACE(longest);
    fs::remove_all(here() / "o");
    const Outcome o = run_drench(here(), words("liquid", {"-o", "o", "--until", "0.09"}), nullptr, SIGINT, longest);
    expect_refusal(o, " cannot be written", 1);
    for (const std::string& name : names_in(here() / "o")) EXPECT_FALSE(name.ends_with(".part")) << name;
  }
  // Unwritable folders, for root too.
  expect_refusal(run("liquid", {"-o", "liquid.yaml/o"}), "liquid.yaml/o: cannot be made: Not a directory");
  expect_refusal(run("liquid", {"-o", "/proc/o"}), "/proc/o: cannot be made");
}

TEST_F(Restart, TwoRunsDoNotWriteToOneFolder) {
  Outcome second;
  const auto once_it_runs = [&] {
    if (!fs::is_directory(here() / "o") || checkpoints_in(here() / "o").empty()) return false;
    second = run("liquid", {"--resume", "o", "--until", "100"});
    return true;
  };
  const Outcome first = run_drench(here(), words("liquid", {"-o", "o", "--until", "100"}), once_it_runs);
  EXPECT_EQ(first.code, 130) << first.err;
  expect_refusal(second, "o: another run of drench is writing there");
}

}  // namespace
}  // namespace drench::test
