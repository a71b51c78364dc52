// The cloths of a scene, and how they are solved.

#include <fmt/format.h>

#include "scene/describe.hpp"
#include "scene/fabrics.hpp"

namespace drench {
namespace {

constexpr std::array<Word<double>, 2> clean_words{{{"auto", clean_automatically}, {"off", 0.0}}};
constexpr std::array<Word<double>, 2> weld_words{{{"auto", weld_automatically}, {"off", 0.0}}};

void describe_mesh(Section& s, ClothScene& cloth) {
  s.one_line();
  s.section("grid", cloth.grid, "a rectangle in x and z, centred on the origin");
  s.saved_if(!cloth.grid)
      .mesh_file("file", cloth.file, "a triangle mesh; a relative name starts at the scene's folder");
  s.saved_if(!cloth.grid)
      .number("scale", cloth.scale, "[1e-9, 1e6]", "1",
              "factor on the file's coordinates, which are then in `unit`; not for a grid");
  describe_coordinates(s, cloth.unit, cloth.up, !cloth.grid);
  s.check(s.has("grid") || s.has("file"), "grid", "neither grid nor file stands here; allowed: exactly one of them");
  s.check(!s.has("grid") || !s.has("file"), "file", "stands beside grid; allowed: exactly one of them");
  for (const char* key : {"scale", "unit", "up"})
    s.check(!s.has("grid") || !s.has(key), key, "is for mesh files; allowed: the size of the grid, in m");
}

void describe_rotate(Section& s, ClothScene& cloth) {
  s.numbers("axis", cloth.rotate_axis, direction_range, "1", "not 0; its length does not matter");
  s.number("degrees", cloth.rotate_degrees, "[-3600, 3600]", "degrees", "by the right-hand rule");
  check_not_zero(s, "axis", cloth.rotate_axis);
}

void describe_place(Section& s, ClothScene& cloth) {
  s.one_line();
  s.numbers("position", cloth.position, coordinate_range, "m", "how far it is moved");
  s.section("rotate", cloth, describe_rotate, "how it is turned, about the origin of its mesh");
}

void describe_pin_spin(Section& s, PinScene& pin) {
  describe(s, pin.spin);
  s.numbers("center", pin.center, coordinate_range, "m", "what they turn about; it moves with them");
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
          "stands beside diffusion, which is exponent 0 or 1; allowed: one of them");
  const double n = fabric.diffusion_exponent.value_or(fabric.diffusion == DiffusionLaw::degenerate ? 1 : 0);
  s.check(
      n + fabric.retention_exponent >= 1, "retention_exponent",
      fmt::format(
          "and the exponent of diffusion, {:g}, come to less than 1, and dry fabric would be wetted infinitely fast; "
          "allowed: [{:g}, 20]",
          n, std::max(0.2, 1 - n)));
}

void describe_porous(Section& s, MaterialScene& fabric) {
  s.number("solid_fraction", fabric.solid_fraction, "[0, 1)", "1", "Φ, the part of the fabric's volume that is fibre");
  s.number("absorption", fabric.absorption, "[0, 100]", "m²/s", "k_a, how fast dry fabric takes up liquid");
  s.number("uptake_velocity", fabric.uptake_velocity, "[0, 100]", "m/s",
           "u_a, the same in the fabric's own terms: above 0 it replaces `absorption` by u_a h² / (7.5 (1 − Φ) τ)");
  s.remark("m/s; above 0 it replaces absorption");
  s.number("max_saturation", fabric.max_saturation, "[1, 10]", "1",
           "s_max, the most that it holds; above 1 it is excess that drips");
  s.number("virtual_pressure", fabric.virtual_pressure, "[0, 1e5]", "m/s²", "k^p, pushes excess liquid out");
  s.number("emission_angle", fabric.emission_angle, "[1, 179]", "degrees",
           "θ^e: liquid leaves within this angle of the flow direction");
  s.number("emission_velocity", fabric.emission_velocity, "[0, 100]", "m/s",
           "u_e; excess is buffered for emission at the rate u_e / d");
  s.number("emission_ramp", fabric.emission_ramp, "[0, 100]", "s",
           "time over which a fresh particle's pressure and speed are ramped in");
  s.number("diffusivity", fabric.diffusivity, "[0, 1]", "m²/s",
           "D, how fast liquid spreads within the fabric; 0: it does not; with `weft_diffusivity` along the warp");
  s.number("weft_diffusivity", fabric.weft_diffusivity, "(0, 1]", "m²/s",
           "across the warp; without it as `diffusivity`");
  s.saved_if(!fabric.diffusion_exponent)
      .choice("diffusion", fabric.diffusion,
              {{"linear", DiffusionLaw::linear}, {"degenerate", DiffusionLaw::degenerate}},
              "`linear`: D as it is; `degenerate`: D grows with the saturation (sharp wet fronts)");
  s.number("diffusion_exponent", fabric.diffusion_exponent, "[0, 20]", "1",
           "n of D sⁿ with the saturation s, in place of `diffusion` (0: `linear`, 1: `degenerate`)");
  s.number("capillary_height", fabric.capillary_height, "[1e-6, 1000]", "m",
           "ℓ: at rest the saturation falls by 1 over this height");
  s.number("retention_exponent", fabric.retention_exponent, "[0.2, 20]", "1",
           "β: at rest the saturation is (1 − z/ℓ)^(1/β) at the height z; 1: a straight line; above 1 fabric stays "
           "full farther up");
  s.number("adhesion", fabric.wet_adhesion, "[0, 10]", "N/m",
           "work per area that parts wet fabric from wet fabric or a solid; with water 0.14 at most");
  s.number("permeability", fabric.permeability, "[0, 1e-4]", "m²",
           "k of the wet fabric across it: pressure drives liquid through, by Darcy's law; 0: it is tight to pressure");
  s.number("breakthrough_pressure", fabric.breakthrough_pressure, "[0, 1e9]", "Pa",
           "p_b, above 0 the fabric repels: up to this difference of pressure it takes and passes nothing; needs "
           "`permeability`");
  s.check(!(fabric.breakthrough_pressure > 0) || fabric.permeability > 0, "breakthrough_pressure",
          "says when liquid passes through, and the permeability is 0; allowed: permeability above 0");
  s.number("critical_saturation", fabric.critical_saturation, "[0, 1]", "1",
           "s_c: fabric that is drier than this dries more slowly, in proportion to its saturation; only with `air`");
  s.boolean("contact_wicking", fabric.contact_wicking,
            "liquid passes between layers that touch and both have this; needs `diffusivity` above 0");
  s.check(!fabric.contact_wicking || fabric.diffusivity > 0, "contact_wicking",
          "passes liquid on as well as the fabric conducts it, and its diffusivity is 0; allowed: diffusivity above 0");
  check_rates(s, fabric);
  check_powers(s, fabric);
}

void check_pins(Section& s, const ClothScene& cloth) {
  for (std::size_t i = 0; i < cloth.pins.size(); ++i) {
    s.check(cloth.dynamics || !moves(cloth.pins[i]), fmt::format("pin.{}", i),
            "moves pins of a cloth that does not move; allowed: only with dynamics: true");
  }
  if (!cloth.grid) return;
  const Index count = cloth.grid->nodes[0] * cloth.grid->nodes[1];
  for (std::size_t i = 0; i < cloth.pins.size(); ++i) {
    for (std::size_t k = 0; k < cloth.pins[i].nodes.size(); ++k) {
      s.check(cloth.pins[i].nodes[k] < count, fmt::format("pin.{}.nodes.{}", i, k),
              fmt::format("{} is not a node of the grid; allowed: [0, {}]", cloth.pins[i].nodes[k], count - 1));
    }
  }
}

void check_saturations(Section& s, const char* key, const std::vector<SaturationScene>& boxes,
                       const ClothScene& cloth) {
  double most = cloth.material.max_saturation;
  for (const RegionScene& region : cloth.regions) most = std::max(most, region.material.max_saturation);
  s.check(boxes.empty() || cloth.material.porous, key,
          "is for a cloth that takes up liquid; allowed: only beside the key porous");
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    s.check(boxes[i].value <= most, fmt::format("{}.{}.value", key, i),
            fmt::format("{} is above porous.max_saturation; allowed: [0, {}] (no unit)", boxes[i].value, most));
  }
}

/// Keys of woven cloth beside those whose place they take.
void check_weave(Section& s, const ClothScene& cloth) {
  const MaterialScene& fabric = cloth.material;
  s.check(!s.has("membrane") || !s.has("stretch"), "stretch", "stands beside membrane; allowed: one of them");
  s.check(!s.has("bending") || !s.has("bend"), "bend", "stands beside bending; allowed: one of them");
  const auto has_directions = [](const MaterialScene& f) { return f.membrane || f.bending || f.weft_diffusivity; };
  s.check(!fabric.has_warp || any_fabric(cloth, has_directions), "warp",
          "has nothing that it is the direction of; allowed: only beside membrane, bending or porous.weft_diffusivity");
  if (fabric.has_warp) check_not_zero(s, "warp", fabric.warp);
  s.check(!fabric.membrane || fabric.membrane->wet == 1 || fabric.porous, "membrane.wet",
          "is for a cloth that takes up liquid; allowed: only beside the key porous");
}

/// What a region needs of its cloth.
void check_regions(Section& s, const ClothScene& cloth) {
  const bool groups = !cloth.grid && (cloth.file.ends_with(".obj") || cloth.file.ends_with(".OBJ"));
  for (std::size_t i = 0; i < cloth.regions.size(); ++i) {
    const RegionScene& region = cloth.regions[i];
    const std::string key = fmt::format("regions.{}.", i);
    s.check(groups || region.kind != RegionScene::Kind::group, key + "group",
            fmt::format("is for a mesh with groups, and {} has none; allowed: box, or an .obj file",
                        cloth.grid ? "a grid" : "a .ply or .stl file"));
    s.check(!region.material.porous || cloth.material.porous, key + "porous",
            "is for a cloth that takes up liquid; allowed: only where the cloth has the key porous");
    s.check(!(region.material.diffusivity > 0) || cloth.material.diffusivity > 0, key + "porous.diffusivity",
            "is above 0, and the cloth's own is 0; allowed: 0, or a cloth with a diffusivity above 0");
  }
}

void describe_seams(Section& s, ClothScene& cloth) {
  s.saved_if(!cloth.grid)
      .number("weld", cloth.weld, weld_words, "[0, 1]", "m",
              "merges boundary points of the mesh file that are no farther apart than this, which sews seams of "
              "doubled points; "
              "`auto`: those that coincide up to a thousandth of the edges there; `off`: none");
  s.saved_if(!cloth.grid)
      .number("clean", cloth.clean, clean_words, "[0, 1]", "m",
              "removes triangles of the mesh file whose height is below this: short edges are collapsed, long ones flipped; "
              "`auto`: a hundredth of the mean edge; `off`: none");
  s.list("sew", cloth.sew, "seams that stitches pull together until `sew_time` and hold from then on");
  s.saved_if(!cloth.sew.empty()).number("sew_time", cloth.sew_time, "(0, 1e6]", "s", "until the seams are closed");
}

void check_sewing(Section& s, const ClothScene& cloth) {
  s.check(!s.has("weld") || !cloth.grid, "weld", "is for mesh files; a grid has no seams");
  s.check(!s.has("clean") || !cloth.grid, "clean", "is for mesh files; a grid has no slivers");
  s.check(!s.has("sew_time") || s.has("sew"), "sew_time", "is the time that seams take; allowed: only beside sew");
  s.check(cloth.sew.empty() || cloth.dynamics, "sew",
          "moves a cloth that does not move; allowed: only with dynamics: true");
  for (std::size_t i = 0; i < cloth.sew.size(); ++i)
    s.check(!cloth.grid || cloth.sew[i].kind != SewScene::Kind::groups, fmt::format("sew.{}.groups", i),
            "is for a mesh with groups, and a grid has none; allowed: loops, pairs, file");
}

void check_cloth(Section& s, const ClothScene& cloth) {
  check_sewing(s, cloth);
  check_regions(s, cloth);
  check_weave(s, cloth);
  for (const char* key : {"friction_wet", "damping_wet"})
    s.check(!s.has(key) || cloth.material.porous, key,
            "is for a cloth that takes up liquid; allowed: only beside the key porous");
  check_pins(s, cloth);
  check_saturations(s, "initial_saturation", cloth.initial_saturation, cloth);
  check_saturations(s, "hold_saturation", cloth.hold_saturation, cloth);
  s.check(cloth.initial_stain.empty() || cloth.material.porous, "initial_stain",
          "is for a cloth that takes up liquid; allowed: only beside the key porous");
}

}  // namespace

void describe(Section& s, ClothSolverScene& solver) {
  s.one_line();
  s.choice("method", solver.method, {{"pd", ClothMethod::pd}, {"xpbd", ClothMethod::xpbd}},
           "`pd`: Projective Dynamics; `xpbd`: XPBD on the same step, slower and independent");
  s.number("tolerance", solver.tolerance, "[1e-15, 0.5]", "1",
           "ends the solve: unbalanced forces over the forces that move the cloth");
  s.integer("max_iterations", solver.max_iterations, "[1, 100000]", "iterations",
            "most iterations of stage cloth; a third of it, but 100 at least, in each iteration of the density solve");
}

void describe(Section& s, GridScene& grid) {
  s.numbers("size", grid.size, "[1e-6, 1000]", "m", "its sides in x and z");
  s.integers("nodes", grid.nodes, "[2, 4096]", "nodes", "nodes along these sides");
}

void describe(Section& s, PinScene& pin) {
  using Kind = PinScene::Kind;
  s.one_line();
  s.one_of(pin.kind, Kind::corners).flag("corners", "the grid's four corners");
  s.one_of(pin.kind, Kind::edges).flag("edges", "all nodes on its boundary");
  s.one_of(pin.kind, Kind::box).section("box", pin.box, "nodes inside this box, after placing");
  s.one_of(pin.kind, Kind::nodes)
      .integer_list("nodes", pin.nodes, "[0, 2147483646]", "(the number of a node)",
                    "nodes by their number in this cloth");
  const bool motion = has_motion(pin), free = motion && pin.sequence.files.empty();
  s.saved_if(free).numbers("velocity", pin.velocity, speed_range, "m/s",
                           "of the pins, between `start` and `end`; a cloth with `dynamics: false` has none");
  s.saved_if(free).numbers("offset", pin.offset, coordinate_range, "m",
                           "keys of how far the pins are from where they start; added to what `velocity` does");
  describe_sequence(s, pin.sequence,
                    "files of the cloth's mesh, placed as it is: the pins go where their nodes are in them");
  s.saved_if(free).section("spin", pin, describe_pin_spin, "how the pins turn, between `start` and `end`");
  s.saved_if(free).number("start", pin.start, "[0, 1e6]", "s", "before it the pins stand still");
  s.saved_if(motion).number("end", pin.end, "[0, inf]", "s", "after it the pins stand still; after `start`");
  check_end_after_start(s, "the motion", pin.start, pin.end);
  check_offset(s, pin.offset, pin.start);
  for (const char* key : {"velocity", "offset", "spin", "start"})
    s.check(!s.has("sequence") || !s.has(key), key,
            "stands beside sequence, which says how the pins move; allowed: one");
}

void describe(Section& s, SewScene& sew) {
  using Kind = SewScene::Kind;
  constexpr const char* numbers = "[0, 2147483646]";
  s.one_line();
  s.one_of(sew.kind, Kind::loops)
      .integer_pairs("loops", sew.loops, numbers, "(the number of a boundary loop)",
                     "pairs of boundary loops, by the numbers that `drench check` lists");
  s.one_of(sew.kind, Kind::groups)
      .texts("groups", sew.groups, "two groups of faces of the .obj file, whose boundaries are sewn along each other");
  s.one_of(sew.kind, Kind::pairs)
      .integer_pairs("pairs", sew.pairs, numbers, "(the number of a point)",
                     "pairs of points, by their numbers in the mesh file, from 0");
  s.one_of(sew.kind, Kind::file)
      .other_file(
          "file", sew.file,
          "a text file with such a pair in each line, as `12 340`; a relative name starts at the scene's folder");
}

void describe(Section& s, SaturationScene& saturation) {
  s.one_line();
  s.required().section("box", saturation.box,
                       "of the nodes in it, after placing; the last box that holds a node counts");
  s.required().number("value", saturation.value, "[0, 10]", "1",
                      "saturation: liquid over what the pores hold; at most `porous.max_saturation`");
  s.number("concentration", saturation.concentration, concentration_range, "kg/kg",
           "of a solute in this liquid, or in what a reservoir supplies");
}

void describe(Section& s, StainScene& stain) {
  s.one_line();
  s.required().section("box", stain.box, "of the nodes in it, after placing; the last box that holds a node counts");
  s.required().number("value", stain.value, "[0, 1000]", "kg/m²", "solute per area of the fabric at rest");
}

void describe(Section& s, MembraneScene& membrane) {
  s.one_line();
  s.required().number("warp", membrane.warp, "[0.001, 1e9]", "N/m", "tension along the warp over its strain");
  s.required().number("weft", membrane.weft, "[0.001, 1e9]", "N/m", "tension along the weft over its strain");
  s.required().number("shear", membrane.shear, "[0, 1e9]", "N/m",
                      "shear force per width over the angle between the yarns, in radians");
  s.number("wet", membrane.wet, "[0.01, 1]", "1",
           "factor on all three at saturation 1, linear in between; only with `porous`");
}

void describe(Section& s, PlateScene& plate) {
  s.one_line();
  s.required().number("warp", plate.warp, "[0, 1e6]", "N·m", "moment per width over the curvature along the warp");
  s.required().number("weft", plate.weft, "[0, 1e6]", "N·m", "the same along the weft");
  s.required().number("twist", plate.twist, "[0, 1e6]", "N·m",
                      "the same of twisting; of a sheet that bends alike in all directions as along the warp");
}

void describe(Section& s, ClothScene& cloth) {
  MaterialScene& fabric = cloth.material;
  s.text("name", cloth.name, "its name in messages and frames; no two alike");
  s.required().section("mesh", cloth, describe_mesh, "its shape at rest: either `grid` or `file`");
  s.section("place", cloth, describe_place, "where it is at the start: turned first, then moved");
  describe_seams(s, cloth);
  describe_fabric(
      s,
      "a fabric whose measured values count where this cloth has no key of its own; those of `porous` where it "
      "has that key, `porous: {}` will do (docs/manual/fabrics.md)");
  s.number("areal_density", fabric.areal_density, "[1e-4, 1000]", "kg/m²", "mass of the dry fabric per area");
  s.number("thickness", fabric.thickness, "[1e-6, 1]", "m",
           "of the fabric; with `solid_fraction` what it can hold, and how far layers stay apart");
  s.number("compression", fabric.compression, "[0, 1e9]", "Pa",
           "pressure that compresses the fabric to half of its thickness; what friction holds it with between two "
           "solids that leave it less room");
  s.saved_if(!fabric.membrane)
      .number("stretch", fabric.stretch, "[0.001, 1e9]", "N/m", "membrane stiffness: Young's modulus times thickness");
  s.section(
      "membrane", fabric.membrane,
      "woven or knitted cloth: stiffness along warp and weft and in shear apart, on any mesh; in place of `stretch`");
  s.saved_if(!fabric.bending)
      .number("bend", fabric.bend, "[0, 1e6]", "N·m",
              "flexural rigidity; on a mesh file, where hinges bend, known to a fifth");
  s.section("bending", fabric.bending,
            "a thin plate, right on any mesh, with rigidities along warp and weft; in place of `bend`, only with "
            "method `pd`");
  s.optional(fabric.has_warp)
      .numbers("warp", fabric.warp, direction_range, "1",
               "direction of the warp in the mesh's own axes, before `place` turns it; each triangle takes its part "
               "within its plane, and its length does not matter. Without it the v of the file's texture coordinates, "
               "or z of a grid");
  s.number("damping", fabric.damping, "[0, 1e6]", "1/s", "of the nodes' velocity, as by air");
  s.number("strain_damping", fabric.strain_damping, "[0, 100]", "s",
           "a spring's force grows by this time × its rate of stretching (Kelvin–Voigt)");
  s.number("friction", fabric.friction, "[0, 10]", "1",
           "Coulomb friction of the dry fabric on solids and on cloth; usual 0.3–0.5");
  s.number("friction_wet", fabric.friction_wet, "[0, 10]", "1",
           "the same at saturation 1, usual 0.9–1.3; without it as `friction`; only with `porous`");
  s.number("damping_wet", fabric.damping_wet, "[0, 1e6]", "1/s",
           "`damping` at saturation 1; without it as `damping`; only with `porous`");
  s.number("strain_limit", fabric.strain_limit, "[0, 0.99]", "1",
           "ε: triangles keep their stretches within [1 − ε, 1 + ε]; 0: no limit");
  s.number("adhesion", fabric.adhesion, "[0, 10]", "N/m",
           "work per area that separates the liquid from the cloth, σ (1 + cos θ)");
  s.number("slip", cloth.slip, slip_words, slip_range, "m", "of viscous liquid on both sides of it, as that of bodies");
  s.number("sample_spacing", cloth.sample_spacing, "[1e-6, 1000]", "m",
           "the largest distance, at rest, between the samples of the cloth that liquid meets; without it "
           "`fluid.spacing`. Cloth that is stretched to λ times its length holds liquid with `fluid.spacing`/λ");
  s.list("pin", cloth.pins, "nodes that do not move, or move as prescribed");
  s.boolean("self_collision", cloth.self_collision,
            "it collides with itself and with other cloths that have this; costly, for cloth that folds");
  s.integer("settle", cloth.settle, "[1, 100000]", "1",
            "steps over which nodes that start inside a body are brought out of it");
  s.boolean("dynamics", cloth.dynamics, "false: a cloth that does not move (wicking, filters); no cloth solver runs");
  s.list("initial_saturation", cloth.initial_saturation,
         "how wet it is at the start, box by box; 0 elsewhere; only with `porous`");
  s.list("hold_saturation", cloth.hold_saturation,
         "reservoirs: what they supply is accounted for as a source; only with `porous`");
  s.list("initial_stain", cloth.initial_stain,
         "a solute that is on it at the start, box by box, besides that of `initial_saturation`; liquid dissolves it; "
         "only with `porous`");
  s.optional(fabric.porous)
      .section("porous", fabric, describe_porous, "the fabric takes up liquid; without it, it is a dry wall");
  RegionScene rest;
  rest.material = fabric;
  s.list("regions", cloth.regions, rest,
         "parts of another fabric, such as a hem, a seam or a patch; where two hold a triangle, the last one counts");
  check_cloth(s, cloth);
}

}  // namespace drench
