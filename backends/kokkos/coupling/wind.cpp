// Stage wind; the law stands in docs/dev/add_a_force.md.

#include <numeric>

#include "core/host_copy.hpp"
#include "core/liquid_pairs.hpp"
#include "coupling/forcing.hpp"

namespace drench::kokkos_backend {
namespace {

/// Constants of the cloth, made on first use; empty where none moves.
struct WindWork {
  Field<Real> areal_density;  // per cloth, kg/m²
  Field<Index> start, item;   // node → its triangles
};

void allocate(const Constants& constants, WindWork& work) {
  if (work.start.exists()) return;
  std::vector<double> density;
  constants.model.for_materials([&](const ClothMaterial& c) { density.push_back(c.areal_density); });
  work.areal_density = to_device<Real>("drench::wind::areal_density", density);
  const ClothMesh& mesh = constants.model.mesh;
  const std::vector<Index> corners = flat(mesh.triangle);
  std::vector<Index> start(static_cast<std::size_t>(mesh.nodes()) + 1, 0), item(corners.size());
  for (const Index n : corners) ++start[static_cast<std::size_t>(n) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<Index> next = start;
  for (std::size_t c = 0; c < corners.size(); ++c)
    item[static_cast<std::size_t>(next[static_cast<std::size_t>(corners[c])]++)] = static_cast<Index>(c / 3);
  work.start = to_device<Index>("drench::wind::start", start);
  work.item = to_device<Index>("drench::wind::item", item);
}

Real3 air_at_end(const Constants& constants, const StepInfo& info) {
  return to_real(constants.model.scene.wind.at(info.time + info.dt));
}

/// What the kernel over nodes sees.
struct Drag {
  Entries<const Real3> position, velocity;
  Entries<const Real> solid_mass, areal_density;
  Entries<const Quanta> liquid;
  Entries<const Index> triangle, material, start, item;
  Real3 air;          // m/s
  Real half_density;  // ½ ρ_a, kg/m³
  Real normal_drag, tangential_drag, dt, quantum;

  Drag(const Constants& constants, const Cloth& fabric, const WindWork& work, const StepInfo& info)
      : position(fabric.nodes.position),
        velocity(fabric.nodes.velocity),
        solid_mass(fabric.nodes.solid_mass),
        areal_density(work.areal_density),
        liquid(fabric.nodes.liquid),
        triangle(fabric.mesh.triangle),
        material(material_numbers(fabric.nodes)),
        start(work.start),
        item(work.item),
        air(air_at_end(constants, info)),
        half_density(Real(0.5 * constants.model.scene.wind.density)),
        normal_drag(Real(constants.model.scene.wind.normal_drag)),
        tangential_drag(Real(constants.model.scene.wind.tangential_drag)),
        dt(Real(info.dt)),
        quantum(Real(constants.quantum)) {}

  /// Eq. 4: (m_s + m_f)/A of a node, kg/m².
  KOKKOS_INLINE_FUNCTION Real wet_density(Index n) const {
    return areal_density(material(n)) * (1 + quantum * Real(liquid(n)) / solid_mass(n));
  }
  /// Eqs. 2, 3 and 5: the force on a triangle, N.
  KOKKOS_INLINE_FUNCTION Real3 force(Index t) const {
    const Index a = triangle(3 * t), b = triangle(3 * t + 1), c = triangle(3 * t + 2);
    const Real3 w = air - (Real(1) / 3) * (velocity(a) + velocity(b) + velocity(c));
    const Real3 span = cross(position(b) - position(a), position(c) - position(a));
    const Real twice_area = norm(span);
    if (!(twice_area > 0)) return {};
    const Real3 normal = (1 / twice_area) * span, across = dot(w, normal) * normal;
    const Real lightest = smaller(wet_density(a), smaller(wet_density(b), wet_density(c)));
    const Real rate = half_density * norm(w), step = dt / lightest;
    const Real normal_part = rate * normal_drag / (1 + step * rate * normal_drag);
    const Real tangential_part = rate * tangential_drag / (1 + step * rate * tangential_drag);
    return (twice_area / 2) * (normal_part * across + tangential_part * (w - across));
  }
};

/// A third of what its triangles feel, on every node.
void push_cloth(const Constants& constants, Cloth& cloth, WindWork& work, const StepInfo& info) {
  allocate(constants, work);
  const Drag drag(constants, cloth, work, info);
  const Entries<Real3> force = cloth.nodes.force;
  parallel(
      "drench::wind::cloth", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Real3 sum;
        for (Index r = drag.start(n); r < drag.start(n + 1); ++r) sum += drag.force(drag.item(r));
        force(n) = (Real(1) / 3) * sum;
      });
  refresh_inverse_mass(constants, cloth);
  apply_node_forces(cloth, static_cast<Real>(info.dt));
}

/// Eq. 8: how much of the air's way to `at` the neighbours of a row take, given where they are.
template <class List, class Position>
KOKKOS_INLINE_FUNCTION Real shade_of(const List& near, Index i, const Position& position, const Real3& at,
                                     const Real3& upwind) {
  Real shade = 0;
  near.for_each(i, [&](Index j) {
    const Real3 r = position(j) - at;
    const Real square = dot(r, r);
    if (square > 0) shade = larger(shade, dot(upwind, r) * inverse_root(square));
  });
  return shade;
}

/// Eqs. 6 to 8.
void drag_liquid(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                 const Cloth& cloth, const StepInfo& info) {
  const WindScene& scene = constants.model.scene.wind;
  const Real3 air = air_at_end(constants, info);
  // share = Δt ½ ρ_a C_l π r² |w| / m with π r² = π (3 V/4π)^(2/3) and m = ρ0 V
  const Real factor =
      Real(info.dt * 0.5 * scene.density * scene.liquid_drag * 1.2089939655123523 / constants.model.rest_density);
  const Real full_volume = Real(constants.model.particle_mass / constants.model.rest_density / quanta_per_particle);
  const Entries<const Real3> x = fluid.particles.position, boundary = bodies.boundary.position,
                             sample = cloth.samples.position;
  const Entries<Real3> velocity = fluid.particles.velocity;
  const Entries<const Quanta> mass = fluid.particles.mass;
  const LiquidNeighbors near_liquid(lists.fluid_fluid);
  const Neighbors near_boundary(lists.fluid_boundary), near_sample(lists.fluid_sample);
  const bool walls = bodies.boundary.count > 0, sheets = cloth.samples.count > 0;
  parallel(
      "drench::wind::liquid", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 at = x(i), w = air - velocity(i);
        const Real speed = norm(w);
        if (!(mass(i) > 0) || !(speed > 0)) return;
        const Real3 upwind = (-1 / speed) * w;
        Real shade = shade_of(near_liquid, i, x, at, upwind);
        if (walls) shade = larger(shade, shade_of(near_boundary, i, boundary, at, upwind));
        if (sheets) shade = larger(shade, shade_of(near_sample, i, sample, at, upwind));
        const Real share = factor * (1 - smaller(shade, Real(1))) * speed / Kokkos::cbrt(full_volume * Real(mass(i)));
        velocity(i) += share / (1 + share) * w;
      });
}

}  // namespace

MemoryEstimate wind_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (s.size.scene.wind.present && s.size.moving_cloth) sum.cloth = (s.size.nodes + 3 * s.size.triangles) * index_bytes;
  return sum;
}

void wind(const Forcing& on) {
  if (on.constants.model.has_moving_cloth()) push_cloth(on.constants, on.cloth, on.kept<WindWork>(), on.info);
  if (on.constants.model.scene.wind.liquid_drag > 0)
    drag_liquid(on.constants, on.fluid, on.lists, on.bodies, on.cloth, on.info);
}

}  // namespace drench::kokkos_backend
