#pragma once
// Host vectors to device arrays and back, converting between double and Real.

#include <string>
#include <vector>

#include "device.hpp"

namespace drench::kokkos_backend {

inline Real3 to_real(const Vec3& a) { return {Real(a[0]), Real(a[1]), Real(a[2])}; }
inline Vec3 to_vec(const Real3& a) { return {double(a.x), double(a.y), double(a.z)}; }

/// A device array of the host values, converted by static_cast.
template <class T, class S>
Array<T> to_device(const char* label, const std::vector<S>& values) {
  Array<T> a(Kokkos::ViewAllocateWithoutInitializing(label), values.size());
  const auto mirror = Kokkos::create_mirror_view(a);
  for (std::size_t i = 0; i < values.size(); ++i) mirror(i) = static_cast<T>(values[i]);
  Kokkos::deep_copy(a, mirror);
  return a;
}

inline Array<Real3> to_device3(const char* label, const std::vector<Vec3>& values) {
  Array<Real3> a(Kokkos::ViewAllocateWithoutInitializing(label), values.size());
  const auto mirror = Kokkos::create_mirror_view(a);
  for (std::size_t i = 0; i < values.size(); ++i) mirror(i) = to_real(values[i]);
  Kokkos::deep_copy(a, mirror);
  return a;
}

/// std::array rows, one after the other.
template <class T, std::size_t N>
std::vector<T> flat(const std::vector<std::array<T, N>>& rows) {
  std::vector<T> out;
  out.reserve(rows.size() * N);
  for (const auto& row : rows) out.insert(out.end(), row.begin(), row.end());
  return out;
}

/// The first `n` entries of a device array.
template <class S, class T>
std::vector<S> to_host(const Array<T>& a, Index n) {
  std::vector<S> out(static_cast<std::size_t>(n), S{});
  if (n == 0 || a.extent(0) == 0) return out;
  const auto part = Kokkos::subview(a, Kokkos::make_pair(Index(0), n));
  const auto mirror = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), part);
  for (Index i = 0; i < n; ++i) {
    if constexpr (std::is_same_v<T, Real3>)
      out[static_cast<std::size_t>(i)] = to_vec(mirror(i));
    else
      out[static_cast<std::size_t>(i)] = static_cast<S>(mirror(i));
  }
  return out;
}

/// The places of `id`'s values in ascending order.
std::vector<Index> by_id(const std::vector<std::int64_t>& id);

}  // namespace drench::kokkos_backend
