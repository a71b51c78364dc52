#pragma once
// Small pictures of a run's frames.

#include <string>
#include <vector>

#include "report/picture.hpp"
#include "report/run_record.hpp"

namespace drench {

struct Thumbnail {
  std::string url;      // data:
  std::string caption;  // "t = 0.2 s, from the side"
};

struct Thumbnails {
  std::vector<Thumbnail> frames;    // over the run
  std::vector<Thumbnail> views;     // of the last frame: from the front, the side and above
  std::vector<Thumbnail> rendered;  // tools/render's pictures of this run, where its folder has them
  std::vector<std::string> notes;   // lines: why there is none, and what they do not show
  bool cloth = false;               // there is cloth in them, so that its colours want a key
};

/// The last frame from the front, the right and above; of this size in pixels. Throws std::runtime_error for a run
/// without frames.
Picture last_frame(const RunRecord& run, int width, int height);

/// Paints so many frames of the run, the first and the last among them, and takes up as many pictures of tools/render.
Thumbnails thumbnails(const RunRecord& run, int frames, bool with_views);

}  // namespace drench
