// Stage wet_adhesion (law: src/stages/wet_adhesion.hpp).

#include "cloth/wet_adhesion.hpp"

#include <algorithm>

#include "bodies/contact.hpp"
#include "bodies/pushed_bodies.hpp"
#include "cloth/proximity.hpp"
#include "cloth/wet_cloth.hpp"
#include "core/fixed_point.hpp"
#include "core/host_copy.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr Index none = -1;

/// What law 2 works with; nothing where no cloth has self_collision.
void allocate(const Constants& constants, WetAdhesionWork& work) {
  const auto& cloths = constants.model.cloths;
  if (work.area.exists() ||
      std::none_of(cloths.begin(), cloths.end(), [](const ClothMaterial& c) { return c.self_collision; }))
    return;
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
  constants.model.for_materials(
      [&](const ClothMaterial& c) { work.thickness = larger(work.thickness, static_cast<Real>(c.thickness)); });
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
  if (!(s.size.fluid > 0)) sum.cloth = s.size.samples * 3 * s.real;  // sample_force, which liquid has too
  if (!s.size.self_collision) return sum;
  sum.cloth += s.size.nodes * (s.real + 3 * sizeof(std::int64_t)) + s.size.triangles * (3 * index_bytes + 3 * s.real);
  sum.cells = cell_table_bytes(s.size.triangles, 0, s);
  return sum;
}

namespace {

/// What node n sees of triangle t.
struct Pull {
  Index triangle = none;
  Proximity near;
};

/// The traction between wet surfaces: it falls in proportion from contact to its range.
struct Traction {
  double thickness, mesh_range;  // m: τ; L̄

  KOKKOS_INLINE_FUNCTION double range() const { return larger(2 * thickness, mesh_range); }
  /// Pa, at `distance` for `work` in N/m.
  KOKKOS_INLINE_FUNCTION double operator()(double work, double distance) const {
    const double gap = larger(0.0, distance - thickness), left = 1 - gap / range();
    return left > 0 ? 2 * work / range() * left : 0;
  }
};

/// What the kernels over samples and nodes see.
struct Sticking {
  Entries<const Real3> position;
  Entries<const Index> triangle, edge, edge_start, edge_item, joint;
  Entries<const Real3> sample;
  Entries<const Index> sample_node;
  Entries<const Real> sample_weight, sample_area;
  Materials material, sample_material;
  Slice<const Solid> solids;
  NodeLiquid wet;
  Slice<const Real> area;
  Entries<std::int64_t> impulse;
  CellTableView cells;
  double dt, impulse_unit;  // s; kg m/s
  double mesh_range;        // L̄, m
  PushesOnBodies pushes;

  Sticking(const Constants& constants, Bodies& bodies, const Cloth& fabric, WetAdhesionWork& work, double step)
      : position(fabric.nodes.position),
        triangle(work.triangle),
        edge(fabric.mesh.edge),
        edge_start(fabric.nodes.edge_start),
        edge_item(fabric.nodes.edge_item),
        joint(fabric.nodes.joint),
        sample(fabric.samples.position),
        sample_node(fabric.samples.node),
        sample_weight(fabric.samples.weight),
        sample_area(fabric.samples.area),
        material(node_materials(fabric)),
        sample_material(sample_materials(fabric)),
        solids(bodies.solids),
        wet(constants, fabric),
        area(work.area),
        impulse(work.impulse),
        cells(work.cells.view()),
        dt(step),
        impulse_unit(constants.quantum / impulse_steps),
        mesh_range(double(fabric.mesh.mean_edge)),
        pushes(constants, bodies) {}

  KOKKOS_INLINE_FUNCTION double saturation(Index n) const { return double(wet.saturation(n)); }
  KOKKOS_INLINE_FUNCTION Traction traction(double thickness) const { return {thickness, mesh_range}; }

  /// `p`: the impulse on node n, kg m/s.
  KOKKOS_INLINE_FUNCTION void push(Index n, const Double3& p) const {
    const double part[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; ++a) {
      const std::int64_t units = fixed_point(part[a] / impulse_unit);
      if (units != 0) Kokkos::atomic_add(&impulse(3 * n + a), units);
    }
  }

  /// Law 1: the force on sample p, N.
  KOKKOS_INLINE_FUNCTION Real3 pull_of_solids(Index p) const {
    Real3 force;
    double work = 0;
    for (Index k = 0; k < 3; ++k) work += double(sample_weight(3 * p + k)) * saturation(sample_node(3 * p + k));
    work *= double(sample_material(p).wet_adhesion);
    if (!(work > 0)) return force;
    const Traction pull = traction(double(sample_material(p).thickness));
    for (std::size_t b = 0; b < solids.extent(0); ++b) {
      const Real3 shift = Real(dt) * surface_velocity(solids(b), sample(p), Real3{});
      const SolidDistance at = solid_distance(solids(b), sample(p), shift);
      const double traction = pull(work, double(at.phi));
      if (!(traction > 0) || !sticks_by_itself(solids, b, at, sample(p), shift)) continue;
      const Real3 own = Real(traction * double(sample_area(p))) * at.normal;
      force -= own;
      const auto body = static_cast<std::size_t>(solids(b).body);
      if (pushes.takes(body)) pushes.add(body, widen((sample(p) - solids(b).center) + shift), times(dt, widen(own)));
    }
    return force;
  }

  KOKKOS_INLINE_FUNCTION bool next_to(Index n, Index t) const {
    for (Index c = 0; c < 3; ++c)
      if (joint_of(joint, triangle(3 * t + c)) == joint_of(joint, n)) return true;
    for (Index r = edge_start(n); r < edge_start(n + 1); ++r) {
      const Index e = edge_item(r), other = edge(2 * e) == n ? edge(2 * e + 1) : edge(2 * e);
      for (Index c = 0; c < 3; ++c)
        if (joint_of(joint, triangle(3 * t + c)) == joint_of(joint, other)) return true;
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
      if (!(near.distance > 0 && near.distance < thickness + traction(thickness).range())) return;
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
    const double size =
        traction(pair_thickness(n, t))(work, pull.near.distance) * 0.5 * double(area(n)) * dt;  // kg m/s
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
        const Real far = larger(norm(a - middle), larger(norm(b - middle), norm(c - middle)));
        largest = larger(largest, double(far));
      },
      Kokkos::Max<double>(radius));
  const Real reach = work.thickness + static_cast<Real>(Traction{work.thickness, cloth.mesh.mean_edge}.range());
  work.cells.build(work.center, work.triangles, Real(1.0001) * (static_cast<Real>(radius) + reach));
}

/// Weighed bodies are pulled back.
void pull_bodies(const Constants& constants, Bodies& bodies) {
  const std::vector<Wrench> impulse = pushes_on(constants, bodies);
  add_impulses(bodies.given_by_cloth, impulse);
  auto states = to_host<RigidState>(bodies.state, bodies.count);
  for (std::size_t b = 0; b < states.size(); ++b) states[b] = pushed(bodies.constant_on_host[b], states[b], impulse[b]);
  set_states(bodies, states);
}

/// Law 1, gathered at the nodes: nodes.force.
void stick_to_solids(const Sticking& s, Cloth& cloth) {
  allocate_zeros(cloth.samples.force, "drench::sample_force", static_cast<std::size_t>(cloth.samples.count));
  const Entries<Real3> force = cloth.samples.force;
  parallel(
      "drench::wet_adhesion::solids", cloth.samples.count,
      KOKKOS_LAMBDA(const Index p) { force(p) = s.pull_of_solids(p); });
  node_forces_from_samples(cloth);
}

/// Law 2, in work.impulse.
void stick_to_fabric(const Sticking& s, const Cloth& cloth) {
  parallel(
      "drench::wet_adhesion::pull", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (!s.material(n).self_collision) return;
        const Pull first = s.nearest(n, {});
        if (first.triangle == none) return;
        s.stick_to(n, first);
        const Pull second = s.nearest(n, first);
        if (second.triangle != none) s.stick_to(n, second);
      });
}

/// Adds the impulses to nodes.force, or puts them there where nothing `is_there` yet; they are zero then.
void add_impulses(Cloth& cloth, WetAdhesionWork& work, double unit, bool is_there) {
  const Entries<std::int64_t> impulse = work.impulse;
  const Entries<Real3> force = cloth.nodes.force;
  parallel(
      "drench::wet_adhesion::force", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Real3 other = is_there ? force(n) : Real3{};
        force(n) = other + Real3{Real(unit * double(impulse(3 * n))), Real(unit * double(impulse(3 * n + 1))),
                                 Real(unit * double(impulse(3 * n + 2)))};
        for (int a = 0; a < 3; ++a) impulse(3 * n + a) = 0;
      });
}

}  // namespace

void wet_adhesion(const Constants& constants, Bodies& bodies, Cloth& cloth, WetAdhesionWork& work,
                  const StepInfo& info) {
  const bool solids = bodies.solids.extent(0) > 0;
  allocate(constants, work);
  const bool fabric = work.triangles > 0;
  if (!solids && !fabric) return;
  place_solids(constants, bodies, info);
  if (solids) place_samples(cloth);
  if (fabric) sort_triangles(cloth, work);
  if (constants.model.cloth_pushes_bodies()) clear_pushes(bodies);
  const Sticking s(constants, bodies, cloth, work, info.dt);
  if (solids) stick_to_solids(s, cloth);
  if (constants.model.cloth_pushes_bodies()) pull_bodies(constants, bodies);
  if (fabric) {
    stick_to_fabric(s, cloth);
    add_impulses(cloth, work, s.impulse_unit / info.dt, solids);
  }
  refresh_inverse_mass(constants, cloth);
  apply_node_forces(cloth, static_cast<Real>(info.dt));
}

}  // namespace drench::kokkos_backend
