// Contact wicking, a part of stage diffusion (src/stages/diffusion.hpp, laws 4–6).

#include "porous/contact_wicking.hpp"

#include <algorithm>
#include <cmath>

#include "cloth/proximity.hpp"
#include "cloth/wet_cloth.hpp"
#include "porous/diffusion_law.hpp"
#include "porous/stages.hpp"
#include "porous/transfer.hpp"
#include "state/film.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr Index none = -1;

/// What sample p sees on one side of its triangle.
struct Touch {
  Index triangle = none, sample = none;
  Proximity near;
};

KOKKOS_INLINE_FUNCTION double most_in_pores(const Material& m) {
  return m.film_depth > 0 ? 1 : double(m.max_saturation);
}

/// Of fabric in contact with fabric whose ℓ is `other` (m), for liquid of `density` kg/m³.
KOKKOS_INLINE_FUNCTION laws::Layer layer_of(const Material& m, double other, double density) {
  const double own = double(m.capillary_height), height = own / smaller(own, other);
  return {density * (1 - double(m.solid_fraction)) * double(m.thickness),
          double(m.thickness),
          double(m.diffusivity),
          height,
          m.retention,
          height * m.steepest_suction};
}

/// What the kernel over samples sees.
struct ContactSearch {
  Entries<const Index> node, sample_triangle, triangle, joint;
  Entries<Index> found;
  Neighbors list;
  Entries<const Real3> sample_position, normal, position;
  Entries<const Real> area;
  Materials of_sample;
  Entries<double> weight, conductance, drop;
  double dt, density;  // s, kg/m³
  Double3 down;        // ĝ, 0 without gravity

  ContactSearch(const Constants& constants, const NeighborLists& lists, const Cloth& cloth, ContactWork& work,
                double step)
      : node(cloth.samples.node),
        sample_triangle(cloth.samples.triangle),
        triangle(cloth.mesh.triangle),
        joint(cloth.nodes.joint),
        found(work.triangle),
        list(lists.sample_sample),
        sample_position(cloth.samples.position),
        normal(cloth.samples.normal),
        position(cloth.nodes.position),
        area(cloth.samples.area),
        of_sample(sample_materials(cloth)),
        weight(work.weight),
        conductance(work.conductance),
        drop(work.drop),
        dt(step),
        density(constants.model.rest_density) {
    const Double3 g = widen(constants.gravity);
    const double size = Kokkos::sqrt(inner(g, g));
    if (size > 0) down = times(1 / size, g);
  }

  /// What a flow through a contact grows by with n > 1, over that with n = 1.
  KOKKOS_INLINE_FUNCTION double steepest(const Material& a, const Material& b) const {
    const double n = larger(a.mobility_exponent, b.mobility_exponent);
    if (n <= 1) return 1;
    return Kokkos::pow(larger(most_in_pores(a), most_in_pores(b)), n - 1);
  }
  KOKKOS_INLINE_FUNCTION bool wicks(const Material& m) const { return m.contact_wicking != 0; }

  KOKKOS_INLINE_FUNCTION bool share_a_node(Index s, Index t) const {
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        if (joint_of(joint, triangle(3 * s + a)) == joint_of(joint, triangle(3 * t + b))) return true;
    return false;
  }

  /// Law 4; side 0: d·n > 0.
  KOKKOS_INLINE_FUNCTION void nearest(Index p, Touch* best) const {
    const Material& own = of_sample(p);
    const Double3 n = widen(normal(p));
    Index last = none;
    const NeighborRow row = list.row(p);
    for (Index k = 0; k < row.count; ++k) {
      const Index other = row(k), t = sample_triangle(other);
      const Material& m = of_sample(other);
      if (t == last || !wicks(m) || share_a_node(sample_triangle(p), t)) continue;
      last = t;
      Double3 x[4] = {widen(sample_position(p)), {}, {}, {}};
      for (Index c = 0; c < 3; ++c) x[c + 1] = widen(position(triangle(3 * t + c)));
      const Proximity near = proximity(false, x);
      const double reach = 0.75 * (double(own.thickness) + double(m.thickness)), height = inner(near.apart, n);
      if (!(near.distance > 0 && near.distance <= reach)) continue;
      if (!(2 * height * height >= near.distance * near.distance)) continue;
      Touch& touch = best[height > 0 ? 0 : 1];
      if (touch.triangle == none || near.distance < touch.near.distance ||
          (near.distance == touch.near.distance && t < touch.triangle))
        touch = {t, other, near};
    }
  }

  KOKKOS_INLINE_FUNCTION void operator()(const Index p) const {
    const Material& own = of_sample(p);
    Touch best[2];
    if (wicks(own)) nearest(p, best);
    for (Index side = 0; side < 2; ++side) {
      const Index c = 2 * p + side, t = best[side].triangle;
      found(c) = t;
      if (t == none) continue;
      const Material& m = of_sample(best[side].sample);
      const double height = double(own.capillary_height), other = double(m.capillary_height);
      const laws::Layer here = layer_of(own, other, density), there = layer_of(m, height, density);
      conductance(c) = 0.5 * double(area(p)) * laws::contact_conductance(here, there, dt * steepest(own, m));
      drop(c) = inner(best[side].near.apart, down) * (1 / smaller(height, other)) + (here.height - there.height);
      for (int k = 0; k < 3; ++k) weight(3 * c + k) = -best[side].near.b[k + 1];
    }
  }
};

/// The nodes and weights of both ends of a contact: sample p and a point of a triangle.
struct Ends {
  Entries<const Index> sample_node, triangle;
  Entries<Index> found;
  Entries<const double> sample_weight, found_weight;

  explicit Ends(const Cloth& cloth, ContactWork& work)
      : sample_node(cloth.samples.node),
        triangle(cloth.mesh.triangle),
        found(work.triangle),
        sample_weight(cloth.samples.weight_exact),
        found_weight(work.weight) {}
  /// Corner k of the sample (far false) or of what it touches (true).
  KOKKOS_INLINE_FUNCTION Index node(Index contact, bool far, int k) const {
    return far ? triangle(3 * found(contact) + k) : sample_node(3 * (contact / 2) + k);
  }
  KOKKOS_INLINE_FUNCTION double weight(Index contact, bool far, int k) const {
    return far ? found_weight(3 * contact + k) : sample_weight(3 * (contact / 2) + k);
  }
  KOKKOS_INLINE_FUNCTION Quanta part(Index contact, bool far, int k, Quanta amount) const {
    return split_part(amount, weight(contact, far, 0), weight(contact, far, 1), weight(contact, far, 2), k);
  }
};

void offer(const Constants& constants, const Cloth& cloth, ContactWork& work, double dt, bool with_momentum) {
  const Ends ends(cloth, work);
  const Entries<Quanta> flow = work.flow, in = work.entering, out = work.leaving;
  const Entries<const double> g = work.conductance, drop = work.drop;
  const NodeLiquid wet(constants, cloth);
  const Materials materials = node_materials(cloth);
  const Entries<const Real> scanning = cloth.nodes.scanning;
  const double scale = dt / constants.quantum, density = constants.model.rest_density;
  const Entries<std::int64_t> momentum = work.momentum;
  parallel(
      "drench::contact_wicking::clear", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        in(n) = out(n) = 0;
        if (with_momentum)
          for (int a = 0; a < 3; ++a) momentum(3 * n + a) = 0;
      });
  parallel(
      "drench::contact_wicking::offer", 2 * cloth.samples.count, KOKKOS_LAMBDA(const Index c) {
        flow(c) = 0;
        if (ends.found(c) == none) return;
        double s[2] = {0, 0}, scanned[2] = {0, 0};
        for (int far = 0; far < 2; ++far)
          for (int k = 0; k < 3; ++k) {
            const Index n = ends.node(c, far != 0, k);
            if (!(wet.capacity(n) > 0)) continue;
            const Material& m = materials(n);
            const double weight = ends.weight(c, far != 0, k), filling = wet.pore_filling(n, m);
            s[far] += weight * filling;
            if (m.by_suction)
              scanned[far] += weight * m.suction.held(filling, scanning.exist() ? double(scanning(n)) : 1);
          }
        const Material &own = materials(ends.node(c, false, 0)), &other = materials(ends.node(c, true, 0));
        const double exponent = larger(own.mobility_exponent, other.mobility_exponent);
        const laws::Layer here = layer_of(own, double(other.capillary_height), density),
                          there = layer_of(other, double(own.capillary_height), density);
        const double held = own.by_suction ? here.height * scanned[0] : here.held(s[0]);
        const double held_there = other.by_suction ? there.height * scanned[1] : there.held(s[1]);
        const double flux = laws::held_flux(g(c), s[0], s[1], held, held_there, drop(c), exponent);
        const Quanta o = offered(Kokkos::abs(flux) * scale);
        if (o == 0) return;
        flow(c) = flux > 0 ? o : -o;
        for (int far = 0; far < 2; ++far)
          for (int k = 0; k < 3; ++k) {
            const Quanta part = whole_part(ends.weight(c, far != 0, k), o) + 1;
            const Index n = ends.node(c, far != 0, k);
            Kokkos::atomic_add((far != 0) == (flux > 0) ? &out(n) : &in(n), part);
          }
      });
}

/// Law 8: what reaches the other end brings the mean velocity of the nodes that it leaves. `to_far`: the end that
/// gains.
KOKKOS_INLINE_FUNCTION void pass_momentum(const Ends& ends, const Entries<const Double3>& v,
                                          const Entries<std::int64_t>& sums, double scale, Index c, bool to_far,
                                          Quanta amount) {
  Double3 mean;
  for (int k = 0; k < 3; ++k)
    mean = add(mean, times(double(ends.part(c, !to_far, k, amount)) / double(amount), v(ends.node(c, !to_far, k))));
  for (int k = 0; k < 3; ++k) {
    const Index n = ends.node(c, to_far, k);
    const Double3 gain = times(scale * double(ends.part(c, to_far, k, amount)), minus(mean, v(n)));
    add_fixed(sums, n, gain);
  }
}

/// The largest power of two with which what fills any node at 1000 m/s stays below 2^62: its momentum is then exact to
/// 2^-53 of that at 1 m/s.
double momentum_scale(const Model& m) {
  double most = 1;  // quanta
  for (const ClothMaterial& c : m.cloths)
    for (Index n = c.first_node; n < c.first_node + c.node_count; ++n)
      most = std::max(most, std::max(c.most_saturation, ceiling_of_node(m, n)) *
                                m.samples.node_capacity[static_cast<std::size_t>(n)] / m.quantum);
  return std::exp2(std::floor(62 - std::log2(1000 * most)));
}

void push_nodes(const Constants& constants, const Cloth& cloth, DiffusionWork& diffusion, const ContactWork& work) {
  const Entries<Double3> v = diffusion.velocity;
  const Entries<const std::int64_t> momentum = work.momentum;
  const Entries<const Quanta> liquid = cloth.nodes.liquid;
  const Entries<const Real> solid = cloth.nodes.solid_mass;
  const Entries<const std::uint8_t> fixed = cloth.nodes.fixed;
  const double q = constants.quantum, unit = constants.quantum / work.momentum_scale;
  parallel(
      "drench::contact_wicking::velocity", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const double mass = double(solid(n)) + q * double(liquid(n));
        if (fixed(n) || !(mass > 0)) return;
        const double scale = unit / mass;
        v(n) = add(v(n), {scale * double(momentum(3 * n)), scale * double(momentum(3 * n + 1)),
                          scale * double(momentum(3 * n + 2))});
      });
}

/// The share of contact c's offer that all of its nodes allow.
struct ContactShare {
  Ends ends;
  Entries<const double> out_share, in_share;

  KOKKOS_INLINE_FUNCTION double operator()(Index c, bool to_near) const {
    double share = 1;
    for (int far = 0; far < 2; ++far)
      for (int k = 0; k < 3; ++k) {
        if (!(ends.weight(c, far != 0, k) > 0)) continue;
        const Index n = ends.node(c, far != 0, k);
        share = smaller(share, (far != 0) == to_near ? out_share(n) : in_share(n));
      }
    return share;
  }
};

/// The solute that goes along with what passes, from each node that gives at its own concentration.
void gain_solute(Cloth& cloth, const DiffusionWork& diffusion, ContactWork& work) {
  const ContactShare share_of{Ends(cloth, work), diffusion.out_share, diffusion.in_share};
  const Entries<const Quanta> flow = std::as_const(work).flow, liquid = std::as_const(cloth).nodes.liquid;
  const Entries<Quanta> gain = work.solute_gain, solute = cloth.nodes.solute;
  parallel(
      "drench::contact_wicking::clear_solute", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { gain(n) = 0; });
  parallel(
      "drench::contact_wicking::solute", 2 * cloth.samples.count, KOKKOS_LAMBDA(const Index c) {
        const Quanta o = flow(c);
        if (o == 0) return;
        const Quanta t = limited(o > 0 ? o : -o, share_of(c, o > 0));
        if (t == 0) return;
        Quanta carried = 0, taken[3];
        for (int k = 0; k < 3; ++k) {
          const Index donor = share_of.ends.node(c, o > 0, k);
          const Quanta part = solute_part(solute(donor), share_of.ends.part(c, o > 0, k, t), liquid(donor));
          carried += part;
          if (part > 0) Kokkos::atomic_add(&gain(donor), -part);
          taken[k] = share_of.ends.part(c, o < 0, k, t);
        }
        if (carried == 0) return;
        for (int k = 0; k < 3; ++k)
          Kokkos::atomic_add(&gain(share_of.ends.node(c, o < 0, k)), solute_beside(carried, taken, k));
      });
  parallel(
      "drench::contact_wicking::solute_gain", cloth.nodes.count,
      KOKKOS_LAMBDA(const Index n) { solute(n) += gain(n); });
}

void limit(const Cloth& cloth, DiffusionWork& diffusion, const ContactWork& work) {
  const Entries<const Quanta> in = work.entering, out = work.leaving, ceiling = cloth.nodes.max_quanta,
                              liquid = cloth.nodes.liquid;
  const Entries<double> out_share = diffusion.out_share, in_share = diffusion.in_share;
  parallel(
      "drench::contact_wicking::limit", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        out_share(n) = outflow_fraction(liquid(n), out(n));
        in_share(n) = inflow_fraction(ceiling(n), liquid(n), in(n));
      });
}

void transfer(Cloth& cloth, DiffusionWork& diffusion, ContactWork& work, bool with_momentum) {
  const Ends ends(cloth, work);
  const ContactShare share_of{ends, std::as_const(diffusion).out_share, std::as_const(diffusion).in_share};
  const Entries<const Quanta> flow = work.flow;
  const Entries<Quanta> liquid = cloth.nodes.liquid;
  const Entries<const Double3> velocity = diffusion.velocity;
  const Entries<std::int64_t> momentum = work.momentum;
  const double scale = work.momentum_scale;
  parallel(
      "drench::contact_wicking::transfer", 2 * cloth.samples.count, KOKKOS_LAMBDA(const Index c) {
        const Quanta o = flow(c);
        if (o == 0) return;
        const Quanta t = limited(o > 0 ? o : -o, share_of(c, o > 0));
        if (t == 0) return;
        if (with_momentum) pass_momentum(ends, velocity, momentum, scale, c, o < 0, t);
        for (int far = 0; far < 2; ++far)
          for (int k = 0; k < 3; ++k) {
            const Quanta part = ends.part(c, far != 0, k, t);
            if (part != 0) Kokkos::atomic_add(&liquid(ends.node(c, far != 0, k)), (far != 0) == (o > 0) ? -part : part);
          }
      });
}

}  // namespace

void find_contacts(const Constants& constants, const NeighborLists& lists, const Cloth& cloth, ContactWork& work,
                   double dt, bool with_momentum) {
  const auto both = 2 * static_cast<std::size_t>(cloth.samples.count),
             nodes = static_cast<std::size_t>(cloth.nodes.count);
  make_room(work.triangle, "drench::contact_wicking::triangle", both);
  make_room(work.weight, "drench::contact_wicking::weight", 3 * both);
  make_room(work.conductance, "drench::contact_wicking::conductance", both);
  make_room(work.drop, "drench::contact_wicking::drop", both);
  make_room(work.flow, "drench::contact_wicking::flow", both);
  make_room(work.entering, "drench::contact_wicking::entering", nodes);
  make_room(work.leaving, "drench::contact_wicking::leaving", nodes);
  if (constants.model.has_solute()) make_room(work.solute_gain, "drench::contact_wicking::solute_gain", nodes);
  if (with_momentum && work.momentum.extent(0) == 0) {
    make_room(work.momentum, "drench::contact_wicking::momentum", 3 * nodes);
    work.momentum_scale = momentum_scale(constants.model);
  }
  parallel("drench::contact_wicking::find", cloth.samples.count, ContactSearch(constants, lists, cloth, work, dt));
}

MemoryEstimate contact_wicking_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (!s.size.contact_wicking) return sum;
  sum.cloth = 2 * s.size.samples * (index_bytes + 5 * double_bytes + quanta_bytes) + s.size.nodes * 2 * quanta_bytes;
  if (s.size.solute) sum.cloth += s.size.nodes * quanta_bytes;
  if (s.size.moving_cloth) sum.cloth += s.size.nodes * 3 * sizeof(std::int64_t);
  return sum;
}

void wick_through_contacts(const Constants& constants, Cloth& cloth, DiffusionWork& diffusion, ContactWork& work,
                           ReservoirWork& reservoirs, double dt, bool with_momentum) {
  offer(constants, cloth, work, dt, with_momentum);
  limit(cloth, diffusion, work);
  if (constants.model.has_reservoirs()) open_reservoirs(constants, reservoirs, diffusion.in_share);
  if (constants.model.has_solute()) gain_solute(cloth, diffusion, work);
  transfer(cloth, diffusion, work, with_momentum);
  if (with_momentum) push_nodes(constants, cloth, diffusion, work);
}

}  // namespace drench::kokkos_backend
