#pragma once
// What a viewer shows of a run: which frame, coloured by which field, from where. The window and the PNG files share
// it.

#include <optional>
#include <string>
#include <vector>

#include "view/named_view.hpp"
#include "view/options.hpp"
#include "view/picture.hpp"
#include "view/run_frames.hpp"

namespace drench {

class Show {
 public:
  /// Throws std::runtime_error where the folder has no frame to show, or the field is none of its frames'.
  explicit Show(const ViewOptions& options);

  Picture& picture() { return picture_; }
  const RunFrames& frames() const { return frames_; }
  std::size_t at() const { return at_; }
  std::size_t last() const { return frames_.times().size() - 1; }

  /// Shows frame i, or the last one where there are fewer.
  void go_to(std::size_t i);
  /// Looks for new frames; shows the newest where the one before was shown. True when there are some.
  bool follow();
  /// Colours by the next field (+1) or the one before (−1); the plain look is one of them.
  void next_color(int direction);
  void switch_liquid();
  /// Points the camera so that all that happens in the run is seen.
  void frame(const View& view, int width, int height);
  /// "velocity", or "look".
  std::string color() const;

 private:
  std::vector<Moment> spread() const;
  void choose(const std::string& field);
  void redraw();

  RunFrames frames_;
  Picture picture_;
  std::vector<FieldRange> ranges_;
  std::optional<std::size_t> field_;  // none: the plain look
  std::vector<Vec3> seen_;            // m; what the camera has to show
  Vec3 up_;
  std::size_t at_ = 0;
  bool surface_ = true;
  Moment moment_;
};

}  // namespace drench
