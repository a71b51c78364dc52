#include "cloth/solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "base/stop_request.hpp"
#include "cloth/clearance.hpp"
#include "cloth/newton_node.hpp"
#include "cloth/pins.hpp"
#include "cloth/wet_cloth.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr double rounding = 0.5;          // of ε Σ D L: what is left of a residual that is summed in this precision
constexpr double trusted = 10;            // × the residual without multipliers: what xpbd may start from
constexpr int part_after_newton = 2;      // beside a GPU: this part of the iterations at most goes on from its result
constexpr int newton_after_failure = 10;  // iterations of a call, where another one in the same solve has not converged

void allocate(const Constants& constants, const Cloth& cloth, ClothSolverWork& solver) {
  const auto nodes = static_cast<std::size_t>(cloth.nodes.count);
  allocate_zeros(solver.mass, "drench::cloth::mass", nodes);
  allocate_zeros(solver.diagonal, "drench::cloth::diagonal", nodes);
  allocate_zeros(solver.friction, "drench::cloth::friction", nodes);
  if (constants.model.softens_when_wet()) allocate_zeros(solver.saturation, "drench::cloth::saturation", nodes);
  allocate_zeros(solver.base, "drench::cloth::base", nodes);
  allocate_zeros(solver.target, "drench::cloth::target", nodes);
  allocate_zeros(solver.displacement, "drench::cloth::displacement", nodes);
  allocate_zeros(solver.last_displacement, "drench::cloth::last_displacement", nodes);
}

/// Of newton.cpp: the factor on the pattern of the mesh's edges, some 50 n log₂ n numbers; the tangent's blocks, of
/// nodes, edges and triangles; iterates in double, and vectors of the linear solver and of Anderson acceleration. A
/// GPU's host needs as much once iterations have not converged, and a step far from rest the factor of all pairs that
/// bend, 3 to 6 times as many numbers; no scene tells either.
MemoryEstimate newton_bytes(const Sizing& s) {
  constexpr double vectors = 60, in_double = 14;  // 3 numbers a node each
  const double n = s.size.nodes, entries = n * std::log2(std::max(2.0, n));
  const double triangles = s.size.membrane || s.size.strain_limit ? s.size.triangles : 0;
  MemoryEstimate sum;
  sum.host = 50 * s.real * entries + n * 3 * (vectors * s.real + in_double * double_bytes) +
             9 * s.real * (5 * n + s.size.edges + 6 * triangles) + 24 * s.real * s.size.edges +
             triangles * 6 * double_bytes + s.size.links * 3 * index_bytes +
             (s.size.scene.bodies.empty() ? 0 : 2 * n * sizeof(double) * 30);
  return sum;
}

/// Of cuda/resident_newton.cpp: blocks of the tangent, 60 pairs of vectors of the linear solver, iterates in double,
/// and the inverses of patches of 34 nodes (24 in double).
double resident_newton_bytes(const Sizing& s) {
  const SetupSize& c = s.size;
  const bool has_triangles = c.membrane || c.strain_limit;
  if (!is_for_newton(c.scene, has_triangles, c.nodes)) return 0;
  const double patch = s.real == sizeof(float) ? 34 : 24, triple = 3 * double_bytes, block = 9 * s.real;
  double node = 7 * triple + (5 + 2 * 60) * 3 * s.real + 4 * block + 2 * 3 * s.real + 9 * patch * s.real +
                4 * index_bytes + sizeof(std::uint16_t) + s.real;
  if (!c.scene.bodies.empty()) node += 2 * sizeof(NodeNearby) + sizeof(ZoneNode);
  return c.nodes * node + c.edges * (2 * (block + 5 * index_bytes) + index_bytes) +
         (c.links - 2 * c.edges) * 3 * index_bytes +
         (has_triangles ? c.triangles : 0) * (6 * block + 2 * triple + 3 * 2 * double_bytes);
}

/// Of cuda/resident_cloth.cpp, which other builds do not compile: two iterates and the patches.
double resident_cloth_bytes(const Sizing& s) {
  return s.size.nodes * (8 * s.real + 3 * index_bytes) + s.size.links * sizeof(std::uint16_t);
}

}  // namespace

bool is_for_newton(const Scene& scene, bool triangles, double nodes) {
  constexpr double most_nodes = 20000;  // Jacobi iterations of larger cloths keep a GPU busy
  const bool meshes = std::any_of(scene.bodies.begin(), scene.bodies.end(),
                                  [](const BodyScene& body) { return body.kind == BodyScene::Kind::mesh; });
  const bool alone = scene.bodies.empty() && !scene.fluid.present;
  return nodes <= most_nodes && (triangles || meshes || alone);
}

MemoryEstimate cloth_solver_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (!s.size.moving_cloth) return sum;
  sum.cloth = s.size.nodes * (s.size.softens ? 16 : 15) * s.real;
  if (s.size.xpbd) sum.cloth += multiplier_bytes(s);
  if (s.gpu && !s.size.xpbd) sum.cloth += resident_cloth_bytes(s) + resident_newton_bytes(s);
  if (!s.gpu && !s.size.xpbd) sum += newton_bytes(s);
  return sum;
}

namespace {

void masses_and_diagonals(const Constants& constants, const Cloth& cloth, const ClothSystem& s) {
  const NodeLiquid wet(constants, cloth);
  const Entries<const Real> solid_mass = cloth.nodes.solid_mass;
  const Entries<const Index> hinge_start = cloth.nodes.hinge_start, hinge_item = cloth.nodes.hinge_item;
  const Entries<const Real> hinge_weight = cloth.mesh.hinge_weight, hinge_stiffness = cloth.mesh.hinge_stiffness;
  const Entries<const Real> plate = cloth.nodes.plate_diagonal;
  const SoftPins soft(cloth);
  parallel(
      "drench::cloth::diagonal", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Real mass =
            static_cast<Real>(static_cast<double>(solid_mass(n)) + wet.quantum * static_cast<double>(wet.liquid(n)));
        mass += soft(n) * s.dt * s.dt;
        Real diagonal = mass * s.inverse_dt2;
        for (Index r = s.edge_start(n); r < s.edge_start(n + 1); ++r)
          diagonal += (1 + s.strain_damping_rate(n)) * s.edge_stiffness(s.edge_item(r));
        for (Index r = hinge_start(n); r < hinge_start(n + 1); ++r) {
          const Index h = hinge_item(r) / 4;
          Real weight_sum = 0;
          for (Index a = 0; a < 4; ++a) weight_sum += Kokkos::abs(hinge_weight(4 * h + a));
          diagonal += hinge_diagonal(hinge_weight(hinge_item(r)), weight_sum, hinge_stiffness(h));
        }
        if (s.triangle_start.exist())
          for (Index r = s.triangle_start(n); r < s.triangle_start(n + 1); ++r) {
            const Index t = s.triangle_item(r) / 4;
            diagonal += triangle_diagonal(s.triangle_shape(t), s.triangle_bound(t), s.triangle_item(r) % 4);
          }
        if (plate.exist()) diagonal += plate(n);
        s.friction(n) = friction_at(s.materials(n), wet, n);
        if (s.saturation.exist()) s.saturation(n) = wet.saturation(n);
        s.mass(n) = mass;
        s.diagonal(n) = diagonal;
      });
}

/// A node's share of a bound for the linear part's spectral radius: the most over free nodes of 1 − m_n/(Δt² D_n).
struct SpectralBound {
  Entries<const std::uint8_t> pinned;
  Entries<const Real> mass, diagonal;
  double inverse_dt2;

  explicit SpectralBound(const ClothSystem& s)
      : pinned(s.pinned), mass(s.mass), diagonal(s.diagonal), inverse_dt2(static_cast<double>(s.inverse_dt2)) {}
  KOKKOS_INLINE_FUNCTION double operator()(const Index n) const {
    return pinned(n) ? 0.0 : 1 - static_cast<double>(mass(n)) * inverse_dt2 / static_cast<double>(diagonal(n));
  }
};
constexpr const char* spectral_bound = "drench::cloth::spectral_bound";

/// The largest ρ for which Chebyshev's weights take a third off every mode within the cap (cloth.hpp).
double reachable_radius(int cap) {
  return cap > plain_iterations ? 1 / std::cosh(std::acosh(3.0) / (cap - plain_iterations)) : 0;
}

/// Calls `work`(touching): without solids kernels have fewer registers.
template <class Work>
auto with_solids(const ClothSystem& s, const Work& work) {
  return s.solids.extent(0) > 0 ? work(std::true_type{}) : work(std::false_type{});
}

template <bool touching>
void iterate_nodes(const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s, Real omega) {
  const Entries<const Real3> shift = solver.displacement;
  const Entries<Real3> last_shift = solver.last_displacement;
  parallel(
      "drench::cloth::jacobi", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (!s.pinned(n))
          last_shift(n) = s.next_shift<touching>(s.terms(n), shift(n), last_shift(n), s.residual(n, shift), omega);
      });
}

/// One Jacobi step with Chebyshev's ω; the new iterate replaces x^{k−1}, then the two change places.
void iterate(const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s, Real omega) {
  with_solids(s, [&](auto touching) { iterate_nodes<touching>(cloth, solver, s, omega); });
  std::swap(solver.displacement, solver.last_displacement);
}

template <bool touching>
double imbalance_of_nodes(const Cloth& cloth, const ClothSolverWork& solver, const ClothSystem& s, double tolerance,
                          double floor) {
  const Entries<const Real3> shift = solver.displacement;
  return over_goal(ordered_sums(
      "drench::cloth::residual", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (s.pinned(n)) return TwoSums{};
        return s.imbalance<touching>(s.terms(n), shift(n), s.residual(n, shift), tolerance, floor);
      }));
}

/// The residual of the newest iterate in units of its goal. Synchronises with the host.
double imbalance(const Cloth& cloth, const ClothSolverWork& solver, const ClothSystem& s, double tolerance,
                 double floor) {
  return with_solids(s,
                     [&](auto touching) { return imbalance_of_nodes<touching>(cloth, solver, s, tolerance, floor); });
}

}  // namespace

ClothSystem::ClothSystem(const Bodies& bodies, const Cloth& fabric, ClothSolverWork& solver, Real step)
    : start(fabric.nodes.position),
      target(solver.target),
      mass(solver.mass),
      diagonal(solver.diagonal),
      friction(solver.friction),
      solid_mass(std::as_const(fabric).nodes.solid_mass),
      kept(std::as_const(fabric).nodes.clearance),
      saturation(solver.saturation),
      pinned(fabric.nodes.pinned),
      link_start(fabric.nodes.link_start),
      edge_start(fabric.nodes.edge_start),
      edge_item(fabric.nodes.edge_item),
      edge(fabric.mesh.edge),
      link(fabric.nodes.link),
      edge_length(fabric.mesh.edge_length),
      edge_stiffness(fabric.mesh.edge_stiffness),
      triangle(fabric.mesh.triangle),
      triangle_start(fabric.nodes.triangle_start),
      triangle_item(fabric.nodes.triangle_item),
      shape(fabric.mesh.triangle_shape),
      limit_stiffness(fabric.mesh.limit_stiffness),
      membrane(fabric.mesh.membrane),
      materials(node_materials(fabric)),
      solids(bodies.solids),
      dt(step),
      inverse_dt(1 / step),
      inverse_dt2(1 / (step * step)) {}

namespace {

/// Rest lengths and shapes of fabric as wet as it is (docs/theory/cloth.md, Eq. 11b). Stitches keep theirs.
void expand_wet_cloth(const Constants& constants, Cloth& cloth) {
  if (!constants.model.expands_when_wet()) return;
  const NodeLiquid wet(constants, cloth);
  const Materials materials = node_materials(cloth);
  const Entries<const Index> link_start = cloth.nodes.link_start, edge = cloth.mesh.edge,
                             triangle = cloth.mesh.triangle;
  const Entries<const Real> dry_length = cloth.mesh.dry_length, dry_link = cloth.mesh.dry_link_length,
                            dry_shape = cloth.mesh.dry_shape;
  const Entries<Link> link = cloth.nodes.link;
  const Entries<Real> length = cloth.mesh.edge_length, shape = cloth.mesh.triangle_shape;
  const Index nodes = cloth.nodes.count, edges = cloth.mesh.edges - cloth.mesh.stitches,
              triangles = dry_shape.exist() ? cloth.mesh.triangles : 0;
  parallel(
      "drench::cloth::expand", std::max({nodes, edges, triangles}), KOKKOS_LAMBDA(const Index k) {
        const auto growth = [&](Index n) { return materials(n).hygral_expansion * wet.saturation(n); };
        if (k < nodes) {
          const Real own = growth(k);
          for (Index r = link_start(k); r < link_start(k + 1); ++r)
            if (dry_link(r) > 0) link(r).length = dry_link(r) * (1 + Real(0.5) * (own + growth(link(r).other)));
        }
        if (k < edges) length(k) = dry_length(k) * (1 + Real(0.5) * (growth(edge(2 * k)) + growth(edge(2 * k + 1))));
        if (k < triangles) {
          const Real sum = growth(triangle(3 * k)) + growth(triangle(3 * k + 1)) + growth(triangle(3 * k + 2));
          for (Index c = 3 * k; c < 3 * k + 3; ++c) shape(c) = dry_shape(c) / (1 + sum / 3);
        }
      });
}

bool has_free_node(const ClothMesh& mesh) {
  return std::find(mesh.pinned.begin(), mesh.pinned.end(), std::uint8_t{0}) != mesh.pinned.end();
}

}  // namespace

ClothSystem weigh_cloth(const Constants& constants, const Bodies& bodies, Cloth& cloth, ClothSolverWork& solver,
                        Real dt) {
  allocate(constants, cloth, solver);
  expand_wet_cloth(constants, cloth);
  set_clearance(constants, bodies, cloth, dt);
  const ClothSystem system(bodies, cloth, solver, dt);
  masses_and_diagonals(constants, cloth, system);
  return system;
}

ClothIteration::ClothIteration(const Constants& constants, const Bodies& bodies, Cloth& cloth, ClothSolverWork& solver,
                               Real dt)
    : constants_(constants),
      bodies_(bodies),
      cloth_(cloth),
      solver_(solver),
      system_(weigh_cloth(constants, bodies, cloth, solver, dt)),
      method_(constants.model.scene.cloth_solver.method),
      tolerance_(constants.model.scene.cloth_solver.tolerance),
      floor_(rounding * static_cast<double>(std::numeric_limits<Real>::epsilon()) *
             static_cast<double>(cloth.mesh.mean_edge)),
      solves_(has_free_node(constants.model.mesh)),
      resident_(solves_ && method_ == ClothMethod::pd && prepare_resident_cloth(constants, cloth, solver, system_)) {
  if (!solves_) {
    progress_.residual = 0;
    return;
  }
  newton_ = method_ == ClothMethod::pd && constants.model.cloth_engine == ClothEngine::own &&
            prepare_newton(cloth, solver, system_, constants.model.cloth_pushes_bodies());
  progress_.ends_at_stall = method_ == ClothMethod::pd && constants.model.cloth_engine != ClothEngine::reference;
  progress_.rho = reachable_radius(constants.model.scene.cloth_solver.max_iterations);
  const SpectralBound bound(system_);
  if (resident_) {
    resident_newton_ =
        constants.model.cloth_engine == ClothEngine::own &&
        prepare_resident_newton(constants, cloth, solver, system_, constants.model.cloth_pushes_bodies());
    find_maximum(spectral_bound, cloth.nodes.count, bound, resident_spectral_bound(solver));
    return;
  }
  const double own = maximum(spectral_bound, cloth.nodes.count, bound);
  if (method_ == ClothMethod::xpbd) progress_.patience = own > progress_.rho ? 1 : patient;
  progress_.rho = std::min(progress_.rho, own);
}

void ClothIteration::run(int most) {
  if (!solves_) return;
  if (resident_) {
    const bool first = !under_way_ && progress_.iterations == 0;
    if (resident_newton_) run_resident_newton(solver_, system_, progress_, most, tolerance_, floor_);
    run_resident_cloth(solver_, system_, cloth_.nodes.count, first && !resident_newton_ ? &progress_ : nullptr, most,
                       tolerance_, floor_, resident_newton_);
    under_way_ = true;
    return;
  }
  if (progress_.iterations > 0) progress_.move_on(system_.solids.extent(0) > 0);
  const int end = progress_.iterations + most;
  if (newton_) {
    if (run_newton(solver_, system_, progress_, has_failed_ ? std::min(most, newton_after_failure) : most, tolerance_))
      return;
    has_failed_ = true;
    begin_newton_anew(solver_);
  }
  const double before = progress_.residual;
  do {
    stop_if_requested();
    advance(std::min(check_interval, end - progress_.iterations));
    progress_.judge(residual());
  } while (progress_.residual > 1 && progress_.iterations < end && !progress_.stalls());
  // These iterations may end farther from the solution than Newton's method did.
  if (!newton_ || progress_.residual <= before) return;
  restore_newton(solver_, system_);
  progress_.residual = before;
}

void ClothIteration::end_early_for_host() {
  if (newton_) return;
  const double worth = iterations_per_node * cloth_.nodes.count;
  if (worth < constants_.model.scene.cloth_solver.max_iterations) progress_.worth = worth;
}

const ClothProgress& ClothIteration::progress() {
  if (under_way_) progress_ = resident_progress(solver_);
  under_way_ = false;
  return progress_;
}

void ClothIteration::finish_on_host() {
  const Model& model = constants_.model;
  if (newton_ || method_ != ClothMethod::pd || model.cloth_engine == ClothEngine::reference || progress().residual <= 1)
    return;
  double best = progress_.residual;
  const Array<Real3> kept(Kokkos::ViewAllocateWithoutInitializing("drench::cloth::best_displacement"),
                          solver_.displacement.extent(0));
  const auto keep = [&](double found) {
    if (!(found < best)) return;
    best = found;
    copy_now(kept, solver_.displacement);
  };
  copy_now(kept, solver_.displacement);
  run_newton_on_host(bodies_, cloth_, solver_, system_, model.cloth_pushes_bodies(), progress_,
                     model.scene.cloth_solver.max_iterations, tolerance_);
  if (progress_.residual <= 1) return;
  // Its goal allows for the rounding of double precision alone, that of the iterations for the kernels'.
  keep(residual());
  progress_.move_on(system_.solids.extent(0) > 0);
  progress_.worth = unlimited;
  const int most = model.scene.cloth_solver.max_iterations / part_after_newton / check_interval;
  for (int checks = 0; checks < most && best > 1 && !progress_.stalls(); ++checks) {
    advance(check_interval);
    progress_.judge(residual());
    keep(progress_.residual);
  }
  copy_now(solver_.displacement, kept);
  progress_.residual = best;
}

void ClothIteration::line_search() {
  if (progress().residual <= 1) return;
  const ClothSystem s = system_;
  const Entries<Real3> shift = solver_.displacement;
  for (const ClothMaterial& cloth : constants_.model.cloths) {
    const Index first = cloth.first_node;
    const TwoSums work = ordered_sums(
        "drench::cloth::work_along_step", cloth.node_count, KOKKOS_LAMBDA(const Index k) {
          const Index n = first + k;
          if (s.pinned(n)) return TwoSums{};
          const NodeTerms t = s.terms(n);
          const Real3 u = shift(n);
          const auto start = [&](const Index m) { return s.pinned(m) ? shift(m) : Real3{}; };
          return TwoSums{static_cast<double>(dot(u, t.inertia * t.target + s.elastic_force(n, start))),
                         static_cast<double>(dot(u, s.unbalanced(t, u, s.residual(n, shift))))};
        });
    const double at_start = work.first, at_end = work.second;
    if (!(at_end < 0)) continue;
    const Real share = at_start > 0 ? static_cast<Real>(at_start / (at_start - at_end)) : Real(0);
    parallel(
        "drench::cloth::shorten_step", cloth.node_count, KOKKOS_LAMBDA(const Index k) {
          if (!s.pinned(first + k)) shift(first + k) = share * shift(first + k);
        });
  }
}

void ClothIteration::advance(int count) {
  if (method_ == ClothMethod::xpbd) {
    if (progress_.iterations == 0)
      start();
    else
      anchor_contacts(bodies_, cloth_, solver_);
  }
  for (int k = 0; k < count; ++k) {
    const Real omega = progress_.next_weight();
    if (method_ == ClothMethod::xpbd)
      iterate_multipliers(constants_, cloth_, solver_, system_, omega);
    else
      iterate(cloth_, solver_, system_, omega);
  }
}

void ClothIteration::start() {
  anchor_contacts(bodies_, cloth_, solver_);
  start_multipliers(constants_, cloth_, solver_, system_);
  // Those that the cloth would have where it goes by itself; none where these push it about, as they do after a solve
  // that has ended at its cap: from there on they would be explicit forces.
  gather_multipliers(cloth_, solver_, system_);
  const double own = residual();
  swap_multipliers(solver_);
  gather_multipliers(cloth_, solver_, system_);
  if (trusted * residual() < own) return;
  swap_multipliers(solver_);
  gather_multipliers(cloth_, solver_, system_);
}

double ClothIteration::residual() const { return imbalance(cloth_, solver_, system_, tolerance_, floor_); }

#ifndef KOKKOS_ENABLE_CUDA
bool prepare_resident_cloth(const Constants&, const Cloth&, ClothSolverWork&, const ClothSystem&) { return false; }
Kokkos::View<double, MemSpace> resident_spectral_bound(const ClothSolverWork&) { return {}; }
void run_resident_cloth(ClothSolverWork&, const ClothSystem&, Index, const ClothProgress*, int, double, double, bool) {}
bool prepare_resident_newton(const Constants&, const Cloth&, ClothSolverWork&, const ClothSystem&, bool) {
  return false;
}
void run_resident_newton(ClothSolverWork&, const ClothSystem&, const ClothProgress&, int, double, double) {}
ClothProgress resident_progress(const ClothSolverWork&) { return {}; }
#endif

}  // namespace drench::kokkos_backend
