// The pipeline on a backend that computes nothing: order of stages, length of steps, and when a run is stopped.

#include "pipeline/pipeline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace drench::test {
namespace {

/// Records what it is asked to run; its ledger reports what the test put in.
struct RecordingBackend : Backend {
  std::vector<Stage> ran;
  std::vector<StepInfo> infos;
  StepReport ledger;
  double dt_wanted = 0.01;
  double divergence_error = 0;
  HostState state;

  std::string name() const override { return "recording"; }
  std::string description() const override { return "none"; }
  void upload(const HostState& s) override { state = s; }
  void run(Stage stage, const StepInfo& info, StepReport& report) override {
    ran.push_back(stage);
    infos.push_back(info);
    if (stage == Stage::time_step) report.dt_wanted = dt_wanted;
    if (stage == Stage::divergence) report.divergence_error = divergence_error;
    if (stage == Stage::ledger) {
      report.nonfinite = ledger.nonfinite;
      report.mass_fluid = ledger.mass_fluid;
      report.mass_drained = ledger.mass_drained;
      report.mass_supplied = ledger.mass_supplied;
    }
  }
  void fence() override {}
  HostState download() const override { return state; }
  std::vector<std::pair<Index, Index>> neighbor_pairs(const std::string&) const override { return {}; }
};

struct PipelineTest : testing::Test {
  Model model;
  RecordingBackend backend;
  HostState initial;
  PipelineTest() {
    model.scene.time.step = 0.01;
    model.scene.fluid.present = true;
    initial.fluid_mass = {100, 50};
    initial.drained = 7;
    initial.supplied = 3;
    backend.ledger.mass_fluid = 140;
    backend.ledger.mass_drained = 17;
    backend.ledger.mass_supplied = 3;
  }
  double step_for(double wanted, double left) {
    backend.dt_wanted = wanted;
    Pipeline pipeline(model, backend, initial);
    pipeline.step(left);
    EXPECT_EQ(backend.infos.back().dt, pipeline.last_dt());
    EXPECT_EQ(pipeline.time(), pipeline.last_dt());
    return pipeline.last_dt();
  }
};

TEST_F(PipelineTest, RunsTheStagesOfTheSceneInOrder) {
  Pipeline pipeline(model, backend, initial);
  pipeline.step(1);
  EXPECT_EQ(backend.ran, pipeline.stages());
  EXPECT_EQ(backend.ran, (std::vector<Stage>{Stage::time_step, Stage::neighbors, Stage::density, Stage::divergence,
                                             Stage::forces, Stage::pressure, Stage::advection, Stage::ledger}));
  EXPECT_EQ(pipeline.step_index(), 1);
  EXPECT_EQ(pipeline.initial_total(), 154);
}

TEST_F(PipelineTest, AStillPorousClothNeedsNoClothSolverAndNoFluid) {
  model.scene.fluid.present = false;
  model.cloths.push_back({.name = "sheet", .dynamics = false, .porous = true});
  EXPECT_EQ(stages_for(model),
            (std::vector<Stage>{Stage::time_step, Stage::porous_neighbors, Stage::diffusion, Stage::ledger}));
}

TEST_F(PipelineTest, AProcessThatIsOffHasNoStage) {
  model.cloths.push_back({.name = "sheet", .dynamics = false, .porous = true});
  const auto porous = [&](ProcessScene processes) {
    model.scene.processes = processes;
    std::vector<Stage> stages = stages_for(model);
    std::erase_if(stages, [](Stage s) { return s < Stage::porous_neighbors || s == Stage::ledger; });
    return stages;
  };
  using enum Stage;
  EXPECT_EQ(porous({}), (std::vector{porous_neighbors, flow_direction, absorption, emission, diffusion}));
  EXPECT_EQ(porous({.direction = false}), (std::vector{porous_neighbors, absorption, emission, diffusion}));
  EXPECT_EQ(porous({.absorption = false}), (std::vector{porous_neighbors, flow_direction, emission, diffusion}));
  EXPECT_EQ(porous({.emission = false}), (std::vector{porous_neighbors, flow_direction, absorption, diffusion}));
  EXPECT_EQ(porous({.diffusion = false}), (std::vector{porous_neighbors, flow_direction, absorption, emission}));
  EXPECT_EQ(porous({.absorption = false, .emission = false}), (std::vector{porous_neighbors, diffusion}));
  EXPECT_EQ(porous({.absorption = false, .emission = false, .diffusion = false}), std::vector<Stage>{});
  model.scene.output.measures = true;
  EXPECT_EQ(porous({.absorption = false, .emission = false, .diffusion = false}), std::vector{measures});
}

TEST_F(PipelineTest, FixedStepsEndAtTheNextOutput) {
  EXPECT_EQ(step_for(0.01, 1), 0.01);
  EXPECT_EQ(step_for(0.01, 0.004), 0.004);
  EXPECT_EQ(step_for(0.01, 0.012), 0.01);
  EXPECT_EQ(step_for(0.01, 0.01 * (1 + 1e-12)), 0.01 * (1 + 1e-12)) << "no sliver is left by rounding";
}

TEST_F(PipelineTest, CflStepsAreSplitEvenlyBeforeAnOutput) {
  model.scene.time.mode = TimeMode::cfl;
  EXPECT_EQ(step_for(0.01, 0.012), 0.006);
  EXPECT_EQ(step_for(0.01, 0.016), 0.01);
  EXPECT_EQ(step_for(0.01, 0.009), 0.009);
}

TEST_F(PipelineTest, OneLostQuantumStopsTheRun) {
  backend.ledger.mass_fluid -= 1;
  Pipeline pipeline(model, backend, initial);
  try {
    pipeline.step(1);
    FAIL() << "not noticed";
  } catch (const RunFailure& failure) {
    EXPECT_EQ(failure.stage, Stage::ledger);
    EXPECT_EQ(failure.step, 0);
    EXPECT_NE(std::string(failure.what()).find("-1 quanta"), std::string::npos) << failure.what();
  }
}

TEST_F(PipelineTest, ParticlesThatAreNotFiniteStopTheRun) {
  backend.ledger.nonfinite = 2;
  Pipeline pipeline(model, backend, initial);
  EXPECT_THROW(pipeline.step(1), RunFailure);
}

TEST_F(PipelineTest, AStageWithANonFiniteErrorIsNamedAtOnce) {
  backend.divergence_error = std::nan("");
  Pipeline pipeline(model, backend, initial);
  try {
    pipeline.step(1);
    FAIL() << "not noticed";
  } catch (const RunFailure& failure) {
    EXPECT_EQ(failure.stage, Stage::divergence);
    EXPECT_EQ(backend.ran.back(), Stage::divergence);
  }
}

TEST_F(PipelineTest, AStepThatIsNotPositiveStopsTheRun) {
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    backend.dt_wanted = bad;
    Pipeline pipeline(model, backend, initial);
    EXPECT_THROW(pipeline.step(1), RunFailure) << bad;
  }
}

TEST_F(PipelineTest, AStepTakesAtLeastAsLongAsItsStages) {
  Pipeline pipeline(model, backend, initial);
  pipeline.step(1.0);
  double stages = 0;
  for (const double ms : pipeline.milliseconds()) stages += ms;
  EXPECT_GE(pipeline.step_milliseconds(), stages);
  EXPECT_GT(pipeline.step_milliseconds(), 0);
}

}  // namespace
}  // namespace drench::test
