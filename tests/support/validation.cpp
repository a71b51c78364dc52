#include "validation.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <ctime>

#include "drench_version.hpp"
#include "pipeline/runtime.hpp"
#include "scene/load.hpp"

namespace drench::test {

namespace {

/// The value of a line `name: value`, "" without one.
std::string value_of(const std::string& lines, const std::string& name) {
  const std::size_t at = ("\n" + lines).find("\n" + name + ": ");
  if (at == std::string::npos) return "";
  const std::size_t from = at + name.size() + 2;
  return lines.substr(from, lines.find('\n', from) - from);
}

void print_run() {
  const std::string runtime = runtime_description(), threads = value_of(runtime, "threads");
  const std::string device = device_memory().device;
  const std::string with = device.empty() ? threads + (threads == "1" ? " thread" : " threads") : device;
  char date[16] = "";
  const std::time_t now = std::time(nullptr);
  std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
  std::printf("VALIDATION2-RUN|%s|%s|%s|%s, %s\n", double_precision ? "double" : "float", date,
              std::string(git_commit).c_str(), value_of(runtime, "backend").c_str(), with.c_str());
}

}  // namespace

void report(const Finding& f) {
  ASSERT_EQ((f.what + f.reference + f.unit + f.reason).find_first_of("|\n"), std::string::npos)
      << "a row's separator within " << f.what;
  static const bool said_where = (print_run(), true);
  static_cast<void>(said_where);
  const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
  const bool met = f.measured <= f.target;
  // VALIDATION2|suite.test|case|reference|target|measured|unit|yes or no|precision|reason: version 2 of the format
  std::printf("VALIDATION2|%s.%s|%s|%s|%.3g|%.3g|%s|%s|%s|%s\n", test.test_suite_name(), test.name(), f.what.c_str(),
              f.reference.c_str(), f.target, f.measured, f.unit.c_str(), met ? "yes" : "no",
              double_precision ? "double" : "float", met ? "" : f.reason.c_str());
  std::fflush(stdout);
  EXPECT_LE(f.measured, f.reached > 0 ? f.reached : f.target) << f.what << ", " << f.unit;
  EXPECT_TRUE(met || !f.reason.empty()) << f.what << ": the target is missed without a reason";
}

SceneRun::SceneRun(const std::string& yaml) : setup_(build(parse_scene(yaml, "validation.yaml"))) {
  restart(setup_.state);
}

void SceneRun::restart(const HostState& from) {
  backend_ = make_kokkos_backend(setup_.model);
  pipeline_ = std::make_unique<Pipeline>(setup_.model, *backend_, from);
}

double kilograms(const Model& model, Quanta mass) { return static_cast<double>(mass) * model.quantum; }

}  // namespace drench::test
