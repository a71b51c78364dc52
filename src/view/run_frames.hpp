#pragma once
// The frames of a run, one moment at a time.

#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "output/recorded_frames.hpp"

namespace drench {

/// All that a run shows at one time. A grid is null where the run has none.
struct Moment {
  double time = 0;  // s
  vtkSmartPointer<vtkUnstructuredGrid> fluid, surface, cloth;
  std::vector<vtkSmartPointer<vtkUnstructuredGrid>> bodies;
};

/// The frames in an output folder. A run may still be adding to them.
class RunFrames {
 public:
  explicit RunFrames(std::filesystem::path folder) : folder_(std::move(folder)) { refresh(); }
  /// Looks for frames that have come since. True when there are some. Throws std::runtime_error.
  bool refresh();

  /// s, ascending. A time counts once the liquid, its surface and the cloths are all there.
  const std::vector<double>& times() const { return times_; }
  bool has(const std::string& series) const { return series_.contains(series); }
  /// Reads frame i of times(). Throws std::runtime_error where a file is missing or damaged.
  Moment read(std::size_t i) const;
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  std::map<std::string, std::vector<RecordedFrame>> series_;  // those that have frames
  std::vector<double> times_;
};

/// The axis against gravity, a unit vector, from the resolved scene; y without one.
Vec3 upward(const std::filesystem::path& folder);

}  // namespace drench
