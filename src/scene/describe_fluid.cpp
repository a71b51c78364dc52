// The liquid of a scene.

#include <fmt/format.h>

#include <cmath>

#include "scene/describe.hpp"

namespace drench {

/// An entry of `sources`: one of the two.
struct SourceScene {
  std::optional<BlockScene> block;
  std::optional<JetScene> jet;
};

void describe(Section& s, SourceScene& source) {
  s.one_of().section("block", source.block, "a box that is full of liquid at the start");
  s.one_of().section("jet", source.jet, "a round nozzle that liquid comes out of");
}

void describe(Section& s, MicropolarScene& micropolar) {
  s.one_line();
  s.number("transfer", micropolar.transfer, "(0, 10]", "m²/s", "ν_t: how fast spins and flow drive each other");
  s.number("inertia", micropolar.inertia, "[0.01, 1e4]", "spacings²",
           "Θ: moment of inertia per mass; longer waves than 2π√Θ are fed most");
  s.number("viscosity", micropolar.viscosity, "[0, 10]", "m²/s", "ζ: how fast spin spreads");
  s.number("reaction", micropolar.reaction, "[0, 1]", "1",
           "a: the part of what winds spins up that the flow pays; 1: no energy from nowhere");
}

void describe(Section& s, FluidSolverScene& solver) {
  s.one_line();
  s.number("density_error", solver.density_error, "[1e-15, 0.5]", "1", "mean compression that ends the density solve");
  s.number("divergence_error", solver.divergence_error, "[1e-15, 0.5]", "1",
           "mean rate of compression times Δt that ends the divergence solve");
  s.integer("max_iterations", solver.max_iterations, "[1, 100000]", "iterations", "most iterations of either solve");
  s.integer("min_iterations", solver.min_iterations, "[0, 100000]", "iterations",
            "fewest iterations of either solve; at most `max_iterations`");
  s.number("density_correction", solver.density_correction, "[0.5, 1]", "1",
           "c: correction factor, the part of a density error that a step corrects; 1 for fast flows in long steps");
  s.number("source_error", solver.source_error, "(0, 1]", "1",
           "η: the density solve goes on until no more than this part of the step's own compression is left; without it none");
  s.check(solver.min_iterations <= solver.max_iterations, s.has("min_iterations") ? "min_iterations" : "max_iterations",
          fmt::format("min_iterations ({}) is above max_iterations ({}); allowed: at most that", solver.min_iterations,
                      solver.max_iterations));
}

void describe(Section& s, BlockScene& block) {
  describe(s, block.box);
  s.numbers("velocity", block.velocity, speed_range, "m/s", "of its particles at the start");
  s.number("concentration", block.concentration, concentration_range, "kg/kg",
           "of a solute (dye, detergent) in its liquid");
}

/// Between two keys the axis turns the short way, which opposite directions do not have.
void check_turns(Section& s, const Keyed<Vec3>& velocity) {
  const Vec3* before = nullptr;
  for (std::size_t k = 0; k < velocity.keys().size(); ++k) {
    const Vec3& v = velocity.keys()[k].value;
    const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (square == 0) continue;
    if (before) {
      const Vec3& u = *before;
      const double cosine = (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) /
                            std::sqrt(square * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]));
      s.check(cosine > -0.9, fmt::format("velocity.{}", k),
              "points back against the entry before; allowed: angles below 154 degrees, or a jet for each direction");
    }
    before = &v;
  }
}

void describe(Section& s, JetScene& jet) {
  s.one_line();
  s.required().numbers("center", jet.center, coordinate_range, "m", "of the nozzle, inside the domain");
  s.required().number("radius", jet.radius, "[1e-6, 100]", "m", "of the nozzle; at least half a spacing");
  s.required().numbers("velocity", jet.velocity, speed_range, "m/s", "of the liquid, along the nozzle's axis; not 0 but in keys, "
                                                                "where 0 closes it");
  s.number("start", jet.start, "[0, 1e6]", "s", "when it starts to flow");
  s.number("end", jet.end, "[0, inf]", "s", "when it stops; after `start`");
  s.number("concentration", jet.concentration, concentration_range, "kg/kg",
           "of a solute (dye, detergent) in its liquid");
  check_not_zero(s, "velocity", jet.velocity);
  check_turns(s, jet.velocity);
  check_end_after_start(s, "the jet", jet.start, jet.end);
}

void describe(Section& s, FluidScene& fluid) {
  s.number("spacing", fluid.spacing, "[1e-6, 10]", "m",
           "d, the particles' diameter and distance; what it costs goes with 1/d³, or faster");
  s.number("density", fluid.density, "[1, 30000]", "kg/m³", "rest density");
  s.number("viscosity", fluid.viscosity, "[0, 100]", "m²/s", "kinematic viscosity ν; water 1e-6");
  s.number("surface_tension", fluid.surface_tension, "[0, 10]", "N/m", "γ; water 0.072");
  s.choice("kernel", fluid.kernel,
           {{"cubic", KernelKind::cubic}, {"wendland", KernelKind::wendland}, {"poly6", KernelKind::poly6}},
           "smoothing kernel");
  // below 1.8, a full neighbourhood has too few (kernel.hpp)
  s.number("support", fluid.support, "[1.8, 4]", "spacings", "radius h of the kernel over the spacing");
  s.remark("h / spacing");
  s.choice("wall_pressure", fluid.wall_pressure,
           {{"mirrored", WallPressure::mirrored}, {"extrapolated", WallPressure::extrapolated}},
           "of solids: the particle's own, or extrapolated along the wall by its gradient");
  s.optional(fluid.micropolar.present)
      .section("micropolar", fluid.micropolar,
               "particles spin and drive the flow: livelier swirls; without it there are no spins");
  s.remark("m²/s, spacings², m²/s, 1");
  s.section("solver", fluid.solver, "when the pressure solves end");

  std::vector<SourceScene> sources;
  for (const BlockScene& block : fluid.blocks) sources.push_back({block, {}});
  for (const JetScene& jet : fluid.jets) sources.push_back({{}, jet});
  s.list("sources", sources, "where the liquid comes from; may be left out only beside porous cloth, which can drip");
  fluid.blocks.clear();
  fluid.jets.clear();
  for (const SourceScene& source : sources) {
    if (source.block) fluid.blocks.push_back(*source.block);
    if (source.jet) fluid.jets.push_back(*source.jet);
  }
}

}  // namespace drench
