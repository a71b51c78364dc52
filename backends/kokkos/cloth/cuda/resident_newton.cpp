// Launches Newton's method on the device (newton_kernel.hpp; cloth/solver.hpp).

#include <algorithm>
#include <memory>
#include <vector>

#include "cloth/cuda/newton_kernel.hpp"
#include "cloth/newton_patches.hpp"
#include "core/cuda/check.hpp"
#include "core/host_copy.hpp"

namespace drench::kokkos_backend {

using namespace resident;

namespace {

constexpr std::size_t most_colours = 24;

template <class T>
Array<T> array(const char* label, std::size_t count) {
  return Array<T>(Kokkos::ViewAllocateWithoutInitializing(label), count);
}
struct IterateArrays {
  Array<Double3> shift, residual;
  Array<NodeNearby> near;

  IterateArrays() = default;
  IterateArrays(std::size_t nodes, bool solids)
      : shift("drench::cloth::newton_shift", nodes), residual(array<Double3>("drench::cloth::newton_residual", nodes)) {
    if (solids) near = array<NodeNearby>("drench::cloth::newton_near", nodes);
  }
  NewtonIterate view() const { return {shift.data(), residual.data(), near.data()}; }
};

}  // namespace

struct ResidentNewton {
  int blocks = 0;                    // 0: the cloth is not for it
  Version placed = Version::none();  // of the nodes that tangent, inverses and states are of
  Real dt = 0;
  bool warm = false, fresh = true;
  double margin = 0, mean_edge = 0;
  NewtonMesh mesh;
  // of the mesh
  Array<Index> order, patch_start, pair_start, bending_start, part_start, pair_link, pair_at, bending_at;
  Array<std::uint16_t> colour;
  Array<TangentPair> pair;
  Array<BendingPair> bending_pair;
  Array<EdgePart> part;
  Array<Real> bending;
  // of a solve
  IterateArrays now, next;
  Array<Double3> best, corner_force, bending_at_x0, slip_direction;
  Array<Matrix3> of_triangle, own, between, factor_free;
  Array<ContactState> state;
  Array<std::uint8_t> touching;
  Array<ZoneNode> zone;
  Array<NodeFreedom> freedom;
  Array<Column3> zone_change, right, change, plain, correction, directions, images;
  Array<Real> inverse;
  Array<double> sums;
  Array<bool> is_warm;

  NewtonArrays arrays(ClothSolverWork& solver) const {
    const ResidentProgress shared = resident_progress_of(solver);
    return {.now = now.view(),
            .next = next.view(),
            .best = best.data(),
            .corner_force = corner_force.data(),
            .bending_at_x0 = bending_at_x0.data(),
            .of_triangle = of_triangle.data(),
            .own = own.data(),
            .between = between.data(),
            .state = state.data(),
            .slip_direction = slip_direction.data(),
            .touching = touching.data(),
            .zone = zone.data(),
            .zone_change = zone_change.data(),
            .freedom = freedom.data(),
            .factor_free = factor_free.data(),
            .right = right.data(),
            .change = change.data(),
            .plain = plain.data(),
            .correction = correction.data(),
            .directions = directions.data(),
            .images = images.data(),
            .inverse = inverse.data(),
            .part = sums.data(),
            .shift = solver.displacement.data(),
            .last_shift = solver.last_displacement.data(),
            .is_warm = is_warm.data(),
            .spectral_bound = shared.spectral_bound,
            .progress = shared.progress,
            .seen = shared.seen};
  }
};

namespace {

template <class View>
auto entries(const View& view) {
  return Entries<const typename View::non_const_value_type>(view.data(), view.extent(0));
}

/// Which nodes share blocks, from the device's arrays.
struct Links {
  std::unique_ptr<TangentPattern> pattern;
  NodeGraph near;  // by edges
  std::vector<Index> pair_link;

  Links(const Cloth& cloth, const ClothSystem& s) : near(static_cast<std::size_t>(cloth.nodes.count)) {
    const auto link_start = on_host_now(cloth.nodes.link_start);
    const auto link = on_host_now(cloth.nodes.link);
    const auto edge = on_host_now(cloth.mesh.edge), triangle = on_host_now(cloth.mesh.triangle);
    ClothSystem host = s;
    host.link_start = entries(link_start);
    host.link = entries(link);
    host.edge = entries(edge);
    host.triangle = entries(triangle);
    const Index nodes = cloth.nodes.count, triangles = s.triangle_start.exist() ? cloth.mesh.triangles : 0;
    pattern = std::make_unique<TangentPattern>(host, nodes, cloth.mesh.edges, triangles);
    for (Index n = 0; n < nodes; ++n)
      for (Index p = pattern->pair_start[at(n)]; p < pattern->pair_start[at(n + 1)]; ++p)
        near[at(n)].push_back(pattern->pairs[at(p)].other);
    pair_link.resize(pattern->pairs.size());
    for (std::size_t l = 0; l < pattern->pair_of.size(); ++l)
      if (pattern->pair_of[l] >= 0) pair_link[at(pattern->pair_of[l])] = static_cast<Index>(l);
  }
};

void list_mesh(const Cloth& cloth, const Links& links, const std::vector<std::uint16_t>& colour, int patches,
               ResidentNewton& r) {
  const TangentPattern& pattern = *links.pattern;
  const auto nodes = static_cast<std::size_t>(cloth.nodes.count);
  const NewtonPatches patch = make_newton_patches(links.near, patches, most_patch);
  r.order = to_device<Index>("drench::cloth::newton_order", patch.order);
  r.patch_start = to_device<Index>("drench::cloth::newton_patches", patch.start);
  r.colour = to_device<std::uint16_t>("drench::cloth::newton_colour", colour);
  r.pair_start = to_device<Index>("drench::cloth::newton_pair_start", pattern.pair_start);
  r.bending_start = to_device<Index>("drench::cloth::newton_bending_start", pattern.bending_start);
  r.part_start = to_device<Index>("drench::cloth::newton_part_start", pattern.part_start);
  std::vector<Index> rank(nodes), pair_at, bending_at;
  for (std::size_t k = 0; k < nodes; ++k) rank[at(patch.order[k])] = static_cast<Index>(k);
  for (const TangentPair& pair : pattern.pairs) pair_at.push_back(rank[at(pair.other)]);
  for (const BendingPair& pair : pattern.bending_pairs) bending_at.push_back(rank[at(pair.other)]);
  r.pair_at = to_device<Index>("drench::cloth::newton_pair_at", pair_at);
  r.bending_at = to_device<Index>("drench::cloth::newton_bending_at", bending_at);
  r.pair_link = to_device<Index>("drench::cloth::newton_pair_link", links.pair_link);
  r.pair = to_device<TangentPair>("drench::cloth::newton_pair", pattern.pairs);
  r.bending_pair = to_device<BendingPair>("drench::cloth::newton_bending_pair", pattern.bending_pairs);
  r.part = to_device<EdgePart>("drench::cloth::newton_part", pattern.parts);
  r.bending = to_device<Real>("drench::cloth::newton_bending", pattern.bending);
  r.mesh = {.nodes = cloth.nodes.count,
            .triangles = static_cast<Index>(r.of_triangle.extent(0) / 6),
            .patches = patches,
            .colours = *std::max_element(colour.begin(), colour.end()) + 1,
            .order = r.order.data(),
            .patch_start = r.patch_start.data(),
            .colour = r.colour.data(),
            .pair_start = r.pair_start.data(),
            .bending_start = r.bending_start.data(),
            .part_start = r.part_start.data(),
            .pair = r.pair.data(),
            .bending_pair = r.bending_pair.data(),
            .part = r.part.data(),
            .pair_at = r.pair_at.data(),
            .bending_at = r.bending_at.data(),
            .pair_link = r.pair_link.data(),
            .bending = r.bending.data()};
}

/// Blocks that fit on the device at once.
int most_blocks() {
  const cudaDeviceProp& device = exec().cuda_device_prop();
  if (!device.cooperativeLaunch) return 0;
  int at_once = 0;  // a processor
  check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&at_once, reinterpret_cast<const void*>(&newton), newton_threads,
                                                      0),
        "cloth");
  return at_once * device.multiProcessorCount;
}

std::shared_ptr<ResidentNewton> make_resident_newton(const Constants& constants, const Cloth& cloth,
                                                     const ClothSystem& s) {
  auto r = std::make_shared<ResidentNewton>();
  const Index count = cloth.nodes.count;
  const int most = most_blocks();
  if (!is_for_newton(constants.model.scene, s.triangle_start.exist(), count) || most == 0) return r;
  const Links links(cloth, s);
  const std::vector<std::uint16_t> colour = colours_of(links.near);
  if (*std::max_element(colour.begin(), colour.end()) >= most_colours) return r;
  // The same number of patches for each block.
  const int needed = (count + most_patch - 1) / most_patch, each = (needed + most - 1) / most;
  r->blocks = std::min(most, (needed + each - 1) / each);
  const int patches = r->blocks * each;
  const auto nodes = static_cast<std::size_t>(count);
  const auto triangles = static_cast<std::size_t>(s.triangle_start.exist() ? cloth.mesh.triangles : 0);
  const bool solids = s.solids.count > 0;
  r->mean_edge = double(cloth.mesh.mean_edge);
  r->of_triangle = array<Matrix3>("drench::cloth::newton_triangles", 6 * triangles);
  r->corner_force = array<Double3>("drench::cloth::newton_corners", 2 * triangles);
  list_mesh(cloth, links, colour, patches, *r);
  r->now = IterateArrays(nodes, solids);
  r->next = IterateArrays(nodes, solids);
  r->best = array<Double3>("drench::cloth::newton_best", nodes);
  r->bending_at_x0 = array<Double3>("drench::cloth::newton_bending_at_x0", nodes);
  r->slip_direction = Array<Double3>("drench::cloth::newton_slip_direction", nodes);
  r->own = array<Matrix3>("drench::cloth::newton_own", nodes);
  r->between = array<Matrix3>("drench::cloth::newton_between", links.pattern->pairs.size());
  r->factor_free = array<Matrix3>("drench::cloth::newton_factor_free", nodes);
  r->state = array<ContactState>("drench::cloth::newton_state", nodes);
  r->touching = array<std::uint8_t>("drench::cloth::newton_touching", nodes);
  if (solids) r->zone = array<ZoneNode>("drench::cloth::newton_zone", nodes);
  r->freedom = array<NodeFreedom>("drench::cloth::newton_freedom", nodes);
  for (Array<Column3>* a : {&r->zone_change, &r->right, &r->change, &r->plain, &r->correction})
    *a = array<Column3>("drench::cloth::newton_vector", nodes);
  r->directions = array<Column3>("drench::cloth::newton_directions", most_directions * nodes);
  r->images = array<Column3>("drench::cloth::newton_images", most_directions * nodes);
  r->inverse = array<Real>("drench::cloth::newton_inverse", static_cast<std::size_t>(patches) * most_rows * most_rows);
  r->sums =
      array<double>("drench::cloth::newton_sums", 2 * (most_directions + 2) * static_cast<std::size_t>(r->blocks));
  r->is_warm = Array<bool>("drench::cloth::newton_is_warm", 1);
  return r;
}

}  // namespace

bool prepare_resident_newton(const Constants& constants, const Cloth& cloth, ClothSolverWork& solver,
                             const ClothSystem& s, bool pushes_bodies) {
  if (solver.resident_newton == nullptr) solver.resident_newton = make_resident_newton(constants, cloth, s);
  ResidentNewton& r = *solver.resident_newton;
  if (r.blocks == 0) return false;
  r.margin = pushes_bodies ? margin_at_dynamic_bodies : 0;
  if (r.placed != cloth.moved || r.dt != s.dt) r.warm = false;
  r.placed = cloth.moved;
  r.dt = s.dt;
  r.fresh = true;
  return true;
}

void run_resident_newton(ClothSolverWork& solver, const ClothSystem& s, const ClothProgress& begin, int most,
                         double tolerance, double floor) {
  ResidentNewton& r = *solver.resident_newton;
  ClothSystem system = s;
  NewtonMesh mesh = r.mesh;
  NewtonArrays arrays = r.arrays(solver);
  NewtonRun run{.begin = begin,
                .first = r.fresh,
                .warm = r.warm,
                .most = most,
                .tolerance = tolerance,
                .floor = floor,
                .mean_edge = r.mean_edge,
                .margin = r.margin};
  void* arguments[] = {&system, &mesh, &arrays, &run};
  const ExecSpace space = exec();
  std::uint64_t id = 0;
  Kokkos::Tools::beginParallelFor("drench::cloth::resident_newton", Kokkos::Tools::Experimental::device_id(space), &id);
  check(cudaLaunchCooperativeKernel(reinterpret_cast<const void*>(&newton), dim3(static_cast<unsigned>(r.blocks)),
                                    dim3(newton_threads), arguments, 0, space.cuda_stream()),
        "cloth");
  Kokkos::Tools::endParallelFor(id);
  r.fresh = false;
  r.warm = true;
}

}  // namespace drench::kokkos_backend
