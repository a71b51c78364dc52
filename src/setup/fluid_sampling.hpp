#pragma once
// The liquid that is there at the start.

#include <string>
#include <vector>

#include "setup/liquid_shapes.hpp"
#include "state/model.hpp"

namespace drench {

/// Particles that the sources hold at the start, before overlaps and solids take some away.
double expected_block_particles(const FluidScene& fluid, const std::vector<SourceFile>& files);

struct BlockParticles {
  std::vector<Vec3> position;  // m
  std::vector<Vec3> velocity;  // m/s
  std::vector<Quanta> mass;
  std::vector<std::size_t> block;  // of each, from 0
};

/// Fills the boxes with lattices of spacing d; where a side is no multiple of d, layers lie closer and particles are
/// lighter, so that each block holds its volume's mass, in whole quanta. Particles closer than d/2 to one of an earlier
/// block and those inside a solid are left out; a warning counts them, and those closer than 0.9 d to an earlier
/// block's or than d/2 to a cloth. Other shapes and files: setup/liquid_shapes.hpp; their `box` becomes their bounding
/// box. Needs model.bodies, model.mesh, model.spacing. SetupError: particles outside the domain, or below min_quanta;
/// shapes and files that give no particles.
BlockParticles fill_blocks(Model& model, std::vector<SourceFile> files, std::vector<std::string>& warnings);

/// In spacings: a particle that starts nearer to a cloth is pushed away from it at once.
inline constexpr double nearest_to_cloth = 0.5 - 1e-6;

/// 1 for each point within `distance` (m) of a cloth's rest shape.
std::vector<std::uint8_t> near_cloth(const Model& model, const std::vector<Vec3>& points, double distance);

/// For each point the number, from 1, of the first solid that it is inside of, or 0; thin walls have no inside.
std::vector<std::size_t> inside_solid(const Model& model, const std::vector<Vec3>& points);

}  // namespace drench
