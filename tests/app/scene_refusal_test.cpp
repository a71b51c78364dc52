// Scenes that the loader refuses: bad ones and their messages, hostile files. Good ones: scene_loader_test.cpp;
// random damage: scene_mutation_test.cpp.

#include <gtest/gtest.h>

#include <fstream>

#include "bad_scenes.hpp"
#include "good_scenes.hpp"
#include "scene_folder.hpp"

namespace drench::testing {
namespace {

TEST(SceneLoader, RefusesEveryBadSceneWithItsPlace) {
  ASSERT_GE(std::size(bad_scenes), 50u);
  for (const BadScene& bad : bad_scenes) {
    const std::string where = "test.yaml:" + std::to_string(bad.line) + ":" + std::to_string(bad.column) + ": ";
    const std::string start = where + bad.key + ": ", what = error_of(bad.yaml);
    EXPECT_EQ(what.substr(0, start.size()), start) << bad.name << ": " << what;
    EXPECT_NE(what.find(bad.fragment, std::min(what.size(), start.size())), what.npos) << bad.name << ": " << what;
    EXPECT_EQ(what.find('\n'), what.npos) << bad.name;
  }
}

TEST(SceneLoader, RefusesBadOverrides) {
  for (const BadOverride& bad : bad_overrides) {
    EXPECT_EQ(error_of(fluid_and_cloth, {bad.override_text}), bad.message) << bad.name;
  }
  const std::string syntax = error_of(fluid_and_cloth, {"fluid.spacing=[1"});
  EXPECT_EQ(syntax.substr(0, 48), "--set fluid.spacing=[1: fluid.spacing: value:1:1") << syntax;
}

TEST(SceneLoader, NamesFilesThatItCannotRead) {
  EXPECT_EQ(load_error(folder().file("none.yaml")),
            folder().file("none.yaml") + ": cannot be read: No such file or directory");
  EXPECT_EQ(load_error(folder().file("folder.obj")),
            folder().file("folder.obj") + ": is a folder; allowed: a scene file");
  EXPECT_NE(load_error(""), "");
}

TEST(SceneLoader, RefusesHugeFiles) {
  const std::string path = folder().file("huge.yaml");
  std::ofstream(path) << minimal;
  fs::resize_file(path, std::uintmax_t{100} << 20);
  EXPECT_EQ(load_error(path), path + ": is too large; allowed: 16 MB");
}

TEST(SceneLoader, RefusesDeepNesting) {
  for (const std::size_t levels : {33u, 5'000u, 16'000'000u}) {
    const std::string what = error_of("drench: 1\nfluid: " + std::string(levels, '['));
    EXPECT_NE(what.find("nested too deeply; allowed: 32 levels"), std::string::npos) << what;
  }
  std::string maps = "drench: 1\n";
  for (int i = 0; i < 1000; ++i) maps += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  EXPECT_NE(error_of(maps).find("nested too deeply"), std::string::npos);
}

TEST(SceneLoader, RefusesAnchorBombs) {
  std::string bomb = "drench: 1\na0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string last = "*a" + std::to_string(i - 1), name = "a" + std::to_string(i);
    bomb.append(name).append(": &").append(name).append(" [").append(last);
    for (int k = 0; k < 9; ++k) bomb.append(", ").append(last);
    bomb += "]\n";
  }
  EXPECT_NE(error_of(bomb).find("too many values; allowed: 300000 in one file"), std::string::npos) << error_of(bomb);
}

TEST(SceneLoader, RefusesMapsWithTooManyKeys) {
  std::string yaml = "drench: 1\n";
  for (int i = 0; i < 2000; ++i) yaml += "k" + std::to_string(i) + ": 1\n";
  EXPECT_EQ(error_of(yaml), "test.yaml:1001:1: syntax: too many keys; allowed: 1000 in one map");
}

}  // namespace
}  // namespace drench::testing
