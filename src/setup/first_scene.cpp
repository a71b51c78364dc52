#include "setup/first_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <utility>

#include "base/eigen_vec.hpp"
#include "scene/fabric_file.hpp"
#include "scene/load.hpp"
#include "scene/nearest_word.hpp"
#include "scene/sequence_names.hpp"
#include "setup/body_fields.hpp"
#include "setup/build.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/cloth_warp.hpp"
#include "setup/distance_field.hpp"
#include "setup/file_place.hpp"
#include "setup/forecast.hpp"
#include "setup/garment.hpp"
#include "setup/mesh_io.hpp"
#include "setup/suggestion.hpp"
#include "setup/worn.hpp"
#include "stages/substeps.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

constexpr double gravity = 9.81;                           // m/s²
constexpr double water = 1000;                             // kg/m³
constexpr double bends[] = {1e-4, 1e-5, 1e-6, 0};          // N·m
constexpr double longest_steps[] = {0.004, 0.002, 0.001};  // s
constexpr double shortest_step = 2.5e-4;                   // s

/// To so many significant digits.
double neat(double x, int digits = 2) {
  if (x == 0) return 0;
  const double unit = std::pow(10, std::floor(std::log10(std::abs(x))) - digits + 1);
  return std::stod(fmt::format("{:.{}g}", std::round(x / unit) * unit, digits + 2));
}

/// The path that a scene in the working folder would have: meshes are looked for beside it.
constexpr const char* scene_path = "scene.yaml";

/// The warp where the fabric knows it from the weft and the file has no texture coordinates that give it: upright, or
/// along a cloth that lies.
void choose_warp(Suggestion& s, const ClothScene& cloth) {
  const auto file_gives_it = [&] {
    try {
      return texture_gives_warp(read_mesh(s.mesh, scene_path, {.texture = true}));
    } catch (const SetupError&) {
      return false;  // its texture coordinates cannot be read
    }
  };
  if (s.mesh.empty() || !needs_warp(cloth) || file_gives_it()) return;
  for (const Vec3& upright : {Vec3{0, 1, 0}, Vec3{0.1, 1, 0.2}, Vec3{0.2, 1, -0.3}}) {
    s.warp = s.garment.flat ? Vec3{upright[0], upright[2], upright[1]} : upright;
    if (!lies_across(s.garment.mesh, *s.warp)) return;
  }
}

/// What the fabric's name stands for.
void read_fabric(Suggestion& s) {
  if (s.fabric.empty()) return;
  std::error_code unknown;
  const std::filesystem::file_type type = std::filesystem::status(s.fabric, unknown).type();
  const auto refuse = [&](const char* what) {
    throw SetupError(fmt::format("fabric file '{}': {}; allowed: a file .yaml or .yml", s.fabric, what));
  };
  if (is_fabric_file(s.fabric)) {
    if (type == std::filesystem::file_type::not_found) refuse("there is no such file");
    if (type == std::filesystem::file_type::directory) refuse("it is a folder");
  } else if (!fabric_named(s.fabric)) {
    if (type != std::filesystem::file_type::not_found) refuse("unknown extension");
    const std::vector<std::string> names = fabric_names();
    const std::string near = nearest_word(s.fabric, names);
    throw SetupError(fmt::format("there is no fabric '{}'; {}", s.fabric,
                                 near.empty() ? fmt::format("allowed: a .yaml file, or {}", fmt::join(names, ", "))
                                              : fmt::format("did you mean '{}'?", near)));
  }
  const std::string alone = fmt::format(
      "drench: 1\n"
      "time: {{step: 1.0e-3, end: 1}}\n"
      "domain: {{min: [0, 0, 0], max: [1, 1, 1]}}\n"
      "fluid: {{spacing: 0.1}}\n"
      "cloth: [{{mesh: {{grid: {{size: [1, 1], nodes: [2, 2]}}}}, fabric: {}, porous: {{}}}}]\n",
      in_quotes(s.fabric));
  const ClothScene cloth = parse_scene(alone, scene_path).cloths.front();
  s.thickness = cloth.material.thickness;
  s.solid_fraction = cloth.material.solid_fraction;
  choose_warp(s, cloth);
}

void choose_fabric(Suggestion& s, std::vector<std::string>& warnings) {
  s.spacing = neat(std::clamp(0.5 * s.garment.edge, s.garment.size / 150, s.garment.size / 40));
  const auto hold_water = [&] { s.capacity = s.garment.area * s.thickness * (1 - s.solid_fraction) * water; };
  hold_water();
  if (s.garment.flat) return;  // it does not fold onto itself at first
  s.self_collision = true;
  if (const double thickest = 0.45 * s.garment.least_height; thickest < s.thickness) {
    const double thinner = neat(0.95 * thickest);
    if (thinner >= 2e-4) {
      s.whole_thickness = s.thickness;
      s.thickness = thinner;
    } else {
      s.self_collision = false;
      warnings.push_back(fmt::format(
          "{}: its smallest triangle is {:.2g} m high, too small for cloth of {} m that collides with itself: "
          "self_collision is off; it requires a mesh with more regular triangles",
          s.mesh, s.garment.least_height, s.thickness));
    }
  }
  hold_water();
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
    const Vec3 middle = front_point(g, g.box.min[1] + 0.45 * (top - g.box.min[1]));
    constexpr double farthest = 4;  // of the usual distance, where a body is in the way
    Vec3 target = middle;
    std::size_t axis = front;
    // Puts the nozzle on one side. False: the body is in its way at all distances.
    const auto aim = [&](std::size_t along, double side) {
      axis = along;
      const double low = g.box.min[axis], high = g.box.max[axis];
      target = middle;
      if (axis != front) target[front] = 0.5 * (g.box.min[front] + g.box.max[front]);
      if (axis != front || side < 0) target[axis] = side > 0 ? high : low;
      target[axis] -= side * 0.3 * (high - low);  // it falls back as the garment begins to hang
      for (double away = reach; away <= farthest * reach; away += reach) {
        s.nozzle = target;
        s.nozzle[1] = top + 0.05 * g.size;
        s.nozzle[axis] = (side > 0 ? high : low) + side * away;
        for (double& x : s.nozzle) x = neat(x, 3);
        if (!to_body || to_body(s.nozzle) >= s.radius + s.spacing) return true;
      }
      return false;
    };
    if (!aim(front, 1) && !aim(front, -1) && !aim(2 - front, 1) && !aim(2 - front, -1)) aim(front, 1);
    // In 0.7 of the time of free fall, so that the jet does not fall apart on its way.
    const double height = s.nozzle[1] - target[1];
    flight = 0.7 * std::sqrt(2 * height / gravity);
    s.velocity = {0, -neat(height / flight - 0.5 * gravity * flight), 0};
    s.velocity[axis] = -neat((s.nozzle[axis] - target[axis]) / flight);
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

/// A scene as text, set up without regard to memory.
Setup build_text(const std::string& yaml, FilledBodies& filled) {
  return build(parse_scene(yaml, scene_path), {}, &filled);
}

/// Sets the scene up. Without self-collision where the mesh passes through itself, which it must not at the start.
Setup set_up(Suggestion& s, std::vector<std::string>& warnings, FilledBodies& filled) {
  try {
    return build_text(text_of(s, false), filled);
  } catch (const SetupError& error) {
    if (!s.self_collision) throw;
    s.self_collision = false;
    if (s.whole_thickness > 0) {
      s.capacity *= s.whole_thickness / s.thickness;
      s.thickness = std::exchange(s.whole_thickness, 0.0);
    }
    Setup setup = build_text(text_of(s, false), filled);
    warnings.push_back(fmt::format("self_collision is off: {}", error.what()));
    return setup;
  }
}

/// The longest step, and the limper fabric where that is not enough, that the cloth's solver and its diffusion take
/// well. A mesh with slivers has none; then the set-up's own warning says so.
void choose_step(Suggestion& s, std::vector<std::string>& warnings, FilledBodies& filled) {
  for (const double bend : bends) {
    s.bend = bend;
    const Setup setup = set_up(s, warnings, filled);
    const Model& m = setup.model;
    for (const double step : longest_steps) {
      s.step = step;
      const double passes = substeps_for(diffusion_rate(m, m.cloths[0]), step),
                   most = m.scene.cloth_solver.max_iterations;
      if (cloth_iterations(m, m.cloths[0], step).count <= 0.9 * most && passes <= 20) return;
    }
    if (!s.fabric.empty()) return;
  }
}

/// Over how many steps nodes that start up to `deepest` (m) inside the body come out: more where steps are short, so
/// that they are not thrown.
int settle_for(const Suggestion& s, double deepest) {
  if (deepest == 0) return ClothScene{}.settle;
  const double steps = (deepest + s.thickness) / (fastest_release * s.step);
  return std::max(ClothScene{}.settle, static_cast<int>(std::ceil(steps)));
}

/// The first steps for real; where one does not converge, half the step, and a limper fabric where that is too short.
/// `deepest`: how deep nodes start inside the body, m.
void try_steps(Suggestion& s, double deepest, const TrySteps& trial, std::vector<std::string>& warnings,
               FilledBodies& filled) {
  const double step = s.step, bend = s.bend;
  const auto converges = [&](double with_step, double with_bend) {
    s.step = with_step;
    s.bend = with_bend;
    s.settle = settle_for(s, deepest);
    return trial(parse_scene(text_of(s), scene_path), filled);
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
  } else if (s.fabric.empty() && bend > 0 && converges(0.25 * step, 0)) {
    for (const double limper : bends)
      for (const double part : {1.0, 0.25})
        if (limper < bend && !found) found = converges(part * step, limper);
  }
  if (!found) {
    s.step = step;
    s.bend = bend;
    warnings.push_back(
        fmt::format("the first steps of the cloth do not converge well, not even with a time.step of {:g} s{}; use a "
                    "mesh with more regular triangles{}",
                    shortest, s.fabric.empty() ? " or without bending stiffness" : "",
                    s.body.empty() ? "" : ", or place it so that it does not intersect the body"));
    return;
  }
  const auto choice = [&](double with_step, double with_bend) {
    return fmt::format("{} s{}", with_step, s.fabric.empty() ? fmt::format(" and bend {:.2g}", with_bend) : "");
  };
  s.found.push_back(fmt::format("With a step of {} the first steps do not converge well; with {} they do",
                                choice(step, bend), choice(s.step, s.bend)));
  warnings.push_back(s.found.back());
}

/// The garment of the suggestion, and the first of the body's files.
std::string measure(Suggestion& s, FirstScene& result) {
  SurfaceMesh mesh = s.mesh.empty() ? grid_mesh(suggested_grid) : read_mesh(s.mesh, scene_path);
  const std::string label = s.mesh.empty() ? "the grid" : s.mesh;
  const bool with_body = !s.body.empty();
  MeshGuess guess = s.mesh.empty() ? MeshGuess{} : guess_of(bounds_of(mesh.points));
  std::string first;
  if (with_body) {
    const auto [files, problem] = sequence_names(s.body, "");
    if (!problem.empty()) throw SetupError(fmt::format("mesh files '{}' {}", s.body, problem));
    if (files.empty()) throw SetupError(fmt::format("mesh files '{}': no such files", s.body));
    s.animated = files.size() > 1 || files.front() != s.body;
    first = files.front();
    const Box box = bounds_of(read_mesh(first, scene_path).points);
    s.body_guess = guess_of_body(box);
    check_guess(box, s.body_guess, first);
    if (!s.mesh.empty()) guess = guess_beside(bounds_of(mesh.points), box, s.body_guess);
  }
  if (!s.mesh.empty()) check_guess(bounds_of(mesh.points), guess, label);
  s.points = mesh;
  s.garment = measure_garment(std::move(mesh), label, guess, with_body);
  if (!s.garment.unit_warning.empty()) result.warnings.push_back(s.garment.unit_warning);
  return first;
}

/// The scene of the suggestion with the first of the body's files at rest.
Setup beside_body_at_rest(const Suggestion& s, const std::string& body_file, FilledBodies& filled) {
  Suggestion still = s;
  still.body = body_file;
  still.animated = still.pinned = still.self_collision = false;
  return build_text(text_of(still), filled);
}

/// Turns and moves a garment to where the body wears it. Has it changed anything?
bool put_on(Suggestion& s, const Body& body) {
  if (body.field.empty() || s.garment.flat) return false;
  const std::optional<Fitting> fitting = fit_to(s.garment, s.points, s.mesh, body);
  if (!fitting) return false;
  const UpAxis before = s.garment.guess.up;
  s.garment = fitting->garment;
  if (fitting->moved) {
    const double unit = std::pow(10, std::floor(std::log10(s.garment.size)) - 3);  // 0.1 to 1 thousandth of its size
    for (std::size_t a = 0; a < 3; ++a) s.garment.shift[a] = std::round(fitting->moved->shift[a] / unit) * unit;
    s.worn = true;
    for (Vec3& x : s.garment.mesh.points) x = to_vec3(to_eigen(x) + to_eigen(s.garment.shift));
    s.garment.box = bounds_of(s.garment.mesh.points);
    s.found.push_back(fmt::format(
        "The garment and the body have different origins: moved by {} m, after which {:.2g} % of its nodes are "
        "inside the body. Delete place to undo it",
        list(s.garment.shift), 100 * fitting->moved->inside));
  }
  if (s.garment.guess.up != before)
    s.found.push_back(
        fmt::format("The body wears the garment with {} up in its file, not {} as the boxes of both suggest",
                    name_of(s.garment.guess.up), name_of(before)));
  choose_jet(s);
  choose_domain(s);
  return true;
}

/// Of a box around points, m.
double longest_side(const std::vector<Vec3>& points) {
  const Box box = bounds_of(points);
  return std::max({box.max[0] - box.min[0], box.max[1] - box.min[1], box.max[2] - box.min[2]});
}

/// Puts the garment on the body and the nozzle where the body is not, and decides by what holds the garment. An
/// animated body counts as its first file. Returns how deep nodes start inside the body, m.
double place_with_body(Suggestion& s, const std::string& body_file, std::vector<std::string>& warnings,
                       FilledBodies& filled) {
  Setup setup = beside_body_at_rest(s, body_file, filled);
  if (put_on(s, setup.model.bodies.front())) setup = beside_body_at_rest(s, body_file, filled);
  const Body& body = setup.model.bodies.front();
  if (!body.field.empty()) {
    choose_jet(s, exact_distance(body));
    constexpr double many = 0.1;  // of the nodes
    if (const double inside = rate_place(s.garment, body).inside; inside > many)
      warnings.push_back(fmt::format(
          "{:.0f} % of the cloth's nodes are inside the body, also at the best place that was found: the garment may "
          "be too small for this body (scale), or set place of the cloth (position, rotate), and unit and up of both "
          "meshes",
          100 * inside));
  }
  const bool sheet = s.garment.flat && s.garment.open, around_it = surrounds(s.garment, body.mesh_points),
             falls = falls_freely(setup.model, setup.model.cloths.front());
  s.pinned = falls || (!sheet && !around_it);
  if (!s.garment.open)
    warnings.push_back(
        fmt::format("{}: the mesh of the garment is closed; if it is the body, interchange the files", s.mesh));
  if (!sheet && !around_it)
    warnings.push_back(fmt::format(
        "no part of the body is inside the garment, which is {:.2g} m long, the body {:.2g} m: check unit and up of "
        "both meshes, and the place of the cloth",
        s.garment.size, longest_side(body.mesh_points)));
  if (const std::size_t pieces = around_it && !s.pinned ? pieces_beside(s.garment, body.mesh_points) : 0; pieces > 0)
    warnings.push_back(fmt::format(
        "the garment is in {} pieces that are not sewn together, and none of them goes around the body by itself: they "
        "may fall off; use weld or sew",
        pieces));
  const char* pins = sheet ? "its edges" : "its highest points";
  s.found.push_back(
      !s.pinned && around_it ? "The body is inside the garment and holds it, so there are no pins"
      : !s.pinned            ? "The cloth falls onto the body, so there are no pins"
      : around_it ? fmt::format("The body is inside the garment but does not hold it, so it is pinned at {}", pins)
      : sheet ? fmt::format("The body is not under the cloth, which would fall past it, so it is pinned at {}", pins)
              : "No part of the body is inside the garment, which is held at its highest points");
  return setup.deepest_inside;
}

}  // namespace

FirstScene first_scene(const FirstSceneFor& wanted, const TrySteps& trial) {
  FirstScene result;
  FilledBodies filled;
  Suggestion s;
  s.body_rate = wanted.body_rate;
  s.paths = wanted.paths;
  s.mesh = wanted.mesh;
  s.body = wanted.body;
  s.fabric = wanted.fabric;
  const std::string body_file = measure(s, result);
  read_fabric(s);
  choose_fabric(s, result.warnings);
  choose_jet(s);
  choose_domain(s);
  double deepest = 0;  // m
  if (!s.body.empty()) {
    deepest = place_with_body(s, body_file, result.warnings, filled);
    choose_domain(s);
  }
  choose_step(s, result.warnings, filled);
  if (s.whole_thickness > 0 && !s.fabric.empty())
    result.warnings.push_back(fmt::format(
        "{}: its smallest triangle is {:.2g} m high, so that the thickness is {} m, and not {} m as of {}; it holds "
        "less "
        "water than that fabric. A mesh with more regular triangles, or self_collision: false, allows the whole "
        "thickness",
        s.mesh, s.garment.least_height, s.thickness, s.whole_thickness, s.fabric));
  if (s.bend < bends[0])
    result.warnings.push_back(
        fmt::format("{}: its smallest triangle is {:.2g} m high and its edges are {:.2g} m: bend is {}, because the "
                    "solve for a stiffer fabric may not converge; a mesh with more regular triangles allows more",
                    s.mesh, s.garment.least_height, s.garment.edge, s.bend));
  if (trial) try_steps(s, deepest, trial, result.warnings, filled);
  s.settle = settle_for(s, deepest);
  const Setup setup = build_text(text_of(s), filled);
  s.found.insert(s.found.end(), setup.notes.begin(), setup.notes.end());
  s.found.insert(s.found.end(), setup.warnings.begin(), setup.warnings.end());
  result.yaml = text_of(s);
  result.warnings.insert(result.warnings.end(), setup.warnings.begin(), setup.warnings.end());
  return result;
}

}  // namespace drench
