// Stage jets (src/stages/jets.hpp). The host decides how many particles leave; their particles are written on the device.

#include "fluid/stages.hpp"

namespace drench::kokkos_backend {

void jets(const Constants& constants, Fluid& fluid, Jets& jets, Accounts& accounts, const StepInfo& info) {
  ParticleSet& particles = fluid.particles;
  const double end = info.time + info.dt;
  for (std::size_t j = 0; j < constants.model.jets.size(); ++j) {
    const Jet& jet = constants.model.jets[j];
    const std::int64_t gone = jets.particles[j];
    std::int64_t& q = jets.particles[j];
    for (;; ++q) {
      const double leaves = jet.scene.start + (double(q) + 0.5) * jet.interval;
      if (leaves > end || leaves >= jet.scene.end) break;
    }
    const auto count = static_cast<Index>(q - gone), size = static_cast<Index>(jet.offsets.size());
    if (count == 0) continue;
    const Array<Real3> offsets = jets.offsets[j];
    const auto &c = jet.scene.center, &u = jet.scene.velocity;
    const Real3 center{Real(c[0]), Real(c[1]), Real(c[2])}, velocity{Real(u[0]), Real(u[1]), Real(u[2])};
    const Index first = particles.count, first_offset = static_cast<Index>(gone % size);
    particles.reserve(first + count);
    const ParticleView all = particles.view();
    const std::int64_t id = particles.next_id;
    const double first_since = end - (jet.scene.start + (double(gone) + 0.5) * jet.interval), interval = jet.interval;
    parallel(
        "drench::jets::particles", count, KOKKOS_LAMBDA(const Index k) {
          const Real since = Real(first_since - k * interval);
          Particle p;
          p.position = center + offsets((first_offset + k) % size) + since * velocity;
          p.velocity = velocity;
          p.mass = quanta_per_particle;
          p.id = id + k;
          p.origin = static_cast<std::uint8_t>(Origin::jet);
          all.store(first + k, p);
        });
    particles.count = first + count;
    particles.next_id += count;
    accounts.supplied += static_cast<Quanta>(count) * quanta_per_particle;
  }
}

}  // namespace drench::kokkos_backend
