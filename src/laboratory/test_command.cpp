// The command `drench test`.

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "app/commands.hpp"
#include "laboratory/laboratory.hpp"
#include "output/run_folder.hpp"
#include "output/text_file.hpp"
#include "pipeline/runtime.hpp"
#include "scene/fabric_file.hpp"
#include "scene/nearest_word.hpp"

namespace drench {
namespace {

void print_list() {
  for (const StandardTest& t : standard_tests()) fmt::print("  {:<12} {}: {}\n", t.name, t.standard, t.title);
}

std::string names() {
  std::string text;
  for (const StandardTest& t : standard_tests()) text += (text.empty() ? "" : ", ") + std::string(t.name);
  return text;
}

/// All that stands for a test.
std::vector<std::string> words() {
  std::vector<std::string> all;
  for (const StandardTest& t : standard_tests()) {
    all.emplace_back(t.name);
    all.insert(all.end(), t.aliases.begin(), t.aliases.end());
  }
  return all;
}

/// The measured numbers of a specimen on one line.
std::string line_of(const TestedSpecimen& specimen) {
  std::string text = fmt::format("specimen {} ({:.1f} s):", specimen.name, specimen.seconds);
  for (const TestNumber& n : specimen.numbers)
    text += fmt::format(" {} {:.4g}{}{};", n.key, n.value, n.unit == "1" ? "" : " ", n.unit == "1" ? "" : n.unit);
  return text;
}

/// For a folder's name.
std::string fabric_name(const std::string& fabric) {
  return is_fabric_file(fabric) ? std::filesystem::path(fabric).stem().string() : fabric;
}

}  // namespace

int test_command(const TestOptions& options) {
  if (options.name.empty() || options.list) {
    print_list();
    return exit_done;
  }
  const StandardTest* test = find_standard_test(options.name);
  if (!test) {
    const std::string near = nearest_word(options.name, words());
    throw TestError(fmt::format("{} is not a test;{} allowed: {}", options.name,
                                near.empty() ? "" : fmt::format(" did you mean '{}'?", near), names()));
  }
  require_device();
  const RunFolder folder =
      make_run_folder(options.output, fmt::format("{}-{}.yaml", test->name, fabric_name(options.fabric)), false,
                      {"choose another folder with -o", nullptr});
  if (!folder.note.empty()) fmt::print(stderr, "{}\n", folder.note);
  const BackendRuntime runtime(options.threads, true);
  TestRequest request;
  request.fabric = options.fabric;
  // The scenes of the specimens stand in folders of their own.
  if (is_fabric_file(request.fabric)) request.fabric = std::filesystem::absolute(request.fabric).string();
  request.overrides = options.overrides;
  request.repeats = options.repeats;
  request.folder = folder.path;
  if (!options.quiet) request.completed = [](const TestedSpecimen& s) { fmt::print(stderr, "{}\n", line_of(s)); };
  std::string last_said;  // specimens of one kind take equally long
  request.takes_long = [&last_said](const std::string& line) {
    if (std::exchange(last_said, line) != line) fmt::print(stderr, "{}\n", line);
  };
  const TestResult result = run_test(*test, request);
  const std::string json = to_json(result);
  write_atomically(folder.path / "curve.csv", to_csv(result));
  write_atomically(folder.path / "result.json", json);
  for (const std::string& w : result.warnings)
    if (!options.quiet) fmt::print(stderr, "warning: {}\n", w);
  if (options.json)
    fmt::print("{}", json);
  else
    fmt::print("{}  Scenes, curve.csv and result.json are in {}\n", to_text(result), folder.path.string());
  return exit_done;
}

}  // namespace drench
