#include "setup/warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "base/eigen_vec.hpp"
#include "setup/body_geometry.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/emitters.hpp"
#include "setup/fluid_sampling.hpp"
#include "setup/forecast.hpp"
#include "setup/membrane.hpp"
#include "setup/point_grid.hpp"
#include "setup/unreached.hpp"
#include "stages/substeps.hpp"
#include "state/nozzle.hpp"

namespace drench {
namespace {

using Lines = std::vector<std::string>;

constexpr double many_passes = 50;  // of a stage in a step

void warn_of_step(const Model& m, const HostState& state, Lines& lines) {
  const TimeScene& time = m.scene.time;
  if (m.has_moving_liquid() && time.mode == TimeMode::fixed) {
    const double speed = expected_speeds(m, state).impact, moved = speed * time.step / m.spacing;
    if (moved > 1)
      lines.push_back(fmt::format(
          "time.step: particles at an impact, an emitter or a moving body reach {:.3g} m/s "
          "and move {:.3g} "
          "spacings per step (CFL number; at most 1, better {}): use a time.step of {:.2g} s or time.mode cfl",
          speed, moved, time.cfl, time.cfl * m.spacing / speed));
  }
  const double parts = m.scene.output.every / time.step;
  if (time.mode == TimeMode::fixed && parts > 0 && std::abs(parts - std::round(parts)) > 1e-6)
    lines.push_back(
        fmt::format("output.every is {:.4g} times time.step, so the step before each frame is shorter; "
                    "use a multiple of time.step",
                    parts));
}

using Corners = std::array<Eigen::Vector3d, 3>;

/// m: how far the surface of a closed mesh is away from a point of triangle `own`, along the inward normal; none where
/// that lies within the solid, or the ray passes through an edge.
std::optional<double> thickness_below(const std::vector<Corners>& triangles, std::size_t own) {
  const auto& [a, b, c] = triangles[own];
  const Eigen::Vector3d from = 0.5 * a + 0.3 * b + 0.2 * c, inward = -(b - a).cross(c - a).normalized();
  std::vector<std::pair<double, int>> crossings;  // m; 1 where the ray leaves the solid, −1 where it enters
  int winding = 0;                                // just below the surface
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (t == own) continue;
    const Eigen::Vector3d ab = triangles[t][1] - triangles[t][0], ac = triangles[t][2] - triangles[t][0],
                          across = inward.cross(ac), to = from - triangles[t][0];
    const double det = ab.dot(across), u = to.dot(across) / det;
    if (!(u >= 0 && u <= 1)) continue;
    const Eigen::Vector3d q = to.cross(ab);
    const double v = inward.dot(q) / det, distance = ac.dot(q) / det;
    if (!(v >= 0 && u + v <= 1 && distance > 0)) continue;
    crossings.emplace_back(distance, det < 0 ? 1 : -1);
    winding += crossings.back().second;
  }
  if (winding != 1) return std::nullopt;
  std::sort(crossings.begin(), crossings.end());
  for (const auto& [distance, leaves] : crossings)
    if ((winding -= leaves) <= 0) return distance;
  return std::nullopt;
}

/// Median, over the surface of a closed mesh, of its thickness along the inward normal, m; infinite if no ray is
/// usable. Unlike volume over surface it does not grow with the filled bottom of a cup.
double median_thickness(const Body& body) {
  constexpr double most_crossings = 2e7;  // triangles times rays
  std::vector<Corners> triangles;
  std::vector<double> area_up_to;
  for (const auto& t : body.mesh_triangles) {
    Corners& x = triangles.emplace_back();
    for (std::size_t c = 0; c < 3; ++c) x[c] = to_eigen(body.mesh_points[static_cast<std::size_t>(t[c])]);
    area_up_to.push_back((area_up_to.empty() ? 0 : area_up_to.back()) + (x[1] - x[0]).cross(x[2] - x[0]).norm());
  }
  const double rays = std::floor(std::clamp(most_crossings / static_cast<double>(triangles.size()), 20.0, 200.0));
  std::vector<double> thickness;
  for (double r = 0.5; r < rays; ++r) {  // evenly over the surface
    const auto found = std::lower_bound(area_up_to.begin(), area_up_to.end(), r / rays * area_up_to.back());
    if (found == area_up_to.end()) continue;
    const auto own = static_cast<std::size_t>(found - area_up_to.begin());
    if (const auto t = thickness_below(triangles, own)) thickness.push_back(*t);
  }
  if (thickness.empty()) return std::numeric_limits<double>::infinity();
  const auto middle = thickness.begin() + static_cast<std::ptrdiff_t>(thickness.size() / 2);
  std::nth_element(thickness.begin(), middle, thickness.end());
  return *middle;
}

void warn_of_coarse_bodies(const Model& m, Lines& lines) {
  const double d = m.spacing;
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    const Body& body = m.bodies[b];
    const auto warn = [&](const char* what, double size, const char* why, double enough) {
      lines.push_back(
          fmt::format("{}: {} {:.3g} m is {:.2g} spacings: {}; use a fluid.spacing of at most {:.2g} m, or a "
                      "larger body",
                      body_label(body.name, b), what, size, size / d, why, enough));
    };
    const Eigen::Vector3d size = to_eigen(body.box.max) - to_eigen(body.box.min);
    constexpr const char* through = "liquid interacts through it";
    if (body.kind == BodyScene::Kind::box && body.inside && size.minCoeff() < 3 * d)
      warn("its smallest inner width", size.minCoeff(), "too few particles for a flow fit in", size.minCoeff() / 3);
    else if (body.kind == BodyScene::Kind::box && !body.inside && size.minCoeff() < 2 * d)
      warn("its thickness", size.minCoeff(), through, size.minCoeff() / 2);
    else if (body.kind == BodyScene::Kind::sphere && body.radius < 2 * d)
      warn("its radius", body.radius, "its boundary particles do not form a sphere", body.radius / 2);
    if (body.kind != BodyScene::Kind::mesh || body.field.empty()) continue;
    if (const double thickness = median_thickness(body); thickness < d)
      warn("its median thickness", thickness, through, thickness);
  }
}

/// Points on the surface of a dynamic body, or a sphere's centre.
std::vector<Vec3> feelers_of(const Body& body) {
  if (body.kind == BodyScene::Kind::sphere) return {body.center};
  if (body.kind == BodyScene::Kind::mesh) return body.mesh_points;
  std::vector<Vec3> corners;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    Vec3& x = corners.emplace_back();
    for (std::size_t a = 0; a < 3; ++a) x[a] = (corner >> a & 1 ? body.box.max : body.box.min)[a];
  }
  return corners;
}

/// m: how deep a dynamic body starts in another solid, and the normal there.
std::pair<double, Vec3> depth_in(const Body& body, const Body& solid) {
  std::pair<double, Vec3> deepest{0, {0, 0, 0}};
  if (solid.kind == BodyScene::Kind::mesh && solid.field.empty()) return deepest;
  for (const Vec3& x : feelers_of(body)) {
    Vec3 normal;
    const bool ball = body.kind == BodyScene::Kind::sphere;
    const double inside = (ball ? body.radius : 0) - signed_distance(solid, x, normal);
    if (inside > deepest.first) deepest = {inside, normal};
  }
  return deepest;
}

/// A floating body that starts in a solid is pushed out of it and lifted by the energy (J) that the message names.
void warn_of_bodies_in_solids(const Model& m, Lines& lines) {
  // Two dynamic bodies that a hinge joins do not touch each other.
  const auto meet = [&](std::size_t b, std::size_t other) {
    const auto one = static_cast<Index>(b), two = static_cast<Index>(other);
    const Body &body = m.bodies[b], &solid = m.bodies[other];
    return (to_eigen(body.center) - to_eigen(solid.center)).norm() < body.reach + solid.reach &&
           std::none_of(m.joints.begin(), m.joints.end(), [&](const Joint& j) {
             return (j.body == one && j.other == two) || (j.body == two && j.other == one);
           });
  };
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    const Body& body = m.bodies[b];
    if (!body.dynamic) continue;
    for (std::size_t other = 0; other < m.bodies.size(); ++other) {
      const Body& solid = m.bodies[other];
      if (solid.dynamic && (other <= b || !meet(b, other))) continue;
      auto [depth, deepest] = depth_in(body, solid);
      if (solid.dynamic) depth = std::max(depth, depth_in(solid, body).first);
      if (depth <= rounding_of(body)) continue;
      const double energy = std::max(0.0, -body.mass * depth * to_eigen(m.scene.gravity).dot(to_eigen(deepest)));
      lines.push_back(fmt::format(
          "{}: it starts {:.2g} m inside {}; {}; move one of them", body_label(body.name, b), depth,
          body_label(solid.name, other),
          solid.dynamic ? "they are pushed apart at once" : fmt::format("pushing it out adds {:.2g} J", energy)));
    }
  }
}

/// m: mean rest length of this cloth's edges.
double mean_edge(const Model& m, const ClothMaterial& cloth) {
  double sum = 0, count = 0;
  for (std::size_t e = 0; e < m.mesh.edge.size(); ++e) {
    const Index n = m.mesh.edge[e][0] - cloth.first_node;
    if (n < 0 || n >= cloth.node_count) continue;
    sum += m.mesh.edge_length[e];
    count += 1;
  }
  return count > 0 ? sum / count : 0;
}

/// Fabrics given in mm or g/m² are a thousand times too thick or too heavy.
void warn_of_units(const Model& m, Lines& lines) {
  constexpr double thickest = 0.05, heaviest = 20;  // m, kg/m²
  for (const ClothMaterial& cloth : m.cloths) {
    if (cloth.thickness > thickest)
      lines.push_back(
          fmt::format("{}: its thickness is {:.3g} m, more than that of any fabric; the unit is m: {:.3g} mm is {:.3g}",
                      cloth_label(cloth.name), cloth.thickness, cloth.thickness, cloth.thickness / 1000));
    if (cloth.areal_density > heaviest)
      lines.push_back(
          fmt::format("{}: its areal_density is {:.4g} kg/m², more than that of any fabric; the unit is kg/m²: {:.4g} "
                      "g/m² is {:.4g}",
                      cloth_label(cloth.name), cloth.areal_density, cloth.areal_density, cloth.areal_density / 1000));
  }
}

void warn_of_cloth_meshes(const Model& m, Lines& lines) {
  constexpr double coarsest = 6, finest = 0.25;  // spacings
  for (const ClothMaterial& cloth : m.cloths) {
    const double edge = mean_edge(m, cloth), d = m.spacing;
    if (edge > coarsest * d)
      lines.push_back(
          fmt::format("{}: its mean edge of {:.3g} m is {:.2g} spacings: bending and wetting are much coarser than the "
                      "liquid; use edges of at most {:.2g} m, or a larger fluid.spacing",
                      cloth_label(cloth.name), edge, edge / d, coarsest * d));
    if (edge > 0 && edge < finest * d)
      lines.push_back(
          fmt::format("{}: its mean edge of {:.3g} m is {:.2g} of a spacing: {} quadrature points, at least one per "
                      "triangle, slow down "
                      "the run; use edges of {:.2g} m or more, or a smaller fluid.spacing",
                      cloth_label(cloth.name), edge, edge / d, cloth.sample_count, finest * d));
  }
}

/// Does a container keep all the liquid in?
bool is_confined(const Model& m) {
  for (const Body& body : m.bodies) {
    if (body.kind != BodyScene::Kind::box || !body.inside) continue;
    bool all = m.jets.empty() || std::all_of(m.jets.begin(), m.jets.end(), [&](const Jet& jet) {
                 if (!jet.mouth) return contains(body.box.min, body.box.max, jet.scene.center);
                 bool inside = true;
                 for (const double time : times_of_mouth(jet, m.scene.time.end))
                   for (const Vec3& x : mouth_at(jet, time)) inside = inside && contains(body.box.min, body.box.max, x);
                 return inside;
               });
    for (const BlockScene& block : m.scene.fluid.blocks)
      all = all && contains(body.box.min, body.box.max, block.box.min) &&
            contains(body.box.min, body.box.max, block.box.max);
    if (all) return true;
  }
  return false;
}

void warn_of_domain(const Model& m, const HostState& state, int real_bytes, Lines& lines) {
  const Eigen::Vector3d size = to_eigen(m.scene.domain.max) - to_eigen(m.scene.domain.min);
  const double h = m.support, cells = (size / h).prod();
  int axis = 0;
  if (const double least = size.minCoeff(&axis); least < 2 * h)
    lines.push_back(
        fmt::format("domain: {:.3g} m in {} are {:.2g} support radii ({:.3g} m): particles leave it before they have "
                    "neighbours; make it at least {:.2g} m wide",
                    least, "xyz"[axis], least / h, h, 4 * h));
  if (cells > 0x1p31 && !is_confined(m))
    lines.push_back(fmt::format(
        "domain: it has {:.2g} cells of the support radius {:.3g} m, more than 2^31: the neighbour search is slower if "
        "liquid spreads, and falling liquid is drained late; use a smaller domain",
        cells, h));
  double farthest = 0;
  const auto extend = [&](const Vec3& x) {
    for (const double axis_value : x) farthest = std::max(farthest, std::abs(axis_value));
  };
  for (const Vec3& x : state.fluid_position) extend(x);
  for (const Jet& jet : m.jets) {
    extend(jet.scene.center);
    if (!jet.mouth) continue;
    for (const double time : times_of_mouth(jet, m.scene.time.end))
      for (const Vec3& x : mouth_at(jet, time)) extend(x);
  }
  const double rounding = farthest * (real_bytes == 4 ? 0x1p-24 : 0x1p-53);
  if (rounding > 1e-3 * m.spacing)
    lines.push_back(fmt::format(
        "fluid: positions {:.3g} m from the origin are rounded to {:.2g} m, {:.2g} of a spacing; move the scene to "
        "the origin, or use a build in double precision",
        farthest, 2 * rounding, 2 * rounding / m.spacing));
}

void warn_of_jets(const Model& m, const HostState& state, Lines& lines) {
  const double d = m.spacing;
  PointGrid at_start(d);
  if (m.has_jets())
    for (const Vec3& x : state.fluid_position) at_start.add(x);
  for (std::size_t j = 0; j < m.jets.size(); ++j) {
    const Jet& jet = m.jets[j];
    if (jet.scene.start >= m.scene.time.end) {
      lines.push_back(
          fmt::format("{}: it starts at {:.4g} s and the scene ends at {:.4g} s: it never flows; reduce "
                      "its start or increase time.end",
                      jet_label(m, j), jet.scene.start, m.scene.time.end));
      continue;
    }
    const std::vector<Vec3> mouth = mouth_at(jet, jet.scene.start);
    for (const double time : times_of_mouth(jet, m.scene.time.end)) {
      const std::vector<Vec3> now = mouth_at(jet, time);
      const auto outside = std::count_if(
          now.begin(), now.end(), [&](const Vec3& x) { return !contains(m.scene.domain.min, m.scene.domain.max, x); });
      if (outside == 0) continue;
      lines.push_back(fmt::format(
          "{}: {} of the {} points of its mouth are outside the domain {}and drained at "
          "once; make the domain larger or move the emitter",
          jet_label(m, j), outside, mouth.size(), time > jet.scene.start ? fmt::format("at {:.3g} s ", time) : ""));
      break;
    }
    const auto near = near_cloth(m, mouth, nearest_to_cloth * d);
    if (const auto count = std::count(near.begin(), near.end(), 1))
      lines.push_back(
          fmt::format("{}: {} of the {} points of its mouth are within {:.3g} m, half a spacing, of a "
                      "cloth; move it {:.2g} m away",
                      jet_label(m, j), count, mouth.size(), 0.5 * d, 2 * d));
    const auto filled =
        std::count_if(mouth.begin(), mouth.end(), [&](const Vec3& x) { return at_start.any_within(x, 0.9 * d); });
    if (filled > 0 && jet.scene.start == 0)
      lines.push_back(
          fmt::format("{}: {} of the {} points of its mouth are in a block's liquid, which it "
                      "compresses at once; move one of them",
                      jet_label(m, j), filled, mouth.size()));
  }
}

void warn_of_falling_cloths(const Model& m, Lines& lines) {
  for (const ClothMaterial& cloth : m.cloths) {
    if (!falls_freely(m, cloth)) continue;
    // With the damping c it falls g (t − (1 − e^−ct)/c)/c.
    const double g = to_eigen(m.scene.gravity).norm(), c = std::max(cloth.damping, 1e-6),
                 height = height_in_domain(m, cloth);
    const auto fallen = [&](double t) { return g / c * (t + std::expm1(-c * t) / c); };
    if (fallen(m.scene.time.end) < height) continue;
    double low = 0, high = m.scene.time.end;
    for (int k = 0; k < 60; ++k) (fallen(0.5 * (low + high)) < height ? low : high) = 0.5 * (low + high);
    lines.push_back(fmt::format(
        "{}: it has no pins and nothing lies under it: it falls out of the domain at about {:.2g} s; pin it, "
        "or put a body under it",
        cloth_label(cloth.name), high));
  }
}

/// A strain limit is straight_yarns times as stiff as the cloth, and XPBD comes to terms with it in proportion to that.
void warn_of_limits_by_xpbd(const Model& m, Lines& lines) {
  const double cap = m.scene.cloth_solver.max_iterations;
  if (m.scene.cloth_solver.method != ClothMethod::xpbd) return;
  for (const ClothMaterial& cloth : m.cloths) {
    const double without = cloth_iterations(m, cloth, m.scene.time.step).count, needed = straight_yarns * without;
    if (cloth.dynamics && cloth.strain_limit > 0 && needed > cap && without <= cap)
      lines.push_back(
          fmt::format("{}: with xpbd, a cloth at its strain_limit needs at least {:.0f} iterations per step, more than "
                      "cloth_solver.max_iterations, {:.0f}: liquid on it may gain energy; use cloth_solver.method pd "
                      "or more iterations",
                      cloth_label(cloth.name), needed, cap));
  }
}

void warn_of_stiff_cloths(const Model& m, Lines& lines) {
  const double cap = m.scene.cloth_solver.max_iterations;
  for (const ClothMaterial& cloth : m.cloths) {
    const ClothIterations needed = cloth_iterations(m, cloth, m.scene.time.step);
    if (!(needed.count > cap)) continue;
    double low = 0, high = m.scene.time.step;
    for (int k = 0; k < 60; ++k)
      (cloth_iterations(m, cloth, 0.5 * (low + high)).count > cap ? high : low) = 0.5 * (low + high);
    const double unit = std::pow(10, std::floor(std::log10(low)) - 1);  // two digits, rounded down
    lines.push_back(fmt::format(
        "{}: with Jacobi iterations (on a GPU, with xpbd) its solve needs about {:.0f} iterations per step, more than "
        "cloth_solver.max_iterations, {:.0f}: with pd the CPU finishes the steps; with xpbd the cloth moves "
        "sluggishly; use more iterations, a time.step of {:.2g} s, or less {}",
        cloth_label(cloth.name), needed.count, cap, std::floor(low / unit) * unit, needed.cause));
  }
}

void warn_of_wet_cloths(const Model& m, Lines& lines) {
  const double dt = m.scene.time.step;
  for (std::size_t c = 0; c < m.cloths.size(); ++c) {
    const ClothMaterial& cloth = m.cloths[c];
    const bool spreads = m.has_diffusion() && cloth.wicks();
    const MaterialScene& fabric = m.scene.cloths[c].material;
    if (fabric.has_film() && fabric.max_saturation != MaterialScene().max_saturation)
      lines.push_back(fmt::format("{}: porous.max_saturation has no effect: porous.film sets it to {:.4g}; remove one",
                                  cloth_label(cloth.name), fabric.ceiling()));
    if (!m.scene.cloths[c].hold_saturation.empty() && !spreads && !m.has_emission())
      lines.push_back(fmt::format(
          "{}: hold_saturation has no effect: {}", cloth_label(cloth.name),
          cloth.diffusivity > 0 ? "processes.diffusion is off; turn it on" : "porous.diffusivity is 0; set it"));
    if (!spreads) continue;
    if (const double passes = substeps_for(diffusion_rate(m, cloth), dt); passes > many_passes)
      lines.push_back(fmt::format(
          "{}: diffusion needs about {:.0f} sub-steps per step; for {:.0f} use a diffusivity of {:.2g} "
          "m²/s, a time.step of {:.2g} s, or edges {:.2g} times as long",
          cloth_label(cloth.name), passes, many_passes, m.scene.cloths[c].material.diffusivity * many_passes / passes,
          dt * many_passes / passes, std::sqrt(passes / many_passes)));
  }
  if (const double passes = m.has_moving_liquid() ? viscous_passes(m, dt) : 0; passes > many_passes)
    lines.push_back(
        fmt::format("fluid: viscosity needs about {:.0f} passes per step; a smaller viscosity, a shorter time.step or "
                    "a larger spacing needs fewer",
                    passes));
}

/// Free flight is inaccurate in a frame that turns far in one step (docs/theory/rotating_frame.md).
void warn_of_fast_frames(const Model& m, Lines& lines) {
  constexpr double largest = 0.05;  // rad per step
  const RotatingFrameScene& frame = m.scene.rotating_frame;
  if (!frame.present) return;
  const double rate = frame.degrees_per_second.largest() * std::numbers::pi / 180;
  if (rate * m.scene.time.step > largest)
    lines.push_back(fmt::format(
        "rotating_frame: a step of {:g} s turns it by up to {:.2g} rad, which makes free flight inaccurate; set "
        "time.step to at most {:.2g} s",
        m.scene.time.step, rate * m.scene.time.step, largest / rate));
}

/// Air that takes nothing up.
void warn_of_idle_air(const Model& m, Lines& lines) {
  if (m.scene.air.cooling && !m.has_porous())
    lines.emplace_back("air.cooling has no effect: no cloth is porous, and liquid keeps the temperature of the air");
  if (!m.scene.air.present || m.evaporation_flux > 0) return;
  if (m.scene.air.evaporation_rate)
    lines.emplace_back("air: nothing evaporates: evaporation_rate is 0; set it or remove air");
  else if (m.scene.air.humidity == 1)
    lines.emplace_back("air: nothing evaporates into air of humidity 1; reduce humidity");
  else if (m.scene.air.transfer_coefficient)
    lines.emplace_back("air: nothing evaporates: transfer_coefficient is 0; set it or remove it");
  else
    lines.emplace_back(
        "air: nothing evaporates: the air stands still, and without gravity vapour does not rise; set speed, "
        "transfer_coefficient or evaporation_rate");
}

}  // namespace

std::vector<std::string> plan_warnings(const Model& model, const HostState& state, int real_bytes) {
  Lines lines;
  if (model.has_fluid()) {
    warn_of_domain(model, state, real_bytes, lines);
    if (model.has_moving_liquid()) warn_of_coarse_bodies(model, lines);
    warn_of_cloth_meshes(model, lines);
    warn_of_jets(model, state, lines);
    warn_of_unreached(model, lines);
  }
  warn_of_units(model, lines);
  warn_of_bodies_in_solids(model, lines);
  warn_of_falling_cloths(model, lines);
  warn_of_limits_by_xpbd(model, lines);
  warn_of_stiff_cloths(model, lines);
  warn_of_wet_cloths(model, lines);
  warn_of_idle_air(model, lines);
  warn_of_fast_frames(model, lines);
  warn_of_step(model, state, lines);
  return lines;
}

}  // namespace drench
