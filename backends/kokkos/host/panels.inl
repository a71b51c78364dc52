// Dense loops over a panel of a Cholesky factor (host/panels.hpp), for one instruction set. A panel lies by
// columns, `stride` numbers apart, a multiple of 16. A row's sums run in the order of columns; a column's have 16
// parts. Arrays of registers are never set to 0 and have loops of known lengths: g++ keeps others in memory.

inline constexpr Index wide = 16;

/// One register of the instruction set. Twelve sums of 16 numbers would not fit into the 16 registers that AVX2 has.
inline constexpr Index register_bytes = DRENCH_ISA_BITS / 8;
inline constexpr Index lanes = register_bytes / static_cast<Index>(sizeof(Real));
inline constexpr Index registers = wide / lanes;  // of 16 numbers
using Register [[gnu::vector_size(register_bytes)]] = Real;
using RegisterAnywhere [[gnu::vector_size(register_bytes), gnu::aligned(sizeof(Real)), gnu::may_alias]] = Real;
using FourAnywhere [[gnu::vector_size(4 * sizeof(Real)), gnu::aligned(sizeof(Real)), gnu::may_alias]] = Real;

[[gnu::always_inline]] inline Register load(const Real* from) {
  return *reinterpret_cast<const RegisterAnywhere*>(from);
}
[[gnu::always_inline]] inline void store(const Register& v, Real* to) { *reinterpret_cast<RegisterAnywhere*>(to) = v; }

/// The sum of a vector by halves.
template <class Vector>
[[gnu::always_inline]] inline Real total(const Vector& v) {
  constexpr int count = static_cast<int>(sizeof(Vector) / sizeof(Real));
  if constexpr (count == 2) {
    return v[0] + v[1];
  } else if constexpr (count == 4) {
    return (v[0] + v[2]) + (v[1] + v[3]);
  } else if constexpr (count == 8) {
    return total(__builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7));
  } else {
    return total(__builtin_shufflevector(v, v, 0, 1, 2, 3, 4, 5, 6, 7) +
                 __builtin_shufflevector(v, v, 8, 9, 10, 11, 12, 13, 14, 15));
  }
}

/// Subtracts from `count` registers of column c, at row r, the multiples of the columns before it.
template <Index count>
[[gnu::always_inline]] inline void subtract_columns(const Real* a, Index c, Index stride, Index r, Real* own) {
  Register sum[count];
#pragma GCC unroll 16
  for (Index i = 0; i < count; ++i) sum[i] = load(own + r + i * lanes);
  for (Index k = 0; k < c; ++k) {
    const Real* const column = a + k * stride;
    const Real part = column[c];
#pragma GCC unroll 16
    for (Index i = 0; i < count; ++i) sum[i] -= part * load(column + r + i * lanes);
  }
#pragma GCC unroll 16
  for (Index i = 0; i < count; ++i) store(sum[i], own + r + i * lanes);
}

/// Factors the first `columns` columns in place. Where rounding has taken a pivot, that number stays as it is.
inline void factor_panel(Real* a, Index columns, Index stride, Real* inverse_pivot) {
  for (Index c = 0; c < columns; ++c) {
    Real* const own = a + c * stride;
    const Index begin = c / wide * wide;
    Index first = begin;
    for (; first + wide < stride; first += 2 * wide) subtract_columns<2 * registers>(a, c, stride, first, own);
    if (first < stride) subtract_columns<registers>(a, c, stride, first, own);
    const Real inverse = own[c] > 0 ? 1 / std::sqrt(own[c]) : Real(0);
    inverse_pivot[c] = inverse;
    for (Index r = begin; r < stride; r += lanes) store(inverse * load(own + r), own + r);
    std::fill_n(own, c, Real(0));  // above the diagonal
  }
}

/// The inverse of the panel's own triangle, by columns of `top` numbers.
inline void invert_panel(const Real* a, Index columns, Index stride, Index top, const Real* inverse_pivot,
                         Real* inverse) {
  for (Index c = 0; c < columns; ++c) {
    Real* const x = inverse + c * top;
    for (Index r = 0; r < top; ++r) x[r] = r == c ? Real(1) : Real(0);
    for (Index k = c; k < columns; ++k) {
      const Real own = inverse_pivot[k] * x[k];
      for (Index r = k / lanes * lanes; r < top; r += lanes) store(load(x + r) - own * load(a + k * stride + r), x + r);
      x[k] = own;
    }
  }
}

/// out[q] = Σ_c a_c a_c[row + q] for `count` rows, at `rows` registers from row r on.
template <Index count, Index rows>
[[gnu::always_inline]] inline void products_at(const Real* a, Index columns, Index stride, Index row, Index r,
                                               Real* out, Index out_stride) {
  Register sum[count][rows];
#pragma GCC unroll 2
  for (Index i = 0; i < rows; ++i) {
    const Register v = load(a + r + i * lanes);
#pragma GCC unroll 6
    for (Index q = 0; q < count; ++q) sum[q][i] = a[row + q] * v;
  }
  for (Index c = 1; c < columns; ++c) {
    const Real* const column = a + c * stride;
    Register v[rows];
#pragma GCC unroll 2
    for (Index i = 0; i < rows; ++i) v[i] = load(column + r + i * lanes);
#pragma GCC unroll 6
    for (Index q = 0; q < count; ++q) {
      const Real part = column[row + q];
#pragma GCC unroll 2
      for (Index i = 0; i < rows; ++i) sum[q][i] += part * v[i];
    }
  }
#pragma GCC unroll 6
  for (Index q = 0; q < count; ++q)
#pragma GCC unroll 2
    for (Index i = 0; i < rows; ++i) store(sum[q][i], out + q * out_stride + r + i * lanes);
}

/// The same for rows [from, to); `a`: the rows below, `to` and `from` multiples of 16.
template <Index count>
[[gnu::always_inline]] inline void panel_products(const Real* a, Index columns, Index stride, Index row, Index from,
                                                  Index to, Real* out, Index out_stride) {
  Index r = from;
  for (; r + lanes < to; r += 2 * lanes) products_at<count, 2>(a, columns, stride, row, r, out, out_stride);
  if (r < to) products_at<count, 1>(a, columns, stride, row, r, out, out_stride);
}
inline void products_of_3(const Real* a, Index columns, Index stride, Index row, Index from, Index to, Real* out,
                          Index out_stride) {
  panel_products<3>(a, columns, stride, row, from, to, out, out_stride);
}
inline void products_of_6(const Real* a, Index columns, Index stride, Index row, Index from, Index to, Real* out,
                          Index out_stride) {
  panel_products<6>(a, columns, stride, row, from, to, out, out_stride);
}

/// out = Σ_c a_c x_c over `rows` rows, a multiple of 16; even and odd columns apart.
inline void panel_times(const Real* a, Index columns, Index stride, Index rows, const Real* x, Real* out) {
  for (Index r = 0; r < rows; r += wide) {
    Register even[registers]{}, odd[registers]{};
    Index c = 0;
    for (; c + 1 < columns; c += 2)
#pragma GCC unroll 16
      for (Index i = 0; i < registers; ++i) {
        even[i] += x[c] * load(a + c * stride + r + i * lanes);
        odd[i] += x[c + 1] * load(a + (c + 1) * stride + r + i * lanes);
      }
#pragma GCC unroll 16
    for (Index i = 0; i < registers; ++i) {
      if (c < columns) even[i] += x[c] * load(a + c * stride + r + i * lanes);
      store(even[i] + odd[i], out + r + i * lanes);
    }
  }
}

/// out_c −= a_c · x over `rows` rows, a multiple of 16; columns are a multiple of 3.
inline void subtract_transposed(const Real* a, Index columns, Index stride, Index rows, const Real* x, Real* out) {
  for (Index c = 0; c < columns; c += 3) {
    const Real* const first = a + c * stride;
    Register sum[3][registers]{};
    for (Index r = 0; r < rows; r += wide)
#pragma GCC unroll 16
      for (Index i = 0; i < registers; ++i) {
        const Register w = load(x + r + i * lanes);
#pragma GCC unroll 3
        for (Index q = 0; q < 3; ++q) sum[q][i] += load(first + q * stride + r + i * lanes) * w;
      }
#pragma GCC unroll 3
    for (Index q = 0; q < 3; ++q) {
#pragma GCC unroll 4
      for (Index half = registers / 2; half > 0; half /= 2)
#pragma GCC unroll 8
        for (Index i = 0; i < half; ++i) sum[q][i] += sum[q][i + half];
      out[c + q] -= total(sum[q][0]);
    }
  }
}

/// Subtracts `length` products from numbers of a target.
[[gnu::always_inline]] inline void subtract_run(const Real* products, Index length, Real* to) {
  Index k = 0;
  for (; k + lanes <= length; k += lanes) store(load(to + k) - load(products + k), to + k);
  if constexpr (lanes > 4)
    for (; k + 4 <= length; k += 4)
      *reinterpret_cast<FourAnywhere*>(to + k) -= *reinterpret_cast<const FourAnywhere*>(products + k);
  for (; k < length; ++k) to[k] -= products[k];
}

/// Subtracts `count` columns of products, `stride` apart, from those of a target, run by run.
template <Index count>
[[gnu::always_inline]] inline void subtract_runs(const Real* products, Index stride, const PanelRun* run,
                                                 const PanelRun* end, Real* const* to) {
  for (; run != end; ++run) {
    const Real* const from = products + run->source;
    if (run->length == 3) {  // most of them
#pragma GCC unroll 6
      for (Index q = 0; q < count; ++q)
        for (Index k = 0; k < 3; ++k) to[q][run->target + k] -= from[q * stride + k];
    } else {
      for (Index q = 0; q < count; ++q) subtract_run(from + q * stride, run->length, to[q] + run->target);
    }
  }
}
inline void subtract_runs_of_3(const Real* products, Index stride, const PanelRun* run, const PanelRun* end,
                               Real* const* to) {
  subtract_runs<3>(products, stride, run, end, to);
}
inline void subtract_runs_of_6(const Real* products, Index stride, const PanelRun* run, const PanelRun* end,
                               Real* const* to) {
  subtract_runs<6>(products, stride, run, end, to);
}

inline constexpr PanelLoops loops{factor_panel,       invert_panel,       products_of_3, products_of_6,
                                  subtract_runs_of_3, subtract_runs_of_6, panel_times,   subtract_transposed};
