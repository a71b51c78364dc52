#pragma once
// Scenes for tests that watch kernels and memory through Kokkos Tools.

namespace drench::test {

/// Water in a box, and nothing else.
inline constexpr const char* no_cloth = R"(drench: 1
time: {step: 0.002, end: 1}
fluid: {spacing: 0.02, sources: [{block: {min: [0, 0, 0], max: [0.1, 0.1, 0.1]}}]}
bodies: [{box: {min: [0, 0, 0], max: [0.2, 0.2, 0.1], inside: true}}]
)";

}  // namespace drench::test
