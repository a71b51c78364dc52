#pragma once
// The liquid's sources: particles of the blocks at the start, lattices of the jets.

#include <string>
#include <vector>

#include "state/model.hpp"

namespace drench {

/// Particles that the sources hold at the start, before overlaps and solids take some away. SetupError as fill_blocks.
double expected_block_particles(const Scene& scene);

struct BlockParticles {
  std::vector<Vec3> position;  // m
  std::vector<Vec3> velocity;  // m/s
  std::vector<Quanta> mass;
  std::vector<std::size_t> block;  // of each, from 1
};

/// Fills the boxes with lattices of spacing d; where a side is no multiple of d, layers lie closer and particles are
/// lighter, so that each block holds its volume's mass, in whole quanta. Particles closer than d/2 to one of an earlier
/// block and those inside a solid are left out; a warning counts them, and those closer than 0.9 d to an earlier
/// block's or than d/2 to a cloth. Other shapes and files: setup/liquid_shapes.hpp; their `box` becomes their bounding
/// box. Needs model.bodies, model.mesh, model.spacing. SetupError: particles outside the domain, or below min_quanta;
/// shapes and files that give no particles.
BlockParticles fill_blocks(Model& model, std::vector<std::string>& warnings);

/// In spacings: a particle that starts nearer to a cloth is pushed away from it at once.
inline constexpr double nearest_to_cloth = 0.5 - 1e-6;

/// 1 for each point within `distance` (m) of a cloth's rest shape.
std::vector<std::uint8_t> near_cloth(const Model& model, const std::vector<Vec3>& points, double distance);

inline constexpr double max_mouth_points = 1e6;

/// "fluid: jet 1", "fluid: rain 2": of an entry of Model::jets, which has the rains last.
std::string jet_label(const Model& model, std::size_t number);

/// Lattice and interval of a jet, which a SetupError calls `name`. Needs model.spacing. SetupError: a radius below d/2,
/// a mouth of too many points, no velocity, a centre outside the domain.
Jet make_jet(const Model& model, const JetScene& scene, const std::string& name);

/// Rain as a jet whose mouth is the rectangle: its offsets are a low-discrepancy sequence on it, and each particle has
/// the mass of a drop, or of several where one would have less than an eighth of a full particle's. SetupError, as
/// above, and for drops that are larger than a particle, or fall along no direction.
Jet make_rain(const Model& model, const RainScene& scene, const std::string& name);

/// The same of all jets of the scene, followed by its rains. Needs model.bodies. A warning counts the points of a mouth
/// that are in a solid.
std::vector<Jet> make_jets(const Model& model, std::vector<std::string>& warnings);

}  // namespace drench
