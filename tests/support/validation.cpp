#include "validation.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>

#include "base/version.hpp"
#include "pipeline/runtime.hpp"
#include "scene/load.hpp"
#include "test_ranks.hpp"

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
  std::printf("VALIDATION3-RUN|%s|%s|%s|%s, %s\n", double_precision ? "double" : "float", date,
              std::string(git_commit).c_str(), value_of(runtime, "backend").c_str(), with.c_str());
}

}  // namespace

std::vector<std::string> objections(const Finding& f, bool of_double, bool exact) {
  std::vector<std::string> all;
  const double bound = f.reached.bound(of_double), worst = std::max(f.measured, f.reached.scatter);
  if (!f.met() && !(f.measured <= bound)) {  // so that NaN is none
    all.push_back(fmt::format("{} is measured, {} is the {}", f.measured, bound > 0 ? bound : f.target,
                              bound > 0 ? "bound of today" : "target"));
  }
  if (!f.met() && f.reason.empty()) all.emplace_back("the target is missed without a reason");
  if (f.reached.scatter > 0 && f.reached.in_float <= 0 && f.reached.in_double <= 0)
    all.emplace_back("a scatter, and no bound that it is for");
  if (!exact || bound <= 0) return all;
  if (worst <= f.target) {
    all.push_back(fmt::format("the target {} is met by {}: take the bound {} away", f.target, worst, bound));
  } else if (bound > (1 + allowed_slack) * worst) {
    all.push_back(fmt::format("the bound {} is {:.0f} % above {}, {:.0f} % are allowed: lower it", bound,
                              100 * (bound / worst - 1), worst, 100 * allowed_slack));
  }
  return all;
}

namespace {

/// Why a target is missed, as the pages say it: with the scatter that the bound is set from.
std::string printed_reason(const Finding& f) {
  if (f.met()) return "";
  return f.reason + (f.reached.scatter > 0 ? fmt::format(" Other roundings reach {:.3g}.", f.reached.scatter) : "");
}

}  // namespace

void report(const Finding& f) {
  ASSERT_EQ((f.what + f.reference + f.unit + f.reason).find_first_of("|\n"), std::string::npos)
      << "a row's separator within " << f.what;
  static const bool said_where = (print_run(), true);
  static_cast<void>(said_where);
  const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
  // VALIDATION3|suite.test|case|reference|target|measured|unit|yes or no|precision|bound|scatter|reason: version 3
  fmt::print("VALIDATION3|{}.{}|{}|{}|{:.3g}|{:.3g}|{}|{}|{}|{:.4g}|{:.4g}|{}\n", test.test_suite_name(), test.name(),
             f.what, f.reference, f.target, f.measured, f.unit, f.met() ? "yes" : "no",
             double_precision ? "double" : "float", f.reached.bound(), f.reached.scatter, printed_reason(f));
  std::fflush(stdout);
  for (const std::string& objection : objections(f, double_precision, computes_on_host()))
    ADD_FAILURE() << f.what << " (" << f.unit << "): " << objection;
}

namespace {

/// With DRENCH_SHAKE=N in the environment, moves the liquid by about the rounding of its positions, differently for
/// each N: how far a row's number goes from N to N is what Reached::scatter is taken from.
void shake(HostState& state, double spacing) {
  const char* seed = std::getenv("DRENCH_SHAKE");
  if (!seed) return;
  std::mt19937_64 random(std::strtoull(seed, nullptr, 10));
  std::uniform_real_distribution<double> offset(-1e-6 * spacing, 1e-6 * spacing);
  for (Vec3& x : state.fluid_position)
    for (double& c : x) c += offset(random);
}

}  // namespace

SceneRun::SceneRun(const std::string& yaml) : setup_(build(parse_scene(yaml, "validation.yaml"))) {
  shake(setup_.state, setup_.model.scene.fluid.spacing);
  restart(setup_.state);
}

void SceneRun::restart(const HostState& from) {
  backend_ = make_kokkos_backend_on(test_ranks(), setup_.model);
  pipeline_ = std::make_unique<Pipeline>(setup_.model, *backend_, from);
}

HostState SceneRun::state() const {
  HostState state = backend_->download();
  share_state(state);
  return state;
}

double kilograms(const Model& model, Quanta mass) { return static_cast<double>(mass) * model.quantum; }

}  // namespace drench::test
