#include "particles/exchange.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "core/host_copy.hpp"
#include "core/ranks.hpp"

namespace drench::kokkos_backend {
namespace {

/// `item` gets the numbers i < n with chosen(i), in order. Returns how many; waits for the device.
template <class Chosen>
Index choose(const char* label, Index n, const Chosen& chosen, const Entries<Index>& item) {
  Index count = 0;
  if (n == 0) return count;
  Kokkos::parallel_scan(
      label, range(n),
      KOKKOS_LAMBDA(const Index i, Index& rank, const bool last) {
        const bool takes = chosen(i);
        if (last && takes) item(rank) = i;
        rank += takes ? 1 : 0;
      },
      count);
  return count;
}

std::array<double, 3> numbers(const Real3& x) { return {double(x.x), double(x.y), double(x.z)}; }

Real3 rounded(const Vec3& x) { return {Real(x[0]), Real(x[1]), Real(x[2])}; }

KOKKOS_INLINE_FUNCTION bool well_between(Real x, Real min, Real max, Real reach) {
  return x - min >= reach && x - max <= -reach;
}

/// Is a point of the box farther than `reach` from all that lies beyond it?
KOKKOS_INLINE_FUNCTION bool deep_inside(const RankBox& box, const Real3& x, Real reach) {
  return well_between(x.x, box.min.x, box.max.x, reach) && well_between(x.y, box.min.y, box.max.y, reach) &&
         well_between(x.z, box.min.z, box.max.z, reach);
}

/// May points of `a` be within `reach` of `b`?
bool meet(const RankBox& a, const RankBox& b, Real reach) {
  const auto near = [reach](Real min, Real max, Real low, Real high) {
    return min - high < reach && low - max < reach;
  };
  return near(a.min.x, a.max.x, b.min.x, b.max.x) && near(a.min.y, a.max.y, b.min.y, b.max.y) &&
         near(a.min.z, a.max.z, b.min.z, b.max.z);
}

}  // namespace

Exchange::Exchange(const Constants& constants) : ranks_(constants.ranks), support_(constants.support) {
#ifdef KOKKOS_ENABLE_CUDA
  if (ranks_) device_ = make_device_messages(*ranks_);
#endif
  overlaps_ = ranks_ && (!device_ || !device_->on_one_host());
}

std::string Exchange::transport() const {
  if (alone()) return "";
  if (device_) return device_->description();
  return ranks_->description() + (on_host ? "" : ", by the host's memory");
}

void Exchange::take_boxes(const Bisection& space) {
  std::vector<RankBox> boxes;
  for (const RankPart& part : space.parts()) boxes.push_back({rounded(part.min), rounded(part.max)});  // cuts are Reals
  host_boxes_ = boxes;
  own_ = boxes[static_cast<std::size_t>(ranks_->rank())];
  make_room(boxes_, "drench::exchange::boxes", boxes.size());
  copy_to_device(boxes_, boxes);
}

void Exchange::upload_own(const HostState& state, ParticleSet& particles) {
  if (alone()) {
    particles.upload(state);
    return;
  }
  const std::int64_t n = state.fluid_count(), points = std::min(n, points_of_rank * ranks_->size());
  const auto place = [&state](std::int64_t k) { return rounded(state.fluid_position[static_cast<std::size_t>(k)]); };
  std::vector<WeightedPoint> seen;
  for (std::int64_t k = 0; k < points; ++k) seen.push_back({numbers(place(k * n / points)), 1});
  take_boxes(Bisection(std::move(seen), ranks_->size()));
  std::vector<std::size_t> kept;
  for (std::int64_t k = 0; k < n; ++k) {
    const Real3 x = place(k);
    const bool finite = std::isfinite(x.x + x.y + x.z);  // what is no number lies in every box
    if (finite ? own_.holds(x) : ranks_->rank() == 0) kept.push_back(static_cast<std::size_t>(k));
  }
  HostState own = state;
  visit_fields(own, [&](std::string_view name, auto& values) {
    if (!name.starts_with("fluid_") || values.empty()) return;  // a state made by hand may lack it
    for (std::size_t k = 0; k < kept.size(); ++k) values[k] = values[kept[k]];
    values.resize(kept.size());
  });
  particles.upload(own);
  particles.total = n;
}

void Exchange::count_all(ParticleSet& particles, double& fullest) const {
  particles.total = particles.count;
  fullest = static_cast<double>(particles.count);
  OverRanks(ranks_).sum(particles.total).maximum(fullest).reduce();
}

void Exchange::migrate(ParticleSet& particles) {
  finish_halo();
  particles.ghosts = 0;
  if (alone()) {
    particles.total = particles.count;
    return;
  }
  send_home(particles);
  double fullest = 0;
  count_all(particles, fullest);
  imbalance_ = particles.total > 0 ? fullest * ranks_->size() / static_cast<double>(particles.total) : 1;
  // What a cut could not mend, as layers that are not cut, the next one cannot either.
  left_by_cut_ = std::max(1.0, std::min(left_by_cut_, imbalance_));
  const double spare = 64.0 * ranks_->size() / std::max(1.0, static_cast<double>(particles.total));
  if (imbalance_ <= most_imbalance * left_by_cut_ + spare) return;
  cut_anew(particles);
  ++cuts_;
  send_home(particles);
  count_all(particles, fullest);
  imbalance_ = left_by_cut_ = fullest * ranks_->size() / static_cast<double>(particles.total);
}

void Exchange::cut_anew(const ParticleSet& particles) {
  const std::int64_t n = particles.count, points = std::min(n, points_of_rank);
  const std::vector<Vec3> position = to_host<Vec3>(particles.position, particles.count);
  std::vector<WeightedPoint> own(static_cast<std::size_t>(points_of_rank));
  for (std::int64_t k = 0; k < points; ++k)
    own[static_cast<std::size_t>(k)] = {numbers(rounded(position[static_cast<std::size_t>(k * n / points)])),
                                        double(n) / double(points)};
  const std::vector<std::byte> bytes = ranks_->all_gather(own.data(), own.size() * sizeof(WeightedPoint));
  std::vector<WeightedPoint> all(bytes.size() / sizeof(WeightedPoint));
  std::memcpy(static_cast<void*>(all.data()), bytes.data(), bytes.size());
  std::erase_if(all, [](const WeightedPoint& p) { return !(p.weight > 0); });
  take_boxes(Bisection(std::move(all), ranks_->size()));
}

void Exchange::send_home(ParticleSet& particles) {
  const auto ranks = static_cast<std::size_t>(ranks_->size());
  const int count = ranks_->size();
  const std::size_t n = static_cast<std::size_t>(particles.count);
  make_ample_room(chosen_, "drench::exchange::chosen", n);
  const RankBox own = own_;
  const Entries<const Real3> x = std::as_const(particles).position;
  const Index leave = choose(
      "drench::exchange::leave", particles.count, KOKKOS_LAMBDA(const Index i) { return !own.holds(x(i)); }, chosen_);
  make_ample_room(home_, "drench::exchange::home", static_cast<std::size_t>(leave));
  const Entries<Index> home = home_;
  const Entries<const Index> chosen = std::as_const(chosen_);
  const Entries<const RankBox> box = std::as_const(boxes_);
  parallel(
      "drench::exchange::home", leave, KOKKOS_LAMBDA(const Index k) {
        home(k) = 0;
        for (int r = 0; r < count; ++r)
          if (box(r).holds(x(chosen(k)))) home(k) = r;
      });
  const std::vector<Index> to = to_host<Index>(home_, leave), from = to_host<Index>(chosen_, leave);
  std::vector<std::int64_t> sent(ranks);
  for (const Index r : to) ++sent[static_cast<std::size_t>(r)];
  const std::vector<std::int64_t> received = ranks_->exchange_counts(sent);
  const auto come = static_cast<Index>(std::accumulate(received.begin(), received.end(), std::int64_t{0}));
  // in the order of their homes
  std::vector<Index> place(static_cast<std::size_t>(leave)), order(static_cast<std::size_t>(leave));
  std::iota(place.begin(), place.end(), Index{0});
  std::stable_sort(place.begin(), place.end(),
                   [&](Index a, Index b) { return to[static_cast<std::size_t>(a)] < to[static_cast<std::size_t>(b)]; });
  for (std::size_t k = 0; k < place.size(); ++k) order[k] = from[static_cast<std::size_t>(place[k])];
  copy_to_device(chosen_, order);
  make_ample_room(packed_, "drench::exchange::packed", static_cast<std::size_t>(leave) * sizeof(Particle));
  make_ample_room(arrived_, "drench::exchange::arrived", static_cast<std::size_t>(come) * sizeof(Particle));
  Particle* const out = reinterpret_cast<Particle*>(packed_.data());
  const ParticleView leaving = particles.view();
  parallel(
      "drench::exchange::pack_particles", leave, KOKKOS_LAMBDA(const Index k) { out[k] = leaving.load(chosen(k)); });
  travel(packed_, sent, arrived_.data(), received, sizeof(Particle));
  settle(particles, from, come);
}

void Exchange::settle(ParticleSet& particles, const std::vector<Index>& left, Index come) {
  const Index before = particles.count, after = before - static_cast<Index>(left.size()) + come;
  std::vector<Index> to, moved;  // free places; those of the last that stay
  for (const Index i : left)
    if (i < after) to.push_back(i);
  for (Index i = before; i < after; ++i) to.push_back(i);
  auto next = std::lower_bound(left.begin(), left.end(), after);
  for (Index i = after; i < before; ++i) {
    if (next != left.end() && *next == i)
      ++next;
    else
      moved.push_back(i);
  }
  particles.reserve(after);
  particles.count = after;
  make_ample_room(home_, "drench::exchange::home", to.size());
  make_ample_room(chosen_, "drench::exchange::chosen", moved.size());
  copy_to_device(home_, to);
  copy_to_device(chosen_, moved);
  const Particle* const arrived = reinterpret_cast<const Particle*>(arrived_.data());
  const Entries<const Index> place = std::as_const(home_), last = std::as_const(chosen_);
  const ParticleView all = particles.view();
  parallel(
      "drench::exchange::settle", static_cast<Index>(to.size()), KOKKOS_LAMBDA(const Index k) {
        if (k < come)
          all.store(place(k), arrived[k]);
        else
          all.store(place(k), all.load(last(k - come)));
      });
}

void Exchange::find_ghosts(ParticleSet& particles, Real more) {
  if (alone()) return;
  const int own = ranks_->rank(), ranks = ranks_->size();
  const Real reach = Real(1.0001) * (support_ + more);
  const RankBox here = own_;
  const Entries<const Real3> x = std::as_const(particles).position;
  const Entries<const RankBox> box = std::as_const(boxes_);
  make_ample_room(chosen_, "drench::exchange::chosen", static_cast<std::size_t>(particles.count));
  const Index candidates = choose(
      "drench::exchange::near_others", particles.count,
      KOKKOS_LAMBDA(const Index i) {
        if (deep_inside(here, x(i), reach)) return false;
        for (int r = 0; r < ranks; ++r)
          if (r != own && box(r).near(x(i), reach)) return true;
        return false;
      },
      chosen_);
  near_others_ = candidates;
  const Entries<const Index> chosen = std::as_const(chosen_);
  sent_to_.assign(static_cast<std::size_t>(ranks), 0);
  sent_count_ = 0;
  parts_.resize(static_cast<std::size_t>(ranks));
  for (int r = 0; r < ranks; ++r) {
    const RankBox other = host_boxes_[static_cast<std::size_t>(r)];
    if (r == own || candidates == 0 || !meet(here, other, reach)) continue;
    Field<Index>& part = parts_[static_cast<std::size_t>(r)];
    make_ample_room(part, "drench::exchange::part", static_cast<std::size_t>(candidates));
    const Index n = choose(
        "drench::exchange::near_other", candidates,
        KOKKOS_LAMBDA(const Index k) { return other.near(x(chosen(k)), reach); }, part);
    sent_to_[static_cast<std::size_t>(r)] = n;
    sent_count_ += n;
  }
  make_ample_room(sent_, "drench::exchange::sent", static_cast<std::size_t>(sent_count_));
  Index first = 0;
  for (int r = 0; r < ranks; ++r) {
    const auto n = static_cast<Index>(sent_to_[static_cast<std::size_t>(r)]);
    if (n == 0) continue;
    const Entries<const Index> part = std::as_const(parts_[static_cast<std::size_t>(r)]);
    const Entries<Index> sent = sent_;
    parallel(
        "drench::exchange::sent", n, KOKKOS_LAMBDA(const Index k) { sent(first + k) = chosen(part(k)); });
    first += n;
  }
  from_ = ranks_->exchange_counts(sent_to_);
  particles.ghosts = static_cast<Index>(std::accumulate(from_.begin(), from_.end(), std::int64_t{0}));
  first_ghost_ = particles.count;
  particles.reserve(particles.local());
  halo(particles.position);
  halo(particles.mass);
  halo(particles.id);
}

void Exchange::sort_owned(ParticleSet& particles, const Array<Index>& item) {
  const Index count = particles.count, all = particles.local();
  inner_ = 0;
  if (all == 0) return;
  make_ample_room(home_, "drench::exchange::home", static_cast<std::size_t>(all));
  const Index near = overlaps_ ? near_others_ : 0, inner = count - near;
  inner_ = overlaps_ ? inner / warp_size * warp_size : 0;
  if (near > 0) {  // those that may be ghosts elsewhere have all neighbours that are ghosts here
    make_ample_room(outer_, "drench::exchange::outer", static_cast<std::size_t>(all));
    const Entries<std::uint8_t> flags = outer_;
    const Entries<const Index> near_others = std::as_const(chosen_);
    parallel(
        "drench::exchange::inner", all, KOKKOS_LAMBDA(const Index i) { flags(i) = 0; });
    parallel(
        "drench::exchange::outer", near, KOKKOS_LAMBDA(const Index k) { flags(near_others(k)) = 1; });
  }
  const Entries<const std::uint8_t> outer = std::as_const(outer_);
  make_ample_room(order_, "drench::exchange::order", static_cast<std::size_t>(all));
  const Entries<Index> source = order_, place = home_;
  constexpr int half = 32;  // ranks among the inner and the outer, side by side
  Kokkos::parallel_scan(
      "drench::exchange::owned_first", range(all), KOKKOS_LAMBDA(const Index e, std::int64_t& ranks, const bool last) {
        const Index i = item(e);
        const bool owned = i < count, beside = owned && near > 0 && outer(i) != 0;
        if (last) {
          const Index to = !owned   ? i
                           : beside ? inner + static_cast<Index>(ranks >> half)
                                    : static_cast<Index>(ranks & 0xffffffff);
          source(to) = i;
          place(i) = to;
          item(e) = to;
        }
        ranks += beside ? std::int64_t{1} << half : owned ? 1 : 0;
      });
  particles.reorder(order_);
  const Entries<Index> sent = sent_;
  const Entries<const Index> places = std::as_const(home_);
  parallel(
      "drench::exchange::sent_places", sent_count_, KOKKOS_LAMBDA(const Index k) { sent(k) = places(sent(k)); });
}

void Exchange::keep_own_rows(const Field<Real3>& position, NeighborList& list) const {
  if (alone()) return;
  const RankBox own = own_;
  const Entries<const Real3> x = position;
  const Entries<Index> count = list.count;
  parallel(
      "drench::exchange::own_rows", list.rows, KOKKOS_LAMBDA(const Index b) {
        if (!own.holds(x(b))) count(b) = 0;
      });
}

double exchange_bytes(double owned, double ghosts, double real_bytes) {
  constexpr double ample = 1.25;
  const double chosen = owned * index_bytes,
               places = (owned + ghosts) * (2 * index_bytes + 1);  // order_, home_, outer_
  const double sent = ghosts * (index_bytes + 4 * real_bytes);     // with `packed_`, of the widest field
  return ample * (chosen + places + sent);
}

void Exchange::gather(HostState& state) const {
  if (alone()) return;
  const bool first = ranks_->rank() == 0;
  visit_fields(state, [&](std::string_view name, auto& values) {
    using Value = typename std::decay_t<decltype(values)>::value_type;
    if (!name.starts_with("fluid_")) return;
    const auto parts = ranks_->gather(values.data(), values.size() * sizeof(Value));
    if (!first) return;
    values.clear();
    for (const auto& part : parts) {
      const std::size_t before = values.size();
      values.resize(before + part.size() / sizeof(Value));
      if (!part.empty()) std::memcpy(static_cast<void*>(values.data() + before), part.data(), part.size());
    }
  });
  if (first) sort_by_id(state);
}

}  // namespace drench::kokkos_backend
