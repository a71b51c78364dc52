// Which files a numbered name or one with a * stands for, in which order, and that a missing one is noticed.

#include "scene/sequence_names.hpp"

#include <gtest/gtest.h>

#include "run_program.hpp"
#include "scene/load.hpp"

namespace drench::test {
namespace {

using Names = std::vector<std::string>;

class SequenceNames : public ::testing::Test {
 protected:
  void write(const Names& names) const {
    for (const std::string& name : names) write_text(folder_.path() / name, "");
  }
  drench::SequenceNames names(const std::string& pattern) const {
    return sequence_names(pattern, folder_.path().string());
  }
  TempFolder folder_;
};

TEST_F(SequenceNames, AreInTheOrderOfTheirNumbers) {
  write({"f_10.obj", "f_2.obj", "f_0.obj", "f_1.obj", "f_9.obj", "f_11.obj"});
  for (int k = 3; k < 9; ++k) write({"f_" + std::to_string(k) + ".obj"});
  Names expected;
  for (int k = 0; k < 12; ++k) expected.push_back("f_" + std::to_string(k) + ".obj");
  for (const char* pattern : {"f_*.obj", "f_{}.obj", "f_{:d}.obj"}) {
    EXPECT_EQ(names(pattern).names, expected) << pattern;
    EXPECT_EQ(names(pattern).problem, "") << pattern;
  }
  write({"b2_x10.ply", "b2_x9.ply", "b10_x1.ply", "b2_a.ply"});
  EXPECT_EQ(names("b*.ply").names, (Names{"b2_a.ply", "b2_x9.ply", "b2_x10.ply", "b10_x1.ply"}));
  EXPECT_EQ(names("b*.ply").problem, "");
  EXPECT_EQ(names("f_3.obj").names, Names{"f_3.obj"});
}

TEST_F(SequenceNames, BeginWithTheFirstThatExists) {
  write({"s_0010.obj", "s_0011.obj", "s_0012.obj", "s_13.obj", "s_0012.ply", "s_00x3.obj"});
  EXPECT_EQ(names("s_{:04d}.obj").names, (Names{"s_0010.obj", "s_0011.obj", "s_0012.obj"}));
  EXPECT_EQ(names("s_{:04d}.obj").problem, "");
  EXPECT_TRUE(names("t_{:04d}.obj").names.empty());
}

TEST_F(SequenceNames, NameWhatIsMissing) {
  write({"m_0005.obj", "m_0006.obj", "m_0008.obj", "m_0009.obj", "k_0.obj", "k_5.obj", "k_10.obj", "k_20.obj"});
  const std::string gap = "lacks 'm_0007.obj' (there are 0005 to 0009); allowed: no gap, or a list of the files";
  EXPECT_EQ(names("m_{:04d}.obj").problem, gap);
  EXPECT_EQ(names("m_*.obj").problem, gap);
  EXPECT_EQ(names("k_*.obj").problem, "lacks 'k_15.obj' (there are 0 to 20); allowed: no gap, or a list of the files");
  EXPECT_EQ(names("k_{}.obj").problem, "lacks 'k_1.obj' (there are 0 to 20); allowed: no gap, or a list of the files");
  write({"k_15.obj"});
  EXPECT_EQ(names("k_*.obj").problem, "") << "every fifth";
  try {
    parse_scene("drench: 1\nbodies: [{mesh: {sequence: \"m_*.obj\"}}]\n", (folder_.path() / "scene.yaml").string());
    FAIL() << "a gap";
  } catch (const SceneError& e) {
    EXPECT_NE(std::string(e.what()).find("bodies.0.mesh.sequence: 'm_*.obj' " + gap), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace drench::test
