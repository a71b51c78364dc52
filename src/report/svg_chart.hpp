#pragma once
// Charts as SVG in HTML: curves, and shares that are stacked. Colours are those of page_style.hpp, by number.

#include <string>
#include <vector>

namespace drench {

constexpr int colour_count = 8;  // the last is grey, for what is summed up

struct Series {
  std::string label;                       // stands at the curve's end; "" for none
  const std::vector<double>* x = nullptr;  // ascending
  const std::vector<double>* y = nullptr;
  int colour = 0;
  bool dashed = false;  // of a second run
};

/// A horizontal line, such as a tolerance.
struct Level {
  std::string label;
  double value = 0;
  int colour = 0;
};

struct LineChart {
  std::string title, x_label, y_label;  // with units: "time, s"
  std::vector<Series> series;
  std::vector<Level> levels;
  bool logarithmic = false;  // values of 0 and below stand on the axis then
  std::string note;          // under the chart; "" for none
};

/// A <figure>; "" when no series has two points.
std::string figure(const LineChart& chart);

/// A band of a stacked chart; `share` has an entry for each x, in %.
struct Band {
  std::string label;
  std::vector<double> share;
  int colour = 0;
};

struct StackChart {
  std::string title, x_label, y_label;
  std::vector<double> x;    // ascending
  std::vector<Band> bands;  // from below
  std::string note;
};

/// A <figure>; "" with fewer than two x.
std::string figure(const StackChart& chart);

}  // namespace drench
