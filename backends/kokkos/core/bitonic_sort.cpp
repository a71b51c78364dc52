// Bitonic sort (Batcher 1968) of 64-bit keys: the bucket above the particle's index. Keys that fill up to a power of
// two are maximal, so they stay at the end. Stage k (2, 4, 8, …) merges runs of k/2 keys into runs of k, every second
// one descending, by passes that compare keys k/2, k/4, …, 1 apart.

#include <algorithm>

#include "core/bucket_sort.hpp"

namespace drench::kokkos_backend {
namespace {

using WideKey = std::uint64_t;

void write_keys(const CellTableView& t, const Array<Real3>& points, Index count, const Array<WideKey>& key,
                Index padded) {
  parallel(
      "drench::cell_table::bitonic_keys", padded, KOKKOS_LAMBDA(const Index i) {
        key(i) = i < count ? static_cast<WideKey>(bucket_of_point(t, points(i))) << 32 | static_cast<WideKey>(i)
                           : ~WideKey(0);
      });
}

void read_items(const CellTableView& t, Index count, const Array<WideKey>& key) {
  const auto item = t.item;
  parallel(
      "drench::cell_table::bitonic_items", count,
      KOKKOS_LAMBDA(const Index e) { item(e) = static_cast<Index>(key(e) & 0xffffffffu); });
}

// ---- the paper's: one launch for every pass, one thread for every key (Tables 5 and 6)

void sort_naively(const Array<WideKey>& key, Index padded) {
  // The paper's inner loop runs while i ≥ 1, which never ends: j is meant.
  for (std::int64_t i = 2; i <= padded; i *= 2)
    for (std::int64_t j = i / 2; j >= 1; j /= 2) {
      const auto run = static_cast<Index>(i), apart = static_cast<Index>(j);
      parallel(
          "drench::cell_table::bitonic_pass", padded, KOKKOS_LAMBDA(const Index e) {
            if ((e & apart) != 0) return;  // tid % 2j ≥ j; both are powers of two
            const bool descending = (e & run) != 0;
            const WideKey a = key(e), b = key(e + apart);
            if (descending ? a < b : a > b) {
              key(e) = b;
              key(e + apart) = a;
            }
          });
    }
}

// ---- fused: up to three passes on eight keys in registers, and all passes within a block of keys in scratch memory

constexpr int lot_bits = 3;
constexpr int block_bits = on_host ? 11 : 12;  // 2048 or 4096 keys, 34 KiB with the gaps; Kokkos gives 32 on the host

/// Keys in memory as they lie there.
struct Plain {
  WideKey* data;
  KOKKOS_INLINE_FUNCTION WideKey& operator[](Index i) const { return data[i]; }
};
/// Keys in scratch memory with a gap after every sixteen, so that a warp's lots of eight fall into different banks.
struct Gapped {
  WideKey* data;
  KOKKOS_INLINE_FUNCTION WideKey& operator[](Index i) const { return data[i + (i >> 4)]; }
  KOKKOS_INLINE_FUNCTION static constexpr std::size_t size(Index keys) {
    return static_cast<std::size_t>(keys + (keys >> 4));
  }
};

KOKKOS_INLINE_FUNCTION void order(WideKey& a, WideKey& b, bool descending) {
  const WideKey low = a < b ? a : b, high = a < b ? b : a;
  a = descending ? high : low;
  b = descending ? low : high;
}

/// `bits` passes at once, over distances 2^(low + bits − 1), …, 2^low: on the 2^bits keys that these connect, of which
/// there are as many sets as keys / 2^bits. `first` is the number of keys[0] among all; stage 2^stage.
template <int bits, class Keys>
KOKKOS_INLINE_FUNCTION void pass(const Keys& keys, Index set, int low, Index first, int stage) {
  constexpr int lot = 1 << bits;
  const Index at = (set >> low) << (low + bits) | (set & ((Index(1) << low) - 1));
  const bool descending = ((first + at) >> stage & 1) != 0;
  WideKey key[lot];
  for (int m = 0; m < lot; ++m) key[m] = keys[at + (Index(m) << low)];
  for (int s = bits - 1; s >= 0; --s)
    for (int m = 0; m < lot; ++m)
      if ((m >> s & 1) == 0) order(key[m], key[m | 1 << s], descending);
  for (int m = 0; m < lot; ++m) keys[at + (Index(m) << low)] = key[m];
}

/// The first three stages on eight keys side by side.
template <class Keys>
KOKKOS_INLINE_FUNCTION void sort_lot(const Keys& keys, Index set, Index first) {
  constexpr int lot = 1 << lot_bits;
  const Index at = set << lot_bits;
  const bool all_descending = ((first + at) >> lot_bits & 1) != 0;
  WideKey key[lot];
  for (int m = 0; m < lot; ++m) key[m] = keys[at + m];
  for (int stage = 1; stage <= lot_bits; ++stage)
    for (int s = stage - 1; s >= 0; --s)
      for (int m = 0; m < lot; ++m)
        if ((m >> s & 1) == 0)
          order(key[m], key[m | 1 << s], stage < lot_bits ? (m >> stage & 1) != 0 : all_descending);
  for (int m = 0; m < lot; ++m) keys[at + m] = key[m];
}

using Team = Kokkos::TeamPolicy<ExecSpace>::member_type;
static_assert(on_host || Gapped::size(1 << block_bits) * sizeof(WideKey) <= most_scratch(1 << (block_bits - lot_bits)));
using Scratch = Kokkos::View<WideKey*, ExecSpace::scratch_memory_space, Kokkos::MemoryTraits<Kokkos::Unmanaged>>;

/// All passes of a stage over distances below 2^high, in scratch memory.
KOKKOS_INLINE_FUNCTION void merge_in_scratch(const Team& team, const Gapped& keys, int block, int high, Index first,
                                             int stage) {
  const Index size = Index(1) << block;
  for (int low = high; low > 0;) {
    const int bits = low < lot_bits ? low : lot_bits;
    low -= bits;
    for (Index set = team.team_rank(); set < size >> bits; set += team.team_size()) {
      if (bits == 3)
        pass<3>(keys, set, low, first, stage);
      else if (bits == 2)
        pass<2>(keys, set, low, first, stage);
      else
        pass<1>(keys, set, low, first, stage);
    }
    team.team_barrier();
  }
}

/// In blocks of 2^block keys: the stages up to that (stage 0), or what is left of a later stage.
void sort_blocks(const Array<WideKey>& key, Index padded, int block, int stage) {
  const Index size = Index(1) << block;
  const int team_size = on_host ? 1 : static_cast<int>(size >> lot_bits);
  Kokkos::TeamPolicy<ExecSpace> policy(exec(), padded >> block, team_size);
  policy.set_scratch_size(0, Kokkos::PerTeam(Scratch::shmem_size(Gapped::size(size))));
  Kokkos::parallel_for(
      stage == 0 ? "drench::cell_table::bitonic_blocks" : "drench::cell_table::bitonic_merge", policy,
      KOKKOS_LAMBDA(const Team& team) {
        const Scratch scratch(team.team_scratch(0), Gapped::size(size));
        const Gapped keys{scratch.data()};
        const Index first = team.league_rank() << block;
        for (Index e = team.team_rank(); e < size; e += team.team_size()) keys[e] = key(first + e);
        team.team_barrier();
        if (stage == 0) {
          for (Index set = team.team_rank(); set < size >> lot_bits; set += team.team_size())
            sort_lot(keys, set, first);
          team.team_barrier();
          for (int s = lot_bits + 1; s <= block; ++s) merge_in_scratch(team, keys, block, s, first, s);
        } else {
          merge_in_scratch(team, keys, block, block, first, stage);
        }
        for (Index e = team.team_rank(); e < size; e += team.team_size()) key(first + e) = keys[e];
      });
}

template <int bits>
void pass_over_all(const Array<WideKey>& key, Index padded, int low, int stage) {
  parallel(
      "drench::cell_table::bitonic_passes", padded >> bits,
      KOKKOS_LAMBDA(const Index set) { pass<bits>(Plain{key.data()}, set, low, 0, stage); });
}

void sort_fused(const Array<WideKey>& key, Index padded) {
  int all = 0;
  while (Index(1) << all < padded) ++all;
  const int block = std::min(block_bits, all);
  sort_blocks(key, padded, block, 0);
  for (int stage = block + 1; stage <= all; ++stage) {
    for (int low = stage; low > block;) {
      const int bits = std::min(lot_bits, low - block);
      low -= bits;
      if (bits == 3)
        pass_over_all<3>(key, padded, low, stage);
      else if (bits == 2)
        pass_over_all<2>(key, padded, low, stage);
      else
        pass_over_all<1>(key, padded, low, stage);
    }
    sort_blocks(key, padded, block, stage);
  }
}

class BitonicSort final : public BucketSort {
 public:
  explicit BitonicSort(bool naive) : naive_(naive) {}
  void make_keys(CellTableView& table, const Array<Real3>& points, Index count) override {
    padded_ = naive_ ? 1 : 1 << lot_bits;
    while (padded_ < count) padded_ *= 2;  // a table has at most 2^28 particles (setup/memory_estimate.cpp)
    make_room(key_, "drench::cell_bitonic_key", static_cast<std::size_t>(padded_));
    write_keys(table, points, count, key_, padded_);
  }
  void sort(CellTableView&, Index) override { naive_ ? sort_naively(key_, padded_) : sort_fused(key_, padded_); }
  void read_out(CellTableView& table, Index count) override {
    read_items(table, count, key_);
    find_starts(table, key_, count);
  }

 private:
  bool naive_;
  Index padded_ = 0;
  Array<WideKey> key_;
};

}  // namespace

std::shared_ptr<BucketSort> make_bitonic_sort(bool naive) { return std::make_shared<BitonicSort>(naive); }

}  // namespace drench::kokkos_backend
