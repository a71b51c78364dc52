// Stage wet_adhesion (law: src/stages/wet_adhesion.hpp).

#include "cloth/wet_adhesion.hpp"

#include "bodies/contact.hpp"
#include "cloth/proximity.hpp"
#include "cloth/wet_cloth.hpp"
#include "core/fixed_point.hpp"
#include "core/host_copy.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr Index none = -1;

void allocate(const Constants& constants, WetAdhesionWork& work) {
  if (work.area.extent(0) > 0) return;
  const ClothMesh& mesh = constants.model.mesh;
  std::vector<Real> area(static_cast<std::size_t>(mesh.nodes()));
  std::vector<Index> corners;
  for (Index t = 0; t < mesh.triangles(); ++t) {
    const auto& corner = mesh.triangle[static_cast<std::size_t>(t)];
    const auto rest = [&](std::size_t c) { return to_real(mesh.rest_position[static_cast<std::size_t>(corner[c])]); };
    for (const Index n : corner)
      area[static_cast<std::size_t>(n)] += norm(cross(rest(1) - rest(0), rest(2) - rest(0))) / 6;
    const auto cloth = static_cast<std::size_t>(mesh.triangle_cloth[static_cast<std::size_t>(t)]);
    if (constants.model.cloths[cloth].self_collision) corners.insert(corners.end(), corner.begin(), corner.end());
  }
  for (const ClothMaterial& c : constants.model.cloths) work.thickness = Kokkos::fmax(work.thickness, static_cast<Real>(c.thickness));
  work.area = to_device<Real>("drench::wet_adhesion::area", area);
  work.triangle = to_device<Index>("drench::wet_adhesion::triangle", corners);
  work.triangles = static_cast<Index>(corners.size() / 3);
  allocate_zeros(work.center, "drench::wet_adhesion::center", static_cast<std::size_t>(work.triangles));
  allocate_zeros(work.impulse, "drench::wet_adhesion::impulse", 3 * area.size());
}

}  // namespace

MemoryEstimate wet_adhesion_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (!s.size.wet_adhesion) return sum;
  sum.cloth = s.size.nodes * (s.real + 3 * sizeof(std::int64_t)) + s.size.triangles * (3 * index_bytes + 3 * s.real);
  sum.cells = cell_table_bytes(s.size.triangles, 0, s);
  return sum;
}

namespace {

/// What node n sees of triangle t.
struct Pull {
  Index triangle = none;
  Proximity near;
};

/// What the kernel over nodes sees.
struct Sticking {
  Entries<const Real3> position;
  Entries<const Index> triangle, edge, edge_start, edge_item;
  Materials material;
  Slice<const Solid> solids;
  NodeLiquid wet;
  Slice<const Real> area;
  Entries<std::int64_t> impulse;
  CellTableView cells;
  double dt, impulse_unit;  // s; kg m/s
  Real mesh_range;          // L̄/2, m

  Sticking(const Constants& constants, const Bodies& bodies, const Cloth& fabric, WetAdhesionWork& work, double step)
      : position(fabric.nodes.position),
        triangle(work.triangle),
        edge(fabric.mesh.edge),
        edge_start(fabric.nodes.edge_start),
        edge_item(fabric.nodes.edge_item),
        material(node_materials(fabric)),
        solids(bodies.solids),
        wet(constants, fabric),
        area(work.area),
        impulse(work.impulse),
        cells(work.cells.view()),
        dt(step),
        impulse_unit(constants.quantum / impulse_steps),
        mesh_range(fabric.mesh.mean_edge / 2) {}

  KOKKOS_INLINE_FUNCTION double saturation(Index n) const { return double(wet.saturation(n)); }
  KOKKOS_INLINE_FUNCTION double range(double thickness) const { return Kokkos::fmax(thickness, double(mesh_range)); }

  /// `p`: the impulse on node n, kg m/s.
  KOKKOS_INLINE_FUNCTION void push(Index n, const Double3& p) const {
    const double part[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; ++a) {
      const std::int64_t units = fixed_point(part[a] / impulse_unit);
      if (units != 0) Kokkos::atomic_add(&impulse(3 * n + a), units);
    }
  }

  /// Law 1.
  KOKKOS_INLINE_FUNCTION void stick_to_solids(Index n) const {
    const double work = double(material(n).wet_adhesion) * saturation(n);
    if (!(work > 0)) return;
    const Real thickness = material(n).thickness;
    const double reach = range(double(thickness));
    for (std::size_t b = 0; b < solids.extent(0); ++b) {
      const Real3 shift = Real(dt) * surface_velocity(solids(b), position(n), Real3{});
      const SolidDistance at = solid_distance(solids(b), position(n), shift);
      if (!(double(at.phi) < double(thickness) + reach)) continue;
      push(n, times(-work * double(area(n)) / reach * dt, widen(at.normal)));
    }
  }

  KOKKOS_INLINE_FUNCTION bool next_to(Index n, Index t) const {
    for (Index c = 0; c < 3; ++c)
      if (triangle(3 * t + c) == n) return true;
    for (Index r = edge_start(n); r < edge_start(n + 1); ++r) {
      const Index e = edge_item(r), other = edge(2 * e) == n ? edge(2 * e + 1) : edge(2 * e);
      for (Index c = 0; c < 3; ++c)
        if (triangle(3 * t + c) == other) return true;
    }
    return false;
  }
  KOKKOS_INLINE_FUNCTION double pair_thickness(Index n, Index t) const {
    return 0.5 * (double(material(n).thickness) + double(material(triangle(3 * t)).thickness));
  }

  /// Law 2: the nearest triangle, of those on the other side than `first` if that is one.
  KOKKOS_INLINE_FUNCTION Pull nearest(Index n, const Pull& first) const {
    Pull best;
    cells.for_near(position(n), [&](const Index t) {
      Double3 x[4] = {widen(position(n)), {}, {}, {}};
      for (Index c = 0; c < 3; ++c) x[c + 1] = widen(position(triangle(3 * t + c)));
      const Proximity near = proximity(false, x);
      const double thickness = pair_thickness(n, t);
      if (!(near.distance > 0 && near.distance < thickness + range(thickness))) return;
      if (first.triangle != none && !(inner(near.apart, first.near.apart) < 0)) return;
      if (best.triangle != none &&
          (near.distance > best.near.distance || (near.distance == best.near.distance && t > best.triangle)))
        return;
      if (!next_to(n, t)) best = {t, near};
    });
    return best;
  }

  KOKKOS_INLINE_FUNCTION void stick_to(Index n, const Pull& pull) const {
    const Index t = pull.triangle;
    double there = 0;  // the saturation of the point that it sticks to
    for (Index c = 0; c < 3; ++c) there -= pull.near.b[c + 1] * saturation(triangle(3 * t + c));
    const double work = 0.5 * (double(material(n).wet_adhesion) * saturation(n) +
                               double(material(triangle(3 * t)).wet_adhesion) * there);
    if (!(work > 0)) return;
    const double size = work / range(pair_thickness(n, t)) * 0.5 * double(area(n)) * dt;  // kg m/s
    const Double3 p = times(-size / pull.near.distance, pull.near.apart);
    push(n, p);
    for (Index c = 0; c < 3; ++c) push(triangle(3 * t + c), times(pull.near.b[c + 1], p));
  }
};

/// The table of the triangles by their centres; what is near enough to a node lies in the 27 cells around it.
void sort_triangles(const Cloth& cloth, WetAdhesionWork& work) {
  const Entries<const Real3> position = cloth.nodes.position;
  const Entries<Real3> center = work.center;
  const Entries<const Index> triangle = work.triangle;
  double radius = 0;
  Kokkos::parallel_reduce(
      "drench::wet_adhesion::centers", range(work.triangles),
      KOKKOS_LAMBDA(const Index t, double& largest) {
        const Real3 a = position(triangle(3 * t)), b = position(triangle(3 * t + 1)), c = position(triangle(3 * t + 2));
        const Real3 middle = (Real(1) / 3) * (a + b + c);
        center(t) = middle;
        const Real far = Kokkos::fmax(norm(a - middle), Kokkos::fmax(norm(b - middle), norm(c - middle)));
        largest = Kokkos::fmax(largest, double(far));
      },
      Kokkos::Max<double>(radius));
  const Real reach = work.thickness + Kokkos::fmax(work.thickness, cloth.mesh.mean_edge / 2);
  work.cells.build(work.center, work.triangles, Real(1.0001) * (static_cast<Real>(radius) + reach));
}

}  // namespace

void wet_adhesion(const Constants& constants, Bodies& bodies, Cloth& cloth, WetAdhesionWork& work,
                  const StepInfo& info) {
  allocate(constants, work);
  place_solids(constants, bodies, info);
  const bool fabric = work.triangles > 0;
  if (fabric) sort_triangles(cloth, work);
  const Sticking s(constants, bodies, cloth, work, info.dt);
  parallel(
      "drench::wet_adhesion::pull", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        s.stick_to_solids(n);
        if (!fabric || !s.material(n).self_collision) return;
        const Pull first = s.nearest(n, {});
        if (first.triangle == none) return;
        s.stick_to(n, first);
        const Pull second = s.nearest(n, first);
        if (second.triangle != none) s.stick_to(n, second);
      });
  const Entries<std::int64_t> impulse = work.impulse;
  const Entries<Real3> force = cloth.nodes.force;
  const double unit = s.impulse_unit / info.dt;
  parallel(
      "drench::wet_adhesion::force", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        force(n) = {Real(unit * double(impulse(3 * n))), Real(unit * double(impulse(3 * n + 1))),
                    Real(unit * double(impulse(3 * n + 2)))};
        for (int a = 0; a < 3; ++a) impulse(3 * n + a) = 0;
      });
  refresh_inverse_mass(constants, cloth);
  apply_node_forces(cloth, static_cast<Real>(info.dt));
}

}  // namespace drench::kokkos_backend
