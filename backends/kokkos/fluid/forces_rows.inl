// The liquid's part of a particle's viscous sums (fluid/forces.cpp), for one instruction set.

#include "core/lanes.inl"

/// ViscousSum::add for all liquid neighbours; `moving`: velocity and 1/√δ.
inline void add_liquid_friction(const Real4* position, const Real4* moving, const NeighborRow& near, Index i,
                                ViscousSum& sum) {
  const Real4 own = position[i], moves = moving[i];
  const Index* const item = near.item + near.first;
  const Real* const factor = near.factor + near.first;
  Lanes px[vectors_of_sum]{}, py[vectors_of_sum]{}, pz[vectors_of_sum]{}, bound[vectors_of_sum]{};
  for (Index k = 0; k < near.count; k += lanes) {
    const Index rest = near.count - k, part = part_of(k);
    Index room[lanes];
    LaneVectors other, v;
    Lanes f;
    const Index* const at = next_items(item + k, rest, i, room);
    load_lanes(position, at, other);
    load_lanes(moving, at, v);
    load_factors(factor + k, rest, f);
    const Lanes x = own.x - other.x, y = own.y - other.y, z = own.z - other.z;
    f *= v.w;
    const Lanes along = f * ((moves.x - v.x) * x + (moves.y - v.y) * y + (moves.z - v.z) * z);
    px[part] += along * x;
    py[part] += along * y;
    pz[part] += along * z;
    bound[part] -= f * (x * x + y * y + z * z);
  }
  sum.pull += {sum_of(px), sum_of(py), sum_of(pz)};
  sum.bound += sum_of(bound);
}
