// The lean iterations of the pressure (fluid/lean_pressure.hpp).

#include "fluid/lean_pressure.hpp"

#ifdef DRENCH_DOUBLE

namespace drench::kokkos_backend {

bool begin_lean_pressure(PressureSystem&) { return false; }
void predict_lean_liquid(PressureSystem&) {}
void measure_lean_density_rate(PressureSystem&) {}

}  // namespace drench::kokkos_backend

#else

#include <cuda_fp16.h>

#include <climits>
#include <cstdlib>

#include "coupling/wall.hpp"

namespace drench::kokkos_backend {

/// A pair is a word: the neighbour's index less the bundle's least one, 16 bits, and V_j |dW/dr|/r over that of a full particle
/// in half precision. Four words are one load. A row is padded with pairs of the particle with itself and factor 0.
struct LeanPressure {
  Array<uint4> word;            // at a bundle's start / 4: [group][lane]
  Array<Index> base;            // of each bundle; −1: its neighbours lie too far apart for 16 bits
  Array<std::uint8_t> groups;   // of each row
  Array<uint4> packed;          // of each particle, see pack()
  Array<Real> starting_rate;    // 1/s: the liquid's part of the density rate at the solve's first velocities
  Version of_lists = Version::none();
};

namespace {

constexpr Index bundle = 32, most_groups = 255;
constexpr float lattice = 16384;  // steps a support

using LeanRange = Kokkos::RangePolicy<ExecSpace, Kokkos::IndexType<Index>, Kokkos::LaunchBounds<128, 9>>;

struct LeanRows {
  Entries<const uint4> word;
  Entries<const Index> base;
  Entries<const std::uint8_t> groups;
  Entries<const std::int64_t> start;

  /// Calls pair(word) for each pair of row i: loads that are used once go past the first-level cache, a group ahead.
  template <class Pair>
  __device__ __forceinline__ void visit(Index i, const Pair& pair) const {
    const uint4* at = word.data + (start(i / bundle) / 4 + i % bundle);
    const int count = groups(i);
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
  __device__ __forceinline__ static uint4 load_once(const uint4* p) {
    uint4 v;
    asm volatile("ld.global.nc.L1::no_allocate.L2::128B.v4.u32 {%0,%1,%2,%3}, [%4];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(p));
    return v;
  }
};
__device__ __forceinline__ float factor_of(unsigned word) { return __half2float(__ushort_as_half(word >> 16)); }

/// a in 24, 24 and 32 bits, x in steps of h/16384 in 16 bits each, which wrap: neighbours are closer than 32768 of them.
__device__ __forceinline__ uint4 pack(const Real3& a, const Real3& x, float steps) {
  const auto on_lattice = [=](float coordinate) { return static_cast<unsigned>(__float2int_rn(coordinate * steps)); };
  const unsigned px = on_lattice(x.x), py = on_lattice(x.y), pz = on_lattice(x.z);
  return {(__float_as_uint(a.x) & ~0xffu) | (pz & 0xffu), (__float_as_uint(a.y) & ~0xffu) | (pz >> 8 & 0xffu),
          __float_as_uint(a.z), (px & 0xffffu) | py << 16};
}

/// (a_j − a_i)·(x_j − x_i) in steps of the lattice, from what was packed. The low bits of a_x and a_y are left as they are.
struct PackedDifference {
  float ax, ay, az;
  unsigned x, y, z;  // 2^15 − own, in the low half, the high half, the low half

  __device__ __forceinline__ static PackedDifference from(const uint4& own) {
    return {__uint_as_float(own.x), __uint_as_float(own.y), __uint_as_float(own.z),
            0x8000u - (own.w & 0xffffu), 0x80000000u - (own.w & 0xffff0000u),
            0x8000u - ((own.x & 0xffu) | (own.y & 0xffu) << 8)};
  }
  __device__ __forceinline__ float operator()(const uint4& q) const {
    constexpr float zero = 8388608.0f + 32768.0f;  // 2^23 + 2^15
    const float dx = __uint_as_float(__byte_perm(q.w + x, 0x4b000000u, 0x7610)) - zero,
                dy = __uint_as_float(__byte_perm(q.w + y, 0x4b000000u, 0x7632)) - zero,
                dz = __uint_as_float(__byte_perm(__byte_perm(q.x, q.y, 0x5540) + z, 0x4b000000u, 0x7610)) - zero;
    return (__uint_as_float(q.x) - ax) * dx + (__uint_as_float(q.y) - ay) * dy + (__uint_as_float(q.z) - az) * dz;
  }
};

/// Writes a row's words. A warp has a bundle.
struct MakeRows {
  Neighbors list;
  Index count;
  float inverse_scale;  // of a factor
  Entries<uint4> word;
  Entries<Index> base;
  Entries<std::uint8_t> groups;

  __device__ void operator()(const Index i) const {
    const bool exists = i < count;
    Index least = exists ? i : INT_MAX, most = exists ? i : 0;
    NeighborRow row{};
    if (exists) row = list.row(i);
    for (Index k = 0; k < row.count; ++k) {
      const Index j = row(k);
      least = j < least ? j : least;
      most = j > most ? j : most;
    }
    const int own_groups = (row.count + 3) / 4;
    int longest = own_groups;
    for (int apart = bundle / 2; apart > 0; apart /= 2) {
      least = min(least, __shfl_xor_sync(~0u, least, apart));
      most = max(most, __shfl_xor_sync(~0u, most, apart));
      longest = max(longest, __shfl_xor_sync(~0u, longest, apart));
    }
    const bool far = most - least > 65535 || longest > most_groups;
    if (i % bundle == 0) base(i / bundle) = far ? -1 : least;
    if (!exists) return;
    groups(i) = static_cast<std::uint8_t>(far ? 0 : own_groups);
    if (far) return;
    const std::int64_t first = list.start(i / bundle) / 4 + i % bundle;
    for (int g = 0; g < own_groups; ++g) {
      unsigned w[4];
      for (int k = 0; k < 4; ++k) {
        const Index at = 4 * g + k;
        const bool real = at < row.count;
        const Index j = real ? row(at) : i;
        const float factor = real ? fminf(row.grad_factor(at) * inverse_scale, 60000.0f) : 0.0f;
        w[k] = static_cast<unsigned>(j - least) | static_cast<unsigned>(__half_as_ushort(__float2half_rn(factor))) << 16;
      }
      word(first + std::int64_t{g} * bundle) = {w[0], w[1], w[2], w[3]};
    }
  }
};

/// The liquid's part of the density rate at the velocities as they are.
struct StartingRate {
  Neighbors list;
  Entries<const Real4> position;
  Entries<const Real3> velocity;
  Entries<Real> rate;

  __device__ void operator()(const Index i) const {
    const Real3 x = position(i).xyz(), v = velocity(i);
    const NeighborRow near = list.row(i);
    Real sum = 0;
    DRENCH_UNROLL
    for (Index k = 0; k < near.count; ++k) {
      const Index j = near(k);
      sum += near.grad_factor(k) * dot(v - velocity(j), x - position(j).xyz());
    }
    rate(i) = sum;
  }
};

/// What both kernels see of walls and sheets.
struct WallsAndSheets {
  Entries<const Real3> wall_gradient, gradient;
  Entries<const Real> ratio;
  Neighbors solids, sheets;
  bool has_solids, has_sheets, touching;

  WallsAndSheets(const PressureSystem& s)
      : wall_gradient(s.lists.fluid_boundary.gradient),
        gradient(s.lists.fluid_sample.gradient),
        ratio(s.fluid.particles.density_ratio),
        solids(s.lists.fluid_boundary),
        sheets(s.lists.fluid_sample),
        has_solids(s.bodies.boundary.count > 0),
        has_sheets(s.has_cloth()),
        touching(s.touching) {}
};

struct LeanAcceleration {
  LeanRows rows;
  Neighbors list;
  WallsAndSheets walls;
  Entries<const Real4> position_kappa;
  Entries<const Real3> velocity;
  Entries<const Real> contact, volume;
  Entries<Real4> predicted;
  Entries<uint4> packed;
  float dt, scale, steps;  // s; 1/m²: of the factors; 1/m

  __device__ void operator()(const Index i) const {
    const Real4 here = position_kappa(i);
    const Real3 x = here.xyz();
    const Real kappa = here.w;
    Real3 a;
    const Index base = rows.base(i / bundle);
    if (base >= 0) {
      const float4* const near = reinterpret_cast<const float4*>(position_kappa.data + base);
      rows.visit(i, [&](unsigned w) {
        const float4 q = __ldg(near + (w & 0xffffu));
        const float f = factor_of(w) * (kappa + q.w);
        a.x = fmaf(f, x.x - q.x, a.x);
        a.y = fmaf(f, x.y - q.y, a.y);
        a.z = fmaf(f, x.z - q.z, a.z);
      });
      a = scale * a;
    } else {
      const NeighborRow near = list.row(i);
      for (Index k = 0; k < near.count; ++k) {
        const Real4 at = position_kappa(near(k));
        a -= (near.grad_factor(k) * (kappa + at.w)) * (x - at.xyz());
      }
    }
    const Real at_sheet = walls.touching ? kappa + contact(i) : kappa;
    if (walls.has_solids && kappa != 0) {
      const NeighborRow near = walls.solids.row(i);
      for (Index k = 0; k < near.count; ++k) a -= (mirrored * kappa) * walls.wall_gradient(near.index_of(k));
    }
    if (walls.has_sheets) {
      const NeighborRow near = walls.sheets.row(i);
      if (near.count > 0) {
        const Real dense = image_density(walls.ratio(i)) * mirrored * at_sheet;
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) a -= dense * walls.gradient(near.index_of(k));
        predicted(i) = {velocity(i) + dt * a, sheet_load(walls.ratio(i), volume(i), at_sheet)};
      }
    }
    packed(i) = pack(a, x, steps);
  }
};

struct LeanRate {
  LeanRows rows;
  Neighbors list;
  WallsAndSheets walls;
  Entries<const uint4> packed;
  Entries<const Real4> position_kappa, us;
  Entries<const Real3> velocity, ub;
  Entries<const Real> starting_rate, compliance, kappa;
  Entries<Real> rate, approach;
  float dt, scale;  // s; −1/m²: of a factor and a step of the lattice

  __device__ void operator()(const Index i) const {
    const uint4 own = packed(i);
    const PackedDifference difference = PackedDifference::from(own);
    Real change = 0;  // of the liquid's part, a second
    const Index base = rows.base(i / bundle);
    if (base >= 0) {
      const uint4* const near = packed.data + base;
      rows.visit(i, [&](unsigned w) { change = fmaf(factor_of(w), difference(__ldg(near + (w & 0xffffu))), change); });
      change *= scale;
    } else {
      const NeighborRow near = list.row(i);
      const Real3 x = position_kappa(i).xyz(), a{difference.ax, difference.ay, difference.az};
      for (Index k = 0; k < near.count; ++k) {
        const uint4 q = packed(near(k));
        const Real3 other{__uint_as_float(q.x), __uint_as_float(q.y), __uint_as_float(q.z)};
        change += near.grad_factor(k) * dot(a - other, x - position_kappa(near(k)).xyz());
      }
    }
    Real sum = starting_rate(i) + dt * change;
    if (walls.has_solids || walls.has_sheets) {
      const Real3 v = velocity(i) + dt * Real3{difference.ax, difference.ay, difference.az};
      if (walls.has_solids) {
        const NeighborRow near = walls.solids.row(i);
        for (Index k = 0; k < near.count; ++k)
          sum += mirrored * dot(v - ub(near(k)), walls.wall_gradient(near.index_of(k)));
      }
      if (walls.has_sheets) {
        Real sheet = 0;
        const NeighborRow near = walls.sheets.row(i);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k)
          sheet += dot(v - us(near(k)).xyz(), walls.gradient(near.index_of(k)));
        sheet *= mirrored * image_density(walls.ratio(i));
        if (walls.touching) approach(i) = sheet;
        sum += sheet;
      }
    }
    rate(i) = sum - dt * compliance(i) * kappa(i);
  }
};

/// 1/m²: the factor that counts as 1.
float factor_scale(const PressureSystem& system) {
  return system.constants.kernel.grad_scale * Real(system.constants.model.particle_mass / system.constants.model.rest_density);
}

LeanRows rows_of(const PressureSystem& system, const LeanPressure& lean) {
  return {lean.word, lean.base, lean.groups, system.lists.fluid_fluid.start};
}

void make_rows(const PressureSystem& system, LeanPressure& lean) {
  const NeighborList& list = system.lists.fluid_fluid;
  const Index rows = (system.count() + bundle - 1) / bundle * bundle;
  make_ample_room(lean.word, "drench::pressure::lean_word", list.entry.extent(0) / 4);
  make_ample_room(lean.base, "drench::pressure::lean_base", static_cast<std::size_t>(rows / bundle));
  make_ample_room(lean.groups, "drench::pressure::lean_groups", static_cast<std::size_t>(rows));
  Kokkos::parallel_for("drench::pressure::lean_rows", LoopRange(0, rows),
                       MakeRows{Neighbors(list), system.count(), -1 / factor_scale(system), lean.word, lean.base, lean.groups});
}

}  // namespace

bool begin_lean_pressure(PressureSystem& system) {
  static const bool off = std::getenv("DRENCH_NO_LEAN") != nullptr;
  if (off) return false;
  PressureWork& work = system.work;
  if (!work.lean) work.lean = std::make_shared<LeanPressure>();
  LeanPressure& lean = *work.lean;
  if (lean.of_lists != system.lists.made) make_rows(system, lean);
  lean.of_lists = system.lists.made;
  const std::size_t n = system.fluid.particles.capacity();
  make_room(lean.packed, "drench::pressure::lean_packed", n);
  make_room(lean.starting_rate, "drench::pressure::lean_rate", n);
  Kokkos::parallel_for("drench::pressure::starting_rate", LoopRange(0, system.count()),
                       StartingRate{Neighbors(system.lists.fluid_fluid), std::as_const(system.fluid).position_volume,
                                    std::as_const(system.fluid).particles.velocity, lean.starting_rate});
  return true;
}

void predict_lean_liquid(PressureSystem& system) {
  LeanPressure& lean = *system.work.lean;
  const float steps = lattice / system.constants.support;
  const LeanAcceleration kernel{rows_of(system, lean),
                                Neighbors(system.lists.fluid_fluid),
                                WallsAndSheets(system),
                                std::as_const(system.work).position_kappa,
                                std::as_const(system.fluid).particles.velocity,
                                std::as_const(system.work).contact_pressure,
                                std::as_const(system.fluid).volume,
                                system.work.predicted,
                                lean.packed,
                                float(system.dt),
                                factor_scale(system),
                                steps};
  Kokkos::parallel_for("drench::pressure::lean_acceleration", LeanRange(0, system.count()), kernel);
}

void measure_lean_density_rate(PressureSystem& system) {
  const LeanPressure& lean = *system.work.lean;
  const LeanRate kernel{rows_of(system, lean),
                        Neighbors(system.lists.fluid_fluid),
                        WallsAndSheets(system),
                        lean.packed,
                        std::as_const(system.work).position_kappa,
                        std::as_const(system.cloth).samples.predicted,
                        std::as_const(system.fluid).particles.velocity,
                        system.bodies.seen_velocity(),
                        lean.starting_rate,
                        std::as_const(system.fluid).compliance,
                        std::as_const(system.kappa),
                        system.work.density_rate,
                        system.work.approach_rate,
                        float(system.dt),
                        -factor_scale(system) * system.constants.support / lattice};
  Kokkos::parallel_for("drench::pressure::lean_rate", LeanRange(0, system.count()), kernel);
}

}  // namespace drench::kokkos_backend

#endif
