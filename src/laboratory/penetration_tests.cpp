// Liquid that is driven against the fabric: AATCC TM22, TM42, ISO 9073-17, ISO 811, ISO 9073-8.

#include <algorithm>
#include <cmath>

#include "laboratory/tests.hpp"
#include "laboratory/trial.hpp"
#include "setup/cloth_material.hpp"

namespace drench {
namespace {

// ---- Sprays: AATCC TM22, TM42, ISO 9073-17

/// A spray on a taut specimen at 45°.
struct Spray {
  double width, length;     // m, of the specimen
  double volume, duration;  // m³, s: as the standard has it
  double fall;              // m: from the nozzle to the middle of the specimen
  double field;             // m: side of the square that the water of the standard falls through
  double part;              // m: side of the part of it that is run
  double simulated;         // s
  bool blotter;             // behind the specimen
};

constexpr double spray_spacing = 0.003, drop_diameter = 0.0036;  // m: a particle is about one drop
constexpr double nozzle_speed = 0.84;                            // m/s: 250 mL in 27.5 s through 19 holes of 0.86 mm
constexpr double blotter_thickness = 0.00058;                    // m: 139 g/m², 0.24 g/cm³

double spray_speed(const Spray& spray) {
  return std::sqrt(nozzle_speed * nozzle_speed + 2 * standard_gravity * spray.fall);
}

/// A grid in the specimen's plane, `behind` m below it along its normal.
std::string inclined_grid(double width, double length, double cell, double behind) {
  const double shift = behind / std::numbers::sqrt2;
  return fmt::format(
      "    place: {{position: [0, {:.6g}, {:.6g}], rotate: {{axis: [1, 0, 0], degrees: 45}}}}\n"
      "    dynamics: false  # {:g} mm by {:g} mm, cells of {:g} mm\n",
      -shift, -shift, 1e3 * width, 1e3 * length, 1e3 * cell);
}

std::string grid_of(double width, double length, double cell) {
  return fmt::format("{{grid: {{size: [{}, {}], nodes: [{}, {}]}}}}", width, length, std::lround(width / cell) + 1,
                     std::lround(length / cell) + 1);
}

/// Fabric that absorbs fills within the first seconds of the standard, of which only a part is run.
bool starts_full(const Trial& trial, const Spray& spray) {
  return spray.blotter && !(trial.material().breakthrough_pressure > 0);
}

std::string spray_scene(const Trial& trial, const Spray& spray) {
  constexpr double above = 0.02;  // m: from the specimen's upper edge to where drops appear
  const double speed = spray_speed(spray), cell = 0.01;
  const double start = spray.part / 2 + above;
  // The pressure of a drop acts while it lands.
  const double landing = drop_diameter / speed;
  std::string porous = fmt::format("emission_ramp: {:.3g}", landing);
  if (!(trial.material().breakthrough_pressure > 0))
    porous += ", " + fmt::format("uptake_velocity: {:.4g}", trial.uptake_velocity());
  // In contact with the specimen the blotter would count as a second wall, which keeps drops from the specimen.
  constexpr double gap = 2.2 * spray_spacing;
  const double domain = spray.length / 2 + 0.05;
  std::string scene = fmt::format(
      "drench: 1\n"
      "time: {{step: 0.001, end: {:g}, mode: cfl}}\n"
      "domain: {{min: [{:.4g}, {:.4g}, {:.4g}], max: [{:.4g}, {:.4g}, {:.4g}]}}\n"
      "output: {{every: 0.05, fabric: true}}\n"
      "fluid:  # {:g} mL in {:g} s of the standard, of which {:g} s are run\n"
      "  spacing: {}\n  viscosity: {}\n"
      "  sources: [{{rain: {{center: [{:.4g}, {:.4g}, {:.4g}], size: [{}, {}], rate: {:.5g}, diameter: {},"
      " velocity: [0, {:.4g}, 0]}}}}]\n",
      spray.simulated, -spray.width / 2 - 0.02, -domain * 0.8, -domain, spray.width / 2 + 0.02,
      std::max(start + 0.01, domain * 0.8), domain, 1e6 * spray.volume, spray.duration, spray.simulated, spray_spacing,
      water_viscosity, 0.5 * cell * trial.scatter(0), start, 0.5 * cell * trial.scatter(1), spray.part, spray.part,
      spray.volume / spray.duration / (spray.field * spray.field) * 3.6e6, drop_diameter, -speed);
  std::string keys = inclined_grid(spray.width, spray.length, cell, 0);
  if (starts_full(trial, spray))
    keys += "    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 1}]\n";
  scene += trial.specimen(grid_of(spray.width, spray.length, cell), keys, porous);
  if (!spray.blotter) return scene;
  scene += fmt::format(
      "  - name: blotter\n    mesh: {}\n{}    areal_density: 0.139\n    thickness: {}\n"
      "    porous: {{solid_fraction: 0.158, uptake_velocity: 0.01, diffusivity: 4.1e-5, diffusion_exponent: 5,"
      " capillary_height: 0.3, max_saturation: 1}}\n",
      grid_of(spray.width, spray.length, cell), inclined_grid(spray.width, spray.length, cell, gap), blotter_thickness);
  return scene;
}

/// kg: what a jet or rain has let go.
double supplied(const Simulation& run, const StepReport& report) {
  return static_cast<double>(report.mass_supplied) * run.quantum();
}

/// How much of the sprayed part of the specimen is wet: of the nodes on which drops fall.
double wet_share(const Simulation& run, const HostState& s, double field, double wet_above) {
  const std::vector<double> saturation = run.saturation(s);
  const auto [first, count] = run.cloth_nodes(0);
  double inside = 0, wet = 0;
  for (Index n = first; n < first + count; ++n) {
    const Vec3& x = s.node_position[at(n)];
    if (std::max(std::fabs(x[0]), std::fabs(x[2])) > field / 2) continue;
    inside += 1;
    wet += saturation[at(n)] >= wet_above;
  }
  return inside > 0 ? wet / inside : 0;
}

/// The grade of the standard's chart that the wet share of the sprayed face comes next to.
double spray_grade(double wet, double passed) {
  if (wet < 0.01) return 100;
  if (wet < 0.1) return 90;
  if (wet < 0.3) return 80;
  if (wet < 0.9) return 70;
  return passed > 0.01 ? 0 : 50;
}

void run_spray(Trial& trial, const Spray& spray) {
  auto run = trial.open(spray_scene(trial, spray));
  const double end = run->scene().time.end, interval = end / 40;
  StepReport report;
  double wet = 0, held = 0, passed = 0, blotted = 0;
  double next = 0;
  for (;;) {
    if (run->time() >= next - 1e-9) {
      const HostState s = run->state();
      wet = wet_share(*run, s, spray.part, 0.05);
      held = cloth_mass(*run, s, 0);
      blotted = spray.blotter ? cloth_mass(*run, s, 1) : 0;
      passed = report.fabrics.empty() ? 0 : static_cast<double>(report.fabrics[0].through()) * run->quantum();
      if (spray.blotter)
        trial.row({run->time(), 1e3 * supplied(*run, report), 1e3 * held, 1e3 * blotted});
      else
        trial.row({run->time(), 1e3 * supplied(*run, report), 1e3 * held, 1e3 * passed, 100 * wet});
      next += interval;
    }
    if (run->time() >= end * (1 - 1e-9)) break;
    report = run->step(std::min(next, end) - run->time());
  }
  if (starts_full(trial, spray)) trial.note("the specimen absorbs, and starts full of water");
  const double sprayed = supplied(*run, report);
  trial.number("sprayed", "sprayed water", "g", 1e3 * sprayed);
  trial.number("held", "water in the specimen", "g", 1e3 * held);
  if (spray.blotter) {
    trial.number("penetration", "penetration: gain of the blotter", "g", 1e3 * blotted);
    trial.number("penetration_share", "part of the sprayed water in the blotter", "%", 100 * blotted / sprayed);
    trial.number("penetration_of_500_mL", "the same part of 500 mL", "g", 1e6 * spray.volume * blotted / sprayed);
  } else {
    trial.number("wet_share", "wet part of the sprayed face", "%", 100 * wet);
    trial.number("passed", "water that passed the specimen", "g", 1e3 * passed);
    trial.number("grade", "spray grade by the wet part (0, 50, 70, 80, 90, 100)", "1",
                 spray_grade(wet, passed / sprayed));
  }
}

void spray(Trial& trial) { run_spray(trial, {0.15, 0.15, 250e-6, 27.5, 0.15, 0.08, 0.08, 2, false}); }
void impact_penetration(Trial& trial) { run_spray(trial, {0.08, 0.08, 500e-6, 55, 0.6, 0.1, 0.04, 2, true}); }
void spray_impact(Trial& trial) { run_spray(trial, {0.08, 0.08, 500e-6, 55, 0.61, 0.1, 0.04, 2, true}); }

// ---- ISO 811

constexpr double column_width = 0.024, column_height = 0.024, column_spacing = 0.003;  // m

/// A short column under raised gravity, so that its pressure is that of the head.
std::string head_scene(Trial& trial, double head) {
  const double gravity = standard_gravity * head / column_height, shift = 0.3 * column_spacing * trial.scatter(0);
  // Four digits, as in the scene, so that frames come after whole steps.
  const double step = std::stod(fmt::format("{:.4g}", std::min(0.001, 0.2 * std::sqrt(column_spacing / gravity))));
  return fmt::format(
      "drench: 1\n"
      "time: {{step: {:.4g}, end: 0.1}}\n"
      "gravity: [0, {:.6g}, 0]  # {:.4g} m of water: {:g} mm of it under {:.4g} times the gravity of the Earth\n"
      "domain: {{min: [-0.03, -0.03, -0.03], max: [0.03, 0.05, 0.03]}}\n"
      "output: {{every: {:.6g}, fabric: true}}\n"
      "fluid:\n  spacing: {}\n  viscosity: {}\n"
      "  sources: [{{block: {{min: [-{w}, 0, -{w}], max: [{w}, {h}, {w}]}}}}]\n"
      "{cloth}"
      "bodies: [{{box: {{min: [-{w}, -0.1, -{w}], max: [{w}, 0.1, {w}], inside: true}}}}]\n",
      step, -gravity, head, 1e3 * column_height, gravity / standard_gravity, step * std::round(0.02 / step),
      column_spacing, water_viscosity, fmt::arg("w", column_width / 2), fmt::arg("h", column_height),
      fmt::arg("cloth",
               trial.specimen(
                   fmt::format("{{grid: {{size: [{0}, {0}], nodes: [9, 9]}}}}", column_width + 2 * std::fabs(shift)),
                   fmt::format("    place: {{position: [{:.5g}, 0, {:.5g}]}}\n    dynamics: false\n", shift, shift),
                   "uptake_velocity: 0.01, " + trial.porous_without_wicking())));
}

void hydrostatic_head(Trial& trial) {
  constexpr double least = 0.02, most = 50;                // m of water
  constexpr double coarse = 1.2, fine = 1.02, hold = 0.1;  // factors of the head; s at each head
  const double pressure = trial.material().breakthrough_pressure;
  if (!(trial.material().permeability > 0)) {
    trial.note("the fabric has no permeability: no pressure drives water through it, and no head is measured");
    return;
  }
  const double expected = pressure / (water_density * standard_gravity);
  std::optional<HostState> closed;  // the last state in which the specimen held the water
  double start = std::max(least, 0.6 * expected), head = start, held = 0, factor = coarse;
  while (head < most) {
    const std::unique_ptr<Simulation> run = trial.open(head_scene(trial, head));
    if (closed) run->restore(*closed);
    const double particle = water_density * std::pow(column_spacing, 3);
    const double begin = run->time();
    run->run_until(begin + hold);
    const HostState s = run->state();
    // What has entered the specimen or left below it.
    double above = 0;
    for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
      if (s.fluid_position[i][1] > 0) above += static_cast<double>(s.fluid_mass[i]) * run->quantum();
    const double column = water_density * column_width * column_width * column_height;
    const double penetrated = column - above;
    const bool opens = penetrated > 3 * particle;
    trial.row({1e2 * head, 1e-2 * water_density * standard_gravity * head, 1e3 * penetrated});
    if (opens && factor == coarse && head > start) {  // go back and raise the head more slowly
      factor = fine;
      head = held * fine;
      continue;
    }
    if (opens) break;
    held = head;
    closed = s;
    head *= factor;
  }
  if (!closed) {
    trial.number("head", "hydrostatic head", "cm", 0, 1e2 * expected);
    trial.note(fmt::format("water enters at the first head of {:g} cm: 0 means less than that", 1e2 * head));
    return;
  }
  const double found = std::sqrt(held * head);
  trial.number("head", "hydrostatic head", "cm", 1e2 * found, 1e2 * expected);
  trial.number("pressure", "the same as pressure", "Pa", water_density * standard_gravity * found, pressure);
}

// ---- ISO 9073-8

void strike_through(Trial& trial) {
  constexpr double dose = 5e-6, width = 0.0222, spacing = 0.002;  // m³; m: the area of a cavity of 25 mm; m
  constexpr double rest = 0.05;                                   // part of the dose
  const double height = dose / (width * width), half = 0.5 * spacing * std::lround(width / spacing);
  const double shift = 0.4 * spacing * trial.scatter(0);
  auto run = trial.open(fmt::format(
      "drench: 1\n"
      "time: {{step: 0.001, end: 60}}\n"
      "domain: {{min: [-0.03, -0.03, -0.03], max: [0.03, 0.05, 0.03]}}\n"
      "output: {{every: 0.1, fabric: true}}\n"
      "fluid:  # 5 mL; what leaves the specimen falls off, as if an ideal pad took it\n"
      "  spacing: {}\n  viscosity: {}\n"
      "  sources: [{{block: {{min: [-{w}, 0, -{w}], max: [{w}, {:.5g}, {w}]}}}}]\n"
      "{cloth}"
      "bodies: [{{box: {{min: [-{w}, -0.1, -{w}], max: [{w}, 0.1, {w}], inside: true}}}}]\n",
      spacing, water_viscosity, height, fmt::arg("w", half),
      fmt::arg(
          "cloth",
          trial.specimen(
              fmt::format("{{grid: {{size: [{0:.5g}, {0:.5g}], nodes: [12, 12]}}}}", 2 * half + 2 * std::fabs(shift)),
              fmt::format("    place: {{position: [{:.5g}, 0, {:.5g}]}}\n    dynamics: false\n", shift, shift),
              fmt::format("uptake_velocity: {:.4g}, {}", trial.uptake_velocity(), trial.porous_without_wicking())))));
  double first = 0, struck = -1;
  const double end = run->scene().time.end;
  watch_run(*run, end, 0.05, [&](const HostState& s) {
    double above = 0;
    for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
      if (s.fluid_position[i][1] > 0) above += static_cast<double>(s.fluid_mass[i]) * run->quantum();
    if (first == 0) first = above;
    trial.row({run->time(), 1e3 * above, 1e3 * cloth_mass(*run, s)});
    if (above <= rest * first) struck = run->time();
    return struck < 0;
  });
  if (struck < 0) {
    trial.note(fmt::format("{:g} s means {:g} s or more", end, end));
    struck = end;
  }
  // A falling head, h' = −u, that drives with half of the fabric's thickness besides, and drag by Eq. 29a of
  // docs/theory/porous.md: g (h + τ/2)/τ = ν/k u + β u², so that dt = −τ/g (ν/k + 2 β u) du/u.
  const MaterialScene& m = trial.material();
  std::optional<double> expected;
  if (m.permeability > 0 && !(m.breakthrough_pressure > 0)) {
    const double area = 4 * half * half * water_density;  // kg/m
    const double high = first / area - trial.capacity() / water_density, low = rest * first / area;
    const double viscous = run->scene().fluid.viscosity / m.permeability, inertial = inertial_drag(m);
    const auto speed = [&](double head) {
      const double drive = standard_gravity * (head + m.thickness / 2) / m.thickness;
      return 2 * drive / (viscous + std::sqrt(viscous * viscous + 4 * inertial * drive));
    };
    if (high > low)
      expected = m.thickness / standard_gravity *
                 (viscous * std::log(speed(high) / speed(low)) + 2 * inertial * (speed(high) - speed(low)));
  }
  trial.number("time", fmt::format("strike-through time of {:g} % of 5 mL", 100 * (1 - rest)), "s", struck, expected);
}

}  // namespace

StandardTest spray_test() {
  return {.name = "aatcc22",
          .aliases = {"spray"},
          .standard = "AATCC TM22",
          .title = "wetting by a spray, at 45 degrees",
          .varied = "place of the spray within a cell of the mesh",
          .directions = false,
          .porous = true,
          .repeats = 2,
          .columns = {"time (s)", "sprayed water (g)", "water in the specimen (g)", "water that passed (g)",
                      "wet part (%)"},
          .run = spray};
}

StandardTest impact_penetration_test() {
  return {.name = "aatcc42",
          .aliases = {"impact-penetration"},
          .standard = "AATCC TM42",
          .title = "penetration of a spray from 0.6 m into a blotter",
          .varied = "place of the spray within a cell of the mesh",
          .directions = false,
          .porous = true,
          .repeats = 2,
          .columns = {"time (s)", "sprayed water (g)", "water in the specimen (g)", "water in the blotter (g)"},
          .run = impact_penetration};
}

StandardTest spray_impact_test() {
  return {.name = "iso9073-17",
          .aliases = {"spray-impact"},
          .standard = "ISO 9073-17",
          .title = "penetration of a spray from 0.61 m into a blotter (nonwovens)",
          .varied = "place of the spray within a cell of the mesh",
          .directions = false,
          .porous = true,
          .repeats = 2,
          .columns = {"time (s)", "sprayed water (g)", "water in the specimen (g)", "water in the blotter (g)"},
          .run = spray_impact};
}

StandardTest hydrostatic_head_test() {
  return {.name = "iso811",
          .aliases = {"hydrostatic-head"},
          .standard = "ISO 811",
          .title = "hydrostatic head at which water penetrates",
          .varied = "position of the specimen within a particle spacing",
          .directions = false,
          .porous = true,
          .repeats = 3,
          .columns = {"head (cm)", "head (mbar)", "water that entered (g)"},
          .run = hydrostatic_head};
}

StandardTest strike_through_test() {
  return {.name = "iso9073-8",
          .aliases = {"strike-through"},
          .standard = "ISO 9073-8",
          .title = "strike-through time of 5 mL",
          .varied = "position of the specimen within a particle spacing",
          .directions = false,
          .porous = true,
          .repeats = 2,
          .columns = {"time (s)", "water above the specimen (g)", "water in the specimen (g)"},
          .run = strike_through};
}

}  // namespace drench
