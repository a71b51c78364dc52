#include "step/kept_state.hpp"

namespace drench::kokkos_backend {
namespace {

using Bytes = Kokkos::View<std::byte*, MemSpace, Kokkos::MemoryTraits<Kokkos::Unmanaged>>;

/// The memory of an array's first `rows` entries.
template <class T>
Bytes memory_of(const Array<T>& a, Index rows) {
  return Bytes(reinterpret_cast<std::byte*>(a.data()), static_cast<std::size_t>(rows) * sizeof(T));
}

/// Calls visit(bytes) for each array of the state that exists and changes, always in the same order.
template <class Visitor>
void visit_state(const Fluid& fluid, const Bodies& bodies, const Cloth& cloth, Index particles, Visitor&& visit) {
  const auto field = [&](const auto& a, Index rows) {
    if (a.extent(0) > 0 && rows > 0) visit(memory_of(a, rows));
  };
#define DRENCH_PARTICLE(owner, name, type, unit, needed) field(fluid.particles.name, particles);
  DRENCH_PARTICLE_FIELDS(DRENCH_PARTICLE)
#undef DRENCH_PARTICLE
#define DRENCH_NODE(owner, name, type, unit, needed) field(cloth.nodes.name, cloth.nodes.count);
  DRENCH_NODE_FIELDS(DRENCH_NODE)
#undef DRENCH_NODE
#define DRENCH_SAMPLE(owner, name, type, unit, needed) field(cloth.samples.name, cloth.samples.count);
  DRENCH_SAMPLE_FIELDS(DRENCH_SAMPLE)
#undef DRENCH_SAMPLE
  if (!bodies.state.exists()) return;  // none moves
  field(bodies.state, bodies.count);
#define DRENCH_BOUNDARY(owner, name, type, unit, needed) field(bodies.boundary.name, bodies.boundary.count);
  DRENCH_BOUNDARY_FIELDS(DRENCH_BOUNDARY)
#undef DRENCH_BOUNDARY
}

}  // namespace

void KeptState::keep(Fluid& fluid, Bodies& bodies, Cloth& cloth, const Accounts& accounts, const Jets& jets) {
  particles_ = fluid.particles.count;
  next_id_ = fluid.particles.next_id;
  accounts_ = accounts;
  jet_particles_ = jets.particles;
  std::size_t k = 0;
  visit_state(fluid, bodies, cloth, particles_, [&](const Bytes& bytes) {
    if (k == arrays_.size()) arrays_.emplace_back();
    make_ample_room(arrays_[k], "drench::kept_state", bytes.extent(0));
    Kokkos::deep_copy(exec(), Bytes(arrays_[k].data(), bytes.extent(0)), bytes);
    ++k;
  });
}

void KeptState::go_back(Fluid& fluid, Bodies& bodies, Cloth& cloth, Accounts& accounts, Jets& jets) const {
  fluid.particles.count = particles_;
  fluid.particles.ghosts = 0;
  fluid.particles.next_id = next_id_;
  accounts = accounts_;
  jets.particles = jet_particles_;
  std::size_t k = 0;
  visit_state(fluid, bodies, cloth, particles_, [&](const Bytes& bytes) {
    Kokkos::deep_copy(exec(), bytes, Bytes(arrays_[k].data(), bytes.extent(0)));
    ++k;
  });
  if (bodies.dynamic.count > 0) Kokkos::deep_copy(exec(), bodies.dynamic.predicted, bodies.boundary.velocity);
  // A step that failed between advection and the ledger leaves what it has counted.
  if (fluid.tunnelled.data() != nullptr) Kokkos::deep_copy(exec(), fluid.tunnelled, Tunnelled{});
  fluid.particles.moved.advance();
  cloth.moved.advance();
  cloth.soaked.advance();
  bodies.moved.advance();
}

MemoryEstimate kept_state_bytes(const Sizing& m) {
  MemoryEstimate sum;
  if (m.size.scene.time.mode != TimeMode::error) return sum;
  double particle = 0, node = 0, sample = 0, boundary = 0;
#define DRENCH_PARTICLE(owner, name, host_type, unit, needed) \
  if (needed) particle += m.entry<host_type>();
  DRENCH_PARTICLE_FIELDS(DRENCH_PARTICLE)
#undef DRENCH_PARTICLE
#define DRENCH_NODE(owner, name, host_type, unit, needed) \
  if (needed) node += m.entry<host_type>();
  DRENCH_NODE_FIELDS(DRENCH_NODE)
#undef DRENCH_NODE
#define DRENCH_SAMPLE(owner, name, host_type, unit, needed) sample += m.entry<host_type>();
  DRENCH_SAMPLE_FIELDS(DRENCH_SAMPLE)
#undef DRENCH_SAMPLE
#define DRENCH_BOUNDARY(owner, name, host_type, unit, needed) boundary += m.entry<host_type>();
  DRENCH_BOUNDARY_FIELDS(DRENCH_BOUNDARY)
#undef DRENCH_BOUNDARY
  sum.particles = particle_room(m) * particle;
  sum.cloth = 1.25 * (m.size.nodes * node + m.size.samples * sample);
  sum.bodies = 1.25 * m.size.boundary * boundary;  // of bodies that stand still none
  return sum;
}

}  // namespace drench::kokkos_backend
