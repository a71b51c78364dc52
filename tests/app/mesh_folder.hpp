#pragma once
// A folder with mesh files, and scenes that are read beside them.

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>

#include "build_scenes.hpp"
#include "run_program.hpp"
#include "scene/load.hpp"

namespace drench::testing {

class MeshFolder : public ::testing::Test {
  test::TempFolder temporary_;

 protected:
  const std::filesystem::path folder_ = temporary_.path();

  std::string write(const std::string& name, const std::string& text) const {
    test::write_text(folder_ / name, text);
    return (folder_ / name).string();
  }
  drench::Setup built(const std::string& yaml) const {
    return build(parse_scene(yaml, (folder_ / "scene.yaml").string()));
  }
  /// What a set-up is refused with, after its key; "" if it is not.
  static std::string refusal_of(const std::function<void()>& set_up) {
    try {
      set_up();
    } catch (const SetupError& e) {
      return e.key + ": " + e.what();
    }
    return "";
  }
};

}  // namespace drench::testing
