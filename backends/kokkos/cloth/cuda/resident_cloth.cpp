// Launches the cloth's resident iterations (resident_kernel.hpp; cloth/solver.hpp).

#include <algorithm>
#include <memory>
#include <utility>

#include "cloth/cuda/resident_kernel.hpp"
#include "core/cuda/check.hpp"

namespace drench::kokkos_backend {

using namespace resident;

namespace {

/// Was the kernel compiled for this capability at least? The driver may have translated it from an older one's PTX.
bool compiled_for(int capability, const void* kernel) {
  cudaFuncAttributes attributes;
  check(cudaFuncGetAttributes(&attributes, kernel), "cloth");
  return attributes.ptxVersion >= capability;
}

/// How the kernel is launched for a cloth, kept from solve to solve.
struct Plan {
  const void* kernel = nullptr;  // null: the cloth does not fit
  int threads = 0, blocks = 0, shared_bytes = 0, lanes = lanes_of_links;
  bool cluster = false;
};

/// The kernel for nodes with `links` a lane at most in blocks of `block` threads, or null.
template <bool plain, int threads, Exchange exchange, int lanes, int triangles>
const void* kernel_with(int links) {
  if (links <= 6) return reinterpret_cast<const void*>(&iterate<6, plain, threads, exchange, lanes, triangles>);
  if constexpr (lanes < 8) {  // a node with more than 48 links takes fewer lanes
    if (links <= 9) return reinterpret_cast<const void*>(&iterate<9, plain, threads, exchange, lanes, triangles>);
    if (links <= 14) return reinterpret_cast<const void*>(&iterate<14, plain, threads, exchange, lanes, triangles>);
  }
  return nullptr;
}
template <bool plain, Exchange exchange, int lanes, int triangles = 0>
const void* kernel_in_blocks(int links, int block) {
  return block <= fewer_threads ? kernel_with<plain, fewer_threads, exchange, lanes, triangles>(links)
                                : kernel_with<plain, most_threads, exchange, lanes, triangles>(links);
}
/// `triangles`: of a lane at most.
template <Exchange exchange, int lanes>
const void* kernel_for(int links, int triangles, bool plain, int block) {
  // Nodes with triangles are never plain, and only they have more lanes.
  if constexpr (lanes != lanes_of_links) {
    if constexpr (lanes == 8)  // a node has more than four triangles
      if (triangles == 1) return kernel_in_blocks<false, exchange, lanes, 1>(links, block);
    if (triangles == 2) return kernel_in_blocks<false, exchange, lanes, 2>(links, block);
    return kernel_in_blocks<false, exchange, lanes>(links, block);
  }
  return plain ? kernel_in_blocks<true, exchange, lanes_of_links>(links, block)
               : kernel_in_blocks<false, exchange, lanes_of_links>(links, block);
}
int of_lane(int rows, int lanes) { return (rows + lanes - 1) / lanes; }

/// What a node has at most.
struct Rows {
  int links, triangles;
};

/// Blocks of as few threads as spread the nodes over all processors.
template <Exchange exchange, int lanes = lanes_of_links>
Plan make_plan(Index nodes, const Rows& rows, bool plain, int room) {
  constexpr bool dated = exchange == Exchange::dated;
  const cudaDeviceProp& device = exec().cuda_device_prop();
  const int processors = device.multiProcessorCount;
  if (!device.cooperativeLaunch) return {};
  for (int blocks_each = 1; blocks_each <= 8; ++blocks_each) {
    const int share = (lanes * nodes + processors * blocks_each - 1) / (processors * blocks_each);
    const int threads = std::clamp((share + warp - 1) / warp * warp, 2 * warp, most_threads);
    const int blocks = (lanes * nodes + threads - 1) / threads;
    const void* const kernel =
        kernel_for<exchange, lanes>(of_lane(rows.links, lanes), of_lane(rows.triangles, lanes), plain, threads);
    if (kernel == nullptr) return {};
    const int shared_bytes = dated ? 2 * (threads / lanes + room) * static_cast<int>(sizeof(Real4)) : 0;
    int at_once = 0;  // a processor
    check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&at_once, kernel, threads, shared_bytes), "cloth");
    if (at_once * processors >= blocks) return {kernel, threads, blocks, shared_bytes, lanes};
  }
  return {};
}

/// The same with the most lanes of which all nodes fit on the device at once.
Plan make_plan_by_triangle(Index nodes, const Rows& rows) {
  Plan plan = make_plan<Exchange::barrier, lanes_of_triangles[0]>(nodes, rows, false, 0);
  if (plan.kernel == nullptr) plan = make_plan<Exchange::barrier, lanes_of_triangles[1]>(nodes, rows, false, 0);
  if (plan.kernel == nullptr) plan = make_plan<Exchange::barrier, lanes_of_triangles[2]>(nodes, rows, false, 0);
  return plan;
}

#ifdef DRENCH_CLUSTERS
cudaLaunchConfig_t launch_of(const Plan& plan, cudaLaunchAttribute& room) {
  room.id = cudaLaunchAttributeClusterDimension;
  room.val.clusterDim.x = static_cast<unsigned>(plan.blocks);
  room.val.clusterDim.y = room.val.clusterDim.z = 1;
  cudaLaunchConfig_t launch{};
  launch.gridDim = static_cast<unsigned>(plan.blocks);
  launch.blockDim = static_cast<unsigned>(plan.threads);
  launch.dynamicSmemBytes = static_cast<std::size_t>(plan.shared_bytes);
  launch.stream = exec().cuda_stream();
  launch.attrs = &room;
  launch.numAttrs = 1;
  return launch;
}

/// All nodes in one cluster, or no kernel.
Plan make_cluster_plan(Index nodes, const Rows& rows, bool plain) {
  for (const int blocks : {most_in_cluster, 8}) {
    constexpr int lanes = lanes_of_links;
    const int share = (lanes * nodes + blocks - 1) / blocks, threads = (share + warp - 1) / warp * warp;
    if (threads > most_threads) continue;
    Plan plan{kernel_for<Exchange::cluster, lanes>(of_lane(rows.links, lanes), 0, plain, threads),
              threads,
              blocks,
              2 * threads / lanes * static_cast<int>(sizeof(Real4)),
              lanes,
              true};
    if (plan.kernel == nullptr || !compiled_for(needed_for_clusters, plan.kernel)) return {};
    if (blocks > 8 &&
        cudaFuncSetAttribute(plan.kernel, cudaFuncAttributeNonPortableClusterSizeAllowed, 1) != cudaSuccess) {
      cudaGetLastError();  // a device with smaller clusters
      continue;
    }
    cudaLaunchAttribute room;
    const cudaLaunchConfig_t launch = launch_of(plan, room);
    int at_once = 0;
    if (cudaOccupancyMaxActiveClusters(&at_once, plan.kernel, &launch) == cudaSuccess && at_once > 0) return plan;
    cudaGetLastError();  // a device that cannot
  }
  return {};
}

void launch_cluster(const Plan& plan, void** arguments) {
  cudaLaunchAttribute room;
  const cudaLaunchConfig_t launch = launch_of(plan, room);
  check(cudaLaunchKernelExC(&launch, plan.kernel, arguments), "cloth");
}
#else
Plan make_cluster_plan(Index, const Rows&, bool) { return {}; }
void launch_cluster(const Plan&, void**) {}
#endif

}  // namespace

struct ResidentCloth {
  Plan plan;
  Patches patches;
  Array<Real4> iterate[2];
  Array<TwoSums> part;
  Kokkos::View<double, MemSpace> spectral_bound;
  Kokkos::View<ClothProgress, MemSpace> progress;
  Kokkos::View<ClothProgress, Kokkos::SharedHostPinnedSpace> seen;
};

namespace {

/// Goes in one cluster, if the cloth is small enough: of a link's other node the kernel wants its place in the order of
/// all.
bool use_cluster(const Constants& constants, const Cloth& cloth, const Rows& rows, bool plain, ResidentCloth& r) {
  const Plan plan = make_cluster_plan(cloth.nodes.count, rows, plain);
  if (plan.kernel == nullptr) return false;
  r.plan = plan;
  r.patches = make_patches(constants, cloth, cloth.nodes.count);
  return true;
}

/// Goes without barriers, if the patches have few enough nodes around them.
void use_patches(const Constants& constants, const Cloth& cloth, const Rows& rows, bool plain, ResidentCloth& r) {
  // With room for the most that may lie around a patch, for that is known only once the patches are.
  const Plan dated = make_plan<Exchange::dated>(cloth.nodes.count, rows, plain, most_around);
  if (dated.kernel == nullptr || !compiled_for(needed_for_dates, dated.kernel)) return;
  Patches patches = make_patches(constants, cloth, dated.threads / dated.lanes);
  if (patches.most > most_around) return;
  r.plan = dated;
  r.plan.shared_bytes = 2 * (dated.threads / dated.lanes + patches.most) * static_cast<int>(sizeof(Real4));
  r.patches = std::move(patches);
}

int most_of_a_node(const char* label, Index nodes, const Entries<const Index>& start) {
  return static_cast<int>(maximum(
      label, nodes, KOKKOS_LAMBDA(const Index n) { return static_cast<double>(start(n + 1) - start(n)); }));
}

/// A cloth's plan and the arrays that it takes; no arrays if it does not fit.
std::shared_ptr<ResidentCloth> make_resident_cloth(const Constants& constants, const Cloth& cloth,
                                                   const ClothSystem& s) {
  auto r = std::make_shared<ResidentCloth>();
  const Index nodes = cloth.nodes.count;
  const bool by_triangle = s.triangle_start.exist();
  const Rows rows{most_of_a_node("drench::cloth::most_links", nodes, s.link_start),
                  by_triangle ? most_of_a_node("drench::cloth::most_triangles", nodes, s.triangle_start) : 0};
  const bool plain = s.solids.count == 0 && !by_triangle;
  r->plan = by_triangle ? make_plan_by_triangle(nodes, rows) : make_plan<Exchange::barrier>(nodes, rows, plain, 0);
  if (r->plan.kernel == nullptr) return r;
  const bool clustered = !by_triangle && use_cluster(constants, cloth, rows, plain, *r);
  if (dated_shifts && !by_triangle && !clustered) use_patches(constants, cloth, rows, plain, *r);
  for (Array<Real4>& i : r->iterate) i = Array<Real4>("drench::cloth::iterate", static_cast<std::size_t>(nodes));
  r->part = Array<TwoSums>("drench::cloth::part", static_cast<std::size_t>(r->plan.blocks));
  r->spectral_bound = Kokkos::View<double, MemSpace>("drench::cloth::spectral_bound");
  r->progress = Kokkos::View<ClothProgress, MemSpace>("drench::cloth::progress");
  r->seen = Kokkos::View<ClothProgress, Kokkos::SharedHostPinnedSpace>("drench::cloth::progress_seen");
  return r;
}

}  // namespace

bool prepare_resident_cloth(const Constants& constants, const Cloth& cloth, ClothSolverWork& solver,
                            const ClothSystem& s) {
  if (solver.resident == nullptr) solver.resident = make_resident_cloth(constants, cloth, s);
  return solver.resident->plan.kernel != nullptr;
}

Kokkos::View<double, MemSpace> resident_spectral_bound(const ClothSolverWork& solver) {
  return solver.resident->spectral_bound;
}

ResidentProgress resident_progress_of(const ClothSolverWork& solver) {
  const ResidentCloth& r = *solver.resident;
  return {r.spectral_bound.data(), r.progress.data(), r.seen.data()};
}

void run_resident_cloth(ClothSolverWork& solver, const ClothSystem& s, Index nodes, const ClothProgress* begin,
                        int most, double tolerance, double floor, bool after_newton) {
  ResidentCloth& r = *solver.resident;
  ClothSystem system = s;
  ResidentArrays arrays{.shift = solver.displacement.data(),
                        .last_shift = solver.last_displacement.data(),
                        .iterate = {r.iterate[0].data(), r.iterate[1].data()},
                        .part = r.part.data(),
                        .spectral_bound = r.spectral_bound.data(),
                        .progress = r.progress.data(),
                        .seen = r.seen.data()};
  ResidentRun run{.begin = begin != nullptr ? *begin : ClothProgress{},
                  .first = begin != nullptr,
                  .after_newton = after_newton,
                  .most = most,
                  .tolerance = tolerance,
                  .floor = floor};
  PatchView patch = r.patches.view(r.plan.threads / r.plan.lanes);
  void* arguments[] = {&system, &arrays, &patch, &run, &nodes};
  const ExecSpace space = exec();
  std::uint64_t id = 0;
  Kokkos::Tools::beginParallelFor("drench::cloth::resident", Kokkos::Tools::Experimental::device_id(space), &id);
  if (r.plan.cluster)
    launch_cluster(r.plan, arguments);
  else
    check(cudaLaunchCooperativeKernel(r.plan.kernel, dim3(static_cast<unsigned>(r.plan.blocks)),
                                      dim3(static_cast<unsigned>(r.plan.threads)), arguments,
                                      static_cast<std::size_t>(r.plan.shared_bytes), space.cuda_stream()),
          "cloth");
  Kokkos::Tools::endParallelFor(id);
}

ClothProgress resident_progress(const ClothSolverWork& solver) {
  exec().fence("drench::cloth::resident");
  return solver.resident->seen();
}

}  // namespace drench::kokkos_backend
