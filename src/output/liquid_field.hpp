#pragma once
// How much of the space is liquid: the field whose level ½ is the liquid's surface, block by block
// (docs/dev/liquid_surface.md).

#include <functional>
#include <vector>

#include "output/liquid_kernels.hpp"
#include "setup/point_grid.hpp"
#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

class LiquidField {
 public:
  /// Cells along a block's side, and vertices.
  static constexpr int cells = 16, vertices = cells + 1;
  /// Vertex (i, j, k) of the lattice lies at Δ (i + ½, …): bodies lie at whole spacings, where c is ½.
  struct Block {
    std::array<std::int64_t, 3> first;  // vertex with the lowest indices
    std::array<int, 3> low, high;       // vertices that a kernel reaches; c is 0 beyond
    const std::vector<double>& value;   // vertices³, x fastest
  };

  /// `step` is Δ, m. Particles that are not finite are left out. Kernels as `output.surface_kernel` says.
  LiquidField(const Model& model, const HostState& state, double step, int threads = 1);
  double step() const { return step_; }

  /// Calls f(block) for all blocks in which c is not 0, in a fixed order. Vertices that blocks share have the same bits
  /// in each. Only some blocks a thread are in memory at a time.
  void for_blocks(const std::function<void(const Block&)>& f) const;

  /// Calls f(blob, weight) for every blob with a part in c(x): V_j W_j(x − x_j).
  template <class F>
  void for_near(const Vec3& x, F&& f) const {
    const Vec3 low{x[0] - widest_, x[1] - widest_, x[2] - widest_},
        high{x[0] + widest_, x[1] + widest_, x[2] + widest_};
    grid_.for_box(low, high, [&](Index b) {
      const Blob& blob = blobs_[static_cast<std::size_t>(b)];
      const double t = 1 - blob.square({x[0] - blob.x[0], x[1] - blob.x[1], x[2] - blob.x[2]});
      if (t > 0) f(blob, blob.share * t * t * t);
    });
  }

 private:
  double step_;  // m
  int threads_;
  std::vector<Blob> blobs_;
  double widest_;   // m; the farthest that a kernel reaches
  PointGrid grid_;  // of the kernels' middles
};

}  // namespace drench
