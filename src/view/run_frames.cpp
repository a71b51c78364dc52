#include "view/run_frames.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

namespace drench {
namespace {

/// The last frame that is not later than `time`, else the first. A body that stands still has one frame for all times.
const RecordedFrame& frame_at(const std::vector<RecordedFrame>& frames, double time) {
  const auto after = std::upper_bound(frames.begin(), frames.end(), time,
                                      [](double t, const RecordedFrame& frame) { return t < frame.time; });
  return after == frames.begin() ? *after : *(after - 1);
}

}  // namespace

bool RunFrames::refresh() {
  series_.clear();
  for (const char* name : {"fluid", "surface", "cloth", "bodies"})
    if (auto frames = recorded_frames(folder_, name); !frames.empty()) series_[name] = std::move(frames);
  std::vector<double> times;
  const std::vector<RecordedFrame>* longest = nullptr;
  for (const auto& [name, frames] : series_)
    if (!longest || frames.size() > longest->size()) longest = &frames;
  if (longest)
    for (const RecordedFrame& frame : *longest) times.push_back(frame.time);
  for (const char* name : {"fluid", "surface", "cloth"})  // a run writes one after the other
    if (const auto it = series_.find(name); it != series_.end())
      std::erase_if(times, [&](double time) { return time > it->second.back().time; });
  const bool more = times != times_;
  times_ = std::move(times);
  return more;
}

Moment RunFrames::read(std::size_t i) const {
  Moment moment;
  moment.time = times_.at(i);
  const auto exact = [&](const char* name) -> vtkSmartPointer<vtkUnstructuredGrid> {
    const auto it = series_.find(name);
    if (it == series_.end()) return nullptr;
    const RecordedFrame& frame = frame_at(it->second, moment.time);
    return frame.time == moment.time ? read_vtu(frame.files.back()) : nullptr;
  };
  moment.fluid = exact("fluid");
  moment.surface = exact("surface");
  moment.cloth = exact("cloth");
  if (const auto it = series_.find("bodies"); it != series_.end())
    for (const auto& file : frame_at(it->second, moment.time).files) moment.bodies.push_back(read_vtu(file));
  return moment;
}

Vec3 upward(const std::filesystem::path& folder) {
  try {
    const auto g = YAML::LoadFile((folder / "scene.yaml").string())["gravity"].as<std::vector<double>>();
    const double length = g.size() == 3 ? std::hypot(g[0], g[1], g[2]) : 0;
    if (length > 0) return {-g[0] / length, -g[1] / length, -g[2] / length};
  } catch (const YAML::Exception&) {  // a folder of frames alone can be looked at too
  }
  return {0, 1, 0};
}

}  // namespace drench
