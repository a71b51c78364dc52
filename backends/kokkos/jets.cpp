// Stage jets (src/stages/jets.hpp). The host decides how many layers leave; their particles are written on the device.

#include "device.hpp"

namespace drench::kokkos_backend {

void jets(Device& d, const StepInfo& info, StepReport&) {
  const double end = info.time + info.dt;
  for (std::size_t j = 0; j < d.model.jets.size(); ++j) {
    const Jet& jet = d.model.jets[j];
    const auto size = static_cast<Index>(jet.offsets.size());
    const Array<Real3> offsets = d.jet_offsets[j];
    const auto& c = jet.scene.center;
    const auto& u = jet.scene.velocity;
    const Real3 center{Real(c[0]), Real(c[1]), Real(c[2])}, velocity{Real(u[0]), Real(u[1]), Real(u[2])};
    for (;; ++d.jet_layers[j]) {
      const double leaves = jet.scene.start + double(d.jet_layers[j]) * jet.layer_interval;
      if (leaves > end || leaves >= jet.scene.end) break;
      const Index first = d.fluid.count;
      d.reserve_fluid(first + size);
      const FluidArrays f = d.fluid;
      const std::int64_t id = d.next_id;
      const Real flight = Real(end - leaves);
      parallel(
          "drench::jets::layer", size, KOKKOS_LAMBDA(const Index k) {
            const Index i = first + k;
            f.position(i) = center + offsets(k) + flight * velocity;
            f.velocity(i) = velocity;
            f.mass(i) = quanta_per_particle;
            f.id(i) = id + k;
            f.age(i) = 0;
            f.origin(i) = static_cast<std::uint8_t>(Origin::jet);
            f.density_ratio(i) = 0;
            f.kappa_density(i) = 0;
            f.kappa_divergence(i) = 0;
          });
      d.fluid.count = first + size;
      d.next_id += size;
      d.supplied += static_cast<Quanta>(size) * quanta_per_particle;
    }
  }
}

}  // namespace drench::kokkos_backend
