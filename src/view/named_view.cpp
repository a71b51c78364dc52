#include "view/named_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <utility>

namespace drench {

std::optional<View> parse_view(const std::string& text) {
  static const std::map<std::string, std::pair<double, double>> named{
      {"auto", {32, 24}}, {"below", {32, -22}}, {"front", {0, 8}}, {"top", {0, 80}}};
  if (const auto it = named.find(text); it != named.end()) return View{it->second.first, it->second.second, {}};
  std::istringstream in(text);
  std::array<double, 6> numbers{};
  for (std::size_t i = 0; i < 6; ++i) {
    char comma = ',';
    if (i > 0) in >> comma;
    if (!(in >> numbers[i]) || comma != ',' || !std::isfinite(numbers[i])) return std::nullopt;
  }
  const bool apart = !std::equal(numbers.begin(), numbers.begin() + 3, numbers.begin() + 3);
  if (!apart || in.peek() != std::istringstream::traits_type::eof()) return std::nullopt;
  return View{0, 0, numbers};
}

std::string camera_choices(const std::string& text) {
  return fmt::format("{} is not a view; allowed: auto, below, front, top, or px,py,pz,fx,fy,fz, in m", text);
}

}  // namespace drench
