#pragma once
// What CUDA's own functions return.

#include <cuda_runtime.h>

#include <stdexcept>
#include <string>

namespace drench::kokkos_backend {

/// Throws if a call failed. `what`: what the call was for, e.g. "cloth".
inline void check(cudaError_t status, const char* what) {
  if (status != cudaSuccess) throw std::runtime_error(std::string(what) + ": " + cudaGetErrorString(status));
}

}  // namespace drench::kokkos_backend
