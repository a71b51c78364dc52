// Start and end of Kokkos, what it runs on, and what it allocates.

#include "pipeline/runtime.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "base/free_cores.hpp"
#include "core/thread_mapping.hpp"
#include "core/types.hpp"
#include "parallel/communicator.hpp"
#include "setup/memory_estimate.hpp"

namespace drench {
namespace {

namespace Tools = Kokkos::Tools::Experimental;

std::atomic<std::int64_t> bytes_now{0}, bytes_peak{0};
std::mutex names_mutex;
std::map<std::string, std::int64_t> bytes_of_name;
// What a profiler had asked to be told; it is told still.
Kokkos_Profiling_allocateDataFunction next_allocate = nullptr;
Kokkos_Profiling_deallocateDataFunction next_deallocate = nullptr;

void count_name(const char* label, std::int64_t bytes) {
  const std::scoped_lock lock(names_mutex);
  const auto entry = bytes_of_name.try_emplace(label, 0).first;
  entry->second += bytes;
  if (entry->second == 0) bytes_of_name.erase(entry);
}

bool is_backends(const Kokkos_Profiling_SpaceHandle& space) {
  return std::strncmp(space.name, kokkos_backend::MemSpace::name(), sizeof(space.name)) == 0;
}

void on_allocate(Kokkos_Profiling_SpaceHandle space, const char* label, const void* data, std::uint64_t size) {
  if (is_backends(space)) {
    const std::int64_t now = bytes_now += static_cast<std::int64_t>(size);
    std::int64_t peak = bytes_peak;
    while (now > peak && !bytes_peak.compare_exchange_weak(peak, now)) {
    }
    count_name(label, static_cast<std::int64_t>(size));
  }
  if (next_allocate) next_allocate(space, label, data, size);
}

void on_deallocate(Kokkos_Profiling_SpaceHandle space, const char* label, const void* data, std::uint64_t size) {
  if (is_backends(space)) {
    bytes_now -= static_cast<std::int64_t>(size);
    count_name(label, -static_cast<std::int64_t>(size));
  }
  if (next_deallocate) next_deallocate(space, label, data, size);
}

void count_allocations() {
  const auto callbacks = Tools::get_callbacks();
  if (callbacks.allocate_data == on_allocate) return;
  next_allocate = callbacks.allocate_data;
  next_deallocate = callbacks.deallocate_data;
  Tools::set_allocate_data_callback(on_allocate);
  Tools::set_deallocate_data_callback(on_deallocate);
}

/// Threads of a host, and whether they sleep while they wait.
void settle_loops() {
  using kokkos_backend::HostLoops;
  if constexpr (kokkos_backend::on_host) {
    HostLoops::most = HostLoops::all = kokkos_backend::ExecSpace().concurrency();
  } else {
    constexpr int most = 8;  // more do not make Newton's method for cloth faster
    const int threads = Kokkos::DefaultHostExecutionSpace().concurrency();
    const bool shared = threads >= static_cast<int>(std::thread::hardware_concurrency());  // with other ranks
    HostLoops::most = std::clamp(shared ? threads / started_ranks() : threads, 1, most);
  }
  const char* const policy = std::getenv("OMP_WAIT_POLICY");
  if (policy != nullptr && (policy[0] == 'p' || policy[0] == 'P')) HostLoops::worth = 2e5F;
}

std::string gibibytes(double bytes) { return fmt::format("{:.1f} GiB", bytes / (1 << 30)); }

#ifdef KOKKOS_ENABLE_CUDA
/// The oldest compute capability that the kernels are compiled for, as 90 for 9.0.
constexpr int built_for = DRENCH_CUDA_OLDEST;

/// " to 9.0" where the kernels are compiled for several.
std::string newest_built_for() {
  constexpr int newest = DRENCH_CUDA_NEWEST;
  return newest > built_for ? fmt::format(" to {}.{}", newest / 10, newest % 10) : "";
}

/// Ranks of a host take its GPUs in turns.
int own_device(int count) { return started_ranks() > 1 ? local_rank() % count : 0; }

void check_device(cudaError_t error) {
  if (error != cudaSuccess) throw DeviceError(no_device_text(cudaGetErrorString(error), built_for));
}
#endif

}  // namespace

void require_device() {
#ifdef KOKKOS_ENABLE_CUDA
  int count = 0;
  if (const cudaError_t error = cudaGetDeviceCount(&count); error != cudaSuccess)
    throw DeviceError(no_device_text(cudaGetErrorString(error), built_for));
  if (count == 0) throw DeviceError(no_device_text("there is none", built_for));
  if (started_ranks() > 1)
    check_device(cudaSetDevice(own_device(count)));  // from here on, also for who asks for its memory
  cudaDeviceProp device;
  if (const cudaError_t error = cudaGetDeviceProperties(&device, own_device(count)); error != cudaSuccess)
    throw DeviceError(no_device_text(cudaGetErrorString(error), built_for));
  // The driver compiles for newer devices than the kernels were compiled for, never for older ones.
  if (const int has = 10 * device.major + device.minor; has < built_for)
    throw DeviceError(wrong_device_text(device.name, has, built_for));
#endif
}

bool computes_on_host() { return kokkos_backend::on_host; }

DeviceMemory device_memory() {
#ifdef KOKKOS_ENABLE_CUDA
  std::size_t free = 0, total = 0;
  cudaDeviceProp device;
  if (const cudaError_t error = cudaMemGetInfo(&free, &total); error != cudaSuccess)
    throw DeviceError(no_device_text(cudaGetErrorString(error), built_for));
  int own = 0;
  check_device(cudaGetDevice(&own));
  check_device(cudaGetDeviceProperties(&device, own));
  return {device.name, double(total), double(free)};
#else
  return {"", machine_memory(), machine_memory_free()};
#endif
}

ArrayMemory array_memory() { return {bytes_now, bytes_peak}; }

std::vector<NamedArray> named_arrays() {
  std::vector<NamedArray> arrays;
  {
    const std::scoped_lock lock(names_mutex);
    for (const auto& [name, bytes] : bytes_of_name) arrays.push_back({name, bytes});
  }
  std::ranges::stable_sort(arrays, [](const NamedArray& a, const NamedArray& b) { return a.bytes > b.bytes; });
  return arrays;
}

BackendRuntime::BackendRuntime(int threads, bool quiet) {
  [[maybe_unused]] const bool starts = !Kokkos::is_initialized();
  if (starts) {
    require_device();
    Kokkos::InitializationSettings settings;
    if (threads > 0)
      settings.set_num_threads(std::min(threads, most_threads));
    else if (host_threads() == most_threads)  // the machine or OMP_NUM_THREADS may have more
      settings.set_num_threads(most_threads);
#ifdef KOKKOS_ENABLE_CUDA
    int device = 0;
    if (started_ranks() > 1 && cudaGetDevice(&device) == cudaSuccess) settings.set_device_id(device);
#endif
    settings.set_disable_warnings(quiet || started_ranks() > 1);  // else each rank gives advice on binding
    // Otherwise Kokkos asks the user to bind threads to cores, which helps no run and harms where cores are shared.
    setenv("OMP_PROC_BIND", "false", 0);
    Kokkos::initialize(settings);
  }
  count_allocations();
  settle_loops();
#ifdef KOKKOS_ENABLE_CUDA
  if (const std::string fault = kokkos_backend::thread_mapping_fault(); !fault.empty()) {
    if (starts) Kokkos::finalize();  // a constructor that throws has no destructor
    throw DeviceError(fault);
  }
#endif
}

BackendRuntime::~BackendRuntime() {
  if (Kokkos::is_initialized() && !Kokkos::is_finalized()) Kokkos::finalize();
}

int loop_threads() { return kokkos_backend::on_host ? kokkos_backend::HostLoops::all : 1; }

int shared_loops() { return kokkos_backend::HostLoops::threads(); }

int runs_at_a_time() {
  constexpr int most = 16;  // threads that launch kernels wait for each other in CUDA
  return kokkos_backend::on_host ? shared_loops() : std::min(allowed_cores(), most);
}

OwnLoops::OwnLoops(int threads) : before_(kokkos_backend::HostLoops::own) {
  const int most = kokkos_backend::on_host ? loop_threads() : std::max(threads, 1);
  kokkos_backend::HostLoops::own = std::clamp(threads, 1, most);
}
OwnLoops::~OwnLoops() { kokkos_backend::HostLoops::own = before_; }

void share_loops(int threads) {
  if (kokkos_backend::on_host) kokkos_backend::HostLoops::most = std::clamp(threads, 1, loop_threads());
}

double loop_cores() {
  double cores = 1;
#ifndef KOKKOS_ENABLE_CUDA
  using kokkos_backend::Range;
  Kokkos::parallel_reduce(
      "drench::threads::cores",
      Range(kokkos_backend::space_of(loop_threads()), 0, loop_threads(), Kokkos::ChunkSize(1)),
      [](const Index, double& sum) { sum += share_of_core(); }, cores);
#endif
  return cores;
}

std::string runtime_description() {
  std::string text = fmt::format("backend: {}\n", kokkos_backend::ExecSpace::name());
  const DeviceMemory memory = device_memory();
#ifdef KOKKOS_ENABLE_CUDA
  const auto& device = kokkos_backend::ExecSpace().cuda_device_prop();
  int driver = 0, runtime = 0;
  cudaDriverGetVersion(&driver);
  cudaRuntimeGetVersion(&runtime);
  text += fmt::format("device: {}\ncompute capability: {}.{}, built for {}.{}{}\n", device.name, device.major,
                      device.minor, built_for / 10, built_for % 10, newest_built_for());
  text += fmt::format("CUDA: runtime {}.{}, driver {}.{}\n", runtime / 1000, runtime % 1000 / 10, driver / 1000,
                      driver % 1000 / 10);
#else
  text += "device: host processor\n";
#endif
  text += fmt::format("memory: {}, {} free\n", gibibytes(memory.total), gibibytes(memory.free));
  text += fmt::format("threads: {}\n", Kokkos::DefaultHostExecutionSpace().concurrency());
  text += fmt::format("Kokkos: {}.{}.{}\n", KOKKOS_VERSION / 10000, KOKKOS_VERSION / 100 % 100, KOKKOS_VERSION % 100);
  return text;
}

}  // namespace drench
