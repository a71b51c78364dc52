#pragma once
// Fabrics with names: a cloth's key `fabric` gives it the values of src/scene/fabrics.yaml, which is compiled in, or of
// a file (fabric_file.hpp).
// docs/manual/fabric_data.md has the source of each value. Units are those of the scene's keys.

#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "scene/yaml_tree.hpp"

namespace drench {

/// A key of a cloth and what a fabric gives it.
struct FabricValue {
  std::string key;     // dotted, from the cloth: membrane.warp
  std::string value;   // as YAML has it
  std::string unit;    // "" for numbers without one
  std::string how;     // measured, derived, similar or assumed; file: it stands in the file that `note` names
  std::string of;      // the fabric that it was taken from, if that is one of fabrics()
  std::string source;  // a name of fabric_sources()
  std::string note;    // which sample, or how it was derived
  yaml::Place place;   // in its file
};

/// How a value is known, in words that stand beside it: "derived", or "assumed: of sock_nylon".
std::string basis_of(const FabricValue& value);

struct Fabric {
  std::string name, about;
  std::vector<FabricValue> values;
};

/// Where values come from.
struct FabricSource {
  std::string name, title, link, read;  // read: what of it was seen
};

/// All of them, in the order of the file.
const std::vector<Fabric>& fabrics();
const std::vector<FabricSource>& fabric_sources();
std::vector<std::string> fabric_names();
/// The one of this name, or null.
const Fabric* fabric_named(const std::string& name);
/// Does a cloth's map have a key that replaces this one?
bool is_replaced(const yaml::Value& cloth, const std::string& key);

/// What a cloth has of its fabric.
struct FabricUse {
  std::size_t cloth = 0;           // its number in the scene
  int region = -1;                 // number of the cloth's region that has it; −1: the cloth itself
  std::string fabric;              // its name
  std::vector<FabricValue> given;  // those that count
  std::vector<FabricValue> own;    // those that the scene gives itself, or gives another key in place of
  std::vector<FabricValue> whole;  // of a region: those that are one for a cloth, which the cloth has
  bool dry = false;                // it could take up liquid, and the cloth has no key `porous`
};

/// Writes the values of each cloth's fabric into the scene's tree, at the place of the key `fabric`. A key that the
/// scene has stays, and what is under `porous` counts only where the cloth has that key. Regions take their fabrics'
/// values in the same way, but those that do not differ within a cloth. Files start at `folder`, and their names become
/// `none`; unknown names are left to the loader. Throws SceneError.
std::vector<FabricUse> apply_fabrics(yaml::Value& scene, const std::string& folder);

/// The scene's numbers that come from fabrics, and how each is known.
FabricOrigins origins_of(const std::vector<FabricUse>& uses);

/// The uses in a scene file, as load_scene() reads it. Throws SceneError.
std::vector<FabricUse> fabrics_used(const std::string& path, const std::vector<std::string>& overrides = {});

}  // namespace drench
