#pragma once
// A time series for ParaView: a .pvd collection and its .vtu frames, readable at any moment of the run.

#include <filesystem>
#include <string>
#include <vector>

#include "output/energy.hpp"
#include "output/grids.hpp"

namespace drench {

/// Writes one grid as VTK XML (inline binary, zlib) in one move. Throws std::runtime_error.
void write_vtu(const std::filesystem::path& path, const Grid& grid);

/// `folder/name.pvd` with frames `folder/frames/name_000123.vtu`.
class VtuSeries {
 public:
  VtuSeries(std::filesystem::path folder, std::string name);
  /// A part that never changes: written once, listed at every time. Call it before the first frame.
  void set_static_part(const Grid& grid);
  /// Goes on after so many frames: those that are listed stay, later ones are taken off the list and removed.
  void resume(int frames);
  /// Writes the frame and then the collection that names it.
  void write(double time, const Grid& grid);
  /// Lists `time` for a series that has nothing but its static part, unless that is listed.
  void write_static(double time);
  /// Puts what was written since the last call onto the disk itself.
  void sync();

 private:
  void list(double time, int part, const std::string& file);
  void write_collection() const;

  std::filesystem::path folder_;
  std::string name_;
  std::string static_file_;  // relative to folder_, "" for none
  std::string entries_;
  int frame_ = 0;
  std::vector<std::string> unsynced_;  // relative to folder_
};

/// The series that a model needs: fluid, its surface, cloth and bodies, each only when the scene has it; and their
/// energy.
class FrameWriter {
 public:
  /// `frames` > 0 goes on after so many frames of an earlier run; in its folder later ones are removed. `threads` make
  /// the surface; the files do not depend on them.
  FrameWriter(const std::filesystem::path& folder, const Model& model, int frames = 0, int threads = 1);
  /// Adds a frame at state.time.
  void write(const HostState& state);
  /// Puts the frames that were written since the last call, and the collections, onto the disk itself.
  void sync();
  int frames() const { return frames_; }
  /// The .pvd files that this run writes.
  std::vector<std::string> collections() const;

 private:
  const Model& model_;
  VtuSeries fluid_, surface_, cloth_, bodies_;
  EnergyCsv energy_;
  int threads_;
  int frames_ = 0;
};

}  // namespace drench
