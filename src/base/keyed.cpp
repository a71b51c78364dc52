#include "base/keyed.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace drench {
namespace {

/// The result of a function of numbers, component by component.
template <class F, class... Numbers>
auto each(F f, const Numbers&... numbers) {
  using T = std::common_type_t<Numbers...>;
  if constexpr (std::is_same_v<T, double>) {
    return f(numbers...);
  } else {
    T result{};
    for (std::size_t a = 0; a < result.size(); ++a) result[a] = f(numbers[a]...);
    return result;
  }
}

double length(double x) { return std::abs(x); }
double length(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }

/// A stretch between two keys: their values, slopes and distance in time.
struct Stretch {
  double first, last, slope, next_slope, time;

  double at(double s) const {
    return first + (last - first) * s * s * (3 - 2 * s) + time * s * (1 - s) * (slope * (1 - s) - next_slope * s);
  }
  double derivative(double s) const {
    return 6 * s * (1 - s) * (last - first) / time + slope * (1 - s) * (1 - 3 * s) + next_slope * s * (3 * s - 2);
  }
  double integral(double s) const {
    const double s2 = s * s;
    return time * (first * s + (last - first) * s2 * s * (1 - 0.5 * s) +
                   time * s2 * (slope * (0.5 - s * (2.0 / 3 - 0.25 * s)) - next_slope * s * (1.0 / 3 - 0.25 * s)));
  }
  /// Of a parabola: at its ends, or where it turns.
  double steepest() const {
    const double secant = (last - first) / time, square = 3 * (slope + next_slope - 2 * secant);
    double most = std::max(std::abs(slope), std::abs(next_slope));
    if (square == 0) return most;
    const double turns = (2 * slope + next_slope - 3 * secant) / square;
    return turns > 0 && turns < 1 ? std::max(most, std::abs(derivative(turns))) : most;
  }
};

/// Fritsch & Carlson: both slopes of a stretch shortened until the cubic between is monotone.
void keep_monotone(double secant, double& slope, double& next_slope) {
  if (secant == 0) {
    slope = next_slope = 0;
    return;
  }
  const double a = slope / secant, b = next_slope / secant, square = a * a + b * b;
  if (square <= 9) return;
  const double shorter = 3 / std::sqrt(square);
  slope = shorter * a * secant;
  next_slope = shorter * b * secant;
}

/// The slopes at the keys: the mean of both secants, 0 where they turn and at both ends, outside of which the value
/// stands still.
std::vector<double> smooth_slopes(const std::vector<double>& time, const std::vector<double>& value) {
  const std::size_t stretches = time.size() - 1;
  std::vector<double> secant(stretches), slope(time.size(), 0.0);
  for (std::size_t k = 0; k < stretches; ++k) secant[k] = (value[k + 1] - value[k]) / (time[k + 1] - time[k]);
  for (std::size_t k = 1; k < stretches; ++k)
    if (secant[k - 1] * secant[k] > 0) slope[k] = 0.5 * (secant[k - 1] + secant[k]);
  for (std::size_t k = 0; k < stretches; ++k) keep_monotone(secant[k], slope[k], slope[k + 1]);
  return slope;
}

template <class T>
std::vector<T> slopes_of(const std::vector<Key<T>>& keys) {
  std::vector<double> time(keys.size()), value(keys.size());
  std::vector<T> slopes(keys.size());
  const auto solve = [&](auto of, auto to) {
    for (std::size_t k = 0; k < keys.size(); ++k) {
      time[k] = keys[k].time;
      value[k] = of(keys[k].value);
    }
    const std::vector<double> found = smooth_slopes(time, value);
    for (std::size_t k = 0; k < keys.size(); ++k) to(slopes[k]) = found[k];
  };
  if constexpr (std::is_same_v<T, double>)
    solve([](double x) { return x; }, [](double& x) -> double& { return x; });
  else
    for (std::size_t a = 0; a < 3; ++a) solve([a](const T& v) { return v[a]; }, [a](T& v) -> double& { return v[a]; });
  return slopes;
}

}  // namespace

template <class T>
Keyed<T>::Keyed(std::vector<Key<T>> keys, Interpolation interpolation)
    : keys_(std::move(keys)), interpolation_(interpolation) {
  if (keys_.empty()) throw std::invalid_argument("there must be at least one keyframe");
  for (std::size_t k = 1; k < keys_.size(); ++k)
    if (!(keys_[k - 1].time < keys_[k].time)) throw std::invalid_argument("the times of the keyframes must increase");
  if (interpolation_ == Interpolation::smooth) slope_ = slopes_of(keys_);
  area_.assign(1, T{});
  for (std::size_t k = 1; k < keys_.size(); ++k)
    area_.push_back(integral_to(keys_[k].time));  // needs only the areas before
}

template <class T>
bool Keyed<T>::is_zero() const {
  if (!has_keys()) return plain_ == T{};
  return std::all_of(keys_.begin(), keys_.end(), [](const Key<T>& key) { return key.value == T{}; });
}

/// The number of the last key that is not after `time`, which is not before the first.
template <class T>
std::size_t Keyed<T>::key_before(double time) const {
  const auto after =
      std::upper_bound(keys_.begin(), keys_.end(), time, [](double t, const Key<T>& key) { return t < key.time; });
  return static_cast<std::size_t>(after - keys_.begin()) - 1;
}

template <class T>
T Keyed<T>::at(double time) const {
  if (!has_keys()) return plain_;
  if (time <= keys_.front().time) return keys_.front().value;
  if (time >= keys_.back().time) return keys_.back().value;
  const std::size_t k = key_before(time);
  const double h = keys_[k + 1].time - keys_[k].time, s = (time - keys_[k].time) / h;
  const T &first = keys_[k].value, &last = keys_[k + 1].value;
  switch (interpolation_) {
    case Interpolation::step:
      return first;
    case Interpolation::linear:
      return each([&](double a, double b) { return (1 - s) * a + s * b; }, first, last);
    case Interpolation::smooth:
      return each(
          [&](double a, double b, double m, double n) {
            return Stretch{a, b, m, n, h}.at(s);
          },
          first, last, slope_[k], slope_[k + 1]);
  }
  return first;
}

template <class T>
T Keyed<T>::derivative(double time) const {
  if (!has_keys() || time < keys_.front().time || time >= keys_.back().time) return T{};
  const std::size_t k = key_before(time);
  const double h = keys_[k + 1].time - keys_[k].time, s = (time - keys_[k].time) / h;
  const T &first = keys_[k].value, &last = keys_[k + 1].value;
  if (interpolation_ == Interpolation::step) return T{};
  if (interpolation_ == Interpolation::linear)
    return each([&](double a, double b) { return (b - a) / h; }, first, last);
  return each(
      [&](double a, double b, double m, double n) {
        return Stretch{a, b, m, n, h}.derivative(s);
      },
      first, last, slope_[k], slope_[k + 1]);
}

/// From the first key on.
template <class T>
T Keyed<T>::integral_to(double time) const {
  const Key<T>&front = keys_.front(), &back = keys_.back();
  if (time <= front.time) return each([&](double a) { return (time - front.time) * a; }, front.value);
  if (time >= back.time && area_.size() == keys_.size())
    return each([&](double sum, double a) { return sum + (time - back.time) * a; }, area_.back(), back.value);
  const std::size_t k = std::min(key_before(time), area_.size() - 1);
  const double h = k + 1 < keys_.size() ? keys_[k + 1].time - keys_[k].time : 1, since = time - keys_[k].time,
               s = since / h;
  const T &first = keys_[k].value, &last = keys_[std::min(k + 1, keys_.size() - 1)].value;
  const auto step = [&](double sum, double a) { return sum + since * a; };
  const auto linear = [&](double sum, double a, double b) { return sum + since * (a + 0.5 * s * (b - a)); };
  const auto smooth = [&](double sum, double a, double b, double m, double n) {
    return sum + Stretch{a, b, m, n, h}.integral(s);
  };
  if (interpolation_ == Interpolation::step) return each(step, area_[k], first);
  if (interpolation_ == Interpolation::linear) return each(linear, area_[k], first, last);
  return each(smooth, area_[k], first, last, slope_[k], slope_[k + 1]);
}

template <class T>
T Keyed<T>::integral(double from, double to) const {
  if (!has_keys()) return each([&](double a) { return a * (to - from); }, plain_);
  return each([](double a, double b) { return a - b; }, integral_to(to), integral_to(from));
}

template <class T>
double Keyed<T>::largest(double from, double to) const {
  if (!has_keys()) return length(plain_);
  // Each component is monotone between keys: its largest is at one of the two ends.
  const auto larger = [](double a, double b) { return std::max(std::abs(a), std::abs(b)); };
  T before = at(from);
  double most = length(before);
  const auto go_on = [&](double time) {
    const T next = at(time);
    most = std::max(most, interpolation_ == Interpolation::smooth ? length(each(larger, before, next)) : length(next));
    before = next;
  };
  for (const Key<T>& key : keys_)
    if (key.time > from && key.time < to) go_on(key.time);
  go_on(to);
  return most;
}

template <class T>
double Keyed<T>::largest() const {
  return has_keys() ? largest(keys_.front().time, keys_.back().time) : length(plain_);
}

template <class T>
double Keyed<T>::largest_derivative(double from, double to) const {
  double most = 0;
  for (std::size_t k = 0; k + 1 < keys_.size(); ++k) {
    if (keys_[k + 1].time <= from || keys_[k].time >= to) continue;
    const double h = keys_[k + 1].time - keys_[k].time;
    const T &first = keys_[k].value, &last = keys_[k + 1].value;
    if (interpolation_ == Interpolation::step && first != last) return std::numeric_limits<double>::infinity();
    const T steepest = interpolation_ == Interpolation::smooth
                           ? each(
                                 [&](double a, double b, double m, double n) {
                                   return Stretch{a, b, m, n, h}.steepest();
                                 },
                                 first, last, slope_[k], slope_[k + 1])
                           : each([&](double a, double b) { return (b - a) / h; }, first, last);
    most = std::max(most, length(steepest));
  }
  return most;
}

template <class T>
double Keyed<T>::largest_derivative() const {
  return largest_derivative(-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity());
}

template <class T>
Keyed<T> Keyed<T>::scaled(double factor) const {
  const auto times = [&](double a) { return factor * a; };
  if (!has_keys()) return Keyed(each(times, plain_));
  std::vector<Key<T>> keys = keys_;
  for (Key<T>& key : keys) key.value = each(times, key.value);
  return Keyed(std::move(keys), interpolation_);
}

template class Keyed<double>;
template class Keyed<Vec3>;

}  // namespace drench
