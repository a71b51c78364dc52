#include "output/liquid_field.hpp"

#include <algorithm>
#include <cmath>
#include <compare>
#include <numbers>

namespace drench {
namespace {

constexpr double lone_density = 0.677;  // 1; liquid_field.hpp
constexpr double farthest = 1e9;        // m; beyond it a lattice's indices mean nothing

bool usable(const Vec3& x) {
  return std::all_of(x.begin(), x.end(), [](double c) { return std::abs(c) < farthest; });  // not if it is not a number
}

/// A blob that reaches into a block; the order that they sort in is that of the blocks and, in each, of the blobs.
struct Reach {
  std::array<std::int64_t, 3> block;  // z y x
  Index blob;
  auto operator<=>(const Reach&) const = default;
};

std::int64_t floor_index(double x) { return static_cast<std::int64_t>(std::floor(x)); }

}  // namespace

LiquidField::LiquidField(const Model& model, const HostState& state, double step)
    : step_(step), widest_(2 * std::max(model.spacing, 1.4 * step)), grid_(widest_) {
  const double d3 = model.spacing * model.spacing * model.spacing;
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    if (!usable(state.fluid_position[i])) continue;
    const double full = static_cast<double>(state.fluid_mass[i]) / static_cast<double>(quanta_per_particle);
    const double h = 2 * std::max(model.spacing * std::cbrt(full), 1.4 * step);
    const double share = full * d3 * 315 / (64 * std::numbers::pi * h * h * h);
    blobs_.push_back({state.fluid_position[i], h, share, 0, static_cast<Index>(i)});
    grid_.add(state.fluid_position[i]);
  }
  for (Blob& blob : blobs_) for_near(blob.x, [&](const Blob&, double weight) { blob.density += weight; });
  for (Blob& blob : blobs_) blob.share /= std::min(1.0, blob.density / lone_density);
}

void LiquidField::for_blocks(const std::function<void(const Block&)>& f) const {
  std::vector<Reach> reaches;
  for (std::size_t b = 0; b < blobs_.size(); ++b) {
    const Blob& blob = blobs_[b];
    std::array<std::int64_t, 3> first{}, last{};
    for (std::size_t a = 0; a < 3; ++a) {  // a block's last vertices are the next one's first
      first[a] = floor_index(((blob.x[a] - blob.h) / step_ - 0.5) / cells);
      last[a] = floor_index(((blob.x[a] + blob.h) / step_ - 0.5) / cells);
    }
    for (auto z = first[2]; z <= last[2]; ++z)
      for (auto y = first[1]; y <= last[1]; ++y)
        for (auto x = first[0]; x <= last[0]; ++x) reaches.push_back({{z, y, x}, static_cast<Index>(b)});
  }
  std::sort(reaches.begin(), reaches.end());

  std::vector<double> value(std::size_t{vertices} * vertices * vertices);
  std::array<double, vertices> square{};
  for (auto begin = reaches.begin(), end = begin; begin != reaches.end(); begin = end) {
    std::fill(value.begin(), value.end(), 0.0);
    Block block{{begin->block[2] * cells, begin->block[1] * cells, begin->block[0] * cells},
                {vertices, vertices, vertices},
                {-1, -1, -1},
                value};
    for (; end != reaches.end() && end->block == begin->block; ++end) {
      const Blob& blob = blobs_[static_cast<std::size_t>(end->blob)];
      std::array<int, 3> low{}, high{};
      const auto from_blob = [&](std::size_t a, int i) {  // m; the same bits in every block
        return (static_cast<double>(block.first[a] + i) + 0.5) * step_ - blob.x[a];
      };
      for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::max(0, static_cast<int>(std::ceil((-blob.h - from_blob(a, 0)) / step_)));
        high[a] = std::min(cells, static_cast<int>(std::floor((blob.h - from_blob(a, 0)) / step_)));
        block.low[a] = std::min(block.low[a], low[a]);
        block.high[a] = std::max(block.high[a], high[a]);
      }
      const double per_square = 1 / (blob.h * blob.h);
      const auto part = [&](std::size_t a, int i) { return from_blob(a, i) * from_blob(a, i) * per_square; };
      for (int i = low[0]; i <= high[0]; ++i) square[static_cast<std::size_t>(i)] = part(0, i);
      for (int k = low[2]; k <= high[2]; ++k)
        for (int j = low[1]; j <= high[1]; ++j) {
          const double rest = 1 - part(1, j) - part(2, k);
          double* row = &value[static_cast<std::size_t>((k * vertices + j) * vertices)];
          for (int i = low[0]; i <= high[0]; ++i) {
            const double t = std::max(0.0, rest - square[static_cast<std::size_t>(i)]);
            row[i] += blob.share * t * t * t;
          }
        }
    }
    f(block);
  }
}

}  // namespace drench
