// Runs that go wrong: each is made to by a checkpoint whose state is bad, or by a scene that cannot go well, and has to
// end with one line that says where, when, who, why and what to change, and to keep what was computed.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <regex>
#include <set>
#include <thread>

#include "commands_fixture.hpp"
#include "frame_reader.hpp"
#include "output/checkpoint.hpp"

namespace drench::test {
namespace {

using Words = std::vector<std::string>;

/// A cube of water on a floor, a pinned and a free sheet high above it, and a ball that falls beside.
constexpr const char* healthy_scene = R"(drench: 1
time: {step: 0.002, end: 0.06}
domain: {min: [-0.3, -0.1, -0.3], max: [0.3, 0.6, 0.3]}
output: {every: 0.01, checkpoint_every: 0.01}
fluid:
  spacing: 0.02
  sources: [{block: {min: [-0.05, 0, -0.05], max: [0.05, 0.1, 0.05]}}]
cloth:
  - name: pinned
    mesh: {grid: {size: [0.2, 0.2], nodes: [9, 9]}}
    place: {position: [0, 0.3, 0]}
    pin: [{corners: true}]
  - name: free
    mesh: {grid: {size: [0.1, 0.1], nodes: [5, 5]}}
    place: {position: [0, 0.5, 0]}
bodies:
  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}
  - sphere: {center: [0.2, 0.3, 0], radius: 0.04, dynamic: true}
)";

class Failure : public testing::Test {
 protected:
  Failure() { write_text(here() / "scene.yaml", healthy_scene); }
  const fs::path& here() const { return folder_.path(); }
  Outcome run(Words more) const {
    more.insert(more.begin(), {"run", "scene.yaml", "--quiet"});
    return run_drench(here(), more);
  }
  /// Goes on, in the folder "o", from its newest checkpoint after `edit` has touched the state there.
  template <class Edit>
  Outcome run_from(Edit&& edit, const Words& more = {}, const std::function<bool()>& when = nullptr) {
    if (!fs::exists(here() / "o")) {
      const Outcome before = run({"-o", "o", "--until", "0.02"});
      EXPECT_EQ(before.code, 0) << before.err;
    }
    const fs::path newest = checkpoints_in(here() / "o").at(0);
    Checkpoint c = read_checkpoint(newest);
    edit(c.state);
    state_ = c.state;
    write_checkpoint(newest, c);
    Words words{"run", "scene.yaml", "--quiet", "--resume", "o", "--until", "0.06"};
    words.insert(words.end(), more.begin(), more.end());
    return run_drench(here(), words, when);
  }
  /// One line with all these parts, exit code 1, and everything of before still there.
  void expect_failure(const Outcome& o, const Words& parts, bool on_disk = true) const {
    EXPECT_EQ(o.code, 1) << o.out << o.err;
    EXPECT_EQ(o.out, "");
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_EQ(o.err.find("drench: the run failed in stage "), 0U) << o.err;
    for (const std::string& part : parts) EXPECT_NE(o.err.find(part), std::string::npos) << part << "\n" << o.err;
    if (!on_disk) return;
    const fs::path out = here() / "o";
    EXPECT_NE(o.err.find("; the last checkpoint is o/checkpoint_"), std::string::npos) << o.err;
    EXPECT_NE(read_text(out / "run.log").find(o.err.substr(0, o.err.size() - 1)), std::string::npos);
    EXPECT_EQ(read_table(out / "stats.csv").rows.size(), 10U) << "the steps of before";
    for (const char* series : {"fluid", "cloth", "bodies"}) {
      const auto frames = read_collection(out / fmt::format("{}.pvd", series));
      EXPECT_GE(frames.size(), 3U) << series;
      for (const auto& frame : frames) EXPECT_GT(read_frame(out / frame.file)->GetNumberOfPoints(), 0);
    }
    EXPECT_EQ(read_checkpoint(checkpoints_in(out).at(0)).state.step, 10);
  }
  struct Offender {
    int kind;
    std::int64_t id;
    auto operator<=>(const Offender&) const = default;
  };
  std::set<Offender> offenders() const {
    const auto grid = read_frame(here() / "o/failure.vtu");
    EXPECT_EQ(point_fields(grid), (Words{"id", "kind", "mass", "position", "velocity"}));
    std::set<Offender> found;
    for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i)
      found.insert({static_cast<int>(field(grid, "kind", i)), static_cast<std::int64_t>(field(grid, "id", i))});
    return found;
  }
  std::string log() const { return read_text(here() / "o/run.log"); }
  Index free_node() const { return 81; }  // the first of the free sheet

  HostState state_;  // that run_from began with

 private:
  TempFolder folder_;
};

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST_F(Failure, AHealthyRunSaysNothing) {
  const Outcome o = run({"-o", "o"});
  EXPECT_EQ(o.code, 0);
  EXPECT_EQ(o.out + o.err, "");
  EXPECT_EQ(log().find("warning"), std::string::npos) << log();
  for (const char* words : {"passed through", "left the domain", "inside solids"})
    EXPECT_EQ(log().find(words), std::string::npos) << log();
  EXPECT_FALSE(fs::exists(here() / "o/failure.vtu"));
}

TEST_F(Failure, WhatIsNotFinite) {
  struct Case {
    std::function<void(HostState&)> edit;
    Words parts;
    int kind;
  };
  const auto node = static_cast<std::size_t>(free_node());
  const Case cases[] = {
      {[](HostState& s) { s.fluid_velocity.at(7)[1] = nan; },
       {" at step 10 (t = 0.02 s): ", "finite number", "; particles ", "halve time.step (0.002 s)",
        "; see o/failure.vtu; "},
       0},
      {[](HostState& s) {
         s.fluid_position.at(7) = {nan, nan, nan};
       },
       {" at step 10 (t = 0.02 s): ", "finite number", "; particles "},
       0},
      {[=](HostState& s) { s.node_velocity.at(node)[0] = nan; }, {"finite number", "nodes ", "halve time.step"}, 1},
      {[](HostState& s) { s.body_velocity.at(1)[2] = nan; }, {"not finite numbers", "bodies 1; "}, 2}};
  for (const Case& c : cases) {
    fs::remove_all(here() / "o");
    const Outcome o = run_from(c.edit);
    expect_failure(o, c.parts);
    const Offender offender{c.kind, c.kind == 0 ? state_.fluid_id.at(7) : c.kind == 1 ? free_node() : 1};
    EXPECT_TRUE(offenders().contains(offender)) << o.err;
    if (c.kind == 2) {
      EXPECT_EQ(offenders().size(), 1U) << o.err;
    }
  }
}

TEST_F(Failure, AParticleBeyondAllSpeeds) {
  const Outcome o = run_from([](HostState& s) {
    s.fluid_velocity.at(4) = {0, 0, 0};
    s.fluid_position.at(4) = {-0.28, 0.2, 0};
    s.fluid_velocity.at(4) = {200, 0, 0};  // 0.4 m a step: it is still in the domain after one
  });
  const std::int64_t id = state_.fluid_id.at(4);
  expect_failure(o, {"in stage ledger at step 10 (t = 0.02 s): the liquid moves at 200 m/s; in this scene nothing can "
                     "make it faster than",
                     fmt::format("; particles {}; the fastest particle, 200 m/s, moves 20 spacings per step: halve "
                                 "time.step (0.002 s) or set "
                                 "time.mode: cfl; see o/failure.vtu; ",
                                 id)});
  EXPECT_EQ(offenders(), (std::set<Offender>{{0, id}}));
}

TEST_F(Failure, AParticleBeyondAllSpeedsThatLeavesTheDomain) {
  const Outcome o = run_from([](HostState& s) {
    s.fluid_position.at(4) = {0, 0.3, 0.25};
    s.fluid_velocity.at(4) = {0, 0, 1e4};
  });
  expect_failure(o, {"in stage advection at step 10 (t = 0.02 s): liquid left the domain at 1e+04 m/s",
                     fmt::format("1 particles, ids {}; ", state_.fluid_id.at(4)), "halve time.step"});
  EXPECT_FALSE(fs::exists(here() / "o/failure.vtu")) << "it is gone";
}

TEST_F(Failure, ClothBeyondAllSpeeds) {
  const Outcome o = run_from([&](HostState& s) {
    for (std::size_t n = 81; n < s.node_velocity.size(); ++n) s.node_velocity[n] = {0, 0, 1e4};
  });
  expect_failure(o, {"in stage ledger at step 10 (t = 0.02 s): the cloth moves at ", "; nodes 81 82 83 ",
                     " and 17 more; ", "halve time.step"});
  const auto found = offenders();
  EXPECT_EQ(found.size(), 25U);
  EXPECT_TRUE(found.contains({1, 81}));
}

TEST_F(Failure, ClothTornApart) {
  const Outcome o = run_from([](HostState& s) { s.node_position.at(0)[0] -= 100; });  // a pin stays where it is
  expect_failure(o, {"in stage ledger at step 10 (t = 0.02 s): the cloth is stretched to ", "; nodes 0 "});
  EXPECT_TRUE(offenders().contains({1, 0})) << o.err;
}

TEST_F(Failure, LiquidThatCollapses) {
  write_text(here() / "piston.yaml", piston_scene);
  const Outcome o = run_drench(here(), {"run", "piston.yaml", "-o", "o", "--quiet"});
  expect_failure(o,
                 {"in stage pressure at step ", "the liquid collapses: its density is ",
                  " % too high on average, for 10 steps in a row; particles ",
                  "the density solve reached fluid.solver.max_iterations (10) with an error of ",
                  "raise the limit, or halve time.step", "; see o/failure.vtu"},
                 false);
  const auto grid = read_frame(here() / "o/failure.vtu");
  EXPECT_GT(grid->GetNumberOfPoints(), 10);
  const auto frames = read_collection(here() / "o/fluid.pvd");
  EXPECT_GE(frames.size(), 2U);
  for (const auto& frame : frames) EXPECT_EQ(read_frame(here() / "o" / frame.file)->GetNumberOfPoints(), 360);
}

TEST_F(Failure, WithoutOutputTheLineIsAllThereIs) {
  const Outcome before = run({"-o", "o", "--until", "0.02"});
  ASSERT_EQ(before.code, 0) << before.err;
  const auto names = names_in(here());
  const Outcome o = run_from([](HostState& s) { s.fluid_velocity.at(7)[1] = nan; }, {"--no-output"});
  expect_failure(o, {"finite number", "; particles "}, false);
  EXPECT_EQ(o.err.find("failure.vtu"), std::string::npos) << o.err;
  EXPECT_EQ(o.err.find("checkpoint"), std::string::npos) << o.err;
  EXPECT_EQ(names_in(here()), names);
  EXPECT_FALSE(fs::exists(here() / "o/failure.vtu"));
}

TEST_F(Failure, OverwriteRemovesAnOldFailure) {
  run_from([](HostState& s) { s.fluid_velocity.at(7)[1] = nan; });
  ASSERT_TRUE(fs::exists(here() / "o/failure.vtu"));
  const Outcome o = run({"-o", "o", "--overwrite", "--steps", "1"});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_FALSE(fs::exists(here() / "o/failure.vtu"));
}

/// The log is a pipe too small for what is said, so that the failure lasts until somebody reads: the signal comes
/// before.
TEST_F(Failure, CtrlCDuringAFailureIsStillAFailure) {
  std::string deep = std::string(200, 'd');
  for (int k = 1; k < 8; ++k) deep += "/" + std::string(200, 'd');  // named three times: more than the pipe holds
  ASSERT_EQ(run({"-o", deep, "--until", "0.02"}).code, 0);
  const fs::path out = here() / deep, log = out / "run.log", newest = checkpoints_in(out).at(0);
  Checkpoint c = read_checkpoint(newest);
  c.state.fluid_velocity.at(7)[1] = nan;
  write_checkpoint(newest, c);
  fs::remove(log);
  ASSERT_EQ(mkfifo(log.c_str(), 0600), 0);
  std::atomic<bool> sent = false;
  std::string said;
  std::thread reader([&] {
    const int file = open(log.c_str(), O_RDONLY);
    EXPECT_EQ(fcntl(file, F_SETPIPE_SZ, 4096), 4096);
    while (!sent) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    char bytes[4096];
    for (ssize_t n = 0; (n = read(file, bytes, sizeof bytes)) > 0;) said.append(bytes, static_cast<std::size_t>(n));
    close(file);
  });
  const Outcome o = run_drench(here(), {"run", "scene.yaml", "--quiet", "--resume", deep, "--until", "0.06"}, [&] {
    sent = fs::exists(out / "failure.vtu");  // written just before the line
    return sent.load();
  });
  sent = true;
  reader.join();
  expect_failure(o, {"finite number", "; particles ", "; see " + deep + "/failure.vtu; "}, false);
  EXPECT_GT(said.size(), 4096U);
  EXPECT_NE(said.find(o.err.substr(0, o.err.size() - 1)), std::string::npos) << said;
}

/// A folder in the place of the temporary file: the picture cannot be written, and that is not why the run failed.
TEST_F(Failure, WithoutAPictureTheLineIsStillTheFailure) {
  ASSERT_EQ(run({"-o", "o", "--until", "0.02"}).code, 0);
  fs::create_directory(here() / "o/.failure.vtu.part");
  const Outcome o = run_from([](HostState& s) { s.fluid_velocity.at(7)[1] = nan; });
  expect_failure(o, {"finite number", "; particles ", "; o/failure.vtu: cannot be written: "});
  EXPECT_EQ(o.err.find("; see "), std::string::npos) << o.err;
}

TEST_F(Failure, LiquidThatIsGoneAtOnceIsAWarning) {
  const Outcome o = run_from([](HostState& s) {
    for (Vec3& v : s.fluid_velocity) v = {90, 0, 0};
  });
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(log().find("warning: step 12 (t = 0.024 s): 125 particles left the domain at once, more than a quarter of "
                       "all: ids 0 1 2 3 4 5 6 7 …"),
            std::string::npos)
      << log();
  EXPECT_NE(log().find("  125 particles left the domain in steps that lost over a quarter of all"), std::string::npos)
      << log();
}

/// Out of the slab means into the tower, and out of the tower means into the slab.
TEST_F(Failure, AParticleThatTwoSolidsHoldIsAWarning) {
  write_text(here() / "scene.yaml", std::string(healthy_scene) +
                                        "  - box: {min: [-0.29, 0.1, 0.1], max: [-0.05, 0.3, 0.29]}\n"
                                        "  - box: {min: [-0.27, 0.24, 0.12], max: [-0.07, 0.55, 0.27]}\n");
  const Outcome o = run_from([](HostState& s) {
    s.fluid_position.at(9) = {-0.17, 0.27, 0.195};
    s.fluid_velocity.at(9) = {0, 0, 0};
  });
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(
      log().find(fmt::format("warning: t = 0.03 s: 1 particles are inside solids or outside of containers: ids {}",
                             state_.fluid_id.at(9))),
      std::string::npos)
      << log();
  EXPECT_NE(log().find("  particles were inside solids or outside of containers in 4 frames"), std::string::npos)
      << log();
}

/// Jaws that overlap leave the cloth between them no place.
TEST_F(Failure, SolidsThatOverlapWithClothBetweenThemAreNamed) {
  write_text(here() / "scene.yaml", std::string(healthy_scene) + R"(  - name: lower
    box: {min: [-0.04, 0.2, -0.04], max: [0.04, 0.31, 0.04]}
  - box: {min: [-0.04, 0.29, -0.04], max: [0.04, 0.4, 0.04]}
)");
  const Outcome o = run_from([](HostState&) {});
  EXPECT_EQ(o.code, 0) << o.err;
  const std::string line =
      "warning: t = 0.03 s: cloth 'pinned': 9 nodes are inside solids, up to 0.01 m deep; body 'lower' and "
      "bodies.3 overlap by 0.02 m at (";
  EXPECT_NE(log().find(line), std::string::npos) << log();
  EXPECT_NE(log().find("): leave room for the cloth between them"), std::string::npos) << log();
}

/// A cloth that is thrown: what the scene itself drives is no runaway.
TEST_F(Failure, ThrownClothIsWithinTheLimits) {
  write_text(here() / "thrown.yaml", R"(drench: 1
time: {step: 0.004, end: 1}
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [101, 101]}}
    velocity: [10, 0, 0]
)");
  const Outcome o = run_drench(here(), {"run", "thrown.yaml", "--steps", "2", "--no-output"});
  EXPECT_EQ(o.code, 0) << o.err;
}

/// Two sheets without self-collision meet within a step, with a particle between them.
TEST_F(Failure, AParticleThatGoesThroughClothIsAWarning) {
  const Outcome o = run_from([](HostState& s) {
    for (std::size_t n = 0; n < s.node_position.size(); ++n) {
      s.node_position[n][1] = n < 81 ? 0.3 : 0.32;
      if (n >= 81) s.node_velocity[n] = {0, -30, 0};  // 0.06 m a step
    }
    s.fluid_position.at(5) = {0.003, 0.31, 0.004};
    s.fluid_velocity.at(5) = {0, 0, 0};
  });
  EXPECT_EQ(o.code, 0) << o.err;
  const std::regex line(
      fmt::format("warning: step 1\\d \\(t = 0.02\\d* s\\): 1 particle passed through intact cloth, the first "
                  "with id {}\n",
                  state_.fluid_id.at(5)));
  EXPECT_TRUE(std::regex_search(log(), line)) << log();
  EXPECT_NE(log().find("  particles passed through intact cloth "), std::string::npos) << log();
}

/// A box rises through a sheet that does not give way, and takes the liquid between them along.
TEST_F(Failure, ABodyThatPushesLiquidThroughClothIsAWarning) {
  write_text(here() / "press.yaml", R"(drench: 1
time: {step: 0.004, end: 0.06}
domain: {min: [-0.3, -0.3, -0.3], max: [0.3, 0.6, 0.3]}
fluid:
  spacing: 0.02
  sources: [{block: {min: [-0.04, 0.02, -0.04], max: [0.04, 0.06, 0.04]}}]
cloth:
  - mesh: {grid: {size: [0.3, 0.3], nodes: [9, 9]}}
    place: {position: [0, 0.07, 0]}
    dynamics: false
bodies:
  - box: {min: [-0.1, -0.2, -0.1], max: [0.1, 0.01, 0.1], velocity: [0, 4, 0]}
)");
  const Outcome o = run_drench(here(), {"run", "press.yaml", "-o", "o", "--quiet"});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(log().find(" passed through intact cloth, the first with id "), std::string::npos) << log();
}

TEST_F(Failure, AFolderWithNothingButTheFirstFileUnfinishedIsOverwritten) {
  fs::create_directory(here() / "o");
  write_text(here() / "o/.scene.yaml.part", "# drench out");
  EXPECT_EQ(run({"-o", "o", "--steps", "1"}).code, 2) << "only when asked to";
  write_text(here() / "o/notes.txt", "mine");
  EXPECT_EQ(run({"-o", "o", "--steps", "1", "--overwrite"}).code, 2);
  EXPECT_EQ(names_in(here() / "o"), (Words{".scene.yaml.part", "notes.txt"}));
  fs::remove(here() / "o/notes.txt");
  const Outcome o = run({"-o", "o", "--steps", "1", "--overwrite"});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_FALSE(fs::exists(here() / "o/.scene.yaml.part"));
  EXPECT_TRUE(fs::exists(here() / "o/stats.csv"));
}

}  // namespace
}  // namespace drench::test
