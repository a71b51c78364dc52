#include "setup/solute.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/eigen_vec.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/liquid_shapes.hpp"

namespace drench {
namespace {

/// The largest concentration of a cloth's boxes and stains, kg/kg.
double most_of_cloth(const ClothScene& scene, const Model& model, std::size_t cloth) {
  double most = 0;
  for (const auto* boxes : {&scene.initial_saturation, &scene.hold_saturation})
    for (const SaturationScene& box : *boxes) most = std::max(most, box.concentration);
  const auto full_of = [&](const ClothMaterial& m) {
    return model.rest_density * (1 - m.solid_fraction) * m.thickness;
  };
  double full = full_of(model.cloths[cloth]);  // kg/m²
  for (const ClothMaterial& m : model.patches)
    if (m.of_cloth == static_cast<Index>(cloth)) full = std::min(full, full_of(m));
  for (const StainScene& stain : scene.initial_stain) most = std::max(most, stain.value / full);
  return most;
}

}  // namespace

void set_concentration_unit(Model& model) {
  double most = 0;
  for (const BlockScene& block : model.scene.fluid.blocks) most = std::max(most, block.concentration);
  for (const JetScene& jet : model.scene.fluid.jets) most = std::max(most, jet.concentration);
  for (const RainScene& rain : model.scene.fluid.rains) most = std::max(most, rain.concentration);
  for (const SprayScene& spray : model.scene.fluid.sprays) most = std::max(most, spray.concentration);
  for (const MeshJetScene& jet : model.scene.fluid.mesh_jets) most = std::max(most, jet.concentration);
  for (std::size_t c = 0; c < model.cloths.size(); ++c)
    most = std::max(most, most_of_cloth(model.scene.cloths[c], model, c));
  model.concentration_unit = most;
}

Quanta solute_quanta(const Model& model, double concentration, Quanta liquid) {
  if (!model.has_solute()) return 0;
  return std::llround(static_cast<double>(liquid) * (concentration / model.concentration_unit));
}

std::vector<double> node_area(const Model& model) {
  std::vector<double> area(model.mesh.rest_position.size(), 0.0);
  for (std::size_t p = 0; p < model.samples.triangle.size(); ++p)
    for (std::size_t k = 0; k < 3; ++k)
      area[static_cast<std::size_t>(model.mesh.triangle[static_cast<std::size_t>(model.samples.triangle[p])][k])] +=
          model.samples.weight[p][k] * model.samples.area[p];
  return area;
}

void dissolve_in_blocks(const Model& model, const std::vector<std::size_t>& block, HostState& state) {
  if (!model.has_solute()) return;
  for (std::size_t i = 0; i < block.size(); ++i)
    state.fluid_solute[i] = solute_quanta(model, model.scene.fluid.blocks[block[i]].concentration, state.fluid_mass[i]);
}

void warn_of_thin_solute(const Model& model, std::vector<std::string>& warnings) {
  const auto look = [&](const char* kind, std::size_t number, double concentration) {
    const double part = concentration / model.concentration_unit;
    if (part > 0 && part < 1e-6)
      warnings.push_back(
          fmt::format("fluid: {} {} has a concentration of {:.3g}, the scene up to {:.3g}: its solute is resolved "
                      "in steps of {:.1g} of its content per "
                      "particle; avoid the larger concentration",
                      kind, number, concentration, model.concentration_unit,
                      1 / (part * static_cast<double>(quanta_per_particle))));
  };
  if (!model.has_solute()) return;
  const FluidScene& fluid = model.scene.fluid;
  for (std::size_t b = 0; b < fluid.blocks.size(); ++b)
    look(kind_of(fluid.blocks[b]), b, fluid.blocks[b].concentration);
  for (std::size_t j = 0; j < fluid.jets.size(); ++j) look("jet", j, fluid.jets[j].concentration);
  for (std::size_t j = 0; j < fluid.sprays.size(); ++j) look("spray", j, fluid.sprays[j].concentration);
  for (std::size_t j = 0; j < fluid.mesh_jets.size(); ++j) look("mesh_jet", j, fluid.mesh_jets[j].concentration);
}

void add_stains(const Model& model, HostState& state, std::vector<std::string>& warnings) {
  if (!model.has_solute()) return;
  const std::vector<double> area = node_area(model);
  std::vector<Quanta> stain(area.size(), 0);
  for (std::size_t c = 0; c < model.cloths.size(); ++c) {
    const ClothMaterial& cloth = model.cloths[c];
    for (const StainScene& box : model.scene.cloths[c].initial_stain) {
      bool any = false;
      for (auto n = static_cast<std::size_t>(cloth.first_node);
           n < static_cast<std::size_t>(cloth.first_node + cloth.node_count); ++n) {
        if (!contains(box.box.min, box.box.max, model.mesh.rest_position[n])) continue;
        stain[n] = std::llround(box.value * area[n] / model.solute_quantum());
        any = true;
      }
      if (!any)
        warnings.push_back(
            fmt::format("{}: initial_stain: a box contains no node of the cloth", cloth_label(cloth.name)));
    }
  }
  for (std::size_t n = 0; n < stain.size(); ++n) state.node_solute[n] += stain[n];
}

}  // namespace drench
