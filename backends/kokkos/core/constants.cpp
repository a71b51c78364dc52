#include "core/constants.hpp"

#include "core/host_copy.hpp"

namespace drench::kokkos_backend {
namespace {

Vec3 squares(const Vec3& a) { return {a[0] * a[0], a[1] * a[1], a[2] * a[2]}; }

}  // namespace

Constants::Constants(const Model& m, const Communicator* communicator)
    : model(m),
      ranks(communicator),
      spacing(Real(m.spacing)),
      support(Real(m.support)),
      rest_density(Real(m.rest_density)),
      kernel(m.scene.fluid.kernel, Real(m.support)),
      quantum(m.quantum),
      gravity(to_real(m.scene.gravity)),
      field_center(to_real(m.scene.field.center)),
      field_square(to_real(squares(m.scene.field.rate))) {}

}  // namespace drench::kokkos_backend
