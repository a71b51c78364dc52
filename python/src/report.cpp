// The numbers of a step as a dict.

#include <algorithm>

#include "module.hpp"

namespace drench::python {
namespace {

nb::dict to_dict(const SomeParticles& some) {
  nb::list ids;
  for (std::int64_t k = 0; k < std::min<std::int64_t>(some.count, std::ssize(some.lowest)); ++k)
    ids.append(some.lowest[static_cast<std::size_t>(k)]);
  nb::dict d;
  d["count"] = some.count;
  d["lowest"] = ids;
  return d;
}

nb::dict to_dict(const FabricNumbers& f) {
  nb::dict d;
#define DRENCH_NUMBER(name) d[#name] = f.name;
  DRENCH_NUMBER(cloth)
  DRENCH_NUMBER(liquid)
  DRENCH_NUMBER(taken_front)
  DRENCH_NUMBER(taken_back)
  DRENCH_NUMBER(given_front)
  DRENCH_NUMBER(given_back)
  DRENCH_NUMBER(wet_area)
  DRENCH_NUMBER(wet_warp)
  DRENCH_NUMBER(wet_weft)
#undef DRENCH_NUMBER
  d["through"] = f.through();
  d["returned"] = f.returned();
  return d;
}

}  // namespace

nb::dict to_dict(const StepReport& r) {
  nb::dict d;
#define DRENCH_NUMBER(name) d[#name] = r.name;
  DRENCH_NUMBER(step)
  DRENCH_NUMBER(time)
  DRENCH_NUMBER(dt)
  DRENCH_NUMBER(dt_wanted)
  DRENCH_NUMBER(divergence_iterations)
  DRENCH_NUMBER(divergence_error)
  DRENCH_NUMBER(divergence_converged)
  DRENCH_NUMBER(density_iterations)
  DRENCH_NUMBER(density_error)
  DRENCH_NUMBER(density_error_max)
  DRENCH_NUMBER(density_converged)
  DRENCH_NUMBER(density_found)
  DRENCH_NUMBER(rejected)
  DRENCH_NUMBER(viscosity_stages)
  DRENCH_NUMBER(micropolar_stages)
  DRENCH_NUMBER(cloth_iterations)
  DRENCH_NUMBER(cloth_residual)
  DRENCH_NUMBER(cloth_converged)
  DRENCH_NUMBER(cloth_contacts)
  DRENCH_NUMBER(cloth_zone_nodes)
  DRENCH_NUMBER(diffusion_substeps)
  DRENCH_NUMBER(collisions)
  DRENCH_NUMBER(clamped)
  DRENCH_NUMBER(mass_fluid)
  DRENCH_NUMBER(mass_cloth)
  DRENCH_NUMBER(mass_drained)
  DRENCH_NUMBER(mass_supplied)
  DRENCH_NUMBER(mass_evaporated)
  DRENCH_NUMBER(solute_fluid)
  DRENCH_NUMBER(solute_cloth)
  DRENCH_NUMBER(solute_drained)
  DRENCH_NUMBER(solute_supplied)
  DRENCH_NUMBER(solute_deposited)
  DRENCH_NUMBER(mass_float)
  DRENCH_NUMBER(saturation_max)
  DRENCH_NUMBER(saturation_error)
  DRENCH_NUMBER(kinetic_energy)
  DRENCH_NUMBER(particles)
  DRENCH_NUMBER(nonfinite)
  DRENCH_NUMBER(imbalance)
  DRENCH_NUMBER(cuts)
  DRENCH_NUMBER(nearest_variance)
  DRENCH_NUMBER(close_share)
  DRENCH_NUMBER(wet_isotropy)
  DRENCH_NUMBER(fluid_speed)
  DRENCH_NUMBER(cloth_speed)
  DRENCH_NUMBER(cloth_stretch)
  DRENCH_NUMBER(tunnelled)
  DRENCH_NUMBER(lowest_tunnelled)
  DRENCH_NUMBER(escaped_speed)
#undef DRENCH_NUMBER
  d["mass_total"] = r.mass_total();
  d["solute_total"] = r.solute_total();
  d["escaped"] = to_dict(r.escaped);
  nb::list fabrics;
  for (const FabricNumbers& f : r.fabrics) fabrics.append(to_dict(f));
  d["fabrics"] = fabrics;
  return d;
}

}  // namespace drench::python
