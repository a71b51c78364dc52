#pragma once
// Host vectors to device arrays and back, converting between double and Real.

#include <string>
#include <vector>

#include "core/types.hpp"

namespace drench::kokkos_backend {

inline Real3 to_real(const Vec3& a) { return {Real(a[0]), Real(a[1]), Real(a[2])}; }
inline Vec3 to_vec(const Real3& a) { return {double(a.x), double(a.y), double(a.z)}; }

/// A host value as a device array holds it: vectors and numbers in the backend's precision.
template <class T, class S>
T to_device_value(const S& value) {
  if constexpr (std::is_same_v<T, Real3>)
    return to_real(value);
  else
    return static_cast<T>(value);
}

/// Copies the values into the front of an array that is large enough.
template <class T, class S>
void copy_to_device(const Array<T>& a, const std::vector<S>& values) {
  if (values.empty()) return;
  const auto part = Kokkos::subview(a, Kokkos::make_pair(std::size_t(0), values.size()));
  const auto mirror = Kokkos::create_mirror_view(part);
  for (std::size_t i = 0; i < values.size(); ++i) mirror(i) = to_device_value<T>(values[i]);
  copy_now(part, mirror);
}

/// A device array of the host values.
template <class T, class S>
Array<T> to_device(const char* label, const std::vector<S>& values) {
  Array<T> a(Kokkos::ViewAllocateWithoutInitializing(label), values.size());
  copy_to_device(a, values);
  return a;
}

inline Array<Real3> to_device3(const char* label, const std::vector<Vec3>& values) {
  return to_device<Real3>(label, values);
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
  const auto mirror = Kokkos::create_mirror_view(part);
  copy_now(mirror, part);
  for (Index i = 0; i < n; ++i) {
    if constexpr (std::is_same_v<T, Real3>)
      out[static_cast<std::size_t>(i)] = to_vec(mirror(i));
    else
      out[static_cast<std::size_t>(i)] = static_cast<S>(mirror(i));
  }
  return out;
}

}  // namespace drench::kokkos_backend
