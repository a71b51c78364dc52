#include "setup/first_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <utility>

#include "base/eigen_vec.hpp"
#include "scene/load.hpp"
#include "scene/sequence_names.hpp"
#include "setup/build.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/distance_field.hpp"
#include "setup/file_place.hpp"
#include "setup/forecast.hpp"
#include "setup/garment.hpp"
#include "setup/mesh_io.hpp"
#include "setup/worn.hpp"
#include "stages/substeps.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

constexpr double gravity = 9.81;  // m/s²
constexpr GridScene grid{{0.6, 0.6}, {31, 31}};
constexpr double solid_fraction = 0.6, water = 1000;       // 1, kg/m³
constexpr double bends[] = {1e-4, 1e-5, 1e-6, 0};          // N·m
constexpr double longest_steps[] = {0.004, 0.002, 0.001};  // s
constexpr double shortest_step = 2.5e-4;                   // s
constexpr double fastest_release = 0.25;                   // m/s: of nodes that start inside the body

/// Everything that the text below has a number for. SI units.
struct Suggestion {
  std::string mesh;  // "" for the grid
  std::string body;  // "" for none
  MeshPaths paths = MeshPaths::as_given;
  bool animated = false;  // it is a pattern of the names of several files, ...
  double body_rate = 24;  // ... so many of them per second
  MeshGuess body_guess;
  bool worn = false;               // the garment's shift puts it on the body
  bool pinned = true;              // false: the body holds it, or it falls onto the body
  std::vector<std::string> found;  // what the set-up says, as comments
  Garment garment;
  double spacing = 0, thickness = 0.001, bend = bends[0], step = longest_steps[0], every = 0.02, end = 1;
  bool self_collision = false;
  int settle = ClothScene{}.settle;
  Box domain;
  double radius = 0, jet_end = 0, jet_mass = 0, capacity = 0;
  Vec3 nozzle{0, 0, 0}, velocity{0, 0, 0};
};

/// To so many significant digits.
double neat(double x, int digits = 2) {
  if (x == 0) return 0;
  const double unit = std::pow(10, std::floor(std::log10(std::abs(x))) - digits + 1);
  return std::stod(fmt::format("{:.{}g}", std::round(x / unit) * unit, digits + 2));
}

double outward(double x, double unit, bool up) {
  return (up ? std::ceil(x / unit - 1e-9) : std::floor(x / unit + 1e-9)) * unit;
}

std::string list(const Vec3& v) { return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v[0] + 0.0, v[1] + 0.0, v[2] + 0.0); }

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

void choose_fabric(Suggestion& s, std::vector<std::string>& warnings) {
  s.spacing = neat(std::clamp(0.5 * s.garment.edge, s.garment.size / 150, s.garment.size / 40));
  s.capacity = s.garment.area * s.thickness * (1 - solid_fraction) * water;
  if (s.garment.flat) return;  // it does not fold onto itself at first
  s.self_collision = true;
  if (const double thickest = 0.45 * s.garment.least_height; thickest < s.thickness) {
    const double thinner = neat(0.95 * thickest);
    if (thinner >= 2e-4) {
      s.thickness = thinner;
    } else {
      s.self_collision = false;
      warnings.push_back(fmt::format(
          "{}: its smallest triangle is {:.2g} m high, too small for cloth of {} m that collides with itself: "
          "self_collision is off; it requires a mesh with more regular triangles",
          s.mesh, s.garment.least_height, s.thickness));
    }
  }
  s.capacity = s.garment.area * s.thickness * (1 - solid_fraction) * water;
}

/// Distance (m) of a point to the body, negative inside it; empty without a body.
using BodyDistance = std::function<double(const Vec3&)>;

/// A point of a sheet, and how far above it the nozzle is, such that the jet does not begin in the body or hit it
/// before the sheet: the middle and 0.25 of the size if possible.
std::pair<Vec3, double> place_above_sheet(const Suggestion& s, const BodyDistance& to_body) {
  const Garment& g = s.garment;
  const double usual = 0.25 * g.size, room = s.radius + s.spacing;
  const Vector3d low = to_eigen(g.box.min), sides = to_eigen(g.box.max) - low;
  const auto point = [&](double along_x, double along_z) {
    return Vec3{low[0] + along_x * sides[0], g.box.max[1], low[2] + along_z * sides[2]};
  };
  const auto is_free = [&](Vec3 x, double reach) {
    for (const double bottom = x[1] + room; to_body && x[1] <= bottom - room + reach; x[1] += 0.5 * room)
      if (x[1] >= bottom && to_body(x) < room) return false;
    return true;
  };
  for (const double off : {0.0, 0.2, 0.3})
    for (const auto& [x, z] : {std::pair{0.0, -1.0}, {0.0, 1.0}, {-1.0, 0.0}, {1.0, 0.0}, {-1.0, -1.0}, {1.0, 1.0}})
      if (is_free(point(0.5 + off * x, 0.5 + off * z), usual)) return {point(0.5 + off * x, 0.5 + off * z), usual};
  double reach = usual;  // the body is everywhere: above it
  const Vec3 middle = point(0.5, 0.5);
  while (reach < 100 * g.size && to_body({middle[0], middle[1] + reach, middle[2]}) < room) reach += room;
  return {middle, reach};
}

/// A nozzle above a garment that lies, or above and before one that hangs; its jet meets the front.
void choose_jet(Suggestion& s, const BodyDistance& to_body = {}) {
  const Garment& g = s.garment;
  const double top = g.box.max[1];
  double reach = 0.25 * g.size;
  s.radius = neat(std::max(2.5 * s.spacing, 0.04 * g.size));
  double flight = 0;  // s, until the water is there
  if (g.flat) {
    const double speed = neat(std::sqrt(gravity * g.size) / 3);
    const auto [target, above] = place_above_sheet(s, to_body);
    reach = above;
    s.nozzle = {neat(target[0], 3), neat(top + reach, 3), neat(target[2], 3)};
    s.velocity = {0, -speed, 0};
    flight = (std::sqrt(speed * speed + 2 * gravity * reach) - speed) / gravity;
  } else {
    const auto front = static_cast<std::size_t>(front_axis(g));
    Vec3 target = front_point(g, g.box.min[1] + 0.45 * (top - g.box.min[1]));
    target[front] -= 0.3 * (g.box.max[front] - g.box.min[front]);  // the front falls back as the garment begins to hang
    constexpr double farthest = 4;                                 // of the usual distance, where a body is in the way
    do {
      s.nozzle = target;
      s.nozzle[1] = top + 0.05 * g.size;
      s.nozzle[front] = g.box.max[front] + reach;
      for (double& x : s.nozzle) x = neat(x, 3);
      reach += 0.25 * g.size;
    } while (to_body && to_body(s.nozzle) < s.radius + s.spacing && reach <= farthest * 0.25 * g.size);
    // In 0.7 of the time of free fall, so that the jet does not fall apart on its way.
    const double height = s.nozzle[1] - target[1];
    flight = 0.7 * std::sqrt(2 * height / gravity);
    s.velocity[1] = -neat(height / flight - 0.5 * gravity * flight);
    s.velocity[front] = -neat((s.nozzle[front] - target[front]) / flight);
  }
  const double speed = to_eigen(s.velocity).norm(), rate = std::numbers::pi * s.radius * s.radius * speed * water;
  s.jet_end = neat(std::clamp(2 * s.capacity / rate, 0.3, 1.0));
  s.jet_mass = rate * s.jet_end;
  s.end = outward(s.jet_end + flight + 0.5, 0.1, true);
  s.every = g.size < 0.4 ? 0.01 : 0.02;
}

void choose_domain(Suggestion& s) {
  const Garment& g = s.garment;
  const double margin = 0.4 * g.size, unit = std::pow(10, std::floor(std::log10(g.size)) - 1);
  for (std::size_t a = 0; a < 3; ++a) {
    const double room = s.radius + 4 * s.spacing;
    s.domain.min[a] = outward(std::min(g.box.min[a] - margin, s.nozzle[a] - room), unit, false);
    s.domain.max[a] = outward(std::max(g.box.max[a] + (a == 1 ? 0 : margin), s.nozzle[a] + room), unit, true);
  }
}

std::string pin_line(const Suggestion& s) {
  const Garment& g = s.garment;
  if (g.flat && g.open) return "    pin: [{edges: true}]              # held at its edges; without pins it falls\n";
  const Box band = top_band(g);
  const double unit = std::pow(10, std::floor(std::log10(g.size)) - 3);
  Box box = band;
  for (std::size_t a = 0; a < 3; ++a) {
    box.min[a] = outward(band.min[a], unit, false);
    box.max[a] = outward(band.max[a], unit, true);
  }
  return fmt::format("    pin: [{{box: {{min: {}, max: {}}}}}]   # m; held at its highest points\n", list(box.min),
                     list(box.max));
}

/// ", unit: cm, up: z" as far as they are not the defaults.
std::string coordinates(const MeshGuess& guess) {
  std::string keys;
  if (guess.unit != LengthUnit::m) keys += fmt::format(", unit: {}", name_of(guess.unit));
  if (guess.up != UpAxis::y) keys += fmt::format(", up: {}", name_of(guess.up));
  return keys;
}

/// "; unit: it is 90 units long; up: …"
std::string reasons(const MeshGuess& guess) {
  std::string text;
  if (!guess.unit_reason.empty()) text += "; unit: " + guess.unit_reason;
  if (!guess.up_reason.empty()) text += "; up: " + guess.up_reason;
  return text;
}

/// The quoted name of a file in the scene.
std::string written(const Suggestion& s, const std::string& file) {
  return quoted(s.paths == MeshPaths::absolute ? std::filesystem::absolute(file).string() : file);
}

const char* kind_of_path(const Suggestion& s, const std::string& file) {
  const bool absolute = s.paths == MeshPaths::absolute || std::filesystem::path(file).is_absolute();
  return absolute ? "absolute path" : "relative to the folder of this file";
}

std::string mesh_lines(const Suggestion& s) {
  const Garment& g = s.garment;
  if (s.mesh.empty())
    return fmt::format("    mesh: {{grid: {{size: [{}, {}], nodes: [{}, {}]}}}}   # m; or {{file: garment.obj}}\n",
                       grid.size[0], grid.size[1], grid.nodes[0], grid.nodes[1]);
  std::string lines = fmt::format("    mesh: {{file: {}{}}}   # {}{}\n", written(s, s.mesh), coordinates(g.guess),
                                  kind_of_path(s, s.mesh), reasons(g.guess));
  if (g.shift != Vec3{0, 0, 0})
    lines += fmt::format("    place: {{position: {}}}   # m; moves it {}\n", list(g.shift),
                         s.worn ? "onto the body" : "to the origin, where rounding is smallest");
  return lines;
}

std::string body_lines(const Suggestion& s) {
  if (s.body.empty())
    return fmt::format(
        "# bodies:                             # a floor, so that it does not fall out of the domain\n"
        "#   - plane: {{point: [0, {:.6g}, 0], normal: [0, 1, 0]}}   # m\n",
        s.domain.min[1] + 0.1 * s.garment.size);
  const std::string motion = s.animated ? fmt::format(", fps: {:.9g}", s.body_rate) : "";
  return fmt::format("bodies:\n  - mesh: {{{}: {}{}{}}}   # {}{}\n", s.animated ? "sequence" : "file",
                     written(s, s.body), motion, coordinates(s.body_guess), kind_of_path(s, s.body),
                     reasons(s.body_guess));
}

std::string head(const Suggestion& s) {
  const Garment& g = s.garment;
  const Vector3d sides = to_eigen(g.box.max) - to_eigen(g.box.min);
  std::string text =
      fmt::format("# A first scene for {}, by drench new. SI units: m, s, kg. Every key: drench schema\n#\n",
                  s.mesh.empty() ? "a square cloth" : s.mesh);
  if (!g.unit_warning.empty()) text += fmt::format("# {}.\n#\n", g.unit_warning);
  for (const std::string& line : s.found) text += fmt::format("# {}.\n", line);
  if (!s.found.empty()) text += "#\n";
  return text + fmt::format(
                    "# {:.3g} × {:.3g} × {:.3g} m, {} points, {} triangles, edges of {:.2g} m. It holds {:.2g} "
                    "kg of water.\n"
                    "# What to expect: {:.2g} kg of water {}; the cloth darkens where it is wet, and drips.\n"
                    "# drench check prints the size of a run; half the spacing takes about 16 times as long.\n",
                    sides[0], sides[1], sides[2], g.mesh.points.size(), g.mesh.triangles.size(), g.edge, s.capacity,
                    s.jet_mass, g.flat ? "falls on its middle" : "hits its front");
}

/// `with_body`: false to measure the cloth alone, which is faster.
std::string text_of(const Suggestion& s, bool with_body = true) {
  std::string text = head(s);
  text += fmt::format(
      "drench: 1                             # version of the format\n"
      "time: {{step: {}, end: {:.6g}, mode: cfl}}   # s; step: longest step at which the cloth converges; fast water "
      "shortens steps\n"
      "gravity: [0, -9.81, 0]                # m/s²; y is up\n"
      "domain: {{min: {}, max: {}}}   # m; water that leaves it is drained\n"
      "output: {{every: {}, surface: true}}   # s between frames; also writes the surface of the liquid\n",
      s.step, s.end, list(s.domain.min), list(s.domain.max), s.every);
  text += fmt::format(
      "fluid:\n"
      "  spacing: {}                      # m; particle diameter; the cloth's edges are {:.1f} times as long, 1 to 2 "
      "is "
      "best\n"
      "  density: 1000                       # kg/m³; water\n"
      "  viscosity: 1.0e-4                   # m²/s; water has 1e-6; a larger value calms splashes at this spacing\n"
      "  sources:\n"
      "    - jet: {{center: {}, radius: {}, velocity: {}, end: {}}}   # m, m, m/s, s; {:.1f} times what the cloth "
      "can hold\n",
      s.spacing, s.garment.edge / s.spacing, list(s.nozzle), s.radius, list(s.velocity), s.jet_end,
      s.jet_mass / s.capacity);
  text += "cloth:\n  - name: " + std::string(s.mesh.empty() ? "sheet" : "garment") + "\n" + mesh_lines(s);
  text += fmt::format(
      "    areal_density: 0.2                # kg/m², 200 g/m²; cotton shirt 0.15, towel 0.4\n"
      "    thickness: {}                  # m; with solid_fraction it determines how much water the fabric holds\n"
      "    stretch: 500                      # N/m; tensile stiffness\n"
      "    bend: {:<28} # N·m; bending stiffness: limp fabric 1e-5, stiff 1e-3\n"
      "    damping: 1.0                      # 1/s; damping of the motion, as by air\n"
      "    friction: 0.4                     # 1; of dry fabric, on bodies and on itself\n"
      "    friction_wet: 1.0                 # 1; wet fabric clings\n",
      s.thickness, s.bend > 0 ? fmt::format("{:.1e}", s.bend) : "0");
  if (s.pinned) text += pin_line(s);
  text += fmt::format("    self_collision: {}\n",
                      s.self_collision ? "true              # front and back do not pass through each other; costs time"
                                       : "false             # true for cloth that folds onto itself; costs time");
  if (s.settle != ClothScene{}.settle)
    text += fmt::format("    settle: {:<25} # 1; steps over which nodes come out of the body, at most {} m/s fast\n",
                        s.settle, fastest_release);
  text += fmt::format(
      "    porous:                           # without this section the cloth absorbs nothing\n"
      "      solid_fraction: {}             # 1; fraction of the volume that is fibre; the rest holds water\n"
      "      absorption: 0.02                # m²/s; how fast dry fabric absorbs water\n"
      "      film: 3.0e-4                    # m; water that each face of soaked fabric carries; it runs down and "
      "drips\n"
      "      film_viscosity: 1.0e-6          # m²/s; of water\n"
      "      diffusivity: 1.0e-4             # m²/s; how fast water spreads within the fabric\n"
      "      capillary_height: 0.3           # m; equilibrium wicking height\n",
      solid_fraction);
  if (with_body || s.body.empty()) text += body_lines(s);
  return text;
}

/// The path that a scene in the working folder would have: meshes are looked for beside it.
constexpr const char* scene_path = "scene.yaml";

/// Sets the scene up. Without self-collision where the mesh passes through itself, which it must not at the start.
Setup set_up(Suggestion& s, std::vector<std::string>& warnings) {
  try {
    return build(parse_scene(text_of(s, false), scene_path));
  } catch (const SetupError& error) {
    if (!s.self_collision) throw;
    s.self_collision = false;
    Setup setup = build(parse_scene(text_of(s, false), scene_path));
    warnings.push_back(fmt::format("self_collision is off: {}", error.what()));
    return setup;
  }
}

/// The longest step, and the limper fabric where that is not enough, that the cloth's solver and its diffusion take
/// well. A mesh with slivers has none; then the set-up's own warning says so.
void choose_step(Suggestion& s, std::vector<std::string>& warnings) {
  for (const double bend : bends) {
    s.bend = bend;
    const Setup setup = set_up(s, warnings);
    const Model& m = setup.model;
    for (const double step : longest_steps) {
      s.step = step;
      const double passes = substeps_for(diffusion_rate(m, m.cloths[0]), step),
                   most = m.scene.cloth_solver.max_iterations;
      if (cloth_iterations(m, m.cloths[0], step).count <= 0.9 * most && passes <= 20) return;
    }
  }
}

/// Gives nodes that start deep inside the body more steps to come out where steps are short, so that they are not
/// thrown. Has it changed anything?
bool slow_down_release(Suggestion& s, const Setup& setup) {
  const double way = setup.deepest_inside + s.thickness;
  const int needed = static_cast<int>(std::ceil(way / (fastest_release * s.step)));
  if (setup.deepest_inside == 0 || needed <= s.settle) return false;
  s.settle = needed;
  return true;
}

/// The first steps for real; where one does not converge, half the step, and a limper fabric where that is too short.
void try_steps(Suggestion& s, const TrySteps& trial, std::vector<std::string>& warnings) {
  const double step = s.step, bend = s.bend;
  const auto converges = [&](double with_step, double with_bend) {
    s.step = with_step;
    s.bend = with_bend;
    return trial(parse_scene(text_of(s), scene_path));
  };
  if (converges(step, bend)) return;
  // Where even the extremes fail, nothing between them is tried: a trial that fails takes the longest.
  double shortest = step;
  while (shortest / 2 >= shortest_step) shortest /= 2;
  bool found = false;
  if (shortest < step && converges(shortest, bend)) {
    for (double half = step / 2; half > shortest && !found; half /= 2) found = converges(half, bend);
    if (!found) s.step = shortest;
    found = true;
  } else if (bend > 0 && converges(0.25 * step, 0)) {
    for (const double limper : bends)
      for (const double part : {1.0, 0.25})
        if (limper < bend && !found) found = converges(part * step, limper);
  }
  if (!found) {
    s.step = step;
    s.bend = bend;
    warnings.push_back(fmt::format(
        "the first steps of the cloth do not converge, not even with a time.step of {:g} s or without bending "
        "stiffness; use a mesh with more regular triangles{}",
        shortest, s.body.empty() ? "" : ", or place it so that it does not intersect the body"));
    return;
  }
  s.found.push_back(
      fmt::format("With a step of {} s and bend {:.2g} the first steps do not converge; with {} s and {:.2g} they do",
                  step, bend, s.step, s.bend));
  warnings.push_back(s.found.back());
}

/// The garment of the suggestion, and the first of the body's files.
std::string measure(Suggestion& s, FirstScene& result) {
  SurfaceMesh mesh = s.mesh.empty() ? grid_mesh(grid) : read_mesh(s.mesh, scene_path);
  const std::string label = s.mesh.empty() ? "the grid" : s.mesh;
  const bool with_body = !s.body.empty();
  MeshGuess guess = s.mesh.empty() ? MeshGuess{} : guess_of(bounds_of(mesh.points));
  std::string first;
  if (with_body) {
    const std::vector<std::string> files = sequence_names(s.body, "");
    if (files.empty()) throw SetupError(fmt::format("mesh files '{}': no such files", s.body));
    s.animated = files.size() > 1 || files.front() != s.body;
    first = files.front();
    const Box box = bounds_of(read_mesh(first, scene_path).points);
    s.body_guess = guess_of(box);
    if (!s.mesh.empty()) guess = guess_beside(bounds_of(mesh.points), box, s.body_guess);
  }
  s.garment = measure_garment(std::move(mesh), label, guess, with_body);
  if (!s.garment.unit_warning.empty()) result.warnings.push_back(s.garment.unit_warning);
  return first;
}

/// The scene of the suggestion with the first of the body's files at rest.
Setup beside_body_at_rest(const Suggestion& s, const std::string& body_file) {
  Suggestion still = s;
  still.body = body_file;
  still.animated = still.pinned = still.self_collision = false;
  return build(parse_scene(text_of(still), scene_path));
}

/// A garment whose file has another origin than the body's is moved to where the body wears it.
bool put_on(Suggestion& s, const Body& body) {
  if (body.field.empty() || s.garment.flat) return false;
  const std::optional<WornPlace> place = find_worn_place(s.garment, body);
  if (!place) return false;
  const double unit = std::pow(10, std::floor(std::log10(s.garment.size)) - 3);  // 0.1 to 1 thousandth of its size
  for (std::size_t a = 0; a < 3; ++a) s.garment.shift[a] = std::round(place->shift[a] / unit) * unit;
  s.worn = true;
  for (Vec3& x : s.garment.mesh.points) x = to_vec3(to_eigen(x) + to_eigen(s.garment.shift));
  s.garment.box = bounds_of(s.garment.mesh.points);
  s.found.push_back(fmt::format(
      "The garment and the body have different origins: moved by {} m, after which {:.2g} % of its nodes are "
      "inside the body. Delete place to undo it",
      list(s.garment.shift), 100 * place->inside));
  choose_jet(s);
  choose_domain(s);
  return true;
}

/// Puts the garment on the body and the nozzle where the body is not, and decides by what holds the garment. An
/// animated body counts as its first file.
void place_with_body(Suggestion& s, const std::string& body_file) {
  Setup setup = beside_body_at_rest(s, body_file);
  if (put_on(s, setup.model.bodies.front())) setup = beside_body_at_rest(s, body_file);
  const Body& body = setup.model.bodies.front();
  if (!body.field.empty()) choose_jet(s, exact_distance(body));
  const bool sheet = s.garment.flat && s.garment.open, around_it = surrounds(s.garment, body.mesh_points),
             falls = falls_freely(setup.model, setup.model.cloths.front());
  s.pinned = falls || (!sheet && !around_it);
  const char* pins = sheet ? "its edges" : "its highest points";
  s.found.push_back(
      !s.pinned && around_it ? "The body is inside the garment and holds it, so there are no pins"
      : !s.pinned            ? "The cloth falls onto the body, so there are no pins"
      : around_it ? fmt::format("The body is inside the garment but does not hold it, so it is pinned at {}", pins)
      : sheet ? fmt::format("The body is not under the cloth, which would fall past it, so it is pinned at {}", pins)
              : "No part of the body is inside the garment, which is held at its highest points");
}

}  // namespace

FirstScene first_scene(const std::string& mesh, const std::string& body, const TrySteps& trial, MeshPaths paths,
                       double body_rate) {
  FirstScene result;
  Suggestion s;
  s.body_rate = body_rate;
  s.paths = paths;
  s.mesh = mesh;
  s.body = body;
  const std::string body_file = measure(s, result);
  choose_fabric(s, result.warnings);
  choose_jet(s);
  choose_domain(s);
  if (!body.empty()) {
    place_with_body(s, body_file);
    choose_domain(s);
  }
  choose_step(s, result.warnings);
  if (s.bend < bends[0])
    result.warnings.push_back(
        fmt::format("{}: its smallest triangle is {:.2g} m high and its edges are {:.2g} m: bend is {}, because the "
                    "solve for a stiffer fabric may not converge; a mesh with more regular triangles allows more",
                    mesh, s.garment.least_height, s.garment.edge, s.bend));
  if (trial) try_steps(s, trial, result.warnings);
  Setup setup = build(parse_scene(text_of(s), scene_path));
  if (slow_down_release(s, setup)) setup = build(parse_scene(text_of(s), scene_path));
  s.found.insert(s.found.end(), setup.notes.begin(), setup.notes.end());
  s.found.insert(s.found.end(), setup.warnings.begin(), setup.warnings.end());
  result.yaml = text_of(s);
  result.warnings.insert(result.warnings.end(), setup.warnings.begin(), setup.warnings.end());
  return result;
}

}  // namespace drench
