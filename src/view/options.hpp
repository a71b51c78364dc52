#pragma once
// The command line of `drench view`: read by drench, which refuses what is wrong, and by drench-view, which does it.

#include <CLI/CLI.hpp>
#include <string>

namespace drench {

struct ViewOptions {
  std::string folder;          // of a run
  bool follow = false;         // show each new frame of a run that goes on
  std::string frame = "last";  // a number from 0, or last
  std::string screenshot;      // a PNG file; no window then
  std::string pictures;        // a folder for PNG files of many frames; no window then
  int frames = 0;              // how many of them, evenly spread; 0: all
  std::string animation;       // with pictures: an Ogg Theora film of them too
  double fps = 0;              // its pictures a second; 0: as time went, at most 50
  std::string size = "1280x960";
  std::string color = "look";   // or a field of the frames
  std::string liquid = "auto";  // particles or surface; auto: the surface where the run has one
  std::string camera = "auto";  // auto, below, front, top, or six numbers: position and focal point, m
};

void add_view_options(CLI::App& command, ViewOptions& options);

/// "1280x960" → 1280, 960.
std::pair<int, int> picture_size(const std::string& text);

}  // namespace drench
