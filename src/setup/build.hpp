#pragma once
// From a Scene to everything that a run starts from.

#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "setup/memory_estimate.hpp"
#include "setup/setup_error.hpp"
#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

class FilledBodies;  // setup/body_fields.hpp

struct Setup {
  Model model;
  HostState state;
  std::vector<std::string> warnings;  // one line each
  std::vector<std::string> notes;     // what the set-up has done to meshes, and their pieces; one line each
  double deepest_inside = 0;          // m: of the free nodes that start inside a solid body
};

/// Reads mesh files, places and samples cloths, bodies and liquid. The same scene gives the same set-up, bit for bit.
/// Throws SetupError when the scene cannot be set up, or would not fit into the memory that there is. `filled`: the
/// distances of bodies from earlier set-ups of similar scenes, to which this one's are added.
Setup build(const Scene& scene, const MemoryBudget& budget = {}, FilledBodies* filled = nullptr);

/// The stages that a model asks for, and the size of its distance fields; all other counts stay 0.
SetupSize kinds_of(const Model& model);

/// Particles that the jets let go until the scene's end.
double jet_particles(const Model& model);

/// Particles that the excess over saturation 1 makes, which cloth holds at the start and may give back.
double dripping_particles(const Setup& setup);

/// The counts of this set-up, for estimate_memory.
SetupSize size_of(const Setup& setup);

/// The same at its end, as far as that can be foreseen: with the room for what jets and overfull cloths add.
SetupSize with_sources(const Setup& setup, SetupSize size);

/// The same where liquid lies at all cloth and walls, as far as there is enough, and has 1.2 times as many neighbours:
/// what scenes came to, no bound.
SetupSize at_work(SetupSize size);

/// The same with room for a hundred pairs of cloth with itself a node, as folds came to; no bound either.
SetupSize in_folds(SetupSize size);

}  // namespace drench
