// What the ranks' particles travel by (particles/exchange.hpp): by the host's memory, or from GPU to GPU.

#include <chrono>
#include <numeric>

#include "particles/exchange.hpp"

namespace drench::kokkos_backend {
namespace {

std::int64_t sum_of(const std::vector<std::int64_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

void Exchange::begin_packing() const {
  finish_halo();
  if (ranks_->traffic().fenced) exec().fence("drench::exchange::before");
  begin_ = seconds_now();
}

void Exchange::travel(const Array<std::byte>& sent, const std::vector<std::int64_t>& to, void* received,
                      const std::vector<std::int64_t>& from, std::size_t each) const {
  begin_travel(sent, to, received, from, each);
  finish_halo();
}

void Exchange::begin_travel(const Array<std::byte>& sent, const std::vector<std::int64_t>& to, void* received,
                            const std::vector<std::int64_t>& from, std::size_t each) const {
  using Bytes = Kokkos::View<std::byte*, MemSpace, Kokkos::MemoryUnmanaged>;
  const auto out_bytes = static_cast<std::size_t>(sum_of(to)) * each,
             in_bytes = static_cast<std::size_t>(sum_of(from)) * each;
  auto* out = sent.data();
  auto* in = static_cast<std::byte*>(received);
  if (!on_host && !device_) {
    const auto room = [](auto& pinned, std::size_t bytes) {
      if (pinned.extent(0) < bytes)
        pinned = std::decay_t<decltype(pinned)>(Kokkos::ViewAllocateWithoutInitializing("drench::exchange::pinned"),
                                                bytes + bytes / 4);
    };
    room(out_, out_bytes);
    room(in_, in_bytes);
    if (out_bytes > 0)
      Kokkos::deep_copy(exec(), Kokkos::subview(out_, Kokkos::make_pair(std::size_t{0}, out_bytes)),
                        Bytes(sent.data(), out_bytes));
    out = out_.data();
    in = in_.data();
  }
  if (!device_ || ranks_->traffic().fenced) exec().fence("drench::exchange::packed");
  if (begin_ >= 0) ranks_->traffic().packing += seconds_now() - begin_;
  begin_ = -1;
  std::vector<Message> messages, answers;
  const auto add = [each](std::vector<Message>& list, const std::vector<std::int64_t>& counts, std::byte* at) {
    for (std::size_t r = 0; r < counts.size(); ++r) {
      const std::size_t bytes = static_cast<std::size_t>(counts[r]) * each;
      if (bytes > 0) list.push_back({static_cast<int>(r), at, bytes});
      at += bytes;
    }
  };
  add(messages, to, out);
  add(answers, from, in);
  under_way_ = true;
  arriving_ = received;
  arriving_bytes_ = in_bytes;
  if (device_)
    begin_on_device(messages, answers);
  else
    ranks_->begin_exchange(messages, answers);
  if (!overlaps_ || ranks_->traffic().fenced) finish_halo();  // fenced: its time is in no other part of the table
}

void Exchange::finish_halo() const {
  if (!under_way_) return;
  under_way_ = false;
  if (device_) {
    const double begin = seconds_now();
    device_->finish_exchange();
    if (ranks_->traffic().fenced) exec().fence("drench::exchange::arrived");
    ranks_->traffic().exchanging += seconds_now() - begin;
  } else {
    ranks_->finish_exchange();
    if (!on_host && arriving_bytes_ > 0) {
      using Bytes = Kokkos::View<std::byte*, MemSpace, Kokkos::MemoryUnmanaged>;
      Kokkos::deep_copy(exec(), Bytes(static_cast<std::byte*>(arriving_), arriving_bytes_),
                        Kokkos::subview(in_, Kokkos::make_pair(std::size_t{0}, arriving_bytes_)));
    }
  }
}

void Exchange::begin_on_device(const std::vector<Message>& sent, const std::vector<Message>& received) const {
  Traffic& traffic = ranks_->traffic();
  const double begin = seconds_now();
  device_->begin_exchange(sent, received);
  traffic.exchanging += seconds_now() - begin;
  traffic.messages += static_cast<std::int64_t>(sent.size());
  for (const Message& m : sent) traffic.bytes += static_cast<std::int64_t>(m.bytes);
}

void Exchange::share_bytes(void* data, std::size_t bytes) const {
  finish_halo();
  if (device_ && bytes % sizeof(std::uint32_t) == 0) {
    device_->add_up(static_cast<std::uint32_t*>(data), bytes / sizeof(std::uint32_t));
    return;
  }
  exec().fence("drench::exchange::share");
  if constexpr (on_host) {
    ranks_->all_or(data, bytes);
  } else {
    using Bytes = Kokkos::View<std::byte*, MemSpace, Kokkos::MemoryUnmanaged>;
    const Bytes device(static_cast<std::byte*>(data), bytes);
    const auto host = on_host_now(device);
    ranks_->all_or(host.data(), bytes);
    copy_now(device, host);
  }
}

void Exchange::add_up_words(std::int64_t* sums, std::size_t count) const {
  finish_halo();
  if (device_) {
    device_->add_up(sums, count);
    return;
  }
  using Words = Kokkos::View<std::int64_t*, MemSpace, Kokkos::MemoryUnmanaged>;
  exec().fence("drench::exchange::add_up");
  const Words device(sums, count);
  const auto host = on_host_now(device);
  ranks_->all_reduce({host.data(), count}, {});
  copy_now(device, host);
}

void Exchange::add_up(Field<Index>& sums, Index count) const {
  if (alone()) return;
  make_room(wide_, "drench::exchange::wide", static_cast<std::size_t>(count));
  const Entries<std::int64_t> to = wide_;
  const Entries<Index> from = sums;
  parallel(
      "drench::exchange::widen", count, KOKKOS_LAMBDA(const Index k) { to(k) = from(k); });
  add_up_words(wide_.data(), static_cast<std::size_t>(count));
  parallel(
      "drench::exchange::narrow", count, KOKKOS_LAMBDA(const Index k) { from(k) = static_cast<Index>(to(k)); });
}

}  // namespace drench::kokkos_backend
