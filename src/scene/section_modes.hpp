#pragma once
// The modes of a Section: each calls a description with a Section of its own.

#include <string>

#include "scene/schema.hpp"
#include "scene/section.hpp"
#include "scene/yaml_tree.hpp"

namespace drench {

/// Loads and checks the keys of `map`; an absent key leaves the struct's default. Relative mesh files lie in `folder`.
/// A bad value throws SceneError at once; then come unknown keys, missing ones, and failed checks between keys.
void load_section(const yaml::Value& map, const std::string& folder, const Describe& describe);

/// The keys with their values in the scene file's syntax.
std::string save_section(const Describe& describe);

/// Every key in the order of the description, with the struct's defaults; not those of maps in it, unless `deep`.
Schema document_section(const Describe& describe, bool deep = true);

}  // namespace drench
