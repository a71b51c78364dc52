#include "report/painter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace drench {
namespace {

constexpr Colour ground{0.933F, 0.945F, 0.961F};  // style_sheet() has it behind pictures, too
constexpr double margin = 0.05;                   // of the picture
const Vec3 light{-0.36, 0.6, 0.71};               // to the right, up and back; of length 1

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3 unit(const Vec3& a) {
  const double length = std::sqrt(dot(a, a));
  return length > 0 ? Vec3{a[0] / length, a[1] / length, a[2] / length} : a;
}
Vec3 difference(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

bool finite(const Vec3& p) { return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]); }

/// Of a surface with this normal in the picture's axes. `shade`: how dark it is where no light falls.
Colour lit(const Colour& colour, const Vec3& normal, double shade, double gloss) {
  const double diffuse = std::max(0.0, dot(normal, light));
  const double shine = gloss * std::pow(std::max(0.0, dot(normal, unit({light[0], light[1], light[2] + 1}))), 40);
  const auto strength = static_cast<float>(1.04 - shade + shade * diffuse);
  Colour out;
  for (std::size_t c = 0; c < 3; ++c) out[c] = std::min(1.0F, colour[c] * strength + static_cast<float>(shine));
  return out;
}

/// First and last pixel whose middle may lie in [from, to], within the picture.
std::pair<int, int> pixels(double from, double to, int count) {
  const double last = static_cast<double>(count) - 1;
  return {static_cast<int>(std::clamp(std::floor(from), 0.0, last + 1)),
          static_cast<int>(std::clamp(std::ceil(to), -1.0, last))};
}

}  // namespace

Vec3 View::project(const Vec3& p) const {
  return {(dot(p, right) - least_x) * scale, (dot(p, up) - least_y) * scale, dot(p, back) * scale};
}

View view_from(const Vec3& back, const Vec3& up) {
  View view;
  view.back = unit(back);
  view.right = unit(cross(up, view.back));
  view.up = cross(view.back, view.right);
  return view;
}

void fit(View& view, const std::vector<Vec3>& points, int width, int height) {
  constexpr double none = std::numeric_limits<double>::infinity();
  double low[2] = {none, none}, high[2] = {-none, -none};
  for (const Vec3& p : points) {
    const double at[2] = {dot(p, view.right), dot(p, view.up)};
    for (int k = 0; k < 2; ++k) {
      low[k] = std::min(low[k], at[k]);
      high[k] = std::max(high[k], at[k]);
    }
  }
  if (!(low[0] <= high[0])) return;
  const double inner = 1 - 2 * margin, tiny = 1e-9;
  view.scale =
      std::min(width * inner / std::max(high[0] - low[0], tiny), height * inner / std::max(high[1] - low[1], tiny));
  view.least_x = (low[0] + high[0]) / 2 - width / view.scale / 2;
  view.least_y = (low[1] + high[1]) / 2 - height / view.scale / 2;
}

Painter::Painter(const View& view, int width, int height)
    : view_(view),
      picture_(width, height, ground),
      depth_(picture_.pixels.size(), -std::numeric_limits<float>::infinity()) {}

void Painter::put(int x, int y, double depth, const Colour& colour) {
  float& nearest =
      depth_[static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) + static_cast<std::size_t>(x)];
  if (static_cast<float>(depth) <= nearest) return;
  nearest = static_cast<float>(depth);
  picture_.at(x, y) = colour;
}

void Painter::ball(const Vec3& center, double radius, const Colour& colour) {
  if (!finite(center)) return;
  const Vec3 c = view_.project(center);
  const double r = std::max(radius * view_.scale, 0.7);
  const auto [left, right] = pixels(c[0] - r, c[0] + r, picture_.width);
  const auto [low, high] = pixels(c[1] - r, c[1] + r, picture_.height);
  for (int y = low; y <= high; ++y)
    for (int x = left; x <= right; ++x) {
      const double dx = (x + 0.5 - c[0]) / r, dy = (y + 0.5 - c[1]) / r, rest = 1 - dx * dx - dy * dy;
      if (rest < 0) continue;
      const Vec3 normal{dx, dy, std::sqrt(rest)};
      put(x, y, c[2] + r * normal[2], lit(colour, normal, 0.56, 0.35));
    }
}

void Painter::triangle(const std::array<Vec3, 3>& corners, const std::array<Colour, 3>& colours) {
  if (!std::all_of(corners.begin(), corners.end(), finite)) return;
  const Vec3 a = view_.project(corners[0]), b = view_.project(corners[1]), c = view_.project(corners[2]);
  const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  if (area == 0) return;
  Vec3 normal = unit(cross(difference(b, a), difference(c, a)));
  if (normal[2] < 0) normal = {-normal[0], -normal[1], -normal[2]};
  const auto [left, right] = pixels(std::min({a[0], b[0], c[0]}), std::max({a[0], b[0], c[0]}), picture_.width);
  const auto [low, high] = pixels(std::min({a[1], b[1], c[1]}), std::max({a[1], b[1], c[1]}), picture_.height);
  for (int y = low; y <= high; ++y)
    for (int x = left; x <= right; ++x) {
      const double px = x + 0.5, py = y + 0.5;
      const double v = ((px - a[0]) * (c[1] - a[1]) - (py - a[1]) * (c[0] - a[0])) / area;
      const double w = ((b[0] - a[0]) * (py - a[1]) - (b[1] - a[1]) * (px - a[0])) / area;
      const double u = 1 - v - w;
      if (u < 0 || v < 0 || w < 0) continue;
      Colour mixed;
      for (std::size_t k = 0; k < 3; ++k)
        mixed[k] = static_cast<float>(u * colours[0][k] + v * colours[1][k] + w * colours[2][k]);
      put(x, y, u * a[2] + v * b[2] + w * c[2], lit(mixed, normal, 0.46, 0));
    }
}

void Painter::line(const Vec3& from, const Vec3& to, const Colour& colour, double thickness) {
  if (!finite(from) || !finite(to)) return;
  const Vec3 a = view_.project(from), b = view_.project(to);
  const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
  const int steps = static_cast<int>(std::min(length * 2, 20000.0)) + 1;
  for (int k = 0; k <= steps; ++k) {
    const double t = static_cast<double>(k) / steps, x = a[0] + t * (b[0] - a[0]), y = a[1] + t * (b[1] - a[1]);
    const auto [left, right] = pixels(x - thickness / 2, x + thickness / 2 - 1, picture_.width);
    const auto [low, high] = pixels(y - thickness / 2, y + thickness / 2 - 1, picture_.height);
    for (int j = low; j <= high; ++j)
      for (int i = left; i <= right; ++i) put(i, j, a[2] + t * (b[2] - a[2]), colour);
  }
}

}  // namespace drench
