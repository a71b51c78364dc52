// Runs the tests with the backend's runtime started, as the program itself does.

#include <gtest/gtest.h>

#include <cstdio>

#include "pipeline/runtime.hpp"
#include "test_ranks.hpp"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  try {
    const drench::test::JoinedRanks ranks;
    auto& listeners = testing::UnitTest::GetInstance()->listeners();
    if (drench::test::test_ranks() != nullptr && drench::test::test_ranks()->rank() > 0)
      delete listeners.Release(listeners.default_xml_generator());
    const drench::BackendRuntime runtime(0, true);
    return RUN_ALL_TESTS();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  }
}
