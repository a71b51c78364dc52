// Launches the cloth's resident iterations (resident_kernel.hpp; cloth/solver.hpp).

#include "cloth/cuda/resident_kernel.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

namespace drench::kokkos_backend {

using namespace resident;

namespace {

void check(cudaError_t status) {
  if (status != cudaSuccess) throw std::runtime_error(std::string("cloth: ") + cudaGetErrorString(status));
}

/// How the kernel is launched for a cloth, kept from solve to solve.
struct Plan {
  const void* kernel = nullptr;  // null: the cloth does not fit
  int threads = 0, blocks = 0, shared_bytes = 0;
};

/// The kernel for nodes with `links` a lane at most in blocks of `block` threads, or null.
template <bool plain, int threads, bool dated>
const void* kernel_with(int links) {
  return links <= 6    ? reinterpret_cast<const void*>(&iterate<6, plain, threads, dated>)
         : links <= 9  ? reinterpret_cast<const void*>(&iterate<9, plain, threads, dated>)
         : links <= 14 ? reinterpret_cast<const void*>(&iterate<14, plain, threads, dated>)
                       : nullptr;
}
template <bool dated>
const void* kernel_for(int links, bool plain, int block) {
  if (block <= fewer_threads)
    return plain ? kernel_with<true, fewer_threads, dated>(links) : kernel_with<false, fewer_threads, dated>(links);
  return plain ? kernel_with<true, most_threads, dated>(links) : kernel_with<false, most_threads, dated>(links);
}

/// Blocks of as few threads as spread the nodes over all processors; a node with `rows` links at most.
template <bool dated>
Plan make_plan(Index nodes, int rows, bool plain, int room) {
  const cudaDeviceProp& device = ExecSpace().cuda_device_prop();
  const int processors = device.multiProcessorCount, each = (rows + lanes - 1) / lanes;
  if (!device.cooperativeLaunch) return {};
  for (int blocks_each = 1; blocks_each <= 8; ++blocks_each) {
    const int share = (lanes * nodes + processors * blocks_each - 1) / (processors * blocks_each);
    const int threads = std::clamp((share + warp - 1) / warp * warp, 2 * warp, most_threads);
    const int blocks = (lanes * nodes + threads - 1) / threads;
    const void* const kernel = kernel_for<dated>(each, plain, threads);
    if (kernel == nullptr) return {};
    const int shared_bytes = dated ? 2 * (threads / lanes + room) * static_cast<int>(sizeof(Real4)) : 0;
    int at_once = 0;  // a processor
    check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&at_once, kernel, threads, shared_bytes));
    if (at_once * processors >= blocks) return {kernel, threads, blocks, shared_bytes};
  }
  return {};
}

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

/// Goes without barriers, if the patches have few enough nodes around them.
void use_patches(const Constants& constants, const Cloth& cloth, int rows, bool plain, ResidentCloth& r) {
  // With room for the most that may lie around a patch, for that is known only once the patches are.
  const Plan dated = make_plan<true>(cloth.nodes.count, rows, plain, most_around);
  if (dated.kernel == nullptr) return;
  Patches patches = make_patches(constants, cloth, dated.threads / lanes);
  if (patches.most > most_around) return;
  r.plan = dated;
  r.plan.shared_bytes = 2 * (dated.threads / lanes + patches.most) * static_cast<int>(sizeof(Real4));
  r.patches = std::move(patches);
}

/// A cloth's plan and the arrays that it takes; no arrays if it does not fit.
std::shared_ptr<ResidentCloth> make_resident_cloth(const Constants& constants, const Cloth& cloth,
                                                   const ClothSystem& s) {
  auto r = std::make_shared<ResidentCloth>();
  const Index nodes = cloth.nodes.count;
  const int rows = static_cast<int>(maximum(
      "drench::cloth::most_links", nodes,
      KOKKOS_LAMBDA(const Index n) { return static_cast<double>(s.link_start(n + 1) - s.link_start(n)); }));
  const bool limits = s.limit_start.exist(), plain = s.solids.count == 0 && !limits;
  r->plan = make_plan<false>(nodes, rows, plain, 0);
  if (r->plan.kernel == nullptr) return r;
  if (dated_shifts && !limits) use_patches(constants, cloth, rows, plain, *r);
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

void run_resident_cloth(ClothSolverWork& solver, const ClothSystem& s, Index nodes, const ClothProgress* begin, int most,
                        double tolerance, double floor) {
  ResidentCloth& r = *solver.resident;
  ClothSystem system = s;
  ResidentArrays arrays{solver.displacement.data(),
                        solver.last_displacement.data(),
                        {r.iterate[0].data(), r.iterate[1].data()},
                        r.part.data(),
                        r.spectral_bound.data(),
                        r.progress.data(),
                        r.seen.data()};
  ResidentRun run{begin != nullptr ? *begin : ClothProgress{}, begin != nullptr, most, tolerance, floor};
  PatchView patch = r.patches.view(r.plan.threads / lanes);
  void* arguments[] = {&system, &arrays, &patch, &run, &nodes};
  const ExecSpace space;
  std::uint64_t id = 0;
  Kokkos::Tools::beginParallelFor("drench::cloth::resident", Kokkos::Tools::Experimental::device_id(space), &id);
  check(cudaLaunchCooperativeKernel(r.plan.kernel, dim3(static_cast<unsigned>(r.plan.blocks)),
                                    dim3(static_cast<unsigned>(r.plan.threads)), arguments,
                                    static_cast<std::size_t>(r.plan.shared_bytes), space.cuda_stream()));
  Kokkos::Tools::endParallelFor(id);
}

ClothProgress resident_progress(const ClothSolverWork& solver) {
  ExecSpace().fence("drench::cloth::resident");
  return solver.resident->seen();
}

}  // namespace drench::kokkos_backend
