#pragma once
// Scene files that must load. The files exists.obj, cache.pc2, cache.mdd, mesh.PLY and seams.txt must lie beside the
// scene.

namespace drench::testing {

inline constexpr const char* minimal = "drench: 1\nfluid: {sources: [{block: {min: [0, 0, 0], max: [1, 1, 1]}}]}\n";
inline constexpr const char* fluid_and_cloth =
    "drench: 1\nfluid: {sources: [{block: {min: [0, 0, 0], max: [1, 1, 1]}}]}\ncloth: [{mesh: {grid: {}}}]\n";

/// Every key of the format, with a value that is not the default wherever this version takes another.
inline constexpr const char* everything = R"(drench: 1
time: {step: 0.002, end: 3.5, mode: cfl, cfl: 0.3, tolerance: 2.0e-3}
gravity: [0.1, -1.62, 0.2]
field: {center: [0.5, 0, -0.5], rate: [1, 2, 0]}
air: {humidity: 0.25, temperature: 35, transfer_coefficient: 0.02, cooling: true}
domain: {min: [-2, -3, -4], max: [5, 6, 7]}
output: {every: 0.05, checkpoint_every: 0.7, measures: true, fabric: true, wet_above: 0.1, surface: true,
    surface_spacing: 0.75, surface_kernel: isotropic, fitted_pressure: true, report: true}
processes: {direction: off, saturation_control: false, absorption: off, emission: off, diffusion: off}
neighbors: {sort: bitonic_naive, through_cloth: true}
fluid:
  spacing: 0.02
  density: 998
  viscosity: 2.0e-6
  surface_tension: 0.05
  kernel: wendland
  support: 2.5
  wall_pressure: mirrored
  micropolar: {transfer: 2.0e-3, inertia: 3, viscosity: 1.0e-4, reaction: 0.25}
  solver: {density_error: 2.0e-3, divergence_error: 3.0e-3, max_iterations: 50, min_iterations: 1,
           density_correction: 0.75, source_error: 0.25}
  sources:
    - block: {min: [0, 0.1, 0], max: [0.3, 0.4, 0.5], velocity: [1, 2, 3], concentration: 0.02}
    - sphere: {center: [0.1, 0.2, 0.3], radius: 0.25, velocity: [0, 1, 0], concentration: 0.01}
    - mesh: {file: mesh.PLY, scale: 20, unit: cm, up: z, position: [1, 2, 3], rotate: {axis: [0, 1, 1], degrees: 20},
        velocity: [1, 0, 0], concentration: 0.03}
    - particles: {file: mesh.PLY, scale: 30, unit: mm, up: x, position: [3, 2, 1],
        rotate: {axis: [1, 1, 0], degrees: 5}, velocity: [0, 0, 1], concentration: 0.05}
    - rain: {center: [0.5, 2, 0.5], size: [0.4, 0.6], rate: 300, diameter: 0.004, velocity: [0, -6, 1], start: 0.25,
        end: 2, concentration: 0.015}
    - spray: {center: [0, 1, 0.5], direction: [1, -2, 0], half_angle: 15, speed: 12, flow: 2.5, start: 0.75, end: 4,
        concentration: 0.025, motion: {velocity: [0, 0, 0.1], offset: [[0, [0, 0, 0]], [2, [0, 0.2, 0]]],
        spin: {axis: [1, 0, 0], degrees_per_second: 20, center: [0, 1, 0]}}}
    - jet: {center: [1, 1, 1], radius: 0.07, velocity: [0, -2, 0], concentration: 0.04, start: 0.5, end: 1.5}
    - jet: {center: [1, 2, 1], radius: 0.08, velocity: [[0, [0, -3, 0]], [0.5, [1, -2, 0.5]]], end: .inf}
    - jet: {center: [0, 1, 0], size: [0.2, 0.1], up: [0, 0, 2], velocity: [0, -1, 0], motion: {velocity: [0.1, 0, 0],
        offset: {keys: [[0, [0, 0, 0]], [1, [0, 0.1, 0]]], interpolation: smooth},
        spin: {axis: [0, 0, 1], degrees_per_second: [[0, 0], [1, 90]], center: [0, 2, 0]}}}
    - mesh_jet: {file: mesh.PLY, scale: 100, unit: mm, up: z, position: [0, 1, 0],
        rotate: {axis: [0, 0, 1], degrees: 8}, speed: [[0, 0], [1, 2]], direction: [0, -1, 0.5],
        motion: {velocity: [0, 0.1, 0],
        offset: [[0, [0, 0, 0]], [2, [0.2, 0, 0]]], spin: {axis: [1, 0, 0], degrees_per_second: 30, center: [1, 0, 0]}},
        start: 0.1, end: 3, concentration: 0.01}
    - mesh_jet: {sequence: [mesh.PLY, mesh.PLY], fps: 12, speed: 1.5}
  drains:
    - {box: {min: [-1, -2, -1], max: [1, -1, 1]}, start: 0.5, end: 2}
    - {sphere: {center: [2, 0, 0], radius: 0.3}}
    - {plane: {point: [0, -2, 0], normal: [0, 2, 0]}}
cloth_solver: {method: xpbd, tolerance: 2.0e-3, max_iterations: 500}
cloth:
  - name: "a \"sheet\" \\ é"
    mesh: {grid: {size: [0.6, 0.7], nodes: [13, 17]}}
    place: {position: [0, 0.5, 0.1], rotate: {axis: [0, 1, 1], degrees: 30}}
    areal_density: 0.3
    thickness: 0.002
    compression: 8000
    stretch: 400
    bend: 2.0e-4
    damping: 0.5
    strain_damping: 0.02
    friction: 0.4
    friction_wet: 1.1
    damping_wet: 3
    strain_limit: 0.05
    adhesion: 0.01
    slip: 0.002
    sample_spacing: 0.009
    pin: [{corners: true}, {edges: true}, {box: {min: [-1, 0, -1], max: [0, 1, 0]}}, {nodes: [3, 220]}]
    self_collision: true
    dynamics: false
    initial_saturation: [{box: {min: [-1, 0, -1], max: [0, 1, 0]}, value: 0.5, concentration: 0.01}]
    hold_saturation:
      - {box: {min: [-1, 0, -1], max: [0, 1, 0]}, value: 1.25}
      - {box: {min: [0, 0, 0], max: [1, 1, 1]}, value: 0, concentration: 0.03}
    initial_stain: [{box: {min: [-1, 0, -1], max: [0, 1, 0]}, value: 0.05}]
    porous: {solid_fraction: 0.5, absorption: 0.02, uptake_velocity: 0.03, max_saturation: 1.3, virtual_pressure: 15,
             emission_angle: 70, emission_velocity: 0.6, emission_ramp: 0.03, diffusivity: 2.0e-4,
             weft_diffusivity: 5.0e-5, diffusion: degenerate, capillary_height: 0.8, adhesion: 0.05,
             film: 4.0e-4, film_viscosity: 2.0e-6, permeability: 2.0e-10, forchheimer: 2.0e5,
             breakthrough_pressure: 300, critical_saturation: 0.4, compressibility: 0.35, contact_wicking: true}
    regions:
      - {box: {min: [-1, 0, -1], max: [0, 1, 0]}, areal_density: 0.9, thickness: 0.003, stretch: 700, bend: 3.0e-4,
            damping: 0.6,
         friction: 0.45, friction_wet: 1.2, damping_wet: 4, adhesion: 0.02, warp: [1, 0, 1],
             porous: {solid_fraction: 0.55, absorption: 0.025, uptake_velocity: 0.035,
         max_saturation: 1.35, virtual_pressure: 17, emission_angle: 65, emission_velocity: 0.7, diffusivity: 3.0e-4,
         weft_diffusivity: 6.0e-5, permeability: 3.0e-10, fibre_diameter: 2.0e-5,
         breakthrough_pressure: 200, critical_saturation: 0.45}}
  - name: moved
    mesh: {grid: {size: [1, 1], nodes: [5, 5]}}
    velocity: [3, 0, -0.5]
    membrane: {warp: 900, weft: 450, shear: 90, warp_locking: 0.25, weft_locking: 0.5}
    warp: [0, 0.5, 1]
    pin:
      - {nodes: [0, 1], velocity: [0.1, 0, 0.2], start: 0.5, end: 2.5}
      - {nodes: [3], stiffness: 500, release: 3,
            velocity: {keys: [[0, [0, 0, 0]], [1, [0, 1, 0]]], interpolation: step},
            offset: {keys: [[0, [0, 0, 0]], [2, [0.1, 0.2, 0.3]]], interpolation: smooth}}
      - {box: {min: [0, -1, 0], max: [1, 1, 1]}, spin: {axis: [0, 0, 1], degrees_per_second: 90, center: [0, 1, 0]}}
  - name: second
    mesh: {file: exists.obj, scale: 0.01, unit: inch, up: z}
    clean: 2.0e-5
    weld: 1.0e-5
    dynamics: false
    porous: {diffusion_exponent: 2.5, retention_exponent: 1.5, drainage_height: 1.75,
      drainage_exponent: 2.25, large_pores: 0.375, large_pore_height: 0.125,
      pore_narrowing: -0.75, hygral_expansion: 0.0625}
  - name: followed
    mesh: {file: exists.obj}
    clean: off
    weld: off
    sew: [{loops: [[0, 1], [2, 3]]}, {groups: [left, right-side]}, {pairs: [[7, 8]]}, {file: seams.txt}]
    sew_time: 0.75
    pin: [{nodes: [1], sequence: exists.obj, fps: 30}, {nodes: [2], body: floor}, {nodes: [3], sequence: cache.mdd}]
  - {name: painted, mesh: {file: mesh.PLY}, regions: [{attribute: wax, friction: 0.9}]}
bodies:
  - mesh: {file: mesh.PLY, sequence: cache.pc2, fps: 25}
  - mesh: {sequence: [mesh.PLY, mesh.PLY], fps: 12}
  - box: {min: [-1, -1, -1], max: [1, 2, 1], inside: true, velocity: [0.1, 0, -0.2], adhesion: 0.02, slip: free}
  - name: ball
    sphere: {center: [0, 0.2, 0], radius: 0.25, dynamic: true, density: 400, slip: 0.05, commanded: false}
  - name: floor
    plane: {point: [0, -0.5, 0], normal: [0, 2, 0], offset: [[0, [0, 0, 0]], [1, [0, 0.5, 0]]],
        spin: {axis: [1, 0, 0], degrees_per_second: [[0, 5], [0.5, -5.5], [2, 0]]}, adhesion: 0.04, commanded: false}
  - mesh: {file: mesh.PLY, scale: 1.5, position: [1, 0, 0], velocity: [0, 0, 1], inside: false,
        spin: {axis: [0, 0, 1], degrees_per_second: -90}, adhesion: 0.06, unit: mm, up: x, commanded: false}
    place: {scale: [1, 2, 0.5], position: [0.5, 1, 0.25], rotate: {axis: [0, 1, 0], degrees: 45}}
joints:
  - hinge: {body: ball, to: floor, point: [0, 0.2, 0.25], axis: [1, 0, 0], limits: [-30, 60],
        motor: {degrees_per_second: [[0, 0], [1, 90]], torque: 2}}
)";

}  // namespace drench::testing
