// Signals within long steps: the program ends soon, with a checkpoint of the last complete step.

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>

#include "base/stop_request.hpp"
#include "output/checkpoint.hpp"
#include "restart_scenes.hpp"
#include "run_results.hpp"

namespace drench::test {
namespace {

using Clock = std::chrono::steady_clock;

class Stop : public ::testing::Test {
 protected:
  Stop() { write_text(here() / "liquid.yaml", liquid_scene); }
  const fs::path& here() const { return folder_.path(); }
  /// Every solve takes so many iterations.
  static std::vector<std::string> words(const std::string& iterations, const std::vector<std::string>& more) {
    std::vector<std::string> all{"run",
                                 "liquid.yaml",
                                 "--quiet",
                                 "--threads",
                                 "1",
                                 "--set",
                                 "output.checkpoint_every=0.01",
                                 "--set",
                                 "fluid.solver.max_iterations=" + iterations,
                                 "--set",
                                 "fluid.solver.min_iterations=" + iterations};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  std::size_t steps_in(const char* folder) const {
    return fs::exists(here() / folder / "stats.csv") ? read_table(here() / folder / "stats.csv").rows.size() : 0;
  }

 private:
  TempFolder folder_;
};

TEST_F(Stop, OnlyAStoppableStepIsGivenUp) {
  forget_stop_request();
  EXPECT_NO_THROW(stop_if_requested());
  request_stop();
  EXPECT_NO_THROW(stop_if_requested());
  {
    const StoppableStep step(true);
    EXPECT_THROW(stop_if_requested(), StepStopped);
  }
  {
    const StoppableStep step(false);
    EXPECT_NO_THROW(stop_if_requested());
  }
  forget_stop_request();
  const StoppableStep step(true);
  EXPECT_NO_THROW(stop_if_requested());
}

/// The first step would take many seconds; it is given up, and the run goes on from its beginning.
TEST_F(Stop, EndsWithinTheFirstStep) {
  Clock::time_point sent;
  const Outcome o = run_drench(
      here(), words("100000", {"-o", "o"}),
      [&] {
        if (!fs::exists(here() / "o/fluid.pvd")) return false;
        if (sent == Clock::time_point{}) sent = Clock::now();
        return Clock::now() - sent > std::chrono::milliseconds(200);
      },
      SIGTERM);
  EXPECT_EQ(o.code, 130) << o.err;
  EXPECT_LT(std::chrono::duration<double>(Clock::now() - sent).count(), 2.5) << "of a step of more than 5 s";
  EXPECT_EQ(steps_in("o"), 0U);
  ASSERT_EQ(checkpoints_in(here() / "o").size(), 1U);
  EXPECT_EQ(checkpoint_step(checkpoints_in(here() / "o").front()), 0);
}

TEST_F(Stop, GoesOnFromTheLastCompleteStep) {
  const std::string iterations = "6000";
  ASSERT_EQ(run_drench(here(), words(iterations, {"-o", "whole", "--until", "0.012"})).code, 0);
  const Outcome o = run_drench(
      here(), words(iterations, {"-o", "part", "--until", "0.012"}), [&] { return steps_in("part") >= 2; }, SIGTERM);
  ASSERT_EQ(o.code, 130) << o.err;
  ASSERT_EQ(run_drench(here(), words(iterations, {"--resume", "part", "--until", "0.012"})).code, 0);
  EXPECT_EQ(difference(here() / "whole", here() / "part"), "");
}

/// A terminal that closes ends a run as Ctrl-C does, with an answer; under nohup the run goes on.
TEST_F(Stop, SavesACheckpointWhenTheTerminalCloses) {
  const std::vector<std::string> run{
      "run", "liquid.yaml", "--threads", "1", "--until", "0.1", "--set", "output.checkpoint_every=0.01", "-o"};
  const auto into = [&](const char* folder) {
    auto all = run;
    all.emplace_back(folder);
    return all;
  };
  const Outcome o = run_drench(
      here(), into("o"), [&] { return steps_in("o") >= 2; }, SIGHUP);
  EXPECT_EQ(o.code, 130) << o.err;
  EXPECT_NE(o.err.find("drench: stopping"), std::string::npos) << o.err;
  EXPECT_FALSE(checkpoints_in(here() / "o").empty());
  const auto before = std::signal(SIGHUP, SIG_IGN);
  const Outcome ignored = run_drench(
      here(), into("ignored"), [&] { return steps_in("ignored") >= 2; }, SIGHUP);
  std::signal(SIGHUP, before);
  EXPECT_EQ(ignored.code, 0) << ignored.err;
}

}  // namespace
}  // namespace drench::test
