// Dense loops over a panel of a Cholesky factor (cloth/block_cholesky.cpp), for one instruction set. A panel lies by
// columns, `stride` numbers apart, a multiple of 16. A row's sums run in the order of columns; a column's have 16
// parts.

inline constexpr Index wide = 16;
using Wide [[gnu::vector_size(wide * sizeof(Real))]] = Real;

/// One register of the instruction set. Twelve sums in registers of Wide would not fit into the 16 that AVX2 has.
inline constexpr Index register_bytes = DRENCH_ISA_BITS / 8;
inline constexpr Index lanes = register_bytes / static_cast<Index>(sizeof(Real));
using Register [[gnu::vector_size(register_bytes)]] = Real;

template <class Vector>
[[gnu::always_inline]] inline void load(Vector& v, const Real* from) {
  std::memcpy(&v, from, sizeof(v));
}
template <class Vector>
[[gnu::always_inline]] inline void store(const Vector& v, Real* to) {
  std::memcpy(to, &v, sizeof(v));
}
/// The sums of each one's 16 parts, by halves.
[[gnu::always_inline]] inline void totals(const Wide (&v)[3], Real (&sum)[3]) {
  using Half [[gnu::vector_size(wide / 2 * sizeof(Real))]] = Real;
  using Quad [[gnu::vector_size(wide / 4 * sizeof(Real))]] = Real;
  Quad q[3];
  for (int i = 0; i < 3; ++i) {
    const Half h = __builtin_shufflevector(v[i], v[i], 0, 1, 2, 3, 4, 5, 6, 7) +
                   __builtin_shufflevector(v[i], v[i], 8, 9, 10, 11, 12, 13, 14, 15);
    q[i] = __builtin_shufflevector(h, h, 0, 1, 2, 3) + __builtin_shufflevector(h, h, 4, 5, 6, 7);
  }
  const Quad two = __builtin_shufflevector(q[0], q[1], 0, 4, 1, 5) + __builtin_shufflevector(q[0], q[1], 2, 6, 3, 7);
  sum[0] = two[0] + two[2];
  sum[1] = two[1] + two[3];
  sum[2] = (q[2][0] + q[2][2]) + (q[2][1] + q[2][3]);
}

/// Subtracts from `count` registers of column c, at row r, the multiples of the columns before it.
template <Index count>
[[gnu::always_inline]] inline void subtract_columns(const Real* a, Index c, Index stride, Index r, Real* own) {
  Register sum[count], v;
  for (Index i = 0; i < count; ++i) load(sum[i], own + r + i * lanes);
  for (Index k = 0; k < c; ++k) {
    const Real* const column = a + k * stride;
    const Real part = column[c];
    for (Index i = 0; i < count; ++i) {
      load(v, column + r + i * lanes);
      sum[i] -= part * v;
    }
  }
  for (Index i = 0; i < count; ++i) store(sum[i], own + r + i * lanes);
}

/// Factors the first `columns` columns in place. Where rounding has taken a pivot, that number stays as it is.
inline void factor_panel(Real* a, Index columns, Index stride, Real* inverse_pivot) {
  for (Index c = 0; c < columns; ++c) {
    Real* const own = a + c * stride;
    const Index begin = c / wide * wide;
    Index first = begin;
    for (; first + wide < stride; first += 2 * wide) subtract_columns<2 * wide / lanes>(a, c, stride, first, own);
    if (first < stride) subtract_columns<wide / lanes>(a, c, stride, first, own);
    const Real inverse = own[c] > 0 ? 1 / std::sqrt(own[c]) : Real(0);
    inverse_pivot[c] = inverse;
    for (Index r = begin; r < stride; r += wide) {
      Wide v;
      load(v, own + r);
      v = inverse * v;
      store(v, own + r);
    }
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
      for (Index r = k / wide * wide; r < top; r += wide) {
        Wide sum, v;
        load(sum, x + r);
        load(v, a + k * stride + r);
        sum -= own * v;
        store(sum, x + r);
      }
      x[k] = own;
    }
  }
}

/// out[q] = Σ_c a_c a_c[row + q] for `count` ≤ 6 rows, of rows [from, to); `a`: the rows below, `to` and `from`
/// multiples of 16.
template <Index count>
[[gnu::always_inline]] inline void panel_products(const Real* a, Index columns, Index stride, Index row, Index from,
                                                  Index to, Real* out, Index out_stride) {
  Index r = from;
  for (; r + lanes < to; r += 2 * lanes) {
    Register first[count]{}, second[count]{}, v, w;
    for (Index c = 0; c < columns; ++c) {
      const Real* const column = a + c * stride;
      load(v, column + r);
      load(w, column + r + lanes);
      for (Index q = 0; q < count; ++q) {
        first[q] += column[row + q] * v;
        second[q] += column[row + q] * w;
      }
    }
    for (Index q = 0; q < count; ++q) {
      store(first[q], out + q * out_stride + r);
      store(second[q], out + q * out_stride + r + lanes);
    }
  }
  if (r >= to) return;
  Register sum[count]{}, v;
  for (Index c = 0; c < columns; ++c) {
    const Real* const column = a + c * stride;
    load(v, column + r);
    for (Index q = 0; q < count; ++q) sum[q] += column[row + q] * v;
  }
  for (Index q = 0; q < count; ++q) store(sum[q], out + q * out_stride + r);
}
inline void products_of_3(const Real* a, Index columns, Index stride, Index row, Index from, Index to, Real* out,
                          Index out_stride) {
  panel_products<3>(a, columns, stride, row, from, to, out, out_stride);
}
inline void products_of_6(const Real* a, Index columns, Index stride, Index row, Index from, Index to, Real* out,
                          Index out_stride) {
  panel_products<6>(a, columns, stride, row, from, to, out, out_stride);
}

/// out = Σ_c a_c x_c over `rows` rows, a multiple of 16.
inline void panel_times(const Real* a, Index columns, Index stride, Index rows, const Real* x, Real* out) {
  constexpr Index count = wide / lanes;
  for (Index r = 0; r < rows; r += wide) {
    Register even[count]{}, odd[count]{}, v;
    Index c = 0;
    for (; c + 1 < columns; c += 2)
      for (Index i = 0; i < count; ++i) {
        load(v, a + c * stride + r + i * lanes);
        even[i] += x[c] * v;
        load(v, a + (c + 1) * stride + r + i * lanes);
        odd[i] += x[c + 1] * v;
      }
    for (Index i = 0; i < count; ++i) {
      if (c < columns) {
        load(v, a + c * stride + r + i * lanes);
        even[i] += x[c] * v;
      }
      const Register sum = even[i] + odd[i];
      store(sum, out + r + i * lanes);
    }
  }
}

/// out_c −= a_c · x over `rows` rows, a multiple of 16; columns are a multiple of 3.
inline void subtract_transposed(const Real* a, Index columns, Index stride, Index rows, const Real* x, Real* out) {
  for (Index c = 0; c < columns; c += 3) {
    const Real* const first = a + c * stride;
    Wide sum[3]{}, v, w;
    for (Index r = 0; r < rows; r += wide) {
      load(w, x + r);
      for (int q = 0; q < 3; ++q) {
        load(v, first + q * stride + r);
        sum[q] += v * w;
      }
    }
    Real all[3];
    totals(sum, all);
    for (int q = 0; q < 3; ++q) out[c + q] -= all[q];
  }
}
