#pragma once
// Contacts of the cloth with itself inside its implicit step. Law: docs/theory/contacts.md, section 8.

#include "cloth/cloth.hpp"

namespace drench::kokkos_backend {

struct SelfCollisionWork;

constexpr double contact_stiffness = 30;  // κ, 1: of a contact over the inertia of its nodes

/// A node and a triangle, or two edges, that may touch in this step: a spring that only presses, and its friction.
struct alignas(16) SelfContact {
  Index node[4], edges;  // edges: 1 or 0
  Real b[4];
  Real3 normal;
  Real short_of;   // γ less n·Σ b x⁰, m
  Real stiffness;  // k_c, N/m
  Real friction;   // μ

  /// What acts on the first of the two; b_k times this acts on node k, N.
  template <class Shift>
  KOKKOS_INLINE_FUNCTION Real3 force(const Shift& shift) const {
    Real3 u;
    for (int k = 0; k < 4; ++k) u += b[k] * shift(node[k]);
    const Real along = dot(normal, u), pressed = short_of - along;
    if (!(pressed > 0)) return {};
    const Real3 slip = u - along * normal;
    const Real length = norm(slip), most = friction * pressed;
    return stiffness * (pressed * normal - (length > most ? most / length : Real(1)) * slip);
  }
};

/// The contacts of a step, and the rows of each node: 4 c + k for corner k of contact c.
struct SelfContacts {
  Field<SelfContact> contact;
  Field<Index> share;  // N_n, then where the next item of a row goes
  Field<Index> start, item;
  Kokkos::View<Index, MemSpace> number;
  Index count = 0;
};

/// Finds the contacts of the paths by the nodes' velocities as they are; none unless the scene asks for them.
void find_self_contacts(const Constants& constants, Bodies& bodies, Cloth& cloth, SelfCollisionWork& work,
                        SelfContacts& contacts, const StepInfo& info);
/// A node's.
double self_contact_bytes(const Sizing& s);

}  // namespace drench::kokkos_backend
