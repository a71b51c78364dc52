#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <string>

#include "app/commands.hpp"
#include "app/set_up.hpp"
#include "pipeline/pipeline.hpp"
#include "pipeline/runtime.hpp"
#include "scene/fabrics.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"
#include "setup/cloth_regions.hpp"
#include "setup/forecast.hpp"
#include "setup/pieces.hpp"
#include "stages/substeps.hpp"

namespace drench {
namespace {

/// The triangles and the dry mass of each region of a cloth.
void print_regions(const Model& model) {
  for (const ClothMaterial& patch : model.patches) {
    if (patch.region < 0 || patch.level > 1) continue;  // of a painted region: all levels at once
    const ClothScene& cloth = model.scene.cloths[static_cast<std::size_t>(patch.of_cloth)];
    Index count = 0;
    double area = 0;  // m²
    for (Index t = 0; t < model.mesh.triangles(); ++t) {
      const ClothMaterial& own = model.material_of_triangle(t);
      if (own.region != patch.region || own.of_cloth != patch.of_cloth) continue;
      const auto& corner = model.mesh.triangle[static_cast<std::size_t>(t)];
      const auto at = [&](std::size_t c) { return model.mesh.rest_position[static_cast<std::size_t>(corner[c])]; };
      area += triangle_area(at(0), at(1), at(2));
      ++count;
    }
    const RegionScene& region = cloth.regions[static_cast<std::size_t>(patch.region)];
    fmt::print("{} of {}: {} triangles, {:.4g} m², {:.4g} kg/m² ({:.4g} g/m²)\n", region_label(region, patch.region),
               cloth.name, count, area, region.material.areal_density, 1000 * region.material.areal_density);
  }
}

/// The loops that `sew` names by number.
void print_loops(const Model& model) {
  constexpr std::size_t most = 16;
  for (std::size_t c = 0; c < model.cloths.size(); ++c) {
    if (model.scene.cloths[c].grid) continue;
    const std::vector<Chain> loops = loops_of(model, model.cloths[c]);
    std::vector<Vec3> points(
        model.mesh.rest_position.begin() + model.cloths[c].first_node,
        model.mesh.rest_position.begin() + model.cloths[c].first_node + model.cloths[c].node_count);
    for (std::size_t k = 0; k < std::min(loops.size(), most); ++k) {
      Vec3 middle{0, 0, 0};
      for (const Index n : loops[k].nodes)
        for (std::size_t a = 0; a < 3; ++a)
          middle[a] += points[static_cast<std::size_t>(n)][a] / static_cast<double>(loops[k].nodes.size());
      for (double& x : middle) x = std::round(1e6 * x) / 1e6 + 0.0;
      fmt::print("boundary loop {} of {}: {} nodes, {:.3g} m, around ({:.3g}, {:.3g}, {:.3g})\n", k,
                 model.cloths[c].name, loops[k].nodes.size(), length_of(loops[k], points), middle[0], middle[1],
                 middle[2]);
    }
    if (loops.size() > most)
      fmt::print("and {} more boundary loops of {}\n", loops.size() - most, model.cloths[c].name);
  }
}

std::string baked_text(const Model& model) {
  const SequenceScene& sequence = model.scene.fluid.blocks.front().sequence;
  return fmt::format(", moved by {} files until {:.4g} s", sequence.files.size(),
                     static_cast<double>(sequence.files.size() - 1) / sequence.fps);
}

void print_parts(const Model& model, const HostState& state) {
  if (model.has_fluid())
    fmt::print("fluid: {} particles of {:.4g} m, {:.4g} kg, {} emitters{}{}\n", state.fluid_count(), model.spacing,
               static_cast<double>(std::accumulate(state.fluid_mass.begin(), state.fluid_mass.end(), Quanta{0})) *
                   model.quantum,
               model.jets.size(), model.has_baked_liquid() ? baked_text(model) : "",
               model.has_drains() ? fmt::format(", {} drains", model.scene.fluid.drains.size()) : "");
  for (const ClothMaterial& c : model.cloths)
    fmt::print("cloth {}: {} nodes, {} triangles, {} quadrature points, {:.4g} kg/m² ({:.4g} g/m²){}{}\n", c.name,
               c.node_count, c.triangle_count, c.sample_count, c.areal_density, 1000 * c.areal_density,
               c.porous ? ", porous" : "", c.dynamics ? "" : ", does not move");
  print_regions(model);
  if (model.has_cloth()) {
    const auto pinned = std::count(model.mesh.pinned.begin(), model.mesh.pinned.end(), 1),
               softly = std::count_if(model.mesh.pin_stiffness.begin(), model.mesh.pin_stiffness.end(),
                                      [](double k) { return k > 0; });
    double capacity = 0;
    for (const double c : model.samples.capacity) capacity += c;
    fmt::print("cloth in all: {} nodes, {} pinned{}, {} edges, {} hinges, holds {:.4g} kg of liquid at saturation 1\n",
               model.mesh.nodes(), pinned, softly > 0 ? fmt::format(", {} held by springs", softly) : "",
               model.mesh.edge.size(), model.mesh.hinge.size(), capacity);
  }
  if (model.has_solute()) {
    Quanta fluid = 0, cloth = 0;
    for (const Quanta q : state.fluid_solute) fluid += q;
    for (const Quanta q : state.node_solute) cloth += q;
    fmt::print("solute: {:.4g} kg in the liquid, {:.4g} kg on cloth\n",
               static_cast<double>(fluid) * model.solute_quantum(),
               static_cast<double>(cloth) * model.solute_quantum());
  }
  const auto deforming =
      std::count_if(model.bodies.begin(), model.bodies.end(), [](const Body& b) { return b.deforms(); });
  if (!model.bodies.empty())
    fmt::print("bodies: {} ({} moving, {} floating{}), {} boundary particles\n", model.bodies.size(),
               std::count_if(model.bodies.begin(), model.bodies.end(), [](const Body& b) { return b.moves(); }),
               std::count_if(model.bodies.begin(), model.bodies.end(), [](const Body& b) { return b.dynamic; }),
               deforming > 0 ? fmt::format(", {} deforming", deforming) : "", model.boundary.count());
}

std::string with_unit(const FabricValue& v) {
  const std::string grams =
      v.key == "areal_density" ? fmt::format(" = {:.4g} g/m²", 1000 * std::strtod(v.value.c_str(), nullptr)) : "";
  return fmt::format("{} {}{}{}{}", v.key, v.value, v.unit.empty() ? "" : " ", v.unit, grams);
}

/// The values that a cloth has from its fabric, each with how it is known.
void print_fabrics(const std::vector<FabricUse>& uses, const Scene& scene) {
  for (const FabricUse& use : uses) {
    const ClothScene& cloth = scene.cloths[use.cloth];
    fmt::print(
        "fabric {} of {}cloth {}:\n", use.fabric,
        use.region < 0 ? "" : region_label(cloth.regions[static_cast<std::size_t>(use.region)], use.region) + " of ",
        cloth.name);
    for (std::size_t k = 0; k < use.given.size();) {  // neighbours that are known in the same way share a line
      const std::string basis = basis_of(use.given[k]);
      std::string line = with_unit(use.given[k++]);
      while (k < use.given.size() && basis_of(use.given[k]) == basis) line += ", " + with_unit(use.given[k++]);
      fmt::print("  {} ({})\n", line, basis);
    }
    std::string own;
    for (const auto* not_taken : {&use.own, &use.whole})
      for (const FabricValue& v : *not_taken) own += (own.empty() ? "" : ", ") + v.key;
    if (!own.empty()) fmt::print("  not used: {}\n", own);
  }
}

void warn_of_dry_fabrics(const std::vector<FabricUse>& uses, const Scene& scene, std::vector<std::string>& warnings) {
  for (const FabricUse& use : uses)
    if (use.dry && scene.fluid.present && use.region < 0)
      warnings.push_back(
          fmt::format("cloth {} absorbs no liquid, although its fabric {} is absorbent: add the key porous (porous: "
                      "{{}} is enough)",
                      scene.cloths[use.cloth].name, use.fabric));
}

/// The ranks' particles, as the liquid lies at the start.
void print_ranks(const Setup& setup, int ranks) {
  const double n = static_cast<double>(setup.state.fluid_count());
  if (n > 0) {
    const SpreadLiquid liquid = spread_over_ranks(setup, ranks);
    const RankShare fullest = liquid.fullest();
    double ghosts = 0;
    for (const double g : liquid.ghosts) ghosts += g / ranks;
    fmt::print("ranks: {}, with {:.0f} particles each on average; the fullest has {:.0f} and {:.0f} ghosts\n", ranks,
               n / ranks, fullest.part * n, fullest.ghosts(n));
    fmt::print("ghosts (copies of other ranks' particles): {:.0f} per rank on average, {:.0f} at most\n", ghosts,
               *std::max_element(liquid.ghosts.begin(), liquid.ghosts.end()));
  } else {
    fmt::print("ranks: {}; the scene starts without liquid: shares are estimated for a compact volume\n", ranks);
  }
  if (setup.model.has_cloth() || !setup.model.bodies.empty())
    fmt::print("replicated: every rank computes all cloth and bodies\n");
}

/// `ranks`: of how many the memory of the fullest is told.
void print_memory(const ForeseenMemory& memory, const MemoryBudget& budget, int ranks) {
  const MemoryEstimate& m = memory.start;
  fmt::print(
      "memory{}: about {}: liquid {}, neighbour lists {}, cell tables {}, bodies {}, cloth {}; plus {} for set-up "
      "and frames{}\n",
      ranks > 1 ? " of the fullest rank" : "", mebibytes(m.backend()), mebibytes(m.particles), mebibytes(m.lists),
      mebibytes(m.cells), mebibytes(m.bodies), mebibytes(m.cloth), mebibytes(m.host),
      budget.device.empty() ? "" : fmt::format("; {} has {} free", budget.device, mebibytes(budget.device_free)));
  if (memory.grows())
    fmt::print(
        "memory at the end: about {}, assuming {}liquid at all cloth and walls and 1.2 times as many neighbours\n",
        mebibytes(memory.end),
        memory.added >= 1 ? fmt::format("{:.0f} more particles from jets and dripping cloth, ", memory.added) : "");
  if (memory.folds())
    fmt::print("memory with folded cloth: about {}, assuming a hundred self-contact pairs per node\n",
               mebibytes(memory.folded));
  if (ranks > 1)
    fmt::print(
        "assumed: liquid keeps its initial shape, and a rank holds up to a tenth more than the mean before the domain "
        "is "
        "divided again; every rank sets up the whole scene, only rank 0 gathers frames\n");
}

void print_step(const Model& model, const HostState& state) {
  const TimeScene& time = model.scene.time;
  if (!model.has_moving_liquid()) {
    fmt::print("time step: {}{:.4g} s\n", model.has_fluid() && time.mode == TimeMode::cfl ? "at most " : "", time.step);
    return;
  }
  const auto [fastest, impact] = expected_speeds(model, state);
  if (time.mode == TimeMode::cfl) {
    double dt = time.step;
    if (fastest > 0) dt = std::min(dt, time.cfl * model.spacing / fastest);
    fmt::print("time step: {:.4g} s, down to {:.4g} s at {:.3g} m/s (fastest expected), CFL number {}\n", time.step,
               std::min(dt, model.capillary_step()), fastest, time.cfl);
    return;
  }
  if (time.mode == TimeMode::error) {
    fmt::print("time step: {:.4g} s, down to {:.4g} s if a step would leave more than {:.3g} % compression\n",
               std::min(time.step, model.capillary_step()), time.step / 100, 100 * time.tolerance);
    return;
  }
  const double spacings = time.step / model.spacing;
  fmt::print(
      "time step: {:.4g} s; at {:.3g} m/s (fastest expected) {:.2g} spacings per step, at {:.3g} m/s (where liquid "
      "hits, "
      "enters "
      "or is pushed) {:.2g} (CFL number)\n",
      time.step, fastest, fastest * spacings, impact, impact * spacings);
}

/// 3 s, 2 min, 5 h
std::string in_words(double seconds) {
  if (seconds < 120) return fmt::format("{:.3g} s", seconds);
  return seconds < 7200 ? fmt::format("{:.3g} min", seconds / 60) : fmt::format("{:.3g} h", seconds / 3600);
}

/// What evaporates, and how long full cloth takes (docs/theory/evaporation.md, Eqs. 1 and 9).
void print_drying(const Model& model) {
  const double flux = model.evaporation_flux / (1 + model.cooling);
  fmt::print("air: a wet surface loses {:.3g} kg/(m² h)\n", 3600 * model.evaporation_flux);
  if (model.cooling > 0)
    fmt::print("air: wet cloth cools to {:.3g} °C and loses {:.3g} kg/(m² h)\n", model.wet_bulb, 3600 * flux);
  for (const ClothMaterial& c : model.cloths) {
    if (!c.porous || !model.has_drying()) continue;
    constexpr double dry = 0.05;
    const double fall = 2 * flux / ((1 - c.solid_fraction) * c.thickness * model.rest_density),
                 critical = c.critical_saturation;
    const double constant = (1 - std::max(critical, dry)) / fall,
                 falling = critical > dry ? critical / fall / (1 + model.cooling) *
                                                (std::log(critical / dry) + model.cooling * (1 - dry / critical))
                                          : 0;
    fmt::print("drying of {}: full cloth takes {} to saturation {:.3g} and {} to {:.3g}, with both sides in air\n",
               c.name, in_words(constant), std::max(critical, dry), in_words(constant + falling), dry);
  }
}

}  // namespace

int check_command(const CheckOptions& options) {
  if (options.threads > 0)
    setenv("OMP_NUM_THREADS", std::to_string(options.threads).c_str(), 1);  // host_threads reads it
  const Scene scene = load_scene(options.scene, options.overrides);
  MemoryBudget budget = host_memory_budget(4);
  std::string no_device;
  try {
    budget = memory_budget();
  } catch (const DeviceError& e) {  // a scene can be checked without one
    no_device = e.what();
  }
  const Setup setup = build(scene, memory_budget_of_rank(budget, share_of_rank(scene, options.ranks)));
  budget = memory_budget_of_rank(budget, share_of_rank(setup, options.ranks));
  const ForeseenMemory memory = foresee_memory(setup, budget);
  refuse_too_large(memory.size, budget);  // now that the lists' entries are counted
  const Model& model = setup.model;
  auto warnings = setup.warnings;
  if (!no_device.empty()) warnings.push_back(no_device);
  if (std::string late = memory.too_large_later(budget); !late.empty()) warnings.push_back(std::move(late));
  fmt::print("scene: {}\n", options.scene);
  print_parts(model, setup.state);
  for (const std::string& line : setup.notes) fmt::print("{}\n", line);
  print_loops(model);
  const std::vector<FabricUse> fabrics = fabrics_used(options.scene, options.overrides);
  print_fabrics(fabrics, scene);
  warn_of_dry_fabrics(fabrics, scene, warnings);
  std::string stages;
  for (const Stage s : stages_for(model)) stages += fmt::format(" {}", name_of(s));
  fmt::print("stages:{}\n", stages);
  if (options.ranks > 1 && model.has_moving_liquid()) print_ranks(setup, options.ranks);
  print_memory(memory, budget, model.has_moving_liquid() ? options.ranks : 1);

  print_step(model, setup.state);
  fmt::print("steps: {}{:.0f} to {:.4g} s\n", scene.time.mode != TimeMode::fixed ? "at least " : "",
             std::ceil(scene.time.end / scene.time.step - 1e-9), scene.time.end);
  if (const double passes = model.has_moving_liquid() ? viscous_passes(model, scene.time.step) : 0; passes > 1)
    fmt::print("viscosity: about {:.0f} passes per step\n", passes);
  if (const double passes = model.has_micropolar() ? spin_passes(model, scene.time.step) : 0; passes > 1)
    fmt::print("micropolar: about {:.0f} passes per step\n", passes);
  for (const ClothMaterial& c : model.cloths)
    if (model.has_diffusion() && c.wicks()) {
      const double substeps = substeps_for(diffusion_rate(model, c), scene.time.step);
      fmt::print("diffusion in {}: about {:.0f} sub-step{} per step\n", c.name, substeps, substeps > 1 ? "s" : "");
    }
  if (scene.air.present) print_drying(model);
  for (const std::string& w : warnings) fmt::print("warning: {}\n", w);
  return exit_done;
}

}  // namespace drench
