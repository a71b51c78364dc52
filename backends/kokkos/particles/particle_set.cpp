// The liquid's arrays: how they come and go, grow, lose particles and change their order.

#include "particles/particle_set.hpp"

#include <algorithm>
#include <numeric>

#include "core/host_copy.hpp"

namespace drench::kokkos_backend {
namespace {

template <class T>
void resize_keeping(Field<T>& a, const char* label, Index n) {
  Field<T> bigger(Kokkos::ViewAllocateWithoutInitializing(label), n);
  const auto kept = static_cast<Index>(std::min<std::size_t>(a.extent(0), static_cast<std::size_t>(n)));
  if (kept > 0)
    copy_now(Kokkos::subview(bigger, Kokkos::make_pair(Index(0), kept)),
             Kokkos::subview(a, Kokkos::make_pair(Index(0), kept)));
  a = std::move(bigger);
}

/// The places of `id`'s values in ascending order.
std::vector<Index> places_by_id(const std::vector<std::int64_t>& id) {
  std::vector<Index> place(id.size());
  std::iota(place.begin(), place.end(), Index{0});
  std::stable_sort(place.begin(), place.end(),
                   [&](Index a, Index b) { return id[static_cast<std::size_t>(a)] < id[static_cast<std::size_t>(b)]; });
  return place;
}

/// Puts `values` into the order that `place` says, the k-th being values[place[k]].
template <class T>
void arrange(std::vector<T>& values, const std::vector<Index>& place) {
  std::vector<T> ordered(values.size());
  for (std::size_t k = 0; k < values.size(); ++k) ordered[k] = values[static_cast<std::size_t>(place[k])];
  values = std::move(ordered);
}

/// Particle i of `to` becomes what `source(i)` was; `source(i)` becomes i.
void copy_from(const ParticleView& from, const Entries<Index>& source, Index n, const ParticleView& to) {
  parallel(
      "drench::fluid::gather", n, KOKKOS_LAMBDA(const Index i) {
        to.store(i, from.load(source(i)));
        source(i) = i;
      });
}

}  // namespace

template <class Visitor>
void ParticleSet::visit_needed(Visitor&& visit) {
#define DRENCH_VISIT(owner, name, host_type, unit, needed) \
  if (needs_field(model_, #owner "_" #name)) visit("drench::" #owner "_" #name, name, spare_##name);
  DRENCH_PARTICLE_FIELDS(DRENCH_VISIT)
#undef DRENCH_VISIT
}

ParticleSet::ParticleSet(const Model& m, bool over_ranks) : model_(m), grows_(over_ranks || m.adds_particles()) {}

ParticleView ParticleSet::view() {
  return {
#define DRENCH_VIEW(owner, name, host_type, unit, needed) name,
      DRENCH_PARTICLE_FIELDS(DRENCH_VIEW)
#undef DRENCH_VIEW
  };
}

void ParticleSet::upload(const HostState& s) {
  count = 0;
  reserve(s.fluid_count());
  count = s.fluid_count();
  ghosts = 0;
  total = count;
#define DRENCH_UPLOAD(owner, name, host_type, unit, needed)                                \
  if (needs_field(model_, #owner "_" #name)) {                                             \
    auto values = s.owner##_##name;                                                        \
    values.resize(static_cast<std::size_t>(count)); /* a state made by hand may lack it */ \
    copy_to_device(name, values);                                                          \
  }
  DRENCH_PARTICLE_FIELDS(DRENCH_UPLOAD)
#undef DRENCH_UPLOAD
  next_id = s.next_id;
  moved.advance();
}

void ParticleSet::download(HostState& s) const {
#define DRENCH_DOWNLOAD(owner, name, host_type, unit, needed) \
  if (needs_field(model_, #owner "_" #name)) s.owner##_##name = to_host<host_type>(name, count);
  DRENCH_PARTICLE_FIELDS(DRENCH_DOWNLOAD)
#undef DRENCH_DOWNLOAD
  s.next_id = next_id;
  sort_by_id(s);
}

void sort_by_id(HostState& s) {
  if (std::is_sorted(s.fluid_id.begin(), s.fluid_id.end())) return;
  const std::vector<Index> place = places_by_id(s.fluid_id);
  visit_fields(s, [&](std::string_view field, auto& values) {
    if (field.starts_with("fluid_") && !values.empty()) arrange(values, place);
  });
}

std::vector<Index> ParticleSet::ranks_by_id() const {
  const std::vector<Index> place = places_by_id(to_host<std::int64_t>(id, count));
  std::vector<Index> rank(place.size());
  for (std::size_t k = 0; k < place.size(); ++k) rank[static_cast<std::size_t>(place[k])] = static_cast<Index>(k);
  return rank;
}

void ParticleSet::reserve(Index n) {
  if (n <= static_cast<Index>(capacity())) return;
  const Index room = capacity() == 0 && !grows_ ? n : n + n / 4 + 64;
  visit_needed([room](const char* label, auto& a, auto&) { resize_keeping(a, label, room); });
}

void ParticleSet::gather(const Array<Index>& source, Index n) {
  const std::size_t room = capacity();
  visit_needed([room](const char* label, auto&, auto& spare) { make_room(spare, label, room); });
  const ParticleView from = view();
  visit_needed([](const char*, auto& a, auto& spare) { std::swap(a, spare); });
  copy_from(from, source, n, view());
  count = n;
}

double particle_room(const Sizing& s) {
  if (!(s.size.fluid > 0)) return 0;
  return s.size.adds_particles ? 1.25 * s.size.fluid + 64 : s.size.fluid;
}

MemoryEstimate particle_bytes(const Sizing& m) {
  double each = 0;
#define DRENCH_BYTES(owner, name, host_type, unit, needed) \
  if (needed) each += 2 * m.entry<host_type>();  // and the spare one
  DRENCH_PARTICLE_FIELDS(DRENCH_BYTES)
#undef DRENCH_BYTES
  if (m.size.absorption || m.size.emission || m.size.evaporation) each += index_bytes;  // source_
  MemoryEstimate sum;
  sum.particles = particle_room(m) * each;
  return sum;
}

void ParticleSet::compact(Slice<const std::uint8_t> gone, Index kept) {
  const Index n = count;
  if (n == 0) return;
  make_room(source_, "drench::compact_source", capacity());
  const Entries<Index> source = source_;
  const Entries<const Quanta> masses = std::as_const(mass);
  const bool flagged = gone.extent(0) > 0;
  const auto number = KOKKOS_LAMBDA(const Index i, Index& rank, const bool last) {
    const bool stays = masses(i) > 0 && !(flagged && gone(i));
    if (last && stays) source(rank) = i;
    rank += stays ? 1 : 0;
  };
  if (kept < 0)
    Kokkos::parallel_scan("drench::compact::scan", range(n), number, kept);
  else if (kept < n)
    Kokkos::parallel_scan("drench::compact::scan", range(n), number);
  if (kept == n) return;
  gather(source_, kept);
}

void ParticleSet::reorder(const Array<Index>& source) {
  const Index owned = count;
  if (local() > 0) gather(source, local());
  count = owned;
}

}  // namespace drench::kokkos_backend
