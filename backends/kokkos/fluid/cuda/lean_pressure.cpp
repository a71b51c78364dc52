// The lean iterations of the pressure (fluid/lean_pressure.hpp).

#include "fluid/lean_pressure.hpp"

#ifndef DRENCH_DOUBLE

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/cuda/block_sums.hpp"
#include "fluid/cuda/packed_acceleration.hpp"

namespace drench::kokkos_backend {

/// A pair is a word: the neighbour's index less the bundle's `base`, and the root of V_j |dW/dr|/r over factor_scale(),
/// 16 bits each. Four words are one load. A row is padded with factors of 0.
struct LeanPressure {
  Array<uint4> word;           // at a bundle's start / 4: [group][lane]
  Array<Index> base;           // of each bundle; −1: it has an index or a factor that 16 bits do not hold
  Array<std::uint8_t> groups;  // of each row; the highest bit: beside solids or sheets
  Field<uint4> packed;         // of each particle, see pack()
  Field<Real> base_contact;    // λ of the full evaluation
  Version of_lists = Version::none();
};

namespace {

constexpr Index bundle = warp_size, most_groups = 127, threads = 128, blocks_a_processor = 9;
constexpr float lattice = 16384;  // steps a support

/// The largest factor, over that of (dW/dr)/r: what lies closer has a bundle that is read in full.
float most_factor(KernelKind kind) { return kind == KernelKind::wendland ? 1 : 4; }

void check(cudaError_t status) {
  if (status != cudaSuccess) throw std::runtime_error(std::string("pressure: ") + cudaGetErrorString(status));
}

template <class Body>
__global__ void __launch_bounds__(threads, blocks_a_processor) run(const Body body) {
  body();
}

/// The root of a pair's factor as words keep it; also where a bundle has no words, so that nobody can tell.
__device__ __forceinline__ int root_of(float factor, float inverse_scale) {
  const float square = factor * inverse_scale;
  return square > 0 ? __float2int_rn(square * inverse_root(square)) : 0;
}
__device__ __forceinline__ float rounded_factor(float factor, float inverse_scale) {
  const auto root = static_cast<float>(root_of(factor, inverse_scale));
  return root * root;
}

/// Blocks that have a thread for each row.
Index blocks_of(Index rows) { return (rows + threads - 1) / threads; }

/// Runs `body` in blocks that have a thread for each of n rows.
template <class Body>
void launch(const char* label, Index n, const Body& body) {
  if (n <= 0) return;
  const ExecSpace space;
  std::uint64_t id = 0;
  Kokkos::Tools::beginParallelFor(label, Kokkos::Tools::Experimental::device_id(space), &id);
  run<<<static_cast<unsigned>(blocks_of(n)), threads, 0, space.cuda_stream()>>>(body);
  check(cudaGetLastError());
  Kokkos::Tools::endParallelFor(id);
}
__device__ __forceinline__ Index own_row() { return static_cast<Index>(blockIdx.x * threads + threadIdx.x); }

/// A load that is not wanted again.
__device__ __forceinline__ uint4 load_once(const uint4* p) {
  uint4 v;
  asm volatile("ld.global.nc.L1::no_allocate.L2::128B.v4.u32 {%0,%1,%2,%3}, [%4];"
               : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
               : "l"(p));
  return v;
}
/// In units of factor_scale().
__device__ __forceinline__ float factor_of(unsigned word) {
  const float root = __uint_as_float((word & 0xffffu) | 0x4b000000u) - 8388608.0f;
  return root * root;
}
__device__ __forceinline__ unsigned index_of(unsigned word) { return word >> 16; }

struct LeanRows {
  const uint4* word;
  const Index* base;
  const std::uint8_t* groups;
  const std::int64_t* start;

  /// Is it beside solids or sheets?
  __device__ __forceinline__ bool is_bounded(Index i) const { return __ldg(groups + i) > most_groups; }
  /// Calls pair(word) for each pair of row i, with the next group of four already under way.
  template <class Pair>
  __device__ __forceinline__ void visit(Index i, const Pair& pair) const {
    const uint4* const at = word + (__ldg(reinterpret_cast<const long long*>(start) + i / bundle) / 4 + i % bundle);
    const int count = __ldg(groups + i) & most_groups;
    uint4 next{};
    if (count > 0) next = load_once(at);
    for (int k = 0; k < count; ++k) {
      const uint4 w = next;
      if (k + 1 < count) next = load_once(at + (k + 1) * bundle);
      pair(w.x);
      pair(w.y);
      pair(w.z);
      pair(w.w);
    }
  }
};

/// Writes a row's words. A warp has a bundle.
struct MakeRows {
  Neighbors list, walls;
  Entries<const Index> sheets;  // where a row begins
  Index count;
  float inverse_scale;  // m²: of a factor
  uint4* word;
  Index* base;
  std::uint8_t* groups;
  bool has_walls, has_sheets;

  __device__ bool is_bounded(Index i) const {
    return (has_walls && walls.count(i) > 0) || (has_sheets && sheets(i + 1) > sheets(i));
  }
  __device__ void operator()() const {
    const Index i = own_row(), b = i / bundle;
    if (b * bundle >= count) return;
    NeighborRow row{};
    if (i < count) row = list.row(i);
    // Cells lie in order, so what is near lies about as far before the bundle as behind it.
    const Index least = b * bundle > 32768 ? b * bundle - 32768 : 0;
    const int own_groups = (row.count + 3) / 4;
    bool far = own_groups > most_groups;
    uint4* const at = word + (list.start(b) / 4 + i % bundle);
    for (int g = 0; g < own_groups && !far; ++g) {
      unsigned w[4];
#pragma unroll
      for (int k = 0; k < 4; ++k) {
        const Index e = 4 * g + k;
        const bool real = e < row.count;
        const Index from = (real ? row(e) : i) - least;
        const int root = real ? root_of(row.grad_factor(e), inverse_scale) : 0;
        far |= from < 0 || from > 65535 || root > 65535;
        w[k] = static_cast<unsigned>(from) << 16 | (static_cast<unsigned>(root) & 0xffffu);
      }
      at[std::int64_t{g} * bundle] = {w[0], w[1], w[2], w[3]};
    }
    far = __any_sync(all_lanes, far);
    if (i % bundle == 0) base[b] = far ? -1 : least;
    if (i < count)
      groups[i] = static_cast<std::uint8_t>((far ? 0 : own_groups) | (is_bounded(i) ? most_groups + 1 : 0));
  }
};

struct LeanAcceleration {
  LeanRows rows;
  Neighbors list;
  const float4* position_kappa;  // x_i, and the change of κ_i
  Entries<const Real3> boundary, sheet, gain_diagonal, gain_shear;
  Entries<const Real> contact, base_contact;
  uint4* packed;
  float scale, inverse_scale, steps;  // 1/m²: of the factors; m², −1 over that; 1/m
  Index first, end;                   // the rows
  bool touching, extrapolates;

  __device__ void operator()() const {
    const Index i = first + own_row();
    if (i >= end) return;
    const float4 here = __ldg(position_kappa + i);
    Real3 a;
    const Index base = __ldg(rows.base + i / bundle);
    if (base >= 0) {
      const float4* const near = position_kappa + base;
      rows.visit(i, [&](unsigned w) {
        const float4 q = __ldg(near + index_of(w));
        const float f = factor_of(w) * (here.w + q.w);
        a.x = fmaf(f, here.x - q.x, a.x);
        a.y = fmaf(f, here.y - q.y, a.y);
        a.z = fmaf(f, here.z - q.z, a.z);
      });
    } else {
      const NeighborRow near = list.row(i);
      for (Index k = 0; k < near.count; ++k) {
        const float4 q = __ldg(position_kappa + near(k));
        const float f = rounded_factor(near.grad_factor(k), inverse_scale) * (here.w + q.w);
        a.x = fmaf(f, here.x - q.x, a.x);
        a.y = fmaf(f, here.y - q.y, a.y);
        a.z = fmaf(f, here.z - q.z, a.z);
      }
    }
    a = scale * a;
    if (rows.is_bounded(i)) {
      a -= here.w * boundary(i);
      if (touching) a -= (contact(i) - base_contact(i)) * sheet(i);
      if (extrapolates) a = product(gain_diagonal(i), gain_shear(i), a);
    }
    packed[i] = pack(a, {here.x, here.y, here.z}, steps);
  }
};

/// Nesterov's step after an update.
struct Momentum {
  Entries<const Real> next, last, next_contact, last_contact;
  Entries<Real> kappa, contact;  // of the next iteration
  float weight;
  bool touching;

  /// Returns κ of the next iteration.
  __device__ __forceinline__ Real step(Index i, bool bounded, Real before, Real contact_before) const {
    const Real k = next(i), y = fmaxf(k + weight * (k - before), 0.0f);
    kappa(i) = y;
    if (touching && bounded) {
      const Real c = next_contact(i);
      contact(i) = fmaxf(c + weight * (c - contact_before), 0.0f);
    }
    return y;
  }
};

/// What the change of the acceleration adds to the liquid's part of the rate.
struct LiquidRate {
  LeanRows rows;
  Neighbors list;
  const uint4* packed;
  Entries<const Real> base;  // 1/s: of the full evaluation
  float dt, scale;           // s; −1/m²: of a factor and a step of the lattice
  float inverse_scale;       // m²: −1 over a factor's

  __device__ __forceinline__ float change(Index i, const PackedDifference& difference) const {
    float sum = 0;
    const Index first = __ldg(rows.base + i / bundle);
    if (first >= 0) {
      const uint4* const near = packed + first;
      rows.visit(i, [&](unsigned w) { sum = fmaf(factor_of(w), difference(__ldg(near + index_of(w))), sum); });
      return scale * sum;
    }
    const NeighborRow near = list.row(i);
    for (Index k = 0; k < near.count; ++k)
      sum = fmaf(rounded_factor(near.grad_factor(k), inverse_scale), difference(__ldg(packed + near(k))), sum);
    return scale * sum;
  }
  __device__ __forceinline__ float operator()(Index i, const PackedDifference& difference) const {
    return base(i) + dt * change(i, difference);
  }
};

/// The rates, and the end of an iteration.
template <class Update>
struct LeanUpdate {
  LiquidRate liquid;
  DensityOperator divergence;
  float4* position_kappa;
  const float4* base;  // v_i and κ_i of the full evaluation
  Entries<const Real3> ub;
  Entries<const Real> compliance;
  Update update;
  Momentum momentum;
  BlockSums<typename Update::Sums, threads> sums;
  Index first, end;  // the rows

  using Few = decltype(std::declval<Update>()(0, 0, 0));

  /// What walls and sheets have in the rate of a particle with velocity v; `approach`: the sheets.
  __device__ __forceinline__ float of_boundary(Index i, const Real3& v, float& approach) const {
    float sum = 0;
    divergence.add_walls(i, v, ub, sum);
    approach = divergence.approach(i, v);
    return sum + approach;
  }
  __device__ __forceinline__ Few of_row(Index i) const {
    const bool bounded = liquid.rows.is_bounded(i);
    const float4 from = __ldg(base + i);
    const PackedDifference difference(__ldg(liquid.packed + i));
    float rate = liquid(i, difference), approach = 0;
    if (bounded) rate += of_boundary(i, Real3{from.x, from.y, from.z} + liquid.dt * difference.a, approach);
    const Real before = momentum.last(i), contact_before = momentum.touching && bounded ? momentum.last_contact(i) : 0;
    const Few own = update(i, rate - liquid.dt * compliance(i) * update.kappa(i), approach);
    position_kappa[i].w = momentum.step(i, bounded, before, contact_before) - from.w;
    return own;
  }
  __device__ void operator()() const {
    const Index i = first + own_row();
    sums.add(update.exact(i < end ? of_row(i) : Few{}));
  }
};

struct FinishVelocities {
  const uint4* packed;
  float4* velocity;
  float dt;
  Index count;

  __device__ void operator()() const {
    const Index i = own_row();
    if (i >= count) return;
    const Real3 a = acceleration_of(packed[i]);
    float4 v = velocity[i];
    v.x += dt * a.x;
    v.y += dt * a.y;
    v.z += dt * a.z;
    velocity[i] = v;
  }
};

/// 1/m²: a factor whose root is 1.
float factor_scale(const PressureSystem& system) {
  const Kernel& kernel = system.constants.kernel;
  const double full = system.constants.model.particle_mass / system.constants.model.rest_density;
  return static_cast<float>(kernel.grad_scale * full) * most_factor(kernel.kind) / (65535.0f * 65535.0f);
}

LeanRows rows_of(const PressureSystem& system) {
  const LeanPressure& lean = *system.work.lean;
  return {lean.word.data(), lean.base.data(), lean.groups.data(), system.lists.fluid_fluid.start.data()};
}

void make_rows(const PressureSystem& system, LeanPressure& lean) {
  const NeighborList& list = system.lists.fluid_fluid;
  const Index bundles = (system.count() + bundle - 1) / bundle;
  make_room(lean.word, "drench::pressure::lean_word", list.entry.extent(0) / 4);
  make_ample_room(lean.base, "drench::pressure::lean_base", static_cast<std::size_t>(bundles));
  make_ample_room(lean.groups, "drench::pressure::lean_groups", static_cast<std::size_t>(bundles * bundle));
  launch("drench::pressure::lean_rows", bundles * bundle,
         MakeRows{Neighbors(list), Neighbors(system.lists.fluid_boundary), system.lists.sheet_rows.of_particle,
                  system.count(), -1 / factor_scale(system), lean.word.data(), lean.base.data(), lean.groups.data(),
                  system.bodies.boundary.count > 0, system.has_sheets()});
  lean.of_lists = system.lists.made;
}

LiquidRate liquid_rate(const PressureSystem& system) {
  const PressureWork& work = system.work;
  return {rows_of(system),          Neighbors(system.lists.fluid_fluid),
          work.lean->packed.data(), work.liquid_rate,
          float(system.dt),         -factor_scale(system) * system.constants.support / lattice,
          -1 / factor_scale(system)};
}

template <class Update>
SumUnderWay<typename Update::Sums> begin_update(PressureSystem& system, const Update& update, Real momentum, int slot) {
  using Sums = typename Update::Sums;
  constexpr const char* label = "drench::pressure::lean_rate";
  PressureWork& work = system.work;
  const PressureWork& seen = work;
  SumRoom& room = sum_room();
  if (room.finished.data() == nullptr)
    room.finished = Kokkos::View<unsigned, MemSpace>("drench::partial_sums::finished");
  Sums* const total = sums_in<Sums>(room.few, 2).data() + slot;
  const Index count = system.count(), inner = system.fluid.exchange.inner(count);
  const Index before = blocks_of(inner), blocks = std::max(before + blocks_of(count - inner), Index{1});
  LeanUpdate<Update> rows{liquid_rate(system),
                          system.divergence(seen.position_kappa, system.sheets_of_particles()),
                          reinterpret_cast<float4*>(work.position_kappa.data()),
                          reinterpret_cast<const float4*>(work.predicted.data()),
                          system.bodies.seen_velocity(),
                          std::as_const(system.fluid).compliance,
                          update,
                          {seen.next_kappa, seen.last_kappa, seen.next_contact_pressure, seen.last_contact_pressure,
                           work.other_kappa, work.other_contact_pressure, momentum, system.touching},
                          {sums_in<Sums>(room.many, blocks).data(), total, room.finished.data(), 0, unsigned(blocks)},
                          0,
                          inner};
  launch(label, inner, rows);
  system.fluid.exchange.finish_halo();  // of the packed accelerations
  rows.first = inner;
  rows.end = count;
  rows.sums.first = static_cast<unsigned>(before);
  launch(label, inner > 0 ? count - inner : std::max(count, Index{1}), rows);
  return {label, total, 1};
}
}  // namespace

void begin_lean_pressure(PressureSystem& system) {
  PressureWork& work = system.work;
  if (!work.lean) work.lean = std::make_shared<LeanPressure>();
  LeanPressure& lean = *work.lean;
  if (lean.of_lists != system.lists.made) make_rows(system, lean);
  const std::size_t n = system.fluid.particles.capacity();
  make_room(lean.packed, "drench::pressure::lean_packed", n);
  make_room(work.other_kappa, "drench::pressure::other_kappa", n);
  if (!system.touching) return;
  make_room(work.other_contact_pressure, "drench::pressure::other_contact", n);
  make_room(lean.base_contact, "drench::pressure::base_contact", n);
  const Entries<Real> base = lean.base_contact;
  const Entries<const Real> contact = std::as_const(work).contact_pressure;
  parallel(
      "drench::pressure::base_contact", system.count(), KOKKOS_LAMBDA(const Index i) { base(i) = contact(i); });
}

void predict_lean_liquid(PressureSystem& system) {
  LeanPressure& lean = *system.work.lean;
  const Fluid& fluid = system.fluid;
  // What loads sheets and bodies reads κ itself.
  if (system.has_cloth() || system.bodies.dynamic.count > 0) fluid.exchange.halo(system.kappa);
  fluid.exchange.begin_halo(system.work.position_kappa);
  const Index count = system.count(), inner = fluid.exchange.inner(count);
  LeanAcceleration rows{rows_of(system),
                        Neighbors(system.lists.fluid_fluid),
                        reinterpret_cast<const float4*>(system.work.position_kappa.data()),
                        fluid.boundary_gradient,
                        fluid.contact.gradient,
                        fluid.wall_gain.diagonal,
                        fluid.wall_gain.shear,
                        std::as_const(system.work).contact_pressure,
                        std::as_const(lean).base_contact,
                        lean.packed.data(),
                        factor_scale(system),
                        -1 / factor_scale(system),
                        lattice / system.constants.support,
                        0,
                        inner,
                        system.touching,
                        system.constants.model.extrapolates_walls()};
  constexpr const char* label = "drench::pressure::lean_acceleration";
  launch(label, inner, rows);
  fluid.exchange.finish_halo();
  rows.first = inner;
  rows.end = count;
  launch(label, count - inner, rows);
  fluid.exchange.begin_halo(lean.packed);
}

SumUnderWay<DensitySums> begin_lean_update(PressureSystem& system, const DensityUpdate& update, Real momentum,
                                           int slot) {
  return begin_update(system, update, momentum, slot);
}
SumUnderWay<IterationNorms> begin_lean_update(PressureSystem& system, const DivergenceUpdate& update, Real momentum,
                                              int slot) {
  return begin_update(system, update, momentum, slot);
}

void finish_lean_pressure(PressureSystem& system) {
  launch("drench::pressure::lean_velocities", system.count(),
         FinishVelocities{system.work.lean->packed.data(), reinterpret_cast<float4*>(system.work.predicted.data()),
                          float(system.dt), system.count()});
}

}  // namespace drench::kokkos_backend

#endif
