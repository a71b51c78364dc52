// The regions of a cloth: parts whose fabric differs from the rest.

#include <fmt/format.h>

#include "scene/describe.hpp"
#include "scene/fabrics.hpp"

namespace drench {
namespace {

constexpr const char* of_the_cloth = "cannot differ between regions; allowed: only as a key of the cloth";
constexpr const char* as_the_cloth = "as for the cloth, in this region";

/// A section whose values begin as the cloth's: none of its keys is required.
void describe_other_membrane(Section& s, MembraneScene& membrane) {
  s.one_line();
  s.number("warp", membrane.warp, "[0.001, 1e9]", "N/m", as_the_cloth);
  s.number("weft", membrane.weft, "[0.001, 1e9]", "N/m", as_the_cloth);
  s.number("shear", membrane.shear, "[0, 1e9]", "N/m", as_the_cloth);
  s.number("wet", membrane.wet, "[0.01, 1]", "1", as_the_cloth);
  s.number("warp_locking", membrane.warp_locking, "[0, 10]", "1", as_the_cloth);
  s.number("weft_locking", membrane.weft_locking, "[0, 10]", "1", as_the_cloth);
}

void describe_other_plate(Section& s, PlateScene& plate) {
  s.one_line();
  s.number("warp", plate.warp, "[0, 1e6]", "N·m", as_the_cloth);
  s.number("weft", plate.weft, "[0, 1e6]", "N·m", as_the_cloth);
  s.number("twist", plate.twist, "[0, 1e6]", "N·m", as_the_cloth);
}

/// A cloth's `stretch` and `membrane` take each other's place.
void describe_stretching(Section& s, MaterialScene& fabric) {
  bool woven = fabric.membrane.has_value();
  MembraneScene membrane = fabric.membrane.value_or(MembraneScene{});
  s.check(!s.has("membrane") || !s.has("stretch"), "stretch",
          "cannot be combined with membrane; allowed: one of the two");
  s.saved_if(!woven).number("stretch", fabric.stretch, "[0.001, 1e9]", "N/m", as_the_cloth);
  s.optional(woven).section(
      "membrane", membrane, describe_other_membrane,
      "as for the cloth, in this region; omitted keys are those of the cloth's `membrane`, if it has one");
  s.check(!woven || (membrane.warp > 0 && membrane.weft > 0), "membrane",
          "lacks warp or weft, and the cloth has no membrane to take them from; allowed: warp, weft and shear");
  s.check(membrane.wet == 1 || fabric.porous, "membrane.wet",
          "applies only to absorbent cloth; allowed: only if the cloth has the key porous");
  if (s.has("stretch")) woven = false;
  fabric.membrane.reset();
  if (woven) fabric.membrane = membrane;
}

/// Hinges and plates do not join: a region bends by the law of its cloth.
void describe_bending(Section& s, MaterialScene& fabric) {
  bool plate = fabric.bending.has_value();
  PlateScene rigidity = fabric.bending.value_or(PlateScene{});
  s.check(!s.has("bend") || !plate, "bend", "does not apply, because the cloth has bending; allowed: bending");
  s.check(!s.has("bending") || plate, "bending", "does not apply, because the cloth has no bending; allowed: bend");
  s.saved_if(!plate).number("bend", fabric.bend, "[0, 1e6]", "N·m",
                            "as for the cloth, in this region; only if the cloth has `bend`");
  s.optional(plate).section(
      "bending", rigidity, describe_other_plate,
      "as for the cloth, in this region; only if the cloth has `bending`, whose values omitted keys take");
  if (fabric.bending) fabric.bending = rigidity;
}

void describe_pores(Section& s, MaterialScene& fabric) {
  s.number("solid_fraction", fabric.solid_fraction, "[0, 1)", "1", as_the_cloth);
  s.number("absorption", fabric.absorption, "[0, 100]", "m²/s", as_the_cloth);
  s.number("uptake_velocity", fabric.uptake_velocity, "[0, 100]", "m/s", as_the_cloth);
  if (s.has("absorption") && !s.has("uptake_velocity")) fabric.uptake_velocity = 0;
  s.number("max_saturation", fabric.max_saturation, "[1, 10]", "1", as_the_cloth);
  s.number("virtual_pressure", fabric.virtual_pressure, "[0, 1e5]", "m/s²", as_the_cloth);
  s.number("emission_angle", fabric.emission_angle, "[1, 179]", "degrees", as_the_cloth);
  s.number("emission_velocity", fabric.emission_velocity, "[0, 100]", "m/s", as_the_cloth);
  s.number("diffusivity", fabric.diffusivity, "[0, 1]", "m²/s",
           "as for the cloth, in this region; above 0 only if the cloth's is");
  s.number("weft_diffusivity", fabric.weft_diffusivity, "(0, 1]", "m²/s", as_the_cloth);
  if (fabric.diffusivity == 0 && !s.has("weft_diffusivity")) fabric.weft_diffusivity.reset();
  s.number("permeability", fabric.permeability, "[0, 1e-4]", "m²", as_the_cloth);
  s.number("forchheimer", fabric.forchheimer, "[0, 1e9]", "1/m", as_the_cloth);
  s.number("fibre_diameter", fabric.fibre_diameter, "[0, 1e-2]", "m", as_the_cloth);
  if (s.has("forchheimer") && !s.has("fibre_diameter")) fabric.fibre_diameter = 0;
  if (s.has("fibre_diameter") && !s.has("forchheimer")) fabric.forchheimer = 0;
  check_drag(s, fabric);
  s.number("breakthrough_pressure", fabric.breakthrough_pressure, "[0, 1e9]", "Pa", as_the_cloth);
  s.number("critical_saturation", fabric.critical_saturation, "[0, 1]", "1", as_the_cloth);
  s.number("hygral_expansion", fabric.hygral_expansion, "[-0.5, 0.5]", "1", as_the_cloth);
  s.check(!(fabric.breakthrough_pressure > 0) || fabric.permeability > 0, "breakthrough_pressure",
          "requires permeability, which is 0; allowed: only with permeability above 0");
  s.check(fabric.compressibility <= 1 - fabric.solid_fraction, "solid_fraction",
          fmt::format("{} leaves no room for the compressibility {} of the cloth; allowed: at most {}",
                      fabric.solid_fraction, fabric.compressibility, 1 - fabric.compressibility));
  s.check(!fabric.contact_wicking || fabric.diffusivity > 0, "diffusivity",
          "is 0, but contact_wicking of the cloth requires it; allowed: above 0");
  check_rates(s, fabric);
  for (const char* key : {"emission_ramp", "diffusion", "diffusion_exponent", "capillary_height", "retention_exponent",
                          "drainage_height", "drainage_exponent", "large_pores", "large_pore_height", "pore_narrowing",
                          "adhesion", "contact_wicking", "film", "film_viscosity", "compressibility"})
    s.not_here(key, of_the_cloth);
}

void refuse_keys_of_the_cloth(Section& s) {
  for (const char* key : {"compression", "strain_damping", "strain_limit", "slip", "sample_spacing", "settle",
                          "self_collision", "dynamics", "velocity", "pin", "mesh", "place", "name",
                          "initial_saturation", "hold_saturation", "initial_stain"})
    s.not_here(key, of_the_cloth);
}

/// A painted region gives its fabric in the way of the cloth, so that there is something in between.
void check_painted(Section& s, const MaterialScene& cloth, const MaterialScene& region, const std::string& key) {
  const char* const as_the_cloth =
      "differs in kind from that of the cloth; allowed in a painted region: the keys that "
      "the cloth has, with other values";
  s.check(region.membrane.has_value() == cloth.membrane.has_value(), key + (region.membrane ? "membrane" : "stretch"),
          as_the_cloth);
  s.check(region.has_warp == cloth.has_warp && region.warp == cloth.warp, key + "warp",
          "is of the whole cloth where a region is painted; allowed: only as a key of the cloth");
  const bool blocks = region.uptake_velocity == 0 && region.absorption == 0;
  s.check(blocks || (region.uptake_velocity > 0) == (cloth.uptake_velocity > 0),
          key + (region.uptake_velocity > 0 ? "porous.uptake_velocity" : "porous.absorption"), as_the_cloth);
  s.check((region.fibre_diameter > 0) == (cloth.fibre_diameter > 0),
          key + (region.fibre_diameter > 0 ? "porous.fibre_diameter" : "porous.forchheimer"), as_the_cloth);
}

}  // namespace

void describe_fabric(Section& s, const char* meaning) {
  std::vector<const char*> words{"none"};
  for (const Fabric& f : fabrics()) words.push_back(f.name.c_str());
  std::string name = "none";
  s.saved_if(false).word("fabric", name, words, meaning);
}

void check_drag(Section& s, const MaterialScene& fabric) {
  s.check(!(fabric.forchheimer > 0) || !(fabric.fibre_diameter > 0), "fibre_diameter",
          "cannot be combined with forchheimer; allowed: exactly one of the two");
  for (const auto& [key, value] :
       {std::pair{"forchheimer", fabric.forchheimer}, std::pair{"fibre_diameter", fabric.fibre_diameter}})
    s.check(!(value > 0) || fabric.permeability > 0, key,
            "requires permeability, which is 0; allowed: only with permeability above 0");
}

void check_rates(Section& s, const MaterialScene& fabric) {
  constexpr double most = 1000;
  const double weft = fabric.weft_diffusivity.value_or(fabric.diffusivity);
  s.check(
      weft <= most * fabric.diffusivity && fabric.diffusivity <= most * weft, "weft_diffusivity",
      fmt::format("is more than {:.0f} times diffusivity, or less than a {:.0f}th of it; allowed: [{:g}, {:g}] m²/s",
                  most, most, fabric.diffusivity / most, std::min(1.0, fabric.diffusivity * most)));
}

void describe(Section& s, RegionScene& region) {
  using Kind = RegionScene::Kind;
  MaterialScene& fabric = region.material;
  s.one_of(region.kind, Kind::group)
      .text("group", region.group, "name of a group of faces (`g`, `o` or `usemtl`) in the cloth's .obj file");
  s.one_of(region.kind, Kind::box)
      .section("box", region.box, "triangles whose centres are inside this box, after placement");
  s.one_of(region.kind, Kind::attribute)
      .text("attribute", region.attribute,
            "painted: a vertex attribute of the cloth's .ply file, from 0 (as the cloth) to 1 (as the region)");
  describe_fabric(
      s,
      "fabric that supplies defaults for this region, except for keys that only a whole cloth can have and the bending "
      "model (docs/manual/fabrics.md); also a .yaml file");
  s.number("areal_density", fabric.areal_density, "[1e-4, 1000]", "kg/m²", as_the_cloth);
  s.number("thickness", fabric.thickness, "[1e-6, 1]", "m", as_the_cloth);
  describe_stretching(s, fabric);
  describe_bending(s, fabric);
  s.optional(fabric.has_warp)
      .numbers("warp", fabric.warp, direction_range, "1",
               "as for the cloth, in this region; for a patch cut on the bias");
  s.number("damping", fabric.damping, "[0, 1e6]", "1/s", as_the_cloth);
  s.number("friction", fabric.friction, "[0, 10]", "1", as_the_cloth);
  s.number("friction_wet", fabric.friction_wet, "[0, 10]", "1", as_the_cloth);
  s.number("damping_wet", fabric.damping_wet, "[0, 1e6]", "1/s", as_the_cloth);
  s.number("adhesion", fabric.adhesion, "[0, 10]", "N/m", as_the_cloth);
  s.optional(fabric.porous)
      .section("porous", fabric, describe_pores,
               "as for the cloth, in this region; only if the cloth has this section");
  for (const char* key : {"friction_wet", "damping_wet"})
    s.check(!s.has(key) || fabric.porous, key,
            "applies only to absorbent cloth; allowed: only if the cloth has the key porous");
  s.check(!s.has("warp") || fabric.membrane || fabric.bending || fabric.weft_diffusivity, "warp",
          "has no effect without properties along warp and weft; allowed: only if the region has membrane, bending or "
          "porous.weft_diffusivity");
  if (s.has("warp")) check_not_zero(s, "warp", fabric.warp);
  refuse_keys_of_the_cloth(s);
}

void check_regions(Section& s, const ClothScene& cloth) {
  const bool groups = !cloth.grid && (cloth.file.ends_with(".obj") || cloth.file.ends_with(".OBJ"));
  const bool attributes = !cloth.grid && (cloth.file.ends_with(".ply") || cloth.file.ends_with(".PLY"));
  for (std::size_t i = 0; i < cloth.regions.size(); ++i) {
    const RegionScene& region = cloth.regions[i];
    const std::string key = fmt::format("regions.{}.", i);
    s.check(groups || region.kind != RegionScene::Kind::group, key + "group",
            fmt::format("applies only to meshes with groups, and {} has none; allowed: box, or an .obj file",
                        cloth.grid ? "a grid" : "a .ply or .stl file"));
    s.check(attributes || region.kind != RegionScene::Kind::attribute, key + "attribute",
            "applies only to .ply files, which have vertex attributes; allowed: box, or a .ply file");
    if (region.kind == RegionScene::Kind::attribute) check_painted(s, cloth.material, region.material, key);
    s.check(!region.material.porous || cloth.material.porous, key + "porous",
            "applies only to absorbent cloth; allowed: only if the cloth has the key porous");
    s.check(!(region.material.diffusivity > 0) || cloth.material.diffusivity > 0, key + "porous.diffusivity",
            "is above 0, but that of the cloth is 0; allowed: 0, or a cloth with a diffusivity above 0");
  }
}

}  // namespace drench
