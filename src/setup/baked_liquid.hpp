#pragma once
// Liquid that another program has simulated: its particles follow a sequence of files.

#include <cstdint>
#include <string>
#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// The files of the source `particles` or `mesh` with a `sequence` (Model::has_baked_liquid). The motion is Eq. 29g of
/// docs/theory/liquid.md. Either all particle files have ids or none has; each may be empty. With ids a particle keeps
/// the mass that cloth has not absorbed. One that cloth has absorbed completely does not return; one that was missing
/// in a file, or outside the domain, returns as a new one. Without ids each file brings new, full particles, and so
/// does each mesh.
class BakedLiquid {
 public:
  explicit BakedLiquid(const Model& model);

  /// Is `time` (s) that of a file after the first?
  bool begins(double time) const;
  /// From `time` to the next file, s; infinite after the last.
  double time_left(double time) const;
  /// The particles of the first file, and warnings of them. SetupError: as replace(), and where it has some but none in
  /// the domain.
  void start(HostState& state, std::vector<std::string>& warnings);
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
  };
  /// Of file `number`; the last three stay in memory.
  const Frame& frame(std::int64_t number);
  Frame read(std::int64_t number) const;
  Frame read_file(std::int64_t number) const;
  bool in_domain(const Vec3& x) const;
  /// Has cloth absorbed the particle of that id, which file `number` still has?
  bool is_absorbed(std::int64_t number, std::int64_t id);
  /// A particle of a file (row) and where it is in the state (row; −1: it is new).
  struct Match {
    std::size_t of_file;
    std::int64_t of_state;
  };
  /// Those that are in the domain, in the order of the file.
  std::vector<Match> matches(std::int64_t number, const Frame& now, const HostState& state);
  /// Particles of file `number` with the velocities until the next one.
  Frame particles_from(std::int64_t number);

  const Model& model_;
  const BlockScene& source_;
  std::int64_t count_;  // of files
  bool has_ids_ = false, knows_ids_ = false;
  std::vector<Frame> frames_;
};

}  // namespace drench
