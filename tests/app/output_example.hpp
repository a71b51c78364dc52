#pragma once
// A model and a state for the tests of the writers.

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench::test {

/// Three particles and one porous triangle with two samples, made by hand so that every expected number is known.
struct Example {
  Model model;
  HostState state;

  Example() {
    model.scene.fluid.present = true;
    model.scene.domain = {{-1, -1, -1}, {1, 1, 1}};
    model.spacing = 0.1;
    model.rest_density = 800;
    model.particle_mass = 0.8;
    model.quantum = 0.8 / static_cast<double>(quanta_per_particle);
    ClothMaterial& cloth = model.cloths.emplace_back();
    cloth.name = "sheet";
    cloth.porous = true;
    model.mesh.rest_position = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
    model.mesh.solid_mass = {0.1, 0.1, 0.1};
    model.mesh.triangle = {{0, 1, 2}};
    model.mesh.triangle_cloth = {0};
    model.samples.triangle = {0, 0};
    model.samples.weight = {{0.5, 0.5, 0.0}, {0.25, 0.25, 0.5}};
    model.samples.node_samples.start = {0, 2, 4, 5};
    model.samples.node_samples.item = {0, 4, 1, 5, 6};  // 4·sample + corner
    model.samples.node_capacity = {0.4, 0.2, 0.0};

    state.fluid_position = {{0, 0.5, 0}, {0.1, 0.5, 0}, {0.2, 0.5, 0}};
    state.fluid_velocity = {{1, 2, 3}, {0, 0, 0}, {0, -1, 0}};
    state.fluid_mass = {quanta_per_particle, quanta_per_particle / 8, quanta_per_particle};
    state.fluid_id = {7, 123456789012345, 9};
    state.fluid_age = {0.5, 0, 0.25};
    state.fluid_density_ratio = {1.0, 1.01, 0.5};
    state.fluid_kappa_density = {0, 2.5, 0};
    state.node_position = model.mesh.rest_position;
    state.node_velocity = {{0, 0, 0}, {0, -2, 0}, {0, 0, 0}};
    state.node_liquid = {quanta_per_particle / 4, quanta_per_particle / 8, 0};
    state.node_pin_force = {{0, 5, 0}, {0, 0, 0}, {0, 0, 0}};
    state.sample_flow_direction = {{1, 0, 0}, {0, 1, 0}};
  }
};

}  // namespace drench::test
