// The liquid of a scene.

#include <fmt/format.h>

#include <cmath>

#include "scene/describe.hpp"

namespace drench {

void describe(Section& s, MicropolarScene& micropolar) {
  s.one_line();
  s.number("transfer", micropolar.transfer, "(0, 10]", "m²/s", "transfer coefficient ν_t between spins and flow");
  s.number("inertia", micropolar.inertia, "[0.01, 1e4]", "spacings²",
           "moment of inertia per mass Θ; waves longer than 2π√Θ gain most energy");
  s.number("viscosity", micropolar.viscosity, "[0, 10]", "m²/s", "spin diffusivity ζ");
  s.number("reaction", micropolar.reaction, "[0, 1]", "1",
           "fraction a of the spins' energy gain that is taken from the flow; 1 adds no energy");
}

void describe(Section& s, FluidSolverScene& solver) {
  s.one_line();
  s.number("density_error", solver.density_error, "[1e-15, 0.5]", "1",
           "mean compression at which the density solver stops");
  s.number("divergence_error", solver.divergence_error, "[1e-15, 0.5]", "1",
           "mean rate of compression times Δt at which the divergence solver stops");
  s.integer("max_iterations", solver.max_iterations, "[1, 100000]", "iterations", "iteration limit of each solver");
  s.integer("min_iterations", solver.min_iterations, "[0, 100000]", "iterations",
            "minimum number of iterations of each solver; at most `max_iterations`");
  s.number("density_correction", solver.density_correction, "[0.5, 1]", "1",
           "fraction c of the density error that is corrected per step; use 1 for fast flows with long steps");
  s.number("source_error", solver.source_error, "(0, 1]", "1",
           "the density solver also continues until at most this fraction η of the step's own compression is left; "
           "off without this key");
  s.check(solver.min_iterations <= solver.max_iterations, s.has("min_iterations") ? "min_iterations" : "max_iterations",
          fmt::format("min_iterations ({}) is above max_iterations ({}); allowed: at most that", solver.min_iterations,
                      solver.max_iterations));
}

/// Of every source that is there at the start.
void describe_content(Section& s, BlockScene& block) {
  s.numbers("velocity", block.velocity, speed_range, "m/s", "initial velocity");
  s.number("concentration", block.concentration, concentration_range, "kg/kg",
           "mass fraction of the solute (such as dye or detergent)");
}

void describe(Section& s, BlockScene& block) {
  describe(s, block.box);
  describe_content(s, block);
}

void describe_sphere(Section& s, BlockScene& block) {
  s.one_line();
  s.required().numbers("center", block.center, coordinate_range, "m", "centre");
  s.required().number("radius", block.radius, "[1e-6, 10000]", "m", "radius; at least one spacing");
  describe_content(s, block);
}

void describe_rotate(Section& s, PlacedFile& placed) {
  s.numbers("axis", placed.rotate_axis, direction_range, "1", "rotation axis; its length does not matter");
  s.number("degrees", placed.rotate_degrees, "[-3600, 3600]", "degrees", "by the right-hand rule");
  check_not_zero(s, "axis", placed.rotate_axis);
}

void describe_placed(Section& s, PlacedFile& placed) {
  s.number("scale", placed.scale, "[1e-9, 1e6]", "1", "scale factor of the file's coordinates");
  describe_coordinates(s, placed.unit, placed.up, true);
  s.numbers("position", placed.position, coordinate_range, "m", "displacement, after the rotation");
  s.section("rotate", placed, describe_rotate, "rotation about the origin of the file");
}

/// Either the file of a source, or the files of liquid that another program has moved.
void describe_files(Section& s, BlockScene& block, bool mesh, const char* file, const char* sequence) {
  std::string& name = block.placed.file;
  s.saved_if(block.sequence.files.empty());
  if (mesh)
    s.mesh_file("file", name, file);
  else
    s.other_file("file", name, file);
  describe_sequence(s, block.sequence, sequence, mesh ? SequenceOf::surfaces : SequenceOf::particles);
  if (!block.sequence.files.empty()) name = block.sequence.files.front();
  s.check(s.has("file") != s.has("sequence"), s.has("file") ? "sequence" : "file",
          s.has("file") ? "cannot be combined with file; allowed: one of the two"
                        : "file and sequence are both missing; allowed: exactly one of the two");
}

/// What a source of files has besides.
void describe_in_place(Section& s, BlockScene& block) {
  describe_placed(s, block.placed);
  describe_content(s, block);
  s.check(block.sequence.files.empty() || block.concentration == 0, "concentration",
          "cannot be combined with sequence; allowed: 0");
}

void describe_mesh(Section& s, BlockScene& block) {
  describe_files(s, block, true, "closed mesh (.obj, .ply, .stl); a relative path starts at the scene's folder",
                 "surfaces of liquid that another program has moved, one closed mesh per frame; the liquid wets cloth, "
                 "but the cloth does not stop it");
  describe_in_place(s, block);
}

void describe_particles(Section& s, BlockScene& block) {
  describe_files(s, block, false,
                 "particles (.ply, .vtu, .vtp, .bgeo, .npz) with their positions; `velocity` (vx, vy, vz in .ply, v in "
                 ".bgeo) and `mass` are read too",
                 "particles that another program has moved: files as in `file`, one per frame, each particle with an "
                 "`id` that it keeps; the liquid wets cloth, but the cloth does not stop it");
  describe_in_place(s, block);
}

/// A vector without a default: absent, it stays empty. The reference of keys shows `shown`.
void vector(Section& s, const char* key, std::optional<Vec3>& value, const char* range, const char* unit,
            const char* meaning, const Vec3& shown = {0, 0, 0}) {
  Vec3 given = value.value_or(shown);
  const bool present = s.has(key) || value;
  s.saved_if(value.has_value()).numbers(key, given, range, unit, meaning);
  if (present) value = given;
}

/// What every emitter has.
template <class Emitter>
void describe_flow(Section& s, Emitter& emitter, const char* what) {
  s.number("start", emitter.start, "[0, 1e6]", "s", "time at which the flow starts");
  s.number("end", emitter.end, "[0, inf]", "s", "time at which the flow stops; after `start`");
  s.number("concentration", emitter.concentration, concentration_range, "kg/kg",
           "mass fraction of the solute (such as dye or detergent)");
  check_end_after_start(s, what, emitter.start, emitter.end);
}

void describe(Section& s, RainScene& rain) {
  s.one_line();
  s.required().numbers("center", rain.center, coordinate_range, "m", "centre of the rectangle, inside the domain");
  s.required().numbers(
      "size", rain.size, "[1e-6, 10000]", "m",
      "side lengths of the rectangle: along x and z if gravity acts along y, otherwise along the two axes across it");
  s.number("rate", rain.rate, "[1e-6, 1e6]", "mm/h", "depth of water per hour on level ground; heavy rain: 10 to 50");
  s.number("diameter", rain.diameter, "[1e-5, 0.01]", "m",
           "diameter of a drop; particles that would be too light for it contain several drops");
  vector(s, "velocity", rain.velocity, speed_range, "m/s",
         "velocity of the drops; without this key the terminal speed of the diameter, along gravity");
  if (rain.velocity) check_not_zero(s, "velocity", *rain.velocity);
  describe_flow(s, rain, "the rain");
}

void describe_nozzle_spin(Section& s, NozzleMotionScene& motion) {
  describe(s, motion.spin);
  vector(s, "center", motion.center, coordinate_range, "m",
         "centre of rotation; moves with the emitter; without this key the centre of the emitter");
}

/// The motion that bodies can have, without an end.
void describe_motion(Section& s, NozzleMotionScene& motion) {
  s.one_line();
  s.numbers("velocity", motion.velocity, speed_range, "m/s", "prescribed velocity of the emitter, from 0 s");
  s.numbers("offset", motion.offset, coordinate_range, "m",
            "keyframes of the displacement from the start; added to the motion by `velocity`");
  s.section("spin", motion, describe_nozzle_spin, "rotation of the emitter and of the direction of its liquid");
  check_offset(s, motion.offset, 0);
}

/// A resolved scene has the motion of emitters that move.
void describe_motion_of(Section& s, NozzleMotionScene& motion) {
  s.saved_if(motion != NozzleMotionScene{})
      .section("motion", motion, describe_motion,
               "motion of the emitter, which the liquid adds to its own velocity; without this key it stands still");
}

void describe(Section& s, SprayScene& spray) {
  s.one_line();
  s.required().numbers("center", spray.center, coordinate_range, "m", "the nozzle, inside the domain");
  s.required().numbers("direction", spray.direction, direction_range, "1",
                       "axis of the cone; its length does not matter");
  check_not_zero(s, "direction", spray.direction);
  s.required().number("half_angle", spray.half_angle, "[0, 180]", "degrees",
                      "angle between the axis and the edge of the cone, whose directions are equally frequent");
  s.required().number("speed", spray.speed, "(0, 1000]", "m/s", "speed of the drops relative to the nozzle");
  s.required().number("flow", spray.flow, "[1e-6, 1e6]", "L/min", "volume per time");
  describe_motion_of(s, spray.motion);
  describe_flow(s, spray, "the spray");
}

void describe(Section& s, MeshJetScene& jet) {
  s.one_line();
  describe_moving_file(
      s, jet.placed.file, jet.sequence,
      "mesh (.obj, .ply, .stl), open or closed; a relative path starts at the scene's folder",
      "files of a moving mesh with the same polygons, which may change their shape; or a point cache, which moves "
      "`file`");
  describe_placed(s, jet.placed);
  s.required().number("speed", jet.speed, "[0, 1000]", "m/s",
                      "speed of the liquid relative to the faces; 0 is allowed in keyframes only");
  s.check(jet.speed.largest() > 0, "speed",
          "is 0 at all times, so the emitter never flows; allowed: a number above 0, or keyframes with one");
  vector(s, "direction", jet.direction, direction_range, "1",
         "direction of the liquid, from the faces that look that way; its length does not matter; without this key "
         "along the normals, for which the corners of a face are counter-clockwise");
  if (jet.direction) check_not_zero(s, "direction", *jet.direction);
  describe_motion_of(s, jet.motion);
  s.check(!s.has("sequence") || !s.has("motion"), "motion",
          "cannot be combined with sequence, which sets the motion; allowed: one of the two");
  describe_flow(s, jet, "the emitter");
}

/// An entry of `sources`.
struct SourceScene {
  BlockScene block;
  std::optional<JetScene> jet;
  std::optional<RainScene> rain;
  std::optional<SprayScene> spray;
  std::optional<MeshJetScene> mesh_jet;
};

void describe(Section& s, SourceScene& source) {
  using Shape = BlockScene::Shape;
  BlockScene& block = source.block;
  const bool full = !source.jet && !source.rain && !source.spray && !source.mesh_jet;
  const auto shape = [&](Shape value) -> Section& { return s.saved_if(full).one_of(block.shape, value); };
  shape(Shape::box).section("block", block, "box that is filled with liquid at the start");
  shape(Shape::sphere).section("sphere", block, describe_sphere, "sphere that is filled with liquid at the start");
  shape(Shape::mesh)
      .section("mesh", block, describe_mesh,
               "closed mesh that is filled with liquid at the start; the mass is density times its volume");
  shape(Shape::particles)
      .section("particles", block, describe_particles,
               "particles of a file, for example a frame of another run, or of a sequence of files; their distance has "
               "to be `spacing`");
  s.one_of().section("jet", source.jet, "emitter: a round or rectangular nozzle");
  s.one_of().section("mesh_jet", source.mesh_jet, "emitter: the faces of a mesh file");
  s.one_of().section("rain", source.rain, "emitter: drops that fall from a horizontal rectangle");
  s.one_of().section("spray", source.spray, "emitter: drops that leave a nozzle in all directions of a cone");
}

/// Between two keys the axis turns the short way, which opposite directions do not have.
void check_turns(Section& s, const Keyed<Vec3>& velocity) {
  const Vec3* before = nullptr;
  for (std::size_t k = 0; k < velocity.keys().size(); ++k) {
    const Vec3& v = velocity.keys()[k].value;
    const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (square == 0) continue;
    if (before) {
      const Vec3& u = *before;
      const double cosine =
          (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) / std::sqrt(square * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]));
      s.check(cosine > -0.9, fmt::format("velocity.{}", k),
              "reverses the previous entry; allowed: angles below 154 degrees, or a jet for each direction");
    }
    before = &v;
  }
}

void describe(Section& s, JetScene& jet) {
  using Shape = JetScene::Shape;
  s.one_line();
  s.required().numbers("center", jet.center, coordinate_range, "m", "centre of the nozzle, inside the domain");
  s.one_of(jet.shape, Shape::disc)
      .number("radius", jet.radius, "[1e-6, 100]", "m", "radius of a round nozzle; at least half a spacing");
  s.one_of(jet.shape, Shape::rectangle)
      .numbers("size", jet.size, "[1e-6, 200]", "m",
               "side lengths of a rectangular nozzle, the second along `up`; each at least one spacing");
  s.required().numbers(
      "velocity", jet.velocity, speed_range, "m/s",
      "velocity of the liquid, along the nozzle's axis; 0 is allowed in keyframes only and closes the nozzle");
  vector(s, "up", jet.up, direction_range, "1",
         "direction of the second side of a rectangular nozzle, of which the part across the velocity counts; without "
         "this key y, or z if the velocity is vertical",
         {0, 1, 0});
  if (jet.up) check_not_zero(s, "up", *jet.up);
  s.check(jet.shape == Shape::rectangle || !s.has("up"), "up",
          "applies only to a rectangular nozzle; allowed: only with size");
  describe_motion_of(s, jet.motion);
  check_not_zero(s, "velocity", jet.velocity);
  check_turns(s, jet.velocity);
  describe_flow(s, jet, "the jet");
}

void describe_drain_sphere(Section& s, DrainScene& drain) {
  s.one_line();
  s.required().numbers("center", drain.center, coordinate_range, "m", "centre");
  s.required().number("radius", drain.radius, "[1e-6, 10000]", "m", "radius");
}

void describe_drain_plane(Section& s, DrainScene& drain) {
  s.one_line();
  s.required().numbers("point", drain.point, coordinate_range, "m", "any point of the plane");
  s.required().numbers("normal", drain.normal, direction_range, "1",
                       "points to the liquid that stays; its length does not matter");
  check_not_zero(s, "normal", drain.normal);
}

void describe(Section& s, DrainScene& drain) {
  using Shape = DrainScene::Shape;
  s.one_line();
  s.one_of(drain.shape, Shape::box).section("box", drain.box, "axis-aligned box");
  s.one_of(drain.shape, Shape::sphere).section("sphere", drain, describe_drain_sphere, "sphere");
  s.one_of(drain.shape, Shape::plane).section("plane", drain, describe_drain_plane, "all that is behind a plane");
  s.number("start", drain.start, "[0, 1e6]", "s", "time at which the drain opens");
  s.number("end", drain.end, "[0, inf]", "s", "time at which the drain closes; after `start`");
  check_end_after_start(s, "the drain", drain.start, drain.end);
}

void describe(Section& s, FluidScene& fluid) {
  s.number("spacing", fluid.spacing, "[1e-6, 10]", "m",
           "particle diameter and distance d; run time grows at least with 1/d³");
  s.number("density", fluid.density, "[1, 30000]", "kg/m³", "rest density");
  s.number("viscosity", fluid.viscosity, "[0, 100]", "m²/s", "kinematic viscosity ν; water: 1e-6");
  s.number("surface_tension", fluid.surface_tension, "[0, 10]", "N/m", "surface tension γ; water: 0.072");
  s.choice("kernel", fluid.kernel,
           {{"cubic", KernelKind::cubic}, {"wendland", KernelKind::wendland}, {"poly6", KernelKind::poly6}},
           "smoothing kernel");
  // below 1.8, a full neighbourhood has too few (kernel.hpp)
  s.number("support", fluid.support, "[1.8, 4]", "spacings", "support radius h of the kernel, in spacings");
  s.remark("h / spacing");
  s.choice("wall_pressure", fluid.wall_pressure,
           {{"mirrored", WallPressure::mirrored}, {"extrapolated", WallPressure::extrapolated}},
           "pressure at solids: that of the particle, or extrapolated to the wall by its gradient");
  s.optional(fluid.micropolar.present)
      .section("micropolar", fluid.micropolar,
               "micropolar model: particles have spins, which preserve vortices; off without this section");
  s.remark("m²/s, spacings², m²/s, 1");
  s.section("solver", fluid.solver, "convergence of the pressure solvers");

  std::vector<SourceScene> sources;
  for (const BlockScene& block : fluid.blocks) sources.emplace_back().block = block;
  for (const JetScene& jet : fluid.jets) sources.emplace_back().jet = jet;
  for (const RainScene& rain : fluid.rains) sources.emplace_back().rain = rain;
  for (const SprayScene& spray : fluid.sprays) sources.emplace_back().spray = spray;
  for (const MeshJetScene& jet : fluid.mesh_jets) sources.emplace_back().mesh_jet = jet;
  s.list("sources", sources, "sources of liquid; required unless the scene has porous cloth");
  fluid.blocks.clear();
  fluid.jets.clear();
  fluid.rains.clear();
  fluid.sprays.clear();
  fluid.mesh_jets.clear();
  for (const SourceScene& source : sources) {
    if (source.jet)
      fluid.jets.push_back(*source.jet);
    else if (source.rain)
      fluid.rains.push_back(*source.rain);
    else if (source.spray)
      fluid.sprays.push_back(*source.spray);
    else if (source.mesh_jet)
      fluid.mesh_jets.push_back(*source.mesh_jet);
    else
      fluid.blocks.push_back(source.block);
  }
  for (std::size_t k = 0; k < sources.size(); ++k)
    s.check(sources.size() == 1 || sources[k].block.sequence.files.empty(), fmt::format("sources.{}", k),
            "has a sequence or stands beside one; allowed: a sequence as the only source");
  s.check(!fluid.is_baked() || !fluid.micropolar.present, "micropolar",
          "does not act on liquid of a sequence of files; allowed: other sources");
  s.list("drains", fluid.drains, "regions that remove the liquid that enters them; its mass is recorded as drained");
}

}  // namespace drench
