// Runs the tests with the backend's runtime started, as the program itself does.

#include <gtest/gtest.h>

#include <cstdio>

#include "pipeline/runtime.hpp"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  try {
    const drench::BackendRuntime runtime(0, true);
    return RUN_ALL_TESTS();
  } catch (const drench::DeviceError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  }
}
