// The one material struct: its table of members is complete, and a number is rounded once.

#include <gtest/gtest.h>

#include <cstddef>
#include <utility>

#include "scene/scene.hpp"

namespace drench::testing {
namespace {

/// Stands for any member of an aggregate.
struct Anything {
  template <class T>
  constexpr operator T() const {
    return T{};
  }
};

template <class T, std::size_t... I>
constexpr bool takes(std::index_sequence<I...>) {
  return requires { T{(static_cast<void>(I), Anything{})...}; };
}

/// Members of an aggregate, its base among them.
template <class T, std::size_t N = 64>
constexpr std::size_t members() {
  if constexpr (takes<T>(std::make_index_sequence<N>{}))
    return N;
  else
    return members<T, N - 1>();
}

constexpr std::size_t visited() {
  std::size_t count = 0;
  ResolvedMaterial<double> material;
  visit_members(material, material, [&](const auto&, const auto&) { ++count; });
  return count;
}

TEST(Material, ItsTableHasEveryMember) {
  EXPECT_EQ(visited(), members<BasicMaterial<double>>() + members<ResolvedMaterial<double>>() - 1);
}

TEST(Material, IsRoundedMemberByMember) {
  ResolvedMaterial<double> material;
  material.thickness = 0.1;
  material.emission_cosine = 1.0 / 3;
  material.diffusion_exponent = 2.0 / 3;
  material.porous = true;
  const auto single = material_in<float>(material);
  EXPECT_EQ(single.thickness, 0.1f);
  EXPECT_EQ(single.emission_cosine, static_cast<float>(1.0 / 3));
  EXPECT_EQ(single.friction, 0.3f);
  EXPECT_EQ(single.diffusion_exponent, static_cast<float>(2.0 / 3));
  EXPECT_TRUE(single.porous && single.wicks() && !single.wicks_through_contact());
}

}  // namespace
}  // namespace drench::testing
