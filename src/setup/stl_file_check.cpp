#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>

#include "setup/mesh_file_check.hpp"

namespace drench {

void check_stl_file(const std::string& path) {
  constexpr std::int64_t before = 84, each = 50;  // bytes of a binary file: header and count, a triangle
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const auto is_text = [](char c) { return (c >= ' ' && c <= '~') || c == '\t' || c == '\n' || c == '\r'; };
  if (std::all_of(bytes.begin(), bytes.end(), is_text)) {
    if (bytes.substr(0, bytes.find_first_of(" \r\n")) != "solid")
      unreadable_mesh(path, "it does not begin with 'solid'");
    return;
  }
  const auto size = static_cast<std::int64_t>(bytes.size());
  if (size < before) unreadable_mesh(path, "it is neither text nor long enough for a binary file");
  std::int64_t count = 0;
  for (int b = 3; b >= 0; --b)
    count = 256 * count + static_cast<unsigned char>(bytes[static_cast<std::size_t>(80 + b)]);
  if (count > (size - before) / each)
    unreadable_mesh(path,
                    fmt::format("it says that it has {} triangles, {} fit into it", count, (size - before) / each));
}

}  // namespace drench
