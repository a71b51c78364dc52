#pragma once
// Sums over the samples of each measured body, in a fixed order.

#include "bodies/bodies.hpp"

namespace drench::kokkos_backend {

inline constexpr Index parts_per_body = 64;

/// dynamic.load = Σ term(s) over each measured body's samples.
template <class Term>
void sum_over_samples(Bodies& bodies, const Term& term) {
  const Entries<const RigidBody> constant = std::as_const(bodies).constant;
  const Entries<Wrench> part = bodies.dynamic.part, load = bodies.dynamic.load;
  parallel(
      "drench::bodies::part", parts_per_body * bodies.count, KOKKOS_LAMBDA(const Index k) {
        const RigidBody& body = constant(k / parts_per_body);
        Wrench sum;
        if (body.measured)
          for (Index s = k % parts_per_body; s < body.sample_count; s += parts_per_body)
            sum += term(body.first_dynamic + s);
        part(k) = sum;
      });
  parallel(
      "drench::bodies::load", bodies.count, KOKKOS_LAMBDA(const Index b) {
        Wrench sum;
        for (Index p = 0; p < parts_per_body; ++p) sum += part(b * parts_per_body + p);
        load(b) = sum;
      });
}

/// Forces on the samples → forces and torques of the bodies. (Not inline: nvcc's lambdas belong to one file.)
void sum_sample_forces(Bodies& bodies);

}  // namespace drench::kokkos_backend
