// Prefix sums on CUDA by CUB: one kernel that reads and writes every number once, where Kokkos' scan reads them twice.

#include <cub/device/device_scan.cuh>
#include <stdexcept>
#include <string>

#include "core/bucket_sort.hpp"

namespace drench::kokkos_backend {
namespace {

void check(cudaError_t status) {
  if (status != cudaSuccess) throw std::runtime_error(std::string("prefix sums: ") + cudaGetErrorString(status));
}

}  // namespace

void PrefixSums::sum(const Array<Index>& a, Index n) {
  const cudaStream_t stream = exec().cuda_stream();
  std::size_t wanted = 0;  // asked every time, on the host alone
  check(cub::DeviceScan::ExclusiveSum(nullptr, wanted, a.data(), a.data(), n, stream));
  make_ample_room(scratch_, "drench::cell_scan_scratch", wanted);
  check(cub::DeviceScan::ExclusiveSum(scratch_.data(), wanted, a.data(), a.data(), n, stream));
}

}  // namespace drench::kokkos_backend
