#pragma once
// A run's frames as they lie on the disk, and how they become pictures at a steady rate.

#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace drench {

/// A frame that a .pvd lists. A series with a static part has that file first.
struct RecordedFrame {
  double time = 0;                           // s
  std::vector<std::filesystem::path> files;  // absolute, or relative to the working folder
};

/// The frames of `folder/series.pvd`, by time; none when the run has no such series. Throws std::runtime_error when the
/// collection cannot be read.
std::vector<RecordedFrame> recorded_frames(const std::filesystem::path& folder, const std::string& series);

/// Reads a .vtu. Throws std::runtime_error when it is missing or damaged.
vtkSmartPointer<vtkUnstructuredGrid> read_vtu(const std::filesystem::path& path);

/// 1/s: that of frames at these times, from the median of their distances; 24 for a single one. `times` (s) ascend.
double frame_rate(const std::vector<double>& times);

/// The frame nearest to each picture k / rate (s) from the first frame to the last. At least one, as `times` is not
/// empty.
std::vector<std::size_t> frames_of_pictures(const std::vector<double>& times, double rate);

/// One line when pictures at this rate have no frame at their time, or frames lie between two pictures and are never
/// met.
std::optional<std::string> rate_misfit(const std::vector<double>& times, double rate);

}  // namespace drench
