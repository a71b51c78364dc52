#pragma once
// An axis of a chart: its range, and where its ticks are.

#include <span>
#include <string>
#include <vector>

namespace drench {

struct Tick {
  double value = 0;
  std::string text;
};

class Axis {
 public:
  /// Round numbers around all finite values; from 0 on where that wastes less than half of the axis. Values that are
  /// all the same stand in the middle.
  static Axis linear(double least, double most);
  /// Exactly this range, with ticks at round numbers.
  static Axis exact(double least, double most);
  /// Whole decades, at most nine below `most`. `least` and `most` are above 0.
  static Axis decades(double least, double most);

  /// 0 at the axis's beginning, 1 at its end; what lies beyond stands at the end.
  double place(double value) const;
  const std::vector<Tick>& ticks() const { return ticks_; }
  double least() const { return least_; }
  double most() const { return most_; }
  bool logarithmic() const { return logarithmic_; }

 private:
  double least_ = 0, most_ = 1;
  bool logarithmic_ = false;
  std::vector<Tick> ticks_;
};

struct Point {
  double x = 0, y = 0;
};

/// A curve in as few points as a picture of so many columns shows: the first, lowest, highest and last of each column.
/// Points that are not finite are left out. `x` ascends.
std::vector<Point> thinned(std::span<const double> x, std::span<const double> y, double least, double most,
                           int columns);

}  // namespace drench
