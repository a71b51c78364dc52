#pragma once
// Messages from one GPU's memory to another's, without the host: NCCL, where each rank has a GPU of its own and the
// library is at hand. DRENCH_NCCL names it (default: libnccl.so.2, as PyPI's nvidia-nccl or a system has it); "off"
// leaves it.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "parallel/communicator.hpp"

namespace drench::kokkos_backend {

/// Nobody waits: sums are on the backend's stream, and messages on one of their own beside it.
class DeviceMessages {
 public:
  virtual ~DeviceMessages() = default;
  virtual std::string description() const = 0;
  virtual bool on_one_host() const = 0;  ///< are all GPUs?
  /// As Communicator's, of device memory: messages follow what is on the backend's stream, and go on beside it until
  /// finish_exchange(), after which it waits for them.
  virtual void begin_exchange(const std::vector<Message>& sent, const std::vector<Message>& received) = 0;
  virtual void finish_exchange() = 0;
  /// Sums of all ranks, in place. Of words that are 0 on all ranks but one, they are that one's bits.
  virtual void add_up(std::uint32_t* words, std::size_t count) = 0;
  virtual void add_up(std::int64_t* words, std::size_t count) = 0;
};

/// Null where not every rank can; called by all ranks.
std::unique_ptr<DeviceMessages> make_device_messages(const Communicator& ranks);

}  // namespace drench::kokkos_backend
