#pragma once
// The content of a scene file as plain structs. All defaults of the project stand here, in scene/liquid.hpp and
// in scene/material.hpp.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "base/keyed.hpp"
#include "base/types.hpp"
#include "scene/liquid.hpp"
#include "scene/material.hpp"
#include "scene/motion.hpp"

namespace drench {

/// Fixed steps, or steps as long as the CFL number or the density's error allows.
enum class TimeMode { fixed, cfl, error };
/// The sort of the neighbour search. It changes the speed and no bit of the results.
enum class SortMethod { automatic, counting, radix, bitonic, bitonic_naive };
/// Projective Dynamics, or XPBD on the same step.
enum class ClothMethod { pd, xpbd };

/// Section `time`.
struct TimeScene {
  double step = 0.004;              // s; the maximum when mode is cfl
  double end = 2.0;                 // s
  TimeMode mode = TimeMode::fixed;  // how the length of a step is chosen
  double cfl = 0.4;                 // 1; Δt = cfl · d / max|v|
  double tolerance = 1e-3;          // 1; of mode error: mean of max(0, δ − 1) that a step leaves

  bool operator==(const TimeScene&) const = default;
};

/// The particles' shapes in the liquid's field that the surface is a level of (output/liquid_kernels.hpp).
enum class SurfaceKernel { isotropic, anisotropic };

/// Section `output`.
/// An entry of `output.probes`: columns of probes.csv.
struct ProbeScene {
  enum class Kind { point, line, disc, body, cloth };
  std::string name;
  Kind kind = Kind::point;  // which members count
  Vec3 position{0, 0, 0};   // m: of a point, or the first end of a line, or the centre of a disc
  Vec3 end{0, 0, 0};        // m: the other end of a line
  Vec3 normal{0, 1, 0};     // disc: flux along it is positive
  double radius = 0;        // m: of a disc, or of a sensor around a point
  std::string of;           // name of a body or a cloth

  bool operator==(const ProbeScene&) const = default;
};

struct OutputScene {
  std::vector<ProbeScene> probes;     // columns of probes.csv
  std::optional<double> probe_every;  // s; else as `every`
  double every = 0.02;                // s; 0 writes no frames
  double checkpoint_every = 0.0;      // s; 0 writes none
  bool measures = false;              // columns of stage measures in stats.csv
  bool fabric = false;                // columns of stage fabric in stats.csv
  double wet_above = 0.05;            // 1: the saturation from which on fabric counts as wet
  bool surface = false;               // the liquid's surface as a mesh with every frame
  double surface_spacing = 0.5;       // 1; of the lattice that the surface is made on, over the particles'
  SurfaceKernel surface_kernel = SurfaceKernel::anisotropic;  // a particle's shape
  bool fitted_pressure = false;                               // field fitted_pressure with every frame
  bool report = false;  // report.html at the end of the run, also of one that fails

  bool operator==(const OutputScene&) const = default;
};

/// The processes between liquid and porous cloth. Each can be left out on its own, to see its effect: then it has no
/// stage. `preset: baseline` at the top of a scene is direction and saturation_control off.
struct ProcessScene {
  bool direction = true;  // Eqs. 4–6 and what looks at them: off, cloth absorbs from and emits to all sides alike
  bool saturation_control = true;  // off: cloth absorbs at a fixed rate, whatever it holds (stages/absorption.hpp)
  bool absorption = true;          // cloth takes up liquid
  bool emission = true;            // cloth gives excess liquid back
  bool diffusion = true;           // liquid spreads within cloth

  bool operator==(const ProcessScene&) const = default;
};

/// A rectangular cloth, in place of a mesh file.
struct GridScene {
  std::array<double, 2> size{1, 1};  // m; spanned in x and z, centred on the origin
  std::array<int, 2> nodes{31, 31};  // along these sides

  bool operator==(const GridScene&) const = default;
};

/// An entry of `cloth.N.pin`: nodes that stand still or move as prescribed, or that springs hold there.
struct PinScene {
  /// How the nodes are chosen.
  enum class Kind { corners, edges, box, nodes };
  Kind kind = Kind::corners;  // how the nodes are chosen
  Box box;                    // for Kind::box, after placing
  std::vector<Index> nodes;   // for Kind::nodes, numbered within this cloth
  // Prescribed motion from `start` to `end`; before and after it the pins stand still.
  Keyed<Vec3> velocity;    // m/s
  Keyed<Vec3> offset;      // m; added to where `velocity` brings them; 0 at `start`
  SequenceScene sequence;  // of the cloth's mesh, in place of `velocity`, `offset`, `spin`
  SpinScene spin;          // about `center`
  Vec3 center{0, 0, 0};    // m; what the pins turn about, moves with them
  std::string body;        // the name of a body that they follow, instead of all these; empty: none
  double start = 0.0;      // s
  double end = std::numeric_limits<double>::infinity();      // s
  std::optional<double> stiffness;                           // N/m, of all its nodes together; none: rigid
  double release = std::numeric_limits<double>::infinity();  // s; from then on springs hold nothing

  bool operator==(const PinScene&) const = default;
};

/// Do these pins move?
inline bool moves(const PinScene& pin) {
  return !pin.body.empty() || !pin.velocity.is_zero() || !pin.offset.is_zero() || !pin.sequence.files.empty() ||
         !pin.spin.degrees_per_second.is_zero();
}

/// An entry of `initial_saturation` or `hold_saturation`.
struct SaturationScene {
  Box box;                   // of the nodes, after placing
  double value = 0;          // 1
  double concentration = 0;  // kg/kg; of the solute in its liquid

  bool operator==(const SaturationScene&) const = default;
};

/// An entry of `initial_stain`.
struct StainScene {
  Box box;           // of the nodes, after placing
  double value = 0;  // kg/m²

  bool operator==(const StainScene&) const = default;
};

/// Diffusion within the fabric: at the rate D, or at D s (sharp wet fronts).
enum class DiffusionLaw { linear, degenerate };

/// Of woven or knitted cloth, per triangle (docs/theory/cloth.md, section 2); takes the place of
/// MaterialScene::stretch.
struct MembraneScene {
  double warp = 0, weft = 0, shear = 0;       // k_u, k_v, k_s, N/m
  double wet = 1;                             // 1; factor on all three at saturation 1, linear in between
  double warp_locking = 0, weft_locking = 0;  // e_L of both, 1: strains at which yarns lock; 0: never

  bool operator==(const MembraneScene&) const = default;
};

/// A thin plate on any mesh (docs/theory/cloth.md, section 3); takes the place of MaterialScene::bend.
struct PlateScene {
  double warp = 0, weft = 0, twist = 0;  // B_u, B_v, B_t, N·m

  bool operator==(const PlateScene&) const = default;
};

/// A fabric as a scene has it. The numbers below are replaced when the scene is set up (setup/cloth_material.hpp).
struct MaterialScene : BasicMaterial<double> {
  double areal_density = 0.2;  // kg/m²
  double stretch = 500.0;      // N/m; membrane stiffness (Young's modulus × thickness)
  double bend = 1.0e-4;        // N·m; flexural rigidity
  std::optional<MembraneScene> membrane;
  std::optional<PlateScene> bending;
  bool has_warp = false;  // is `warp` given? Else the warp is texture v, or a grid's z
  Vec3 warp{0, 0, 1};     // its direction in the mesh's own axes; its length does not matter
  // At saturation 1, between dry and there linear; as when dry where they are not given.
  std::optional<double> friction_wet;  // 1; wet fabric 0.9–1.3
  std::optional<double> damping_wet;   // 1/s
  double uptake_velocity = 0.0;        // u_a, m/s; > 0 replaces `absorption` by k_a = u_a h² / (7.5 (1−Φ) τ)
  double emission_angle = 80.0;        // θ^e, degrees
  DiffusionLaw diffusion = DiffusionLaw::linear;
  std::optional<double> diffusion_exponent;  // n, 1: in place of `diffusion`, at the rate D sⁿ
  std::optional<double> weft_diffusivity;    // m²/s; then `diffusivity` is that along the warp

  /// n, 1.
  double exponent() const { return diffusion_exponent.value_or(diffusion == DiffusionLaw::degenerate ? 1 : 0); }
  bool operator==(const MaterialScene&) const = default;
};

/// An entry of `cloth.N.regions`: a part of the cloth whose fabric differs.
struct RegionScene {
  /// How its triangles are chosen.
  enum class Kind { group, box, attribute };
  Kind kind = Kind::group;  // how its triangles are chosen
  std::string group;        // for Kind::group: a name of the mesh file
  std::string attribute;    // for Kind::attribute: of the mesh file's points, how much of the region they are, 0 to 1
  Box box;                  // for Kind::box: of the triangles' middles, after placing
  MaterialScene material;   // the cloth's, with the keys that this entry has

  bool operator==(const RegionScene&) const = default;
};

/// Of `cloth.N.weld`: sews boundary points that coincide, up to a small part of their edges.
inline constexpr double weld_automatically = -1;
/// Of `cloth.N.clean`: removes triangles that are lower than a hundredth of the mesh's mean edge.
inline constexpr double clean_automatically = -1;

/// An entry of `cloth.N.sew`: nodes that stitches pull together.
struct SewScene {
  /// How the nodes are chosen.
  enum class Kind { loops, groups, pairs, file };
  Kind kind = Kind::loops;                  // how the nodes are chosen
  std::vector<std::array<Index, 2>> loops;  // for Kind::loops: boundary loops of the cloth, by their numbers
  std::array<std::string, 2> groups{};      // for Kind::groups: names of the mesh file
  std::vector<std::array<Index, 2>> pairs;  // for Kind::pairs: points, by their numbers in the mesh file
  std::string file;                         // for Kind::file: such pairs, one a line

  bool operator==(const SewScene&) const = default;
};

/// An entry of `cloth`.
struct ClothScene {
  std::string name = "cloth";            // in messages and frames; no two alike
  std::optional<GridScene> grid;         // its shape, or else `file`
  std::string file;                      // a mesh file (.obj, .ply, .stl) when `grid` is absent
  double scale = 1.0;                    // 1; of the mesh file
  LengthUnit unit = LengthUnit::m;       // of the mesh file
  UpAxis up = UpAxis::y;                 // of the mesh file
  double clean = clean_automatically;    // m: height below which triangles of the mesh file are removed; 0: none
  double weld = weld_automatically;      // m: how far apart boundary points are that become one; 0: none
  Vec3 position{0, 0, 0};                // m
  Vec3 rotate_axis{1, 0, 0};             // it is turned first, about its mesh's origin, then moved
  double rotate_degrees = 0.0;           // °
  MaterialScene material;                // the fabric
  std::vector<RegionScene> regions;      // parts of another fabric; where two hold a triangle, the last one counts
  double slip = 0;                       // m; slip length b of the liquid on both sides, 0: none, inf: free
  std::optional<double> sample_spacing;  // m; at most, between the samples that liquid meets; else fluid.spacing
  std::vector<PinScene> pins;            // where two catch a node, the last one counts
  std::vector<SewScene> sew;             // seams that are closed during the run
  double sew_time = 0.5;                 // s; until they are closed
  bool self_collision = false;           // with itself and with other cloths that have this
  int settle = 50;         // steps of length time.step over which nodes that start inside a body come out of it
  bool dynamics = true;    // false: it does not move
  Vec3 velocity{0, 0, 0};  // m/s; of its nodes that are not pinned, at the start
  std::vector<SaturationScene> initial_saturation;  // at the start; 0 elsewhere
  std::vector<SaturationScene> hold_saturation;     // reservoirs
  std::vector<StainScene> initial_stain;            // solute that is dry on it at the start; 0 elsewhere

  bool operator==(const ClothScene&) const = default;
};

/// Is there a fabric in the cloth, its own or a region's, that it is true of?
template <class Predicate>
bool any_fabric(const ClothScene& cloth, Predicate predicate) {
  return predicate(cloth.material) || std::any_of(cloth.regions.begin(), cloth.regions.end(),
                                                  [&](const RegionScene& r) { return predicate(r.material); });
}

/// How the cloth's implicit step is solved (stages/cloth.hpp). It stands at the top of a scene: one solve serves all of
/// its cloths, and its tolerance is one on the sum over their nodes.
struct ClothSolverScene {
  ClothMethod method = ClothMethod::pd;  // the same step, solved in another way
  double tolerance = 1e-3;               // 1; unbalanced forces over the forces that move the cloth
  int max_iterations = 1000;             // in stage cloth

  bool operator==(const ClothSolverScene&) const = default;
};

/// An entry of `bodies`.
struct BodyScene {
  std::string name;  // empty: none; in programs and messages
  /// Its shape.
  enum class Kind { box, sphere, plane, mesh };
  Kind kind = Kind::box;            // its shape, which decides the members that count
  Box box;                          // box
  bool inside = false;              // a box that is a container: its inside is free
  Vec3 center{0, 0, 0};             // sphere
  double radius = 0.1;              // m, sphere
  Vec3 point{0, 0, 0};              // plane
  Vec3 normal{0, 1, 0};             // plane; points to the free side
  std::string file;                 // mesh; of a sequence, its first
  SequenceScene sequence;           // mesh that moves as its files say
  double scale = 1.0;               // 1, of the mesh file
  LengthUnit unit = LengthUnit::m;  // of the mesh file
  UpAxis up = UpAxis::y;            // of the mesh file
  Vec3 position{0, 0, 0};           // m, added to the scaled mesh
  Vec3 stretch{1, 1, 1};            // 1, along the axes, before the rotation
  Vec3 place{0, 0, 0};              // m, added to that
  Vec3 rotate_axis{1, 0, 0};        // a mesh is turned first, about its file's origin, then moved
  double rotate_degrees = 0.0;      // °
  // Prescribed motion, without end; of a dynamic body, how it starts.
  Keyed<Vec3> velocity;        // m/s
  Keyed<Vec3> offset;          // m; added to where `velocity` brings it; 0 at the start
  SpinScene spin;              // about the centre: of the box, the sphere or the mesh's bounding box; a plane's point
  bool commanded = false;      // a program moves it; stands still until then
  bool dynamic = false;        // floats and sinks, pushed by the liquid, cloth, gravity and other bodies
  double density = 500.0;      // kg/m³, of a dynamic body
  std::optional<double> mass;  // kg, of a dynamic body; replaces the density
  double friction = 0.5;       // μ, against other bodies
  double restitution = 0;      // 1, against other bodies
  double adhesion = 0;         // N/m; work per area that separates the liquid from the body
  double slip = 0;             // m; slip length b, 0: none, inf: free

  bool operator==(const BodyScene&) const = default;
};

/// A motor of a hinge.
struct MotorScene {
  bool present = false;                   // does the joint have the section?
  Keyed<double> degrees_per_second{0.0};  // °/s, of the body relative to the other
  double torque = 0;                      // N·m; at most

  bool operator==(const MotorScene&) const = default;
};

/// An entry of `joints`: a hinge between a dynamic body and another body or the world.
struct JointScene {
  std::string body;                         // its name
  std::string to;                           // the other body's name; empty: the world
  Vec3 point{0, 0, 0};                      // m; on the axis, at the start
  Vec3 axis{0, 1, 0};                       // at the start
  std::array<double, 2> limits{-180, 180};  // °; of the angle since the start; these: none
  MotorScene motor;

  bool operator==(const JointScene&) const = default;
};

/// An acceleration of the liquid towards a centre: −Ω_k² (x − c)_k along each axis k.
struct FieldScene {
  bool present = false;  // does the scene have the section?
  Vec3 center{0, 0, 0};  // c, m
  Vec3 rate{0, 0, 0};    // Ω, 1/s

  bool operator==(const FieldScene&) const = default;
};

/// An entry of `wind.gusts`: what is added to the air's velocity at a time.
struct GustScene {
  double time = 0;         // s
  Vec3 velocity{0, 0, 0};  // m/s

  bool operator==(const GustScene&) const = default;
};

/// Moving air (stages/wind.hpp).
struct WindScene {
  bool present = false;           // does the scene have the section?
  Keyed<Vec3> velocity;           // m/s; of undisturbed air
  std::vector<GustScene> gusts;   // linear in between, the first before them and the last after them
  double density = 1.2;           // ρ_a, kg/m³
  double normal_drag = 1.17;      // C_n, 1; of both sides of the cloth together
  double tangential_drag = 0.02;  // C_t, 1; likewise
  double liquid_drag = 0;         // C_l, 1; of free drops; 0: none

  /// Does it act on anything in a scene with moving cloth, or with liquid?
  bool blows(bool cloth, bool fluid) const { return present && (cloth || (fluid && liquid_drag > 0)); }
  /// Eq. 1: the velocity of undisturbed air at a time (s), m/s.
  Vec3 at(double time) const;
  /// The fastest that the air ever is, m/s; with keys and gusts, no more than this.
  double fastest() const;

  bool operator==(const WindScene&) const = default;
};

/// A frame that rotates about a fixed axis, in which everything is described (stages/rotating_frame.hpp).
struct RotatingFrameScene {
  bool present = false;                   // does the scene have the section?
  Vec3 axis{0, 1, 0};                     // 1; its length does not matter
  Vec3 center{0, 0, 0};                   // m; a point of the axis
  Keyed<double> degrees_per_second{0.0};  // °/s; of the frame, by the right-hand rule

  /// Does it act on anything in a scene with moving cloth, or with liquid?
  bool acts(bool cloth, bool fluid) const { return present && (cloth || fluid); }
  /// The speed in the frame of what stands still outside it, at the farthest corner of the domain, m/s.
  double fastest(const Box& domain) const {
    double square = 0;
    for (std::size_t a = 0; a < 3; ++a)
      square += std::pow(std::max(std::abs(domain.min[a] - center[a]), std::abs(domain.max[a] - center[a])), 2);
    return degrees_per_second.largest() * std::numbers::pi / 180 * std::sqrt(square);
  }

  bool operator==(const RotatingFrameScene&) const = default;
};

/// Section `air`: what liquid evaporates into (docs/theory/evaporation.md).
struct AirScene {
  bool present = false;                        // does the scene have the section?
  double humidity = 0.5;                       // RH, 1
  double temperature = 20;                     // °C; of the air, and of what is wet unless that cools
  double speed = 0;                            // m/s; along what is wet
  double length = 0.3;                         // m; of what is wet, along the air
  std::optional<double> transfer_coefficient;  // h_m, m/s; in place of speed and length
  std::optional<double> evaporation_rate;      // j, kg/(m² s); in place of all the others
  bool cooling = false;                        // do wet cloths cool as they dry?

  bool operator==(const AirScene&) const = default;
};

/// A number that a named fabric supplied (scene/fabrics.hpp).
struct FabricOrigin {
  std::string key;    // dotted, from the scene: cloth.0.porous.diffusivity
  double value = 0;   // in the unit of the key
  std::string basis;  // how it is known: "fabric cotton_interlock, assumed: of sock_nylon"
};

/// Comments of the resolved scene. They compute nothing, so all are equal.
struct FabricOrigins {
  std::vector<FabricOrigin> values;  // of all cloths and their regions

  bool operator==(const FabricOrigins&) const { return true; }
};

/// A whole scene. Mesh files are absolute paths, all other values as in the file.
struct Scene {
  std::string path;                           // the file that it came from, "" when built in memory
  int version = 1;                            // of the format
  TimeScene time;                             // how time goes on
  Vec3 gravity{0, -9.81, 0};                  // m/s²
  FieldScene field;                           // draws liquid to a centre
  WindScene wind;                             // drags at cloth and liquid
  RotatingFrameScene rotating_frame;          // in which the scene is described
  AirScene air;                               // takes up vapour
  Box domain{{-10, -10, -10}, {10, 10, 10}};  // m
  OutputScene output;                         // files and their times
  ProcessScene processes;                     // of porous cloth
  SortMethod sort = SortMethod::automatic;    // of the neighbour search
  bool through_cloth = false;      // true: liquid feels liquid on the other side of a cloth (stages/neighbors.hpp)
  FluidScene fluid;                // the liquid
  ClothSolverScene cloth_solver;   // one for all cloths
  std::vector<ClothScene> cloths;  // each with its own mesh and fabric
  std::vector<BodyScene> bodies;   // containers and obstacles
  std::vector<JointScene> joints;  // of dynamic bodies
  FabricOrigins origins;           // of the cloths' numbers

  bool operator==(const Scene&) const = default;
};

}  // namespace drench
