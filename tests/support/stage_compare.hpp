#pragma once
// Runs one stage on the backend and on the reference from identical input and compares every field of the state.

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "compare/field_difference.hpp"
#include "pipeline/backend.hpp"
#include "pipeline/stage_list.hpp"
#include "setup/build.hpp"

namespace drench::test {

/// How a scene begins whose liquid is solved for in six iterations: up to its sources.
inline constexpr const char* few_iterations = R"(drench: 1
time: {step: 0.002, end: 1.0}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
output: {every: 0}
fluid:
  spacing: 0.02
  viscosity: 1.0e-3
  solver: {max_iterations: 6, min_iterations: 6}
  sources:)";

/// A scene that uses every stage: a small block of water just above a pinned porous sheet, over a sphere and a floor.
std::string wet_scene();
/// Replaces the first occurrence of `from`; throws if there is none, so that a test cannot silently test something
/// else.
std::string with(std::string text, const std::string& from, const std::string& to);
drench::Setup setup_from(const std::string& yaml);

struct Comparison {
  Stage stage;
  std::string scene = wet_scene();
  int steps_before = 12;  ///< whole steps that the reference runs first
  /// Edits what the scene was resolved to, before anything runs (both sides get the edited one).
  std::function<void(Model&)> resolve = {};
  /// Edits the state just before the stage under test (both sides get the edited one).
  std::function<void(const Model&, HostState&)> prepare = {};
  double last_start = 0;  ///< StepInfo's divergence_start and density_start
  /// The stage must change this field, or the test would compare nothing.
  std::string changes = {};
};

/// Runs the stages one after the other from `state`, on the reference and then on the backend: check(backend, report)
/// of each.
template <class Check>
void run_on_both(const Model& model, const HostState& state, const std::vector<Stage>& stages, const StepInfo& info,
                 const Check& check) {
  for (const auto& backend : {make_reference_backend(model), make_kokkos_backend(model)}) {
    SCOPED_TRACE(backend->name());
    StepReport report;
    backend->upload(state);
    for (const Stage stage : stages) backend->run(stage, info, report);
    check(*backend, report);
  }
}

/// What advection needs before it, and advection.
inline const std::vector<Stage> until_advection{Stage::neighbors, Stage::density, Stage::advection};

/// For `prepare`: the nodes' liquid at 1.02 to 1.12 of their capacity, one part in `parts` of it buffered.
void overfill(const Model& model, HostState& state, Quanta parts);

/// For `prepare`: every fifth particle gets 5 % of its mass, every seventh comes within 0.3 spacings of the one before.
void crowd(const Model& model, HostState& state);

/// What this build's backend computes with.
Precision backend_precision();

/// Expects agreement within the tolerances of compare/field_difference.hpp, which `drench compare` uses too.
void compare_stage(const Comparison& c);

/// The same with each of the smoothing kernels.
void compare_stage_with_every_kernel(Comparison c);

}  // namespace drench::test
