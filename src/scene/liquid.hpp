#pragma once
// Section `fluid` of a scene as plain structs, and what other sections share with it.

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/keyed.hpp"
#include "base/types.hpp"
#include "scene/motion.hpp"

namespace drench {

/// A box along the axes.
struct Box {
  Vec3 min{0, 0, 0};  // m
  Vec3 max{0, 0, 0};  // m

  bool operator==(const Box&) const = default;
};

/// The smoothing kernel.
enum class KernelKind { cubic, wendland, poly6 };
/// What pressure a wall has beside a particle: the particle's, or that plus what its gradient along the wall adds.
enum class WallPressure { mirrored, extrapolated };
/// The axis of a mesh file that points up; the mesh is turned so that it becomes y.
enum class UpAxis { x, y, z };
/// The unit of a mesh file's coordinates.
enum class LengthUnit { m, dm, cm, mm, inch };
/// Section `fluid.solver`: when the pressure solves end.
struct FluidSolverScene {
  double density_error = 1e-3;         // 1; mean compression that ends the density solve
  double divergence_error = 1e-3;      // 1; mean compression rate · Δt that ends the divergence solve
  int max_iterations = 100;            // most iterations of either solve
  int min_iterations = 2;              // fewest iterations of either solve
  double density_correction = 0.5;     // c, 1; correction factor of a density error (stages/pressure.hpp)
  std::optional<double> source_error;  // η, 1; part of a step's own compression that ends the density solve

  bool operator==(const FluidSolverScene&) const = default;
};

/// A file with points, and how they come to their places: scaled, turned about the file's origin, then moved.
struct PlacedFile {
  std::string file;
  double scale = 1.0;               // 1
  LengthUnit unit = LengthUnit::m;  // of the file's coordinates
  UpAxis up = UpAxis::y;            // of the file
  Vec3 position{0, 0, 0};           // m
  Vec3 rotate_axis{1, 0, 0};        // its length does not matter
  double rotate_degrees = 0.0;      // °

  bool operator==(const PlacedFile&) const = default;
};

/// A source of liquid that is there at the start: a volume that is full of it, or particles of a file.
struct BlockScene {
  /// What it is.
  enum class Shape { box, sphere, mesh, particles };
  Box box;                   // full of liquid; of another shape: what it lies in, once the scene is set up
  Vec3 velocity{0, 0, 0};    // m/s; of particles: where their file has none
  double concentration = 0;  // kg/kg; of its solute
  Shape shape = Shape::box;  // which decides the members that count
  Vec3 center{0, 0, 0};      // m; of a sphere
  double radius = 0.1;       // m; of a sphere
  PlacedFile placed{};       // of a closed mesh, or of particles; of a sequence, the first file
  SequenceScene sequence{};  // of particles that another program moves

  bool operator==(const BlockScene&) const = default;
};

/// A source of liquid: a plane nozzle.
struct JetScene {
  /// Of its mouth.
  enum class Shape { disc, rectangle };
  Vec3 center{0, 0, 0};                                  // m
  double radius = 0.05;                                  // m; of a disc
  Keyed<Vec3> velocity;                                  // m/s; the nozzle's axis
  double start = 0.0;                                    // s
  double end = std::numeric_limits<double>::infinity();  // s
  double concentration = 0;                              // kg/kg; of its solute
  Shape shape = Shape::disc;                             // which decides the members that count
  std::array<double, 2> size{0.1, 0.1};                  // m; of a rectangle: the second side is along `up`
  std::optional<Vec3> up{};    // of a rectangle; without it y, or z where the axis is vertical
  NozzleMotionScene motion{};  // of the nozzle, with the direction of the liquid

  bool operator==(const JetScene&) const = default;
};

/// A source of liquid: the faces of a mesh.
struct MeshJetScene {
  PlacedFile placed;                                     // its file; of a sequence, the first
  SequenceScene sequence;                                // of a mesh that moves as its files say
  Keyed<double> speed;                                   // m/s
  std::optional<Vec3> direction;                         // of the liquid; without it along the normals
  NozzleMotionScene motion;                              // of a mesh without a sequence
  double start = 0.0;                                    // s
  double end = std::numeric_limits<double>::infinity();  // s
  double concentration = 0;                              // kg/kg; of its solute

  bool operator==(const MeshJetScene&) const = default;
};

/// A source of liquid: drops that fall from a horizontal rectangle.
struct RainScene {
  Vec3 center{0, 0, 0};                                  // m; of the rectangle
  std::array<double, 2> size{1, 1};                      // m; of the rectangle, in x and z
  double rate = 10;                                      // mm/h: depth of water per time on level ground
  double diameter = 0.002;                               // m; of a drop
  std::optional<Vec3> velocity;                          // m/s; else they fall along gravity at their terminal speed
  double start = 0.0;                                    // s
  double end = std::numeric_limits<double>::infinity();  // s
  double concentration = 0;                              // kg/kg; of its solute

  bool operator==(const RainScene&) const = default;
};

/// A source of liquid: drops that leave a nozzle in all directions of a cone.
struct SprayScene {
  Vec3 center{0, 0, 0};                                  // m; of the nozzle
  Vec3 direction{0, -1, 0};                              // of the cone's axis; its length does not matter
  double half_angle = 30;                                // °; between the axis and the edge of the cone
  double speed = 10;                                     // m/s
  double flow = 1;                                       // L/min
  NozzleMotionScene motion{};                            // of the nozzle, with its axis
  double start = 0.0;                                    // s
  double end = std::numeric_limits<double>::infinity();  // s
  double concentration = 0;                              // kg/kg; of its solute

  bool operator==(const SprayScene&) const = default;
};

/// A region that removes the liquid that enters it.
struct DrainScene {
  enum class Shape { box, sphere, plane };
  Shape shape = Shape::box;  // which decides the members that count
  Box box;
  Vec3 center{0, 0, 0};                                  // m; of a sphere
  double radius = 0.1;                                   // m; of a sphere
  Vec3 point{0, 0, 0};                                   // m; of a plane
  Vec3 normal{0, 1, 0};                                  // of a plane; points to the liquid that stays
  double start = 0.0;                                    // s
  double end = std::numeric_limits<double>::infinity();  // s

  bool operator==(const DrainScene&) const = default;
};

/// Spin of the particles, for turbulence (stages/micropolar.hpp); a scene without the section has none.
struct MicropolarScene {
  bool present = false;      // does the scene have the section?
  double transfer = 1.0e-3;  // ν_t, m²/s
  double inertia = 1.0;      // Θ / d²
  double viscosity = 0.0;    // ζ, m²/s
  double reaction = 0.0;     // a, 1

  bool operator==(const MicropolarScene&) const = default;
};

/// Section `fluid`.
struct FluidScene {
  bool present = false;                   // a scene without the section `fluid` has no liquid particles
  double spacing = 0.01;                  // m; the particle diameter d
  double density = 1000.0;                // kg/m³
  double viscosity = 1.0e-6;              // m²/s
  double surface_tension = 0.0;           // N/m
  KernelKind kernel = KernelKind::cubic;  // of liquid, walls and cloth alike
  double support = 2.0;                   // h / d
  WallPressure wall_pressure = WallPressure::extrapolated;  // at solids
  MicropolarScene micropolar;                               // spins
  FluidSolverScene solver;                                  // tolerances and caps
  std::vector<BlockScene> blocks;                           // sources that are there at the start
  std::vector<JetScene> jets;                               // sources that flow
  std::vector<RainScene> rains;                             // sources that rain
  std::vector<SprayScene> sprays;                           // sources that spray
  std::vector<MeshJetScene> mesh_jets;                      // sources that flow from the faces of a mesh
  std::vector<DrainScene> drains;                           // what removes liquid

  /// Do files prescribe the motion of the liquid?
  bool is_baked() const { return !blocks.empty() && !blocks.front().sequence.files.empty(); }
  bool operator==(const FluidScene&) const = default;
};

}  // namespace drench
