#pragma once
// Scenes that between them use everything that a step hands on to the next one, small enough for tests. In all of them
// much happens within some thirty steps.

namespace drench::test {

/// A block beside a jet in a container, with a floating box and a ball that rises and turns, surface tension, a domain
/// that drains, and steps as long as the liquid allows.
inline constexpr const char* liquid_scene = R"(drench: 1
time: {step: 0.004, end: 1, mode: cfl}
domain: {min: [-0.2, -0.05, -0.2], max: [0.07, 0.5, 0.2]}
output: {every: 0.01}
fluid:
  spacing: 0.02
  viscosity: 2.0e-3
  surface_tension: 0.05
  micropolar: {transfer: 2.0e-3, viscosity: 1.0e-4}
  sources:
    - block: {min: [-0.1, 0, -0.08], max: [0.02, 0.12, 0.08], velocity: [2.5, 0, 0]}
    - jet: {center: [0, 0.3, 0], radius: 0.03, velocity: [0, -2, 0.3], start: 0.004, end: 0.06}
bodies:
  - box: {min: [-0.1, 0, -0.1], max: [0.1, 0.2, 0.1], inside: true}
  - box: {min: [-0.06, 0.13, -0.03], max: [0, 0.17, 0.03], dynamic: true, density: 400, slip: free}
  - sphere: {center: [0.05, 0.05, 0], radius: 0.03, velocity: [0, 0.2, 0],
        spin: {axis: [0, 0, 1], degrees_per_second: 400}, slip: 0.01}
)";

/// An overfull sheet drips on a second one that moves by its pins, over a floating sphere, under a jet: all of the
/// porous stages, sticking and touching layers, a reservoir, and fresh particles.
inline constexpr const char* porous_scene = R"(drench: 1
time: {step: 0.003, end: 1}
domain: {min: [-0.4, -0.1, -0.4], max: [0.4, 0.5, 0.4]}
output: {every: 0.01, measures: true, fabric: true}
fluid:
  spacing: 0.015
  viscosity: 1.0e-4
  micropolar: {transfer: 2.0e-3, inertia: 0.5, reaction: 0.5}
  sources:
    - block: {min: [-0.04, 0.21, -0.04], max: [0.04, 0.25, 0.04], velocity: [0, -1.5, 0], concentration: 0.01}
    - jet: {center: [0.02, 0.3, 0], radius: 0.02, velocity: [0, -2, 0], end: 0.08, concentration: 0.03}
cloth:
  - name: upper
    mesh: {grid: {size: [0.2, 0.2], nodes: [9, 9]}}
    place: {position: [0, 0.2, 0]}
    thickness: 0.002
    self_collision: true
    friction_wet: 1
    damping_wet: 3
    adhesion: 0.01
    pin: [{corners: true}]
    initial_saturation: [{box: {min: [-1, -1, -1], max: [0, 1, 1]}, value: 1.4}]
    hold_saturation: [{box: {min: [0.05, 0, 0.05], max: [1, 1, 1]}, value: 1.2, concentration: 0.02}]
    initial_stain: [{box: {min: [-1, -1, -1], max: [1, 1, 0]}, value: 1.0e-3}]
    porous: {max_saturation: 1.5, diffusivity: 2.0e-3, diffusion: degenerate, capillary_height: 0.2,
        emission_velocity: 2,
             adhesion: 0.1, contact_wicking: true}
  - name: lower
    mesh: {grid: {size: [0.16, 0.16], nodes: [7, 7]}}
    place: {position: [0.05, 0.195, 0], rotate: {axis: [0, 1, 0], degrees: 30}}
    thickness: 0.002
    self_collision: true
    strain_limit: 0.05
    pin: [{nodes: [0, 6], velocity: [0, 0.3, 0.1], end: 0.05}]
    porous: {diffusivity: 1.0e-3, adhesion: 0.1, contact_wicking: true}
bodies:
  - sphere: {center: [0, 0.13, 0], radius: 0.05, dynamic: true, density: 600}
  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}
)";

/// What porous_scene's `lower` gets before its pins: two regions, and a seam that both sheets lie on.
inline constexpr const char* scene_regions = R"(    regions:
      - {box: {min: [-1, -1, -1], max: [0.05, 1, 1]}, areal_density: 0.4, thickness: 0.0025, stretch: 900,
            bend: 4.0e-4, friction: 0.6,
         damping: 2, porous: {solid_fraction: 0.6, absorption: 0.05, max_saturation: 1.4, diffusivity: 4.0e-4,
             emission_velocity: 1}}
      - {box: {min: [0.06, -1, -0.02], max: [1, 1, 1]}, stretch: 200,
            porous: {diffusivity: 5.0e-3, uptake_velocity: 0.1}}
)";

/// A steep sheet falls on a pinned one over a sphere, in XPBD with strain limits; no liquid.
inline constexpr const char* cloth_scene = R"(drench: 1
time: {step: 0.004, end: 1}
output: {every: 0.01}
cloth_solver: {method: xpbd, tolerance: 1.0e-2}
cloth:
  - name: falling
    mesh: {grid: {size: [0.15, 0.15], nodes: [8, 8]}}
    place: {position: [0, 0.205, 0], rotate: {axis: [1, 0.2, 0.1], degrees: 70}}
    thickness: 0.004
    bend: 1.0e-5
    strain_damping: 0.01
    strain_limit: 0.03
    self_collision: true
  - name: pinned
    mesh: {grid: {size: [0.2, 0.2], nodes: [9, 9]}}
    place: {position: [0, 0.12, 0]}
    thickness: 0.004
    self_collision: true
    pin: [{corners: true}]
bodies:
  - sphere: {center: [0, 0.05, 0], radius: 0.06}
  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}
)";

/// A wide nozzle that sweeps, one that turns about a place beside it, and drains in the pool that they fill.
inline constexpr const char* emitters_scene = R"(drench: 1
time: {step: 0.004, end: 1, mode: cfl}
domain: {min: [-0.4, -0.1, -0.4], max: [0.4, 0.5, 0.4]}
output: {every: 0.01}
fluid:
  spacing: 0.02
  sources:
    - jet: {center: [-0.05, 0.1, 0], size: [0.1, 0.04], velocity: [[0, [0, -1, 0]], [0.05, [0.5, -2, 0]]],
        up: [1, 0, 0], start: 0.002, end: 0.09,
        motion: {velocity: {keys: [[0, [0, 0, 0]], [0.03, [1.5, 0, 0]]], interpolation: smooth},
        offset: [[0, [0, 0, 0]], [0.04, [0, 0.02, 0.03]]]}}
    - jet: {center: [0.06, 0.12, 0], radius: 0.03, velocity: [0, -1.5, 0],
        motion: {spin: {axis: [0, 1, 0], degrees_per_second: 720, center: [0, 0.12, 0]}}}
  drains:
    - {box: {min: [-0.06, -0.1, -0.1], max: [0.06, 0.015, 0.1]}, start: 0.03, end: 0.1}
    - {sphere: {center: [0.1, 0.02, 0], radius: 0.04}}
    - {plane: {point: [0, -0.01, 0.09], normal: [0, 0, -1]}}
bodies:
  - box: {min: [-0.15, 0, -0.1], max: [0.15, 0.3, 0.1], inside: true}
)";

/// A source for it.
inline constexpr const char* moving_spray =
    "    - spray: {center: [0, 0.2, 0.05], direction: [0, -1, 0], half_angle: 50, speed: 1.5, flow: 30, start: 0.003, "
    "motion: {offset: [[0, [0, 0, 0]], [0.05, [0.03, 0, 0]]]}}\n";

/// All that keys move: a jet, a wind, the frame, pins, a ball and a floor, each with keys between which the first steps
/// end.
inline constexpr const char* keyed_scene = R"(drench: 1
time: {step: 0.004, end: 1, mode: cfl}
domain: {min: [-0.4, -0.1, -0.4], max: [0.4, 0.5, 0.4]}
output: {every: 0.01}
wind: {velocity: {keys: [[0, [0, 0, 0]], [0.05, [6, 0, 0]], [0.1, [0, 0, 3]]], interpolation: smooth},
    liquid_drag: 0.47}
rotating_frame: {degrees_per_second: [[0, 0], [0.06, 200]]}
fluid:
  spacing: 0.02
  sources:
    - jet: {center: [0, 0.3, 0], radius: 0.03, velocity: [[0, [0, 0, 0]], [0.02, [0, -3, 0]], [0.06, [1, -3, 0]]],
          start: 0.002, end: 0.07}
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [9, 9]}}
    place: {position: [0, 0.2, 0]}
    pin: [{corners: true, velocity: {keys: [[0, [0, 0, 0]], [0.03, [0, 0.5, 0]], [0.06, [0, 0, 0]]],
        interpolation: smooth}, offset: [[0, [0, 0, 0]], [0.05, [0.01, 0, 0]]],
        spin: {axis: [0, 1, 0], degrees_per_second: [[0, 0], [0.05, 200]]}}]
bodies:
  - sphere: {center: [0, 0.08, 0], radius: 0.05,
        offset: {keys: [[0, [0, 0, 0]], [0.1, [0, 0.05, 0.02]]], interpolation: smooth},
        spin: {degrees_per_second: [[0, 0], [0.05, 500]]}}
  - plane: {point: [0, 0, 0], normal: [0, 1, 0], velocity: [[0, [0, 0, 0]], [0.05, [0, 0.2, 0]]]}
)";

/// A still sheet that wicks from a reservoir, with liquid on it, in poly6, with liquid that feels through cloth.
inline constexpr const char* filter_scene = R"(drench: 1
time: {step: 0.002, end: 1, mode: cfl}
domain: {min: [-0.2, -0.05, -0.2], max: [4, 4, 4]}
output: {every: 0.01, measures: true, fabric: true}
neighbors: {sort: bitonic, through_cloth: true}
field: {center: [0, 0.1, 0], rate: [3, 0, 3]}
fluid:
  spacing: 0.02
  kernel: poly6
  sources:
    - block: {min: [-0.05, 0.11, -0.05], max: [0.05, 0.17, 0.05], velocity: [0, -1, 0]}
    - block: {min: [3, 3, 3], max: [3.02, 3.02, 3.02]}    # so far away that the cells are hashed
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [9, 9]}}
    place: {position: [0, 0.1, 0]}
    dynamics: false
    hold_saturation: [{box: {min: [-1, -1, -1], max: [-0.05, 1, 1]}, value: 1.18}]
    porous: {diffusivity: 1.0e-3}
)";

}  // namespace drench::test
