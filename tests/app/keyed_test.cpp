// Values that move with time: between keys, their derivative, their integral and their bounds.

#include "base/keyed.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace drench {
namespace {

constexpr Interpolation all[] = {Interpolation::linear, Interpolation::smooth, Interpolation::step};

/// Keys at uneven times that rise, fall, stand still and turn.
Keyed<double> wavy(Interpolation between) {
  return {{{0.5, 1}, {0.7, 4}, {1.9, 4.5}, {2, -3}, {2.5, -3}, {4, 0}, {4.1, 7}}, between};
}

/// Simpson's rule over stretches that do not cross a key.
double simpson(const Keyed<double>& k, double from, double to) {
  std::vector<double> ends{from};
  for (const Key<double>& key : k.keys())
    if (key.time > from && key.time < to) ends.push_back(key.time);
  ends.push_back(to);
  double sum = 0;
  for (std::size_t e = 1; e < ends.size(); ++e) {
    const double a = ends[e - 1], b = ends[e], tiny = 1e-13 * (b - a);  // a step has its jump at the key
    sum += (b - a) / 6 * (k.at(a + tiny) + 4 * k.at(0.5 * (a + b)) + k.at(b - tiny));
  }
  return sum;
}

}  // namespace

TEST(Keyed, APlainValueStaysWhatItIs) {
  const Keyed<double> plain = 3.0;
  EXPECT_FALSE(plain.has_keys());
  EXPECT_EQ(plain.at(-5), 3);
  EXPECT_EQ(plain.derivative(2), 0);
  EXPECT_EQ(plain.integral(0.1, 0.7), 3.0 * (0.7 - 0.1));
  EXPECT_EQ(plain.largest(), 3);
  EXPECT_EQ(plain.largest_derivative(), 0);
  EXPECT_TRUE(Keyed<Vec3>().is_zero());
  EXPECT_EQ((Keyed<Vec3>{1, 2, 3}), (Keyed<Vec3>(Vec3{1, 2, 3})));
  EXPECT_EQ((Keyed<Vec3>{1, 2, 3}.integral(1, 3)), (Vec3{2, 4, 6}));
}

TEST(Keyed, GoesThroughItsKeysAndStandsStillOutsideOfThem) {
  for (const Interpolation between : all) {
    const Keyed<double> k = wavy(between);
    for (const Key<double>& key : k.keys()) EXPECT_EQ(k.at(key.time), key.value);
    EXPECT_EQ(k.at(-1), 1);
    EXPECT_EQ(k.at(9), 7);
    EXPECT_EQ(k.derivative(0.4), 0);
    EXPECT_EQ(k.derivative(9), 0);
  }
}

TEST(Keyed, LinearIsStraightAndStepHolds) {
  EXPECT_DOUBLE_EQ(wavy(Interpolation::linear).at(0.6), 2.5);
  EXPECT_DOUBLE_EQ(wavy(Interpolation::linear).derivative(0.6), 15);
  EXPECT_EQ(wavy(Interpolation::step).at(0.69), 1);
  EXPECT_EQ(wavy(Interpolation::step).derivative(0.69), 0);
}

/// Fritsch & Carlson: no key is overshot, no turn is added, and the slope has no corner, also not at the ends.
TEST(Keyed, SmoothIsMonotoneBetweenKeysWithoutCorners) {
  const Keyed<double> k = wavy(Interpolation::smooth);
  const auto& keys = k.keys();
  for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
    const double h = keys[i + 1].time - keys[i].time, rise = keys[i + 1].value - keys[i].value;
    double before = keys[i].value;
    for (int s = 1; s <= 200; ++s) {
      const double now = k.at(keys[i].time + h * s / 200);
      EXPECT_GE((now - before) * (rise == 0 ? 1 : rise), -1e-12) << i << " " << s;
      EXPECT_TRUE(rise != 0 || now == before) << i << " " << s;
      before = now;
    }
  }
  for (const Key<double>& key : keys) {
    const double e = 1e-7;
    EXPECT_NEAR(k.derivative(key.time - e), k.derivative(key.time + e), 1e-3) << key.time;
  }
  EXPECT_NEAR(k.derivative(1.2), (k.at(1.2 + 1e-6) - k.at(1.2 - 1e-6)) / 2e-6, 1e-6);
}

/// A cubic's integral is exactly Simpson's; and the whole is the sum of parts, whatever their number.
TEST(Keyed, TheIntegralIsExactAndAddsUp) {
  for (const Interpolation between : all) {
    const Keyed<double> k = wavy(between);
    EXPECT_NEAR(k.integral(0, 5), simpson(k, 0, 5), 1e-11);
    EXPECT_NEAR(k.integral(0.6, 2.3), simpson(k, 0.6, 2.3), 1e-11);
    EXPECT_NEAR(k.integral(0.55, 0.65), simpson(k, 0.55, 0.65), 1e-12);
    EXPECT_NEAR(k.integral(-2, 0.25), 2.25, 1e-14);
    EXPECT_NEAR(k.integral(5, 6), 7, 1e-13);
    EXPECT_EQ(k.integral(1.3, 1.3), 0);
    double sum = 0;
    for (int i = 0; i < 1000; ++i) sum += k.integral(0.005 * i, 0.005 * (i + 1));
    EXPECT_NEAR(sum, k.integral(0, 5), 1e-11);
  }
  EXPECT_NEAR(wavy(Interpolation::linear).integral(0.5, 0.7), 0.2 * 2.5, 1e-15);
  EXPECT_NEAR(wavy(Interpolation::step).integral(0.5, 0.8), 0.2 * 1 + 0.1 * 4, 1e-15);
}

/// The bounds that the time step and the limits of a run are made of.
TEST(Keyed, NothingIsAboveItsBounds) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-2, 2), time(0.01, 0.5);
  for (int round = 0; round < 50; ++round) {
    std::vector<Key<Vec3>> keys;
    double t = 0;
    for (int i = 0; i < 6; ++i) keys.push_back({t += time(random), {value(random), value(random), value(random)}});
    for (const Interpolation between : all) {
      const Keyed<Vec3> k(keys, between);
      const double from = 0.3 * t, to = 0.8 * t;
      double most = 0, steepest = 0;
      std::vector<double> times;
      for (int i = 0; i <= 500; ++i) times.push_back(from + (to - from) * i / 500);
      for (const Key<Vec3>& key : keys)
        if (key.time > from && key.time < to) times.push_back(key.time);
      for (const double at : times) {
        const Vec3 v = k.at(at), d = k.derivative(at);
        most = std::max(most, std::hypot(v[0], v[1], v[2]));
        steepest = std::max(steepest, std::hypot(d[0], d[1], d[2]));
      }
      EXPECT_LE(most, k.largest(from, to) * (1 + 1e-12));
      EXPECT_LE(steepest, k.largest_derivative(from, to) * (1 + 1e-12));
      EXPECT_LE(k.largest(from, to), k.largest() * std::sqrt(3.0));
      if (between != Interpolation::smooth) {
        EXPECT_NEAR(k.largest(from, to), most, 1e-12);
      }
    }
  }
  EXPECT_TRUE(std::isinf(wavy(Interpolation::step).largest_derivative()));
}

TEST(Keyed, NeedsRisingTimes) {
  EXPECT_THROW(Keyed<double>(std::vector<Key<double>>{}, Interpolation::linear), std::invalid_argument);
  EXPECT_THROW(Keyed<double>({{1, 0}, {1, 2}}, Interpolation::linear), std::invalid_argument);
  const Keyed<double> one({{2, 5}}, Interpolation::smooth);
  EXPECT_EQ(one.at(1), 5);
  EXPECT_EQ(one.integral(0, 4), 20);
  EXPECT_EQ(one.scaled(2).at(9), 10);
}

}  // namespace drench
