#pragma once
// One specimen of a test: its fabric, its scene, and what is measured on it.

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "drench/drench.hpp"
#include "laboratory/laboratory.hpp"
#include "state/film.hpp"

namespace drench {

inline constexpr double standard_gravity = 9.81;  // m/s²
inline constexpr double water_density = 1000;     // kg/m³
inline constexpr double water_viscosity = 1e-6;   // m²/s
inline constexpr double pi = std::numbers::pi;

enum class Direction { warp, weft };

class Trial {
 public:
  Trial(const StandardTest& test, const TestRequest& request, Direction direction, int repeat);

  /// The specimen's fabric, with the overrides of its keys.
  const MaterialScene& material() const { return material_; }
  Direction direction() const { return direction_; }
  bool along_warp() const { return direction_ == Direction::warp; }
  int repeat() const { return repeat_; }
  /// Tells specimens apart: between −1 and 1, evenly spread over the repeats; 0 for the first. `purpose` counts the
  /// quantities that a test varies.
  double scatter(int purpose) const;

  /// kg/m²: liquid in the saturated fabric.
  double capacity() const;
  /// m/s: Darcy flux that the capillary pressure ρgℓ drives through half of the fabric's thickness, for
  /// `porous.uptake_velocity` of fabrics without an absorption rate of their own.
  double uptake_velocity() const;

  /// The entry `cloth` of a scene: `cloth.0` is the specimen.
  /// @param mesh the value of `mesh`
  /// @param keys further lines of the cloth, indented by 4 spaces
  /// @param porous keys and values of `porous`, which replace those of the fabric
  std::string specimen(const std::string& mesh, const std::string& keys, const std::string& porous = "") const;
  /// Does the fabric draw liquid in by itself?
  bool wicks() const { return material_.diffusivity > 0 && !(material_.breakthrough_pressure > 0); }
  /// Keys of `porous`, which replace those of the fabric: for tests in which the fabric holds no more than its pores
  /// do.
  std::string porous_without_film();
  /// The same for tests in which liquid does not spread within the fabric.
  std::string porous_without_wicking();
  /// The same for tests in which liquid lies on the fabric, but does not pass it.
  std::string porous_without_flow();
  /// The test writes this key of the fabric itself, from material(), which has the overrides of it.
  void writes(const std::string& key) { written_.push_back(key); }
  /// The key `warp` for a grid whose z axis is the specimen's length.
  std::string warp_along_length() const;

  /// Writes the scene with the overrides and sets up its run.
  /// @param text of the scene; a comment at the top describes it
  /// @param suffix of the file's name
  std::unique_ptr<Simulation> open(const std::string& text, const std::string& suffix = "");
  /// The folder for files that a scene needs.
  const std::filesystem::path& folder() const { return request_.folder; }
  /// The name of a file for this specimen alone: `stem`, the specimen's name, `ending`.
  std::string file_name(const std::string& stem, const std::string& ending) const;

  void row(std::vector<double> values);
  void number(std::string key, std::string meaning, std::string unit, double value,
              std::optional<double> expected = std::nullopt);
  void note(std::string text);

  /// What was measured, with a note of keys that the test does not use.
  TestedSpecimen take();
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  /// `key: value` for `porous`, which also replaces an override.
  std::string without(const std::string& key, const std::string& value);
  void foresee(const Simulation& run) const;

  const StandardTest& test_;
  const TestRequest& request_;
  Direction direction_;
  int repeat_;
  MaterialScene material_;
  TestedSpecimen specimen_;
  std::vector<std::string> written_;
  std::vector<std::string> unused_;  // keys of `porous` that the fabric has and the test does not use
  std::vector<std::string> warnings_;
};

/// Steps until `end`, s, and calls `look` at t = 0 and then every `interval`, s. Ends when `look` returns false.
void watch_run(Simulation& run, double end, double interval, const std::function<bool(const HostState&)>& look);

/// kg: liquid in particles, and in the nodes of a cloth.
double liquid_mass(const Simulation& run, const HostState& state);
double cloth_mass(const Simulation& run, const HostState& state, Index cloth = 0);

/// The straight line through points by least squares.
struct FittedLine {
  double slope = 0, at_zero = 0;
};
FittedLine fit_line(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace drench
