#pragma once
// A field of the backend as it lies in memory, seen without a copy.

#include <cstdint>
#include <memory>
#include <string_view>

#include "base/types.hpp"

namespace drench {

/// A field of the backend's own arrays, named as in HostState. It is read-only.
///
/// The rows of liquid particles lie in the backend's order, which changes from step to step; `fluid_id` names them.
/// A view belongs to the generation in which it was taken. Its memory stays valid as long as `memory` is held, but a
/// later step may put other values there: Simulation::is_current() tells.
struct FieldView {
  /// Type of a number.
  enum class Type : std::uint8_t { float32, float64, int64, uint8 };
  /// Where the numbers lie.
  enum class Memory : std::uint8_t { host, cuda };

  std::string_view name;               ///< "fluid_position"
  std::string_view unit;               ///< of the table of fields: "m"
  const void* data = nullptr;          ///< of the first number; null if there are no rows
  Type type = Type::float32;           ///< of a number
  Index rows = 0;                      ///< particles, nodes, samples or bodies
  int columns = 1;                     ///< 1: numbers; 3: vectors x y z; 4: quaternions w x y z
  std::int64_t row_bytes = 0;          ///< from one row to the next, bytes
  Memory where = Memory::host;         ///< what can read `data`
  std::uint64_t generation = 0;        ///< Simulation::generation() when the view was taken
  std::shared_ptr<const void> memory;  ///< keeps the array alive
};

/// Copies a view's values, row by row without gaps, into `to` on the host.
/// @param view of a Simulation; it may be stale, and what it shows is then any step's
/// @param to room for rows × columns numbers of the view's type
void copy_to_host(const FieldView& view, void* to);

}  // namespace drench
