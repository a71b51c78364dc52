// Liquid that spreads within the fabric: AATCC TM197, TM198, TM79, ISO 9073-14.

#include <algorithm>
#include <cmath>
#include <map>

#include "laboratory/tests.hpp"
#include "laboratory/trial.hpp"

namespace drench {
namespace {

constexpr double wet_above = 0.1;  // saturation from which the eye sees fabric darken

// ---- AATCC TM197

/// How high a hanging strip is wet, m above `water`: the mean saturation of a row of nodes falls to `wet_above` there.
/// Below the first row above the water it is the part of `wet_above` that this row has reached, because the row below
/// is held full, whether or not the fabric wicks.
double wet_height(const std::vector<Vec3>& position, const std::vector<double>& saturation, double water) {
  std::map<long, std::pair<double, double>> rows;  // by height in µm: sum of saturations, nodes
  for (std::size_t n = 0; n < position.size(); ++n) {
    auto& [sum, count] = rows[std::lround(position[n][1] * 1e6)];
    sum += saturation[n];
    count += 1;
  }
  double below_at = water, below = 1;
  for (const auto& [height, sums] : rows) {
    const double s = sums.first / sums.second, y = static_cast<double>(height) * 1e-6;
    if (y <= water) {
      below_at = y, below = s;
      continue;
    }
    if (s < wet_above && below_at <= water) return std::max(0.0, below_at + (y - below_at) * s / wet_above - water);
    if (s < wet_above)
      return std::max(0.0, below_at + (y - below_at) * (below - wet_above) / std::max(1e-12, below - s) - water);
    below_at = y, below = s;
  }
  return below_at - water;
}

void vertical_wicking(Trial& trial) {
  constexpr double width = 0.025, length = 0.165, immersed = 0.005, mark = 0.02;  // m
  constexpr int cells = 82;                                                       // along the strip: 2 mm
  const double cell = length / cells, level = immersed + 0.5 * cell * trial.scatter(0);
  const bool wicks = trial.wicks();
  const std::string held = fmt::format(
      "    hold_saturation: [{{box: {{min: [-1, -1, -1], max: [1, {:.6g}, 1]}}, value: 1}}]  # water\n", level);
  auto run = trial.open(fmt::format(
      "drench: 1\n"
      "time: {{step: 0.5, end: 600}}  # AATCC TM197 B: 2 min and 10 min\n"
      "output: {{every: 10, fabric: true, wet_above: {:g}}}\n"
      "{}",
      wet_above,
      trial.specimen(fmt::format("{{grid: {{size: [{}, {}], nodes: [3, {}]}}}}", width, length, cells + 1),
                     fmt::format("    place: {{position: [0, {}, 0], rotate: {{axis: [1, 0, 0], degrees: 90}}}}\n{}"
                                 "    dynamics: false\n{}",
                                 length / 2, trial.warp_along_length(), wicks ? held : ""),
                     trial.porous_without_film())));
  // The upper end of what is held at saturation 1 is where the height begins.
  double water = 0;
  const HostState start = run->state();
  for (const Vec3& x : start.node_position)
    if (x[1] <= level) water = std::max(water, x[1]);
  const std::string name = trial.along_warp() ? "warp" : "weft";
  std::vector<double> times, heights;
  double absorbed = 0;
  const auto look = [&](const HostState& s) {
    times.push_back(run->time());
    heights.push_back(wet_height(s.node_position, run->saturation(s), water));
    absorbed = cloth_mass(*run, s);
    trial.row({times.back(), 1e3 * heights.back(), 1e3 * absorbed});
    return true;
  };
  const double end = run->scene().time.end;
  if (wicks) {
    watch_run(*run, std::min(end, 60.0), 1, look);
  } else {
    look(run->state());
    trial.note(trial.material().diffusivity > 0
                   ? "the fabric repels water (breakthrough_pressure), so that it does not wick"
                   : "the fabric has no diffusivity, so that it does not wick");
  }
  if (wicks && end > 60) {
    double next = 60;
    while (next < end * (1 - 1e-9)) {
      next = std::min(end, next + 10);
      run->run_until(next);
      look(run->state());
    }
  }
  const auto height_at = [&](double time) {
    for (std::size_t i = 1; i < times.size(); ++i)
      if (times[i] >= time * (1 - 1e-9))
        return heights[i - 1] + (heights[i] - heights[i - 1]) * (time - times[i - 1]) / (times[i] - times[i - 1]);
    return heights.back();
  };
  for (const double minutes : {2.0, 10.0, 30.0}) {
    if (end < 60 * minutes * (1 - 1e-9)) continue;
    const double h = 1e3 * height_at(60 * minutes);
    trial.number(fmt::format("height_{:g}_min_{}", minutes, name),
                 fmt::format("wicking height after {:g} min, {}", minutes, name), "mm", h);
    trial.number(fmt::format("rate_{:g}_min_{}", minutes, name),
                 fmt::format("wicking rate over {:g} min, {}", minutes, name), "mm/s", h / (60 * minutes));
  }
  for (std::size_t i = 1; i < heights.size(); ++i)
    if (heights[i] >= mark) {
      const double time = times[i - 1] + (times[i] - times[i - 1]) * (mark - heights[i - 1]) /
                                             std::max(1e-12, heights[i] - heights[i - 1]);
      trial.number("time_20_mm_" + name, "time to 20 mm, " + name, "s", time);
      break;
    }
  if (end < 120 * (1 - 1e-9)) trial.note(fmt::format("heights are reported from 2 min on; time.end is {:g} s", end));
  if (heights.back() < mark) trial.note("the water does not reach 20 mm");
  if (heights.back() > length - water - cell)
    trial.note(
        fmt::format("the water reaches the upper end of the strip, {:.3g} mm above its level: rates are lower "
                    "bounds from then on",
                    1e3 * (length - water)));
  trial.number("absorbed_" + name, "absorbed water at the end, " + name, "g", 1e3 * absorbed);
}

// ---- AATCC TM198

/// The extents of what is wet of a flat sheet along x and z, m.
std::pair<double, double> wet_extents(const HostState& s, const std::vector<double>& saturation,
                                      const std::vector<std::array<Index, 3>>& triangles) {
  double low[2]{1e9, 1e9}, high[2]{-1e9, -1e9};
  const auto take = [&](double x, double z) {
    low[0] = std::min(low[0], x), high[0] = std::max(high[0], x);
    low[1] = std::min(low[1], z), high[1] = std::max(high[1], z);
  };
  for (const auto& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t a = at(t[k]), b = at(t[(k + 1) % 3]);
      const Vec3 &xa = s.node_position[a], &xb = s.node_position[b];
      if (saturation[a] >= wet_above) take(xa[0], xa[2]);
      if ((saturation[a] >= wet_above) == (saturation[b] >= wet_above)) continue;
      const double part = (wet_above - saturation[a]) / (saturation[b] - saturation[a]);
      take(xa[0] + part * (xb[0] - xa[0]), xa[2] + part * (xb[2] - xa[2]));
    }
  if (high[0] < low[0]) return {0, 0};
  return {high[0] - low[0], high[1] - low[1]};
}

/// Hands the liquid in the cloth of a run, and where its nodes are on their curves, to another one that begins with the
/// same cloth.
void hand_over(const Simulation& from, Simulation& to) {
  const HostState last = from.state();
  const std::vector<double> saturation = from.saturation(last), capacity = to.node_capacity();
  HostState state = to.state();
  for (std::size_t n = 0; n < saturation.size(); ++n)
    state.node_liquid[n] = std::llround(saturation[n] * capacity[n] / to.quantum());
  if (!state.node_scanning.empty()) {
    std::copy(last.node_scanning.begin(), last.node_scanning.end(), state.node_scanning.begin());
    std::copy(last.node_extreme.begin(), last.node_extreme.end(), state.node_extreme.begin());
  }
  to.set_state(state);
}

/// The radius up to which a volume that spreads in isotropic fabric from a point has a saturation above `wet_above`, by
/// Barenblatt's solution of ∂s/∂t = D ∇·(sⁿ ∇s); 0 where it does not apply.
double spread_radius(const Trial& trial, double volume, double time) {
  const MaterialScene& m = trial.material();
  const double n = m.exponent();
  if (!(n > 0) || m.weft_diffusivity || m.retention_exponent != 1 || m.breakthrough_pressure > 0 ||
      m.flows_by_suction() || !(time > 0))
    return 0;
  const double filled = volume * water_density / trial.capacity();  // m² of full fabric
  const double radius =
      std::pow(4 * (n + 1) / n * m.diffusivity * time * std::pow(filled * (n + 1) / (n * pi), n), 1 / (2 * n + 2));
  const double centre = filled * (n + 1) / (n * pi * radius * radius);
  if (!(centre < 1 && centre > wet_above)) return 0;
  return radius * std::sqrt(1 - std::pow(wet_above / centre, n));
}

void horizontal_wicking(Trial& trial) {
  constexpr double size = 0.2, circle = 0.1, volume = 1e-6, pouring = 5, spacing = 0.003;  // m, m, m³, s, m
  constexpr double radius = 0.0015, height = 0.01;                                         // m, of the burette's tip
  constexpr double given_up = 5;                                                           // s after pouring
  constexpr int nodes = 49;
  const double cell = size / (nodes - 1), x = 0.5 * cell * trial.scatter(0), z = 0.5 * cell * trial.scatter(1);
  const auto scene = [&](bool pours) {
    const std::string water = fmt::format(
        "fluid:  # 1 mL from 10 mm above\n"
        "  spacing: {}\n  viscosity: {}\n"
        "  sources: [{{jet: {{center: [{:.5g}, {}, {:.5g}], radius: {}, velocity: [0, {:.5g}, 0], end: {}}}}}]\n",
        spacing, 5 * water_viscosity, x, height, z, radius, -volume / (pi * radius * radius * pouring), pouring);
    return fmt::format(
        "drench: 1\n"
        "time: {}\n"
        "domain: {{min: [-0.15, -0.05, -0.15], max: [0.15, 0.05, 0.15]}}\n"
        "output: {{every: 0.5, fabric: true, wet_above: {:g}}}\n{}{}",
        pours ? "{step: 0.003, end: 300, mode: cfl}" : "{step: 0.1, end: 300}", wet_above, pours ? water : "",
        trial.specimen(fmt::format("{{grid: {{size: [{0}, {0}], nodes: [{1}, {1}]}}}}", size, nodes),
                       "    dynamics: false\n", trial.porous_without_flow()));
  };
  std::unique_ptr<Simulation> run = trial.open(scene(true));
  const double end = run->scene().time.end;
  double before = 0, along = 0, across = 0, reached = end;
  bool circle_reached = false, hopeless = false;
  const auto look = [&](const HostState& s) {
    const double now = before + run->time();
    std::tie(across, along) = wet_extents(s, run->saturation(s), run->triangles());
    const double inside = cloth_mass(*run, s);
    trial.row({now, 1e3 * along, 1e3 * across, 1e3 * liquid_mass(*run, s), 1e3 * inside});
    circle_reached = std::max(along, across) >= circle;
    if (circle_reached) reached = now;
    const bool waits_for_water = !(before > 0);
    hopeless = waits_for_water && now > pouring + given_up && inside / (volume * water_density) * end < now;
    return !circle_reached && !hopeless && !(waits_for_water && now > pouring && s.fluid_mass.empty());
  };
  watch_run(*run, end, 0.5, look);
  if (hopeless)
    trial.note(
        fmt::format("the water is not absorbed within {:g} s: the test was ended after {:g} s", end, run->time()));
  if (!circle_reached && !hopeless &&
      run->time() < end) {  // nothing lies on the fabric any more: longer steps without particles
    const std::unique_ptr<Simulation> poured = std::move(run);
    before = poured->time();
    run = trial.open(scene(false), "_after");
    hand_over(*poured, *run);
    watch_run(*run, end - before, 1, look);
  }
  trial.number("time", "time to the 100 mm circle, at most 5 min", "s", reached);
  std::optional<double> expected;
  if (const double radius_then = spread_radius(trial, volume, reached - pouring / 2); radius_then > 0)
    expected = 2e3 * radius_then;
  trial.number("length", "wet length along the warp", "mm", 1e3 * along, expected);
  trial.number("width", "wet width along the weft", "mm", 1e3 * across, expected);
  trial.number("rate", "horizontal wicking rate, pi/4 length width/time", "mm2/s",
               1e6 * pi / 4 * along * across / reached);
}

// ---- AATCC TM79

void drop_absorbency(Trial& trial) {
  constexpr double volume = 50e-9, tip = 0.01, size = 0.06, spacing = 0.00075;  // m³ (20 drops per mL), m
  constexpr double given_up = 5, longest = 60, rest = 0.01;                     // s, s, part of the drop
  constexpr int nodes = 61;
  const double radius = std::cbrt(3 * volume / (4 * pi)), cell = size / (nodes - 1);
  auto run = trial.open(
      fmt::format("drench: 1\n"
                  "time: {{step: 0.001, end: {}, mode: cfl}}\n"
                  "domain: {{min: [-0.04, -0.03, -0.04], max: [0.04, 0.03, 0.04]}}\n"
                  "output: {{every: 0.01, fabric: true}}\n"
                  "fluid:  # one drop of 0.05 mL that leaves a tip 10 mm above the fabric\n"
                  "  spacing: {}\n  viscosity: {}\n  surface_tension: {}\n"
                  "  sources: [{{sphere: {{center: [{:.5g}, {:.5g}, {:.5g}], radius: {:.5g}}}}}]\n"
                  "{}",
                  longest, spacing, water_viscosity, water_surface_tension, 0.5 * cell * trial.scatter(0), tip - radius,
                  0.5 * cell * trial.scatter(1), radius,
                  trial.specimen(fmt::format("{{grid: {{size: [{0}, {0}], nodes: [{1}, {1}]}}}}", size, nodes),
                                 "    dynamics: false\n    adhesion: 0.1\n", trial.porous_without_flow())));
  double drop = 0, touched = -1, absorbed_at = -1, wet = 0, last = 0;
  watch_run(*run, run->scene().time.end, 0.01, [&](const HostState& s) {
    const double on_top = liquid_mass(*run, s), inside = cloth_mass(*run, s), now = run->time();
    if (drop == 0) drop = on_top;
    const auto [across, along] = wet_extents(s, run->saturation(s), run->triangles());
    wet = std::max(across, along);
    if (touched < 0) {
      double lowest = 1;
      for (const Vec3& x : s.fluid_position) lowest = std::min(lowest, x[1]);
      if (inside > 0 || lowest < spacing) touched = now;
    }
    if (now >= last - 1e-9) {
      trial.row({now, 1e6 * on_top, 1e6 * inside, 1e3 * wet});
      last = now + (now < 1 ? 0.01 : 0.1);
    }
    if (on_top <= rest * drop) absorbed_at = now;
    const bool hopeless = touched >= 0 && now > touched + given_up && inside / drop * longest < now - touched;
    return absorbed_at < 0 && !hopeless;
  });
  const double time = absorbed_at >= 0 ? absorbed_at - std::max(0.0, touched) : longest;
  if (absorbed_at < 0) trial.note("60 s means 60 s or more: the drop is not absorbed");
  trial.number("wetting_time", "wetting time, at most 60 s", "s", time);
  trial.number("spot", "diameter of the wet spot then", "mm", 1e3 * wet);
}

// ---- ISO 9073-14

/// Filter paper of published wicking (docs/validation/diffusion.md), as a layer.
std::string paper(const std::string& name, double height, double thickness, const std::string& keys) {
  return fmt::format(
      "  - name: {}\n    mesh: {{grid: {{size: [0.1, 0.1], nodes: [5, 5]}}}}\n    place: {{position: [0, {:.6g}, 0]}}\n"
      "    areal_density: {:.4g}\n    thickness: {:.4g}\n    dynamics: false\n{}"
      "    porous: {{solid_fraction: 0.16, diffusivity: 4.1e-5, diffusion_exponent: 5, capillary_height: 0.3,"
      " max_saturation: 1, contact_wicking: true}}\n",
      name, height, 240 * thickness, thickness, keys);
}

void wetback(Trial& trial) {
  if (!trial.wicks()) {
    trial.number("wetback", "wetback: water in the pick-up paper", "g", 0);
    trial.number("wetback_per_area", "the same per area", "g/m2", 0);
    trial.number("held", "water in the specimen", "g", 0);
    trial.note(trial.material().diffusivity > 0
                   ? "the fabric repels water (breakthrough_pressure), so that it takes none from the pad"
                   : "the fabric has no diffusivity, so that it takes no water from the pad");
    return;
  }
  constexpr double pad = 0.004, pick_up = 0.0012, area = 0.01, waiting = 180, pressed = 120;  // m, m, m², s, s
  const double load = 0.8 + 0.05 * trial.scatter(0);                                          // saturation of the pad
  const double specimen = trial.material().thickness;
  const double first = 0.55 * (pad + specimen), second = first + 0.55 * (specimen + pick_up);
  const auto scene = [&](bool with_paper) {
    return fmt::format(
        "drench: 1\n"
        "time: {{step: 0.02, end: {:g}}}\n"
        "output: {{every: 1, fabric: true}}\n"
        "{}{}{}",
        with_paper ? pressed : waiting,
        trial.specimen("{grid: {size: [0.1, 0.1], nodes: [5, 5]}}",
                       fmt::format("    place: {{position: [0, {:.6g}, 0]}}\n    dynamics: false\n", first),
                       "contact_wicking: true, " + trial.porous_without_film()),
        paper("pad", 0, pad,
              fmt::format("    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: {:.4g}}}]\n",
                          load)),
        with_paper ? paper("pick_up_paper", second, pick_up, "") : "");
  };
  // First the load evens out over pad and specimen, then the pick-up paper lies on top.
  const std::unique_ptr<Simulation> even = trial.open(scene(false), "_before");
  even->run_until(even->scene().time.end);
  const std::unique_ptr<Simulation> run = trial.open(scene(true));
  hand_over(*even, *run);
  double picked = 0, held = 0;
  watch_run(*run, run->scene().time.end, 1, [&](const HostState& s) {
    held = cloth_mass(*run, s, 0), picked = cloth_mass(*run, s, 2);
    trial.row({run->time(), 1e3 * picked, 1e3 * held, 1e3 * cloth_mass(*run, s, 1)});
    return true;
  });
  trial.number("wetback", "wetback: water in the pick-up paper", "g", 1e3 * picked);
  trial.number("wetback_per_area", "the same per area", "g/m2", 1e3 * picked / area);
  trial.number("held", "water in the specimen", "g", 1e3 * held);
}

}  // namespace

StandardTest vertical_wicking_test() {
  return {.name = "aatcc197",
          .aliases = {"vertical-wicking"},
          .standard = "AATCC TM197",
          .title = "vertical wicking of a hanging strip",
          .varied = "water level within half a cell of the mesh",
          .directions = true,
          .porous = true,
          .repeats = 3,
          .columns = {"time (s)", "wicking height (mm)", "absorbed water (g)"},
          .run = vertical_wicking};
}

StandardTest horizontal_wicking_test() {
  return {.name = "aatcc198",
          .aliases = {"horizontal-wicking"},
          .standard = "AATCC TM198",
          .title = "horizontal wicking of 1 mL of water",
          .varied = "position of the water within a cell of the mesh",
          .directions = false,
          .porous = true,
          .repeats = 2,
          .columns = {"time (s)", "wet length (mm)", "wet width (mm)", "water on the fabric (g)", "absorbed water (g)"},
          .run = horizontal_wicking};
}

StandardTest drop_absorbency_test() {
  return {.name = "aatcc79",
          .aliases = {"drop"},
          .standard = "AATCC TM79",
          .title = "time to absorb a drop of water",
          .varied = "position of the drop within a cell of the mesh",
          .directions = false,
          .porous = true,
          .repeats = 5,
          .columns = {"time (s)", "water on the fabric (mg)", "absorbed water (mg)", "wet diameter (mm)"},
          .run = drop_absorbency};
}

StandardTest wetback_test() {
  return {
      .name = "iso9073-14",
      .aliases = {"wetback"},
      .standard = "ISO 9073-14",
      .title = "wetback from a wet pad through the specimen into dry paper",
      .varied = "saturation of the pad, 0.75 to 0.85",
      .directions = false,
      .porous = true,
      .repeats = 3,
      .columns = {"time (s)", "water in the pick-up paper (g)", "water in the specimen (g)", "water in the pad (g)"},
      .run = wetback};
}

}  // namespace drench
