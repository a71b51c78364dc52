#pragma once
// The mechanical energy of a state, for energy.csv and reports.

#include <filesystem>
#include <string>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// In J, as docs/theory/mass.md says: Eq. 4. Wet cloth counts with its liquid; bodies count where they are dynamic.
struct Energies {
  double liquid_kinetic = 0, cloth_kinetic = 0, body_kinetic = 0;
  double liquid_potential = 0, cloth_potential = 0, body_potential = 0;  ///< in gravity and in the scene's field
  double stretch = 0;                                                    ///< of springs and strain limits
  double bend = 0;
  double total() const {
    return liquid_kinetic + cloth_kinetic + body_kinetic + liquid_potential + cloth_potential + body_potential +
           stretch + bend;
  }
};

/// Sums in double, in the order of the state. Particles and nodes that are not finite make it so.
Energies energies_of(const Model& model, const HostState& state);

/// energy.csv in a run's folder: a row a frame, with the columns of docs/manual/output.md that the scene has something
/// for.
class EnergyCsv {
 public:
  /// `frames` > 0 goes on after so many rows of the file that is there. Without such a file the first row is the next
  /// frame's.
  EnergyCsv(const std::filesystem::path& folder, const Model& model, int frames = 0);
  /// Adds the state's row. Throws std::runtime_error when the disk refuses.
  void write(const HostState& state);
  /// Puts the file onto the disk itself.
  void sync() const;

 private:
  const Model& model_;
  std::filesystem::path path_;
  std::string text_;  // the whole file
};

}  // namespace drench
