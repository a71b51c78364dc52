// The scene as a whole, and its small sections.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "scene/describe.hpp"
#include "scene/load.hpp"
#include "scene/nearest_word.hpp"

namespace drench {
namespace {

bool has_porous(const Scene& scene) {
  return std::any_of(scene.cloths.begin(), scene.cloths.end(),
                     [](const ClothScene& cloth) { return cloth.material.porous; });
}

/// A preset says where the switches stand that `processes` leaves alone. A resolved scene has the switches.
void describe_preset(Section& s, ProcessScene& processes) {
  enum class Preset { none, baseline } preset = Preset::none;
  s.saved_if(false).choice("preset", preset, {{"none", Preset::none}, {"baseline", Preset::baseline}},
                           "`baseline` turns `direction` and `saturation_control` off unless `processes` sets them; "
                           "only with porous cloth");
  if (preset == Preset::baseline) processes.direction = processes.saturation_control = false;
}

void describe_neighbors(Section& s, Scene& scene) {
  s.one_line();
  s.choice("sort", scene.sort,
           {{"auto", SortMethod::automatic},
            {"counting", SortMethod::counting},
            {"radix", SortMethod::radix},
            {"bitonic", SortMethod::bitonic},
            {"bitonic_naive", SortMethod::bitonic_naive}},
           "sorting algorithm; affects speed, not results");
  s.boolean("through_cloth", scene.through_cloth, "liquid interacts with liquid on the other side of a cloth");
}

/// Rejects what is not available with liquid of files.
void check_baked(Section& s, const Scene& scene) {
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    s.check(!scene.bodies[b].dynamic, fmt::format("bodies.{}", b),
            "is dynamic, which is not available with liquid of a sequence of files; allowed: bodies that are fixed, "
            "move as prescribed or are commanded");
  s.check(!scene.output.fitted_pressure, "output.fitted_pressure",
          "is not available with liquid of a sequence of files, which has no pressure; allowed: false");
}

/// In a frame that rotates about another direction than gravity's, gravity would turn.
void check_frame(Section& s, const Scene& scene) {
  const Vec3 &a = scene.rotating_frame.axis, &g = scene.gravity;
  const double across = std::hypot(a[1] * g[2] - a[2] * g[1], a[2] * g[0] - a[0] * g[2], a[0] * g[1] - a[1] * g[0]);
  s.check(across <= 1e-9 * std::hypot(a[0], a[1], a[2]) * std::hypot(g[0], g[1], g[2]), "rotating_frame.axis",
          "is not parallel to gravity, which would turn in the frame; allowed: gravity along the axis, or none");
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    s.check(!scene.bodies[b].dynamic, fmt::format("bodies.{}", b),
            "is dynamic; allowed: bodies that are at rest or move as prescribed in a scene with rotating_frame");
}

/// Relations between sections.
void check_sections(Section& s, const Scene& scene) {
  s.check(scene.fluid.present || !scene.cloths.empty(), "fluid",
          "the scene has neither fluid nor cloth; allowed: at least one of the two");
  s.check(scene.fluid.present || !scene.field.present, "field",
          "acts on liquid, and the scene has none; allowed: only with the key fluid");
  s.check(scene.fluid.present || !scene.output.surface, "output.surface",
          "requires liquid, and the scene has none; allowed: true only with the key fluid");
  if (scene.fluid.is_baked()) check_baked(s, scene);
  s.check(scene.fluid.present || !scene.output.fitted_pressure, "output.fitted_pressure",
          "requires liquid, and the scene has none; allowed: true only with the key fluid");
  if (scene.rotating_frame.present) check_frame(s, scene);
  s.check(!scene.air.present || scene.fluid.present || has_porous(scene), "air",
          "lets liquid evaporate, and the scene has neither liquid nor porous cloth; allowed: only with fluid or "
          "porous cloth");
  s.check(!s.has("cloth_solver") || !scene.cloths.empty(), "cloth_solver",
          "requires cloth, and the scene has none; allowed: only with the key cloth");
  const bool porous = has_porous(scene);
  s.check(!scene.output.fabric || porous, "output.fabric",
          "requires absorbent cloth, and the scene has none; allowed: true only if a cloth has the key porous");
  s.check(!scene.fluid.present || !scene.fluid.blocks.empty() || !scene.fluid.jets.empty() ||
              !scene.fluid.rains.empty() || !scene.fluid.sprays.empty() || !scene.fluid.mesh_jets.empty() || porous,
          "fluid.sources",
          "is missing; allowed: a list of maps; only scenes with porous cloth, which can drip, may omit it");
  for (const char* key : {"preset", "processes"})
    s.check(!s.has(key) || porous, key,
            "applies only to absorbent cloth, and the scene has none; allowed: only if a cloth has the key porous");
  if (const auto often = too_often(scene)) s.check(false, often->first, often->second);
}

auto body_named(const Scene& scene, const std::string& name) {
  return std::find_if(scene.bodies.begin(), scene.bodies.end(), [&](const BodyScene& b) { return b.name == name; });
}

/// For a name that none of `parts` has, in a key such as `bodies.N.name`.
template <class Parts>
std::string no_such(const char* kind, const std::string& name, const Parts& parts, const char* names) {
  std::vector<std::string> known;
  for (const auto& part : parts)
    if (!part.name.empty()) known.push_back(part.name);
  const std::string near = nearest_word(name, known);
  return fmt::format("there is no {} named '{}';{} allowed: a value of {}", kind, name,
                     near.empty() ? "" : fmt::format(" did you mean '{}'?", near), names);
}

std::string no_body(const Scene& scene, const std::string& name) {
  return no_such("body", name, scene.bodies, "bodies.N.name");
}

/// Pins follow a body whose motion does not depend on them.
void check_followed_body(Section& s, const Scene& scene, const std::string& name, const std::string& key) {
  if (name.empty()) return;
  const auto body = body_named(scene, name);
  s.check(body != scene.bodies.end(), key, no_body(scene, name));
  if (body != scene.bodies.end())
    s.not_available(body->dynamic, key, "a pin that follows a dynamic body", "a body without dynamic: true");
}

/// A hinge holds a dynamic body to another one that keeps its shape.
void check_joints(Section& s, const Scene& scene) {
  for (std::size_t i = 0; i < scene.joints.size(); ++i) {
    const JointScene& joint = scene.joints[i];
    const std::string key = fmt::format("joints.{}.hinge.", i);
    for (const auto& [part, name] : {std::pair{"body", joint.body}, {"to", joint.to}})
      s.check((name.empty() && part == std::string_view("to")) || body_named(scene, name) != scene.bodies.end(),
              key + part, no_body(scene, name));
    const auto body = body_named(scene, joint.body);
    s.check(body == scene.bodies.end() || body->dynamic, key + "body",
            fmt::format("'{}' is not a dynamic body; allowed: a body with dynamic: true", joint.body));
    s.check(joint.to != joint.body, key + "to", "is the body itself; allowed: another body, or none for the world");
  }
}

void check_probes(Section& s, const Scene& scene) {
  using Kind = ProbeScene::Kind;
  std::set<std::string> names;
  for (std::size_t i = 0; i < scene.output.probes.size(); ++i) {
    const ProbeScene& probe = scene.output.probes[i];
    const std::string key = fmt::format("output.probes.{}.", i);
    s.check(names.insert(probe.name).second, key + "name",
            fmt::format("an earlier probe is also named '{}'; allowed: a different name for each probe", probe.name));
    s.check(probe.name.find_first_of(",\"\n") == std::string::npos, key + "name",
            "contains a comma or a quotation mark; allowed: text without these");
    const auto named = [&](const auto& list) {
      return std::any_of(list.begin(), list.end(), [&](const auto& part) { return part.name == probe.of; });
    };
    if (probe.kind == Kind::body)
      s.check(named(scene.bodies), key + "body", no_body(scene, probe.of));
    else if (probe.kind == Kind::cloth)
      s.check(named(scene.cloths), key + "cloth", no_such("cloth", probe.of, scene.cloths, "cloth.N.name"));
    else
      s.check(scene.fluid.present,
              key + (probe.kind == Kind::point  ? "point"
                     : probe.kind == Kind::line ? "line"
                                                : "disc"),
              "applies only to liquid, and the scene has none; allowed: only with the key fluid");
  }
}

void check_parts(Section& s, const Scene& scene) {
  check_probes(s, scene);
  check_joints(s, scene);
  std::set<std::string> names;
  for (std::size_t i = 0; i < scene.cloths.size(); ++i) {
    const ClothScene& cloth = scene.cloths[i];
    s.check(!cloth.sample_spacing || !scene.fluid.present || *cloth.sample_spacing <= scene.fluid.spacing,
            fmt::format("cloth.{}.sample_spacing", i),
            fmt::format("{} is more than fluid.spacing; allowed: at most {} (m)", cloth.sample_spacing.value_or(0),
                        scene.fluid.spacing));
    s.check(!cloth.material.bending || scene.cloth_solver.method == ClothMethod::pd, fmt::format("cloth.{}.bending", i),
            "cannot be combined with cloth_solver.method: xpbd; allowed: only with pd");
    const bool passes = cloth.material.porous && cloth.material.permeability > 0;
    s.check(!passes || scene.fluid.viscosity > 0 || !scene.fluid.present,
            fmt::format("cloth.{}.porous.permeability", i),
            "needs a viscous liquid (Darcy's flux is k Δp / (μ τ)), and fluid.viscosity is 0; allowed: fluid.viscosity "
            "above 0");
    const bool inviscid = scene.fluid.present && !(scene.fluid.viscosity > 0) && !(cloth.material.film_viscosity > 0);
    s.check(!(cloth.material.porous && cloth.material.film > 0) || !inviscid, fmt::format("cloth.{}.porous.film", i),
            "needs a viscous liquid, and fluid.viscosity is 0; allowed: film_viscosity or fluid.viscosity above 0");
    s.check(names.insert(cloth.name).second, fmt::format("cloth.{}.name", i),
            fmt::format("an earlier cloth is also named '{}'; allowed: a different name for each cloth", cloth.name));
  }
  std::set<std::string> bodies;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const std::string& name = scene.bodies[i].name;
    s.check(name.empty() || bodies.insert(name).second, fmt::format("bodies.{}.name", i),
            fmt::format("an earlier body is also named '{}'; allowed: a different name for each body", name));
    using Kind = BodyScene::Kind;
    const Kind shape = scene.bodies[i].kind;  // planes are never dynamic
    const char* const kind = shape == Kind::sphere ? "sphere" : shape == Kind::mesh ? "mesh" : "box";
    s.not_available(scene.bodies[i].dynamic && !scene.fluid.present, fmt::format("bodies.{}.{}.dynamic", i, kind),
                    "a dynamic body in a scene without fluid", "false, or a scene with fluid");
  }
  for (std::size_t i = 0; i < scene.cloths.size(); ++i)
    for (std::size_t k = 0; k < scene.cloths[i].pins.size(); ++k)
      check_followed_body(s, scene, scene.cloths[i].pins[k].body, fmt::format("cloth.{}.pin.{}.body", i, k));
}

}  // namespace

void describe(Section& s, TimeScene& time) {
  s.one_line();
  s.number("step", time.step, "[1e-9, 1]", "s",
           "time step Δt; the longest one with `mode: cfl` or `error`; at most 10⁹ steps until `end`");
  s.number("end", time.end, "[1e-9, 1e6]", "s", "simulated time at which the run ends");
  s.choice("mode", time.mode, {{"fixed", TimeMode::fixed}, {"cfl", TimeMode::cfl}, {"error", TimeMode::error}},
           "`fixed`: every step has the length `step`, except one or two before a frame; `cfl`: as long as `cfl` "
           "allows; `error`: as long as the density error stays within `tolerance`");
  s.number("cfl", time.cfl, "[0.001, 1]", "1",
           "with `mode: cfl`, largest displacement of a particle per step, in spacings");
  s.number("tolerance", time.tolerance, "[1e-5, 0.1]", "1",
           "with `mode: error`, target for the mean compression per step; steps that add more than 2.5 times as much "
           "are repeated with a shorter Δt");
}

void describe(Section& s, FieldScene& field) {
  s.one_line();
  s.numbers("center", field.center, coordinate_range, "m", "centre c");
  s.required().numbers("rate", field.rate, "[0, 1000]", "1/s", "rate Ω along each axis; at least one above 0");
  check_not_zero(s, "rate", field.rate);
}

void describe(Section& s, GustScene& gust) {
  s.one_line();
  s.required().number("time", gust.time, "[0, 1e6]", "s", "time of the entry; later than the one before");
  s.required().numbers("velocity", gust.velocity, air_speed_range, "m/s",
                       "velocity added to the wind's `velocity` at that time");
}

void describe(Section& s, WindScene& wind) {
  s.numbers("velocity", wind.velocity, air_speed_range, "m/s", "velocity of the undisturbed air");
  s.list(
      "gusts", wind.gusts,
      "velocities added to the wind over time, linear between entries; the first applies before it, the last after it");
  s.number("density", wind.density, "[0, 100]", "kg/m³", "density ρ_a of the air");
  s.number("normal_drag", wind.normal_drag, "[0, 10]", "1",
           "drag coefficient C_n of cloth across the wind, both sides together");
  s.number("tangential_drag", wind.tangential_drag, "[0, 10]", "1",
           "drag coefficient C_t of cloth along the wind, both sides together");
  s.number("liquid_drag", wind.liquid_drag, "[0, 10]", "1",
           "drag coefficient C_l of free liquid; 0.47 for round drops, 0 for no drag");
  for (std::size_t i = 1; i < wind.gusts.size(); ++i)
    s.check(wind.gusts[i - 1].time < wind.gusts[i].time, fmt::format("gusts.{}.time", i),
            fmt::format("{} is not later than the previous entry ({}); allowed: a larger value, in s",
                        wind.gusts[i].time, wind.gusts[i - 1].time));
}

void describe(Section& s, RotatingFrameScene& frame) {
  s.numbers("axis", frame.axis, direction_range, "1", "direction of the axis; its length does not matter");
  s.numbers("center", frame.center, coordinate_range, "m", "a point of the axis");
  s.required().number("degrees_per_second", frame.degrees_per_second, "[-1e5, 1e5]", "degrees/s",
                      "rotation of the frame, by the right-hand rule");
  check_not_zero(s, "axis", frame.axis);
}

void describe(Section& s, AirScene& air) {
  const bool direct = air.evaporation_rate.has_value(), given = direct || air.transfer_coefficient;
  s.one_line();
  s.saved_if(!direct).number("humidity", air.humidity, "[0, 1]", "1", "relative humidity of the ambient air");
  s.saved_if(!direct).number("temperature", air.temperature, "[0, 60]", "°C",
                             "temperature of the air and of liquid, and of wet cloth unless `cooling` is true");
  s.saved_if(!given).number("speed", air.speed, "[0, 100]", "m/s",
                            "air speed along the wet surface; independent of `wind`, which exerts drag");
  s.saved_if(!given).number("length", air.length, "[0.001, 1000]", "m", "length of the wet surface along the air flow");
  s.number("transfer_coefficient", air.transfer_coefficient, "[0, 10]", "m/s",
           "mass transfer coefficient h_m at a wet surface; replaces `speed` and `length`");
  s.number("evaporation_rate", air.evaporation_rate, "[0, 100]", "kg/(m² s)",
           "evaporation rate j of a wet surface; replaces all other keys; 1 kg/(m² h) is 2.8e-4");
  s.saved_if(!direct).boolean(
      "cooling", air.cooling,
      "evaporation cools wet cloth, at most to the wet-bulb temperature, and the cloth dries more slowly");
  for (const char* key : {"speed", "length"})
    s.check(!s.has(key) || !air.transfer_coefficient, key,
            "cannot be combined with transfer_coefficient, which it would determine; allowed: one of the two");
  for (const char* key : {"humidity", "temperature", "speed", "length", "transfer_coefficient", "cooling"})
    s.check(!s.has(key) || !air.evaporation_rate, key,
            "cannot be combined with evaporation_rate, which it would determine; allowed: one of the two");
}

namespace {

void describe_point(Section& s, ProbeScene& probe) {
  s.one_line();
  s.required().numbers("position", probe.position, coordinate_range, "m", "position of the sensor");
  s.number("radius", probe.radius, "[0, 1000]", "m",
           "radius over which a sensor averages, if larger than the support radius of a particle");
}

void describe_line(Section& s, ProbeScene& probe) {
  s.one_line();
  s.required().numbers("from", probe.position, coordinate_range, "m", "end from which heights count");
  s.required().numbers("to", probe.end, coordinate_range, "m", "other end");
  s.check(probe.position != probe.end, "to", "is equal to from; allowed: another point");
}

void describe_disc(Section& s, ProbeScene& probe) {
  s.one_line();
  s.required().numbers("center", probe.position, coordinate_range, "m", "centre");
  s.required().numbers("normal", probe.normal, direction_range, "1",
                       "direction in which flux is positive; its length does not matter");
  s.required().number("radius", probe.radius, "[1e-9, 10000]", "m", "radius");
  check_not_zero(s, "normal", probe.normal);
}

}  // namespace

void describe(Section& s, ProbeScene& probe) {
  using Kind = ProbeScene::Kind;
  s.one_line();
  s.required().text("name", probe.name, "name of the columns, such as H1");
  s.one_of(probe.kind, Kind::point)
      .section("point", probe, describe_point, "pressure, velocity and share of liquid at a point; only with `fluid`");
  s.one_of(probe.kind, Kind::line)
      .section("line", probe, describe_line,
               "wave gauge: height and depth of the liquid along a line; only with `fluid`");
  s.one_of(probe.kind, Kind::disc)
      .section("disc", probe, describe_disc, "mass of liquid that passes through a disc; only with `fluid`");
  s.one_of(probe.kind, Kind::body).text("body", probe.of, "name of a body: force and torque on it");
  s.one_of(probe.kind, Kind::cloth)
      .text("cloth", probe.of, "name of a cloth: liquid in it, force of its pins and of contact");
}

void describe(Section& s, OutputScene& output) {
  s.one_line();
  s.number("every", output.every, "[0, 1e6]", "s",
           "time between frames; 0 for none; at most 10⁹ frames until `time.end`");
  s.number("checkpoint_every", output.checkpoint_every, "[0, 1e6]", "s",
           "time between checkpoints; 0 for none; at most 10⁹ checkpoints until `time.end`");
  s.boolean("measures", output.measures,
            "adds columns for particle clumping and the shape of the wet patch to `stats.csv`; increases run time");
  s.boolean("fabric", output.fabric,
            "adds columns for each porous cloth to `stats.csv`: absorbed liquid, wet area, and liquid absorbed and "
            "released on each face");
  s.number("wet_above", output.wet_above, "[1e-6, 1]", "1", "with `fabric`, saturation from which cloth counts as wet");
  s.boolean("surface", output.surface, "writes the liquid's surface as a mesh with every frame; only with `fluid`");
  s.number("surface_spacing", output.surface_spacing, "[0.25, 1]", "spacings",
           "lattice spacing of the surface mesh; time and number of triangles grow at least with the inverse square");
  s.choice("surface_kernel", output.surface_kernel,
           {{"isotropic", SurfaceKernel::isotropic}, {"anisotropic", SurfaceKernel::anisotropic}},
           "shape of a particle in the surface: a sphere, or an ellipsoid along the surface, which is smoother");
  s.boolean("fitted_pressure", output.fitted_pressure,
            "adds the field `fitted_pressure` to the liquid's frames: pressure without the scatter between particles");
  s.boolean("report", output.report, "writes `report.html` when the run ends, also if it fails");
  s.list("probes", output.probes, "probes, whose values are columns of `probes.csv`");
  s.number(
      "probe_every", output.probe_every, "[1e-9, 1e6]", "s",
      "time between rows of `probes.csv`; a row is written after the first step that reaches it; default: `every`");
  s.check(!s.has("probe_every") || !output.probes.empty(), "probe_every",
          "applies only to probes, and there are none; allowed: only with probes");
  s.check(output.probes.empty() || output.probe_every || output.every > 0, "probe_every",
          "is missing, and every is 0; allowed: [1e-9, 1e6] (s)");
}

void describe(Section& s, ProcessScene& processes) {
  s.one_line();
  s.on_off("direction", processes.direction, "flow directions; off: cloth absorbs and emits equally to all sides");
  s.on_off("saturation_control", processes.saturation_control,
           "absorption slows down as the cloth fills; off: constant rate");
  s.on_off("absorption", processes.absorption, "cloth absorbs liquid");
  s.on_off("emission", processes.emission, "cloth releases excess liquid");
  s.on_off("diffusion", processes.diffusion, "liquid spreads within cloth");
}

void describe(Section& s, Box& box) {
  s.one_line();
  s.required().numbers("min", box.min, coordinate_range, "m", "corner with the smallest x, y and z");
  s.required().numbers("max", box.max, coordinate_range, "m", "opposite corner, above `min` on each axis");
  for (std::size_t i = 0; i < 3; ++i) {
    s.check(box.min[i] < box.max[i], fmt::format("max.{}", i),
            fmt::format("{} is not above min ({}); allowed: more than min, in m", box.max[i], box.min[i]));
  }
}

void describe_coordinates(Section& s, LengthUnit& unit, UpAxis& up, bool saved) {
  s.saved_if(saved).choice("unit", unit,
                           {{"m", LengthUnit::m},
                            {"dm", LengthUnit::dm},
                            {"cm", LengthUnit::cm},
                            {"mm", LengthUnit::mm},
                            {"inch", LengthUnit::inch}},
                           "unit of the scaled coordinates");
  s.saved_if(saved).choice("up", up, {{"x", UpAxis::x}, {"y", UpAxis::y}, {"z", UpAxis::z}},
                           "upward axis of the file; the mesh is rotated so that it becomes y");
}

void describe_sequence(Section& s, SequenceScene& sequence, const char* meaning, SequenceOf of) {
  const bool saved = !sequence.files.empty(), moving_mesh = of == SequenceOf::moving_mesh;
  s.saved_if(saved);
  if (moving_mesh)
    s.moving_mesh("sequence", sequence.files, meaning);
  else if (of == SequenceOf::surfaces)
    s.mesh_files("sequence", sequence.files, meaning);
  else
    s.other_files("sequence", sequence.files, meaning);
  s.saved_if(saved && !sequence.has_times())
      .number("fps", sequence.fps, "[0.001, 1e5]", "1/s",
              moving_mesh ? "files of the `sequence` per second, the first at 0 s; frames per second of a .pc2 file; "
                            "not for a .mdd file, which has times"
                          : "files of the `sequence` per second; the first is at 0 s");
  s.check(s.has("sequence") || !s.has("fps"), "fps",
          "applies only to a sequence of files; allowed: only with sequence");
  s.check(!sequence.has_times() || !s.has("fps"), "fps",
          "cannot be combined with a .mdd file, which has the times of its samples; allowed: without fps");
  const bool caches = std::any_of(sequence.files.begin(), sequence.files.end(),
                                  [](const std::string& file) { return !point_cache_ending(file).empty(); });
  s.check(!moving_mesh || !caches || sequence.files.size() == 1, "sequence",
          "has a point cache among several files; allowed: one point cache, or mesh files");
}

void describe_moving_file(Section& s, std::string& file, SequenceScene& sequence, const char* file_meaning,
                          const char* meaning) {
  s.saved_if(sequence.files.empty() || sequence.is_cache()).mesh_file("file", file, file_meaning);
  describe_sequence(s, sequence, meaning);
  const bool both = s.has("file") && s.has("sequence");
  s.check(s.has("file") || s.has("sequence"), "file",
          "file and sequence are both missing; allowed: one of the two, or a mesh file and its point cache");
  s.check(!both || sequence.is_cache(), "sequence",
          "cannot be combined with file unless it is a point cache (.pc2, .mdd); allowed: one of the two");
  s.check(both || !sequence.is_cache(), "sequence",
          "is a point cache, which has no polygons; allowed: with file, the mesh whose points it moves");
  if (!sequence.files.empty() && !sequence.is_cache()) file = sequence.files.front();
}

void describe(Section& s, SpinScene& spin) {
  s.one_line();
  s.numbers("axis", spin.axis, direction_range, "1", "rotation axis; its length does not matter");
  s.number("degrees_per_second", spin.degrees_per_second, "[-1e5, 1e5]", "degrees/s", "by the right-hand rule");
  check_not_zero(s, "axis", spin.axis);
}

void describe(Section& s, Scene& scene) {
  s.required().integer("drench", scene.version, "[1, 1]", "(the format's version)", "version of the format");
  s.section("time", scene.time, "simulated time and time steps");
  s.remark("s");
  s.numbers("gravity", scene.gravity, "[-1000, 1000]", "m/s²", "acceleration of everything that moves");
  s.optional(scene.field.present)
      .section("field", scene.field,
               "acceleration of the liquid towards a centre, −Ω² (x − c) along each axis; only with `fluid`");
  s.remark("m, 1/s");
  s.optional(scene.wind.present).section("wind", scene.wind, "moving air: drag on cloth and optionally on free liquid");
  s.optional(scene.rotating_frame.present)
      .section("rotating_frame", scene.rotating_frame,
               "describes the scene in a rotating frame: centrifugal, Coriolis and Euler force on cloth and liquid");
  s.optional(scene.air.present)
      .section("air", scene.air,
               "evaporation of free liquid and of liquid in porous cloth; without this section nothing evaporates");
  s.section("domain", scene.domain,
            "box that contains the liquid; particles that leave it are removed, and their mass is recorded as drained");
  s.remark("m");
  s.section("output", scene.output, "output files and their intervals");
  s.remark("s");
  describe_preset(s, scene.processes);
  s.saved_if(has_porous(scene))
      .section("processes", scene.processes,
               "switches for the exchange between porous cloth and liquid; only with porous cloth");
  s.section("neighbors", scene, describe_neighbors, "neighbour search");
  s.optional(scene.fluid.present)
      .section("fluid", scene.fluid, "the liquid; without this section there are no particles");
  s.saved_if(!scene.cloths.empty())
      .section("cloth_solver", scene.cloth_solver, "solver settings for all cloths; only with `cloth`");
  s.list("cloth", scene.cloths, "cloths of the scene");
  s.list("bodies", scene.bodies, "solid bodies and containers of the scene");
  s.list("joints", scene.joints, "hinges of dynamic bodies");
  check_sections(s, scene);
  check_parts(s, scene);
}

}  // namespace drench
