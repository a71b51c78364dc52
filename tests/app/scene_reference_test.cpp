// scenes/README.md says what the loader knows: all of it, and nothing else.

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "good_scenes.hpp"
#include "run_program.hpp"
#include "scene/load.hpp"
#include "scene/schema.hpp"
#include "scene/yaml_tree.hpp"

namespace drench::testing {
namespace {

/// The paths of all maps, lists and values in a document but within a value's keys, with N for the number of a list's
/// entry.
void collect(const yaml::Value& value, const std::string& path, std::set<std::string>& paths) {
  for (const yaml::Entry& entry : value.entries) {
    const std::string at = path.empty() ? entry.key : path + "." + entry.key;
    paths.insert(at);
    if (!entry.value.find("keys")) collect(entry.value, at, paths);  // else a value that moves with time
  }
  for (const yaml::Value& item : value.items)
    if (item.kind == yaml::Value::Kind::map) collect(item, path + ".N", paths);
}

std::set<std::string> paths_of(const std::string& yaml_text) {
  std::set<std::string> paths;
  collect(yaml::parse(yaml_text, "test.yaml"), "", paths);
  return paths;
}

std::set<std::string> schema_paths() {
  std::set<std::string> paths;
  for (const SchemaKey& key : scene_schema().keys) EXPECT_TRUE(paths.insert(key.path).second) << key.path;
  return paths;
}

TEST(SceneReference, IsWhatTheLoaderKnows) {
  EXPECT_TRUE(scene_reference() == test::read_text(test::scenes_folder() + "/README.md"))
      << "scenes/README.md is out of date: build/*/drench schema > scenes/README.md";
}

TEST(SceneReference, IsWhatTheProgramPrints) {
  const test::TempFolder here;
  const test::Outcome o = test::run_drench(here.path(), {"schema"});
  EXPECT_EQ(o.code, 0);
  EXPECT_EQ(o.err, "");
  EXPECT_TRUE(o.out == scene_reference());
}

TEST(SceneReference, EveryKeyHasAMeaning) {
  for (const SchemaKey& key : scene_schema().keys) {
    EXPECT_NE(key.meaning, "") << key.path;
    EXPECT_EQ(key.meaning.find('|'), key.meaning.npos) << key.path;
  }
}

/// The keys of all scenes in the tests' sources, each a raw string that begins with `drench: 1`. A pack has no sources.
std::set<std::string> keys_of_test_scenes() {
  namespace fs = std::filesystem;
  const fs::path tests = fs::path(test::scenes_folder()).parent_path() / "tests";
  std::set<std::string> keys;
  if (!fs::exists(tests)) return schema_paths();
  for (const auto& file : fs::recursive_directory_iterator(tests)) {
    if (file.path().extension() != ".cpp" && file.path().extension() != ".hpp") continue;
    const std::string text = test::read_text(file.path()), begin = "R\"(drench: 1\n", end = ")\"";
    for (std::size_t at = text.find(begin); at != text.npos; at = text.find(begin, at + 1)) {
      const std::size_t first = at + 3, last = text.find(end, first);
      try {
        keys.merge(paths_of(text.substr(first, last - first)));
      } catch (const SceneError&) {  // a pattern that its test fills in
      }
    }
  }
  return keys;
}

/// So the schema misses no key that a scene can have, and the tests none of the schema: `everything` has the keys of
/// old, and a newer section those of its own test.
TEST(SceneReference, HasTheKeysOfTheScenesOfTests) {
  std::set<std::string> known = schema_paths(), used = paths_of(everything);
  used.insert("preset");                                       // `everything` has the switches that it stands for
  for (const char* body : {"box", "plane", "mesh", "sphere"})  // `everything` shows once what all bodies have
    for (const char* key : {"velocity", "offset", "spin", "spin.axis", "spin.degrees_per_second", "dynamic", "density",
                            "mass", "friction", "restitution", "adhesion", "slip"})
      used.insert(std::string("bodies.N.") + body + "." + key);
  for (const std::string& path : used) EXPECT_TRUE(known.count(path)) << path;
  used.merge(keys_of_test_scenes());
  for (const std::string& path : known) EXPECT_TRUE(used.count(path)) << path << " stands in no scene of the tests";
}

/// Every key that a resolved scene is written with can be read, and stands in the reference.
TEST(SceneReference, HasTheKeysOfAResolvedScene) {
  const std::set<std::string> known = schema_paths();
  for (const char* yaml_text : {minimal, fluid_and_cloth})
    for (const std::string& path : paths_of(to_yaml(parse_scene(yaml_text, "test.yaml"))))
      EXPECT_TRUE(known.count(path)) << path;
}

/// The default in the table is the value of a scene that does not say otherwise.
TEST(SceneReference, HasTheDefaultsOfAResolvedScene) {
  const yaml::Value resolved = yaml::parse(to_yaml(parse_scene(fluid_and_cloth, "test.yaml",
                                                               {"cloth.0.porous={}",
                                                                "bodies=[{sphere: {center: [0, 0, 0], "
                                                                "radius: 1}}]"})),
                                           "test.yaml");
  int compared = 0;
  for (const SchemaKey& key : scene_schema().keys) {
    if (key.standard.empty() || key.need != SchemaKey::Need::optional) continue;
    const yaml::Value* value = &resolved;
    for (const std::string& segment : test::split(key.path, '.')) {
      if (value->kind == yaml::Value::Kind::list)
        value = &value->items[0];
      else
        value = value->find(segment);
      if (!value) break;
    }
    if (!value) continue;  // of a section that this scene lacks
    ++compared;
    std::string text = value->text;
    for (const yaml::Value& item : value->items) text += (text.empty() ? "[" : ", ") + item.text;
    if (!value->items.empty()) text += "]";
    if (key.type == "switch" && (text == "on" || text == "off")) text = text == "on" ? "true" : "false";
    EXPECT_EQ(text, key.standard) << key.path;
  }
  EXPECT_GT(compared, 60);
}

TEST(SceneReference, RangesAndUnitsAreThoseOfTheMessages) {
  for (const SchemaKey& key : scene_schema().keys) {
    if (key.type != "number" || key.path.find(".N") != key.path.npos) continue;
    std::string message;
    try {
      parse_scene(fluid_and_cloth, "test.yaml", {key.path + "=x"});
    } catch (const SceneError& error) {
      message = error.what();
    }
    const std::string expected =
        "'x' is not a number; allowed: " + key.allowed + " " + (key.unit.empty() ? "(no unit)" : key.unit);
    EXPECT_NE(message.find(key.path + ": " + expected), message.npos) << message;
  }
}

}  // namespace
}  // namespace drench::testing
