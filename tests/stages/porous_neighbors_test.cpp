// Stage porous_neighbors: follows the positions after advection. (Sets against the reference: neighbors_test.)

#include <gtest/gtest.h>

#include <set>

#include "pipeline/backend.hpp"
#include "stage_compare.hpp"

namespace drench::test {

TEST(porous_neighbors, are_those_of_the_current_positions) {
  const auto setup = setup_from(wet_scene());
  const auto backend = make_kokkos_backend(setup.model);
  StepReport report;
  backend->upload(setup.state);
  backend->run(Stage::porous_neighbors, {}, report);
  EXPECT_GT(backend->neighbor_pairs("sample_fluid").size(), 0u);
  HostState moved = setup.state;
  for (Vec3& x : moved.fluid_position) x[1] += 0.5;
  backend->upload(moved);
  backend->run(Stage::porous_neighbors, {}, report);
  EXPECT_EQ(backend->neighbor_pairs("sample_fluid").size(), 0u);
  EXPECT_GT(backend->neighbor_pairs("sample_boundary").size(), 0u);
}

TEST(porous_neighbors, fluid_sample_is_the_transpose_of_sample_fluid) {
  const auto setup = setup_from(wet_scene());
  const auto backend = make_kokkos_backend(setup.model);
  StepReport report;
  backend->upload(setup.state);
  backend->run(Stage::porous_neighbors, {}, report);
  std::set<std::pair<Index, Index>> forward, backward;
  for (auto [p, i] : backend->neighbor_pairs("sample_fluid")) forward.insert({p, i});
  for (auto [i, p] : backend->neighbor_pairs("fluid_sample")) backward.insert({p, i});
  EXPECT_EQ(forward, backward);
}

}  // namespace drench::test
