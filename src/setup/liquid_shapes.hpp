#pragma once
// Liquid that is there at the start in other shapes than boxes: spheres, closed meshes, particles of a file.

#include <string>
#include <vector>

#include "setup/read_particles.hpp"
#include "state/model.hpp"

namespace drench {

/// Where a particle starts, its velocity and its mass.
struct StartParticle {
  Vec3 position, velocity;  // m, m/s
  Quanta mass = 0;
};

/// What the file of a source holds.
struct SourceFile {
  Body mesh;               // of a mesh: closed
  ParticleFile particles;  // of particles
};

/// "block", or "mesh source", for messages.
const char* kind_of(const BlockScene& block);
/// "fluid: mesh source 0": of the liquid that is there at the start, counted from 0.
std::string block_label(const BlockScene& block, std::size_t number);

/// Reads the file of block `number` (from 0); lines about holes are added to `warnings`, those about an unusual size to
/// `hints`. SetupError: a file that cannot be read, a mesh that encloses no volume. Files of a sequence may hold
/// nothing.
SourceFile read_source_file(const std::string& scene_path, const BlockScene& block, std::size_t number,
                            std::vector<std::string>& warnings, std::vector<std::string>& hints);

/// The same of all blocks, an entry each.
std::vector<SourceFile> read_source_files(const Scene& scene, std::vector<std::string>& warnings,
                                          std::vector<std::string>& hints);

/// Number of particles of a source, before overlaps and solids take some away: of a sphere and a mesh from the volume.
double expected_particles(const BlockScene& block, const SourceFile& file, double spacing);

/// Fills a sphere or a closed mesh: of the lattice in the bounding box (setup/block_lattice.hpp), the points that are
/// deepest inside. Their number is that of the volume as nearly as points of the same depth allow; the lattice is then
/// scaled about the middle so that the particles, which are equally heavy, are at rest density, and their masses add up
/// to density times volume in whole quanta. If one of them is beside a solid, those near the surface are moved until
/// none is compressed (setup/relax_points.hpp), so that liquid in a vessel of its shape starts near rest. Of a file:
/// its particles, with its velocities and masses where it has them; without masses they are full particles. Needs
/// model.boundary. Sets block.box to the bounding box. SetupError, whose text `name` begins: particles that are too
/// light, or heavier than two.
std::vector<StartParticle> start_particles(const Model& model, BlockScene& block, SourceFile file,
                                           const std::string& name);

/// Adds a line where the particles of a file are much closer to each other, or farther, than `fluid.spacing` and their
/// masses say. `pushes`: they push each other, unlike liquid of a sequence, whose particles may lie at random.
void warn_of_distances(const Model& model, const std::vector<StartParticle>& particles, const std::string& name,
                       bool pushes, std::vector<std::string>& warnings);

}  // namespace drench
