#include "validation.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "scene/load.hpp"

namespace drench::test {

void report(const Finding& f) {
  ASSERT_EQ((f.what + f.reference + f.unit).find('|'), std::string::npos) << "a row's separator within " << f.what;
  const bool met = f.measured <= f.target;
  std::printf("VALIDATION|%s|%s|%.3g|%.3g|%s|%s|%s\n", f.what.c_str(), f.reference.c_str(), f.target, f.measured,
              f.unit.c_str(), met ? "yes" : "no", double_precision ? "double" : "float");
  std::fflush(stdout);
  EXPECT_LE(f.measured, f.reached > 0 ? f.reached : f.target) << f.what << ", " << f.unit;
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
