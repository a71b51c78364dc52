#include "output/run_schedule.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace drench {

RunSchedule::RunSchedule(const Scene& scene)
    : every_(scene.output.every),
      checkpoint_every_(scene.output.checkpoint_every),
      end_(scene.time.end),
      rounding_(1e-6 * scene.time.step) {}

std::int64_t RunSchedule::passed(double interval, double now) const {
  now += rounding_;
  // At most what the type holds: intervals of 1e-300 s are allowed.
  auto n = static_cast<std::int64_t>(std::min(std::floor(now / interval), 9.0e18)) + 1;
  if (static_cast<double>(n) * interval <= now) ++n;
  if (static_cast<double>(n - 1) * interval > now) --n;
  return n;
}

double RunSchedule::time_left(double now) const {
  const double to_frame = has_frames() ? next_frame_time() - now : std::numeric_limits<double>::infinity();
  return std::min(to_frame, end_ - now);
}

bool RunSchedule::clipped_by_end(double now, double dt) const {
  const double to_end = end_ - now;
  return !(has_frames() && next_frame_time() - now <= to_end) && (dt == to_end || dt == 0.5 * to_end);
}

bool RunSchedule::go_on(double now) {
  if (!has_frames()) return false;
  frame_count_ = passed(every_, now);
  return static_cast<double>(frame_count_ - 1) * every_ >= now - rounding_;
}

void RunSchedule::plan_checkpoint(double now) {
  if (checkpoint_every_ > 0)
    next_checkpoint_time_ = static_cast<double>(passed(checkpoint_every_, now)) * checkpoint_every_;
}

}  // namespace drench
