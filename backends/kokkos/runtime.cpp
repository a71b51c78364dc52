// Start and end of Kokkos, and what it runs on.

#include "pipeline/runtime.hpp"

#include <fmt/format.h>

#include "types.hpp"

namespace drench {

BackendRuntime::BackendRuntime(int threads, bool quiet) {
  if (Kokkos::is_initialized()) return;
  Kokkos::InitializationSettings settings;
  if (threads > 0) settings.set_num_threads(threads);
  settings.set_disable_warnings(quiet);
  Kokkos::initialize(settings);
}

BackendRuntime::~BackendRuntime() {
  if (Kokkos::is_initialized() && !Kokkos::is_finalized()) Kokkos::finalize();
}

std::string runtime_description() {
  std::string text = fmt::format("backend: {}\n", kokkos_backend::ExecSpace::name());
#ifdef KOKKOS_ENABLE_CUDA
  const auto& device = kokkos_backend::ExecSpace().cuda_device_prop();
  int driver = 0, runtime = 0;
  cudaDriverGetVersion(&driver);
  cudaRuntimeGetVersion(&runtime);
  text += fmt::format("device: {} (sm_{}{}, {:.1f} GiB)\nCUDA: {}.{} (driver {}.{})\n", device.name, device.major,
                      device.minor, double(device.totalGlobalMem) / double(1 << 30), runtime / 1000,
                      runtime % 1000 / 10, driver / 1000, driver % 1000 / 10);
#else
  text += "device: host processor\n";
#endif
  text += fmt::format("threads: {}\n", Kokkos::DefaultHostExecutionSpace().concurrency());
  text += fmt::format("Kokkos: {}.{}.{}\n", KOKKOS_VERSION / 10000, KOKKOS_VERSION / 100 % 100, KOKKOS_VERSION % 100);
  return text;
}

}  // namespace drench
