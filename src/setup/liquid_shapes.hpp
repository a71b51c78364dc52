#pragma once
// Liquid that is there at the start in other shapes than boxes: spheres, closed meshes, particles of a file.

#include <string>
#include <vector>

#include "state/model.hpp"

namespace drench {

/// Where a particle starts, its velocity and its mass.
struct StartParticle {
  Vec3 position, velocity;  // m, m/s
  Quanta mass = 0;
};

/// Number of particles of a source, before overlaps and solids take some away: of a sphere and a mesh from the volume.
/// SetupError: a file that cannot be read, a mesh that encloses no volume. `name` begins its text.
double expected_particles(const Scene& scene, const BlockScene& block, const std::string& name);

/// Fills a sphere or a closed mesh: of the lattice in the bounding box (setup/block_lattice.hpp), the points that are
/// deepest inside. Their number is that of the volume as nearly as points of the same depth allow; the lattice is then
/// scaled about the middle so that the particles, which are equally heavy, are at rest density, and their masses add up
/// to density times volume in whole quanta. If one of them is beside a solid, those near the surface are moved until
/// none is compressed (setup/relax_points.hpp), so that liquid in a vessel of its shape starts near rest. Of a file:
/// its particles, with its velocities and masses where it has them; without masses they are full particles. Needs
/// model.boundary. Sets block.box to the bounding box. `name` begins a line that is added to `warnings`, and the text
/// of a SetupError: as above, and for a shape of less than a spacing.
std::vector<StartParticle> start_particles(const Model& model, BlockScene& block, const std::string& name,
                                           std::vector<std::string>& warnings);

}  // namespace drench
