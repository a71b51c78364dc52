// The pipeline on a backend that computes nothing: order of stages, length of steps, and when a run is stopped.

#include "pipeline/pipeline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <tuple>

namespace drench::test {
namespace {

/// Records what it is asked to run; its ledger reports what the test put in.
struct RecordingBackend : Backend {
  std::vector<Stage> ran;
  std::vector<StepInfo> infos;
  StepReport ledger;
  double dt_wanted = 0.01;
  double divergence_error = 0;
  std::function<double(double dt)> found = [](double) { return 0.0; };  // density_found after a step of that length
  int kept = 0, gone_back = 0;
  HostState state;

  std::string name() const override { return "recording"; }
  std::string description() const override { return "none"; }
  void upload(const HostState& s) override { state = s; }
  void run(Stage stage, const StepInfo& info, StepReport& report) override {
    ran.push_back(stage);
    infos.push_back(info);
    if (stage == Stage::time_step) report.dt_wanted = dt_wanted;
    if (stage == Stage::density) report.density_found = found(info.dt);
    if (stage == Stage::divergence) report.divergence_error = divergence_error;
    if (stage == Stage::pressure) {
      report.density_error = ledger.density_error;
      report.density_converged = ledger.density_converged;
    }
    if (stage == Stage::ledger) {
      report.fluid_speed = ledger.fluid_speed;
      report.cloth_speed = ledger.cloth_speed;
      report.cloth_stretch = ledger.cloth_stretch;
      report.nonfinite = ledger.nonfinite;
      report.mass_fluid = ledger.mass_fluid;
      report.mass_drained = ledger.mass_drained;
      report.mass_supplied = ledger.mass_supplied;
      report.mass_evaporated = ledger.mass_evaporated;
      report.solute_fluid = ledger.solute_fluid;
    }
  }
  void fence() override {}
  HostState download() const override { return state; }
  void keep() override { ++kept; }
  void go_back() override { ++gone_back; }
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
    initial.evaporated = 2;
    backend.ledger.mass_fluid = 140;
    backend.ledger.mass_drained = 17;
    backend.ledger.mass_supplied = 3;
    backend.ledger.mass_evaporated = 2;
  }
  RunFailure failure_of_a_step() {
    Pipeline pipeline(model, backend, initial);
    try {
      pipeline.step(1);
    } catch (const RunFailure& failure) {
      return failure;
    }
    throw std::logic_error("the step did not fail");
  }
  double step_for(double wanted, double left) {
    backend.dt_wanted = wanted;
    Pipeline pipeline(model, backend, initial);
    const StepReport report = pipeline.step(left);
    EXPECT_EQ(backend.infos.back().dt, report.dt);
    EXPECT_EQ(pipeline.time(), report.time);
    EXPECT_EQ(report.time, report.dt);
    EXPECT_EQ(report.step, pipeline.step_index());
    EXPECT_EQ(report.dt_wanted, wanted);
    return report.dt;
  }
};

TEST_F(PipelineTest, RunsTheStagesOfTheSceneInOrder) {
  Pipeline pipeline(model, backend, initial);
  pipeline.step(1);
  EXPECT_EQ(backend.ran, pipeline.stages());
  EXPECT_EQ(backend.ran, (std::vector<Stage>{Stage::time_step, Stage::neighbors, Stage::density, Stage::divergence,
                                             Stage::forces, Stage::pressure, Stage::advection, Stage::ledger}));
  EXPECT_EQ(pipeline.step_index(), 1);
  EXPECT_EQ(pipeline.initial_total(), 156);
}

TEST_F(PipelineTest, AStillPorousClothNeedsNoClothSolverAndNoFluid) {
  model.scene.fluid.present = false;
  model.cloths.emplace_back().porous = true;
  model.cloths.back().dynamics = false;
  EXPECT_EQ(stages_for(model),
            (std::vector<Stage>{Stage::time_step, Stage::porous_neighbors, Stage::diffusion, Stage::ledger}));
}

TEST_F(PipelineTest, AProcessThatIsOffHasNoStage) {
  model.cloths.emplace_back().porous = true;
  model.cloths.back().dynamics = false;
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
  model.cloths.back().conductance = 0.1;
  EXPECT_EQ(porous({}), (std::vector{porous_neighbors, flow_direction, permeation, absorption, emission, diffusion}));
  EXPECT_EQ(porous({.direction = false}), (std::vector{porous_neighbors, absorption, emission, diffusion}));
  EXPECT_EQ(porous({.emission = false}), (std::vector{porous_neighbors, flow_direction, absorption, diffusion}));
  model.scene.output.measures = true;
  EXPECT_EQ(porous({.absorption = false, .emission = false, .diffusion = false}), std::vector{measures});
  model.scene.output.fabric = true;
  EXPECT_EQ(porous({.absorption = false, .emission = false, .diffusion = false}), (std::vector{measures, fabric}));
}

TEST_F(PipelineTest, FixedStepsEndAtTheNextOutput) {
  EXPECT_EQ(step_for(0.01, 1), 0.01);
  EXPECT_EQ(step_for(0.01, 0.004), 0.004);
  EXPECT_EQ(step_for(0.01, 0.012), 0.01);
  EXPECT_EQ(step_for(0.01, 0.0109), 0.00545) << "no sliver is left by an output that nearly fits";
  EXPECT_EQ(step_for(0.01, 0.01 * (1 + 1e-12)), 0.01 * (1 + 1e-12)) << "no sliver is left by rounding";
}

TEST_F(PipelineTest, CflStepsAreSplitEvenlyBeforeAnOutput) {
  model.scene.time.mode = TimeMode::cfl;
  EXPECT_EQ(step_for(0.01, 0.012), 0.006);
  EXPECT_EQ(step_for(0.01, 0.016), 0.01);
  EXPECT_EQ(step_for(0.01, 0.009), 0.009);
}

/// Steps of mode error: `found` is asked for after each.
struct ErrorSteps : PipelineTest {
  ErrorSteps() {
    model.scene.time.mode = TimeMode::error;
    model.scene.time.tolerance = 1e-3;
  }
};

TEST_F(ErrorSteps, AStepThatLeavesTooMuchIsDoneAgainAtHalfItsLength) {
  backend.found = [](double dt) { return dt > 0.003 ? 2.6e-3 : 2.4e-3; };
  Pipeline pipeline(model, backend, initial);
  const StepReport report = pipeline.step(1);
  EXPECT_EQ(report.dt, 0.0025);
  EXPECT_EQ(report.rejected, 2);
  EXPECT_EQ(report.density_found, 2.4e-3);
  EXPECT_EQ(backend.kept, 1);
  EXPECT_EQ(backend.gone_back, 2);
  EXPECT_EQ(pipeline.time(), 0.0025);
  EXPECT_EQ(pipeline.step_index(), 1);
}

TEST_F(ErrorSteps, ItsLengthSettlesWhereItsOwnErrorIsTheAim) {
  backend.found = [](double dt) { return 50 * dt * dt; };  // ½ of 0.6e-3 at 2.45 ms
  Pipeline pipeline(model, backend, initial);
  double dt = 0;
  for (int k = 0; k < 30; ++k) dt = pipeline.step(1).dt;
  EXPECT_NEAR(dt, std::sqrt(0.3e-3 / 50), 1e-5);
  backend.found = [](double) { return 0.0; };
  for (int k = 0; k < 30; ++k) dt = pipeline.step(1).dt;
  EXPECT_EQ(dt, 0.01) << "no longer than time.step";
}

TEST_F(ErrorSteps, WhatTheSolveHasLeftDoesNotShortenSteps) {
  backend.ledger.density_error = 2e-2;  // as where liquid is crowded at the start
  backend.found = [](double) { return 2e-2; };
  Pipeline pipeline(model, backend, initial);
  for (int k = 0; k < 10; ++k) EXPECT_EQ(pipeline.step(1).dt, 0.01);
}

TEST_F(ErrorSteps, NoStepIsShorterThanAHundredth) {
  backend.found = [](double) { return 1.0; };
  Pipeline pipeline(model, backend, initial);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(pipeline.step(1).dt, 0.01 / 100) << "and it is taken as it is";
}

TEST_F(ErrorSteps, AStepThatFailsIsTriedAgain) {
  backend.ledger.fluid_speed = 1e9;
  EXPECT_EQ(failure_of_a_step().kind, FailureKind::fluid_speed);
  EXPECT_EQ(backend.gone_back, 7);
  backend.gone_back = 0;
  backend.ledger.mass_fluid -= 1;  // no length of a step is to blame
  EXPECT_EQ(failure_of_a_step().kind, FailureKind::mass);
  backend.ledger.mass_fluid += 1;
  backend.ledger.solute_fluid += 1;
  EXPECT_EQ(failure_of_a_step().kind, FailureKind::solute);
  EXPECT_EQ(backend.gone_back, 0);
}

TEST_F(ErrorSteps, ListsAndDensitiesThatAreThereAreNotMadeAgain) {
  Pipeline pipeline(model, backend, initial);
  pipeline.step(1);
  const auto first = backend.ran;
  backend.ran.clear();
  pipeline.step(1);
  EXPECT_EQ(first,
            (std::vector<Stage>{Stage::time_step, Stage::neighbors, Stage::density, Stage::divergence, Stage::forces,
                                Stage::pressure, Stage::advection, Stage::ledger, Stage::neighbors, Stage::density}));
  EXPECT_EQ(backend.ran, (std::vector<Stage>{Stage::time_step, Stage::divergence, Stage::forces, Stage::pressure,
                                             Stage::advection, Stage::ledger, Stage::neighbors, Stage::density}));
}

TEST_F(ErrorSteps, ARunThatGoesOnHasTheSameNextStep) {
  backend.found = [](double dt) { return 50 * dt * dt; };
  HostState half = initial;
  double next = 0;
  {
    Pipeline pipeline(model, backend, initial);
    for (int k = 0; k < 4; ++k) pipeline.step(1);
    pipeline.mark(half);
    next = pipeline.step(1).dt;
  }
  Pipeline pipeline(model, backend, half);
  EXPECT_EQ(pipeline.step(1).dt, next);
}

TEST_F(PipelineTest, OneLostQuantumStopsTheRun) {
  backend.ledger.mass_fluid -= 1;
  const RunFailure failure = failure_of_a_step();
  EXPECT_EQ(failure.stage, Stage::ledger);
  EXPECT_EQ(failure.info.step, 0);
  EXPECT_NE(std::string(failure.what()).find("-1 mass units"), std::string::npos) << failure.what();
}

TEST_F(PipelineTest, ParticlesThatAreNotFiniteStopTheRun) {
  backend.ledger.nonfinite = 2;
  Pipeline pipeline(model, backend, initial);
  EXPECT_THROW(pipeline.step(1), RunFailure);
}

TEST_F(PipelineTest, AStageWithANonFiniteErrorIsNamedAtOnce) {
  backend.divergence_error = std::nan("");
  EXPECT_EQ(failure_of_a_step().stage, Stage::divergence);
  EXPECT_EQ(backend.ran.back(), Stage::divergence);
}

TEST_F(PipelineTest, OnlyALastingCollapseStopsTheRun) {
  Pipeline pipeline(model, backend, initial);
  backend.ledger.density_error = 1.5;
  for (int k = 0; k < 30; ++k) {
    backend.ledger.density_converged = k % collapse_steps == 0;  // the solver catches up now and then
    ASSERT_NO_THROW(pipeline.step(1)) << k;
  }
  backend.ledger.density_converged = false;
  backend.ledger.density_error = 0.9;
  for (int k = 0; k < 30; ++k) ASSERT_NO_THROW(pipeline.step(1)) << k;
  backend.ledger.density_error = 1.5;
  for (int k = 1; k < collapse_steps; ++k) ASSERT_NO_THROW(pipeline.step(1)) << k;
  try {
    pipeline.step(1);
    FAIL() << "not noticed";
  } catch (const RunFailure& failure) {
    EXPECT_EQ(failure.kind, FailureKind::density);
    EXPECT_EQ(failure.stage, Stage::pressure);
    EXPECT_EQ(failure.info.step, 69);
  }
}

TEST_F(PipelineTest, ARunThatGoesOnStopsWhereItWouldHave) {
  backend.ledger.density_error = 1.5;
  backend.ledger.density_converged = false;
  HostState half = initial;
  {
    Pipeline pipeline(model, backend, initial);
    for (int k = 1; k < collapse_steps; ++k) ASSERT_NO_THROW(pipeline.step(1)) << k;
    pipeline.mark(half);
  }
  Pipeline pipeline(model, backend, half);
  EXPECT_THROW(pipeline.step(1), RunFailure);
}

TEST_F(PipelineTest, BoundsAreThoseOfTheirComment) {
  model.scene.gravity = {0, -10, 0};
  model.scene.domain = {{0, 0, 0}, {0, 5, 0}};
  model.spacing = 0.02;
  model.rest_density = 1000;
  model.jets.push_back({});
  model.jets[0].scene.velocity = {0, -3, 0};
  model.jets[0].area = std::numbers::pi * 0.01;
  model.mesh.solid_mass = {0.06, 0.04};
  model.mesh.edge_length = {0.05, 0.1};
  model.mesh.edge_stiffness = {400, 25};
  const Limits limits(model, 2);
  EXPECT_NEAR(limits.fluid_speed(0), 10 * (3 + 2), 1e-9) << "d/dt = 2 m/s";
  EXPECT_NEAR(limits.fluid_speed(0.5), 10 * (3 + 5 + 2), 1e-9);
  EXPECT_NEAR(limits.fluid_speed(50), 10 * (3 + 10 + 2), 1e-9) << "nothing falls farther than 5 m";
  EXPECT_NEAR(limits.cloth_speed(50), 10 * (3 + 500 + 10), 1e-9);
  const double brought = 1000 * std::numbers::pi * 0.01 * 3 * 0.5;  // kg, by the jet
  EXPECT_NEAR(limits.cloth_stretch(0.5), 10 * (1 + 8 * std::sqrt(2.1 + brought) / (0.1 * 5) + 2 * 3 * 0.5 / 0.05),
              1e-9);
  model.mesh.edge_stiffness = {400, 4};
  EXPECT_NEAR(Limits(model, 2).cloth_stretch(0), 10 * (1 + 3 * std::sqrt(2.1) / (0.1 * 2)), 1e-9);
  model.reservoirs.push_back({});
  EXPECT_EQ(Limits(model, 2).cloth_stretch(0.5), std::numeric_limits<double>::infinity());
}

TEST_F(PipelineTest, WhatIsBeyondABoundStopsTheRunAndWhatIsAtItDoesNot) {
  model.mesh.edge_length = {0.05};
  model.mesh.edge_stiffness = {400};
  const Limits limits(model, 154 * model.quantum);
  const std::tuple<double StepReport::*, FailureKind, double> kinds[] = {
      {&StepReport::fluid_speed, FailureKind::fluid_speed, limits.fluid_speed(0.01)},
      {&StepReport::cloth_speed, FailureKind::cloth_speed, limits.cloth_speed(0.01)},
      {&StepReport::cloth_stretch, FailureKind::cloth_stretch, limits.cloth_stretch(0.01)}};
  for (const auto& [number, kind, limit] : kinds) {
    backend.ledger.fluid_speed = backend.ledger.cloth_speed = backend.ledger.cloth_stretch = 0;
    backend.ledger.*number = limit;
    EXPECT_NO_THROW(Pipeline(model, backend, initial).step(1));
    backend.ledger.*number = limit * 1.001;
    try {
      Pipeline(model, backend, initial).step(1);
      FAIL() << "not noticed";
    } catch (const RunFailure& failure) {
      EXPECT_EQ(failure.kind, kind);
      EXPECT_EQ(failure.stage, Stage::ledger);
      EXPECT_EQ(failure.limit, limit);
    }
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
