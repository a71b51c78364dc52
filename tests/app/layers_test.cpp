// The folders of src/ in their order: a file includes files of its own folder and of those before it.

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <sstream>

#include "run_program.hpp"

namespace drench::test {
namespace {

const std::vector<std::string> layers{"base",     "parallel", "scene",  "state",  "stages",  "setup", "pipeline",
                                      "output", "report", "compare", "view", "app", "drench"};

TEST(Layers, NoFileOfSrcIncludesUp) {
  const fs::path src = fs::path(scenes_folder()).parent_path() / "src";
  const std::regex include("#include \"([a-z_]+)/[a-z_]+\\.hpp\"");
  int seen = 0;
  for (const auto& entry : fs::recursive_directory_iterator(src)) {
    if (!entry.is_regular_file()) continue;
    const auto own = std::find(layers.begin(), layers.end(), entry.path().parent_path().filename().string());
    ASSERT_NE(own, layers.end()) << entry.path() << ": a folder of src/ that stands in no order";
    std::istringstream lines(read_text(entry.path()));
    for (std::string line; std::getline(lines, line);) {
      std::smatch match;
      if (!std::regex_match(line, match, include)) continue;
      ++seen;
      EXPECT_NE(std::find(layers.begin(), own + 1, match[1].str()), own + 1) << entry.path() << ": " << line;
    }
  }
  EXPECT_GT(seen, 200);
}

}  // namespace
}  // namespace drench::test
