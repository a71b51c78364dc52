#pragma once
// What a scene file says, as plain structs. Every default value of the project stands here and nowhere else.

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "state/types.hpp"

namespace drench {

struct Box {
  Vec3 min{0, 0, 0};  // m
  Vec3 max{0, 0, 0};  // m
};

enum class TimeMode { fixed, cfl };
enum class SortMethod { automatic, counting, radix, bitonic, bitonic_naive };
enum class KernelKind { cubic, wendland, poly6 };
enum class DiffusionLaw { linear, degenerate };
enum class ClothMethod { pd, xpbd };

struct TimeScene {
  double step = 0.004;  // s; the maximum when mode is cfl
  double end = 2.0;     // s
  TimeMode mode = TimeMode::fixed;
  double cfl = 0.4;  // 1; Δt = cfl · d / max|v|
};

struct OutputScene {
  double every = 0.02;            // s; 0 writes no frames
  double checkpoint_every = 0.0;  // s; 0 writes none
  bool measures = false;          // columns of stage measures in stats.csv
  bool surface = false;           // the liquid's surface as a mesh with every frame
  double surface_spacing = 0.5;   // 1; of the lattice that the surface is made on, over the particles'
};

/// What liquid and porous cloth do to each other, each of them to be left out on its own: to see what it is for. A process
/// that is off has no stage. `preset: baseline` at the top of a scene is direction and saturation_control off.
struct ProcessScene {
  bool direction = true;  // Eqs. 4–6 and what looks at them: off, cloth absorbs from and emits to all sides alike
  bool saturation_control = true;  // off: cloth absorbs at a fixed rate, whatever it holds (stages/absorption.hpp)
  bool absorption = true;
  bool emission = true;
  bool diffusion = true;
};

struct FluidSolverScene {
  double density_error = 1e-3;     // 1; mean compression that ends the density solve
  double divergence_error = 1e-3;  // 1; mean compression rate · Δt that ends the divergence solve
  int max_iterations = 100;
  int min_iterations = 2;
  double density_correction = 0.5;  // c, 1; share of a compression that a step takes back (stages/pressure.hpp)
};

struct BlockScene {
  Box box;
  Vec3 velocity{0, 0, 0};  // m/s
};

struct JetScene {
  Vec3 center{0, 0, 0};                                  // m
  double radius = 0.05;                                  // m
  Vec3 velocity{0, 0, 0};                                // m/s; the nozzle's axis
  double start = 0.0;                                    // s
  double end = std::numeric_limits<double>::infinity();  // s
};

/// Spin of the particles, for turbulence (stages/micropolar.hpp); a scene without the section has none.
struct MicropolarScene {
  bool present = false;
  double transfer = 1.0e-3;  // ν_t, m²/s
  double inertia = 1.0;      // Θ / d²
  double viscosity = 0.0;    // ζ, m²/s
  double reaction = 0.0;     // a, 1
};

struct FluidScene {
  bool present = false;          // a scene without the section `fluid` has no liquid particles
  double spacing = 0.01;         // m; the particle diameter d
  double density = 1000.0;       // kg/m³
  double viscosity = 1.0e-6;     // m²/s
  double surface_tension = 0.0;  // N/m
  KernelKind kernel = KernelKind::cubic;
  double support = 2.0;  // h / d
  MicropolarScene micropolar;
  FluidSolverScene solver;
  std::vector<BlockScene> blocks;
  std::vector<JetScene> jets;
};

struct GridScene {
  std::array<double, 2> size{1, 1};  // m; spanned in x and z, centred on the origin
  std::array<int, 2> nodes{31, 31};
};

struct SpinScene {
  Vec3 axis{0, 1, 0};
  double degrees_per_second = 0.0;
};

struct PinScene {
  enum class Kind { corners, edges, box, nodes } kind = Kind::corners;
  Box box;                   // for Kind::box, after placing
  std::vector<Index> nodes;  // for Kind::nodes, numbered within this cloth
  // Prescribed motion from `start` to `end`; before and after it the pins stand still.
  Vec3 velocity{0, 0, 0};  // m/s
  SpinScene spin;
  Vec3 center{0, 0, 0};                                  // m; what the pins turn about, moves with `velocity`
  double start = 0.0;                                    // s
  double end = std::numeric_limits<double>::infinity();  // s
};

/// Do these pins move?
inline bool moves(const PinScene& pin) { return pin.velocity != Vec3{0, 0, 0} || pin.spin.degrees_per_second != 0; }

struct SaturationScene {
  Box box;
  double value = 0;  // 1
};

struct PorousScene {
  bool present = false;
  double solid_fraction = 0.4;     // Φ, 1
  double absorption = 0.01;        // k_a, m²/s
  double uptake_velocity = 0.0;    // u_a, m/s; > 0 replaces `absorption` by k_a = u_a h² / (7.5 (1−Φ) τ)
  double max_saturation = 1.18;    // s_max, 1
  double virtual_pressure = 16.8;  // k^p, m/s²
  double emission_angle = 80.0;    // θ^e, degrees
  double emission_velocity = 0.5;  // u_e, m/s; how fast excess ripens for emission: rate u_e / d
  double emission_ramp = 0.02;     // s; over which a fresh particle's pressure and speed are ramped in
  double diffusivity = 1.0e-4;     // D, m²/s
  DiffusionLaw diffusion = DiffusionLaw::linear;
  double capillary_height = 1.0;  // ℓ, m
  double adhesion = 0.0;  // N/m; work per area that parts wet fabric from wet fabric or a solid; 0.14 with water at most
  bool contact_wicking = false;  // liquid passes between layers that touch and both have this
};

struct ClothScene {
  std::string name = "cloth";
  std::optional<GridScene> grid;
  std::string file;        // a mesh file (.obj, .ply, .stl) when `grid` is absent
  double scale = 1.0;      // 1; of the mesh file
  Vec3 position{0, 0, 0};  // m
  Vec3 rotate_axis{1, 0, 0};
  double rotate_degrees = 0.0;
  double areal_density = 0.2;  // kg/m²
  double thickness = 0.001;    // m
  double stretch = 500.0;      // N/m; membrane stiffness (Young's modulus × thickness)
  double bend = 1.0e-4;        // N·m; flexural rigidity
  double damping = 1.0;        // 1/s, of the nodes' velocity
  double strain_damping = 0;   // s: a spring's force grows by this time × its rate of stretching (Kelvin–Voigt)
  double friction = 0.3;       // 1; dry fabric on solids 0.3–0.5
  // At saturation 1, between dry and there linear; as when dry where they are not given.
  std::optional<double> friction_wet;  // 1; wet fabric 0.9–1.3
  std::optional<double> damping_wet;   // 1/s
  double strain_limit = 0;             // ε, 1: triangles keep their stretches within [1 − ε, 1 + ε]; 0: no limit
  double adhesion = 0;                 // N/m; work per area that separates the liquid from the cloth
  // m: between the samples that liquid meets, at rest, at most; fluid.spacing where it is not given.
  std::optional<double> sample_spacing;
  std::vector<PinScene> pins;
  bool self_collision = false;
  bool dynamics = true;
  std::vector<SaturationScene> initial_saturation;
  std::vector<SaturationScene> hold_saturation;
  PorousScene porous;
};

/// How the cloth's implicit step is solved (stages/cloth.hpp). It stands at the top of a scene: one solve serves all of
/// its cloths, and its tolerance is one on the sum over their nodes.
struct ClothSolverScene {
  ClothMethod method = ClothMethod::pd;
  double tolerance = 1e-3;   // 1; unbalanced forces over the forces that move the cloth
  int max_iterations = 300;  // in stage cloth
};

struct BodyScene {
  enum class Kind { box, sphere, plane, mesh } kind = Kind::box;
  Box box;
  bool inside = false;   // a box that is a container: its inside is free
  Vec3 center{0, 0, 0};  // sphere
  double radius = 0.1;   // m, sphere
  Vec3 point{0, 0, 0};   // plane
  Vec3 normal{0, 1, 0};  // plane; points to the free side
  std::string file;      // mesh
  double scale = 1.0;
  Vec3 position{0, 0, 0};  // m, added to the scaled mesh
  // Prescribed motion, without end; of a dynamic body, how it starts.
  Vec3 velocity{0, 0, 0};  // m/s
  SpinScene spin;          // about the centre: of the box, the sphere or the mesh's bounding box; a plane's point
  bool dynamic = false;    // sphere and box (not inside): floats and sinks, pushed by the liquid and by gravity
  double density = 500.0;  // kg/m³, of a dynamic body
  double adhesion = 0;     // N/m; work per area that separates the liquid from the body
};

/// An acceleration of the liquid towards a centre: −Ω_k² (x − c)_k along each axis k.
struct FieldScene {
  bool present = false;
  Vec3 center{0, 0, 0};  // c, m
  Vec3 rate{0, 0, 0};    // Ω, 1/s
};

struct Scene {
  std::string path;  // the file that it came from, "" when built in memory
  int version = 1;
  TimeScene time;
  Vec3 gravity{0, -9.81, 0};  // m/s²
  FieldScene field;
  Box domain{{-10, -10, -10}, {10, 10, 10}};  // m
  OutputScene output;
  ProcessScene processes;
  SortMethod sort = SortMethod::automatic;
  bool through_cloth = false;  // true: liquid feels liquid on the other side of a cloth (stages/neighbors.hpp)
  FluidScene fluid;
  ClothSolverScene cloth_solver;
  std::vector<ClothScene> cloths;
  std::vector<BodyScene> bodies;
};

}  // namespace drench
