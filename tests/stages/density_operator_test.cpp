// The discrete divergence and its adjoint (fluid/density_operator.hpp): Eq. 12 of docs/theory/liquid.md, with walls and
// cloth.

#include <gtest/gtest.h>

#include <cmath>

#include "fluid/pressure_solve.hpp"
#include "fluid/stages.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"
#include "states.hpp"

namespace drench::kokkos_backend {
namespace {

Real3 some_vector(Index i) {
  const auto at = static_cast<std::size_t>(i);
  return {Real(test::noise(at, 0)), Real(test::noise(at, 1)), Real(test::noise(at, 2))};
}

/// Σ_i V_i κ_i R_i, and Σ_i V_i v_i · a_i + Σ_n u_n · F_n, over ρ0; by Eq. 12 their sum is 0.
/// `size`: of the terms of the first; `difference`: what they are apart by the two ways to give velocities.
struct Products {
  double of_rates = 0, of_forces = 0, size = 0, difference = 0;
};

/// `every`: of so many particles one has half of its mass; 0: none has.
Products products(const std::string& scene, std::size_t every) {
  Setup setup = test::setup_from(scene);
  if (every > 0)
    for (std::size_t i = 0; i < setup.state.fluid_mass.size(); i += every) setup.state.fluid_mass[i] /= 2;
  const Constants constants(setup.model);
  Fluid fluid(constants);
  Bodies bodies(constants);
  Cloth cloth(constants);
  fluid.exchange.upload_own(setup.state, fluid.particles);
  bodies.upload(constants, setup.state);
  cloth.upload(setup.model, setup.state);
  NeighborLists lists;
  StepReport report;
  neighbors(constants, fluid, lists, bodies, cloth, nullptr);
  density(constants, fluid, lists, bodies, cloth, report);

  PressureWork work;
  allocate_pressure_work(work, fluid);
  const PressureSystem system{constants, fluid, lists, bodies, cloth, work, fluid.particles.kappa_density, 0.001};
  const Index particles = fluid.particles.count, nodes = cloth.nodes.count;
  const auto on_host = [](const auto& field) {
    return Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), field);
  };
  const auto positions = on_host(fluid.position_volume);
  const auto kappa_and_place = Kokkos::create_mirror_view(work.position_kappa);
  const auto velocities = Kokkos::create_mirror_view(work.predicted);
  for (Index i = 0; i < particles; ++i) {
    const auto k = static_cast<std::size_t>(i);
    kappa_and_place(i) = {positions(i).xyz(), Real(std::abs(test::noise(k, 3)))};
    velocities(i) = {some_vector(i), Real(0)};
  }
  Kokkos::deep_copy(work.position_kappa, kappa_and_place);
  Kokkos::deep_copy(work.predicted, velocities);
  const auto node_velocities = Kokkos::create_mirror_view(cloth.nodes.velocity);
  for (Index n = 0; n < nodes; ++n) node_velocities(n) = some_vector(n + 7);
  Kokkos::deep_copy(cloth.nodes.velocity, node_velocities);

  const SheetRows& rows = lists.sheet_rows;
  const DensityOperator divergence =
      system.divergence(std::as_const(work).position_kappa,
                        {rows.of_particle, rows.particle_pair, std::as_const(cloth).nodes.velocity, Real(1)});
  const Entries<const Real3> boundary = std::as_const(fluid).boundary_gradient;
  const Entries<const Real4> v = std::as_const(work).predicted;
  const bool bounded = bodies.boundary.count > 0 || cloth.samples.count > 0;
  Array<Real> rate("rate", static_cast<std::size_t>(particles)), differs("differs", rate.extent(0));
  Array<Real3> acceleration("acceleration", static_cast<std::size_t>(particles));
  parallel(
      "test::rates", particles, KOKKOS_LAMBDA(const Index i) {
        Real sum = 0;
        divergence.add_liquid(
            i, v(i).xyz(), [&](Index j) { return v(j).xyz(); }, sum);
        Real of_array = 0;
        divergence.add_liquid(i, v, of_array);
        differs(i) = of_array - sum;
        divergence.add_walls(
            i, v(i).xyz(), [](Index) { return Real3{}; }, sum);  // at rest
        rate(i) = sum + divergence.approach(i, v(i).xyz());
        acceleration(i) = -divergence.gradient(i);
        if (bounded) acceleration(i) -= divergence.position(i).w * boundary(i);
      });
  const auto rates = on_host(rate), differences = on_host(differs);
  const auto accelerations = on_host(acceleration);
  const auto number = [](const Real3& a, const Real3& b) {
    return double(a.x) * double(b.x) + double(a.y) * double(b.y) + double(a.z) * double(b.z);
  };
  Products p;
  for (Index i = 0; i < particles; ++i) {
    const double volume = double(positions(i).w);
    const double term = volume * double(kappa_and_place(i).w) * double(rates(i));
    p.of_rates += term;
    p.size += std::abs(term);
    p.difference += volume * double(kappa_and_place(i).w) * std::abs(double(differences(i)));
    p.of_forces += volume * number(velocities(i).xyz(), accelerations(i));
  }
  if (rows.count == 0) return p;
  const auto start = on_host(rows.of_node);
  const auto pairs = on_host(rows.node_pair);
  for (Index n = 0; n < nodes; ++n)
    for (Index e = start(n); e < start(n + 1); ++e) {
      const SheetPair& pair = pairs(e);
      p.of_forces += double(kappa_and_place(pair.other).w) * number(node_velocities(n), pair.gradient) /
                     double(constants.rest_density);
    }
  return p;
}

void expect_adjoint(const std::string& scene, std::size_t every = 0) {
  const Products p = products(scene, every);
  ASSERT_GT(p.size, 0);
  EXPECT_LT(p.difference, (test::double_precision ? 1e-14 : 1e-5) * p.size);
  EXPECT_NEAR(p.of_rates, -p.of_forces, (test::double_precision ? 1e-11 : 1e-4) * p.size);
}

const char* const pool = R"(drench: 1
time: {step: 0.001, end: 1}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [-0.1, -0.11, -0.08], max: [0.1, 0.11, 0.08]}
)";
const char* const walls = R"(bodies:
  - plane: {point: [0, -0.12, 0], normal: [0, 1, 0]}
  - sphere: {center: [0, 0.16, 0], radius: 0.05}
)";
const char* const sheet = R"(cloth:
  - mesh: {grid: {size: [0.3, 0.3], nodes: [9, 9]}}
    place: {position: [0, 0.13, 0]}
    thickness: 0.002
)";

}  // namespace

TEST(density_operator, is_the_negative_adjoint_of_the_acceleration) { expect_adjoint(pool); }

TEST(density_operator, is_adjoint_where_particles_have_several_masses) { expect_adjoint(pool, 5); }

TEST(density_operator, is_adjoint_beside_walls) { expect_adjoint(std::string(pool) + walls); }

TEST(density_operator, is_adjoint_beside_walls_and_cloth) { expect_adjoint(std::string(pool) + sheet + walls); }

}  // namespace drench::kokkos_backend
