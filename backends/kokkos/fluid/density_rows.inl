// The liquid's part of a particle's density and Jacobi diagonal (fluid/density.cpp), for one instruction set.

#include "core/lanes.inl"

/// Kernel::pair for several pairs, with 1/r in place of r.
[[gnu::always_inline]] inline void pair_lanes(const Kernel& k, const Lanes& square, Lanes& inverse, Lanes& value,
                                              Lanes& grad_factor) {
  const Lanes none{};
  Lanes root = square;
  take_root(root);
  inverse = square > none + Real(1e-18) * k.h * k.h ? Real(1) / root : none;
  const Lanes r = square * inverse, q = r * k.inverse_h, p = Real(1) - q;
  if (k.kind == KernelKind::cubic) {
    const Lanes half = Real(0.5) - q, t = half > none ? half : none;
    const Lanes steep = q < none + Real(1.0 / 3) ? none + Real(1.0 / 3) : p * p - 4 * t * t;
    value = 2 * k.sigma * (p * p * p - 4 * t * t * t);
    grad_factor = -k.grad_scale * steep * (inverse * k.h);
    return;
  }
  const Lanes held = k.steepest * k.grad_factor(k.steepest) * inverse;
  if (k.kind == KernelKind::wendland) {
    value = k.sigma * (p * p) * (p * p) * (4 * q + 1);
    grad_factor = r < none + k.steepest ? held : -k.grad_scale * p * p * p;
    return;
  }
  const Lanes s = p * (1 + q);
  value = k.sigma * s * s * s;
  grad_factor = q > none + Real(1e-9) ? -k.grad_scale * p * p * (k.h * inverse) : none;
}

/// DensityPairs::add_liquid.
inline void add_liquid_lanes(const DensityPairs& pairs, Index i, DensitySum& sum) {
  const Real4 own = pairs.position(i);
  const WritableRow near = pairs.lf.writable.row(i);
  const Index* const item = near.item + near.first;
  Real* const kept = near.factor + near.first;
  Lanes delta[vectors_of_sum]{}, gx[vectors_of_sum]{}, gy[vectors_of_sum]{}, gz[vectors_of_sum]{},
      squares[vectors_of_sum]{}, yielded[vectors_of_sum]{};
  const Lanes none{};
  Lanes closest = none + Real(1e30);
  for (Index k = 0; k < near.count; k += lanes) {
    const Index rest = near.count - k, part = part_of(k);
    Index room[lanes];
    LaneVectors other;
    load_lanes(pairs.position.data, next_items(item + k, rest, i, room), other);
    const Lanes x = own.x - other.x, y = own.y - other.y, z = own.z - other.z, square = x * x + y * y + z * z;
    Lanes apart = square;
    if (rest < lanes) {
      keep_first(rest, other.w);
      Lanes there = none + Real(1);
      keep_first(rest, there);
      apart += Real(1e30) * (Real(1) - there);
    }
    closest = apart < closest ? apart : closest;
    Lanes inverse, value, grad_factor;
    pair_lanes(pairs.kernel, square, inverse, value, grad_factor);
    const Lanes weighted = other.w * grad_factor;
    store_lanes(weighted, rest, kept + k);
    delta[part] += other.w * value;
    gx[part] += weighted * x;
    gy[part] += weighted * y;
    gz[part] += weighted * z;
    const Lanes steep = weighted * grad_factor * square, heavier = other.w - own.w;
    squares[part] += steep;
    yielded[part] += (heavier > none ? heavier : none) * steep;
  }
  sum.delta = own.w * pairs.kernel.value(0) + sum_of(delta);
  sum.gradient = {sum_of(gx), sum_of(gy), sum_of(gz)};
  sum.squares = own.w * sum_of(squares);
  sum.yielded = sum_of(yielded);
  const Real least = Real(1.001) * pairs.coincident.least;
  if (least_of(closest) < least * least) pairs.add_separation(i, sum);
}
