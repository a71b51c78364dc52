#include "output/liquid_field.hpp"

#include <algorithm>
#include <cmath>
#include <compare>

#include "base/for_ranges.hpp"

namespace drench {
namespace {

constexpr double farthest = 1e9;  // m; beyond it a lattice's indices mean nothing

bool usable(const Vec3& x) {
  return std::all_of(x.begin(), x.end(), [](double c) { return std::abs(c) < farthest; });  // not if it is not a number
}

/// A blob that reaches into a block; the order that they sort in is that of the blocks and, in each, of the blobs.
struct Reach {
  std::array<std::int64_t, 3> block;  // z y x
  Index blob;
  auto operator<=>(const Reach&) const = default;
};

std::vector<Blob> kernels(const Model& model, const HostState& state, double step, int threads) {
  std::vector<SurfaceParticle> particles;
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    if (!usable(state.fluid_position[i])) continue;
    const double full = static_cast<double>(state.fluid_mass[i]) / static_cast<double>(quanta_per_particle);
    const double size = std::max(model.spacing * std::cbrt(full), 1.4 * step);
    particles.push_back({state.fluid_position[i], full, size, static_cast<Index>(i)});
  }
  return model.scene.output.surface_kernel == SurfaceKernel::isotropic
             ? round_kernels(particles, model.spacing)
             : anisotropic_kernels(particles, model.spacing, threads);
}

double widest(const std::vector<Blob>& blobs, double least) {
  for (const Blob& blob : blobs) least = std::max({least, blob.reach[0], blob.reach[1], blob.reach[2]});
  return least;
}

std::int64_t floor_index(double x) { return static_cast<std::int64_t>(std::floor(x)); }

/// Adds a kernel to the values of a block.
void add(const Blob& blob, double step, LiquidField::Block& block, std::vector<double>& value) {
  constexpr int vertices = LiquidField::vertices;
  std::array<std::array<double, vertices>, 3> from{};  // m, from the kernel's middle; the same bits in every block
  std::array<int, 3> low{}, high{};
  for (std::size_t a = 0; a < 3; ++a) {
    for (int i = 0; i < vertices; ++i)
      from[a][static_cast<std::size_t>(i)] = (static_cast<double>(block.first[a] + i) + 0.5) * step - blob.x[a];
    low[a] = std::max(0, static_cast<int>(std::ceil((-blob.reach[a] - from[a][0]) / step)));
    high[a] = std::min(vertices - 1, static_cast<int>(std::floor((blob.reach[a] - from[a][0]) / step)));
    block.low[a] = std::min(block.low[a], low[a]);
    block.high[a] = std::max(block.high[a], high[a]);
  }
  const auto& m = blob.metric;
  for (int k = low[2]; k <= high[2]; ++k)
    for (int j = low[1]; j <= high[1]; ++j) {
      const double y = from[1][static_cast<std::size_t>(j)], z = from[2][static_cast<std::size_t>(k)];
      const double rest = 1 - (m[1] * y * y + m[2] * z * z + 2 * m[3] * y * z), mixed = 2 * (m[5] * y + m[4] * z);
      double* row = &value[static_cast<std::size_t>((k * vertices + j) * vertices)];
      for (int i = low[0]; i <= high[0]; ++i) {
        const double x = from[0][static_cast<std::size_t>(i)], t = std::max(0.0, rest - x * (m[0] * x + mixed));
        row[i] += blob.share * t * t * t;
      }
    }
}

}  // namespace

LiquidField::LiquidField(const Model& model, const HostState& state, double step, int threads)
    : step_(step),
      threads_(threads),
      blobs_(kernels(model, state, step, threads)),
      widest_(widest(blobs_, step)),
      grid_(widest_) {
  for (const Blob& blob : blobs_) grid_.add(blob.x);
  for_ranges(blobs_.size(), threads, [this](std::size_t b) {
    double sum = 0;
    for_near(blobs_[b].x, [&](const Blob&, double weight) { sum += weight; });
    blobs_[b].density = sum;
  });
  for (Blob& blob : blobs_) blob.share /= std::min(1.0, blob.density / blob.enough);
}

void LiquidField::for_blocks(const std::function<void(const Block&)>& f) const {
  std::vector<Reach> reaches;
  for (std::size_t b = 0; b < blobs_.size(); ++b) {
    const Blob& blob = blobs_[b];
    std::array<std::int64_t, 3> first{}, last{};
    for (std::size_t a = 0; a < 3; ++a) {  // a block's last vertices are the next one's first
      first[a] = floor_index(((blob.x[a] - blob.reach[a]) / step_ - 0.5) / cells);
      last[a] = floor_index(((blob.x[a] + blob.reach[a]) / step_ - 0.5) / cells);
    }
    for (auto z = first[2]; z <= last[2]; ++z)
      for (auto y = first[1]; y <= last[1]; ++y)
        for (auto x = first[0]; x <= last[0]; ++x) reaches.push_back({{z, y, x}, static_cast<Index>(b)});
  }
  std::sort(reaches.begin(), reaches.end());

  std::vector<std::size_t> begins;  // of the blocks, and the end
  for (std::size_t k = 0; k < reaches.size(); ++k)
    if (k == 0 || reaches[k].block != reaches[k - 1].block) begins.push_back(k);
  const std::size_t blocks = begins.size(), at_once = threads_ > 1 ? 8 * static_cast<std::size_t>(threads_) : 1;
  begins.push_back(reaches.size());

  std::vector<std::vector<double>> values(std::min(at_once, blocks));
  std::vector<Block> made;
  for (std::size_t first = 0; first < blocks; first += at_once) {
    made.clear();
    for (std::size_t b = first; b < std::min(first + at_once, blocks); ++b) {
      const auto& [z, y, x] = reaches[begins[b]].block;
      made.push_back(
          {{x * cells, y * cells, z * cells}, {vertices, vertices, vertices}, {-1, -1, -1}, values[b - first]});
    }
    for_ranges(made.size(), threads_, [&](std::size_t k) {
      values[k].assign(std::size_t{vertices} * vertices * vertices, 0.0);
      for (std::size_t r = begins[first + k]; r < begins[first + k + 1]; ++r)
        add(blobs_[static_cast<std::size_t>(reaches[r].blob)], step_, made[k], values[k]);
    });
    for (const Block& block : made) f(block);
  }
}

}  // namespace drench
