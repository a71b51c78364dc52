#pragma once
// Liquid that another program has simulated: its particles follow a sequence of files.

#include <cstdint>
#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// The files of the source `particles` or `mesh` with a `sequence` (Model::has_baked_liquid). Particle files have ids
/// either all of them or none; each may be empty. With ids a particle keeps what cloth has left of its mass and moves
/// evenly from file to file; one that cloth has absorbed stays away, and one that returns after a file without it, or
/// from outside the domain, is new. Without ids each file brings new, full particles, which move with their velocities
/// until the next file; so does each mesh, whose liquid has the velocity of the source. After the last file all
/// particles rest.
class BakedLiquid {
 public:
  explicit BakedLiquid(const Model& model);

  /// Is `time` (s) that of a file after the first?
  bool begins(double time) const;
  /// From `time` to the next file, s; infinite after the last.
  double time_left(double time) const;
  /// m/s: of a state's particles.
  static double fastest(const HostState& state);
  /// The particles of the first file. SetupError: as replace(), and where it has some but none in the domain.
  void start(HostState& state);
  /// The particles of the file that begins at `time`. The mass budget goes on: what the file adds is supplied, what it
  /// no longer has is drained. SetupError: an unreadable file, a mesh that encloses no volume, particles heavier than
  /// two, ids that are missing, negative or not unique.
  void replace(HostState& state, double time);

 private:
  /// What a file holds, by ascending id; scene coordinates.
  struct Frame {
    std::int64_t number = -1;
    std::vector<Vec3> position, velocity;  // m, m/s
    std::vector<Quanta> mass;
    std::vector<std::int64_t> id;

    /// The row of an id; −1: none.
    std::int64_t row_of(std::int64_t id) const;
  };
  /// Of file `number`; the last three stay in memory.
  const Frame& frame(std::int64_t number);
  Frame read(std::int64_t number) const;
  bool in_domain(const Vec3& x) const;
  /// Particles of file `number` with the velocities until the next one.
  Frame particles_from(std::int64_t number);

  const Model& model_;
  const BlockScene& source_;
  std::int64_t count_;  // of files
  bool has_ids_ = false, knows_ids_ = false;
  std::vector<Frame> frames_;
};

}  // namespace drench
