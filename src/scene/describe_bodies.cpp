// The solid bodies of a scene.

#include "scene/describe.hpp"

namespace drench {
namespace {

using Kind = BodyScene::Kind;

/// Of every body: how it moves, and how the liquid sticks to it.
void describe_motion(Section& s, BodyScene& body) {
  const bool free = body.sequence.files.empty();  // else its files say how it moves
  s.saved_if(free).numbers("velocity", body.velocity, speed_range, "m/s",
                           "prescribed and without end; of a dynamic body only how it starts, and plain");
  s.saved_if(free).numbers("offset", body.offset, coordinate_range, "m",
                           "keys of how far the body is from where it starts; added to what `velocity` does");
  s.saved_if(free).section(
      "spin", body.spin,
      "about the centre of box, sphere or the mesh's bounding box, or the plane's point; as `velocity`");
  s.boolean("dynamic", body.dynamic,
            "floats and sinks, pushed by liquid and gravity: spheres and boxes that are no container; only with "
            "`fluid`");
  s.saved_if(body.dynamic)
      .number("density", body.density, "[1, 30000]", "kg/m³", "of a dynamic body, and only beside `dynamic: true`");
  s.number(
      "adhesion", body.adhesion, "[0, 10]", "N/m",
      "work per area that separates the liquid from the body, σ (1 + cos θ) for a contact angle θ; 0 where it floats");
  s.number(
      "slip", body.slip, slip_words, slip_range, "m",
      "`no`: viscous liquid moves with the surface; `free`: it feels no friction there; between them a slip length");
  s.check(body.dynamic || !s.has("density"), "density",
          "is for a body that floats; allowed: only beside dynamic: true");
  const bool can_float = body.kind == Kind::sphere || (body.kind == Kind::box && !body.inside);
  s.not_available(body.dynamic && !can_float, "dynamic", "a plane, mesh or container that the liquid moves",
                  "false, or a sphere or a box that is not a container");
  check_offset(s, body.offset, 0);
  const bool keys = body.velocity.has_keys() || body.offset.has_keys() || body.spin.degrees_per_second.has_keys();
  s.not_available(body.dynamic && keys, "dynamic", "a body that liquid moves and keys move", "false, or plain values");
  s.not_available(body.dynamic && body.adhesion > 0, "adhesion", "adhesion to a body that floats", "0 N/m");
}

void describe_box(Section& s, BodyScene& body) {
  describe(s, body.box);
  s.boolean("inside", body.inside, "a container: the box's inside is free and its outside solid");
  describe_motion(s, body);
}

void describe_sphere(Section& s, BodyScene& body) {
  s.one_line();
  s.required().numbers("center", body.center, coordinate_range, "m", "at the start");
  s.required().number("radius", body.radius, "[1e-6, 10000]", "m", "of the ball");
  describe_motion(s, body);
}

void describe_plane(Section& s, BodyScene& body) {
  s.one_line();
  s.required().numbers("point", body.point, coordinate_range, "m", "any point of its surface");
  s.required().numbers("normal", body.normal, direction_range, "1",
                       "points to the free side; its length does not matter; not 0");
  check_not_zero(s, "normal", body.normal);
  describe_motion(s, body);
}

void describe_rotate(Section& s, BodyScene& body) {
  s.numbers("axis", body.rotate_axis, direction_range, "1", "not 0; its length does not matter");
  s.number("degrees", body.rotate_degrees, "[-3600, 3600]", "degrees", "by the right-hand rule");
  check_not_zero(s, "axis", body.rotate_axis);
}

void describe_place(Section& s, BodyScene& body) {
  s.one_line();
  s.numbers("position", body.place, coordinate_range, "m", "how far it is moved, besides `mesh.position`");
  s.section("rotate", body, describe_rotate, "how it is turned, about the origin of its file");
}

void describe_mesh(Section& s, BodyScene& body) {
  s.one_line();
  const bool moving = !body.sequence.files.empty();
  s.saved_if(!moving).mesh_file("file", body.file, "a relative name starts at the scene's folder");
  describe_sequence(s, body.sequence,
                    "files of a mesh that moves, and may change its shape if it has an inside; each has the same polygons");
  if (!body.sequence.files.empty()) body.file = body.sequence.files.front();
  s.check(s.has("file") != s.has("sequence"), s.has("file") ? "sequence" : "file",
          s.has("file") ? "stands beside file; allowed: exactly one of them"
                        : "neither file nor sequence stands here; allowed: exactly one of them");
  s.number("scale", body.scale, "[1e-9, 1e6]", "1", "factor on the file's coordinates, which are then in `unit`");
  describe_coordinates(s, body.unit, body.up, true);
  s.numbers("position", body.position, coordinate_range, "m", "added to the scaled mesh");
  s.boolean("inside", body.inside,
            "a vessel of one layer of triangles: both sides are free, and it holds liquid only; without it the mesh is solid, and "
            "its holes are covered");
  describe_motion(s, body);
  for (const char* key : {"velocity", "offset", "spin"})
    s.check(!s.has("sequence") || !s.has(key), key,
            "stands beside sequence, which says how the mesh moves; allowed: one");
}

}  // namespace

void describe(Section& s, BodyScene& body) {
  s.one_of(body.kind, Kind::box).section("box", body, describe_box, "a box along the axes");
  s.one_of(body.kind, Kind::sphere).section("sphere", body, describe_sphere, "a ball");
  s.one_of(body.kind, Kind::plane).section("plane", body, describe_plane, "a half-space");
  s.one_of(body.kind, Kind::mesh)
      .section("mesh", body, describe_mesh, "a solid of triangles; holes are covered, and a sheet that encloses nothing holds liquid only");
  s.saved_if(body.kind == Kind::mesh)
      .section("place", body, describe_place, "where a mesh is at the start: turned first, then moved");
  s.check(!s.has("place") || body.kind == Kind::mesh, "place",
          "is for a mesh; allowed: only beside the key mesh, for the others have keys of their own");
}

}  // namespace drench
