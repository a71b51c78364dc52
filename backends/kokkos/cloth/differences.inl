// Loops of Anderson's acceleration (cloth/factored.cpp), for one instruction set; `n` is a multiple of 16. A sum has 16 parts.

inline constexpr Index wide = 16;
using Wide [[gnu::vector_size(wide * sizeof(Real))]] = Real;
using WideDouble [[gnu::vector_size(wide * sizeof(double))]] = double;

/// a · b, in double.
inline double product(const Real* a, const Real* b, Index n) {
  WideDouble sum{};
  for (Index k = 0; k < n; k += wide) {
    Wide x, y;
    std::memcpy(&x, a + k, sizeof(x));
    std::memcpy(&y, b + k, sizeof(y));
    sum += __builtin_convertvector(x, WideDouble) * __builtin_convertvector(y, WideDouble);
  }
  double part[wide];
  std::memcpy(part, &sum, sizeof(sum));
  for (Index half = wide / 2; half > 0; half /= 2)
    for (Index k = 0; k < half; ++k) part[k] += part[k + half];
  return part[0];
}

/// x += z − Σ_k w_k d_k.
inline void combine(Real* x, const Real* z, const Real* const* d, const Real* w, int count, Index n) {
  for (Index i = 0; i < n; i += wide) {
    Wide sum, v;
    std::memcpy(&sum, x + i, sizeof(sum));
    std::memcpy(&v, z + i, sizeof(v));
    sum += v;
    for (int k = 0; k < count; ++k) {
      std::memcpy(&v, d[k] + i, sizeof(v));
      sum -= w[k] * v;
    }
    std::memcpy(x + i, &sum, sizeof(sum));
  }
}
