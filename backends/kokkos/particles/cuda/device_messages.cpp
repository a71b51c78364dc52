#include "particles/device_messages.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/cuda/check.hpp"
#include "core/types.hpp"

namespace drench::kokkos_backend {
namespace {

// The part of NCCL's interface that is used; it has been the same since version 2.7.
struct UniqueId {
  char bytes[128];
};
using Comm = void*;
constexpr int uint8 = 1, uint32 = 3, int64 = 4, sum = 0;

/// The library's functions, looked up once it is loaded.
struct Library {
  void* handle = nullptr;
  int (*get_unique_id)(UniqueId*) = nullptr;
  int (*init_rank)(Comm*, int, UniqueId, int) = nullptr;
  int (*destroy)(Comm) = nullptr;
  int (*get_version)(int*) = nullptr;
  int (*group_start)() = nullptr;
  int (*group_end)() = nullptr;
  int (*send)(const void*, std::size_t, int, int, Comm, cudaStream_t) = nullptr;
  int (*receive)(void*, std::size_t, int, int, Comm, cudaStream_t) = nullptr;
  int (*all_reduce)(const void*, void*, std::size_t, int, int, Comm, cudaStream_t) = nullptr;
  const char* (*error_string)(int) = nullptr;

  bool load() {
    const char* const given = std::getenv("DRENCH_NCCL");
    if (given != nullptr && std::strcmp(given, "off") == 0) return false;
    handle = dlopen(given != nullptr ? given : "libnccl.so.2", RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) return false;
    bool all = true;
    const auto find = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::decay_t<decltype(function)>>(dlsym(handle, name));
      all = all && function != nullptr;
    };
    find(get_unique_id, "ncclGetUniqueId");
    find(init_rank, "ncclCommInitRank");
    find(destroy, "ncclCommDestroy");
    find(get_version, "ncclGetVersion");
    find(group_start, "ncclGroupStart");
    find(group_end, "ncclGroupEnd");
    find(send, "ncclSend");
    find(receive, "ncclRecv");
    find(all_reduce, "ncclAllReduce");
    find(error_string, "ncclGetErrorString");
    return all;
  }
};

class Nccl final : public DeviceMessages {
 public:
  Nccl(const Library& library, const Communicator& ranks, bool on_one_host)
      : nccl_(library), on_one_host_(on_one_host) {
    UniqueId id{};
    if (ranks.rank() == 0) check(nccl_.get_unique_id(&id), "ncclGetUniqueId");
    const std::vector<std::byte> ids = ranks.all_gather(&id, sizeof id);
    std::memcpy(&id, ids.data(), sizeof id);
    check(nccl_.init_rank(&comm_, ranks.size(), id, ranks.rank()), "ncclCommInitRank");
    if (on_one_host_) return;
    int least = 0, greatest = 0;
    check(cudaDeviceGetStreamPriorityRange(&least, &greatest));
    check(cudaStreamCreateWithPriority(&beside_, cudaStreamNonBlocking, greatest));
    for (cudaEvent_t* event : {&before_, &after_}) check(cudaEventCreateWithFlags(event, cudaEventDisableTiming));
  }
  ~Nccl() override {
    nccl_.destroy(comm_);
    if (on_one_host_) return;
    cudaEventDestroy(before_);
    cudaEventDestroy(after_);
    cudaStreamDestroy(beside_);
  }
  Nccl(const Nccl&) = delete;
  Nccl& operator=(const Nccl&) = delete;

  std::string description() const override {
    int version = 0;
    nccl_.get_version(&version);
    return fmt::format("NCCL {}.{}.{}", version / 10000, version / 100 % 100, version % 100);
  }
  bool on_one_host() const override { return on_one_host_; }
  void begin_exchange(const std::vector<Message>& sent, const std::vector<Message>& received) override {
    if (sent.empty() && received.empty()) return;
    if (!on_one_host_) {
      check(cudaEventRecord(before_, stream()));
      check(cudaStreamWaitEvent(beside_, before_, 0));
    }
    const cudaStream_t on = on_one_host_ ? stream() : beside_;
    check(nccl_.group_start(), "ncclGroupStart");
    for (const Message& m : received) check(nccl_.receive(m.data, m.bytes, uint8, m.rank, comm_, on), "ncclRecv");
    for (const Message& m : sent) check(nccl_.send(m.data, m.bytes, uint8, m.rank, comm_, on), "ncclSend");
    check(nccl_.group_end(), "ncclGroupEnd");
    if (on_one_host_) return;
    check(cudaEventRecord(after_, beside_));
    under_way_ = true;
  }
  void finish_exchange() override {
    if (under_way_) check(cudaStreamWaitEvent(stream(), after_, 0));
    under_way_ = false;
  }
  void add_up(std::uint32_t* words, std::size_t count) override {
    check(nccl_.all_reduce(words, words, count, uint32, sum, comm_, stream()), "ncclAllReduce");
  }
  void add_up(std::int64_t* words, std::size_t count) override {
    check(nccl_.all_reduce(words, words, count, int64, sum, comm_, stream()), "ncclAllReduce");
  }

 private:
  static cudaStream_t stream() { return exec().cuda_stream(); }
  void check(int code, const char* what) const {
    if (code != 0) throw std::runtime_error(fmt::format("NCCL: {}: {}", what, nccl_.error_string(code)));
  }

  static void check(cudaError_t status) { kokkos_backend::check(status, "messages between GPUs"); }

  Library nccl_;
  bool on_one_host_;
  Comm comm_ = nullptr;
  cudaStream_t beside_ = nullptr;
  cudaEvent_t before_ = nullptr, after_ = nullptr;
  bool under_way_ = false;
};

/// Which GPU, on which host.
std::array<char, 128> own_device() {
  std::array<char, 128> name{};
  gethostname(name.data(), 96);
  int device = 0;
  cudaGetDevice(&device);
  cudaDeviceGetPCIBusId(name.data() + 96, 32, device);
  return name;
}

/// The devices of all ranks.
std::vector<std::array<char, 128>> all_devices(const Communicator& ranks) {
  const std::array<char, 128> own = own_device();
  const std::vector<std::byte> bytes = ranks.all_gather(own.data(), own.size());
  std::vector<std::array<char, 128>> all(static_cast<std::size_t>(ranks.size()));
  std::memcpy(all.data(), bytes.data(), bytes.size());
  return all;
}

}  // namespace

std::unique_ptr<DeviceMessages> make_device_messages(const Communicator& ranks) {
  Library library;
  std::int64_t able = library.load() ? 1 : 0;
  ranks.all_reduce({&able, 1}, {});
  std::vector<std::array<char, 128>> devices = all_devices(ranks);
  const std::string first_host = devices.front().data();
  const bool on_one_host =
      std::all_of(devices.begin(), devices.end(), [&](const auto& d) { return first_host == d.data(); });
  std::sort(devices.begin(), devices.end());
  const bool differ = std::adjacent_find(devices.begin(), devices.end()) == devices.end();
  if (!differ || able < ranks.size()) return nullptr;
  return std::make_unique<Nccl>(library, ranks, on_one_host);
}

}  // namespace drench::kokkos_backend
