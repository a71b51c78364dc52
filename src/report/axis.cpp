#include "report/axis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace drench {
namespace {

constexpr int most_decades = 9;

/// 1, 2 or 5 times a power of ten: about five of them fit into `range`.
double round_step(double range) {
  const double rough = range / 5, power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (rough <= factor * power * 1.0001) return factor * power;
  return 10 * power;
}

std::vector<Tick> ticks_between(double least, double most, double step) {
  std::vector<Tick> ticks;
  for (double k = std::ceil(least / step - 1e-6); k * step <= most + 1e-6 * step && ticks.size() < 12; ++k) {
    const double value = k * step;
    ticks.push_back({value, k == 0 ? "0" : fmt::format("{:.6g}", value)});
  }
  return ticks;
}

std::string power_of_ten(int exponent) {
  static constexpr std::string_view digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  if (exponent == 0) return "1";
  if (exponent == 1) return "10";
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char c : std::to_string(std::abs(exponent))) text += digits[c - '0'];
  return text;
}

}  // namespace

Axis Axis::exact(double least, double most) {
  Axis axis;
  axis.least_ = least;
  axis.most_ = most > least ? most : least + std::max(1e-12, std::abs(least) * 1e-6);
  axis.ticks_ = ticks_between(axis.least_, axis.most_, round_step(axis.most_ - axis.least_));
  return axis;
}

Axis Axis::linear(double least, double most) {
  if (least >= 0 && least < 0.5 * most) least = 0;
  if (most <= 0 && most > 0.5 * least) most = 0;
  // Rounding noise is no curve: a range far below the value itself is drawn as a level line.
  const double smallest = 1e-6 * std::max(std::abs(least), std::abs(most));
  if (most - least <= smallest) {
    const double half = least == 0 ? 1 : 0.1 * std::abs(least);
    least = least == 0 ? 0 : least - half;
    most += half;
  }
  const double step = round_step(most - least);
  return exact(std::floor(least / step + 1e-6) * step, std::ceil(most / step - 1e-6) * step);
}

Axis Axis::decades(double least, double most) {
  Axis axis;
  axis.logarithmic_ = true;
  const int high = static_cast<int>(std::ceil(std::log10(most) - 1e-9));
  int low = static_cast<int>(std::floor(std::log10(least) + 1e-9));
  low = std::min(std::max(low, high - most_decades), high - 1);
  axis.least_ = std::pow(10, low);
  axis.most_ = std::pow(10, high);
  const int every = high - low > 5 ? 2 : 1;
  for (int k = high; k >= low; k -= every) axis.ticks_.push_back({std::pow(10, k), power_of_ten(k)});
  return axis;
}

double Axis::place(double value) const {
  const double part = logarithmic_ ? std::log(std::max(value, least_) / least_) / std::log(most_ / least_)
                                   : (value - least_) / (most_ - least_);
  return std::clamp(part, 0.0, 1.0);
}

namespace {

/// The points of one column of the picture.
struct Column {
  std::size_t first = 0, lowest = 0, highest = 0, last = 0;
};

void append(std::vector<Point>& points, const Column& c, std::span<const double> x, std::span<const double> y) {
  std::size_t order[] = {c.first, std::min(c.lowest, c.highest), std::max(c.lowest, c.highest), c.last};
  std::size_t before = x.size();
  for (const std::size_t i : order) {
    if (i != before) points.push_back({x[i], y[i]});
    before = i;
  }
}

}  // namespace

std::vector<Point> thinned(std::span<const double> x, std::span<const double> y, double least, double most,
                           int columns) {
  std::vector<Point> points;
  Column column;
  int current = -1;
  const double width = most > least ? (most - least) / columns : 1;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    const int here = static_cast<int>(std::clamp((x[i] - least) / width, 0.0, static_cast<double>(columns)));
    if (here != current) {
      if (current >= 0) append(points, column, x, y);
      column = {i, i, i, i};
      current = here;
    }
    if (y[i] < y[column.lowest]) column.lowest = i;
    if (y[i] > y[column.highest]) column.highest = i;
    column.last = i;
  }
  if (current >= 0) append(points, column, x, y);
  return points;
}

}  // namespace drench
