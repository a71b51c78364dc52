#include "report/svg_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "report/axis.hpp"
#include "report/html.hpp"

namespace drench {
namespace {

using html::escaped;

// In the units of the SVG, which are pixels at its natural size.
constexpr double width = 500, height = 262, left = 58, right = 124, top = 26, bottom = 40;
constexpr double plot_width = width - left - right, plot_height = height - top - bottom;
constexpr double line_height = 15;

struct Frame {
  Axis x, y;
  double px(double value) const { return left + plot_width * x.place(value); }
  double py(double value) const { return top + plot_height * (1 - y.place(value)); }
};

struct Range {
  double least = std::numeric_limits<double>::infinity(), most = -std::numeric_limits<double>::infinity();
  void add(double v) {
    if (!std::isfinite(v)) return;
    least = std::min(least, v);
    most = std::max(most, v);
  }
  bool empty() const { return !(least <= most); }
};

std::string axes(const Frame& f, const std::string& x_label, const std::string& y_label) {
  std::string out;
  for (const Tick& t : f.y.ticks())
    out += fmt::format(
        "<line class=\"grid\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/><text class=\"e\" x=\"{:.1f}\" "
        "y=\"{:.1f}\">{}</text>\n",
        left, left + plot_width, f.py(t.value), f.py(t.value), left - 6, f.py(t.value) + 4.5, escaped(t.text));
  for (const Tick& t : f.x.ticks())
    out += fmt::format(
        "<line class=\"tick\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/><text class=\"m\" x=\"{:.1f}\" "
        "y=\"{:.1f}\">{}</text>\n",
        f.px(t.value), f.px(t.value), top + plot_height, top + plot_height + 4, f.px(t.value), top + plot_height + 17,
        escaped(t.text));
  out += fmt::format("<line class=\"axis\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>\n", left,
                     left + plot_width, top + plot_height, top + plot_height);
  out += fmt::format("<text class=\"m\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", left + plot_width / 2, height - 5,
                     escaped(x_label));
  return out + fmt::format("<text x=\"4\" y=\"13\">{}</text>\n", escaped(y_label));
}

/// Words at the right edge, moved apart so that none covers another.
class EdgeLabels {
 public:
  void add(double y, const std::string& label, int colour) {
    if (!label.empty()) labels_.push_back({y, label, colour});
  }
  std::string svg() {
    std::sort(labels_.begin(), labels_.end(), [](const Label& a, const Label& b) { return a.y < b.y; });
    double free_from = top, free_to = top + plot_height;
    for (Label& l : labels_) {
      l.y = std::max(l.y, free_from);
      free_from = l.y + line_height;
    }
    for (auto l = labels_.rbegin(); l != labels_.rend(); ++l) {
      l->y = std::min(l->y, free_to);
      free_to = l->y - line_height;
    }
    std::string out;
    for (const Label& l : labels_)
      out += fmt::format("<text class=\"t{}\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", l.colour, left + plot_width + 6,
                         l.y + 4.5, escaped(l.text));
    return out;
  }

 private:
  struct Label {
    double y;
    std::string text;
    int colour;
  };
  std::vector<Label> labels_;
};

std::string svg(const Frame& f, const std::string& title, const std::string& content) {
  return fmt::format(
      "<svg class=\"chart\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\" data-box=\"{} {} {} {}\" "
      "data-x=\"{:.9g} {:.9g}\" data-y=\"{:.9g} {:.9g}\" data-log=\"{}\">\n{}</svg>\n",
      width, height, escaped(title), left, top, plot_width, plot_height, f.x.least(), f.x.most(), f.y.least(),
      f.y.most(), f.y.logarithmic() ? 1 : 0, content);
}

std::string wrap(const std::string& title, const std::string& picture, const std::string& note) {
  return fmt::format("<figure><figcaption>{}</figcaption>\n{}{}</figure>\n", escaped(title), picture,
                     note.empty() ? "" : html::note(note));
}

Axis y_axis(const LineChart& chart) {
  Range all, positive;
  const auto add = [&](double v) {
    all.add(v);
    if (v > 0) positive.add(v);
  };
  for (const Series& s : chart.series)
    for (const double v : *s.y) add(v);
  for (const Level& l : chart.levels) add(l.value);
  if (!chart.logarithmic) return all.empty() ? Axis::linear(0, 1) : Axis::linear(all.least, all.most);
  return positive.empty() ? Axis::decades(0.1, 1) : Axis::decades(positive.least, positive.most);
}

std::string curve(const Frame& f, const Series& s, EdgeLabels& labels) {
  const auto points = thinned(*s.x, *s.y, f.x.least(), f.x.most(), static_cast<int>(plot_width));
  if (points.empty()) return "";
  std::string d;
  for (const Point& p : points) d += fmt::format("{}{:.1f} {:.1f}", d.empty() ? "M" : "L", f.px(p.x), f.py(p.y));
  labels.add(f.py(points.back().y), s.label, s.colour);
  return fmt::format("<path class=\"l s{}{}\" data-name=\"{}\" d=\"{}\"/>\n", s.colour, s.dashed ? " dashed" : "",
                     escaped(s.label), d);
}

bool can_be_drawn(const LineChart& chart) {
  return std::any_of(chart.series.begin(), chart.series.end(), [](const Series& s) { return s.y->size() >= 2; });
}

}  // namespace

std::string figure(const LineChart& chart) {
  if (!can_be_drawn(chart)) return "";
  Range time;
  time.add(0);
  for (const Series& s : chart.series)
    if (!s.x->empty()) time.add(s.x->back());
  const Frame f{Axis::exact(time.least, time.most), y_axis(chart)};
  EdgeLabels labels;
  std::string content = axes(f, chart.x_label, chart.y_label);
  for (const Level& l : chart.levels) {
    content += fmt::format("<line class=\"level s{}\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>\n",
                           l.colour, left, left + plot_width, f.py(l.value), f.py(l.value));
    labels.add(f.py(l.value), l.label, l.colour);
  }
  for (const Series& s : chart.series) content += curve(f, s, labels);
  return wrap(chart.title, svg(f, chart.title, content + labels.svg()), chart.note);
}

namespace {

/// The band between two sums.
std::string band(const Frame& f, const StackChart& chart, const Band& b, const std::vector<double>& below,
                 const std::vector<double>& above) {
  std::string d;
  for (std::size_t i = 0; i < chart.x.size(); ++i)
    d += fmt::format("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", f.px(chart.x[i]), f.py(above[i]));
  for (std::size_t i = chart.x.size(); i-- > 0;) d += fmt::format("L{:.1f} {:.1f}", f.px(chart.x[i]), f.py(below[i]));
  return fmt::format("<path class=\"f{}\" d=\"{}Z\"><title>{}</title></path>\n", b.colour, d, escaped(b.label));
}

}  // namespace

std::string figure(const StackChart& chart) {
  if (chart.x.size() < 2) return "";
  const Frame f{Axis::exact(0, chart.x.back()), Axis::exact(0, 100)};
  EdgeLabels labels;
  std::string bands;
  std::vector<double> below(chart.x.size(), 0);
  for (const Band& b : chart.bands) {
    std::vector<double> above = below;
    for (std::size_t i = 0; i < above.size(); ++i) above[i] += b.share[i];
    bands += band(f, chart, b, below, above);
    labels.add((f.py(below.back()) + f.py(above.back())) / 2, b.label, b.colour);
    below = std::move(above);
  }
  return wrap(chart.title, svg(f, chart.title, bands + axes(f, chart.x_label, chart.y_label) + labels.svg()),
              chart.note);
}

}  // namespace drench
