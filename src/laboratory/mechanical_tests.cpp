// The dry fabric and its drying: ISO 9073-7, ISO 13934-1, ISO 9073-9, ISO 17617.

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "base/eigen_vec.hpp"
#include "laboratory/tests.hpp"
#include "laboratory/trial.hpp"
#include "output/text_file.hpp"
#include "setup/air.hpp"

namespace drench {
namespace {

double rigidity(const MaterialScene& m, bool along_warp) {
  if (!m.bending) return m.bend;
  return along_warp ? m.bending->warp : m.bending->weft;
}

double stiffness(const MaterialScene& m, bool along_warp) {
  if (!m.membrane) return m.stretch;
  return along_warp ? m.membrane->warp : m.membrane->weft;
}

/// Steps until the fastest node moves at less than `slow`, m/s, but at most until the scene's end.
bool come_to_rest(Simulation& run, double slow) {
  const double end = run.scene().time.end;
  while (run.time() < end * (1 - 1e-9)) {
    const double speed = run.step().cloth_speed;
    if (run.steps() > 20 && speed < slow) return true;
  }
  return false;
}

// ---- ISO 9073-7, ASTM D1388

/// The angle below the horizontal, degrees, of the line from the edge of the platform to the end of a strip that hangs
/// over it.
double overhang_angle(Trial& trial, double overhang, int cells) {
  constexpr double width = 0.025;
  constexpr int across = 4;  // nodes
  const double cell = overhang / cells, length = overhang + 2 * cell;
  const MaterialScene& m = trial.material();
  // The lowest frequency of the strip; its damping is nearly critical.
  const double frequency =
      3.516 * std::sqrt(rigidity(m, trial.along_warp()) / (m.areal_density * std::pow(overhang, 4)));
  const double step = std::stod(fmt::format("{:.2g}", 0.1 / frequency));
  auto run = trial.open(fmt::format(
      "drench: 1\n"
      "time: {{step: {:.6g}, end: {:.6g}}}\n"
      "output: {{every: {:.6g}}}\n"
      "{}",
      step, 600 * step, 10 * step,
      trial.specimen(
          fmt::format("{{grid: {{size: [{}, {:.6g}], nodes: [{}, {}]}}}}", width, length, across, cells + 3),
          fmt::format("    place: {{position: [0, 0, {:.6g}]}}  # the platform ends at z = 0\n{}    damping: {:.4g}\n"
                      "    pin: [{{box: {{min: [-1, -1, -1], max: [1, 1, {:.6g}]}}}}]\n",
                      length / 2 - 2 * cell, trial.warp_along_length(), 1.5 * frequency, 0.01 * cell))));
  if (!come_to_rest(*run, 2e-4 * overhang * frequency)) trial.note("the strip had not come to rest");
  const std::vector<Vec3> position = run->state().node_position;
  double drop = 0, reach = 0;
  for (std::size_t n = position.size() - across; n < position.size(); ++n)
    drop -= position[n][1], reach += position[n][2];
  return std::atan2(drop, reach) * 180 / pi;
}

/// The overhang at which that angle is 41.5°, m; none where the strip does not hang down.
std::optional<double> overhang_of(Trial& trial, double overhang, int cells) {
  constexpr double target = 41.5, radians = pi / 180;
  // Peirce's formula for the bending length over the overhang.
  const auto peirce = [](double a) { return std::cbrt(std::cos(a / 2) / (8 * std::tan(a))); };
  for (int k = 0; k < 6; ++k) {
    const double angle = overhang_angle(trial, overhang, cells);
    trial.row({static_cast<double>(cells), 1e3 * overhang, angle});
    if (!(angle > 0 && angle < 90)) return std::nullopt;
    overhang *= peirce(angle * radians) / peirce(target * radians);
    if (std::fabs(angle - target) < 0.3) break;
  }
  return overhang;
}

void cantilever(Trial& trial) {
  const MaterialScene& m = trial.material();
  const double weight = m.areal_density * standard_gravity, input = rigidity(m, trial.along_warp());
  const std::string name = trial.along_warp() ? "warp" : "weft";
  if (!(input > 0)) {
    trial.note("the fabric has no bending stiffness");
    return;
  }
  const double expected = std::cbrt(input / weight);
  // The clamp's edge is uncertain by a part of a cell: two meshes tell it.
  const int cells = 30 + 4 * trial.repeat();
  const std::optional<double> coarse = overhang_of(trial, 2 * expected, cells),
                              fine = coarse ? overhang_of(trial, *coarse, 2 * cells) : std::nullopt;
  const double length = fine ? (2 * *fine - *coarse) / 2 : 0;
  if (!(length > 0)) {
    trial.note("the strip does not hang down from the edge: no bending length is measured, " + name);
    return;
  }
  trial.number("bending_length_" + name, "bending length, " + name, "mm", 1e3 * length, 1e3 * expected);
  trial.number("flexural_rigidity_" + name, "flexural rigidity, " + name, "uN m", 1e6 * weight * std::pow(length, 3),
               1e6 * input);
}

// ---- ISO 13934-1

void tensile(Trial& trial) {
  constexpr double width = 0.05, gauge = 0.2, rate = 0.1 / 60, strain = 0.05;  // m, m, m/s, 1
  const std::string name = trial.along_warp() ? "warp" : "weft";
  const int along = 41 + 4 * trial.repeat(), across = (along - 1) / 4 + 1;
  auto run = trial.open(fmt::format(
      "drench: 1\n"
      "time: {{step: 0.1, end: {:g}}}\n"
      "gravity: [0, 0, 0]\n"
      "output: {{every: 0.5}}\n"
      "cloth_solver: {{tolerance: 1.0e-4}}\n"
      "{}",
      strain * gauge / rate,
      trial.specimen(
          fmt::format("{{grid: {{size: [{}, {}], nodes: [{}, {}]}}}}", width, gauge, across, along),
          fmt::format("{}    damping: 20\n    pin:\n"
                      "      - {{box: {{min: [-1, -1, -1], max: [1, 1, {:.5g}]}}}}\n"
                      "      - {{box: {{min: [-1, -1, {:.5g}], max: [1, 1, 1]}}, velocity: [0, 0, {:.6g}]}}\n",
                      trial.warp_along_length(), -gauge / 2 + 1e-4, gauge / 2 - 1e-4, rate))));
  const std::vector<Index> grip = run->pin_nodes(0, 1);
  std::vector<double> extensions, forces;
  double previous_strain = 0, previous_force = 0;
  // Springs on a grid resist with 1.2 Y along its axes (docs/theory/cloth.md, (4)).
  const MaterialScene& m = trial.material();
  const double slope = (m.membrane ? 1 : 1.2) * stiffness(m, trial.along_warp()), limit = m.strain_limit;
  const double lock = !m.membrane ? 0 : trial.along_warp() ? m.membrane->warp_locking : m.membrane->weft_locking;
  const auto expected = [=](double e) {  // N/m; docs/theory/cloth.md, Eq. 4c
    if (!(lock > 0)) return slope * e;
    const double at = std::min(e, locking_part * lock), left = 1 - at * at / (lock * lock);
    return slope * (at / left + (2 - left) / (left * left) * (e - at));
  };
  const auto is_elastic = [limit](double e) { return !(limit > 0) || e < limit * (1 - 1e-6); };
  std::vector<double> marks{0.01, 0.02, 0.05};
  watch_run(*run, run->scene().time.end, 0.1, [&](const HostState& s) {
    double force = 0;
    for (const Index n : grip) force += s.node_pin_force[at(n)][2];
    const double e = rate * run->time() / gauge;
    trial.row({1e3 * e * gauge, 100 * e, force});
    if (e > 0.001 && e < 0.0101 && is_elastic(e)) extensions.push_back(e), forces.push_back(force / width);
    while (!marks.empty() && e >= marks.front() * (1 - 1e-6)) {
      const double f = previous_force + (force - previous_force) * (marks.front() - previous_strain) /
                                            std::max(1e-12, e - previous_strain);
      trial.number(fmt::format("force_{:g}_percent_{}", 100 * marks.front(), name),
                   fmt::format("force at {:g} %, 50 mm wide, {}", 100 * marks.front(), name), "N", f,
                   is_elastic(marks.front()) ? std::optional(expected(marks.front()) * width) : std::nullopt);
      marks.erase(marks.begin());
    }
    previous_strain = e, previous_force = force;
    return true;
  });
  if (extensions.size() > 1) {
    std::vector<double> by_law;
    for (const double e : extensions) by_law.push_back(expected(e));
    trial.number("stiffness_" + name, "tensile stiffness up to 1 %, " + name, "N/m", fit_line(extensions, forces).slope,
                 fit_line(extensions, by_law).slope);
  }
  if (!is_elastic(strain))
    trial.note(
        fmt::format("from {:g} % on the force is that of strain_limit, for which there is no theory", 100 * limit));
  trial.note("the fabric does not break in drench: maximum force and elongation are not measured");
}

// ---- ISO 9073-9

struct Disc {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  int held = 0;  // points on the supporting disc
};

/// Rings of ever more points, each turned by a random angle so that no direction is preferred.
Disc make_disc(double radius, double support, int rings, unsigned seed) {
  std::mt19937 random(seed);
  const auto number = [&] { return static_cast<double>(random()) / 4294967296.0; };  // the same on every machine
  Disc disc;
  disc.points.push_back({0, 0, 0});
  std::vector<int> first{0}, count{1};
  std::vector<double> turn{0};
  for (int k = 1; k <= rings; ++k) {
    first.push_back(static_cast<int>(disc.points.size()));
    count.push_back(6 * k);
    turn.push_back(number());
    const double r = radius * k / rings;
    for (int i = 0; i < 6 * k; ++i) {
      const double angle = 2 * pi * (i + turn.back()) / (6 * k);
      const double lift = r > support ? 1e-4 * (number() - 0.5) : 0;  // folds begin somewhere
      disc.points.push_back({r * std::cos(angle), lift, r * std::sin(angle)});
    }
    if (r < support * (1 + 1e-9)) disc.held = static_cast<int>(disc.points.size());
    const auto inner = [&](int i) {
      return first[static_cast<std::size_t>(k) - 1] + i % count[static_cast<std::size_t>(k) - 1];
    };
    const auto outer = [&](int i) { return first.back() + i % count.back(); };
    if (k == 1) {
      for (int i = 0; i < 6; ++i) disc.triangles.push_back({0, outer(i + 1), outer(i)});
      continue;
    }
    // Goes around both rings and takes the shorter diagonal.
    const int n = count[static_cast<std::size_t>(k) - 1], m = count.back();
    const auto angle_of = [](double i, double t, int c) { return (i + t) / c; };
    const double inner_turn = turn[static_cast<std::size_t>(k) - 1];
    int j = 0;  // the outer point next to the first inner one
    double best = 2;
    for (int i = 0; i < m; ++i) {
      double d = std::fabs(angle_of(i, turn.back(), m) - angle_of(0, inner_turn, n));
      d = std::min(d, 1 - d);
      if (d < best) best = d, j = i;
    }
    int a = 0, b = 0;
    while (a < n || b < m) {
      const auto far = [&](int p, int q) {
        const Vec3 &x = disc.points[static_cast<std::size_t>(inner(p))],
                   &y = disc.points[static_cast<std::size_t>(outer(j + q))];
        return std::hypot(x[0] - y[0], x[2] - y[2]);
      };
      if (b < m && (a == n || far(a, b + 1) < far(a + 1, b))) {
        disc.triangles.push_back({inner(a), outer(j + b + 1), outer(j + b)});
        ++b;
      } else {
        disc.triangles.push_back({inner(a), inner(a + 1), outer(j + b)});
        ++a;
      }
    }
  }
  return disc;
}

std::string obj_of(const Disc& disc) {
  std::string text;
  for (const Vec3& x : disc.points) text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", x[0], x[1], x[2]);
  for (const auto& t : disc.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

/// The area of the shadow that light along y throws, m².
double shadow(const std::vector<Vec3>& x, const std::vector<std::array<Index, 3>>& triangles, double radius) {
  constexpr int pixels = 640;
  const double size = 2.1 * radius / pixels;
  std::vector<std::uint8_t> dark(static_cast<std::size_t>(pixels) * pixels, 0);
  for (const auto& t : triangles) {
    const Vec3 &a = x[at(t[0])], &b = x[at(t[1])], &c = x[at(t[2])];
    const auto pixel = [&](double v) { return (v / size) + pixels / 2.0; };
    const double ax = pixel(a[0]), az = pixel(a[2]), bx = pixel(b[0]), bz = pixel(b[2]), cx = pixel(c[0]),
                 cz = pixel(c[2]);
    const double area = (bx - ax) * (cz - az) - (cx - ax) * (bz - az);
    if (area == 0) continue;
    const int low = std::max(0, static_cast<int>(std::floor(std::min({az, bz, cz})))),
              high = std::min(pixels - 1, static_cast<int>(std::ceil(std::max({az, bz, cz}))));
    const int left = std::max(0, static_cast<int>(std::floor(std::min({ax, bx, cx})))),
              right = std::min(pixels - 1, static_cast<int>(std::ceil(std::max({ax, bx, cx}))));
    for (int i = low; i <= high; ++i)
      for (int j = left; j <= right; ++j) {
        const double px = j + 0.5, pz = i + 0.5;
        const double u = ((bx - px) * (cz - pz) - (cx - px) * (bz - pz)) / area,
                     v = ((cx - px) * (az - pz) - (ax - px) * (cz - pz)) / area;
        if (u >= 0 && v >= 0 && u + v <= 1)
          dark[static_cast<std::size_t>(i) * pixels + static_cast<std::size_t>(j)] = 1;
      }
  }
  double sum = 0;
  for (const std::uint8_t d : dark) sum += d;
  return sum * size * size;
}

/// The number of folds: the strongest wave of the rim's distance from the axis.
int folds(const std::vector<Vec3>& x, int rings) {
  const std::size_t count = static_cast<std::size_t>(6 * rings);
  int strongest = 0;
  double most = 0;
  for (int k = 2; k <= 20; ++k) {
    double re = 0, im = 0;
    for (std::size_t n = x.size() - count; n < x.size(); ++n) {
      const double angle = 2 * pi * k * static_cast<double>(n) / static_cast<double>(count),
                   r = std::hypot(x[n][0], x[n][2]);
      re += r * std::cos(angle), im += r * std::sin(angle);
    }
    if (std::hypot(re, im) > most) most = std::hypot(re, im), strongest = k;
  }
  return strongest;
}

/// The fabric's resistance to stretch in the drape test, as a key of the cloth. Flat triangles of width h fold only
/// with stretch, and the fabric seems too stiff where that resists more than bending, h² k > 4000 B
/// (docs/dev/testing.md). A drape hardly depends on stretch, which therefore is limited; it stays below 2 % under the
/// fabric's weight.
std::string limited_stretch(Trial& trial, double radius, double width) {
  const MaterialScene& m = trial.material();
  const double bending = std::min(rigidity(m, true), rigidity(m, false));
  const double most = std::max(4000 * bending / (width * width), 50 * m.areal_density * standard_gravity * radius);
  if (std::max(stiffness(m, true), stiffness(m, false)) <= most && (!m.membrane || m.membrane->shear <= most))
    return "";
  trial.note(fmt::format(
      "stiffnesses of stretch and shear are limited to {:.3g} N/m, at which folds of the mesh bend freely", most));
  trial.writes(m.membrane ? "membrane" : "stretch");
  if (!m.membrane) return fmt::format("    stretch: {:.6g}\n", most);
  return fmt::format("    membrane: {{warp: {:.6g}, weft: {:.6g}, shear: {:.6g}}}\n", std::min(m.membrane->warp, most),
                     std::min(m.membrane->weft, most), std::min(m.membrane->shear, most));
}

void drape(Trial& trial) {
  constexpr double radius = 0.15, support = 0.09;  // m
  constexpr int rings = 25;                        // of 6 mm; the 15th is the edge of the support
  const Disc disc = make_disc(radius, support, rings, static_cast<unsigned>(trial.repeat()) + 1);
  const std::string mesh = trial.file_name("disc", ".obj");
  write_atomically(trial.folder() / mesh, obj_of(disc));
  std::string held;
  for (int n = 0; n < disc.held; ++n) held += fmt::format("{}{}", n ? ", " : "", n);
  auto run = trial.open(fmt::format(
      "drench: 1\n"
      "time: {{step: 0.01, end: 4}}\n"
      "output: {{every: 0.1}}\n"
      "{}",
      trial.specimen("{file: " + mesh + "}",
                     limited_stretch(trial, radius, radius / rings) +
                         "    warp: [0, 0, 1]\n    clean: off\n    damping: 4\n    pin: [{nodes: [" + held + "]}]\n")));
  const auto coefficient = [&](const HostState& s) {
    const double disc_area = pi * support * support, all = pi * radius * radius;
    return 100 * (shadow(s.node_position, run->triangles(), radius) - disc_area) / (all - disc_area);
  };
  double value = 100, before = 200;
  watch_run(*run, run->scene().time.end, 0.25, [&](const HostState& s) {
    before = value;
    value = coefficient(s);
    trial.row({run->time(), value});
    return !(run->time() > 1.5 && std::fabs(value - before) < 0.1);
  });
  if (std::fabs(value - before) > 1) trial.note("the fabric had not come to rest");
  trial.number("drape_coefficient", "drape coefficient, 30 cm on 18 cm", "%", value);
  trial.number("folds", "number of folds", "1", folds(run->state().node_position, rings));
}

// ---- ISO 17617

void drying_rate(Trial& trial) {
  constexpr double size = 0.1, volume = 0.3e-6;  // m, m³
  constexpr int cells = 16;
  const double cell = size / cells, capacity = trial.capacity();
  // A square of nodes that holds the volume at a saturation of at most 1.
  const double side = std::sqrt(volume * water_density / capacity);
  const int nodes = std::min(cells - 1, static_cast<int>(std::ceil(side / cell)));
  const double wanted = volume * water_density / capacity / std::pow(nodes * cell, 2),
               saturation = std::min(1.0, wanted);
  const double x = 0.004 * trial.scatter(0), y = 0.004 * trial.scatter(1);
  const auto near_node = [&](double at_place) {  // the middle of `nodes` nodes
    const double shift = nodes % 2 ? 0 : 0.5;
    return (std::floor(at_place / cell + 0.5) + shift) * cell;
  };
  const double half = 0.5 * nodes * cell, cx = near_node(x), cy = near_node(y);
  auto run = trial.open(fmt::format(
      "drench: 1\n"
      "time: {{step: 1, end: 21600}}\n"
      "air: {{humidity: 0.65, temperature: 20, speed: 0, length: {}, cooling: true}}\n"
      "output: {{every: 60, fabric: true}}\n"
      "{}",
      size,
      trial.specimen(
          fmt::format("{{grid: {{size: [{0}, {0}], nodes: [{1}, {1}]}}}}", size, cells + 1),
          fmt::format("    place: {{rotate: {{axis: [1, 0, 0], degrees: 90}}}}  # hangs\n    dynamics: false\n"
                      "    initial_saturation:  # {:.3g} mL\n"
                      "      - {{box: {{min: [{:.6g}, {:.6g}, -1], max: [{:.6g}, {:.6g}, 1]}}, value: {:.6g}}}\n",
                      1e6 * volume * saturation / wanted, cx - half, cy - half, cx + half, cy + half, saturation),
          trial.porous_without_film())));
  const Scene& scene = run->scene();
  const double flux = scene.air.cooling ? wet_bulb(scene).flux : evaporation_flux(scene);
  std::vector<double> hours, grams;
  double start = 0, dried_at = -1, wet_hours = 0, wet_last = 0;
  const double end = run->scene().time.end;
  StepReport report;
  for (double next = 0;;) {
    const double mass = cloth_mass(*run, run->state());
    if (start == 0) start = mass;
    const double residual = mass / start, hour = run->time() / 3600;
    wet_last = report.fabrics.empty() ? 0 : report.fabrics[0].wet_area;
    trial.row({run->time() / 60, 1e3 * mass, 100 * residual, 1e4 * wet_last});
    if (residual >= 0.1) hours.push_back(hour), grams.push_back(1e3 * mass);
    if (residual < 0.1 && dried_at < 0) {
      const double before = grams.back() / (1e3 * start);
      dried_at = hours.back() + (hour - hours.back()) * (before - 0.1) / (before - residual);
    }
    if (dried_at >= 0 || run->time() >= end * (1 - 1e-9)) break;
    next = std::min(end, next + 300);
    while (run->time() < next * (1 - 1e-9)) {
      report = run->step(next - run->time());
      wet_hours += report.dt / 3600 * (report.fabrics.empty() ? 0 : report.fabrics[0].wet_area);
    }
  }
  const double lost = 1e3 * (start - cloth_mass(*run, run->state()));
  const double rate = hours.size() > 1 ? -fit_line(hours, grams).slope : lost / (run->time() / 3600);
  if (wanted > 1)
    trial.note(
        fmt::format("the specimen holds {:.3g} mL within its edges, less than the 0.3 mL of the standard: the "
                    "test starts with that",
                    1e6 * start / water_density));
  trial.number("water", "water at the start", "g", 1e3 * start);
  trial.number("drying_rate", "drying rate from 100 % to 10 %", "g/h", rate);
  trial.number("rate_per_wet_area", "the same per wet area, both sides", "g/(m2 h)",
               wet_hours > 0 ? lost / (2 * wet_hours) : 0);
  trial.number("air_rate", "evaporation rate of wet cloth in this air", "g/(m2 h)", 3.6e6 * flux);
  if (dried_at >= 0)
    trial.number("time_to_dry", "time to 10 % of the water", "min", 60 * dried_at);
  else
    trial.note(fmt::format("more than 10 % of the water are left after {:g} h", end / 3600));
}

}  // namespace

StandardTest drying_rate_test() {
  return {.name = "iso17617",
          .aliases = {"drying"},
          .standard = "ISO 17617 A",
          .title = "drying rate of 0.3 mL of water in a hanging specimen",
          .varied = "place of the water",
          .directions = false,
          .porous = true,
          .repeats = 2,
          .columns = {"time (min)", "residual water (g)", "residual water (%)", "wet area (cm2)"},
          .run = drying_rate};
}

StandardTest drape_test() {
  return {.name = "iso9073-9",
          .aliases = {"drape", "cusick"},
          .standard = "ISO 9073-9",
          .title = "drape coefficient on a Cusick drape tester",
          .varied = "mesh, and the unevenness of 0.1 mm at which folds begin",
          .directions = false,
          .porous = false,
          .repeats = 3,
          .takes_other_mesh = false,
          .columns = {"time (s)", "drape coefficient (%)"},
          .run = drape};
}

StandardTest tensile_test() {
  return {.name = "iso13934-1",
          .aliases = {"tensile"},
          .standard = "ISO 13934-1",
          .title = "tensile force of a strip up to 5 %",
          .varied = "mesh width",
          .directions = true,
          .porous = false,
          .repeats = 2,
          .columns = {"extension (mm)", "strain (%)", "force (N)"},
          .run = tensile};
}

StandardTest cantilever_test() {
  return {.name = "iso9073-7",
          .aliases = {"astm-d1388", "cantilever"},
          .standard = "ISO 9073-7",
          .title = "bending length of a cantilever (ASTM D1388)",
          .varied = "mesh width",
          .directions = true,
          .porous = false,
          .repeats = 2,
          .takes_other_mesh = false,
          .columns = {"cells (1)", "overhang (mm)", "angle (degrees)"},
          .run = cantilever};
}

}  // namespace drench
