#include "view/show.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "view/camera.hpp"

namespace drench {
namespace {

constexpr std::size_t looked_at = 9;     // frames that settle the camera and the range of colours
constexpr vtkIdType most_points = 5000;  // of a grid, for the camera
constexpr std::size_t stray = 50;        // the farthest 1/50 of a grid on each side is not framed

/// All but the farthest points of a grid: a stray drop does not count.
void add_seen(vtkUnstructuredGrid* grid, std::vector<Vec3>& seen) {
  if (!grid || grid->GetNumberOfPoints() == 0) return;
  const vtkIdType stride = std::max<vtkIdType>(1, grid->GetNumberOfPoints() / most_points);
  std::vector<Vec3> points;
  std::array<std::vector<double>, 3> along;
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); i += stride) {
    Vec3& x = points.emplace_back();
    grid->GetPoint(i, x.data());
    for (std::size_t a = 0; a < 3; ++a) along[a].push_back(x[a]);
  }
  Vec3 low{}, high{};
  for (std::size_t a = 0; a < 3; ++a) {
    std::sort(along[a].begin(), along[a].end());
    low[a] = along[a][points.size() / stray];
    high[a] = along[a][points.size() - 1 - points.size() / stray];
  }
  for (const Vec3& x : points)
    if (x[0] >= low[0] && x[1] >= low[1] && x[2] >= low[2] && x[0] <= high[0] && x[1] <= high[1] && x[2] <= high[2])
      seen.push_back(x);
}

std::vector<Vec3> seen_in(const std::vector<Moment>& moments) {
  std::vector<Vec3> seen;
  for (const Moment& moment : moments) {
    add_seen(moment.fluid, seen);
    add_seen(moment.cloth, seen);
  }
  if (seen.empty())
    for (const auto& grid : moments.back().bodies) add_seen(grid, seen);
  return seen;
}

}  // namespace

Show::Show(const ViewOptions& options) : frames_(options.folder), up_(upward(options.folder)) {
  if (frames_.times().empty())
    throw std::runtime_error(
        fmt::format("{}: holds no frames of a run (fluid.pvd, cloth.pvd, surface.pvd or bodies.pvd)", options.folder));
  if (options.liquid == "surface" && !frames_.has("surface"))
    throw std::runtime_error(
        fmt::format("--liquid surface: {} has no surface.pvd; run with output.surface: true", options.folder));
  if (options.liquid == "particles" && !frames_.has("fluid"))
    throw std::runtime_error(fmt::format("--liquid particles: {} has no fluid.pvd", options.folder));
  surface_ = options.liquid != "particles";
  const std::size_t begin = options.frame == "last" ? last() : std::stoul(options.frame);
  if (begin > last())
    throw std::runtime_error(fmt::format("--frame {}: {} has frames 0 to {}", begin, options.folder, last()));
  const std::vector<Moment> moments = spread();
  ranges_ = field_ranges(moments);
  seen_ = seen_in(moments);
  choose(options.color);
  go_to(begin);
}

std::vector<Moment> Show::spread() const {
  std::vector<Moment> moments;
  const std::size_t count = std::min(looked_at, last() + 1);
  for (std::size_t k = 0; k < count; ++k) moments.push_back(frames_.read(count == 1 ? 0 : k * last() / (count - 1)));
  return moments;
}

void Show::choose(const std::string& field) {
  field_.reset();
  if (field == plain_look) return;
  std::string known = plain_look;
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    if (ranges_[i].name == field) field_ = i;
    known += ", " + ranges_[i].name;
  }
  if (!field_) throw std::runtime_error(fmt::format("--color {}: no such field; allowed: {}", field, known));
}

void Show::go_to(std::size_t i) {
  at_ = std::min(i, last());
  moment_ = frames_.read(at_);
  redraw();
}

void Show::redraw() {
  picture_.show_surface(surface_);
  picture_.color_by(field_ ? std::optional(ranges_[*field_]) : std::nullopt);
  picture_.show(moment_);
}

bool Show::follow() {
  const bool newest = at_ == last();
  if (!frames_.refresh() || frames_.times().empty()) return false;
  if (!newest) return true;
  at_ = last();
  moment_ = frames_.read(at_);
  for (const FieldRange& found : field_ranges({moment_})) {
    const auto known =
        std::find_if(ranges_.begin(), ranges_.end(), [&](const auto& r) { return r.name == found.name; });
    if (known == ranges_.end()) {
      ranges_.push_back(found);
    } else {
      known->low = std::min(known->low, found.low);
      known->high = std::max(known->high, found.high);
    }
  }
  redraw();
  return true;
}

void Show::next_color(int direction) {
  const int choices = static_cast<int>(ranges_.size()) + 1, now = field_ ? static_cast<int>(*field_) + 1 : 0;
  const int then = (now + direction + choices) % choices;
  field_ = then == 0 ? std::nullopt : std::optional(static_cast<std::size_t>(then - 1));
  redraw();
}

void Show::switch_liquid() {
  surface_ = !surface_;
  redraw();
}

void Show::frame(const View& view, int width, int height) {
  std::vector<Vec3> points = seen_;
  add_seen(moment_.fluid, points);
  add_seen(moment_.cloth, points);
  place_camera(picture_.renderer(), view, up_, points, static_cast<double>(width) / height);
  picture_.renderer()->ResetCameraClippingRange();
}

std::string Show::color() const { return field_ ? ranges_[*field_].name : plain_look; }

}  // namespace drench
