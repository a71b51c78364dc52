// The example of docs/dev/add_a_scene_key.md, compiled; and what the page shows of it, compared.

#include <gtest/gtest.h>

#include <sstream>

#include "run_program.hpp"
#include "section_text.hpp"

namespace drench {

// The page has all between this line and the next of its kind.
// [example]
enum class Shade { clear, frosted };

struct LampScene {
  double power = 40;       // W
  Vec3 position{0, 2, 0};  // m
  Shade shade = Shade::clear;
  std::optional<double> warm_up;  // s; without it the lamp is bright at once
};

void describe(Section& s, LampScene& lamp) {
  s.number("power", lamp.power, "[0, 1000]", "W", "of its light alone");
  s.required().numbers("position", lamp.position, "[-10, 10]", "m", "of its middle");
  s.choice("shade", lamp.shade, {{"clear", Shade::clear}, {"frosted", Shade::frosted}}, "the glass around it");
  s.number("warm_up", lamp.warm_up, "(0, 60]", "s", "time until it is bright; without it none");
  s.check(lamp.power > 0 || !lamp.warm_up, "warm_up", "is for a lamp that shines; allowed: only with power above 0");
}

struct RoomScene {
  bool lit = false;
  LampScene lamp;
};

void describe(Section& s, RoomScene& room) {
  s.optional(room.lit).section("lamp", room.lamp, "a lamp over the cloth; without it the room is dark");
}
// [example]

namespace test {
namespace {

std::string page() { return read_text(scenes_folder() + "/../docs/dev/add_a_scene_key.md"); }

/// The blocks of the page that begin with this line of three backticks and a language.
std::vector<std::string> blocks(const std::string& language) {
  std::istringstream lines(page());
  std::vector<std::string> all;
  std::string line, text;
  for (bool inside = false, wanted = false; std::getline(lines, line);) {
    if (!line.starts_with("```")) {
      text += line + "\n";
      continue;
    }
    if (inside && wanted) all.push_back(text);
    inside = !inside;
    wanted = line == "```" + language;
    text.clear();
  }
  return all;
}

RoomScene room_of(const std::string& yaml_text) { return loaded<RoomScene>(yaml_text, "room.yaml"); }
std::string refusal_line(const std::string& yaml_text) { return refusal<RoomScene>(yaml_text, "room.yaml") + "\n"; }

TEST(SceneKeyExample, IsOnThePage) {
  const std::string source = read_text(scenes_folder() + "/../tests/app/scene_key_example_test.cpp");
  const std::string mark = "// [example]\n";
  const std::size_t begin = source.find(mark) + mark.size(), end = source.find(mark, begin);
  ASSERT_EQ(blocks("cpp").size(), 1u);
  EXPECT_EQ(blocks("cpp").front(), source.substr(begin, end - begin));
}

TEST(SceneKeyExample, LoadsAndSavesAsThePageSays) {
  const std::vector<std::string> yaml_blocks = blocks("yaml");
  ASSERT_EQ(yaml_blocks.size(), 2u);
  const RoomScene room = room_of(yaml_blocks[0]);
  EXPECT_TRUE(room.lit);
  EXPECT_EQ(room.lamp.power, 40);
  EXPECT_EQ(room.lamp.position, (Vec3{0, 3, 0.5}));
  EXPECT_EQ(room.lamp.shade, Shade::frosted);
  EXPECT_FALSE(room.lamp.warm_up);
  EXPECT_EQ(saved(room), yaml_blocks[1]);
  EXPECT_EQ(saved(room_of(yaml_blocks[1])), yaml_blocks[1]);
  EXPECT_EQ(saved(RoomScene{}), "");
  RoomScene slow = room;
  slow.lamp.warm_up = 5;
  EXPECT_EQ(room_of(saved(slow)).lamp.warm_up, 5);
}

TEST(SceneKeyExample, RefusesAsThePageSays) {
  const std::vector<std::string> messages = blocks("");
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages.front(), refusal_line("lamp:\n  power: 2000\n  position: [0, 1, 0]\n") +
                                  refusal_line("lamp:\n  position: [0, 1, 0]\n  shad: clear\n") +
                                  refusal_line("lamp: {power: 20}\n") +
                                  refusal_line("lamp:\n  position: [0, 1, 0]\n  power: 0\n  warm_up: 5\n"));
}

TEST(SceneKeyExample, IsDocumentedAsThePageSays) {
  RoomScene room;
  const std::string tables = tables_of(document_section([&](Section& s) { describe(s, room); }));
  const std::string section = tables.substr(tables.find("## `lamp`\n"));
  EXPECT_NE(page().find("\n" + section.substr(section.find("| Key |"))), std::string::npos) << section;
  EXPECT_EQ(section.find("## `lamp`\nA lamp over the cloth; without it the room is dark.\n"), 0u) << section;
}

}  // namespace
}  // namespace test
}  // namespace drench
