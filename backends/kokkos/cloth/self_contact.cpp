#include "cloth/self_contact.hpp"

#include "cloth/proximity.hpp"
#include "cloth/self_collision.hpp"
#include "cloth/wet_cloth.hpp"
#include "core/sizing.hpp"

namespace drench::kokkos_backend {

namespace {

/// Of a SelfContact, for a Real of so many bytes.
constexpr double contact_bytes(double real) { return real > 4 ? 112 : 64; }
static_assert(sizeof(SelfContact) == contact_bytes(sizeof(Real)));

/// Is a pair with these paths (m) a contact, and how does it lie? That is as at the end of the paths, unless these may cross.
KOKKOS_INLINE_FUNCTION bool touches(const ClosePair& pair, const Double3* x, const Double3* u, Proximity& at) {
  constexpr double near_end = 1.5;  // of τ
  const bool edges = pair.edges != 0;
  if (reaches(edges, x, u, 0.5 * Kokkos::fmin(pair.thickness, pair.distance), at)) {
    if (pair.distance > pair.thickness) return reaches(edges, x, u, pair.thickness, at);
    at = proximity(edges, x);
    return true;
  }
  Double3 end[4];
  for (int k = 0; k < 4; ++k) end[k] = add(x[k], u[k]);
  at = proximity(edges, end);
  return at.distance <= near_end * pair.thickness;
}

/// Appends the contacts among the pairs, in any order, and counts them at their nodes.
Index list_contacts(const Constants& constants, const Cloth& cloth, const SelfCollisionWork& work,
                    SelfContacts& contacts, Index pairs) {
  const Entries<const ClosePair> pair = work.pair;
  const Entries<const Real3> start = cloth.nodes.position, end = work.end;
  const Entries<SelfContact> list = contacts.contact;
  const Entries<Index> share = contacts.share;
  const Materials materials = node_materials(cloth);
  const NodeLiquid wet(constants, cloth);
  make_room_for_one(contacts.number, "drench::cloth::self_contact_count");
  const Kokkos::View<Index, MemSpace> number = contacts.number;
  Kokkos::deep_copy(number, Index{0});
  parallel(
      "drench::cloth::self_contact_list", pairs, KOKKOS_LAMBDA(const Index p) {
        const ClosePair near = pair(p);
        Double3 x[4], u[4];
        for (int k = 0; k < 4; ++k) {
          x[k] = widen(start(near.node[k]));
          u[k] = minus(widen(end(near.node[k])), x[k]);
        }
        Proximity at;
        if (!touches(near, x, u, at) || !(at.distance > 0)) return;
        const Double3 normal = times(1 / at.distance, at.apart);
        double short_of = target_gap(near.thickness, near.distance, near.thickness);
        SelfContact c{};
        c.edges = near.edges;
        for (int k = 0; k < 4; ++k) {
          c.node[k] = near.node[k];
          c.b[k] = static_cast<Real>(at.b[k]);
          short_of -= at.b[k] * inner(normal, minus(x[k], x[0]));
          if (c.b[k] != 0) Kokkos::atomic_add(&share(c.node[k]), Index{1});
        }
        c.normal = narrow(normal);
        c.short_of = static_cast<Real>(short_of);
        c.friction = Real(0.5) * (friction_at(materials(c.node[0]), wet, c.node[0]) +
                                  friction_at(materials(c.node[3]), wet, c.node[3]));
        list(Kokkos::atomic_fetch_add(&number(), Index{1})) = c;
      });
  Index count = 0;
  Kokkos::deep_copy(count, number);
  return count;
}

void find_stiffness(const Cloth& cloth, SelfContacts& contacts, Real dt) {
  const Entries<SelfContact> list = contacts.contact;
  const Entries<const Index> share = contacts.share;
  const Entries<const Real> inverse_mass = cloth.nodes.inverse_mass;
  const Real scale = static_cast<Real>(contact_stiffness) / (dt * dt);
  parallel(
      "drench::cloth::self_contact_stiffness", contacts.count, KOKKOS_LAMBDA(const Index i) {
        SelfContact& c = list(i);
        Real mobility = 0;
        for (int k = 0; k < 4; ++k)
          mobility += c.b[k] * c.b[k] * static_cast<Real>(share(c.node[k])) * inverse_mass(c.node[k]);
        c.stiffness = mobility > 0 ? scale / mobility : Real(0);
      });
}

KOKKOS_INLINE_FUNCTION bool comes_before(const SelfContact& p, const SelfContact& q) {
  for (int k = 0; k < 4; ++k)
    if (p.node[k] != q.node[k]) return p.node[k] < q.node[k];
  return p.edges < q.edges;
}

/// start and item; share becomes 0.
void list_rows(SelfContacts& contacts, Index nodes) {
  const Entries<Index> share = contacts.share, start = contacts.start, item = contacts.item;
  const Entries<const SelfContact> list = contacts.contact;
  Kokkos::parallel_scan(
      "drench::cloth::self_contact_rows", range(nodes), KOKKOS_LAMBDA(const Index n, Index& sum, const bool last) {
        if (last && n == 0) start(0) = 0;
        sum += share(n);
        if (last) start(n + 1) = sum;
      });
  parallel(
      "drench::cloth::self_contact_items", contacts.count, KOKKOS_LAMBDA(const Index i) {
        for (Index k = 0; k < 4; ++k)
          if (const Index n = list(i).node[k]; list(i).b[k] != 0)
            item(start(n) + Kokkos::atomic_fetch_add(&share(n), Index{-1}) - 1) = 4 * i + k;
      });
  // A fixed order: a node's contacts by their nodes. Two may have the same four, as a node with a triangle and as two edges.
  parallel(
      "drench::cloth::self_contact_order", nodes, KOKKOS_LAMBDA(const Index n) {
        for (Index i = start(n) + 1; i < start(n + 1); ++i) {
          const Index moved = item(i);
          Index to = i;
          for (; to > start(n) && comes_before(list(moved / 4), list(item(to - 1) / 4)); --to) item(to) = item(to - 1);
          item(to) = moved;
        }
      });
}

}  // namespace

double self_contact_bytes(const Sizing& s) {
  // Made once cloth touches: of the pairs beyond those that there is room for at the start half are contacts, each in the rows
  // of four nodes.
  const double pairs = s.size.fold_pairs - SetupSize().fold_pairs;
  if (!s.size.contacts_in_solve || !(pairs > 0)) return 0;
  return 2 * index_bytes + 1.25 * pairs * (contact_bytes(s.real) + 2 * index_bytes);
}

void find_self_contacts(const Constants& constants, Bodies& bodies, Cloth& cloth, SelfCollisionWork& work,
                        SelfContacts& contacts, const StepInfo& info) {
  contacts.count = 0;
  if (!constants.model.has_contacts_in_solve()) return;
  const Index pairs = find_near_pairs(constants, bodies, cloth, work, info);
  if (pairs == 0) return;
  const Index nodes = cloth.nodes.count;
  allocate_zeros(contacts.share, "drench::cloth::self_contact_share", static_cast<std::size_t>(nodes));
  make_ample_room(contacts.contact, "drench::cloth::self_contact_contact", static_cast<std::size_t>(pairs));
  contacts.count = list_contacts(constants, cloth, work, contacts, pairs);
  if (contacts.count == 0) return;
  find_stiffness(cloth, contacts, static_cast<Real>(info.dt));
  make_room(contacts.start, "drench::cloth::self_contact_start", static_cast<std::size_t>(nodes) + 1);
  make_ample_room(contacts.item, "drench::cloth::self_contact_item", 4 * static_cast<std::size_t>(contacts.count));
  list_rows(contacts, nodes);
}

}  // namespace drench::kokkos_backend
