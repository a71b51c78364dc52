#pragma once
// Runs one stage on the backend and on the reference from identical input and compares every field of the state.

#include <functional>
#include <string>

#include "compare/field_difference.hpp"
#include "pipeline/stage_list.hpp"
#include "setup/build.hpp"

namespace drench::test {

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
  /// The stage must change this field, or the test would compare nothing.
  std::string changes = {};
};

/// For `prepare`: every fifth particle gets 5 % of its mass, every seventh comes within 0.3 spacings of the one before.
void crowd(const Model& model, HostState& state);

/// What this build's backend computes with.
Precision backend_precision();

/// Expects agreement within the tolerances of compare/field_difference.hpp, which `drench compare` uses too.
void compare_stage(const Comparison& c);

/// The same with each of the smoothing kernels.
void compare_stage_with_every_kernel(Comparison c);

}  // namespace drench::test
