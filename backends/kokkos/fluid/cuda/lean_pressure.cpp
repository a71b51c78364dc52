// The lean iterations of the pressure (fluid/lean_pressure.hpp).

#include "fluid/lean_pressure.hpp"

#ifndef DRENCH_DOUBLE

#include <algorithm>
#include <utility>

#include "core/cuda/block_sums.hpp"
#include "core/cuda/check.hpp"
#include "fluid/cuda/packed_acceleration.hpp"

namespace drench::kokkos_backend {

struct LeanPressure {
  Field<uint4> packed;       // of each particle, see pack()
  Field<Real> base_contact;  // λ of the full evaluation
};

namespace {

constexpr Index threads = 128, blocks_a_processor = 9;
constexpr float lattice = 16384;  // steps a support

template <Index lanes, class Body>
__global__ void __launch_bounds__(threads, blocks_a_processor) run(const Body body) {
  body.template work<lanes>();
}

/// Threads that share a row, where the liquid is too little for a GPU's threads: the same on any number of ranks.
constexpr Index few_lanes = 4, few_rows = 15'000;
Index lanes_of(const PressureSystem& system) { return system.all() < few_rows ? few_lanes : 1; }

/// Blocks that have `lanes` threads for each row.
Index blocks_of(Index rows, Index lanes) { return (rows + threads / lanes - 1) / (threads / lanes); }

/// Runs `body` in blocks that have `lanes` threads for each of n rows.
template <class Body>
void launch(const char* label, Index n, Index lanes, const Body& body) {
  if (n <= 0) return;
  const ExecSpace space = exec();
  std::uint64_t id = 0;
  Kokkos::Tools::beginParallelFor(label, Kokkos::Tools::Experimental::device_id(space), &id);
  const auto blocks = static_cast<unsigned>(blocks_of(n, lanes));
  if (lanes == 1)
    run<1><<<blocks, threads, 0, space.cuda_stream()>>>(body);
  else
    run<few_lanes><<<blocks, threads, 0, space.cuda_stream()>>>(body);
  check(cudaGetLastError(), "pressure");
  Kokkos::Tools::endParallelFor(id);
}
template <Index lanes>
__device__ __forceinline__ Index own_row() {
  return static_cast<Index>(blockIdx.x * threads + threadIdx.x) / lanes;
}
template <Index lanes>
__device__ __forceinline__ Index own_lane() {
  return static_cast<Index>(threadIdx.x) % lanes;
}
/// The sum over the lanes of a row, in each of them; all threads of a warp call it.
template <Index lanes>
__device__ __forceinline__ float over_lanes(float sum) {
#pragma unroll
  for (Index apart = lanes / 2; apart > 0; apart /= 2) sum += __shfl_xor_sync(all_lanes, sum, apart);
  return sum;
}

struct LeanAcceleration {
  DensityOperator divergence;  // with the change of κ_i
  Entries<const Real3> boundary, sheet, gain_diagonal, gain_shear;
  Entries<const Real> contact, base_contact;
  uint4* packed;
  float steps;       // 1/m
  Index first, end;  // the rows
  bool touching, extrapolates;

  template <Index lanes>
  __device__ void work() const {
    const Index i = first + own_row<lanes>(), lane = own_lane<lanes>();
    Real3 sum;
    if (i < end) sum = divergence.gradient<lanes>(i, lane);
    Real3 a{-over_lanes<lanes>(sum.x), -over_lanes<lanes>(sum.y), -over_lanes<lanes>(sum.z)};
    if (i >= end || lane > 0) return;
    const Real4 here = divergence.position(i);
    if (divergence.liquid.is_bounded(i)) {
      a -= here.w * boundary(i);
      if (touching) a -= (contact(i) - base_contact(i)) * sheet(i);
      if (extrapolates) a = product(gain_diagonal(i), gain_shear(i), a);
    }
    packed[i] = pack(a, here.xyz(), steps);
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

/// What the change of the acceleration adds to the liquid's part of the rate: DensityOperator::add_liquid of packed
/// accelerations.
struct LiquidRate {
  LiquidPairs pairs;
  PairSlope slope;  // of positions on the lattice
  const uint4* packed;
  Entries<const Real> base;  // 1/s: of the full evaluation
  float dt, scale;           // s; 1/m⁴, of a step of the lattice

  /// Of `lanes` that share a row each has its own part; without `base`.
  template <Index lanes>
  __device__ __forceinline__ float change(Index i, Index lane, const PackedDifference& difference) const {
    const CompactRow near = pairs.compact_row(i);
    float sum = 0;
    if (pairs.has_mixed_volumes(i)) {
      near.for_each<lanes>(
          [&](Index j) {
            const Apart apart = difference(__ldg(packed + j));
            sum = fmaf(pairs.volume(j) * slope(apart.square), apart.rate, sum);
          },
          lane);
    } else {
      near.for_each_filled_up<lanes>(
          [&](std::uint32_t k, Index origin) {
            const Apart apart = difference(__ldg(packed + origin + k));
            sum = fmaf(slope(apart.square), apart.rate, sum);
          },
          lane);
      sum *= pairs.volume(i);
    }
    return dt * scale * sum;
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
  /// `change`: of the liquid's part of the rate.
  __device__ __forceinline__ Few of_row(Index i, const PackedDifference& difference, float change) const {
    const bool bounded = liquid.pairs.is_bounded(i);
    const float4 from = __ldg(base + i);
    float rate = liquid.base(i) + change, approach = 0;
    if (bounded) rate += of_boundary(i, Real3{from.x, from.y, from.z} + liquid.dt * difference.a, approach);
    const Real before = momentum.last(i), contact_before = momentum.touching && bounded ? momentum.last_contact(i) : 0;
    const Few own = update(i, rate - liquid.dt * compliance(i) * update.kappa(i), approach);
    position_kappa[i].w = momentum.step(i, bounded, before, contact_before) - from.w;
    return own;
  }
  template <Index lanes>
  __device__ void work() const {
    const Index i = first + own_row<lanes>(), lane = own_lane<lanes>();
    const PackedDifference difference(i < end ? __ldg(liquid.packed + i) : uint4{});
    const float change = over_lanes<lanes>(i < end ? liquid.change<lanes>(i, lane, difference) : 0.0f);
    sums.add(update.exact(i < end && lane == 0 ? of_row(i, difference, change) : Few{}));
  }
};

struct FinishVelocities {
  const uint4* packed;
  float4* velocity;
  float dt;
  Index count;

  template <Index>
  __device__ void work() const {
    const Index i = own_row<1>();
    if (i >= count) return;
    const Real3 a = acceleration_of(packed[i]);
    float4 v = velocity[i];
    v.x += dt * a.x;
    v.y += dt * a.y;
    v.z += dt * a.z;
    velocity[i] = v;
  }
};

LiquidRate liquid_rate(const PressureSystem& system, const DensityOperator& divergence) {
  const PressureWork& work = system.work;
  const Kernel& kernel = system.constants.kernel;
  return {.pairs = divergence.liquid,
          .slope = PairSlope(kernel.kind, lattice),
          .packed = work.lean->packed.data(),
          .base = work.liquid_rate,
          .dt = float(system.dt),
          .scale = -kernel.grad_scale * (kernel.h / lattice)};
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
  const Index lanes = lanes_of(system), before = blocks_of(inner, lanes),
              blocks = std::max(before + blocks_of(count - inner, lanes), Index{1});
  const DensityOperator divergence = system.divergence(seen.position_kappa, system.sheets_of_particles());
  LeanUpdate<Update> rows{
      .liquid = liquid_rate(system, divergence),
      .divergence = divergence,
      .position_kappa = reinterpret_cast<float4*>(work.position_kappa.data()),
      .base = reinterpret_cast<const float4*>(work.predicted.data()),
      .ub = system.bodies.seen_velocity(),
      .compliance = std::as_const(system.fluid).compliance,
      .update = update,
      .momentum = {seen.next_kappa, seen.last_kappa, seen.next_contact_pressure, seen.last_contact_pressure,
                   work.other_kappa, work.other_contact_pressure, momentum, system.touching},
      .sums = {sums_in<Sums>(room.many, blocks).data(), total, room.finished.data(), 0, unsigned(blocks)},
      .first = 0,
      .end = inner};
  launch(label, inner, lanes, rows);
  system.fluid.exchange.finish_halo();  // of the packed accelerations
  rows.first = inner;
  rows.end = count;
  rows.sums.first = static_cast<unsigned>(before);
  launch(label, inner > 0 ? count - inner : std::max(count, Index{1}), lanes, rows);
  return {label, total, 1};
}

}  // namespace

void begin_lean_pressure(PressureSystem& system) {
  PressureWork& work = system.work;
  if (!work.lean) work.lean = std::make_shared<LeanPressure>();
  LeanPressure& lean = *work.lean;
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
  LeanAcceleration rows{.divergence = system.divergence(std::as_const(system.work).position_kappa, {}),
                        .boundary = fluid.boundary_gradient,
                        .sheet = fluid.contact.gradient,
                        .gain_diagonal = fluid.wall_gain.diagonal,
                        .gain_shear = fluid.wall_gain.shear,
                        .contact = std::as_const(system.work).contact_pressure,
                        .base_contact = std::as_const(lean).base_contact,
                        .packed = lean.packed.data(),
                        .steps = lattice / system.constants.support,
                        .first = 0,
                        .end = inner,
                        .touching = system.touching,
                        .extrapolates = system.constants.model.extrapolates_walls()};
  constexpr const char* label = "drench::pressure::lean_acceleration";
  launch(label, inner, lanes_of(system), rows);
  fluid.exchange.finish_halo();
  rows.first = inner;
  rows.end = count;
  launch(label, count - inner, lanes_of(system), rows);
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
  launch("drench::pressure::lean_velocities", system.count(), 1,
         FinishVelocities{system.work.lean->packed.data(), reinterpret_cast<float4*>(system.work.predicted.data()),
                          float(system.dt), system.count()});
}

}  // namespace drench::kokkos_backend

#endif
