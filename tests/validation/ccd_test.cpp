// Continuous collision of liquid with cloth: the law of the backend and that of the reference against a referee in long
// double, on random and degenerate pairs; and the momentum of the impulse.

#include <gtest/gtest.h>

#include <array>

#include "ccd_pairs.hpp"
#include "collision.hpp"
#include "coupling/collision.hpp"
#include "coupling/collision_filter.hpp"
#include "pipeline/backend.hpp"
#include "scene/load.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

using namespace ccd;

struct Found {
  bool hit = false;
  double time = 0;
};
Found by_backend(const Pair& p) {
  const auto wide = [](const Vector3d& v) { return kokkos_backend::Double3{v[0], v[1], v[2]}; };
  kokkos_backend::Hit hit;
  const bool found =
      kokkos_backend::first_hit(wide(p.x0), wide(p.x1), {wide(p.from[0]), wide(p.from[1]), wide(p.from[2])},
                                {wide(p.to[0]), wide(p.to[1]), wide(p.to[2])}, touch, hit);
  return {found, hit.time};
}
Found by_reference(const Pair& p) {
  const auto hit = reference::first_hit({p.from, p.to}, p.x0, p.x1);
  return {hit.has_value(), hit ? hit->tau : 0};
}

/// As an array holds it; not inlined, for g++ 12 then computes on with the digits that it should have lost.
[[gnu::noinline]] kokkos_backend::Real3 stored(const Vector3d& v) {
  using kokkos_backend::Real;
  return {Real(v[0]), Real(v[1]), Real(v[2])};
}

struct Tally {
  int misses = 0, false_hits = 0, hits = 0;
};

/// Σ m v of particles and nodes, kg m/s, and Σ m |v|.
std::pair<Vector80, double> momentum(const Model& m, const HostState& s) {
  Vector80 sum = Vector80::Zero();
  double size = 0;
  const auto add = [&](double mass, const Vec3& v) {
    const Vector80 p = Real80(mass) * Vector80(v[0], v[1], v[2]);
    sum += p;
    size += static_cast<double>(p.norm());
  };
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) add(kilograms(m, s.fluid_mass[i]), s.fluid_velocity[i]);
  for (std::size_t n = 0; n < s.node_position.size(); ++n)
    add(m.mesh.solid_mass[n] + kilograms(m, s.node_liquid[n]), s.node_velocity[n]);
  return {sum, size};
}

}  // namespace

TEST(ccd, no_hit_is_missed_and_none_is_invented) {
  constexpr int pairs = 1'000'000;
  Pairs source;
  Tally backend, reference;
  std::array<int, Pairs::kinds> crossings{}, first_miss;
  first_miss.fill(-1);
  int touches = 0;
  for (int k = 0; k < pairs; ++k) {
    const int kind = k % Pairs::kinds;
    const Pair pair = source.make(kind);
    const Referee referee(pair);
    const Real80 crossing = referee.clear_crossing();
    const bool touched = referee.clear_touch_at_end();
    crossings[static_cast<std::size_t>(kind)] += crossing <= 1;
    touches += touched;
    for (const bool is_backend : {true, false}) {
      Tally& tally = is_backend ? backend : reference;
      const Found found = is_backend ? by_backend(pair) : by_reference(pair);
      tally.hits += found.hit;
      // A later hit than the referee's is a miss too. Touching without a change of side is the backend's only.
      const bool missed =
          (crossing <= 1 && !(found.hit && found.time <= crossing + 1e-6L)) || (is_backend && touched && !found.hit);
      tally.misses += missed;
      if (missed && first_miss[static_cast<std::size_t>(kind)] < 0) first_miss[static_cast<std::size_t>(kind)] = k;
      if (found.hit && referee.beyond(found.time) > 0) ++tally.false_hits;
    }
  }
  for (int kind = 0; kind < Pairs::kinds; ++kind) {
    const auto at = static_cast<std::size_t>(kind);
    std::printf("kind %d: %d clear crossings, first miss at pair %d\n", kind, crossings[at], first_miss[at]);
    if (kind != 4) {  // what moves within one plane changes no side
      EXPECT_GT(crossings[at], kind == 5 || kind == 8 ? 5000 : 10000) << "kind " << kind;
    }
  }
  EXPECT_GT(touches, 40000);
  EXPECT_GT(backend.hits, 500000);
  const char* what = "Collision of particle and triangle, 10⁶ random and degenerate pairs up to 100 × the usual speed";
  report({what + std::string(": missed by the backend"), "check in long double", double(backend.misses), 0, "pairs"});
  report(
      {what + std::string(": missed by the reference"), "check in long double", double(reference.misses), 0, "pairs"});
  report({what + std::string(": hits without contact, backend"), "check in long double", double(backend.false_hits), 0,
          "pairs"});
  report({what + std::string(": hits without contact, reference"), "check in long double", double(reference.false_hits),
          0, "pairs"});
}

TEST(ccd, what_the_filter_rules_out_does_not_hit) {
  using namespace kokkos_backend;
  constexpr int pairs = 1'000'000;
  Pairs source;
  int ruled_out = 0, lost = 0, hits = 0;
  for (int k = 0; k < pairs; ++k) {
    const Pair p = source.make(k % Pairs::kinds);
    const Real3 x0 = stored(p.x0), x1 = stored(p.x1);
    const Real3 from[3] = {stored(p.from[0]), stored(p.from[1]), stored(p.from[2])};
    const Real3 to[3] = {stored(p.to[0]), stored(p.to[1]), stored(p.to[2])};
    Hit hit;
    const bool hits_it = first_hit(widen(x0), widen(x1), {widen(from[0]), widen(from[1]), widen(from[2])},
                                   {widen(to[0]), widen(to[1]), widen(to[2])}, touch, hit);
    const RelativeWay way(x0, x1, from, to);
    const bool out = passes_by(way, Real(1e-3 * 0.01)) || stays_on_its_side(way, Real(touch));
    hits += hits_it;
    ruled_out += out;
    lost += hits_it && out;
  }
  EXPECT_GT(hits, 400000);
  EXPECT_GT(ruled_out, 50000);
  std::printf("%d hits, %d of %d others ruled out\n", hits, ruled_out, pairs - hits);
  report({"Collision of particle and triangle, the same pairs: hits that the single-precision filter rejects",
          "none, by its bounds", double(lost), 0, "pairs"});
}

TEST(ccd, impulses_conserve_momentum) {
  // A block at 30 m/s, several particles a triangle, meets a free sheet within one step.
  const drench::Setup setup = build(parse_scene(R"(drench: 1
time: {step: 0.002, end: 1}
gravity: [0, 0, 0]
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid:
  spacing: 0.01
  sources: [{block: {min: [-0.05, 0.006, -0.05], max: [0.05, 0.05, 0.05], velocity: [3, -30, 1]}}]
cloth: [{mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}}]
)",
                                                "ccd.yaml"));
  for (const bool is_reference : {false, true}) {
    const auto backend = is_reference ? make_reference_backend(setup.model) : make_kokkos_backend(setup.model);
    StepReport done;
    const StepInfo info{0, 0, 0.002};
    backend->upload(setup.state);
    for (const Stage stage : {Stage::neighbors, Stage::density}) backend->run(stage, info, done);
    const auto before = momentum(setup.model, backend->download());
    backend->run(Stage::advection, info, done);
    const auto after = momentum(setup.model, backend->download());
    EXPECT_GT(done.collisions, 100);
    report({is_reference ? "Collision of particles and cloth, momentum before and after: reference"
                         : "Collision of particles and cloth, momentum before and after",
            "conservation", static_cast<double>((after.first - before.first).norm()) / before.second,
            is_reference || double_precision ? 1e-12 : 1e-6, "of Σ m v"});
  }
}

}  // namespace drench::test
