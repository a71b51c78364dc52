#pragma once
// Balls, triangles and lines painted into a picture, the nearest in front. No graphics library or display is needed.

#include <array>
#include <vector>

#include "base/types.hpp"
#include "report/picture.hpp"

namespace drench {

/// A parallel projection. `right`, `up` and `back` (towards the eye) are unit vectors, across each other.
struct View {
  Vec3 right{1, 0, 0}, up{0, 1, 0}, back{0, 0, 1};
  double least_x = 0, least_y = 0;  // m: what the picture's lower left corner shows
  double scale = 1;                 // pixels/m
  /// Pixels to the right and up, and pixels towards the eye.
  Vec3 project(const Vec3& position) const;
};

/// Looks at things from where `back` points to, `up` upwards (not along `back`). It has no place yet: see fit().
View view_from(const Vec3& back, const Vec3& up);

/// Makes these points fill a picture of this size, in pixels, with a margin.
void fit(View& view, const std::vector<Vec3>& points, int width, int height);

class Painter {
 public:
  Painter(const View& view, int width, int height);
  void ball(const Vec3& center, double radius, const Colour& colour);
  /// A sheet with two sides. The colours of its corners are mixed between them.
  void triangle(const std::array<Vec3, 3>& corners, const std::array<Colour, 3>& colours);
  void line(const Vec3& a, const Vec3& b, const Colour& colour, double thickness);
  const Picture& picture() const { return picture_; }

 private:
  /// Paints a pixel unless something nearer is there.
  void put(int x, int y, double depth, const Colour& colour);

  View view_;
  Picture picture_;
  std::vector<float> depth_;
};

}  // namespace drench
