#pragma once
// The one place that says where kernels run and in which precision.

#include <Kokkos_Core.hpp>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>

#include "core/host_loops.hpp"
#include "host/real.hpp"

namespace drench::kokkos_backend {

using ExecSpace = Kokkos::DefaultExecutionSpace;
using MemSpace = ExecSpace::memory_space;
/// Do kernels run on the host? A GPU wants other loops here and there.
inline constexpr bool on_host = std::is_same_v<MemSpace, Kokkos::HostSpace>;
#if defined(KOKKOS_ENABLE_DEBUG_BOUNDS_CHECK) || !defined(NDEBUG)
#define DRENCH_CHECK_BOUNDS
#endif

template <class T>
using Array = Kokkos::View<T*, MemSpace>;

/// Before a loop with loads that wait for each other: a GPU has some of them under way at once.
#ifdef __CUDA_ARCH__
#define DRENCH_UNROLL _Pragma("unroll 4")
#else
#define DRENCH_UNROLL
#endif
/// Before a loop with a long body: a GPU would have a copy of it for each round.
#ifdef __CUDA_ARCH__
#define DRENCH_ROLLED _Pragma("unroll 1")
#else
#define DRENCH_ROLLED
#endif
/// For a function that is called seldom: on a GPU its code stays apart from the caller's.
#ifdef __CUDA_ARCH__
#define DRENCH_SELDOM __noinline__
#else
#define DRENCH_SELDOM
#endif

/// An entry that no kernel writes while this one runs: a GPU reads it through a cache that barriers do not empty.
template <class T>
KOKKOS_INLINE_FUNCTION T read_only(const T* from) {
#ifdef __CUDA_ARCH__
  return __ldg(from);
#else
  return *from;
#endif
}

/// A raw-pointer view of an array for kernels: 8 bytes instead of a View's 24. CUDA launches serialise once a kernel's
/// arguments exceed 512 bytes. A debug build carries the length and checks it. `Entries<const T>` is read-only.
template <class T>
struct Entries {
  using Owner = Array<std::remove_const_t<T>>;

  T* data = nullptr;
#ifdef DRENCH_CHECK_BOUNDS
  std::int64_t count = 0;
#endif

  Entries() = default;
  /// From a plain array; an array of a subsystem (Field) goes through its own conversions, which keep its constness.
  template <class A>
  requires std::is_same_v<A, Owner> Entries(const A& a) : Entries(a.data(), a.extent(0)) {}
  KOKKOS_INLINE_FUNCTION Entries(T* first, [[maybe_unused]] std::size_t size) : data(first) {
#ifdef DRENCH_CHECK_BOUNDS
    count = static_cast<std::int64_t>(size);
#endif
  }
  /// What may be written may be read.
  template <class U>
  requires(std::is_same_v<const U, T> && !std::is_const_v<U>) KOKKOS_INLINE_FUNCTION Entries(const Entries<U>& o)
      : data(o.data) {
#ifdef DRENCH_CHECK_BOUNDS
    count = o.count;
#endif
  }
  KOKKOS_INLINE_FUNCTION T& operator()(std::int64_t i) const {
#ifdef DRENCH_CHECK_BOUNDS
    if (i < 0 || i >= count) Kokkos::abort("drench: an index is beyond its array");
#endif
    return data[i];
  }
  KOKKOS_INLINE_FUNCTION bool exist() const { return data != nullptr; }
};

/// A view of an array with its length, 16 bytes.
template <class T>
struct Slice {
  using Owner = Array<std::remove_const_t<T>>;

  T* data = nullptr;
  std::int64_t count = 0;

  Slice() = default;
  template <class A>
  requires std::is_same_v<A, Owner> Slice(const A& a) : Slice(a.data(), a.extent(0)) {}
  KOKKOS_INLINE_FUNCTION Slice(T* first, std::size_t size) : data(first), count(static_cast<std::int64_t>(size)) {}
  KOKKOS_INLINE_FUNCTION T& operator()(std::int64_t i) const {
#ifdef DRENCH_CHECK_BOUNDS
    if (i < 0 || i >= count) Kokkos::abort("drench: an index is beyond its array");
#endif
    return data[i];
  }
  KOKKOS_INLINE_FUNCTION std::size_t extent(int) const { return static_cast<std::size_t>(count); }
};

/// An array that a subsystem owns. A kernel sees it as Entries or Slice, read-only ones where its owner is const: what
/// a function writes to stands in its signature, and the compiler checks it.
template <class T>
class Field : public Array<T> {
 public:
  using Array<T>::Array;
  Field() = default;
  Field(Array<T>&& a) : Array<T>(std::move(a)) {}
  Field(Field&&) noexcept = default;
  Field& operator=(Field&&) noexcept = default;
  Field(const Field&) = delete;
  Field& operator=(const Field&) = delete;

  operator Entries<T>() { return {this->data(), this->extent(0)}; }
  operator Entries<const T>() const { return {this->data(), this->extent(0)}; }
  operator Slice<T>() { return {this->data(), this->extent(0)}; }
  operator Slice<const T>() const { return {this->data(), this->extent(0)}; }
  bool exists() const { return this->extent(0) > 0; }
};

/// Gives a field `n` entries, all 0, unless it has as many.
template <class T>
void allocate_zeros(Field<T>& a, const char* label, std::size_t n) {
  if (a.extent(0) == n) return;
  a = Field<T>();  // free before allocating
  a = Field<T>(std::string(label), n);
}
/// Makes room for `n` entries; contents are undefined after growth.
template <class T>
void make_room(Array<T>& a, const char* label, std::size_t n) {
  if (a.extent(0) >= n) return;
  a = Array<T>();  // free before allocating
  a = Array<T>(Kokkos::ViewAllocateWithoutInitializing(label), n);
}
/// The same with a quarter more, for what grows often. Has the array grown?
template <class T>
bool make_ample_room(Array<T>& a, const char* label, std::size_t n) {
  if (a.extent(0) >= n) return false;
  make_room(a, label, n + n / 4);
  return true;
}
/// Room for the one value of a view without extents; the first call makes it.
template <class One>
void make_room_for_one(One& a, const char* label) {
  if (a.data() == nullptr) a = One(Kokkos::ViewAllocateWithoutInitializing(label));
}

using Range = Kokkos::RangePolicy<ExecSpace, Kokkos::IndexType<Index>>;
/// Blocks of 128 threads on a GPU, so that also a cloth's nodes lie on all of its processors; on an H200 that made no
/// kernel measurably faster.
using LoopRange = Kokkos::RangePolicy<ExecSpace, Kokkos::IndexType<Index>, Kokkos::LaunchBounds<128, 1>>;
/// Teams of four warps on a GPU. That ranks, like a loop's indexes, lie along the lanes of warps is checked when the
/// backend starts (core/thread_mapping.hpp).
inline constexpr Index warp_size = 32, team_threads = 128;
using Teams = Kokkos::TeamPolicy<ExecSpace, Kokkos::LaunchBounds<team_threads, 1>>;
static_assert(team_threads % warp_size == 0);
#ifdef KOKKOS_ENABLE_CUDA
static_assert(std::is_same_v<ExecSpace, Kokkos::Cuda>, "a Kokkos with CUDA runs kernels there by default");
#endif
/// Scratch memory for a team on any GPU, bytes: of 48 KiB Kokkos keeps a double for each thread, and a few more.
constexpr std::size_t most_scratch(Index threads) {
  return 47 * 1024 - static_cast<std::size_t>(threads) * sizeof(double);
}

template <class T>
struct Vector3 {
  T x = 0, y = 0, z = 0;
  KOKKOS_INLINE_FUNCTION Vector3& operator+=(const Vector3& o) {
    x += o.x;
    y += o.y;
    z += o.z;
    return *this;
  }
  KOKKOS_INLINE_FUNCTION Vector3& operator-=(const Vector3& o) {
    x -= o.x;
    y -= o.y;
    z -= o.z;
    return *this;
  }
};
using Real3 = Vector3<Real>;
using Double3 = Vector3<double>;
/// A vector and a number in one load: what loops over neighbours read.
struct alignas(4 * sizeof(Real)) Real4 {
  Real x = 0, y = 0, z = 0, w = 0;
  Real4() = default;
  KOKKOS_INLINE_FUNCTION Real4(const Real3& v, Real number) : x(v.x), y(v.y), z(v.z), w(number) {}
  KOKKOS_INLINE_FUNCTION Real3 xyz() const { return {x, y, z}; }
};
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> operator+(Vector3<T> a, const std::type_identity_t<Vector3<T>>& b) {
  return a += b;
}
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> operator-(Vector3<T> a, const std::type_identity_t<Vector3<T>>& b) {
  return a -= b;
}
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> operator-(const Vector3<T>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> operator*(std::type_identity_t<T> s, const Vector3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
KOKKOS_INLINE_FUNCTION T dot(const Vector3<T>& a, const std::type_identity_t<Vector3<T>>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
/// a b + c, in one operation on a GPU. (The compiler is told not to make these by itself.)
template <class T>
KOKKOS_INLINE_FUNCTION T fused(std::type_identity_t<T> a, std::type_identity_t<T> b, T c) {
#ifdef __CUDA_ARCH__
  return ::fma(a, b, c);
#else
  return a * b + c;
#endif
}
/// a · b, r², and v + f r.
template <class T>
KOKKOS_INLINE_FUNCTION T fused_dot(const Vector3<T>& a, const std::type_identity_t<Vector3<T>>& b) {
  return fused(a.z, b.z, fused(a.y, b.y, a.x * b.x));
}
template <class T>
KOKKOS_INLINE_FUNCTION T fused_square(const Vector3<T>& r) {
  return fused_dot(r, r);
}
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> fused_sum(const Vector3<T>& v, std::type_identity_t<T> f,
                                            const std::type_identity_t<Vector3<T>>& r) {
  return {fused(f, r.x, v.x), fused(f, r.y, v.y), fused(f, r.z, v.z)};
}
/// The larger of two numbers, a if b is not one. A host's fmax is a call of its library.
template <class A, class B>
KOKKOS_INLINE_FUNCTION std::common_type_t<A, B> larger(A a, B b) {
#ifdef __CUDA_ARCH__
  return Kokkos::fmax(a, b);
#else
  return b > a ? b : a;
#endif
}
/// The smaller of them, likewise.
template <class A, class B>
KOKKOS_INLINE_FUNCTION std::common_type_t<A, B> smaller(A a, B b) {
#ifdef __CUDA_ARCH__
  return Kokkos::fmin(a, b);
#else
  return b < a ? b : a;
#endif
}
/// a/b; a GPU has an instruction for it, to 2 ulp for 2⁻¹²⁶ < |b| < 2¹²⁶, where an exact division calls a function.
template <class T>
KOKKOS_INLINE_FUNCTION T quotient(T a, T b) {
#ifdef __CUDA_ARCH__
  if constexpr (std::is_same_v<T, float>) return ::__fdividef(a, b);
#endif
  return a / b;
}
/// 1/√x; a GPU has an instruction for it, to 2 ulp, where root and division are exact and take several times as long.
template <class T>
KOKKOS_INLINE_FUNCTION T inverse_root(T x) {
#ifdef __CUDA_ARCH__
  return ::rsqrt(x);
#else
  return 1 / Kokkos::sqrt(x);
#endif
}
template <class T>
KOKKOS_INLINE_FUNCTION T norm(const Vector3<T>& a) {
  return Kokkos::sqrt(dot(a, a));
}
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> cross(const Vector3<T>& a, const std::type_identity_t<Vector3<T>>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
KOKKOS_INLINE_FUNCTION Double3 widen(const Real3& a) { return {double(a.x), double(a.y), double(a.z)}; }
KOKKOS_INLINE_FUNCTION Real3 narrow(const Double3& a) { return {Real(a.x), Real(a.y), Real(a.z)}; }
/// A vector of the device's precision in another one.
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> in_precision(const Real3& a) {
  return {T(a.x), T(a.y), T(a.z)};
}

/// How the device holds a host type: vectors and numbers in the backend's precision.
template <class T>
struct OnDevice {
  using type = T;
};
template <>
struct OnDevice<double> {
  using type = Real;
};
template <>
struct OnDevice<Vec3> {
  using type = Real3;
};

/// The current run's space with as many of a host's threads (core/workspace.cpp).
const ExecSpace& space_of(int threads);
/// Where the current run computes.
ExecSpace exec();
/// Copies, and waits until the current run's work is done. (Kokkos::deep_copy without a space waits for all runs.)
template <class To, class From>
void copy_now(To&& to, const From& from) {
  const ExecSpace space = exec();
  Kokkos::deep_copy(space, to, from);
  space.fence("drench::copy");
}
/// The range of a reduction or scan over n items.
inline Range range(Index n) {
  if constexpr (on_host) return Range(space_of(n > 1024 ? HostLoops::threads() : 1), 0, n);
  return Range(exec(), 0, n);
}

/// The values of an array on the host, once the current run's work is done.
template <class A>
auto on_host_now(const A& a) {
  const auto mirror = Kokkos::create_mirror_view(a);
  copy_now(mirror, a);
  return mirror;
}

/// Runs `body(i)` for i in [0, n) under a label that Kokkos Tools and profilers show, e.g. "drench::density::alpha".
template <class Body>
void parallel(const char* label, Index n, const Body& body) {
  if (n <= 0) return;
  if constexpr (on_host) {
    static thread_local LoopTime time;
    run_timed(
        time, n,
        [&] {
          std::uint64_t id = 0;
          Kokkos::Tools::beginParallelFor(label, Kokkos::Tools::Experimental::device_id(ExecSpace()), &id);
          for (Index i = 0; i < n; ++i) body(i);
          Kokkos::Tools::endParallelFor(id);
        },
        [&] {  // each thread takes pieces from all over the range, for what takes long lies side by side
          const Index threads = HostLoops::threads(), length = (n - 1) / (16 * threads) + 1;
          Kokkos::parallel_for(label, LoopRange(space_of(threads), 0, threads), [&, threads, length](const Index t) {
            for (Index first = t * length; first < n; first += threads * length) {
              const Index end = first + length < n ? first + length : n;
              for (Index i = first; i < end; ++i) body(i);
            }
          });
        });
  } else {
    Kokkos::parallel_for(label, LoopRange(exec(), 0, n), body);
  }
}

}  // namespace drench::kokkos_backend
