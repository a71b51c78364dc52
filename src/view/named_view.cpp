#include "view/named_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "named_views.hpp"

namespace drench {

std::optional<View> parse_view(const std::string& text) {
  for (const NamedView& named : named_views)
    if (named.name == text) return View{named.azimuth, named.elevation, {}};
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
  std::string names;
  for (const NamedView& named : named_views) names += fmt::format("{}, ", named.name);
  return fmt::format("{} is not a view; allowed: {}or px,py,pz,fx,fy,fz, in m", text, names);
}

}  // namespace drench
