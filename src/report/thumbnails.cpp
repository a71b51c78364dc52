#include "report/thumbnails.hpp"

#include <fmt/format.h>
#include <vtkCell.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkPointData.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "output/recorded_frames.hpp"
#include "report/painter.hpp"

namespace drench {

namespace fs = std::filesystem;

namespace {

struct Size {
  int width, height;  // pixels
};
constexpr Size thumbnail{400, 320};
constexpr int finer = 2;  // painted so much larger, then reduced: smooth edges
constexpr Colour liquid{0.20F, 0.52F, 0.86F}, solid{0.82F, 0.84F, 0.86F}, outline{0.62F, 0.66F, 0.71F};

using Grid = vtkSmartPointer<vtkUnstructuredGrid>;

Vec3 point_of(vtkUnstructuredGrid* grid, vtkIdType i) {
  Vec3 p;
  grid->GetPoint(i, p.data());
  return p;
}

/// A frame's grids; null where the run has no such series.
struct Scenery {
  double time = 0;
  Grid fluid, cloth;
  std::vector<Grid> bodies;
};

/// tools/export/saturation.json, which tools/render and ParaView take.
Colour wet_colour(double saturation) {
  struct Stop {
    double at;
    Colour colour;
  };
  static constexpr Stop stops[] = {{0, {0.95F, 0.92F, 0.85F}},
                                   {0.5, {0.58F, 0.55F, 0.56F}},
                                   {1, {0.16F, 0.17F, 0.25F}},
                                   {1.2, {0.128F, 0.136F, 0.2F}}};
  if (!(saturation > 0)) return stops[0].colour;
  for (std::size_t k = 1; k < std::size(stops); ++k) {
    if (saturation > stops[k].at) continue;
    const auto part = static_cast<float>((saturation - stops[k - 1].at) / (stops[k].at - stops[k - 1].at));
    Colour c;
    for (std::size_t j = 0; j < 3; ++j) c[j] = stops[k - 1].colour[j] * (1 - part) + stops[k].colour[j] * part;
    return c;
  }
  return stops[3].colour;
}

class FrameSeries {
 public:
  explicit FrameSeries(const fs::path& folder)
      : all_{recorded_frames(folder, "fluid"), recorded_frames(folder, "cloth"), recorded_frames(folder, "bodies")} {}
  /// Times of the series with the most frames: bodies that stand still have only one.
  std::vector<double> times() const {
    const auto& most =
        *std::max_element(all_.begin(), all_.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    std::vector<double> times;
    times.reserve(most.size());
    for (const RecordedFrame& f : most) times.push_back(f.time);
    return times;
  }
  Scenery read(double time) const {
    Scenery s;
    s.time = time;
    if (const auto* f = at(all_[0], time)) s.fluid = read_vtu(f->files.back());
    if (const auto* f = at(all_[1], time)) s.cloth = read_vtu(f->files.back());
    if (const auto* f = at(all_[2], time))
      for (const fs::path& file : f->files) s.bodies.push_back(read_vtu(file));
    return s;
  }

 private:
  /// The last frame that is not later.
  static const RecordedFrame* at(const std::vector<RecordedFrame>& frames, double time) {
    const RecordedFrame* found = frames.empty() ? nullptr : &frames.front();
    for (const RecordedFrame& f : frames)
      if (f.time <= time * (1 + 1e-9)) found = &f;
    return found;
  }
  std::array<std::vector<RecordedFrame>, 3> all_;  // of the liquid, the cloths and the bodies
};

double cell_value(vtkUnstructuredGrid* grid, const char* field, vtkIdType cell) {
  vtkDataArray* values = grid->GetCellData()->GetArray(field);
  return values ? values->GetComponent(cell, 0) : 0;
}

bool is_open(vtkUnstructuredGrid* grid, vtkIdType cell) {
  return cell_value(grid, "container", cell) != 0 || cell_value(grid, "plane", cell) != 0;
}

template <class Do>
void each_triangle(vtkUnstructuredGrid* grid, Do&& todo) {
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    vtkCell* cell = grid->GetCell(c);
    for (vtkIdType k = 2; k < cell->GetNumberOfPoints(); ++k)
      todo(c, std::array<vtkIdType, 3>{cell->GetPointId(0), cell->GetPointId(k - 1), cell->GetPointId(k)});
  }
}

/// Where all but the outermost 1 % of the points lie, axis by axis: a stray drop must not make the rest small.
void add_corners(vtkUnstructuredGrid* grid, std::vector<Vec3>& corners) {
  const vtkIdType count = grid->GetNumberOfPoints();
  if (count == 0) return;
  std::array<std::vector<double>, 3> axes;
  for (vtkIdType i = 0; i < count; ++i) {
    const Vec3 p = point_of(grid, i);
    if (!std::isfinite(p[0] + p[1] + p[2])) continue;
    for (std::size_t k = 0; k < 3; ++k) axes[k].push_back(p[k]);
  }
  if (axes[0].empty()) return;
  Vec3 low, high;
  for (std::size_t k = 0; k < 3; ++k) {
    std::sort(axes[k].begin(), axes[k].end());
    const std::size_t cut = axes[k].size() / 200;
    low[k] = axes[k][cut];
    high[k] = axes[k][axes[k].size() - 1 - cut];
  }
  for (int c = 0; c < 8; ++c)
    corners.push_back({c & 1 ? high[0] : low[0], c & 2 ? high[1] : low[1], c & 4 ? high[2] : low[2]});
}

void paint_fluid(Painter& painter, vtkUnstructuredGrid* grid) {
  vtkDataArray* radius = grid->GetPointData()->GetArray("radius");
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i)
    painter.ball(point_of(grid, i), radius ? 1.15 * radius->GetComponent(i, 0) : 0, liquid);
}

void paint_cloth(Painter& painter, vtkUnstructuredGrid* grid) {
  vtkDataArray* saturation = grid->GetPointData()->GetArray("saturation");
  each_triangle(grid, [&](vtkIdType, const std::array<vtkIdType, 3>& t) {
    std::array<Vec3, 3> corners;
    std::array<Colour, 3> colours;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = point_of(grid, t[k]);
      colours[k] = wet_colour(saturation ? saturation->GetComponent(t[k], 0) : 0);
    }
    painter.triangle(corners, colours);
  });
}

/// Solids as they are; of containers only the outline, so that one sees into them; planes not at all.
void paint_bodies(Painter& painter, vtkUnstructuredGrid* grid) {
  each_triangle(grid, [&](vtkIdType cell, const std::array<vtkIdType, 3>& t) {
    if (cell_value(grid, "plane", cell) != 0) return;
    const std::array<Vec3, 3> corners{point_of(grid, t[0]), point_of(grid, t[1]), point_of(grid, t[2])};
    if (!is_open(grid, cell)) painter.triangle(corners, {solid, solid, solid});
  });
}

/// The axis-aligned boxes around containers.
std::vector<std::array<Vec3, 2>> containers(const std::vector<Grid>& bodies) {
  std::vector<std::array<Vec3, 2>> boxes;
  for (const Grid& grid : bodies) {
    std::vector<int> number;  // of the body's box, by body; -1: none yet
    each_triangle(grid, [&](vtkIdType cell, const std::array<vtkIdType, 3>& t) {
      if (cell_value(grid, "container", cell) == 0 || cell_value(grid, "plane", cell) != 0) return;
      const auto body = static_cast<std::size_t>(std::max(0.0, cell_value(grid, "body", cell)));
      if (number.size() <= body) number.resize(body + 1, -1);
      if (number[body] < 0) {
        number[body] = static_cast<int>(boxes.size());
        boxes.push_back({point_of(grid, t[0]), point_of(grid, t[0])});
      }
      auto& [low, high] = boxes[static_cast<std::size_t>(number[body])];
      for (const vtkIdType i : t)
        for (std::size_t k = 0; k < 3; ++k) {
          low[k] = std::min(low[k], point_of(grid, i)[k]);
          high[k] = std::max(high[k], point_of(grid, i)[k]);
        }
    });
  }
  return boxes;
}

void paint_outline(Painter& painter, const std::array<Vec3, 2>& box) {
  const auto corner = [&](int c) { return Vec3{box[c & 1 ? 1 : 0][0], box[c & 2 ? 1 : 0][1], box[c & 4 ? 1 : 0][2]}; };
  for (int c = 0; c < 8; ++c)
    for (const int bit : {1, 2, 4})
      if (!(c & bit)) painter.line(corner(c), corner(c | bit), outline, 2 * finer * 0.6);
}

Picture painted(const Scenery& s, View view, const std::vector<Vec3>& shown, const Size& size) {
  fit(view, shown, size.width * finer, size.height * finer);
  Painter painter(view, size.width * finer, size.height * finer);
  for (const Grid& g : s.bodies) paint_bodies(painter, g);
  for (const auto& box : containers(s.bodies)) paint_outline(painter, box);
  if (s.cloth) paint_cloth(painter, s.cloth);
  if (s.fluid) paint_fluid(painter, s.fluid);
  return reduced(painter.picture(), finer);
}

std::string paint(const Scenery& s, const View& view, const std::vector<Vec3>& shown) {
  return data_url(painted(s, view, shown, thumbnail));
}

/// Numbers of so many of `count` things, spread evenly, the first and the last among them.
std::vector<std::size_t> spread(std::size_t count, int wanted) {
  std::vector<std::size_t> picked;
  const std::size_t n = std::min(count, static_cast<std::size_t>(std::max(wanted, 1)));
  for (std::size_t k = 0; k < n; ++k) picked.push_back(n == 1 ? count - 1 : (k * (count - 1) + (n - 1) / 2) / (n - 1));
  return picked;
}

/// Against gravity; +y where there is none.
Vec3 up_of(const RunRecord& run) {
  const yaml::Value* g = run.find("gravity");
  Vec3 up{0, 1, 0};
  if (!g || g->items.size() != 3) return up;
  Vec3 given;
  for (std::size_t k = 0; k < 3; ++k) given[k] = -std::strtod(g->items[k].text.c_str(), nullptr);
  return std::hypot(given[0], given[1], given[2]) > 0 ? given : up;
}

/// Horizontal directions that belong to `up`: to the front and to the right.
std::array<Vec3, 2> horizontal(const Vec3& up) {
  const View view = view_from(std::abs(up[1]) >= std::abs(up[2]) ? Vec3{0, 0, 1} : Vec3{0, -1, 0}, up);
  const Vec3 u = view_from({up[0], up[1], up[2]}, {up[1], up[2], up[0]}).back;
  const double along = view.back[0] * u[0] + view.back[1] * u[1] + view.back[2] * u[2];
  Vec3 front;
  for (std::size_t k = 0; k < 3; ++k) front[k] = view.back[k] - along * u[k];
  return {front, view.right};
}

Vec3 mix(const Vec3& a, double s, const Vec3& b, double t, const Vec3& c, double u) {
  return {s * a[0] + t * b[0] + u * c[0], s * a[1] + t * b[1] + u * c[1], s * a[2] + t * b[2] + u * c[2]};
}

Vec3 unit_of(const Vec3& v) { return view_from(v, {v[1], v[2], v[0] + 1}).back; }

/// Pictures of an earlier run in the same folder are older than this one's scene.yaml.
void take_rendered(const RunRecord& run, int count, Thumbnails& out) {
  const fs::path folder = run.folder / "pictures";
  if (!fs::is_directory(folder)) return;
  const auto begun = fs::last_write_time(run.folder / "scene.yaml");
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".png" && entry.last_write_time() >= begun) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  if (files.empty()) return;
  for (const std::size_t k : spread(files.size(), count)) {
    const Picture picture = read_png(files[k]);
    out.rendered.push_back(
        {data_url(reduced(picture, std::max(1, (picture.width + 239) / 480))), files[k].filename().string()});
  }
}

/// From the front, the right and above.
View oblique(const Vec3& up) {
  const auto [front, right] = horizontal(up);
  return view_from(mix(front, 1, right, 0.55, up, 0.55), up);
}

/// Corners around what these frames show.
std::vector<Vec3> corners_of(const std::vector<Scenery>& frames) {
  std::vector<Vec3> shown;
  for (const Scenery& s : frames) {
    if (s.fluid) add_corners(s.fluid, shown);
    if (s.cloth) add_corners(s.cloth, shown);
  }
  for (const auto& box : containers(frames.back().bodies)) shown.insert(shown.end(), box.begin(), box.end());
  if (shown.empty())
    for (const Grid& g : frames.back().bodies) add_corners(g, shown);
  return shown;
}

void paint_all(const RunRecord& run, int count, bool with_views, Thumbnails& out) {
  const FrameSeries series(run.folder);
  const std::vector<double> times = series.times();
  if (times.empty()) {
    out.notes.emplace_back("The run has written no frames, so there are no pictures.");
    return;
  }
  std::vector<Scenery> frames;
  for (const std::size_t k : spread(times.size(), count)) frames.push_back(series.read(times[k]));
  for (const Scenery& s : frames) out.cloth = out.cloth || s.cloth;
  const std::vector<Vec3> shown = corners_of(frames);
  const Vec3 up = unit_of(up_of(run));
  const auto [front, right] = horizontal(up);
  for (const Scenery& s : frames)
    out.frames.push_back({paint(s, oblique(up), shown), fmt::format("t = {:.4g} s", s.time)});
  if (!with_views) return;
  const Scenery& last = frames.back();
  out.views.push_back(
      {paint(last, view_from(front, up), shown), fmt::format("t = {:.4g} s, from the front", last.time)});
  out.views.push_back(
      {paint(last, view_from(right, up), shown), fmt::format("t = {:.4g} s, from the side", last.time)});
  const Vec3 behind{-front[0], -front[1], -front[2]};
  out.views.push_back({paint(last, view_from(up, behind), shown), fmt::format("t = {:.4g} s, from above", last.time)});
}

}  // namespace

Picture last_frame(const RunRecord& run, int width, int height) {
  const FrameSeries series(run.folder);
  const std::vector<double> times = series.times();
  if (times.empty()) throw std::runtime_error("The run has written no frames, so there are no pictures.");
  const std::vector<Scenery> frames{series.read(times.back())};
  return painted(frames.back(), oblique(unit_of(up_of(run))), corners_of(frames), {width, height});
}

Thumbnails thumbnails(const RunRecord& run, int frames, bool with_views) {
  Thumbnails out;
  try {
    paint_all(run, frames, with_views, out);
  } catch (const std::runtime_error& e) {
    out.notes.push_back(fmt::format("Pictures are missing: {}", e.what()));
  }
  try {
    take_rendered(run, frames, out);
  } catch (const std::runtime_error& e) {
    out.notes.push_back(fmt::format("Rendered pictures are missing: {}", e.what()));
  }
  return out;
}

}  // namespace drench
