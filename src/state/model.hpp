#pragma once
// The constant part of a run: numbers, materials, meshes and bodies, resolved from the scene.
// HostState (host_state.hpp) holds what changes. Both are plain host data without Kokkos.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "state/body.hpp"

namespace drench {

/// Per-node lists in compressed form: entries of node n are [start[n], start[n+1]).
struct Rows {
  std::vector<Index> start;  // rows + 1
  std::vector<Index> item;
  Index rows() const { return start.empty() ? 0 : static_cast<Index>(start.size()) - 1; }
};

/// One cloth: its material, and which nodes, triangles and samples of the model are its own.
struct ClothMaterial : ResolvedMaterial<double> {
  std::string name;
  double slip = 0;                   // b, m; inf: free
  double areal_density = 0;          // kg/m²
  double uptake_velocity = 0;        // u_a, m/s; 0: `absorption` is as the scene gives it
  double most_saturation = 0;        // 1: the largest max_saturation of the cloth and its regions
  Index of_cloth = -1, region = -1;  // of Model::patches: the cloth, and its region (−1: of nodes between them)
  int level = 0;                     // of painted regions: how much of the region it is, in setup/mesh_io.hpp's levels
  std::array<Vec3, 2> rest_plane{};  // of stages measures and fabric: two unit vectors at right angles; 0 without them
  Vec3 rest_center{0, 0, 0};         // m
  Index first_node = 0, node_count = 0;
  Index first_triangle = 0, triangle_count = 0;
  Index first_sample = 0, sample_count = 0;

  /// The largest saturation of its pores, 1: what is beyond runs as a film where there is one.
  double pore_saturation() const { return film_depth > 0 ? 1 : most_saturation; }
};

/// Of a triangle of woven or knitted cloth: warp = cosine · (first axis) + sine · (second axis) of its frame, k A of
/// the stretches along warp and weft and of shear, N·m, the factor on these at saturation 1, and the strains at which
/// yarns lock. All 0 in other cloths.
template <class Number>
struct Membrane {
  Number cosine, sine;
  Number warp, weft, shear;
  Number wet;
  Number warp_locking, weft_locking;  // e_L, 1; 0: never
};

/// Beyond this strain over that at the start of the step, 1, and beyond this part of the locking strain, where it is
/// 20 times as stiff, a yarn pulls along its tangent, so that one matrix bounds the whole step.
inline constexpr double locking_margin = 0.02, locking_part = 0.84;

/// All cloths' meshes, concatenated; indices are global. Built once from the rest shape.
struct ClothMesh {
  // nodes
  std::vector<Vec3> rest_position;   // m, after placing
  std::vector<double> solid_mass;    // m_s, kg: areal density × a third of the adjacent triangles
  std::vector<std::uint8_t> pinned;  // 1: does not move (also every node of a cloth without dynamics)
  std::vector<Index> node_cloth;     // index into Model::cloths
  std::vector<Index> node_material;  // of Model::material(); empty unless a cloth has regions
  // triangles
  std::vector<std::array<Index, 3>> triangle;
  std::vector<Index> triangle_cloth;
  std::vector<Index> triangle_material;             // of Model::material(); empty unless a cloth has regions
  std::vector<Vec3> triangle_warp;                  // unit, in its plane; 0 in cloth without; empty unless one has it
  std::vector<std::array<Index, 3>> boundary_edge;  // of one triangle alone: nodes, and its third; empty unless needed
  // edge springs, i < j
  std::vector<std::array<Index, 2>> edge;
  std::vector<double> edge_length;     // m, rest
  std::vector<double> edge_stiffness;  // N/m: stretch · (A0 + A1) / length² (Van Gelder 1998); 0 in membranes
  // stitches of seams (`sew`), i < j: springs whose rest length falls from stitch_length to 0 at stitch_time
  // (state/stitch.hpp)
  std::vector<std::array<Index, 2>> stitch;
  std::vector<double> stitch_length;     // m, at t = 0
  std::vector<double> stitch_stiffness;  // N/m
  std::vector<double> stitch_time;       // s
  std::vector<Index> joint;              // per node: the lowest of the nodes that it is sewn to; empty: no stitches
  // hinges: nodes 0 1 on the shared edge, 2 3 opposite; of grids, differences along lines and twists of cells
  std::vector<std::array<Index, 4>> hinge;
  std::vector<std::array<double, 4>> hinge_weight;  // K, 1/m·m = 1: cotangent vector, ΣK = 0 (Bergou 2006)
  std::vector<double> hinge_stiffness;              // bend / (A0 + A1), N/m (setup/cloth_mesh.cpp says why)
  // bending of plates: pairs n < m and B_nm, N/m (setup/plate.hpp); empty unless a cloth has it
  std::vector<std::array<Index, 2>> plate_pair;
  std::vector<double> plate_weight;
  // strain limiting and membranes; empty unless a cloth has one of them
  std::vector<std::array<double, 3>> triangle_shape;  // per triangle: R⁻¹ of its edges Q R at rest (xx, xy, yy), 1/m
  std::vector<double> limit_stiffness;                // per triangle: w A, N·m; 0 in cloths without; empty: no limit
  std::vector<Membrane<double>> membrane;             // per triangle; empty: no membrane
  Rows node_triangles;                                // node → items 4·triangle + corner
  std::vector<Index> pin_motion;  // per node: index into Model::pin_motions, −1 if it has none; empty if no pin moves
  std::vector<double> pin_stiffness;  // per node, N/m: of soft pins, whose nodes are not `pinned`; empty without them
  std::vector<Index> pin_entry;       // per node: which of its cloth's `pin` entries holds it, −1: none
  std::vector<std::uint8_t> baked;    // 1: of absorbent cloth, pinned to a sequence of files
  // node → constraint rows; an item is edge id (stitches follow the edges), or 4·hinge + corner
  Rows node_edges;
  Rows node_hinges;

  Index nodes() const { return static_cast<Index>(rest_position.size()); }
  /// The stiffness by which a soft pin holds a node, N/m; 0 if none does.
  double soft_pin(Index n) const {
    const auto k = static_cast<std::size_t>(n);
    return pin_stiffness.empty() || pinned[k] || pin_motion[k] < 0 ? 0 : pin_stiffness[k];
  }
  /// Has the node no velocity but its pin's? Of baked cloth only the cloth's own stages hold the nodes
  /// (docs/theory/cloth.md, section 7).
  bool is_fixed(Index n) const {
    const auto k = static_cast<std::size_t>(n);
    return pinned[k] && (k >= baked.size() || !baked[k]);
  }
  Index triangles() const { return static_cast<Index>(triangle.size()); }
  /// The node that stands for all that this one is sewn to.
  Index joint_of(Index n) const { return joint.empty() ? n : joint[static_cast<std::size_t>(n)]; }
};

/// Prescribed motion of pins, rigid or soft: X(t) = C + o + ∫v + p(s) + Rot(axis, ∫rate) R (X0 − C),
/// from start to s = min(max(t, start), end). What they did before a program gave them another velocity stands in o and
/// R. Pins that follow a body have X(t) = c_b + w_b(t) + Q_b(t) (X0 − C) instead, with the centre, the way and the turn
/// of the body.
struct PinMotion {
  Keyed<Vec3> velocity;                                             // v, m/s
  Vec3 axis{0, 1, 0};                                               // unit
  Keyed<double> rate;                                               // rad/s
  Vec3 center{0, 0, 0};                                             // C, m
  double start = 0, end = std::numeric_limits<double>::infinity();  // s
  Vec3 offset{0, 0, 0};                                             // o, m
  Quaternion rotated{1, 0, 0, 0};                                   // R
  Keyed<Vec3> path;                                                 // p, m; 0 at `start`
  double reach = 0;                                                 // m: the farthest of its nodes from C at rest
  Index body = -1;                                                  // b, of Model::bodies; −1: follows none
  double release = std::numeric_limits<double>::infinity();         // s; from then on springs hold nothing

  /// Do springs hold its nodes in a step?
  bool holds(double time, double dt) const { return time + 0.5 * dt < release; }
  bool has_keys() const { return velocity.has_keys() || rate.has_keys() || path.has_keys(); }
};

/// A hinge of a dynamic body.
struct Joint {
  Index body = 0, other = -1;  // of Model::bodies; −1: the world
  Vec3 point{0, 0, 0};         // m; on the axis at the start
  Vec3 axis{0, 1, 0};          // unit
  bool limited = false;        // is there a least and a largest angle?
  double low = 0, high = 0;    // rad, since the start
  Keyed<double> speed{0.0};    // rad/s: that the motor holds, of `body` relative to the other
  double torque = 0;           // N·m: the most of the motor; 0: none
};

/// Samples of the cloths: boundary particles for the liquid (all cloths), porous particles (porous cloths).
struct SampleSet {
  std::vector<Index> triangle;                // the triangle that carries the sample
  std::vector<std::array<double, 3>> weight;  // barycentric weights w_pn, Σ = 1, in the triangle's node order
  std::vector<Index> cloth;                   // index into Model::cloths
  std::vector<Index> material;                // of Model::material(); empty unless a cloth has regions
  std::vector<double> area;                   // a_p, m²: rest-area share; sums to the mesh's area
  std::vector<double> capacity;               // C_p = (1−Φ) a_p τ ρ0, kg; 0 for a cloth that is not porous
  std::vector<Vec3> rest_position;            // m
  Rows node_samples;                          // node → items 4·sample + corner (0..2)
  std::vector<double> node_capacity;          // C_n = Σ_p w_pn C_p, kg
  std::vector<double> node_weight_sum;        // w′_n = Σ_p w_pn
  // Per sample two boundary edges of its cloth within 2 d at rest: the nearest, and the nearest that goes another way
  // (the cosine between them is below 0.9); −1: none. Empty where no cloth parts liquid or none has a boundary.
  std::vector<std::array<Index, 2>> boundary_edges;
  double spacing = 0;       // m: √ of the largest area share
  double cover_radius = 0;  // m: no point of a triangle is farther from that triangle's nearest sample
  Index count() const { return static_cast<Index>(triangle.size()); }
};

/// Pairs of nodes that pass liquid on within a fabric (stages/diffusion.hpp): of the porous cloths with a diffusivity.
struct FabricPairs {
  std::vector<std::array<Index, 2>> nodes;  // lower, higher
  // ω_ij = ½ (cot α + cot β) > 0, 1: edges of the intrinsic Delaunay mesh at rest, stretched where D has two
  // directions; each side times what its region conducts over what the cloth itself does
  std::vector<double> weight;
  std::vector<double> rest_square;  // m²: distance² of its nodes at rest, 0 of stitches; empty unless pores narrow
  // the same of a film on the faces, whatever the region conducts; empty without films
  std::vector<double> film;
  // per node: at the boundary of its cloth, where a film that runs down has to drip; empty without films
  std::vector<std::uint8_t> hem;
  Rows of_node;  // node → items 2·pair + side
};

/// The mouth of an emitter that moves, sprays or is a mesh: each particle leaves at a time of its own, from where the
/// mouth is then (state/nozzle.hpp). Meshes of a sequence have an entry per file of what changes, others one.
struct Mouth {
  PinMotion motion;                       // of a mouth that moves as a whole; `center` as Jet::scene has it, or its own
  std::vector<std::vector<Vec3>> points;  // m: of each file; empty: Jet::offsets, as a whole
  std::vector<std::vector<Vec3>> directions;  // unit: of the liquid of each point; empty: along the jet's axis
  std::vector<std::vector<double>> flow;      // 1: running sums of what the points emit; empty: all the same
  std::vector<double> time;                   // s: of each file of `points`
  std::int64_t stride = 1;                    // the next particle leaves from the point so many further on
  Keyed<double> area;                         // m²: flow over speed
  /// m³ that have come out by the times (s) between which the flow is smooth.
  struct Volumes {
    std::vector<double> time, out;
  } volumes;
  double fastest_file = 0;  // m/s: of the points of a sequence
  bool moves = false;
  /// Of a spray: the directions around the jet's axis, before its motion.
  struct Cone {
    double cosine = 1;             // of the half angle
    std::array<Vec3, 2> across{};  // unit, normal to the axis and to each other
  };
  std::optional<Cone> cone;
};

struct Jet {
  JetScene scene;
  std::vector<Vec3> offsets;          // m: points of the mouth, relative to the centre; of a nozzle, normal to the axis
  Quanta mass = quanta_per_particle;  // of each particle
  Quanta solute = 0;                  // of each particle
  double area = 0;                    // m²: flow over speed, at its largest
  double interval = 0;                // s, between two particles: d³/(area · |v|); 0 with keys
  double advance = 0;                 // m, of the liquid between two particles: d³/area
  // of a velocity with keys, what it is between them (src/stages/jets.hpp); also of one without, if there is a mouth
  Keyed<double> speed;         // m/s
  Keyed<Vec3> aim;             // unit at each key; the axis is along it
  std::optional<Mouth> mouth;  // of an emitter that moves or is a mesh

  bool has_keys() const { return speed.has_keys(); }
  /// How much liquid has come out by `time` (s), as a length of the jet, m.
  double out(double time) const {
    return speed.integral(scene.start, std::max(scene.start, std::min(time, scene.end)));
  }
};

/// One box of `hold_saturation`, resolved to nodes.
struct Reservoir {
  std::vector<Index> nodes;
  std::vector<Quanta> target;  // the liquid mass that each of them is held at
  double solute = 0;           // 1: quanta of solute for each of liquid that it supplies
};

/// How stage cloth solves: as this build does, by the reference's iterations (drench compare), or as a build for a GPU
/// does (tests).
enum class ClothEngine : std::uint8_t { own, reference, gpu };

struct Model {
  Scene scene;                              // as loaded
  double spacing = 0.01;                    // d, m
  double support = 0.02;                    // h, m
  double rest_density = 1000;               // ρ0, kg/m³
  double particle_mass = 1e-3;              // m0 = ρ0 d³, kg
  double quantum = 0;                       // q = m0 / 2^32, kg
  double layer_share = 1;                   // d³ S of density.hpp: a plane of wall samples counts for one layer
  double relaxation = 0.3;                  // ω of both pressure solves (setup/smoothing_kernel.hpp)
  ClothEngine cloth_engine{};               // own
  double evaporation_flux = 0;              // j, kg/(m² s): of a wet surface (setup/air.hpp); 0: nothing evaporates
  double cooling = 0;                       // β, 1: of wet cloth (setup/air.hpp); 0: it does not cool
  double wet_bulb = 0;                      // T_w, °C: of cloth that is wet all over, with cooling
  Quanta min_quanta = 0;                    // m_min = 0.05 m0
  Quanta max_quanta = quanta_per_particle;  // m_max = m0
  // kg/kg: liquid of this concentration has as many quanta of solute as of mass; 0: no solute (setup/solute.hpp)
  double concentration_unit = 0;
  std::vector<ClothMaterial> cloths;
  std::vector<ClothMaterial> patches;        // materials of regions and of nodes between them (setup/cloth_regions.hpp)
  std::vector<MaterialScene> patch_fabrics;  // of the first ones, those of regions: as the scene has them
  ClothMesh mesh;
  std::vector<PinMotion> pin_motions;
  // m/s: of particles at the start, and of what was prescribed before a program changed it (drench/prescribed.hpp)
  double fastest_before = 0;
  SampleSet samples;
  FabricPairs fabric;
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  BoundarySet boundary;
  std::vector<Jet> jets;
  std::vector<Reservoir> reservoirs;

  /// ω_C: the part of the row sums of cloth and dynamic bodies in the Jacobi diagonal
  /// (docs/theory/walls_and_sheets.md).
  double row_share() const { return 0.5 * relaxation; }
  bool has_fluid() const { return scene.fluid.present; }
  /// Do files prescribe the motion of the liquid, which then only wets cloth (setup/baked_liquid.hpp)?
  bool has_baked_liquid() const { return has_fluid() && scene.fluid.is_baked(); }
  /// Is the motion of the liquid computed?
  bool has_moving_liquid() const { return has_fluid() && !scene.fluid.is_baked(); }
  bool has_cloth() const { return !cloths.empty(); }
  /// Is there a cloth, or a region of one, that it is true of?
  template <class Predicate>
  bool any_cloth(Predicate predicate) const {
    return std::any_of(cloths.begin(), cloths.end(), predicate) ||
           std::any_of(patches.begin(), patches.end(), predicate);
  }
  /// Calls f for the material of every cloth and region.
  template <class F>
  void for_materials(F f) const {
    std::for_each(cloths.begin(), cloths.end(), f);
    std::for_each(patches.begin(), patches.end(), f);
  }
  /// Materials are numbered through: those of the cloths, then `patches`.
  const ClothMaterial& material(Index number) const {
    const auto at = static_cast<std::size_t>(number), first = cloths.size();
    return at < first ? cloths[at] : patches[at - first];
  }
  bool has_regions() const { return !mesh.triangle_material.empty(); }
  const ClothMaterial& material_of_node(Index n) const {
    return material((has_regions() ? mesh.node_material : mesh.node_cloth)[static_cast<std::size_t>(n)]);
  }
  const ClothMaterial& material_of_triangle(Index t) const {
    return material((has_regions() ? mesh.triangle_material : mesh.triangle_cloth)[static_cast<std::size_t>(t)]);
  }
  const ClothMaterial& material_of_sample(Index p) const {
    return material((has_regions() ? samples.material : samples.cloth)[static_cast<std::size_t>(p)]);
  }
  /// The fabric of a triangle as the scene has it.
  const MaterialScene& fabric_of_triangle(Index t) const {
    const auto at = static_cast<std::size_t>(t);
    const Index patch = has_regions() ? mesh.triangle_material[at] - static_cast<Index>(cloths.size()) : -1;
    if (patch < 0) return scene.cloths[static_cast<std::size_t>(mesh.triangle_cloth[at])].material;
    return patch_fabrics[static_cast<std::size_t>(patch)];
  }
  bool has_moving_cloth() const {
    return any_cloth([](const ClothMaterial& c) { return c.dynamics; });
  }
  /// Does nothing but the liquid itself answer to its pressure?
  bool only_liquid_answers() const { return samples.count() == 0 && !has_dynamic_body() && !has_commanded_body(); }
  /// Is a solve's start scaled, if the last step's began with `start` tolerances (docs/theory/liquid.md, Eq. 20a)?
  bool scales_start(double start) const { return only_liquid_answers() && start > 2; }
  bool has_moving_pins() const { return !pin_motions.empty(); }
  bool has_soft_pins() const { return !mesh.pin_stiffness.empty(); }
  bool has_stitches() const { return !mesh.stitch.empty(); }
  bool has_strain_limit() const { return !mesh.limit_stiffness.empty(); }
  bool has_membrane() const { return !mesh.membrane.empty(); }
  /// Does something act on the deformation of triangles?
  bool has_triangle_stress() const { return !mesh.triangle_shape.empty(); }
  bool softens_when_wet() const {
    return std::any_of(scene.cloths.begin(), scene.cloths.end(), [](const ClothScene& c) {
      return any_fabric(c, [](const MaterialScene& f) { return f.membrane && f.membrane->wet != 1; });
    });
  }
  bool expands_when_wet() const {
    return std::any_of(scene.cloths.begin(), scene.cloths.end(), [](const ClothScene& c) {
      return any_fabric(c, [](const MaterialScene& f) { return f.porous && f.hygral_expansion != 0; });
    });
  }
  /// How far cloth can be stretched (length over rest length) before its samples are 1.5 d apart and liquid gets
  /// between them; infinite where liquid meets none.
  double most_stretch() const {
    const bool met = samples.count() > 0 && has_fluid();
    return met ? 1.5 * spacing / samples.spacing : std::numeric_limits<double>::infinity();
  }
  bool has_self_collision() const {
    return any_cloth([](const ClothMaterial& c) { return c.dynamics && c.self_collision; });
  }
  bool has_wet_adhesion() const {
    return any_cloth([](const ClothMaterial& c) { return c.dynamics && c.wet_adhesion > 0; });
  }
  bool has_porous() const {
    return any_cloth([](const ClothMaterial& c) { return c.porous; });
  }
  /// Numbers of the porous cloths.
  std::vector<Index> porous_cloths() const {
    std::vector<Index> numbers;
    for (std::size_t k = 0; k < cloths.size(); ++k)
      if (cloths[k].porous) numbers.push_back(static_cast<Index>(k));
    return numbers;
  }
  bool has_absorption() const { return has_porous() && has_fluid() && scene.processes.absorption; }
  bool has_emission() const { return has_porous() && has_moving_liquid() && scene.processes.emission; }
  /// Does liquid go into the cloth or out of it?
  bool has_exchange() const { return has_absorption() || has_emission(); }
  /// Does the liquid's surface lose vapour to the air (stages/evaporation.hpp)? Does wet cloth (stages/drying.hpp)?
  bool has_evaporation() const { return evaporation_flux > 0 && has_moving_liquid(); }
  bool has_drying() const { return evaporation_flux > 0 && has_porous(); }
  /// Does something ask for liquid near porous cloth, after advection?
  bool meets_porous() const { return has_exchange() || (has_drying() && has_fluid()); }
  /// And for solids near it?
  bool porous_meets_solids() const { return (has_exchange() && has_direction()) || (has_drying() && has_fluid()); }
  /// Does pressure drive liquid through a cloth (stages/permeation.hpp)?
  bool has_permeation() const {
    return has_absorption() && has_emission() && has_direction() &&
           any_cloth([](const ClothMaterial& c) { return c.conductance > 0; });
  }
  bool has_direction() const { return scene.processes.direction; }
  bool has_saturation_control() const { return scene.processes.saturation_control; }
  bool has_diffusion() const {
    return scene.processes.diffusion && any_cloth([](const ClothMaterial& c) { return c.wicks(); });
  }
  /// Does liquid run down on the faces of a cloth?
  bool has_films() const {
    return has_diffusion() && has_emission() && any_cloth([](const ClothMaterial& c) { return c.film_depth > 0; });
  }
  /// Does liquid flow in a cloth by the suction of its pores?
  bool has_suction() const {
    return has_diffusion() && any_cloth([](const ClothMaterial& c) { return c.flows_by_suction(); });
  }
  /// Does stretching change the pores of a cloth?
  bool has_narrowing() const {
    return has_diffusion() && any_cloth([](const ClothMaterial& c) { return c.narrows(); });
  }
  /// Does a cloth hold liquid by other curves while it drains?
  bool has_hysteresis() const {
    return has_diffusion() && any_cloth([](const ClothMaterial& c) { return c.has_hysteresis(); });
  }
  /// Does pressure change what a cloth's pores hold (stages/squeezing.hpp)?
  bool has_squeezing() const {
    return any_cloth([](const ClothMaterial& c) { return c.dynamics && c.squeezes(); });
  }
  bool has_contact_wicking() const {
    return scene.processes.diffusion && any_cloth([](const ClothMaterial& c) { return c.wicks_through_contact(); });
  }
  /// Do walls have the pressure that the liquid's gradient along them makes?
  bool extrapolates_walls() const {
    return has_moving_liquid() && has_boundary() && scene.fluid.wall_pressure == WallPressure::extrapolated;
  }
  bool has_surface() const { return has_fluid() && scene.output.surface; }
  bool has_measures() const { return scene.output.measures; }
  bool has_fabric() const { return scene.output.fabric; }
  /// Does cloth count what comes and goes on each of its faces (stages/fabric.hpp)?
  bool counts_faces() const { return has_fabric() && has_exchange(); }
  bool has_boundary() const { return boundary.count() > 0; }
  /// Is there a body that it is true of?
  template <class Predicate>
  bool any_body(Predicate predicate) const {
    return std::any_of(bodies.begin(), bodies.end(), predicate);
  }
  /// Have bodies poses among the backend's arrays: because one moves, or for a probe of what acts on it?
  bool has_body_state() const {
    return any_body([](const Body& b) { return b.moves() || b.probed; });
  }
  bool has_moving_body() const {
    return any_body([](const Body& b) { return b.moves(); });
  }
  bool has_keyed_body() const {
    return any_body([](const Body& b) { return b.has_keys(); });
  }
  bool has_deforming_body() const {
    return any_body([](const Body& b) { return b.deforms(); });
  }
  bool has_dynamic_body() const {
    return any_body([](const Body& b) { return b.dynamic; });
  }
  bool has_commanded_body() const {
    return any_body([](const Body& b) { return b.commanded; });
  }
  bool has_measured_body() const {
    return any_body([](const Body& b) { return b.is_measured(); });
  }
  /// Does cloth that moves meet bodies that answer to it?
  bool cloth_pushes_bodies() const { return has_measured_body() && has_moving_cloth(); }
  // Slip is a matter of viscosity: without that there is none.
  bool has_slipping_body() const {
    return has_moving_liquid() && scene.fluid.viscosity > 0 && any_body([](const Body& b) { return b.slip > 0; });
  }
  bool has_slipping_cloth() const {
    return has_moving_liquid() && scene.fluid.viscosity > 0 &&
           any_cloth([](const ClothMaterial& c) { return c.slip > 0; });
  }
  bool has_sticky_cloth() const {
    return any_cloth([](const ClothMaterial& c) { return c.adhesion > 0; });
  }
  /// Does the liquid adhere to anything?
  bool has_adhesion() const {
    return has_sticky_cloth() || any_body([](const Body& b) { return b.adhesion > 0; });
  }
  /// The longest step that surface tension and adhesion allow, s (src/stages/time_step.hpp); infinite without them.
  double capillary_step() const {
    double strongest = scene.fluid.surface_tension;  // N/m
    for (const auto& b : bodies) strongest = std::max(strongest, b.adhesion);
    for_materials([&](const ClothMaterial& c) { strongest = std::max(strongest, c.adhesion); });
    if (!has_moving_liquid() || strongest <= 0) return std::numeric_limits<double>::infinity();
    return 0.7 * std::sqrt(scene.fluid.density * spacing * spacing * spacing / (2 * std::numbers::pi * strongest));
  }
  /// 1: mean compression that ends the density solve. Steps of mode error share their tolerance between it and the
  /// motion.
  double density_tolerance() const {
    const double asked = scene.fluid.solver.density_error;
    return scene.time.mode == TimeMode::error ? std::min(asked, 0.5 * scene.time.tolerance) : asked;
  }
  bool has_surface_forces() const { return has_moving_liquid() && (scene.fluid.surface_tension > 0 || has_adhesion()); }
  bool has_micropolar() const { return has_fluid() && scene.fluid.micropolar.present; }
  /// Does the liquid carry a solute (docs/theory/solute.md)?
  bool has_solute() const { return concentration_unit > 0; }
  /// kg: of a quantum of solute.
  double solute_quantum() const { return quantum * concentration_unit; }
  bool has_jets() const { return !jets.empty(); }
  bool has_drains() const { return has_fluid() && !scene.fluid.drains.empty(); }
  /// May there be more particles than at the start?
  bool adds_particles() const { return has_jets() || has_emission() || has_baked_liquid(); }
  bool has_reservoirs() const { return !reservoirs.empty(); }
};

}  // namespace drench
