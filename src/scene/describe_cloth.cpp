// The cloths of a scene, and how they are solved.

#include <fmt/format.h>

#include "scene/describe.hpp"
#include "scene/fabrics.hpp"
#include "scene/saturation_limit.hpp"

namespace drench {
namespace {

constexpr std::array<Word<double>, 2> clean_words{{{"auto", clean_automatically}, {"off", 0.0}}};
constexpr std::array<Word<double>, 2> weld_words{{{"auto", weld_automatically}, {"off", 0.0}}};

void describe_mesh(Section& s, ClothScene& cloth) {
  s.one_line();
  s.section("grid", cloth.grid, "rectangle in x and z, centred on the origin");
  s.saved_if(!cloth.grid).mesh_file("file", cloth.file, "triangle mesh; a relative path starts at the scene's folder");
  s.saved_if(!cloth.grid)
      .number("scale", cloth.scale, "[1e-9, 1e6]", "1", "scale factor of the file's coordinates; not for a grid");
  describe_coordinates(s, cloth.unit, cloth.up, !cloth.grid);
  s.check(s.has("grid") || s.has("file"), "grid", "grid and file are both missing; allowed: exactly one of the two");
  s.check(!s.has("grid") || !s.has("file"), "file", "cannot be combined with grid; allowed: exactly one of the two");
  for (const char* key : {"scale", "unit", "up"})
    s.check(!s.has("grid") || !s.has(key), key, "applies only to mesh files; allowed: the size of the grid, in m");
}

void describe_rotate(Section& s, ClothScene& cloth) {
  s.numbers("axis", cloth.rotate_axis, direction_range, "1", "rotation axis; its length does not matter");
  s.number("degrees", cloth.rotate_degrees, "[-3600, 3600]", "degrees", "by the right-hand rule");
  check_not_zero(s, "axis", cloth.rotate_axis);
}

void describe_place(Section& s, ClothScene& cloth) {
  s.one_line();
  s.numbers("position", cloth.position, coordinate_range, "m", "displacement");
  s.section("rotate", cloth, describe_rotate, "rotation about the origin of the mesh");
}

void describe_pin_spin(Section& s, PinScene& pin) {
  describe(s, pin.spin);
  s.numbers("center", pin.center, coordinate_range, "m", "centre of rotation; moves with the pins");
}

/// A resolved scene has the motion of pins that differ from such as stand still.
bool has_motion(const PinScene& pin) {
  const PinScene still;
  return pin.velocity != still.velocity || pin.offset != still.offset || pin.sequence != still.sequence ||
         pin.spin != still.spin || pin.center != still.center || pin.start != still.start || pin.end != still.end;
}

/// Powers of the saturation.
void check_powers(Section& s, const MaterialScene& fabric) {
  s.check(!s.has("diffusion") || !s.has("diffusion_exponent"), "diffusion_exponent",
          "cannot be combined with diffusion, which sets the exponent to 0 or 1; allowed: one of the two");
  const double n = fabric.exponent();
  s.check(
      n + fabric.retention_exponent >= 1, "retention_exponent",
      fmt::format("and the diffusion exponent, {:g}, add up to less than 1, so dry fabric would wet infinitely fast; "
                  "allowed: [{:g}, 20]",
                  n, std::max(0.2, 1 - n)));
}

/// The rate of suction is bounded for powers of the saturation from 1 on alone (docs/theory/porous.md, section 18).
void check_suction(Section& s, const MaterialScene& fabric, const char* key) {
  s.check(fabric.diffusivity > 0, key, "requires diffusivity, which is 0; allowed: only with diffusivity above 0");
  s.check(
      fabric.exponent() >= 1, key,
      fmt::format("requires a diffusion exponent of at least 1, which is {:g}; allowed: with diffusion: degenerate, "
                  "or with diffusion_exponent of at least 1",
                  fabric.exponent()));
  s.check(fabric.retention_exponent >= 1, key,
          fmt::format("requires a retention_exponent of at least 1, which is {:g}; allowed: with at least 1",
                      fabric.retention_exponent));
}

void check_hysteresis(Section& s, const MaterialScene& fabric) {
  s.check(!(fabric.drainage_exponent > 0) || fabric.drainage_height > fabric.capillary_height, "drainage_exponent",
          "requires a drainage_height above capillary_height; allowed: only with that");
  if (!(fabric.drainage_height > 0)) return;
  s.check(fabric.drainage_height >= fabric.capillary_height, "drainage_height",
          fmt::format("is below capillary_height, {:g} m; allowed: at least that", fabric.capillary_height));
  check_suction(s, fabric, "drainage_height");
  s.check(!(fabric.drainage_exponent > 0) || fabric.drainage_exponent >= fabric.retention_exponent, "drainage_exponent",
          fmt::format("is below retention_exponent, {:g}; allowed: [{:g}, 20]", fabric.retention_exponent,
                      fabric.retention_exponent));
}

void check_large_pores(Section& s, const MaterialScene& fabric) {
  constexpr double least = 1.5, most = 100;  // of both heights' ratio
  s.check(!(fabric.large_pore_height > 0) || fabric.large_pores > 0, "large_pore_height",
          "requires large_pores, which is 0; allowed: only with large_pores above 0");
  if (!(fabric.large_pores > 0)) return;
  s.check(fabric.large_pore_height > 0, "large_pores", "requires large_pore_height, in m; allowed: only with both");
  s.check(fabric.large_pore_height * least <= fabric.capillary_height &&
              fabric.large_pore_height * most >= fabric.capillary_height,
          "large_pore_height",
          fmt::format("{:g} does not suit the capillary_height of the small pores, {:g} m; allowed: [{:g}, {:g}] m",
                      fabric.large_pore_height, fabric.capillary_height, fabric.capillary_height / most,
                      fabric.capillary_height / least));
  check_suction(s, fabric, "large_pores");
}

void check_narrowing(Section& s, const MaterialScene& fabric) {
  if (fabric.pore_narrowing != 0) check_suction(s, fabric, "pore_narrowing");
}

void describe_porous(Section& s, MaterialScene& fabric) {
  s.number("solid_fraction", fabric.solid_fraction, "[0, 1)", "1",
           "solid fraction Φ: fibre volume over fabric volume; porosity is 1 − Φ");
  s.number("absorption", fabric.absorption, "[0, 100]", "m²/s", "absorption rate k_a of dry fabric");
  s.number(
      "uptake_velocity", fabric.uptake_velocity, "[0, 100]", "m/s",
      "uptake velocity u_a, independent of the spacing: above 0 it replaces `absorption` by u_a h² / (7.5 (1 − Φ) τ)");
  s.remark("m/s; above 0 it replaces absorption");
  s.number("max_saturation", fabric.max_saturation, "[1, 10]", "1",
           "largest saturation s_max; liquid above 1 is excess, which drips");
  s.number("virtual_pressure", fabric.virtual_pressure, "[0, 1e5]", "m/s²",
           "coefficient k^p of the pressure that expels excess liquid");
  s.number("emission_angle", fabric.emission_angle, "[1, 179]", "degrees",
           "emission angle θ^e: liquid leaves within this angle of the flow direction");
  s.number("emission_velocity", fabric.emission_velocity, "[0, 100]", "m/s",
           "emission velocity u_e; excess is buffered for emission at the rate u_e / d");
  s.number("emission_ramp", fabric.emission_ramp, "[0, 100]", "s",
           "time over which pressure and speed of an emitted particle rise to their full values");
  s.number(
      "diffusivity", fabric.diffusivity, "[0, 1]", "m²/s",
      "diffusivity D of liquid within the fabric; 0 for no spreading; along the warp if `weft_diffusivity` is given");
  s.number("weft_diffusivity", fabric.weft_diffusivity, "(0, 1]", "m²/s",
           "diffusivity across the warp; default: `diffusivity`");
  s.saved_if(!fabric.diffusion_exponent)
      .choice("diffusion", fabric.diffusion,
              {{"linear", DiffusionLaw::linear}, {"degenerate", DiffusionLaw::degenerate}},
              "`linear`: constant D; `degenerate`: D proportional to the saturation, for sharp wet fronts");
  s.number("diffusion_exponent", fabric.diffusion_exponent, "[0, 20]", "1",
           "exponent n of D sⁿ with the saturation s; replaces `diffusion` (0: `linear`, 1: `degenerate`)");
  s.number("capillary_height", fabric.capillary_height, "[1e-6, 1000]", "m",
           "equilibrium wicking height ℓ: at rest the saturation falls by 1 over this height");
  s.number("retention_exponent", fabric.retention_exponent, "[0.2, 20]", "1",
           "retention exponent β: at rest the saturation at height z is (1 − z/ℓ)^(1/β); above 1 the fabric stays "
           "full to a greater height");
  s.number("drainage_height", fabric.drainage_height, "[0, 1000]", "m",
           "height ℓ_d that replaces `capillary_height` where the fabric drains (hysteresis); at least that; 0: no "
           "hysteresis");
  s.number("drainage_exponent", fabric.drainage_exponent, "[0, 20]", "1",
           "retention exponent where the fabric drains; at least `retention_exponent`; 0: as that; requires "
           "`drainage_height`");
  s.number("large_pores", fabric.large_pores, "[0, 0.95]", "1",
           "share w of the pore volume that lies between yarns, in large pores; `capillary_height` and `diffusivity` "
           "are then those of the small ones within yarns; 0: pores of one kind");
  s.number(
      "large_pore_height", fabric.large_pore_height, "[0, 1000]", "m",
      "equilibrium wicking height of the large pores, below that of the small ones by a factor of 1.5 to 100; requires "
      "`large_pores`");
  s.number("pore_narrowing", fabric.pore_narrowing, "[-20, 20]", "1",
           "relative narrowing c of pores under stretch: at the area strain e liquid rises 1 + c e times as high and "
           "spreads as many times more slowly; below 0 they widen");
  s.number("adhesion", fabric.wet_adhesion, "[0, 10]", "N/m",
           "adhesion of wet fabric to wet fabric or a solid: work per unit area; at most 0.14 with water");
  s.number("film", fabric.film, "[0, 0.01]", "m",
           "thickest film δ of liquid on each face of soaked fabric; it runs down and drips at the lowest places; "
           "replaces `max_saturation` by 1 + 2 δ / ((1 − Φ) τ); 0: no film");
  s.number("film_viscosity", fabric.film_viscosity, "[0, 1]", "m²/s",
           "kinematic viscosity of the film; 0: that of the liquid (`fluid.viscosity`); water: 1e-6");
  s.check(!(fabric.film_viscosity > 0) || fabric.film > 0, "film_viscosity",
          "requires film, which is 0; allowed: only with film above 0");
  s.check(!(fabric.film > 0) || fabric.diffusivity > 0, "film",
          "requires diffusivity, which is 0; allowed: only with diffusivity above 0");
  s.number("permeability", fabric.permeability, "[0, 1e-4]", "m²",
           "permeability k of the wet fabric through its thickness, for flow by Darcy's law; 0: impermeable");
  s.number("forchheimer", fabric.forchheimer, "[0, 1e9]", "1/m",
           "Forchheimer coefficient β: flow at u m/s through the thickness τ costs ρ0 β τ u² beside Darcy's pressure");
  s.number("fibre_diameter", fabric.fibre_diameter, "[0, 1e-2]", "m",
           "diameter of the fibres; sets `forchheimer` by Ergun's equation; 0: not known");
  check_drag(s, fabric);
  s.number("breakthrough_pressure", fabric.breakthrough_pressure, "[0, 1e9]", "Pa",
           "breakthrough pressure p_b of repellent fabric: below this pressure difference it absorbs and passes "
           "nothing; requires `permeability`");
  s.check(!(fabric.breakthrough_pressure > 0) || fabric.permeability > 0, "breakthrough_pressure",
          "requires permeability, which is 0; allowed: only with permeability above 0");
  s.number("critical_saturation", fabric.critical_saturation, "[0, 1]", "1",
           "critical saturation s_c below which drying slows down in proportion to the saturation; only with `air`");
  s.number("hygral_expansion", fabric.hygral_expansion, "[-0.5, 0.5]", "1",
           "relative growth of the fabric's lengths at saturation 1, linear in the saturation; below 0 it shrinks");
  s.number(
      "compressibility", fabric.compressibility, "[0, 1)", "1",
      "largest share c of the thickness that pressure takes from the fabric, and from its pores: at the pressure p "
      "c p / (p + `compression`); at most 1 − Φ; 0: the pores keep their volume");
  s.check(fabric.compressibility <= 1 - fabric.solid_fraction, "compressibility",
          fmt::format("{} would compress the fibres; allowed: at most 1 - solid_fraction = {}", fabric.compressibility,
                      1 - fabric.solid_fraction));
  s.boolean("contact_wicking", fabric.contact_wicking,
            "transfer of liquid between touching layers that both have this key; requires `diffusivity` above 0");
  s.check(!fabric.contact_wicking || fabric.diffusivity > 0, "contact_wicking",
          "requires diffusivity, which is 0; allowed: only with diffusivity above 0");
  check_rates(s, fabric);
  check_powers(s, fabric);
  check_hysteresis(s, fabric);
  check_large_pores(s, fabric);
  check_narrowing(s, fabric);
}

void check_pins(Section& s, const ClothScene& cloth) {
  for (std::size_t i = 0; i < cloth.pins.size(); ++i) {
    s.check(cloth.dynamics || !moves(cloth.pins[i]), fmt::format("pin.{}", i),
            "moves pins of a cloth with dynamics: false; allowed: only with dynamics: true");
    s.check(cloth.dynamics || !cloth.pins[i].stiffness, fmt::format("pin.{}.stiffness", i),
            "holds a cloth with dynamics: false by springs; allowed: only with dynamics: true");
  }
  if (!cloth.grid) return;
  const Index count = cloth.grid->nodes[0] * cloth.grid->nodes[1];
  for (std::size_t i = 0; i < cloth.pins.size(); ++i) {
    s.check(!cloth.pins[i].sequence.is_cache(), fmt::format("pin.{}.sequence", i),
            "is a point cache, which moves the points of a mesh file; allowed: a cloth with mesh.file");
    for (std::size_t k = 0; k < cloth.pins[i].nodes.size(); ++k) {
      s.check(cloth.pins[i].nodes[k] < count, fmt::format("pin.{}.nodes.{}", i, k),
              fmt::format("{} is not a node of the grid; allowed: [0, {}]", cloth.pins[i].nodes[k], count - 1));
    }
  }
}

void check_saturations(Section& s, const char* key, const std::vector<SaturationScene>& boxes,
                       const ClothScene& cloth) {
  const MaterialScene* most_of = &cloth.material;
  for (const RegionScene& region : cloth.regions)
    if (region.material.ceiling() > most_of->ceiling()) most_of = &region.material;
  const double most = most_of->ceiling();
  const std::string limit = most_of->has_film() ? "what porous.film allows" : "porous.max_saturation";
  s.check(boxes.empty() || cloth.material.porous, key,
          "applies only to absorbent cloth; allowed: only if the cloth has the key porous");
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    s.check(!exceeds(boxes[i].value, most), fmt::format("{}.{}.value", key, i),
            fmt::format("{} is above {}; allowed: [0, {:.9g}] (no unit)", boxes[i].value, limit, most));
  }
}

/// Keys of woven cloth beside those whose place they take.
void check_weave(Section& s, const ClothScene& cloth) {
  const MaterialScene& fabric = cloth.material;
  s.check(!s.has("membrane") || !s.has("stretch"), "stretch",
          "cannot be combined with membrane; allowed: one of the two");
  s.check(!s.has("bending") || !s.has("bend"), "bend", "cannot be combined with bending; allowed: one of the two");
  const auto has_directions = [](const MaterialScene& f) { return f.membrane || f.bending || f.weft_diffusivity; };
  s.check(!fabric.has_warp || any_fabric(cloth, has_directions), "warp",
          "has no effect without properties along warp and weft; allowed: only with membrane, bending or "
          "porous.weft_diffusivity");
  if (fabric.has_warp) check_not_zero(s, "warp", fabric.warp);
  s.check(!fabric.membrane || fabric.membrane->wet == 1 || fabric.porous, "membrane.wet",
          "applies only to absorbent cloth; allowed: only if the cloth has the key porous");
}

void describe_seams(Section& s, ClothScene& cloth) {
  s.saved_if(!cloth.grid)
      .number("weld", cloth.weld, weld_words, "[0, 1]", "m",
              "merges boundary points of the mesh file up to this distance, which closes seams of doubled points; "
              "`auto`: a thousandth of the adjacent edges; `off`: no merging");
  s.saved_if(!cloth.grid)
      .number("clean", cloth.clean, clean_words, "[0, 1]", "m",
              "removes triangles of the mesh file that are lower than this by collapsing and flipping edges; `auto`: a "
              "hundredth of the mean edge; `off`: none");
  s.list("sew", cloth.sew, "seams that stitches close until `sew_time` and hold afterwards");
  s.saved_if(!cloth.sew.empty())
      .number("sew_time", cloth.sew_time, "(0, 1e6]", "s", "time at which the seams are closed");
}

void check_sewing(Section& s, const ClothScene& cloth) {
  s.check(!s.has("weld") || !cloth.grid, "weld", "applies only to mesh files; a grid has no seams");
  s.check(!s.has("clean") || !cloth.grid, "clean", "applies only to mesh files; a grid has no slivers");
  s.check(!s.has("sew_time") || s.has("sew"), "sew_time", "has no effect without seams; allowed: only with sew");
  s.check(cloth.sew.empty() || cloth.dynamics, "sew",
          "moves a cloth with dynamics: false; allowed: only with dynamics: true");
  for (std::size_t i = 0; i < cloth.sew.size(); ++i)
    s.check(!cloth.grid || cloth.sew[i].kind != SewScene::Kind::groups, fmt::format("sew.{}.groups", i),
            "applies only to meshes with groups, and a grid has none; allowed: loops, pairs, file");
}

void check_cloth(Section& s, const ClothScene& cloth) {
  check_sewing(s, cloth);
  check_regions(s, cloth);
  check_weave(s, cloth);
  for (const char* key : {"friction_wet", "damping_wet"})
    s.check(!s.has(key) || cloth.material.porous, key,
            "applies only to absorbent cloth; allowed: only if the cloth has the key porous");
  check_pins(s, cloth);
  s.check(cloth.dynamics || cloth.velocity == Vec3{0, 0, 0}, "velocity",
          "moves a cloth with dynamics: false; allowed: only with dynamics: true");
  check_saturations(s, "initial_saturation", cloth.initial_saturation, cloth);
  check_saturations(s, "hold_saturation", cloth.hold_saturation, cloth);
  s.check(cloth.initial_stain.empty() || cloth.material.porous, "initial_stain",
          "applies only to absorbent cloth; allowed: only if the cloth has the key porous");
}

}  // namespace

void describe(Section& s, ClothSolverScene& solver) {
  s.one_line();
  s.choice(
      "method", solver.method, {{"pd", ClothMethod::pd}, {"xpbd", ClothMethod::xpbd}},
      "`pd`: Newton's method on a CPU; on a GPU Projective Dynamics, and Newton's method on the CPU where that does "
      "not converge; `xpbd`: XPBD for the same step, independent and slower");
  s.number("tolerance", solver.tolerance, "[1e-15, 0.5]", "1",
           "residual force, relative to the forces that move the cloth, at which the solver stops");
  s.integer("max_iterations", solver.max_iterations, "[1, 100000]", "iterations",
            "iteration limit per step; in each iteration of the density solver a third of it, but at least 100");
}

void describe(Section& s, GridScene& grid) {
  s.numbers("size", grid.size, "[1e-6, 1000]", "m", "side lengths in x and z");
  s.integers("nodes", grid.nodes, "[2, 4096]", "nodes", "number of nodes along the sides");
}

void describe(Section& s, PinScene& pin) {
  using Kind = PinScene::Kind;
  s.one_line();
  s.one_of(pin.kind, Kind::corners).flag("corners", "the four corners of a grid");
  s.one_of(pin.kind, Kind::edges).flag("edges", "all boundary nodes");
  s.one_of(pin.kind, Kind::box).section("box", pin.box, "nodes inside this box, after placement");
  s.one_of(pin.kind, Kind::nodes)
      .integer_list("nodes", pin.nodes, "[0, 2147483646]", "(the number of a node)", "nodes by number, from 0");
  const bool motion = has_motion(pin), free = motion && pin.sequence.files.empty();
  s.saved_if(free).numbers("velocity", pin.velocity, speed_range, "m/s",
                           "velocity between `start` and `end`; not with `dynamics: false`");
  s.saved_if(free).numbers("offset", pin.offset, coordinate_range, "m",
                           "keyframes of the displacement from the start; added to the motion by `velocity`");
  describe_sequence(s, pin.sequence,
                    "files of the moving cloth mesh, or a point cache of it; the pins follow their nodes in them");
  s.saved_if(!pin.body.empty())
      .text("body", pin.body, "name of a body that the pins move and turn with, such as a gripper; not a dynamic one");
  s.number("stiffness", pin.stiffness, "(0, 1e9]", "N/m",
           "holds the nodes by springs of this stiffness in all, shared out by mass; default: rigid");
  s.saved_if(pin.stiffness.has_value())
      .number("release", pin.release, "[0, inf]", "s", "time at which the springs let go; only with `stiffness`");
  s.check(!s.has("release") || pin.stiffness, "release",
          "needs a pin that holds by springs; allowed: only with stiffness, such as 1e4 N/m");
  s.saved_if(free).section("spin", pin, describe_pin_spin, "rotation between `start` and `end`");
  s.saved_if(free).number("start", pin.start, "[0, 1e6]", "s", "time at which the motion starts");
  s.saved_if(motion).number("end", pin.end, "[0, inf]", "s", "time at which the motion ends; after `start`");
  check_end_after_start(s, "the motion", pin.start, pin.end);
  check_offset(s, pin.offset, pin.start);
  for (const char* key : {"velocity", "offset", "spin", "start"})
    s.check(!s.has("sequence") || !s.has(key), key,
            "cannot be combined with sequence, which sets the motion; allowed: one of the two");
  for (const char* key : {"velocity", "offset", "spin", "sequence", "start", "end"})
    s.check(!s.has("body") || !s.has(key), key,
            "cannot be combined with body, which sets the motion; allowed: one of the two");
}

void describe(Section& s, SewScene& sew) {
  using Kind = SewScene::Kind;
  constexpr const char* numbers = "[0, 2147483646]";
  s.one_line();
  s.one_of(sew.kind, Kind::loops)
      .integer_pairs("loops", sew.loops, numbers, "(the number of a boundary loop)",
                     "pairs of boundary loops, as numbered by `drench check`");
  s.one_of(sew.kind, Kind::groups)
      .texts("groups", sew.groups, "two groups of faces of the .obj file; their boundaries are sewn together");
  s.one_of(sew.kind, Kind::pairs)
      .integer_pairs("pairs", sew.pairs, numbers, "(the number of a point)",
                     "pairs of points of the mesh file, counted from 0");
  s.one_of(sew.kind, Kind::file)
      .other_file(
          "file", sew.file,
          "text file with one such pair per line, for example `12 340`; a relative path starts at the scene's folder");
}

void describe(Section& s, SaturationScene& saturation) {
  s.one_line();
  s.required().section("box", saturation.box,
                       "box that selects nodes, after placement; where boxes overlap, the last one applies");
  s.required().number("value", saturation.value, "[0, 10]", "1",
                      "saturation: liquid relative to the capacity of the voids; at most `porous.max_saturation`");
  s.number("concentration", saturation.concentration, concentration_range, "kg/kg",
           "mass fraction of the solute in this liquid, or in the liquid supplied");
}

void describe(Section& s, StainScene& stain) {
  s.one_line();
  s.required().section("box", stain.box,
                       "box that selects nodes, after placement; where boxes overlap, the last one applies");
  s.required().number("value", stain.value, "[0, 1000]", "kg/m²", "solute per unit area of the fabric at rest");
}

void describe(Section& s, MembraneScene& membrane) {
  s.one_line();
  s.required().number("warp", membrane.warp, "[0.001, 1e9]", "N/m", "tension per strain along the warp");
  s.required().number("weft", membrane.weft, "[0.001, 1e9]", "N/m", "tension per strain along the weft");
  s.required().number("shear", membrane.shear, "[0, 1e9]", "N/m",
                      "shear force per width and per change of the angle between the yarns, in radians");
  s.number("wet", membrane.wet, "[0.01, 1]", "1",
           "factor on all three at saturation 1, linear in the saturation; only with `porous`");
  s.number("warp_locking", membrane.warp_locking, "[0, 10]", "1",
           "locking strain e_L: at the strain e above 0 the tension along the warp is `warp` e / (1 - (e/e_L)²), "
           "up to 20 times as stiff; 0: never");
  s.number("weft_locking", membrane.weft_locking, "[0, 10]", "1", "the same along the weft");
}

void describe(Section& s, PlateScene& plate) {
  s.one_line();
  s.required().number("warp", plate.warp, "[0, 1e6]", "N·m", "bending moment per width and curvature along the warp");
  s.required().number("weft", plate.weft, "[0, 1e6]", "N·m", "bending moment per width and curvature along the weft");
  s.required().number("twist", plate.twist, "[0, 1e6]", "N·m",
                      "twisting moment per width and twist; equal to `warp` for an isotropic sheet");
}

void describe(Section& s, ClothScene& cloth) {
  MaterialScene& fabric = cloth.material;
  s.text("name", cloth.name, "name in messages and frames; must be unique");
  s.required().section("mesh", cloth, describe_mesh, "rest shape: either `grid` or `file`");
  s.section("place", cloth, describe_place, "initial placement: rotated first, then moved");
  describe_seams(s, cloth);
  describe_fabric(
      s,
      "fabric that supplies defaults for this cloth, and for `porous` if the cloth has that section, such as "
      "`porous: {}` (docs/manual/fabrics.md); also a .yaml file, as `drench fit` writes it");
  s.number("areal_density", fabric.areal_density, "[1e-4, 1000]", "kg/m²",
           "mass per unit area of the dry fabric; 150 g/m² is 0.15");
  s.number("thickness", fabric.thickness, "[1e-6, 1]", "m",
           "fabric thickness; determines the liquid that it can hold, with `solid_fraction`, and the distance between "
           "layers");
  s.number("compression", fabric.compression, "[0, 1e9]", "Pa",
           "pressure that halves the thickness, or with `porous.compressibility` takes half of that; determines the "
           "friction "
           "on cloth that two solids squeeze");
  s.saved_if(!fabric.membrane)
      .number("stretch", fabric.stretch, "[0.001, 1e9]", "N/m", "tensile stiffness: Young's modulus times thickness");
  s.section("membrane", fabric.membrane,
            "separate stiffness along warp and weft and in shear, on any mesh; replaces `stretch`");
  s.saved_if(!fabric.bending)
      .number("bend", fabric.bend, "[0, 1e6]", "N·m",
              "flexural rigidity of a hinge model, which is accurate to about 20 % on mesh files");
  s.section(
      "bending", fabric.bending,
      "thin-plate model for any mesh, with rigidities along warp and weft; replaces `bend`; only with `method: pd`");
  s.optional(fabric.has_warp)
      .numbers("warp", fabric.warp, direction_range, "1",
               "warp direction in the axes of the mesh, before `place` is applied, projected onto each triangle; its "
               "length does not matter. Default: the v direction of the file's texture coordinates, or z of a grid");
  s.number("damping", fabric.damping, "[0, 1e6]", "1/s", "damping rate of node velocities, as by air");
  s.number("strain_damping", fabric.strain_damping, "[0, 100]", "s",
           "Kelvin–Voigt damping: a spring's force grows by this time × its strain rate");
  s.number("friction", fabric.friction, "[0, 10]", "1",
           "Coulomb friction coefficient of the dry fabric on solids and cloth; typically 0.3–0.5");
  s.number("friction_wet", fabric.friction_wet, "[0, 10]", "1",
           "friction coefficient at saturation 1, typically 0.9–1.3; default: `friction`; only with `porous`");
  s.number("damping_wet", fabric.damping_wet, "[0, 1e6]", "1/s",
           "`damping` at saturation 1; default: `damping`; only with `porous`");
  s.number("strain_limit", fabric.strain_limit, "[0, 0.99]", "1",
           "strain limit ε: stretch stays within [1 − ε, 1 + ε]; 0 for no limit");
  s.number("adhesion", fabric.adhesion, "[0, 10]", "N/m",
           "adhesion of liquid: work per unit area, σ (1 + cos θ) for a contact angle θ");
  s.number("slip", cloth.slip, slip_words, slip_range, "m", "slip of viscous liquid on both sides, as for bodies");
  s.number("sample_spacing", cloth.sample_spacing, "[1e-6, 1000]", "m",
           "largest distance at rest between the cloth's quadrature points (samples), which interact with the liquid; "
           "default: `fluid.spacing`. For cloth stretched by a factor λ use `fluid.spacing`/λ");
  s.list("pin", cloth.pins, "nodes that are held or move as prescribed");
  s.boolean(
      "self_collision", cloth.self_collision,
      "collisions with itself and with other cloths that have this key; for cloth that folds; increases run time");
  s.integer("settle", cloth.settle, "[1, 100000]", "1",
            "number of steps of length `time.step` over which nodes that start inside a body are moved out");
  s.boolean("dynamics", cloth.dynamics, "`false`: the cloth does not move and is not solved, for wicking and filters");
  s.saved_if(cloth.velocity != Vec3{0, 0, 0})
      .numbers("velocity", cloth.velocity, speed_range, "m/s",
               "initial velocity of the nodes that are not pinned; not with `dynamics: false`");
  s.list("initial_saturation", cloth.initial_saturation,
         "initial saturation inside boxes; 0 elsewhere; only with `porous`");
  s.list("hold_saturation", cloth.hold_saturation,
         "fixed-saturation boundaries; liquid that they supply is recorded as a source; only with `porous`");
  s.list("initial_stain", cloth.initial_stain,
         "dry solute inside boxes at the start, in addition to that of `initial_saturation`; liquid dissolves it; "
         "only with `porous`");
  s.optional(fabric.porous)
      .section("porous", fabric, describe_porous, "absorbent fabric; without this section the cloth acts as a wall");
  RegionScene rest;
  rest.material = fabric;
  s.list("regions", cloth.regions, rest,
         "parts of another fabric, such as a hem or a patch; where two overlap, the last one applies");
  check_cloth(s, cloth);
}

}  // namespace drench
