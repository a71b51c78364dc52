#pragma once
// The solids that a node of the cloth touches. Law: docs/theory/cloth.md, section 11.

#include "bodies/contact.hpp"

namespace drench::kokkos_backend {

/// The solids that a node touches: which directions their planes leave it, how far their surfaces move in the step (m),
/// and what presses the node into all of them, as a force or a displacement.
template <class T = Real>
struct NodeContact {
  bool touches = false, held = false;  // held: no direction is left
  Vector3<T> normal, second;           // at right angles; second: 0 unless it is pressed onto two planes
  Vector3<T> beside;                   // normal of a plane that it touches unpressed, at right angles to both; or 0
  Vector3<T> moved;
  T press = 0;

  /// The part of v along the directions that are left.
  KOKKOS_INLINE_FUNCTION Vector3<T> tangential(const Vector3<T>& v) const {
    if (held) return {};
    return v - dot(v, normal) * normal - dot(v, second) * second;
  }
  /// One more plane that it is pressed onto.
  KOKKOS_INLINE_FUNCTION void add_plane(const Vector3<T>& own) {
    if (!(dot(normal, normal) > 0)) {
      normal = own;
      return;
    }
    const Vector3<T> fresh = fresh_direction(own);
    if (dot(fresh, fresh) > 0) add_second(fresh);
  }
  /// A plane that it is not pressed onto: `beside`.
  KOKKOS_INLINE_FUNCTION void add_beside(const Vector3<T>& own) {
    if (!(dot(beside, beside) > 0)) beside = fresh_direction(own);
  }
  /// `next` after Coulomb friction: it slips along the surface by `loss` (m) less, at most to a standstill.
  KOKKOS_INLINE_FUNCTION Vector3<T> with_friction(const Vector3<T>& next, T loss) const {
    const Vector3<T> slip = tangential(next - moved);
    const T length = norm(slip);
    return length > loss ? next - (loss / length) * slip : next - slip;
  }
  /// The same of a node at `shift`. Where friction would move it into the plane beside, it slips along both, and
  /// `blocked` becomes true (docs/theory/cloth.md, section 11).
  KOKKOS_INLINE_FUNCTION Vector3<T> slipped(const Vector3<T>& shift, const Vector3<T>& next,
                                            std::type_identity_t<T> loss, bool* blocked = nullptr) const {
    const Vector3<T> after = with_friction(next, loss);
    if (!(dot(after - shift, beside) < 0)) return after;
    if (blocked != nullptr) *blocked = true;
    NodeContact both = *this;
    both.add_second(beside);
    return both.with_friction(next - dot(next - shift, beside) * beside, loss);
  }

 private:
  /// Of a plane's normal, of unit length: what is at right angles to the planes so far; 0 for a plane as one of them.
  KOKKOS_INLINE_FUNCTION Vector3<T> fresh_direction(const Vector3<T>& own) const {
    const Vector3<T> fresh = tangential(own);
    const T length = norm(fresh);
    return length < T(0.05) ? Vector3<T>{} : (1 / length) * fresh;
  }
  KOKKOS_INLINE_FUNCTION void add_second(const Vector3<T>& fresh) {
    held = dot(second, second) > 0;
    second = fresh;
  }
};

/// The slip (m) as the residual's test counts it: 0 where it is below a tenth of the displacement along the normal,
/// `relative` less the slip. An interpolated distance has normals that jump so much between its cells.
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> counted_slip(const Vector3<T>& relative, const Vector3<T>& slip) {
  const Vector3<T> along_normal = relative - slip;
  return dot(slip, slip) > T(0.01) * dot(along_normal, along_normal) ? slip : Vector3<T>{};
}

/// A solid next to a node, by its number.
template <class T>
struct FoundSolid {
  std::size_t solid;
  NearSolid<T> near;
};

/// The solids that a node touches, and what presses it into each of them.
template <class T>
struct TouchedSolids {
  static constexpr int most = 4;
  int count = 0;
  std::size_t solid[most];
  NearSolid<T> near[most];
  T held[most];
  int first = -1, second = -1;  // the two that squeeze the node most
  Vector3<T> halfway;           // normal of the surface between them, away from the first
  T across = 0;                 // what presses the node from the first (or, if negative, from the second)

  KOKKOS_INLINE_FUNCTION void add(const Slice<const Solid>& solids, std::size_t b, const NearSolid<T>& own) {
    for (int k = 0; k < count; ++k) {
      if (!alike(solids(solid[k]), normal(k), solids(b), own.at.normal)) continue;
      if (!(own.at.phi - own.kept < phi(k) - near[k].kept)) return;
      solid[k] = b;
      near[k] = own;
      return;
    }
    solid[count] = b;
    near[count] = own;
    held[count++] = 0;
  }
  /// Solids j and k squeeze the node.
  KOKKOS_INLINE_FUNCTION void add_pair(int j, int k) {
    if (first >= 0 && !(phi(j) + phi(k) < phi(first) + phi(second))) return;
    first = j;
    second = k;
  }
  KOKKOS_INLINE_FUNCTION T phi(int k) const { return near[k].at.phi; }
  KOKKOS_INLINE_FUNCTION const Vector3<T>& normal(int k) const { return near[k].at.normal; }
  /// Is it one of these two?
  KOKKOS_INLINE_FUNCTION bool holds_halfway(int k) const { return k == first || k == second; }
  /// Takes from `push` what presses into the solids: all of it across the surface halfway between two that squeeze the
  /// node, and of the others the least that leaves none of it in any of them, by projected Gauss-Seidel.
  KOKKOS_INLINE_FUNCTION void take(Vector3<T>& push) {
    constexpr bool exact = sizeof(T) == sizeof(double);
    constexpr int sweeps = exact ? 200 : 50;
    if (first >= 0) halfway = Halfway<T>(near[first], near[second]).normal;
    const T enough = T(exact ? 1e-12 : 1e-7) * norm(push);
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      T most_change = 0;
      if (first >= 0) {
        const T change = -dot(push, halfway);
        across += change;
        push += change * halfway;
        most_change = Kokkos::abs(change);
      }
      for (int k = 0; k < count; ++k) {
        if (holds_halfway(k)) continue;
        const T change = larger(-held[k], -dot(push, normal(k)));
        held[k] += change;
        push += change * normal(k);
        most_change = larger(most_change, Kokkos::abs(change));
      }
      if (count == 1 || !(most_change > enough)) return;
    }
  }
};

}  // namespace drench::kokkos_backend
