#include "app/fit.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "app/python.hpp"

namespace drench {
namespace {

constexpr PythonEnvironment fit_python{
    "DRENCH_PYTHON", ".deps/fit-venv",
    "run tools/setup fit, or name a Python that has numpy and scipy in DRENCH_PYTHON"};

std::string whole_number_to_1000(const std::string& text) {
  int value = 0;
  const bool good = CLI::detail::lexical_cast(text, value) && value >= 1 && value <= 1000;
  return good ? std::string() : fmt::format("{} is not allowed; allowed: a whole number from 1 to 1000", text);
}

}  // namespace

void add_fit_options(CLI::App& command, FitOptions& options) {
  const auto list = [&](const char* name, std::vector<std::string>& values, const char* help) {
    return command.add_option(name, values, help)->allow_extra_args(false);
  };
  command
      .add_option("DATA", options.data,
                  "CSV files of measured curves; the header names quantity and unit: time (s),height (mm)")
      ->required();
  list("--test", options.tests, "test that gives these curves (see drench test); one for all files, or one per file")
      ->required();
  list("--parameters", options.parameters,
       "keys of the fabric to fit, separated by commas: diffusivity,capillary_height")
      ->delimiter(',')
      ->required();
  command.add_option("--fabric", options.fabric, "fabric that gives all other values (default: cotton_interlock)");
  list("--hold-out", options.held_out, "CSV file to predict, but not to fit; repeatable");
  list("--hold-out-test", options.held_out_tests,
       "test of that file (default: the first --test); one, or one per file");
  list("--set", options.overrides,
       "KEY=VALUE: fix a key of the test's scene, such as cloth.0.thickness=0.0006; repeatable");
  list("--start", options.starts, "NAME=VALUE: start of a parameter (default: value of the fabric); repeatable");
  list("--bounds", options.bounds,
       "NAME=LOW:HIGH: bounds of a parameter (default: a hundredth and a hundred times the start); repeatable");
  command.add_option("--direction", options.direction, "direction of the specimens where the header does not name it")
      ->check(CLI::IsMember({"warp", "weft"}));
  command.add_option("--name", options.name, "name of the fabric in fabric.yaml (default: FABRIC_fitted)");
  command.add_option("-o,--output", options.output,
                     "output folder, new or of an earlier fit (default: out/fit-<data>)");
  command.add_option("-j,--jobs", options.jobs, "runs at a time, of one thread each (default: number of cores)")
      ->check(whole_number_to_1000);
  command.add_option("--max-steps", options.max_steps, "largest number of steps (default: 40)")
      ->check(whole_number_to_1000);
  command.add_flag("--simulate", options.simulate,
                   "simulate each run, also where an equation of the test is known (aatcc197)");
  command.add_flag("--quiet", options.quiet, "print only the result and warnings");
  command.footer(
      "Examples:\n"
      "  drench fit heights.csv --test aatcc197 --parameters diffusivity,capillary_height\n"
      "  drench fit warp.csv weft.csv --test tensile --parameters membrane.warp,membrane.weft --fabric denim_11oz\n"
      "  drench fit first.csv --test aatcc197 --parameters diffusivity --hold-out second.csv -o fitted -j 2");
}

void fit_command(const FitOptions& options) {
  std::error_code ignored;
  std::vector<std::string> words{"--program", std::filesystem::read_symlink("/proc/self/exe", ignored).string()};
  const auto all = [&](const std::string& name, const std::vector<std::string>& values) {
    for (const std::string& v : values) words.push_back(name + "=" + v);
  };
  all("--test", options.tests);
  all("--parameters", options.parameters);
  all("--hold-out", options.held_out);
  all("--hold-out-test", options.held_out_tests);
  all("--set", options.overrides);
  all("--start", options.starts);
  all("--bounds", options.bounds);
  all("--fabric", {options.fabric});
  all("--direction", {options.direction});
  all("--name", {options.name});
  if (options.output) all("--output", {*options.output});
  if (options.jobs) all("--jobs", {std::to_string(*options.jobs)});
  if (options.max_steps) all("--max-steps", {std::to_string(*options.max_steps)});
  if (options.simulate) words.emplace_back("--simulate");
  if (options.quiet) words.emplace_back("--quiet");
  words.emplace_back("--");  // names may begin with dashes
  words.insert(words.end(), options.data.begin(), options.data.end());
  become_python("fit_fabric.py", words, fit_python);
}

}  // namespace drench
