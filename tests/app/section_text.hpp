#pragma once
// A section of the scene format from text and back, by its description alone.

#include <string>

#include "scene/scene_error.hpp"
#include "scene/section_modes.hpp"

namespace drench::test {

template <class T>
T loaded(const std::string& yaml_text, const std::string& file) {
  T section;
  load_section(yaml::parse(yaml_text, file), "", [&](Section& s) { describe(s, section); });
  return section;
}

template <class T>
std::string saved(T section) {
  return save_section([&](Section& s) { describe(s, section); });
}

/// What loading it says; "" if it loads.
template <class T>
std::string refusal(const std::string& yaml_text, const std::string& file) {
  try {
    loaded<T>(yaml_text, file);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

}  // namespace drench::test
