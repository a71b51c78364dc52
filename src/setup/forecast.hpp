#pragma once
// A forecast of a run: how fast things will move, how often stages repeat themselves in a step.

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// Speeds that the liquid comes to, m/s. Paths begin at points of each block, at some particles, at each jet and, where
/// cloth drips, at nodes, and fall under gravity and field until they leave the domain, stop at a cloth, a plane or a
/// container, or the scene ends; other bodies they pass as liquid flows round them. Bodies are where they are at t = 0.
struct ExpectedSpeeds {
  double fastest = 0;  // anywhere on the way
  double impact = 0;   // at a source, where a path meets a solid or a cloth, or of bodies and pins that push
};
ExpectedSpeeds expected_speeds(const Model& model, const HostState& state);

/// Does nothing hold this cloth: no pin, no solid below it, no other cloth that it could lie on, no body that moves?
bool falls_freely(const Model& model, const ClothMaterial& cloth);
/// The same of a part of it: these nodes.
bool falls_freely(const Model& model, const ClothMaterial& cloth, const std::vector<Index>& nodes);

/// Height (m) from the highest of the cloth's nodes down to the domain's border, along gravity.
double height_in_domain(const Model& model, const ClothMaterial& cloth);

/// The largest rate (1/s) at which nodes of the cloth exchange liquid, in its rest shape and without differences of
/// height: sub-steps of stage diffusion follow from it (stages/substeps.hpp).
double diffusion_rate(const Model& model, const ClothMaterial& cloth);

/// Iterations of the cloth's solver (src/stages/cloth.hpp) that take every mode of the dry cloth down to the scene's
/// tolerance, for its linear part; 0 for a cloth that does not move. Chebyshev's weights leave 1/T_k(1/ρ) of the
/// slowest after k.
struct ClothIterations {
  double count = 0;
  const char* cause =
      "";  // the key that has most of the stiffness: stretch or membrane, strain_damping, bend or bending
};
ClothIterations cloth_iterations(const Model& model, const ClothMaterial& cloth, double dt);

/// Passes of the viscosity a step (src/stages/forces.hpp) in full neighbourhoods: Σ V |∇W| r = 3 there; C_i grows to
/// about twice that beside solids, and light cloth can need more.
double viscous_passes(const Model& model, double dt);

/// Passes of the spins a step (src/stages/micropolar.hpp) in full neighbourhoods: k = 3 there, and g = 6/h at most.
double spin_passes(const Model& model, double dt);

}  // namespace drench
