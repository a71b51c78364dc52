// Wet cloth and pools dry: against the exact courses of docs/theory/evaporation.md.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "quanta_sum.hpp"
#include "setup/air.hpp"
#include "validation.hpp"
#include "watched_cloth.hpp"

namespace drench::test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double pores = 0.6;  // kg/m²: (1 − Φ) τ ρ0 of the default cloth

std::string air(double rate) { return fmt::format("gravity: [0, 0, 0]\nair: {{evaporation_rate: {:.17g}}}", rate); }

Quanta total(const HostState& s) {
  return sum(s.fluid_mass) + sum(s.node_liquid) + s.drained + s.evaporated - s.supplied;
}

/// A sheet that is wet all over and dries alone.
struct Sheet {
  SceneRun run;
  Quanta start, lost = 0;

  Sheet(double step, double saturation, double critical, double rate) : Sheet(step, saturation, critical, air(rate)) {}
  Sheet(double step, double saturation, double critical, const std::string& in_air)
      : run(still_cloth(
            "{grid: {size: [0.2, 0.2], nodes: [11, 11]}}", step,
            fmt::format("diffusivity: 1.0e-4, max_saturation: 1, critical_saturation: {}", critical),
            fmt::format("    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: {}}}]\n",
                        saturation),
            in_air)),
        start(total(run.initial())) {}
  /// Mean saturation.
  double saturation() const { return kilograms(run.model(), sum(run.state().node_liquid)) / (pores * 0.2 * 0.2); }
  /// The largest error of it over `scale(expected)` until a time, looked at every `every` steps.
  template <class Expected, class Scale>
  double worst_until(double end, int every, const Expected& expected, const Scale& scale) {
    double worst = 0;
    for (int k = 1; run.time() < end - 1e-9; ++k) {
      run.step();
      if (k % every != 0) continue;
      const double exact = expected(run.time());
      worst = std::max(worst, std::fabs(saturation() - exact) / scale(exact));
      lost = std::max(lost, std::abs(total(run.state()) - start));
    }
    return worst;
  }
};

/// s(t) above and below the critical saturation, `fall` (1/s) above it.
double course(double start, double critical, double fall, double time) {
  const double until = std::max(0.0, start - critical) / fall;
  return time < until ? start - fall * time : std::min(start, critical) * std::exp(-fall * (time - until) / critical);
}

}  // namespace

TEST(drying, a_sheet_dries_at_a_constant_rate_then_slower) {
  constexpr double rate = 3e-3, fall = 2 * rate / pores;  // kg/(m² s), 1/s
  Quanta lost = 0;
  {
    Sheet sheet(0.1, 0.95, 0.3, rate);
    report({"a wet cloth above the critical saturation: its mass, largest error", "m = m₀ − 2 j A t",
            sheet.worst_until(
                60, 10, [&](double t) { return 0.95 - fall * t; }, [](double s) { return s; }),
            0.02});
    lost = std::max(lost, sheet.lost);
  }
  {
    Sheet sheet(0.1, 0.25, 0.3, rate);
    report({"a damp cloth below the critical saturation, to 5 % of its mass: largest error",
            "m = m₀ e^(−2 j A t/(s_c C))",
            sheet.worst_until(
                90, 10, [&](double t) { return 0.25 * std::exp(-fall * t / 0.3); }, [](double s) { return s; }),
            0.02});
    lost = std::max(lost, sheet.lost);
  }
  for (const double fast : {1.0, 20.0}) {
    const double step = 0.05 * fast;  // s
    Sheet sheet(step, 0.95, 0.3, fast * rate);
    report({fmt::format("from wet to nearly dry, the saturation falls by {} in a step: mass, largest error",
                        step * fast * fall),
            "constant, then falling rate",
            sheet.worst_until(
                std::floor(154 / fast / step) * step, 1, [&](double t) { return course(0.95, 0.3, fast * fall, t); },
                [](double s) { return s; }),
            0.02});
    lost = std::max(lost, sheet.lost);
  }
  report({"cloths that dry: mass budget error", "0", static_cast<double>(lost), 0, "quanta"});
}

namespace {

/// The time, s, in which cloth that cools dries from a saturation to a lower one; `fall`, 1/s, above the critical one.
double time_to(double start, double end, double critical, double fall, double cooling) {
  const double above = std::max(0.0, start - std::max(end, critical)) / fall;
  if (end >= critical) return above;
  const double x0 = std::min(start, critical) / critical, x = end / critical;
  return above + critical * (std::log(x0 / x) + cooling * (x0 - x)) / (fall * (1 + cooling));
}

/// T_w of a ventilated psychrometer, °C: e = e_s(T_w) − A p (T − T_w), A = 6.53e-4 (1 + 9.44e-4 T_w)/K (WMO-No. 8,
/// annex 4.B).
double psychrometer(double t, double humidity) {
  const auto pressure = [](double x) { return saturated_vapour(x) * 461.52 * (x + 273.15); };
  double low = -20, high = t;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    const double e = pressure(middle) - 6.53e-4 * (1 + 9.44e-4 * middle) * 101325 * (t - middle);
    (e < humidity * pressure(t) ? low : high) = middle;
  }
  return high;
}

}  // namespace

TEST(drying, wet_cloth_cools) {
  double worst = 0;
  for (const double t : {10.0, 20.0, 30.0, 40.0})
    for (const double humidity : {0.3, 0.5, 0.7, 0.9}) {
      Scene scene;
      scene.air = {true, humidity, t, 5, 0.01, {}, {}, true};
      worst = std::max(worst, std::fabs((t - wet_bulb(scene).temperature) / (t - psychrometer(t, humidity)) - 1));
    }
  report({"wet wick of 1 cm in air of 5 m/s, 10 to 40 °C, 30 to 90 %: how far it cools, largest error",
          "psychrometer, WMO-No. 8", worst, 0.06});
  // From wet to nearly dry, in air that is warm and dry: the rate falls to a third.
  Sheet sheet(1, 0.95, 0.4, "gravity: [0, 0, 0]\nair: {humidity: 0.2, temperature: 30, speed: 5, cooling: true}");
  const Model& m = sheet.run.model();
  const double fall = 2 * m.evaporation_flux / (1 + m.cooling) / pores;
  const double end = time_to(0.95, 0.02, 0.4, fall, m.cooling);
  double off = 0;
  while (sheet.run.time() < end) {
    sheet.run.step();
    off = std::max(off, std::fabs(sheet.run.time() / time_to(0.95, sheet.saturation(), 0.4, fall, m.cooling) - 1));
  }
  report({"cloth that cools: time to each saturation from 0.95 to 0.02, largest error", "balance of heat and vapour",
          off, 0.02});
  EXPECT_GT(m.cooling, 1);
  EXPECT_EQ(total(sheet.run.state()), sheet.start);
}

TEST(drying, the_air_decides_the_rate) {
  // Water at 20 °C in air of 50 %: e_s = 2339 Pa (Wagner and Pruß 2002), ρ_sat = 17.3 g/m³.
  report({"saturated vapour at 0, 20, 40 and 60 °C: largest error", "Wagner and Pruß 2002",
          std::max({std::fabs(saturated_vapour(0.01) / 0.0048546 - 1), std::fabs(saturated_vapour(20) / 0.017314 - 1),
                    std::fabs(saturated_vapour(40) / 0.051242 - 1), std::fabs(saturated_vapour(60) / 0.13043 - 1)}),
          0.01});
}

namespace {

/// A strip that is fed at its left end and dries all over: the saturation along it, once that does not change.
struct Strip {
  static constexpr double diffusivity = 1e-4, length = 0.12;  // m²/s, m
  int cells;
  SceneRun run;
  Quanta start, lost = 0;

  Strip(int cells_along, double step, double critical, double rate, bool vertical)
      : cells(cells_along),
        run(still_cloth(
            fmt::format("{{grid: {{size: [{}, {}], nodes: [{}, 2]}}}}", length, length / cells, cells + 1), step,
            fmt::format("diffusivity: {}, max_saturation: 1, critical_saturation: {}, capillary_height: 0.2",
                        diffusivity, critical),
            fmt::format("    hold_saturation: [{{box: {{min: [-1, -1, -1], max: [{}, 1, 1]}}, value: 1}}]\n",
                        -length / 2 + 1e-6),
            vertical ? with_gravity(rate) : air(rate))),
        start(total(run.initial())) {}
  static std::string with_gravity(double rate) {
    return fmt::format("gravity: [-9.81, 0, 0]\nair: {{evaporation_rate: {:.17g}}}", rate);
  }
  void until(double end) {
    while (run.time() < end - 1e-9) run.step();
    lost = std::abs(total(run.state()) - start);
  }
  /// By the distance from the fed end, m.
  std::vector<std::pair<double, double>> profile() const {
    const HostState s = run.state();
    const Model& m = run.model();
    std::vector<std::pair<double, double>> result;
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
      if (m.mesh.rest_position[n][2] < 0)
        result.emplace_back(m.mesh.rest_position[n][0] + length / 2,
                            kilograms(m, s.node_liquid[n]) / m.samples.node_capacity[n]);
    std::sort(result.begin(), result.end());
    return result;
  }
  template <class Exact>
  double worst(const Exact& exact) const {
    double largest = 0;
    for (const auto& [x, s] : profile()) largest = std::max(largest, std::fabs(s - exact(x)));
    return largest;
  }
  /// ∫ s dx, m.
  double wet() const {
    const auto p = profile();
    double sum = 0;
    for (std::size_t k = 1; k < p.size(); ++k)
      sum += 0.5 * (p[k].second + p[k - 1].second) * (p[k].first - p[k - 1].first);
    return sum;
  }
};

}  // namespace

TEST(drying, wicking_and_drying_hold_a_wet_length) {
  constexpr double wet = 0.08, fall = 2 * Strip::diffusivity / (wet * wet);  // m; 1/s, so that L = √(2 D/fall)
  Quanta lost = 0;
  for (const int cells : {24, 48}) {
    for (const double step : {0.05, 0.2}) {
      Strip strip(cells, step, 0, fall * pores / 2, false);
      strip.until(4 * wet * wet / Strip::diffusivity);
      const std::string which = fmt::format("a strip fed at one end, {} cells, steps of {} s: ", cells, step);
      report({which + "saturation along it, largest error", "s = (1 − x/L)², L = √(2 D/e)",
              strip.worst([&](double x) { return x < wet ? (1 - x / wet) * (1 - x / wet) : 0; }), 0.02});
      report({which + "wet length L from its mass", "L = √(2 D/e)", std::fabs(3 * strip.wet() / wet - 1), 0.02});
      lost = std::max(lost, strip.lost);
    }
  }
  {  // below the critical saturation everywhere: s'' = s/λ², no flux at the dry end
    Strip strip(48, 0.1, 1, fall * pores / 2, false);
    strip.until(2 * wet * wet / Strip::diffusivity);
    const double scale = std::sqrt(Strip::diffusivity / fall);
    report({"a strip below the critical saturation: saturation along it, largest error",
            "s = cosh((ℓ − x)/λ)/cosh(ℓ/λ)", strip.worst([&](double x) {
              return std::cosh((Strip::length - x) / scale) / std::cosh(Strip::length / scale);
            }),
            0.02});
    lost = std::max(lost, strip.lost);
  }
  {  // upwards: s'' D = e, flux −D (s' + 1/ℓ_c) = 0 at the front
    Strip strip(48, 0.1, 0, fall * pores / 2, true);
    strip.until(4 * wet * wet / Strip::diffusivity);
    // s = 1 + b x + e x²/(2 D) with s = 0 and s' = −1/ℓ_c at the front: e L²/(2 D) + L/ℓ_c = 1
    const double c = 0.2, a = fall / (2 * Strip::diffusivity),
                 front = (-1 / c + std::sqrt(1 / (c * c) + 4 * a)) / (2 * a);
    const double slope = -1 / c - 2 * a * front;
    report({"a strip that wicks up and dries: saturation along it, largest error", "D s″ = e, no flux at the front",
            strip.worst([&](double x) { return x < front ? 1 + slope * x + a * x * x : 0; }), 0.02});
    lost = std::max(lost, strip.lost);
  }
  report({"strips that wick and dry: mass budget error", "0", static_cast<double>(lost), 0, "quanta"});
}

namespace {

/// Water in a square tank, and how fast it loses vapour over what its plan loses by theory.
struct Pool {
  static constexpr double width = 0.16;  // m
  double rate;                           // kg/(m² s)
  SceneRun run;
  Quanta start;

  Pool(double spacing, double step, double flux)
      : rate(flux),
        run(fmt::format(R"(drench: 1
time: {{step: {0}, end: 100}}
air: {{evaporation_rate: {1}}}
fluid:
  spacing: {2}
  viscosity: 1.0e-5
  sources: [{{block: {{min: [0, 0, 0], max: [{3}, 0.06, {3}]}}}}]
bodies: [{{box: {{min: [0, 0, 0], max: [{3}, 0.2, {3}], inside: true}}}}]
)",
                        step, flux, spacing, width)),
        start(total(run.initial())) {}
  /// From one time to another.
  double rate_between(double from, double to) {
    while (run.time() < from - 1e-9) run.step();
    const Quanta before = run.state().evaporated;
    while (run.time() < to - 1e-9) run.step();
    return kilograms(run.model(), run.state().evaporated - before) / (rate * width * width * (to - from));
  }
};

}  // namespace

TEST(drying, a_pool_loses_by_its_surface) {
  Quanta lost = 0;
  for (const double d : {0.016, 0.01, 0.008}) {
    Pool pool(d, d / 5, 0.05);
    const double measured = pool.rate_between(0.5, 1.5);
    std::printf("pool, d = %g mm: %.4f of the plan's rate\n", d * 1e3, measured);
    report({fmt::format("a pool of {:.0f} spacings across: rate of evaporation over j times its plan", Pool::width / d),
            "1", std::fabs(measured - 1), 0.02});
    lost = std::max(lost, std::abs(total(pool.run.state()) - pool.start));
  }
  {
    Pool pool(0.01, 0.002, 10);
    const double measured = pool.rate_between(0.5, 2.5);
    std::printf("pool that loses two layers: %.4f of the plan's rate, %d particles of %d\n", measured,
                pool.run.state().fluid_count(), pool.run.initial().fluid_count());
    report({"a pool of 16 spacings across that loses two layers: rate of evaporation over j times its plan", "1",
            std::fabs(measured - 1), 0.02});
    lost = std::max(lost, std::abs(total(pool.run.state()) - pool.start));
  }
  report({"pools that dry: mass budget error", "0", static_cast<double>(lost), 0, "quanta"});
}

namespace {

/// Liquid in air without gravity: how fast it loses vapour over j times an area, m², that follows from its volume, m³.
template <class Area>
double rate_in_air(const std::string& source, double from, double to, const Area& area, Quanta& lost) {
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.0005, end: 100, mode: cfl}}
gravity: [0, 0, 0]
air: {{evaporation_rate: 0.05}}
fluid:
  spacing: 0.001
  viscosity: 2.0e-5
  {})",
                           source));
  const Quanta start = total(run.initial());
  while (run.time() < from - 1e-9) run.step(from - run.time());
  const HostState before = run.state();
  const double volume = kilograms(run.model(), sum(before.fluid_mass)) / run.model().rest_density;
  while (run.time() < to - 1e-9) run.step(to - run.time());
  const HostState after = run.state();
  lost = std::max(lost, std::abs(total(after) - start));
  return kilograms(run.model(), after.evaporated - before.evaporated) / (0.05 * area(volume) * (to - from));
}

}  // namespace

TEST(drying, drops_and_films_lose_by_their_surface) {
  Quanta lost = 0;
  const auto ball = [](double volume) { return std::cbrt(36 * pi * volume * volume); };
  for (const int n : {6, 10}) {
    const double edge = 1e-3 * n, radius = std::cbrt(3 / (4 * pi)) * n;
    const double measured = rate_in_air(
        fmt::format("surface_tension: 0.07\n  sources: [{{block: {{min: [0, 0, 0], max: [{0}, {0}, {0}]}}}}]", edge),
        0.3, 0.4, ball, lost);
    std::printf("drop, R = %.2f d: %.4f of the ball's rate\n", radius, measured);
    report({fmt::format("a drop of a radius of {:.1f} spacings: rate of evaporation over j times its surface", radius),
            "1", std::fabs(measured - 1), 0.05});
  }
  for (const int layers : {1, 2, 3}) {
    const double width = 0.04, thick = 1e-3 * layers, all = 2 * width * width + 4 * width * thick;
    const double measured = rate_in_air(
        fmt::format("sources: [{{block: {{min: [0, 0, 0], max: [{0}, {1}, {0}]}}}}]", width, thick), 0, 0.01,
        [&](double) { return all; }, lost);
    std::printf("film of %d layers: %.4f of its rate\n", layers, measured);
    report({fmt::format("a film of {} layers with air on both sides: rate of evaporation over j times its surface",
                        layers),
            "1", std::fabs(measured - 1), 0.1});
  }
  report({"drops and films that dry: mass budget error", "0", static_cast<double>(lost), 0, "quanta"});
}

}  // namespace drench::test
