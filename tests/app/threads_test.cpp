// The same scene with one and with two threads, and on the reference: the program as a user starts it.

#include <gtest/gtest.h>

#include <map>

#include "run_program.hpp"

namespace drench::test {
namespace {

std::map<std::string, std::string> frames(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".vtu") files[entry.path().filename().string()] = read_text(entry.path());
  }
  return files;
}

std::string scene(const std::string& name) { return std::string(DRENCH_SCENES_DIR) + "/" + name; }

}  // namespace

TEST(threads, one_and_two_threads_write_the_same_bytes) {
  const TempFolder folder;
  for (const char* threads : {"1", "2"}) {
    const Outcome o = run_drench(folder.path(), {"run", scene("water_on_cloth.yaml"), "--until", "0.12", "--quiet",
                                                 "--threads", threads, "-o", std::string("threads") + threads});
    ASSERT_EQ(o.code, 0) << o.err;
  }
  const auto one = frames(folder.path() / "threads1"), two = frames(folder.path() / "threads2");
  ASSERT_GE(one.size(), 12u);
  ASSERT_EQ(one.size(), two.size());
  for (const auto& [name, bytes] : one) EXPECT_TRUE(two.at(name) == bytes) << name << " differs";
}

TEST(reference, runs_the_small_scenes_through_the_same_pipeline) {
  for (const char* name : {"cloth_only.yaml", "dam_break.yaml", "wick.yaml"}) {
    const TempFolder folder;
    const Outcome o = run_drench(
        folder.path(), {"run", scene(name), "--backend", "reference", "--steps", "10", "--quiet", "-o", "out"});
    ASSERT_EQ(o.code, 0) << name << ": " << o.err;
    const Table table = read_table(folder.path() / "out" / "stats.csv");
    EXPECT_EQ(table.rows.size(), 10u) << name;
    for (std::size_t row = 0; row < table.rows.size(); ++row) EXPECT_EQ(table.number(row, "mass_error"), 0.0) << name;
  }
}

}  // namespace drench::test
