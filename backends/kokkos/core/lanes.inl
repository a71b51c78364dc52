// Vectors of numbers for one instruction set (host/for_each_isa.hpp): loops over the rows of a list take some pairs at
// once. A sum has 16 parts on every instruction set, and pair k goes to part k modulo 16: all of them compute the same
// bits.

inline constexpr Index lanes = DRENCH_ISA_BITS / 8 / sizeof(Real) < 4 ? 4 : DRENCH_ISA_BITS / 8 / sizeof(Real);
inline constexpr Index sum_parts = 16, vectors_of_sum = sum_parts / lanes;
using Lanes [[gnu::vector_size(lanes * sizeof(Real))]] = Real;
/// Which vector of a sum the pairs from k on go to.
constexpr Index part_of(Index k) { return k / lanes % vectors_of_sum; }

/// Four vectors and numbers of neighbours, turned to lanes.
struct LaneVectors {
  Lanes x, y, z, w;
};

/// The next of a row's items, of which `rest` are left; lanes beyond them have `spare`, in `room`.
[[gnu::always_inline]] inline const Index* next_items(const Index* from, Index rest, Index spare,
                                                      Index (&room)[lanes]) {
  if (rest >= lanes) return from;
  for (Index k = 0; k < lanes; ++k) room[k] = k < rest ? from[k] : spare;
  return room;
}

// As many quads as make up Lanes, side by side.
using Quad [[gnu::vector_size(4 * sizeof(Real))]] = Real;
inline constexpr Index quads = lanes / 4;
#if DRENCH_ISA_BITS == 512 && !defined(DRENCH_DOUBLE)
[[gnu::always_inline]] inline void join(const Quad (&q)[quads], Lanes& all) {
  const auto low = __builtin_shufflevector(q[0], q[1], 0, 1, 2, 3, 4, 5, 6, 7);
  const auto high = __builtin_shufflevector(q[2], q[3], 0, 1, 2, 3, 4, 5, 6, 7);
  all = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
}
#elif DRENCH_ISA_BITS == 512 || (DRENCH_ISA_BITS == 256 && !defined(DRENCH_DOUBLE))
[[gnu::always_inline]] inline void join(const Quad (&q)[quads], Lanes& all) {
  all = __builtin_shufflevector(q[0], q[1], 0, 1, 2, 3, 4, 5, 6, 7);
}
#else
[[gnu::always_inline]] inline void join(const Quad (&q)[quads], Lanes& all) { all = q[0]; }
#endif

[[gnu::always_inline]] inline void load_lanes(const Real4* from, const Index* item, LaneVectors& to) {
  Quad x[quads], y[quads], z[quads], w[quads];
  for (Index g = 0; g < quads; ++g) {
    Quad a, b, c, d;
    std::memcpy(&a, from + item[4 * g], sizeof(Quad));
    std::memcpy(&b, from + item[4 * g + 1], sizeof(Quad));
    std::memcpy(&c, from + item[4 * g + 2], sizeof(Quad));
    std::memcpy(&d, from + item[4 * g + 3], sizeof(Quad));
    const Quad ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
    const Quad ab2 = __builtin_shufflevector(a, b, 2, 6, 3, 7), cd2 = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    x[g] = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
    y[g] = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
    z[g] = __builtin_shufflevector(ab2, cd2, 0, 1, 4, 5);
    w[g] = __builtin_shufflevector(ab2, cd2, 2, 3, 6, 7);
  }
  join(x, to.x);
  join(y, to.y);
  join(z, to.z);
  join(w, to.w);
}

/// v, and 0 beyond the first `rest` lanes.
[[gnu::always_inline]] inline void keep_first(Index rest, Lanes& v) {
  using Whole = std::conditional_t<sizeof(Real) == 4, std::int32_t, std::int64_t>;
  using Wholes [[gnu::vector_size(lanes * sizeof(Real))]] = Whole;
  static constexpr Whole number[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  Wholes lane;
  std::memcpy(&lane, number, sizeof(lane));
  v = lane < static_cast<Whole>(rest) ? v : Lanes{};
}
/// The first `rest` lanes.
[[gnu::always_inline]] inline void store_lanes(const Lanes& v, Index rest, Real* to) {
  if (rest >= lanes) {
    std::memcpy(to, &v, sizeof(v));
    return;
  }
  Real each[lanes];
  std::memcpy(each, &v, sizeof(v));
  for (Index k = 0; k < rest; ++k) to[k] = each[k];
}

/// √ of each lane, rounded as ever.
[[gnu::always_inline]] inline void take_root(Lanes& v) {
  Real each[lanes];
  std::memcpy(each, &v, sizeof(v));
  for (Index k = 0; k < lanes; ++k) each[k] = std::sqrt(each[k]);
  std::memcpy(&v, each, sizeof(v));
}

/// A sum's 16 parts, by halves.
[[gnu::always_inline]] inline Real sum_of(const Lanes (&sum)[vectors_of_sum]) {
  Quad q[4];
  std::memcpy(q, sum, sizeof(q));
  const Quad s = (q[0] + q[2]) + (q[1] + q[3]);
  return (s[0] + s[2]) + (s[1] + s[3]);
}

[[gnu::always_inline]] inline Real least_of(const Lanes& v) {
  Real least = v[0];
  for (Index k = 1; k < lanes; ++k) least = v[k] < least ? v[k] : least;
  return least;
}
