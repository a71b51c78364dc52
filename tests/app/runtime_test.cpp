// What the program says of its device, and the device's memory.

#include "pipeline/runtime.hpp"

#include <gtest/gtest.h>

namespace drench::test {

TEST(Runtime, SaysWhatIsWrongWithTheDeviceInOneLine) {
  EXPECT_EQ(no_device_text("no CUDA-capable device is detected", 90),
            "no CUDA device: no CUDA-capable device is detected; this build requires a GPU of compute capability 9.0 "
            "(sm_90) or newer; --backend reference runs without");
  EXPECT_EQ(wrong_device_text("GTX 1080 Ti", 61, 90),
            "GTX 1080 Ti has compute capability 6.1 (sm_61), this build needs 9.0 (sm_90) or newer: build with "
            "-DDRENCH_CUDA_ARCH=61");
}

TEST(Runtime, HasMemory) {
  require_device();
  const DeviceMemory memory = device_memory();
  EXPECT_GT(memory.free, 1e7);
  EXPECT_LE(memory.free, memory.total);
}

}  // namespace drench::test
