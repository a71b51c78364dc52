#pragma once
// Pictures that stand in a page.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace drench {

using Colour = std::array<float, 3>;  // red, green, blue from 0 to 1

struct Picture {
  int width = 0, height = 0;
  std::vector<Colour> pixels;  // rows from the bottom up
  Picture(int wide, int high, const Colour& ground)
      : width(wide), height(high), pixels(static_cast<std::size_t>(wide) * static_cast<std::size_t>(high), ground) {}
  Colour& at(int x, int y) {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
  const Colour& at(int x, int y) const { return const_cast<Picture*>(this)->at(x, y); }
};

/// Each pixel is the mean of factor × factor pixels; what is left over at the edges goes. `factor` from 1 on.
Picture reduced(const Picture& picture, int factor);

/// The picture as a data: URL (JPEG). Throws std::runtime_error when it cannot be encoded.
std::string data_url(const Picture& picture);

/// Writes a PNG of 8 bits a channel in one move. Throws std::runtime_error when it cannot be written.
void write_png(const Picture& picture, const std::filesystem::path& path);

/// Reads a PNG of 8 bits a channel. Throws std::runtime_error when it is missing, damaged or of another kind.
Picture read_png(const std::filesystem::path& path);

}  // namespace drench
