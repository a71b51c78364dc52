// What particles do between ranks, thousands of times over. mpirun starts it (tests/app/over_ranks.sh); alone it is
// skipped.

#include <gtest/gtest.h>

#include <cstdio>
#include <set>
#include <vector>

#include "core/host_copy.hpp"
#include "drench/drench.hpp"
#include "particles/exchange.hpp"
#include "restart_scenes.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"
#include "test_ranks.hpp"

namespace drench::test {
namespace {

using kokkos_backend::Constants;
using kokkos_backend::Entries;
using kokkos_backend::Exchange;
using kokkos_backend::ParticleSet;
using kokkos_backend::Real;
using kokkos_backend::Real3;

constexpr std::int64_t count = 20000;

/// A number of 23 bits that looks random; splitmix64, by Steele, Lea and Flood.
KOKKOS_INLINE_FUNCTION Real random_number(std::int64_t id, std::int64_t round, std::int64_t which) {
  std::uint64_t z = static_cast<std::uint64_t>((round * count + id) * 8 + which) * 0x9e3779b97f4a7c15U;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return static_cast<Real>((z ^ (z >> 31)) >> 41) * Real(0x1p-23);
}

/// Anywhere in a cube, and in every tenth round in an eighth of it, as liquid that one rank has all of.
KOKKOS_INLINE_FUNCTION Real3 place(std::int64_t id, std::int64_t round) {
  const Real side = round % 10 == 9 ? Real(0.5) : Real(1);
  return side * Real3{random_number(id, round, 0), random_number(id, round, 1), random_number(id, round, 2)};
}
std::int64_t mass_of(std::int64_t id) { return 1000003 * (id + 1); }
Real3 velocity_of(std::int64_t id) {
  return {random_number(id, 0, 3), random_number(id, 0, 4), random_number(id, 0, 5)};
}

void move_all(ParticleSet& particles, std::int64_t round) {
  const Entries<Real3> x = particles.position;
  const Entries<const std::int64_t> id = std::as_const(particles).id;
  kokkos_backend::parallel(
      "drench::test::move", particles.count, KOKKOS_LAMBDA(const Index i) { x(i) = place(id(i), round); });
}

bool same(const Vec3& a, const Real3& b) { return a[0] == b.x && a[1] == b.y && a[2] == b.z; }

}  // namespace

TEST(OverRanks, a_million_crossings_lose_and_double_nothing) {
  const Communicator* const ranks = test_ranks();
  if (ranks == nullptr) GTEST_SKIP() << "started alone";
  const drench::Setup setup = build(parse_scene(R"(drench: 1
time: {step: 0.001, end: 1}
fluid:
  spacing: 0.02
  sources: [{block: {min: [0, 0, 0], max: [0.1, 0.1, 0.1]}}]
)",
                                                "crossings.yaml"));
  HostState state = setup.state;
  visit_fields(state, [](std::string_view name, auto& values) {
    if (name.starts_with("fluid_")) values.assign(count, {});
  });
  for (std::int64_t id = 0; id < count; ++id) {
    const auto k = static_cast<std::size_t>(id);
    const Real3 x = place(id, 0), v = velocity_of(id);
    state.fluid_id[k] = id;
    state.fluid_mass[k] = mass_of(id);
    state.fluid_position[k] = {x.x, x.y, x.z};
    state.fluid_velocity[k] = {v.x, v.y, v.z};
  }
  const Constants constants(setup.model, ranks);
  Exchange exchange(constants);
  ParticleSet particles(setup.model, true);
  exchange.upload_own(state, particles);

  const double support = setup.model.support;
  std::vector<bool> mine(count, false);
  std::int64_t crossings = 0;
  for (std::int64_t round = 1; crossings < 1'000'000; ++round) {
    ASSERT_LT(round, 500) << crossings << " crossings";
    move_all(particles, round);
    exchange.migrate(particles);
    exchange.find_ghosts(particles);
    HostState own;
    own.fluid_id = kokkos_backend::to_host<std::int64_t>(particles.id, particles.local());
    const auto x = kokkos_backend::to_host<Vec3>(particles.position, particles.local());
    const auto v = kokkos_backend::to_host<Vec3>(particles.velocity, particles.count);
    const auto m = kokkos_backend::to_host<std::int64_t>(particles.mass, particles.local());
    std::vector<int> seen(count, 0);
    std::int64_t arrived = 0, wrong = 0;
    for (std::size_t k = 0; k < own.fluid_id.size(); ++k) {
      const std::int64_t id = own.fluid_id[k];
      const bool owned = k < static_cast<std::size_t>(particles.count);
      wrong += ++seen[static_cast<std::size_t>(id)] > 1 || !same(x[k], place(id, round)) || m[k] != mass_of(id);
      if (!owned) continue;
      wrong += !same(v[k], velocity_of(id)) || !exchange.own().holds(place(id, round));
      arrived += !mine[static_cast<std::size_t>(id)];
    }
    // Each rank knows where all of them are, so it knows which it should see.
    std::vector<bool> holds(count, false);
    for (std::int64_t id = 0; id < count; ++id) {
      const auto k = static_cast<std::size_t>(id);
      holds[k] = exchange.own().holds(place(id, round));
      if (exchange.own().near(place(id, round), static_cast<Real>(support))) wrong += seen[k] != 1;
    }
    mine = holds;
    std::int64_t sums[] = {arrived, wrong, particles.count};
    ranks->all_reduce(sums, {});
    ASSERT_EQ(sums[1], 0) << "round " << round;
    ASSERT_EQ(sums[2], count) << "round " << round;
    ASSERT_EQ(particles.total, count);
    if (round > 1) crossings += sums[0];
  }
  EXPECT_GT(exchange.cuts(), 10);
  exchange.migrate(particles);
  std::printf("%lld crossings, space cut %lld times\n", static_cast<long long>(crossings),
              static_cast<long long>(exchange.cuts()));
}

// Each rank also runs the scene alone.
TEST(OverRanks, the_library_gives_the_bits_of_one) {
  const Communicator* const ranks = test_ranks();
  if (ranks == nullptr) GTEST_SKIP() << "started alone";
  const Scene scene = parse_scene(porous_scene, "library.yaml");
  const std::string checkpoint = "over_ranks.checkpoint";  // where the ranks were started
  Simulation alone(scene), together(scene, ranks);
  const auto compare = [&](const char* when) {
    HostState one = alone.state(), all = together.state();
    share_state(all);
    EXPECT_GT(all.fluid_count(), 0);
    EXPECT_EQ(bits_of(all), bits_of(one)) << when;
    EXPECT_EQ(together.time(), alone.time());
  };
  const auto steps = [&](int count) {
    for (int n = 0; n < count; ++n) {
      const StepReport one = alone.step(), all = together.step();
      ASSERT_EQ(all.mass_fluid, one.mass_fluid);
      ASSERT_EQ(all.kinetic_energy, one.kinetic_energy);
      ASSERT_EQ(all.density_iterations, one.density_iterations);
    }
  };
  steps(4);
  compare("at first");
  for (Simulation* s : {&alone, &together}) {
    s->set_pin_velocity(0, 0, {0.1, 0.2, 0});
    s->set_wind({1, 0, 0});
  }
  steps(4);
  compare("with other pins and wind");
  const auto own = static_cast<Index>(together.state().fluid_count());  // all of it on rank 0
  EXPECT_GE(together.field("fluid_position").rows, ranks->rank() == 0 ? 0 : own);
  std::int64_t elsewhere = ranks->rank() == 0 ? 0 : own;
  ranks->all_reduce({&elsewhere, 1}, {});
  EXPECT_GT(elsewhere, 0);
  EXPECT_LT(elsewhere, alone.state().fluid_count());
  together.save_checkpoint(checkpoint);
  steps(2);
  const std::uint64_t later = bits_of(alone.state());
  together.resume(checkpoint);
  for (int n = 0; n < 2; ++n) together.step();
  HostState again = together.state();
  share_state(again);
  EXPECT_EQ(bits_of(again), later);
}

}  // namespace drench::test
