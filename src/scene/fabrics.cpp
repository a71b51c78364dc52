#include "scene/fabrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <utility>

#include "scene/fabric_file.hpp"

namespace drench {

using yaml::Entry;
using yaml::Value;

namespace {

constexpr std::string_view fabrics_text =
#include "fabrics_text.inc"
    ;

std::string text_at(const Value& map, const char* key) {
  const Value* found = map.find(key);
  return found ? found->text : "";
}

Fabric fabric_of(const Entry& entry, const Value& units) {
  Fabric fabric{entry.key, text_at(entry.value, "about"), {}};
  for (const Value& v : entry.value.find("values")->items) {
    const std::string key = text_at(v, "key");
    fabric.values.push_back({key,
                             text_at(v, "value"),
                             text_at(units, key.c_str()),
                             text_at(v, "how"),
                             text_at(v, "of"),
                             text_at(v, "source"),
                             text_at(v, "note"),
                             {}});
  }
  return fabric;
}

struct Data {
  std::vector<Fabric> fabrics;
  std::vector<FabricSource> sources;
};

/// Read once, when the first cloth is.
const Data& data() {
  static const Data the_data = [] {
    const Value root = yaml::parse(std::string(fabrics_text), "fabrics.yaml");
    Data all;
    for (const Entry& e : root.find("fabrics")->entries) all.fabrics.push_back(fabric_of(e, *root.find("units")));
    for (const Entry& e : root.find("sources")->entries)
      all.sources.push_back({e.key, text_at(e.value, "title"), text_at(e.value, "link"), text_at(e.value, "read")});
    return all;
  }();
  return the_data;
}

/// Keys that take the place of each other: whoever has one has no use for the other.
constexpr std::array<std::array<std::string_view, 2>, 5> in_place_of{{{"stretch", "membrane"},
                                                                      {"bend", "bending"},
                                                                      {"porous.diffusion", "porous.diffusion_exponent"},
                                                                      {"porous.absorption", "porous.uptake_velocity"},
                                                                      {"porous.forchheimer", "porous.fibre_diameter"}}};

const Value* at(const Value& map, const std::string& dotted) {
  const Value* value = &map;
  for (std::size_t from = 0; value && from <= dotted.size();) {
    const std::size_t to = std::min(dotted.find('.', from), dotted.size());
    value = value->kind == Value::Kind::map ? value->find(dotted.substr(from, to - from)) : nullptr;
    from = to + 1;
  }
  return value;
}

/// Sets a dotted key that is not there. A value on the way that is no map is left to the loader.
bool give(Value& map, const std::string& dotted, const std::string& text, const yaml::Place& place) {
  const std::size_t dot = dotted.find('.');
  const std::string key = dotted.substr(0, dot);
  auto found = std::find_if(map.entries.begin(), map.entries.end(), [&](const Entry& e) { return e.key == key; });
  if (found != map.entries.end() && dot == dotted.npos) return false;
  if (found == map.entries.end()) {
    Value value;
    value.kind = dot == dotted.npos ? Value::Kind::scalar : Value::Kind::map;
    value.place = place;
    if (dot == dotted.npos) value.text = text;
    map.entries.push_back({key, place, std::move(value)});
    found = std::prev(map.entries.end());
  }
  if (dot == dotted.npos) return true;
  return found->value.kind == Value::Kind::map && give(found->value, dotted.substr(dot + 1), text, place);
}

/// What a fabric gives and a region does not take.
bool is_of_whole_cloth(const std::string& key, bool plate) {
  constexpr std::array<std::string_view, 17> keys{"compression",
                                                  "strain_limit",
                                                  "porous.diffusion",
                                                  "porous.diffusion_exponent",
                                                  "porous.capillary_height",
                                                  "porous.retention_exponent",
                                                  "porous.drainage_height",
                                                  "porous.drainage_exponent",
                                                  "porous.large_pores",
                                                  "porous.large_pore_height",
                                                  "porous.pore_narrowing",
                                                  "porous.adhesion",
                                                  "porous.film",
                                                  "porous.film_viscosity",
                                                  "porous.emission_ramp",
                                                  "porous.compressibility",
                                                  "porous.contact_wicking"};
  if (key == "bend" || key.starts_with("bending.")) return plate == (key == "bend");
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

/// `taker`: a cloth, or a region of `cloth`.
FabricUse apply(Value& taker, const Value& cloth, bool is_region, const Fabric& fabric) {
  FabricUse use;
  use.fabric = fabric.name;
  const Value before = taker;
  const yaml::Place place = before.find("fabric")->place;
  const bool porous = cloth.find("porous"), plate = cloth.find("bending");
  for (const FabricValue& v : fabric.values) {
    if (v.key.starts_with("porous.") && !porous) {
      use.dry = true;
      continue;
    }
    if (!porous && (v.key == "friction_wet" || v.key == "membrane.wet")) {
      use.own.push_back(v);
      continue;
    }
    if (is_region && is_of_whole_cloth(v.key, plate)) {
      use.whole.push_back(v);
      continue;
    }
    const bool given = !is_replaced(before, v.key) && give(taker, v.key, v.value, v.place.source ? v.place : place);
    (given ? use.given : use.own).push_back(v);
  }
  return use;
}

/// The fabric that a cloth or a region names; none where it names none that there is. The name of a file becomes
/// `none`.
std::optional<Fabric> fabric_named_in(Value& map, const std::string& key, const std::string& folder) {
  if (map.kind != Value::Kind::map) return {};
  const auto name =
      std::find_if(map.entries.begin(), map.entries.end(), [](const Entry& e) { return e.key == "fabric"; });
  if (name == map.entries.end() || name->value.kind != Value::Kind::scalar) return {};
  if (is_fabric_file(name->value.text)) {
    Fabric fabric = read_fabric_file(name->value, key + ".fabric", folder);
    name->value.text = "none";
    return fabric;
  }
  const Fabric* fabric = fabric_named(name->value.text);
  return fabric ? std::optional<Fabric>(*fabric) : std::nullopt;
}

void apply_to_regions(Value& cloth, std::size_t number, const std::string& folder, std::vector<FabricUse>& uses) {
  if (cloth.kind != Value::Kind::map) return;
  const auto regions =
      std::find_if(cloth.entries.begin(), cloth.entries.end(), [](const Entry& e) { return e.key == "regions"; });
  if (regions == cloth.entries.end()) return;
  int region = 0;
  for (Value& taker : regions->value.items) {
    if (const auto fabric = fabric_named_in(taker, fmt::format("cloth.{}.regions.{}", number, region), folder)) {
      uses.push_back(apply(taker, cloth, true, *fabric));
      uses.back().cloth = number;
      uses.back().region = region;
    }
    ++region;
  }
}

}  // namespace

const std::vector<Fabric>& fabrics() { return data().fabrics; }

const std::vector<FabricSource>& fabric_sources() { return data().sources; }

std::vector<std::string> fabric_names() {
  std::vector<std::string> names;
  for (const Fabric& f : fabrics()) names.push_back(f.name);
  return names;
}

const Fabric* fabric_named(const std::string& name) {
  const auto found = std::find_if(fabrics().begin(), fabrics().end(), [&](const Fabric& f) { return f.name == name; });
  return found == fabrics().end() ? nullptr : &*found;
}

bool is_replaced(const Value& cloth, const std::string& key) {
  const auto is = [&](std::string_view one) { return key == one || key.starts_with(std::string(one) + "."); };
  return std::any_of(in_place_of.begin(), in_place_of.end(), [&](const auto& pair) {
    return (is(pair[1]) && at(cloth, std::string(pair[0]))) || (is(pair[0]) && at(cloth, std::string(pair[1])));
  });
}

std::string basis_of(const FabricValue& value) {
  if (value.how.ends_with("measured") || value.how.ends_with("derived")) return value.how;
  if (value.of.empty()) return value.how + ": " + value.note;
  std::string times;
  for (const FabricValue& v : fabric_named(value.of)->values) {
    const double own = std::strtod(value.value.c_str(), nullptr), other = std::strtod(v.value.c_str(), nullptr);
    if (v.key == value.key && own != other) times = fmt::format("{:.3g} times that ", own / other);
  }
  return value.how + ": " + times + "of " + value.of;
}

std::vector<FabricUse> apply_fabrics(Value& scene, const std::string& folder) {
  std::vector<FabricUse> uses;
  for (Entry& entry : scene.entries) {
    if (entry.key != "cloth") continue;
    for (std::size_t i = 0; i < entry.value.items.size(); ++i) {
      Value& cloth = entry.value.items[i];
      if (const auto fabric = fabric_named_in(cloth, fmt::format("cloth.{}", i), folder)) {
        uses.push_back(apply(cloth, cloth, false, *fabric));
        uses.back().cloth = i;
      }
      apply_to_regions(cloth, i, folder, uses);
    }
  }
  return uses;
}

FabricOrigins origins_of(const std::vector<FabricUse>& uses) {
  FabricOrigins origins;
  for (const FabricUse& use : uses) {
    const std::string region = use.region < 0 ? "" : fmt::format("regions.{}.", use.region);
    for (const FabricValue& v : use.given) {
      const bool own = v.how == "file" && v.note == use.fabric;
      origins.values.push_back({fmt::format("cloth.{}.{}{}", use.cloth, region, v.key),
                                std::strtod(v.value.c_str(), nullptr),
                                fmt::format("fabric {}{}", use.fabric, own ? "" : ", " + basis_of(v))});
    }
  }
  return origins;
}

}  // namespace drench
