#pragma once
// The one place that says where kernels run and in which precision.

#include <Kokkos_Core.hpp>

#include "state/types.hpp"

namespace drench::kokkos_backend {

using ExecSpace = Kokkos::DefaultExecutionSpace;
using MemSpace = ExecSpace::memory_space;
#ifdef DRENCH_DOUBLE
using Real = double;
#else
using Real = float;
#endif

template <class T>
using Array = Kokkos::View<T*, MemSpace>;

/// Before a loop with loads that wait for each other: a GPU has some of them under way at once.
#ifdef __CUDA_ARCH__
#define DRENCH_UNROLL _Pragma("unroll 4")
#else
#define DRENCH_UNROLL
#endif

/// An array as a kernel with many of them sees it, 8 bytes in place of a View's 24: from 512 bytes of arguments on, what
/// Kokkos adds to them included, launches on CUDA wait for each other.
template <class T>
struct Entries {
  T* data = nullptr;

  Entries() = default;
  Entries(const Array<T>& a) : data(a.data()) {}
  KOKKOS_INLINE_FUNCTION T& operator()(std::int64_t i) const { return data[i]; }
  KOKKOS_INLINE_FUNCTION bool exist() const { return data != nullptr; }
};
/// The same with its length, 16 bytes.
template <class T>
struct Slice {
  T* data = nullptr;
  std::int64_t count = 0;

  Slice() = default;
  Slice(const Array<T>& a) : data(a.data()), count(static_cast<std::int64_t>(a.extent(0))) {}
  KOKKOS_INLINE_FUNCTION T& operator()(std::int64_t i) const { return data[i]; }
  KOKKOS_INLINE_FUNCTION std::size_t extent(int) const { return static_cast<std::size_t>(count); }
};
using Range = Kokkos::RangePolicy<ExecSpace, Kokkos::IndexType<Index>>;
/// Blocks of 128 threads on a GPU, so that also a cloth's nodes lie on all of its processors; on an H200 that made no kernel
/// measurably faster.
using LoopRange = Kokkos::RangePolicy<ExecSpace, Kokkos::IndexType<Index>, Kokkos::LaunchBounds<128, 1>>;

struct Real3 {
  Real x = 0, y = 0, z = 0;
  KOKKOS_INLINE_FUNCTION Real3& operator+=(const Real3& o) {
    x += o.x;
    y += o.y;
    z += o.z;
    return *this;
  }
  KOKKOS_INLINE_FUNCTION Real3& operator-=(const Real3& o) {
    x -= o.x;
    y -= o.y;
    z -= o.z;
    return *this;
  }
};
/// A vector and a number in one load: what loops over neighbours read.
struct alignas(4 * sizeof(Real)) Real4 {
  Real x = 0, y = 0, z = 0, w = 0;
  Real4() = default;
  KOKKOS_INLINE_FUNCTION Real4(const Real3& v, Real number) : x(v.x), y(v.y), z(v.z), w(number) {}
  KOKKOS_INLINE_FUNCTION Real3 xyz() const { return {x, y, z}; }
};
KOKKOS_INLINE_FUNCTION Real3 operator+(Real3 a, const Real3& b) { return a += b; }
KOKKOS_INLINE_FUNCTION Real3 operator-(Real3 a, const Real3& b) { return a -= b; }
KOKKOS_INLINE_FUNCTION Real3 operator-(const Real3& a) { return {-a.x, -a.y, -a.z}; }
KOKKOS_INLINE_FUNCTION Real3 operator*(Real s, const Real3& a) { return {s * a.x, s * a.y, s * a.z}; }
KOKKOS_INLINE_FUNCTION Real dot(const Real3& a, const Real3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
/// 1/√x; a GPU has an instruction for it, to 2 ulp, where root and division are exact and take several times as long.
KOKKOS_INLINE_FUNCTION Real inverse_root(Real x) {
#ifdef __CUDA_ARCH__
  return ::rsqrt(x);
#else
  return 1 / Kokkos::sqrt(x);
#endif
}
KOKKOS_INLINE_FUNCTION Real norm(const Real3& a) { return Kokkos::sqrt(dot(a, a)); }
KOKKOS_INLINE_FUNCTION Real3 cross(const Real3& a, const Real3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Runs `body(i)` for i in [0, n) under a label that Kokkos Tools and profilers show, e.g. "drench::density::alpha".
template <class Body>
void parallel(const char* label, Index n, const Body& body) {
  if (n > 0) Kokkos::parallel_for(label, LoopRange(0, n), body);
}

}  // namespace drench::kokkos_backend
