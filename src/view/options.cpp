#include "view/options.hpp"

#include <fmt/format.h>

#include <charconv>
#include <regex>

#include "named_views.hpp"
#include "view/named_view.hpp"

namespace drench {
namespace {

std::string check_size(const std::string& text) {
  const auto [width, height] = picture_size(text);
  if (std::min(width, height) >= least_side && std::max(width, height) <= most_side) return {};
  return fmt::format("{} is not a size; allowed: WIDTHxHEIGHT of {} to {} pixels", text, least_side, most_side);
}

std::string check_frame(const std::string& text) {
  static const std::regex number("[0-9]{1,9}");
  if (text == "last" || std::regex_match(text, number)) return {};
  return fmt::format("{} is not a frame; allowed: a number from 0, or last", text);
}

std::string check_png(const std::string& text) {
  return text.ends_with(".png") ? std::string() : fmt::format("{} is not a picture file; allowed: NAME.png", text);
}

std::string check_count(const std::string& text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value >= 1) return {};
  return fmt::format("{} is not allowed; allowed: a whole number from 1 to 2147483647", text);
}

}  // namespace

std::pair<int, int> picture_size(const std::string& text) {
  static const std::regex size("([0-9]{1,5})x([0-9]{1,5})");
  std::smatch match;
  if (!std::regex_match(text, match, size)) return {0, 0};
  return {std::stoi(match[1]), std::stoi(match[2])};
}

void add_view_options(CLI::App& command, ViewOptions& options) {
  command.add_option("OUT", options.folder, "output folder of a run")->required();
  command.add_flag("--follow", options.follow, "show each new frame of a run in progress");
  command.add_option("--frame", options.frame, "first frame to show, from 0 (default: the last)")->check(check_frame);
  command.add_option("--color", options.color, "field to colour by, or look: water, and cloth that darkens when wet");
  command.add_option("--liquid", options.liquid, "particles or surface (default: the surface if the run has one)")
      ->check(CLI::IsMember({"auto", "particles", "surface"}));
  command
      .add_option("--camera", options.camera,
                  "auto, below, front, top, or px,py,pz,fx,fy,fz: position and focal point, m")
      ->check([](const std::string& text) { return parse_view(text) ? std::string() : camera_choices(text); });
  command.add_option("--size", options.size, "size of the window or picture in pixels (default: 1280x960)")
      ->check(check_size);
  auto* one = command.add_option("--screenshot", options.screenshot, "write this PNG file of one frame; no window")
                  ->check(check_png);
  auto* many =
      command.add_option("--pictures", options.pictures, "write a PNG file of each frame into this folder; no window")
          ->excludes(one);
  command.add_option("--frames", options.frames, "with --pictures: only this many frames, evenly spaced")
      ->check(check_count)
      ->needs(many);
  command.add_option("--animation", options.animation, "with --pictures: also write a video (.ogv)")
      ->check([](const std::string& text) {
        return text.ends_with(".ogv") ? std::string() : fmt::format("{} is not a video file; allowed: NAME.ogv", text);
      })
      ->needs(many);
  command.add_option("--fps", options.fps, "pictures per second of the video (default: real time, at most 50)")
      ->check([](const std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && value >= 0.1 && value <= 100;
        return good ? std::string() : fmt::format("{} is not a rate; allowed: 0.1 to 100 pictures per second", text);
      });
  command.footer(
      "Keys: space plays and pauses; left and right step; Home and End; c colours by the next field, C by the one "
      "before;\n"
      "l particles or surface; r shows all; 1 to 4 auto, below, front, top; < and > slower and faster; s saves a "
      "picture;\n"
      "h shows the keys; q ends.\n"
      "Examples:\n"
      "  drench view out/scene\n"
      "  drench view out/scene --color velocity --frame 10\n"
      "  drench view out/scene --screenshot scene.png --frame last --size 900x600");
}

}  // namespace drench
