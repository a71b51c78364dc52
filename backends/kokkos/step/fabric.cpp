// Stage fabric (src/stages/fabric.hpp).

#include "step/fabric.hpp"

#include "cloth/wet_cloth.hpp"
#include "core/host_copy.hpp"
#include "core/reduce.hpp"
#include "setup/rest_plane.hpp"
#include "setup/surface_mesh.hpp"
#include "step/fabric_law.hpp"

namespace drench::kokkos_backend {
namespace {

void lay_out(const Constants& constants, FabricWork& work) {
  const ClothMesh& mesh = constants.model.mesh;
  std::vector<double> rest_area;
  for (const auto& t : mesh.triangle) {
    const auto at = [&](std::size_t c) { return mesh.rest_position[static_cast<std::size_t>(t[c])]; };
    rest_area.push_back(triangle_area(at(0), at(1), at(2)));
  }
  work.rest_uv = to_device<double>("drench::fabric::rest_uv", places_in_rest_planes(constants.model));
  work.rest_area = to_device<double>("drench::fabric::rest_area", rest_area);
}

/// The wet part of a cloth: its area, m², and how far it reaches along warp and weft, m.
struct Patch {
  static constexpr double far = 1e300;
  double area = 0, low_u = far, high_u = -far, low_v = far, high_v = -far;
  KOKKOS_INLINE_FUNCTION void reach(double u, double v) {
    low_u = smaller(low_u, u);
    high_u = larger(high_u, u);
    low_v = smaller(low_v, v);
    high_v = larger(high_v, v);
  }
  KOKKOS_INLINE_FUNCTION Patch& operator+=(const Patch& o) {
    area += o.area;
    low_u = smaller(low_u, o.low_u);
    high_u = larger(high_u, o.high_u);
    low_v = smaller(low_v, o.low_v);
    high_v = larger(high_v, o.high_v);
    return *this;
  }
};

/// Of one triangle.
struct WetTriangle {
  NodeLiquid wet;
  Entries<const Index> node;
  Entries<const double> uv, area;
  double least;

  WetTriangle(const Constants& constants, const Cloth& cloth, const FabricWork& work)
      : wet(constants, cloth),
        node(cloth.mesh.triangle),
        uv(work.rest_uv),
        area(work.rest_area),
        least(constants.model.scene.output.wet_above) {}

  KOKKOS_INLINE_FUNCTION double excess(Index n) const {
    return (wet.capacity(n) > 0 ? wet.filling_at_rest(n) : 0) - least;
  }
  KOKKOS_INLINE_FUNCTION Patch operator()(Index t) const {
    const Index n[3] = {node(3 * t), node(3 * t + 1), node(3 * t + 2)};
    const double s[3] = {excess(n[0]), excess(n[1]), excess(n[2])};
    Patch patch;
    patch.area = area(t) * laws::part_above(s[0], s[1], s[2]);
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      const Index a = n[k], b = n[next];
      if (s[k] >= 0) patch.reach(uv(2 * a), uv(2 * a + 1));
      if ((s[k] >= 0) == (s[next] >= 0)) continue;
      const double part = s[k] / (s[k] - s[next]);  // of the way from a to b
      patch.reach(uv(2 * a) + part * (uv(2 * b) - uv(2 * a)), uv(2 * a + 1) + part * (uv(2 * b + 1) - uv(2 * a + 1)));
    }
    return patch;
  }
};

/// Quanta on the two faces of samples.
struct FaceSums {
  Quanta taken_front = 0, taken_back = 0, given_front = 0, given_back = 0;
  KOKKOS_INLINE_FUNCTION FaceSums& operator+=(const FaceSums& o) {
    taken_front += o.taken_front;
    taken_back += o.taken_back;
    given_front += o.given_front;
    given_back += o.given_back;
    return *this;
  }
};

void add_faces(const Cloth& cloth, const ClothMaterial& material, FabricNumbers& numbers) {
  const Samples& s = cloth.samples;
  if (!s.taken_front.exists()) return;
  const Entries<const Quanta> taken_front = s.taken_front, taken_back = s.taken_back, given_front = s.given_front,
                              given_back = s.given_back;
  const Index first = material.first_sample;
  const FaceSums sums = ordered<FaceSums>(
      "drench::fabric::faces", material.sample_count, KOKKOS_LAMBDA(const Index k) {
        const Index p = first + k;
        return FaceSums{taken_front(p), taken_back(p), given_front(p), given_back(p)};
      });
  numbers.taken_front = sums.taken_front;
  numbers.taken_back = sums.taken_back;
  numbers.given_front = sums.given_front;
  numbers.given_back = sums.given_back;
}

FabricNumbers numbers_of(const Constants& constants, const Cloth& cloth, const FabricWork& work,
                         const ClothMaterial& material) {
  FabricNumbers numbers;
  const Entries<const Quanta> liquid = cloth.nodes.liquid;
  const Index first_node = material.first_node, first = material.first_triangle;
  numbers.liquid = ordered<Quanta>(
      "drench::fabric::liquid", material.node_count, KOKKOS_LAMBDA(const Index k) { return liquid(first_node + k); });
  const WetTriangle wet(constants, cloth, work);
  const Patch patch = ordered<Patch>(
      "drench::fabric::patch", material.triangle_count, KOKKOS_LAMBDA(const Index k) { return wet(first + k); });
  numbers.wet_area = patch.area;
  if (patch.high_u >= patch.low_u) {
    numbers.wet_warp = patch.high_u - patch.low_u;
    numbers.wet_weft = patch.high_v - patch.low_v;
  }
  add_faces(cloth, material, numbers);
  return numbers;
}

}  // namespace

MemoryEstimate fabric_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (s.size.fabric) sum.cloth = (2 * s.size.nodes + s.size.triangles) * double_bytes;
  if (s.counts_faces()) sum.cloth += s.size.samples * quanta_bytes;  // transfers.front
  return sum;
}

void fabric(const Constants& constants, const Cloth& cloth, FabricWork& work, StepReport& report) {
  if (work.rest_uv.extent(0) == 0) lay_out(constants, work);
  report.fabrics.clear();
  for (std::size_t k = 0; k < constants.model.cloths.size(); ++k) {
    const ClothMaterial& material = constants.model.cloths[k];
    if (!material.porous) continue;
    report.fabrics.push_back(numbers_of(constants, cloth, work, material));
    report.fabrics.back().cloth = static_cast<Index>(k);
  }
}

}  // namespace drench::kokkos_backend
