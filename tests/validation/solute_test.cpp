// A solute that liquid carries through cloth: along a line against exact characteristics, through uptake, wicking and
// dripping, and into the ring of a stain.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "quanta_sum.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

/// The solute's accounts over a run: what was lost, and what was below 0, in quanta.
struct SoluteBooks {
  Quanta lost = 0;
  std::int64_t below_zero = 0;

  static Quanta total(const HostState& s) {
    return sum(s.fluid_solute) + sum(s.node_solute) + s.solute_drained + s.solute_deposited - s.solute_supplied;
  }
  void look(const HostState& s, Quanta at_start) {
    lost = std::max(lost, std::abs(total(s) - at_start));
    for (const auto* all : {&s.fluid_solute, &s.node_solute})
      for (const Quanta q : *all) below_zero += q < 0 ? 1 : 0;
  }
  void print(const std::string& runs) const {
    report({runs + ": solute budget error", "0", static_cast<double>(lost), 0, "quanta"});
    report({runs + ": particles and nodes with negative solute, all steps", "0", static_cast<double>(below_zero), 0});
  }
};

/// A still strip of one row of cells along x, from 0 on, at the saturation of `wet`, and dyed liquid held at its left
/// end.
struct Strip {
  static constexpr double diffusivity = 1e-4;  // m²/s
  int cells;
  double length;
  SceneRun run;
  SoluteBooks& books;
  Quanta at_start = 0;
  HostState state;

  template <class Wet>
  Strip(int count, double size, double step, const std::string& right, SoluteBooks& of, const Wet& wet)
      : cells(count),
        length(size),
        run(fmt::format(R"(drench: 1
time: {{step: {3}, end: 1000}}
gravity: [0, 0, 0]
cloth:
  - mesh: {{grid: {{size: [{0}, {1}], nodes: [{2}, 2]}}}}
    place: {{position: [{4}, 0, 0]}}
    dynamics: false
    hold_saturation:
      - {{box: {{min: [-1, -1, -1], max: [{5}, 1, 1]}}, value: 1, concentration: 0.02}}{6}
    porous: {{diffusivity: 1.0e-4}}
)",
                        size, size / count, count + 1, step, size / 2, 0.1 * size / count, right)),
        books(of),
        state(run.initial()) {
    for (std::size_t n = 0; n < state.node_liquid.size(); ++n) {
      if (place(n) < 0.1 * spacing()) continue;
      state.node_liquid[n] = std::llround(wet(place(n)) * run.model().samples.node_capacity[n] / run.model().quantum);
      state.node_solute[n] = 0;
    }
    run.restart(state);
    at_start = SoluteBooks::total(state);
  }
  double spacing() const { return length / cells; }
  double place(std::size_t n) const { return run.model().mesh.rest_position[n][0]; }
  void step() {
    run.step();
    state = run.state();
    books.look(state, at_start);
  }
  /// Concentration over that of the reservoir, by cells from the left end.
  std::vector<double> profile() const {
    std::vector<double> solute(static_cast<std::size_t>(cells) + 1, 0), liquid(solute);
    for (std::size_t n = 0; n < state.node_solute.size(); ++n) {
      const auto k = static_cast<std::size_t>(std::llround(place(n) / spacing()));
      solute[k] += static_cast<double>(state.node_solute[n]);
      liquid[k] += static_cast<double>(state.node_liquid[n]);
    }
    for (std::size_t k = 0; k < solute.size(); ++k) solute[k] /= liquid[k];
    return solute;
  }
};

constexpr double pi = std::numbers::pi;

/// Where a front of dye is that enters with the liquid: what lies behind it is what came in. In units of √(D t), for a
/// strip at the saturation `before` whose end is held at 1 (linear diffusion).
double front(double before) {
  const double came = (1 - before) * 2 / std::sqrt(pi);
  double low = 0, high = 10;
  for (int k = 0; k < 60; ++k) {
    const double x = 0.5 * (low + high);
    // ∫_0^x erfc(ξ/2) dξ = x erfc(x/2) + 2 (1 − e^(−x²/4))/√π
    const double behind =
        before * x + (1 - before) * (x * std::erfc(x / 2) + 2 * (1 - std::exp(-x * x / 4)) / std::sqrt(pi));
    (behind < came ? low : high) = x;
  }
  return low;
}

/// Where a falling profile passes ½, in cells.
double middle(const std::vector<double>& profile) {
  std::size_t k = 0;
  while (k + 1 < profile.size() && profile[k + 1] > 0.5) ++k;
  return static_cast<double>(k) + (profile[k] - 0.5) / (profile[k] - profile[k + 1]);
}

}  // namespace

TEST(solute, a_front_of_dye_goes_as_far_as_the_liquid_that_brings_it) {
  constexpr double before = 0.4, time = 4;
  const double scale = std::sqrt(Strip::diffusivity * time), exact = front(before) * scale;
  SoluteBooks books;
  std::vector<double> position, profile_error;  // the second over that of donor cells
  for (const int cells : {8, 16, 32, 64}) {
    const double h = exact / cells;
    const int along = static_cast<int>(std::ceil(8 * scale / h));
    constexpr int steps = 80;
    Strip strip(along, along * h, time / steps, "", books, [&](double) { return before; });
    for (int k = 0; k < steps; ++k) strip.step();
    const std::vector<double> profile = strip.profile();
    position.push_back(std::fabs(middle(profile) * h / exact - 1));
    double off = 0;
    for (std::size_t k = 0; k < profile.size(); ++k) {
      const double left = std::max(0.0, (double(k) - 0.5) * h), right = (double(k) + 0.5) * h;
      const double expected = std::clamp((exact - left) / (right - left), 0.0, 1.0);
      off += std::fabs(profile[k] - expected) * (right - left);
    }
    // A step that donor cells have spread is normal with the variance h x. A grid's nodes hold a third and two thirds
    // of a row's cell in turn: 10/9 of that.
    profile_error.push_back(off / std::sqrt(2 / pi * 10 / 9 * h * exact));
    std::printf("front over %d cells: position %.4f, profile %.4f, over donor cells %.4f\n", cells, position.back(),
                off / exact, profile_error.back());
  }
  const double order = std::log2(position.front() / position.back()) / static_cast<double>(position.size() - 1);
  const std::size_t last = profile_error.size() - 1;  // the rest goes with √h
  const double fine = (std::sqrt(2) * profile_error[last] - profile_error[last - 1]) / (std::sqrt(2) - 1);
  const std::string what = "front of dye in a wet strip that absorbs more, 64 cells behind it: ";
  report({what + "position of half the concentration, − 1", "the liquid that came in lies behind it", position.back(),
          0.02});
  report({what + "0.9 minus the order of its position", "order ≥ 0.9", 0.9 - order, 0});
  report({what + "mean error of its profile over theory, on ever finer meshes, − 1", "donor cells: √(h x)",
          std::fabs(fine - 1), 0.02});
  books.print("fronts of dye");
}

TEST(solute, steady_wicking_carries_it_along_characteristics) {
  // Between a saturation of 1 and one of ½ liquid flows at a constant rate and speeds up as there is less of it.
  constexpr double length = 0.1, drop = 0.5, station = 0.75 * length;
  const double rate = Strip::diffusivity * drop / length;  // m/s: flux over what the pores hold
  const double arrival = (station - drop * station * station / (2 * length)) / rate;
  SoluteBooks books;
  std::vector<double> late;
  double spread = 0;
  for (const int cells : {16, 32, 64}) {
    const double h = length / cells, dt = 0.5;
    Strip strip(
        cells, length, dt,
        fmt::format("\n      - {{box: {{min: [{}, -1, -1], max: [1, 1, 1]}}, value: {}}}", length - 0.1 * h, 1 - drop),
        books, [&](double x) { return 1 - drop * x / length; });
    const auto at = static_cast<std::size_t>(cells * 3 / 4);
    double mean = 0, square = 0, last = 0;  // s, s²: of the time at which dye comes to the station
    for (int k = 0; k < 2.5 * arrival / dt; ++k) {
      strip.step();
      const double now = strip.profile()[at], t = (k + 0.5) * dt;
      mean += t * (now - last);
      square += t * t * (now - last);
      last = now;
    }
    EXPECT_NEAR(last, 1, 1e-3);
    mean /= last, square /= last;
    double tanks = 0;  // s²: each node is a tank that is stirred, in two rows of them
    double row = 0;    // kg: held by a cell of one
    for (const double c : strip.run.model().samples.node_capacity) row += c / (2 * cells);
    for (std::size_t n = 0; n < strip.state.node_liquid.size(); ++n) {
      const double x = strip.place(n),
                   stay = (1 - drop * x / length) * strip.run.model().samples.node_capacity[n] / row * h / rate;
      if (x > 0.5 * h && x < station + 0.5 * h) tanks += stay * stay / 2;
    }
    late.push_back(std::fabs(mean / arrival - 1));
    spread = std::fabs(std::sqrt((square - mean * mean) / tanks) - 1);
    std::printf("steady flow over %d cells: arrives after %.3f s of %.3f, spread %.3f s, of stirred tanks %.3f\n",
                cells, mean, arrival, std::sqrt(square - mean * mean), std::sqrt(tanks));
  }
  const std::string what = "dye in a strip that liquid flows through, 64 cells: ";
  report({what + "mean time to three quarters of its length, − 1", "characteristics", late.back(), 0.02});
  report(
      {what + "0.9 minus the order of that time", "order ≥ 0.9", 0.9 - std::log2(late.front() / late.back()) / 2, 0});
  report({what + "spread of the times over that of nodes as stirred tanks, − 1", "√Σ τ²", spread, 0.02});
  books.print("dye in a strip that liquid flows through");
}

TEST(solute, what_is_uniform_stays_uniform) {
  // Half a cubic centimetre on an overfull sheet, which drips. The unit is another jet's, which never flows.
  SceneRun run(R"(drench: 1
time: {step: 0.001, end: 10, mode: cfl}
domain: {min: [-0.05, -0.03, -0.05], max: [0.05, 0.05, 0.05]}
fluid:
  spacing: 0.001
  viscosity: 1.0e-5
  sources:
    - block: {min: [-0.005, 0.0005, -0.005], max: [0.005, 0.0055, 0.005], concentration: 0.01}
    - jet: {center: [0, 0.04, 0], radius: 0.002, velocity: [0, -1, 0], start: 1000, concentration: 0.03}
cloth:
  - mesh: {grid: {size: [0.02, 0.02], nodes: [21, 21]}}
    dynamics: false
    thickness: 0.0007
    initial_saturation: [{box: {min: [-1, -1, 0], max: [1, 1, 1]}, value: 1.18, concentration: 0.01}]
    porous: {uptake_velocity: 0.02, diffusivity: 5.0e-4, emission_velocity: 1}
)");
  SoluteBooks books;
  const Quanta at_start = SoluteBooks::total(run.initial());
  double apart = 0;  // quanta
  bool dripped = false;
  HostState s;
  while (run.time() < 0.3) {
    run.step();
    s = run.state();
    books.look(s, at_start);
    const auto look = [&](const std::vector<Quanta>& solute, const std::vector<Quanta>& liquid) {
      for (std::size_t k = 0; k < solute.size(); ++k)
        apart = std::max(apart, std::fabs(static_cast<double>(solute[k]) - static_cast<double>(liquid[k]) / 3));
    };
    look(s.fluid_solute, s.fluid_mass);
    look(s.node_solute, s.node_liquid);
    for (const auto o : s.fluid_origin) dripped = dripped || o == static_cast<std::uint8_t>(Origin::cloth);
  }
  EXPECT_TRUE(dripped);
  EXPECT_GT(sum(s.node_liquid), 0);
  std::printf("uniform: %.0f quanta apart, drained %.3g, %d particles\n", apart, double(s.drained),
              int(s.fluid_count()));
  const std::string what = "dyed water that is absorbed, spreads and drips: ";
  report({what + "deviation from uniform concentration, over a particle's solute", "0, to rounding",
          apart / static_cast<double>(quanta_per_particle / 3), 1e-5});
  books.print("dyed water that is absorbed, spreads and drips");
}

namespace {

/// A sheet of 6 cm that dries on both sides at a given rate; `fed`: a square of 8 mm in its middle is held full of dyed
/// liquid.
struct DryingSheet {
  static constexpr double thickness = 0.001, solid = 0.4, diffusivity = 2.25e-6, exponent = 2, critical = 0.05;
  static constexpr double rate = 2e-3;                            // kg/(m² s), of both sides
  static constexpr double load = (1 - solid) * thickness * 1000;  // kg/m² at saturation 1
  static constexpr double step_length = 1;                        // s
  SceneRun run;
  HostState state;

  explicit DryingSheet(bool fed)
      : run(fmt::format(R"(drench: 1
time: {{step: {}, end: 10000}}
gravity: [0, 0, 0]
air: {{evaporation_rate: {}}}
cloth:
  - mesh: {{grid: {{size: [0.06, 0.06], nodes: [61, 61]}}}}
    dynamics: false
    thickness: {}
    {}: [{{box: {{min: [-0.00401, -1, -0.00401], max: [0.00401, 1, 0.00401]}}, value: 1, concentration: 0.01}}]
    porous: {{solid_fraction: {}, diffusivity: {}, diffusion_exponent: {}, max_saturation: 1, critical_saturation: {}}}
)",
                        step_length, rate / 2, thickness, fed ? "hold_saturation" : "initial_saturation", solid,
                        diffusivity, exponent, critical)),
        state(run.initial()) {}
  double capacity(std::size_t n) const { return run.model().samples.node_capacity[n]; }
  double area(std::size_t n) const { return capacity(n) / load; }
  void step() {
    run.step();
    state = run.state();
  }
  /// Of the circle as large as what is wetter than a fiftieth, m.
  double radius() const {
    double wet = 0;
    for (std::size_t n = 0; n < state.node_liquid.size(); ++n)
      if (kilograms(run.model(), state.node_liquid[n]) > 0.02 * capacity(n)) wet += area(n);
    return std::sqrt(wet / pi);
  }
  /// Solute per area by distance from the middle, kg/m², in rings of a millimetre.
  std::vector<double> stain() const {
    std::vector<double> mass(30, 0), on(30, 0);
    for (std::size_t n = 0; n < state.node_solute.size(); ++n) {
      const Vec3& x = run.model().mesh.rest_position[n];
      const auto k = static_cast<std::size_t>(std::hypot(x[0], x[2]) / 0.001);
      if (k >= mass.size()) continue;
      mass[k] += static_cast<double>(state.node_solute[n]) * run.model().solute_quantum();
      on[k] += area(n);
    }
    for (std::size_t k = 0; k < mass.size(); ++k) mass[k] /= on[k];
    return mass;
  }
  /// R of Eq. 9 of docs/theory/solute.md for a feed that is full up to the radius a.
  static double steady_radius(double a) {
    double low = a, high = 10 * a;
    for (int k = 0; k < 60; ++k) {
      const double r = 0.5 * (low + high),
                   rise = rate / (2 * load * diffusivity) * (r * r * std::log(r / a) - (r * r - a * a) / 2);
      (rise < 1 / (exponent + 1) ? low : high) = r;
    }
    return low;
  }
};

}  // namespace

TEST(solute, the_stain_of_a_patch_that_is_fed_and_dries_has_a_ring) {
  // Fed for ten minutes, in which its liquid dries four times over; then it dries out.
  DryingSheet fed(true), left_alone(false);
  SoluteBooks books;
  const Quanta at_start = SoluteBooks::total(fed.state);
  for (int k = 0; k < 600; ++k) {
    fed.step();
    books.look(fed.state, at_start);
  }
  const double expected =
      DryingSheet::steady_radius(0.5902 * 0.008);  // a square is to the logarithm of (9) as a circle of this radius
  const double radius = fed.radius();
  HostState s = left_alone.state;
  s.node_liquid = fed.state.node_liquid;
  s.node_buffered = fed.state.node_buffered;
  s.node_solute = fed.state.node_solute;
  left_alone.run.restart(s);
  const Quanta all = SoluteBooks::total(s);
  int steps = 0;
  do {
    left_alone.step();
    books.look(left_alone.state, all);
  } while (++steps < 4000 && sum(left_alone.state.node_liquid) > 0);
  const std::vector<double> stain = left_alone.stain();
  const auto rim = std::max_element(stain.begin() + 8, stain.end());
  const double place = (static_cast<double>(rim - stain.begin()) + 0.5) * 0.001;
  double middle = 0;
  for (std::size_t k = 7; k < 12; ++k) middle += stain[k] / 5;
  for (std::size_t k = 0; k < stain.size(); ++k) std::printf("%zu mm: %.4g g/m²\n", k, 1000 * stain[k]);
  std::printf("radius %.4g m, of theory %.4g; ring at %.4g m, over the middle %.3g; dry after %.0f s more\n", radius,
              expected, place, *rim / middle, steps * DryingSheet::step_length);
  const std::string what = "patch that is fed with dye in its middle and dries: ";
  report({what + "radius when it is steady, over theory − 1", "feed = drying", std::fabs(radius / expected - 1), 0.05});
  report({what + "solute in the middle of the dry stain over that at its rim", "a ring: below 1", middle / *rim, 0.5});
  report({what + "position of the ring over the steady radius, − 1", "the rim", std::fabs(place / expected - 1), 0.1});
  report({what + "liquid left", "0", static_cast<double>(sum(left_alone.state.node_liquid)), 0, "quanta"});
  books.print("stain with a ring");
}

}  // namespace drench::test
