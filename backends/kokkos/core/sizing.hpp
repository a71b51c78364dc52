#pragma once
// What arrays are sized by, before any is made: each subsystem tells the bytes of its own beside the code that
// allocates them, and backend.cpp adds them up.

#include <type_traits>

#include "base/types.hpp"
#include "setup/memory_estimate.hpp"

namespace drench::kokkos_backend {

inline constexpr double index_bytes = sizeof(Index), quanta_bytes = sizeof(Quanta), double_bytes = sizeof(double);

/// `real`, the bytes of a Real, and `gpu` need not be this build's: the reference is judged in double, and tests ask
/// for a GPU.
struct Sizing {
  Sizing(const SetupSize& scene, int real_bytes, bool on_gpu)
      : size(with_expected_mesh(scene)), entries(expected_entries(scene, on_gpu)), real(real_bytes), gpu(on_gpu) {
    if (compact_pairs())
      entries.fluid_fluid += 1.5 * size.fluid;  // the liquid's own bundles are whole groups of four wide
  }

  SetupSize size;
  ListTotals entries;
  double real;
  bool gpu;

  /// As core/neighbor_list.hpp has it.
  bool compact_pairs() const { return gpu && real == sizeof(float); }

  // As Model has them, for the conditions in the table of fields (src/state/fields.hpp).
  bool has_fluid() const { return size.liquid; }
  bool has_porous() const { return size.porous; }
  bool has_micropolar() const { return size.micropolar; }
  bool has_permeation() const { return size.permeation; }
  bool counts_faces() const { return size.fabric && (size.absorption || size.emission); }
  bool has_solute() const { return size.solute; }
  bool has_squeezing() const { return size.squeezing; }
  bool has_hysteresis() const { return size.hysteresis; }

  /// Of an entry of a field that has this type on the host.
  template <class T>
  double entry() const {
    if constexpr (std::is_same_v<T, Vec3>)
      return 3 * real;
    else if constexpr (std::is_same_v<T, double>)
      return real;
    else
      return sizeof(T);
  }
};

}  // namespace drench::kokkos_backend
