// The liquid's arrays: how they grow, lose particles and change their order.

#include <algorithm>

#include "device.hpp"

namespace drench::kokkos_backend {
namespace {

template <class T>
void resize_keeping(Array<T>& a, Index n) {
  Array<T> bigger(Kokkos::ViewAllocateWithoutInitializing(a.label().empty() ? "drench::fluid" : a.label()), n);
  const auto kept = static_cast<Index>(std::min<std::size_t>(a.extent(0), static_cast<std::size_t>(n)));
  if (kept > 0)
    Kokkos::deep_copy(Kokkos::subview(bigger, Kokkos::make_pair(Index(0), kept)),
                      Kokkos::subview(a, Kokkos::make_pair(Index(0), kept)));
  a = bigger;
}

/// Particle i becomes what source(i) was, for i < n; source(i) becomes i.
void gather(Device& d, const Array<Index>& source, Index n) {
  const FluidArrays& from = d.fluid;
  FluidArrays& to = d.reorder.spare;
  const std::size_t capacity = from.position.extent(0);
  to.spins = from.spins;
  if (to.position.extent(0) != capacity) {
    visit_arrays(to, [capacity](auto& a) {
      a = {};
      a = std::decay_t<decltype(a)>(Kokkos::ViewAllocateWithoutInitializing("drench::fluid"), capacity);
    });
  }
  const Slice<Real3> x = from.position, v = from.velocity, x_to = to.position, v_to = to.velocity;
  const Slice<Quanta> mass = from.mass, mass_to = to.mass;
  const Slice<std::int64_t> id = from.id, id_to = to.id;
  const Slice<Real> age = from.age, ratio = from.density_ratio, pressure = from.kappa_density,
                    divergence = from.kappa_divergence, age_to = to.age, ratio_to = to.density_ratio,
                    pressure_to = to.kappa_density, divergence_to = to.kappa_divergence;
  const Slice<std::uint8_t> origin = from.origin, origin_to = to.origin;
  const Slice<Index> of = source;
  const Entries<Real3> spin = from.spin, spin_to = to.spin;
  const bool spins = from.spins;
  parallel(
      "drench::fluid::gather", n, KOKKOS_LAMBDA(const Index i) {
        // All loads before the first store, which might be to the same memory for all that the compiler knows.
        const Index j = of(i);
        const Real3 xj = x(j), vj = v(j);
        const Quanta mj = mass(j);
        const std::int64_t name = id(j);
        const Real a = age(j), r = ratio(j), kp = pressure(j), kd = divergence(j);
        const std::uint8_t o = origin(j);
        const Real3 w = spins ? spin(j) : Real3{};
        x_to(i) = xj;
        v_to(i) = vj;
        mass_to(i) = mj;
        id_to(i) = name;
        age_to(i) = a;
        origin_to(i) = o;
        ratio_to(i) = r;
        pressure_to(i) = kp;
        divergence_to(i) = kd;
        if (spins) spin_to(i) = w;
        of(i) = i;
      });
  to.count = n;
  std::swap(d.fluid, d.reorder.spare);
}

}  // namespace

void Device::reserve_fluid(Index n) {
  if (n <= static_cast<Index>(fluid.position.extent(0))) return;
  const Index capacity = n + n / 4 + 64;
  visit_arrays(fluid, [capacity](auto& a) { resize_keeping(a, capacity); });
  const auto fresh = [capacity](auto& a, const char* label) {
    a = {};
    a = std::decay_t<decltype(a)>(Kokkos::ViewAllocateWithoutInitializing(label), capacity);
  };
  fresh(work.predicted, "drench::fluid_predicted");
  resize_keeping(work.place, capacity);
  fresh(work.rate, "drench::fluid_rate");
  fresh(work.kappa_next, "drench::fluid_kappa_next");
  fresh(work.kappa_last, "drench::fluid_kappa_last");
  fresh(work.active, "drench::fluid_active");
  resize_keeping(work.volume, capacity);
  resize_keeping(work.alpha, capacity);
  resize_keeping(work.compliance, capacity);
  resize_keeping(work.shift, capacity);
}

void Device::compact_fluid(const Array<std::uint8_t>& gone, Index kept) {
  const Index n = fluid.count;
  if (n == 0) return;
  if (reorder.source.extent(0) < fluid.position.extent(0))
    reorder.source =
        Array<Index>(Kokkos::ViewAllocateWithoutInitializing("drench::compact_source"), fluid.position.extent(0));
  const auto source = reorder.source;
  const auto mass = fluid.mass;
  const bool flagged = gone.extent(0) > 0;
  const auto number = KOKKOS_LAMBDA(const Index i, Index& rank, const bool last) {
    const bool stays = mass(i) > 0 && !(flagged && gone(i));
    if (last && stays) source(rank) = i;
    rank += stays ? 1 : 0;
  };
  if (kept < 0)
    Kokkos::parallel_scan("drench::compact::scan", Range(0, n), number, kept);
  else if (kept < n)
    Kokkos::parallel_scan("drench::compact::scan", Range(0, n), number);
  if (kept == n) return;
  gather(*this, source, kept);
}

void Device::clear_spins(Index first, Index count) {
  if (!fluid.spins) return;
  const auto spin = fluid.spin;
  parallel(
      "drench::micropolar::clear", count, KOKKOS_LAMBDA(const Index k) { spin(first + k) = {}; });
}

void Device::order_fluid_by_cell() {
  if (fluid.count == 0) return;
  gather(*this, fluid_cells.view().item, fluid.count);
}

}  // namespace drench::kokkos_backend
