// Prefix sums on CUDA by CUB: one kernel that reads and writes every number once, where Kokkos' scan reads them twice.

#include <cub/device/device_scan.cuh>

#include "core/bucket_sort.hpp"
#include "core/cuda/check.hpp"

namespace drench::kokkos_backend {

void PrefixSums::sum(const Array<Index>& a, Index n) {
  const cudaStream_t stream = exec().cuda_stream();
  std::size_t wanted = 0;  // asked every time, on the host alone
  check(cub::DeviceScan::ExclusiveSum(nullptr, wanted, a.data(), a.data(), n, stream), "prefix sums");
  make_ample_room(scratch_, "drench::cell_scan_scratch", wanted);
  check(cub::DeviceScan::ExclusiveSum(scratch_.data(), wanted, a.data(), a.data(), n, stream), "prefix sums");
}

}  // namespace drench::kokkos_backend
