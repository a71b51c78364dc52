#pragma once
// An acceleration and a position in one load of 16 bytes, for the rate of the lean iterations.

#include "core/types.hpp"

namespace drench::kokkos_backend {

/// a in 24, 24 and 32 bits, x in steps of h/16384 in 16 bits each, which wrap: neighbours are closer than 32768 of
/// them.
__device__ __forceinline__ uint4 pack(const Real3& a, const Real3& x, float steps) {
  const auto on_lattice = [=](float coordinate) { return static_cast<unsigned>(__float2int_rn(coordinate * steps)); };
  const unsigned px = on_lattice(x.x), py = on_lattice(x.y), pz = on_lattice(x.z);
  return {(__float_as_uint(a.x) & ~0xffu) | (pz & 0xffu), (__float_as_uint(a.y) & ~0xffu) | (pz >> 8 & 0xffu),
          __float_as_uint(a.z), (px & 0xffffu) | py << 16};
}
/// The acceleration that was packed. The low bits of a_x and a_y are left as they are.
__device__ __forceinline__ Real3 acceleration_of(const uint4& q) {
  return {__uint_as_float(q.x), __uint_as_float(q.y), __uint_as_float(q.z)};
}

/// (a_j − a_i)·(x_j − x_i) and |x_j − x_i|², the positions in steps of the lattice.
struct Apart {
  float rate, square;
};
struct PackedDifference {
  Real3 a;
  unsigned x, y, z;  // 2^15 − own, in the low half, the high half, the low half

  __device__ __forceinline__ explicit PackedDifference(const uint4& own)
      : a(acceleration_of(own)),
        x(0x8000u - (own.w & 0xffffu)),
        y(0x80000000u - (own.w & 0xffff0000u)),
        z(0x8000u - ((own.x & 0xffu) | (own.y & 0xffu) << 8)) {}
  __device__ __forceinline__ Apart operator()(const uint4& q) const {
    constexpr float zero = 8388608.0f + 32768.0f;  // 2^23 + 2^15
    const float dx = __uint_as_float(__byte_perm(q.w + x, 0x4b000000u, 0x7610)) - zero,
                dy = __uint_as_float(__byte_perm(q.w + y, 0x4b000000u, 0x7632)) - zero,
                dz = __uint_as_float(__byte_perm(__byte_perm(q.x, q.y, 0x5540) + z, 0x4b000000u, 0x7610)) - zero;
    return {
        fmaf(__uint_as_float(q.z) - a.z, dz, fmaf(__uint_as_float(q.y) - a.y, dy, (__uint_as_float(q.x) - a.x) * dx)),
        fmaf(dz, dz, fmaf(dy, dy, dx * dx))};
  }
};

}  // namespace drench::kokkos_backend
