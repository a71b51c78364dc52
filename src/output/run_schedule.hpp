#pragma once
// When a run's frames and checkpoints are due, and when it ends. Times in s.

#include <cstdint>

#include "scene/scene.hpp"

namespace drench {

/// Steps are clipped to frames' times and to the end, and not to checkpoints': whether those are written must not
/// change the result.
class RunSchedule {
 public:
  explicit RunSchedule(const Scene& scene);

  bool has_frames() const { return every_ > 0; }
  /// At or after time.end.
  bool ended(double now) const { return now >= end_ - rounding_; }
  /// The longest that a step from now on may last; `clipped`: would the end, and no frame, cut it to `dt` or to half of
  /// it?
  double time_left(double now) const;
  bool clipped_by_end(double now, double dt) const;

  bool frame_due(double now) const { return has_frames() && next_frame_time() <= now + rounding_; }
  void frame_taken() { ++frame_count_; }
  /// Goes on at a time: frames up to it are taken. True where the last of them is of this very time.
  bool go_on(double now);

  bool checkpoint_due(double now) const {
    return next_checkpoint_time_ > 0 && now >= next_checkpoint_time_ - rounding_;
  }
  /// The next multiple of output.checkpoint_every.
  void plan_checkpoint(double now);

 private:
  /// Counted, not summed, so that a thousand frames do not drift.
  double next_frame_time() const { return static_cast<double>(frame_count_) * every_; }
  /// How many multiples of `interval` from 0 on have come.
  std::int64_t passed(double interval, double now) const;

  double every_, checkpoint_every_, end_;
  double rounding_;                  // a part in a million of time.step: what times may be off
  std::int64_t frame_count_ = 0;     // frames' times that have come
  double next_checkpoint_time_ = 0;  // 0: none
};

}  // namespace drench
