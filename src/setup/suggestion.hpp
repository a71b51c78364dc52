#pragma once
// What `drench new` decides about a first scene, and the text of it.

#include <optional>
#include <string>
#include <vector>

#include "setup/first_scene.hpp"
#include "setup/garment.hpp"

namespace drench {

/// Everything that the text below has a number for. SI units.
struct Suggestion {
  std::string mesh;    // "" for the grid
  SurfaceMesh points;  // of that file
  std::string body;    // "" for none
  std::string fabric;  // "" for the numbers below
  MeshPaths paths = MeshPaths::as_given;
  bool animated = false;  // it is a pattern of the names of several files, ...
  double body_rate = 24;  // ... so many of them per second
  MeshGuess body_guess;
  bool worn = false;               // the garment's shift puts it on the body
  bool pinned = true;              // false: the body holds it, or it falls onto the body
  std::vector<std::string> found;  // what the set-up says, as comments
  Garment garment;
  double spacing = 0, thickness = 0.001, bend = 1e-4, step = 0.004, every = 0.02, end = 1;
  double solid_fraction = 0.6;  // 1
  double whole_thickness = 0;   // m: of the fabric, where `thickness` is less for the sake of self_collision; else 0
  std::optional<Vec3> warp;     // where the fabric has one and the mesh does not give it
  bool self_collision = false;
  int settle = ClothScene{}.settle;
  Box domain;
  double radius = 0, jet_end = 0, jet_mass = 0, capacity = 0;
  Vec3 nozzle{0, 0, 0}, velocity{0, 0, 0};
};

constexpr GridScene suggested_grid{{0.6, 0.6}, {31, 31}};  // without a mesh
constexpr double fastest_release = 0.25;                   // m/s: of nodes that start inside the body

/// The nearest multiple of `unit` that is at least x (`up`), or at most x.
double outward(double x, double unit, bool up);
/// A word for YAML.
std::string in_quotes(const std::string& text);
/// "[0.1, 0.2, 0.3]"
std::string list(const Vec3& v);

/// The scene file. `with_body`: false to measure the cloth alone, which is faster.
std::string text_of(const Suggestion& s, bool with_body = true);

}  // namespace drench
