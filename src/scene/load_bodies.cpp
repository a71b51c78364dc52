// Reads the solid bodies of a scene, and what other sections share with them.

#include <fmt/format.h>

#include "scene/load_sections.hpp"

namespace drench {
namespace {

/// What all bodies have: how they move.
void read_motion(Section& s, BodyScene& body) {
  s.numbers("velocity", body.velocity, speed_range, "m/s");
  s.section("spin", body.spin, read_spin);
  s.boolean("dynamic", body.dynamic);
  s.number("density", body.density, "[1, 30000]", "kg/m³");
  s.check(body.dynamic || !s.has("density"), "density",
          "is for a body that floats; allowed: only beside dynamic: true");
  const bool can_float = body.kind == BodyScene::Kind::sphere || (body.kind == BodyScene::Kind::box && !body.inside);
  s.not_available(body.dynamic && !can_float, "dynamic", "a plane, mesh or container that the liquid moves",
                  "false, or a sphere or a box that is not a container");
}
void read_adhesion(Section& s, BodyScene& body) {
  s.number("adhesion", body.adhesion, "[0, 10]", "N/m");
  s.not_available(body.dynamic && body.adhesion > 0, "adhesion", "adhesion to a body that floats", "0 N/m");
}

void read_body_box(Section& s, BodyScene& body) {
  body.kind = BodyScene::Kind::box;
  read_box(s, body.box);
  s.boolean("inside", body.inside);
  read_motion(s, body);
  read_adhesion(s, body);
}

void read_sphere(Section& s, BodyScene& body) {
  body.kind = BodyScene::Kind::sphere;
  s.required({"center", "radius"});
  s.numbers("center", body.center, coordinate_range, "m");
  s.number("radius", body.radius, "[1e-6, 10000]", "m");
  read_motion(s, body);
  read_adhesion(s, body);
}

void read_plane(Section& s, BodyScene& body) {
  body.kind = BodyScene::Kind::plane;
  s.required({"point", "normal"});
  s.numbers("point", body.point, coordinate_range, "m");
  s.numbers("normal", body.normal, "[-1e6, 1e6]", "1");
  check_not_zero(s, "normal", body.normal);
  read_motion(s, body);
  read_adhesion(s, body);
}

void read_body_mesh(Section& s, BodyScene& body) {
  body.kind = BodyScene::Kind::mesh;
  s.required({"file"});
  s.mesh_file("file", body.file);
  s.number("scale", body.scale, "[1e-9, 1e6]", "1");
  s.numbers("position", body.position, coordinate_range, "m");
  read_motion(s, body);
  read_adhesion(s, body);
}

}  // namespace

void read_box(Section& s, Box& box) {
  s.required({"min", "max"});
  s.numbers("min", box.min, coordinate_range, "m");
  s.numbers("max", box.max, coordinate_range, "m");
  for (std::size_t i = 0; i < 3; ++i) {
    s.check(box.min[i] < box.max[i], fmt::format("max.{}", i),
            fmt::format("{} is not above min ({}); allowed: more than min, in m", box.max[i], box.min[i]));
  }
}

void read_spin(Section& s, SpinScene& spin) {
  s.numbers("axis", spin.axis, "[-1e6, 1e6]", "1");
  s.number("degrees_per_second", spin.degrees_per_second, "[-1e5, 1e5]", "degrees/s");
  check_not_zero(s, "axis", spin.axis);
}

void read_body(Section& s, BodyScene& body) {
  s.one_of({"box", "sphere", "plane", "mesh"});
  s.section("box", body, read_body_box);
  s.section("sphere", body, read_sphere);
  s.section("plane", body, read_plane);
  s.section("mesh", body, read_body_mesh);
}

}  // namespace drench
