// A Section in its three modes, where no scene shows it: lists within one line, switches, keys that exclude each other.

#include <gtest/gtest.h>

#include "section_text.hpp"

namespace drench {

struct Nail {
  double length = 1;
  bool bent = false;
};

void describe(Section& s, Nail& nail) {
  s.number("length", nail.length, "(0, 9]", "cm", "of its shaft");
  s.saved_if(nail.bent).on_off("bent", nail.bent, "no use any more");
}

struct Tool {
  enum class Kind { hammer, box } kind = Kind::hammer;
  std::array<int, 2> size{1, 2};
  std::vector<Nail> nails;
};

void describe_box(Section& s, Tool& tool) {
  s.one_line();
  s.integers("size", tool.size, "[1, 9]", "1", "width and height");
  s.list("nails", tool.nails, "in it");
}

void describe(Section& s, Tool& tool) {
  s.one_of(tool.kind, Tool::Kind::hammer).flag("hammer", "a hammer");
  s.one_of(tool.kind, Tool::Kind::box).section("box", tool, describe_box, "a box of nails");
  s.remark("heavy");
}

namespace testing {
namespace {

Tool loaded(const std::string& yaml_text) { return test::loaded<Tool>(yaml_text, "t.yaml"); }
std::string refusal(const std::string& yaml_text) { return test::refusal<Tool>(yaml_text, "t.yaml"); }

TEST(SceneSection, SavesListsWithinOneLine) {
  const std::string text = "box: {size: [3, 2], nails: [{length: 2}, {length: 0.5, bent: on}]}  # heavy\n";
  const Tool tool = loaded(text);
  EXPECT_EQ(tool.kind, Tool::Kind::box);
  ASSERT_EQ(tool.nails.size(), 2u);
  EXPECT_EQ(tool.nails[1].length, 0.5);
  EXPECT_TRUE(tool.nails[1].bent);
  EXPECT_EQ(test::saved(tool), text);
  EXPECT_EQ(test::saved(Tool{}), "hammer: true\n") << "a remark is for the key before it, and that is not saved";
}

TEST(SceneSection, ExactlyOneOfSeveralKeysStands) {
  EXPECT_EQ(loaded("hammer: true").kind, Tool::Kind::hammer);
  EXPECT_EQ(refusal("hammer: false"), "t.yaml:1:9: hammer: is false; allowed: true, or leave it out");
  EXPECT_EQ(refusal("{}"), "t.yaml:1:1: scene: has none of the keys hammer, box; allowed: exactly one of them");
  // settled before any of them is read
  EXPECT_EQ(refusal("{hammer: 3, box: {size: []}}"),
            "t.yaml:1:1: scene: has 2 of the keys hammer, box; allowed: exactly one of them");
  EXPECT_EQ(refusal("box: {nails: []}"),
            "t.yaml:1:14: box.nails: is an empty list; allowed: at least one entry, or leave the key out");
}

TEST(SceneSection, IsDocumentedInItsOrder) {
  Tool tool;
  std::string keys;
  for (const SchemaKey& key : document_section([&](Section& s) { describe(s, tool); }).keys)
    keys += key.path + " " + key.type + " " + key.standard + "\n";
  EXPECT_EQ(keys,
            "hammer switch \nbox map \nbox.size 2 whole numbers [1, 2]\nbox.nails list of maps \n"
            "box.nails.N.length number 1\nbox.nails.N.bent switch false\n");
}

}  // namespace
}  // namespace testing
}  // namespace drench
