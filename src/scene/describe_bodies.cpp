// The solid bodies of a scene.

#include "scene/describe.hpp"

namespace drench {
namespace {

using Kind = BodyScene::Kind;

/// Of every body: how it moves, and how the liquid sticks to it.
void describe_motion(Section& s, BodyScene& body) {
  const bool free = body.sequence.files.empty();  // else its files say how it moves
  s.saved_if(free).numbers("velocity", body.velocity, speed_range, "m/s",
                           "prescribed velocity; of a dynamic body the initial velocity, without keyframes");
  s.saved_if(free).numbers("offset", body.offset, coordinate_range, "m",
                           "keyframes of the displacement from the start; added to the motion by `velocity`");
  s.saved_if(free).section(
      "spin", body.spin,
      "rotation about the centre of a box, a sphere or a mesh's bounding box, or a plane's point; prescribed or "
      "initial, as `velocity`");
  s.boolean("commanded", body.commanded,
            "a program moves the body (Simulation.set_body_velocity); it stands still until then");
  s.boolean("dynamic", body.dynamic,
            "moved by liquid, cloth, gravity and other bodies: for spheres, closed meshes, and boxes that are not "
            "containers; only with `fluid`");
  s.saved_if(body.dynamic && !body.mass)
      .number("density", body.density, "[1, 30000]", "kg/m³", "density of a dynamic body; only with `dynamic: true`");
  s.number("mass", body.mass, "[1e-6, 1e6]", "kg", "mass of a dynamic body; replaces `density`");
  s.number("friction", body.friction, "[0, 10]", "1",
           "friction coefficient between dynamic bodies and this one; of two bodies, √(μ₁ μ₂) counts");
  s.number(
      "restitution", body.restitution, "[0, 1]", "1",
      "speed after an impact between dynamic bodies and this one over that before; of two bodies, √(e₁ e₂) counts");
  s.number("adhesion", body.adhesion, "[0, 10]", "N/m",
           "adhesion of liquid: work per unit area, σ (1 + cos θ) for a contact angle θ; 0 for dynamic and commanded "
           "bodies");
  s.number("slip", body.slip, slip_words, slip_range, "m",
           "`no`: viscous liquid sticks to the surface; `free`: no friction; a number: slip length");
  s.check(body.dynamic || !s.has("density"), "density",
          "applies only to dynamic bodies; allowed: only with dynamic: true");
  s.check(body.dynamic || !s.has("mass"), "mass", "applies only to dynamic bodies; allowed: only with dynamic: true");
  s.check(!s.has("density") || !s.has("mass"), "mass",
          "cannot be combined with density; allowed: exactly one of the two");
  const bool can_float = body.kind != Kind::plane && !body.inside && body.sequence.files.empty();
  s.not_available(body.dynamic && !can_float, "dynamic",
                  "a dynamic plane, container, thin vessel or mesh with a sequence",
                  "false, or a sphere, a box or a closed mesh without inside: true");
  check_offset(s, body.offset, 0);
  const bool moves = body.dynamic || !body.velocity.is_zero() || !body.offset.is_zero() ||
                     !body.spin.degrees_per_second.is_zero() || !body.sequence.files.empty();
  s.not_available(body.commanded && moves, "commanded", "a commanded body that moves by itself",
                  "false, or no dynamic, velocity, offset, spin or sequence");
  s.not_available(body.commanded && body.kind == Kind::plane, "commanded", "a commanded plane", "false, or a box");
  const bool keys = body.velocity.has_keys() || body.offset.has_keys() || body.spin.degrees_per_second.has_keys();
  s.not_available(body.dynamic && keys, "dynamic", "a dynamic body with keyframes", "false, or constants");
  s.not_available(body.dynamic && body.adhesion > 0, "adhesion", "adhesion to a dynamic body", "0 N/m");
  s.not_available(body.commanded && body.adhesion > 0, "adhesion", "adhesion to a commanded body", "0 N/m");
}

void describe_box(Section& s, BodyScene& body) {
  describe(s, body.box);
  s.boolean("inside", body.inside, "container: the inside of the box is free, the outside solid");
  describe_motion(s, body);
}

void describe_sphere(Section& s, BodyScene& body) {
  s.one_line();
  s.required().numbers("center", body.center, coordinate_range, "m", "initial centre");
  s.required().number("radius", body.radius, "[1e-6, 10000]", "m", "radius");
  describe_motion(s, body);
}

void describe_plane(Section& s, BodyScene& body) {
  s.one_line();
  s.required().numbers("point", body.point, coordinate_range, "m", "any point on its surface");
  s.required().numbers("normal", body.normal, direction_range, "1",
                       "points to the free side; its length does not matter");
  check_not_zero(s, "normal", body.normal);
  describe_motion(s, body);
}

void describe_rotate(Section& s, BodyScene& body) {
  s.numbers("axis", body.rotate_axis, direction_range, "1", "rotation axis; its length does not matter");
  s.number("degrees", body.rotate_degrees, "[-3600, 3600]", "degrees", "by the right-hand rule");
  check_not_zero(s, "axis", body.rotate_axis);
}

void describe_place(Section& s, BodyScene& body) {
  s.one_line();
  s.saved_if(body.stretch != BodyScene{}.stretch)
      .numbers(
          "scale", body.stretch, "[1e-6, 1e6]", "1",
          "scale factors along x, y and z, before the rotation, about the same point; a sphere becomes an ellipsoid");
  s.numbers("position", body.place, coordinate_range, "m", "displacement, in addition to `mesh.position`");
  s.section("rotate", body, describe_rotate,
            "rotation about the origin of the mesh file, the centre of the box or sphere, or the point of the plane");
}

void describe_mesh(Section& s, BodyScene& body) {
  s.one_line();
  describe_moving_file(s, body.file, body.sequence, "mesh file; a relative path starts at the scene's folder",
                       "files of a moving mesh with the same polygons, or a point cache, which moves `file`; its shape "
                       "may change if it encloses a volume");
  s.number("scale", body.scale, "[1e-9, 1e6]", "1", "scale factor of the file's coordinates");
  describe_coordinates(s, body.unit, body.up, true);
  s.numbers("position", body.position, coordinate_range, "m", "displacement of the scaled mesh");
  s.boolean("inside", body.inside,
            "thin vessel of one layer of triangles, for scenes without moving cloth; without this key the mesh is "
            "solid and its holes are closed");
  describe_motion(s, body);
  for (const char* key : {"velocity", "offset", "spin"})
    s.check(!s.has("sequence") || !s.has(key), key,
            "cannot be combined with sequence, which sets the motion; allowed: one of the two");
}

void describe_hinge(Section& s, JointScene& joint) {
  s.one_line();
  s.required().text("body", joint.body, "name of a dynamic body");
  s.saved_if(!joint.to.empty()).text("to", joint.to, "name of the body that it is hinged to; default: the world");
  s.required().numbers("point", joint.point, coordinate_range, "m", "a point on the axis, at the start");
  s.required().numbers("axis", joint.axis, direction_range, "1", "axis at the start; its length does not matter");
  check_not_zero(s, "axis", joint.axis);
  s.numbers("limits", joint.limits, "[-180, 180]", "degrees",
            "smallest and largest angle, by the right-hand rule, counted from the start; the default is no limit");
  s.check(joint.limits[0] <= 0 && joint.limits[1] >= 0, "limits",
          "excludes the start, where the angle is 0; allowed: [0 or less, 0 or more]");
  s.optional(joint.motor.present).section("motor", joint.motor, "turns the body; at speed 0, a brake or friction");
}

}  // namespace

void describe(Section& s, MotorScene& motor) {
  s.one_line();
  s.number("degrees_per_second", motor.degrees_per_second, "[-1e5, 1e5]", "degrees/s",
           "speed of the body relative to the other, by the right-hand rule");
  s.required().number("torque", motor.torque, "(0, 1e9]", "N·m", "largest torque");
}

void describe(Section& s, JointScene& joint) {
  s.one_line();
  s.required().section("hinge", joint, describe_hinge, "lets the body turn about one axis");
}

void describe(Section& s, BodyScene& body) {
  s.saved_if(!body.name.empty()).text("name", body.name, "name for programs, such as gripper");
  s.one_of(body.kind, Kind::box).section("box", body, describe_box, "axis-aligned box");
  s.one_of(body.kind, Kind::sphere).section("sphere", body, describe_sphere, "sphere");
  s.one_of(body.kind, Kind::plane).section("plane", body, describe_plane, "half-space");
  s.one_of(body.kind, Kind::mesh)
      .section("mesh", body, describe_mesh,
               "triangle mesh; holes are closed; a sheet that encloses no volume acts on liquid only and is rejected "
               "beside moving cloth");
  const BodyScene none;
  const bool placed =
      body.place != none.place || body.rotate_degrees != none.rotate_degrees || body.stretch != none.stretch;
  s.saved_if(body.kind == Kind::mesh || placed)
      .section("place", body, describe_place, "initial placement: scaled first, then rotated, then moved");
  s.check(body.kind != Kind::box || !body.inside || body.rotate_degrees == none.rotate_degrees, "place.rotate",
          "does not apply to containers; allowed: a box without inside: true, or a mesh");
  s.check(body.kind != Kind::plane || body.stretch == none.stretch, "place.scale",
          "does not apply to planes; allowed: the keys box, sphere, mesh");
}

}  // namespace drench
