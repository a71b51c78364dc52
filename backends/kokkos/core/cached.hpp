#pragma once
// Derived data that knows what it was made from.

#include <cstdint>

namespace drench::kokkos_backend {

/// Counts the changes of something that other data is derived from. It never goes back.
class Version {
 public:
  Version() = default;
  /// The version of what does not exist.
  static constexpr Version none() { return Version(0); }
  void advance() { ++count_; }
  /// Changes whenever one of the two does.
  friend Version operator+(Version a, Version b) { return Version(a.count_ + b.count_); }
  bool operator==(const Version&) const = default;

 private:
  explicit constexpr Version(std::uint64_t count) : count_(count) {}
  std::uint64_t count_ = 1;
};

/// A T with the version of what it was made from; at first of nothing.
template <class T>
struct Cached : T {
  using T::T;

  bool is_of(Version source) const { return source_ == source; }
  void set_made_from(Version source) { source_ = source; }

 private:
  Version source_ = Version::none();
};

}  // namespace drench::kokkos_backend
