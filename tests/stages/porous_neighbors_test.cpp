// Stage porous_neighbors: follows the positions after advection. (Sets against the reference: neighbors_test.)

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "pipeline/pipeline.hpp"
#include "stage_compare.hpp"

namespace drench::test {

TEST(porous_neighbors, are_those_of_the_current_positions) {
  const auto setup = setup_from(wet_scene());
  const auto backend = make_kokkos_backend(setup.model);
  StepReport report;
  backend->upload(setup.state);
  backend->run(Stage::porous_neighbors, {}, report);
  EXPECT_GT(backend->neighbor_pairs("fluid_sample").size(), 0u);
  HostState moved = setup.state;
  for (Vec3& x : moved.fluid_position) x[1] += 0.5;
  backend->upload(moved);
  backend->run(Stage::porous_neighbors, {}, report);
  EXPECT_EQ(backend->neighbor_pairs("fluid_sample").size(), 0u);
  EXPECT_GT(backend->neighbor_pairs("sample_boundary").size(), 0u);
}

TEST(porous_neighbors, fluid_sample_is_the_transpose_of_sample_fluid) {
  const auto setup = setup_from(wet_scene());
  const auto backend = make_kokkos_backend(setup.model);
  StepReport report;
  backend->upload(setup.state);
  backend->run(Stage::neighbors, {}, report);
  std::set<std::pair<Index, Index>> forward, backward;
  for (auto [p, i] : backend->neighbor_pairs("sample_fluid")) forward.insert({p, i});
  backend->run(Stage::porous_neighbors, {}, report);
  for (auto [i, p] : backend->neighbor_pairs("fluid_sample")) backward.insert({p, i});
  EXPECT_EQ(forward, backward);
}

// What the backend keeps from step to step is what it would find anew.
TEST(porous_neighbors, lists_that_are_kept_are_those_of_the_current_positions) {
  const auto setup = setup_from(wet_scene());
  const auto kept = make_kokkos_backend(setup.model), fresh = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *kept, setup.state);
  for (int s = 0; s < 12; ++s) pipeline.step(1.0);
  const HostState state = kept->download();
  fresh->upload(state);
  EXPECT_NE(state.node_position, setup.state.node_position);
  StepReport report;
  for (const Stage stage : {Stage::porous_neighbors, Stage::neighbors}) {
    if (stage == Stage::neighbors)
      kept->run(stage, {}, report);  // porous_neighbors ran before emission, in the last step
    fresh->run(stage, {}, report);
    for (const char* list : {"sample_sample", "fluid_sample"}) {
      if (stage == Stage::porous_neighbors && std::string(list) == "fluid_sample") continue;
      EXPECT_FALSE(kept->neighbor_pairs(list).empty());
      EXPECT_EQ(kept->neighbor_pairs(list), fresh->neighbor_pairs(list)) << list;
    }
  }
}

// And a run goes on from a state as it would have without the interruption, to the last bit.
TEST(porous_neighbors, a_backend_that_starts_from_a_state_goes_on_as_the_one_that_made_it) {
  const std::string scene = with(wet_scene(), "end: 1.0}", "end: 1.0, mode: cfl}");
  const auto setup = setup_from(scene);
  const auto one = make_kokkos_backend(setup.model), other = make_kokkos_backend(setup.model);
  Pipeline first(setup.model, *one, setup.state);
  for (int s = 0; s < 8; ++s) first.step(1.0);
  const HostState middle = one->download();
  Pipeline second(setup.model, *other, middle);
  for (int s = 0; s < 8; ++s) {
    first.step(1.0);
    second.step(1.0);
  }
  const HostState a = one->download(), b = other->download();
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.fluid_position, b.fluid_position);
  EXPECT_EQ(a.fluid_mass, b.fluid_mass);
  EXPECT_EQ(a.node_position, b.node_position);
  EXPECT_EQ(a.node_velocity, b.node_velocity);
  EXPECT_EQ(a.node_liquid, b.node_liquid);
  EXPECT_EQ(a.node_buffered, b.node_buffered);
}

}  // namespace drench::test
