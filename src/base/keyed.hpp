#pragma once
// Values that move with time. docs/theory/keys.md has the formulas.

#include <type_traits>
#include <vector>

#include "base/types.hpp"

namespace drench {

/// Between two keys: straight; a monotone cubic (Fritsch & Carlson 1980); the value of the key before.
enum class Interpolation { linear, smooth, step };

/// A value at a time, s.
template <class T>
struct Key {
  double time = 0;  ///< s
  T value{};        ///< from then on, or at that time

  bool operator==(const Key&) const = default;
};

/// A number or a vector that is one value for all times, or is given by keys: the first holds before its time and the
/// last after. A plain value has no keys, and its integral is exactly value · (to − from).
template <class T>
class Keyed {
 public:
  /// A plain value.
  Keyed(const T& value = T{}) : plain_(value) {}  // NOLINT(google-explicit-constructor): a plain value stays one
  /// A plain vector.
  template <class Vector = T>  // a template of its own for clang 14, which instantiates others with the class
  requires std::is_same_v<Vector, Vec3> Keyed(double x, double y, double z) : plain_(Vector{x, y, z}) {}
  /// At least one key, their times rising. std::invalid_argument if they are not.
  Keyed(std::vector<Key<T>> keys, Interpolation interpolation);

  /// Is it no plain value?
  bool has_keys() const { return !keys_.empty(); }
  /// The value for all times; of one with keys, the first.
  const T& plain() const { return has_keys() ? keys_.front().value : plain_; }
  const std::vector<Key<T>>& keys() const { return keys_; }       ///< none of a plain value
  Interpolation interpolation() const { return interpolation_; }  ///< between its keys
  bool is_zero() const;                                           ///< at all times

  /// The value at a time, s.
  T at(double time) const;
  /// The rate of change; at a corner, that towards later times.
  T derivative(double time) const;
  /// From one time to another, in closed form.
  T integral(double from, double to) const;
  /// No value (length of a vector) between the two times is above it; exact where only one component changes.
  double largest(double from, double to) const;
  double largest() const;  ///< at all times
  /// The same of the derivative, over the whole of each stretch between keys that they touch; infinite across a step.
  double largest_derivative(double from, double to) const;
  double largest_derivative() const;  ///< at all times
  /// The same times with values `factor` times as large.
  Keyed scaled(double factor) const;

  bool operator==(const Keyed&) const = default;

 private:
  std::size_t key_before(double time) const;
  T integral_to(double time) const;

  T plain_{};
  std::vector<Key<T>> keys_;
  std::vector<T> slope_;  // of a smooth one, at each key
  std::vector<T> area_;   // from the first key to each
  Interpolation interpolation_ = Interpolation::linear;
};

extern template class Keyed<double>;
extern template class Keyed<Vec3>;

}  // namespace drench
