#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "setup/mesh_files.hpp"

namespace drench {
namespace {

/// As VTK tells a text (kwsys::SystemTools::DetectFileType): less than a twentieth of its first bytes are none of a
/// text.
bool is_text(const std::string& bytes) {
  const std::size_t looked_at = std::min<std::size_t>(bytes.size(), 256);
  const auto others =
      std::count_if(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(looked_at),
                    [](unsigned char c) { return !((c >= 0x20 && c <= 0x7f) || c == '\n' || c == '\r' || c == '\t'); });
  return looked_at > 0 && 20 * static_cast<std::size_t>(others) < looked_at;
}

}  // namespace

void check_stl_file(const std::string& path) {
  constexpr std::int64_t before = 84, each = 50;  // bytes of a binary file: header and count, a triangle
  const std::string bytes = bytes_of_mesh(path);
  if (is_text(bytes)) return;  // VTK says what is wrong in it
  const auto size = static_cast<std::int64_t>(bytes.size());
  if (size < before) unreadable_mesh(path, "it is neither a text file nor long enough for a binary file");
  std::uint32_t count = 0;
  for (std::size_t b = 84; b-- > 80;) count = 256 * count + static_cast<unsigned char>(bytes[b]);
  // VTK goes by the length where the count is 0 or, as a signed number, negative.
  if (count < 0x80000000u && count > (size - before) / each)
    unreadable_mesh(
        path, fmt::format("its header gives {} triangles, but its size allows {}", count, (size - before) / each));
}

}  // namespace drench
