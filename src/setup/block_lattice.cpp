#include "setup/block_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace drench {

BlockLattice::BlockLattice(const Box& box, double spacing) : spacing_(spacing) {
  constexpr double rounding = 1e-9, widest = 1.05;  // of a layer, over d
  double fill = 1;                                  // volume of a particle over d³
  bool fits = true;
  for (std::size_t a = 0; a < 3; ++a) {
    const double extent = box.max[a] - box.min[a], whole = std::max(1.0, std::round(extent / spacing));
    const bool multiple = std::abs(extent / spacing - whole) <= rounding * whole;
    layers_[a] = extent <= widest * whole * spacing ? whole : whole + 1;
    step_[a] = multiple ? spacing : extent / layers_[a];
    first_[a] = box.min[a] + 0.5 * step_[a] + 0.5 * (extent - layers_[a] * step_[a]);
    fits = fits && multiple;
    if (!multiple) fill *= step_[a] / spacing;
  }
  if (fits) return;
  // Rounded once for the whole block: particles rounded one by one would lose up to half a quantum each.
  const double mass = fill * static_cast<double>(quanta_per_particle);
  least_ = static_cast<Quanta>(std::floor(mass));
  heavier_ = std::llround(std::min(count(), 0x1p62) * (mass - std::floor(mass)));
}

double BlockLattice::narrowest() const { return *std::min_element(step_.begin(), step_.end()); }

std::string BlockLattice::squeezed_axes() const {
  std::vector<std::string> axes;
  for (std::size_t a = 0; a < 3; ++a)
    if (step_[a] < 0.95 * spacing_) axes.emplace_back(1, "xyz"[a]);
  if (axes.empty()) return "";
  std::string text = axes.front();
  for (std::size_t k = 1; k < axes.size(); ++k) text += (k + 1 < axes.size() ? ", " : " and ") + axes[k];
  return text;
}

}  // namespace drench
