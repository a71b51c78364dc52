// Stage jets (src/stages/jets.hpp). The host decides how many particles leave; their particles are written on the device.

#include "device.hpp"

namespace drench::kokkos_backend {

void jets(Device& d, const StepInfo& info, StepReport&) {
  const double end = info.time + info.dt;
  for (std::size_t j = 0; j < d.model.jets.size(); ++j) {
    const Jet& jet = d.model.jets[j];
    const std::int64_t gone = d.jet_particles[j];
    std::int64_t& q = d.jet_particles[j];
    for (;; ++q) {
      const double leaves = jet.scene.start + (double(q) + 0.5) * jet.interval;
      if (leaves > end || leaves >= jet.scene.end) break;
    }
    const auto count = static_cast<Index>(q - gone), size = static_cast<Index>(jet.offsets.size());
    if (count == 0) continue;
    const Array<Real3> offsets = d.jet_offsets[j];
    const auto &c = jet.scene.center, &u = jet.scene.velocity;
    const Real3 center{Real(c[0]), Real(c[1]), Real(c[2])}, velocity{Real(u[0]), Real(u[1]), Real(u[2])};
    const Index first = d.fluid.count, first_offset = static_cast<Index>(gone % size);
    d.reserve_fluid(first + count);
    const FluidArrays f = d.fluid;
    const std::int64_t id = d.next_id;
    const double first_flight = end - (jet.scene.start + (double(gone) + 0.5) * jet.interval), interval = jet.interval;
    parallel(
        "drench::jets::particles", count, KOKKOS_LAMBDA(const Index k) {
          const Index i = first + k;
          const Real flight = Real(first_flight - k * interval);
          f.position(i) = center + offsets((first_offset + k) % size) + flight * velocity;
          f.velocity(i) = velocity;
          f.mass(i) = quanta_per_particle;
          f.id(i) = id + k;
          f.age(i) = 0;
          f.origin(i) = static_cast<std::uint8_t>(Origin::jet);
          f.density_ratio(i) = 0;
          f.kappa_density(i) = 0;
          f.kappa_divergence(i) = 0;
        });
    d.clear_spins(first, count);
    d.fluid.count = first + count;
    d.next_id += count;
    d.supplied += static_cast<Quanta>(count) * quanta_per_particle;
  }
}

}  // namespace drench::kokkos_backend
