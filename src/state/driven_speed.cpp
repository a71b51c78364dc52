#include "state/driven_speed.hpp"

#include <algorithm>

#include "base/eigen_vec.hpp"
#include "state/deforming_body.hpp"

namespace drench {
namespace {

/// Of the centre, m/s.
double fastest_centre(const Body& body) {
  return body.velocity.largest() + body.path.largest_derivative() + to_eigen(body.command.velocity).norm();
}
/// rad/s
double fastest_spin(const Body& body) {
  return std::max(body.spin_rate.largest(), body.turn_rate) + to_eigen(body.command.spin).norm();
}

double fastest_of_pin(const Model& m, const PinMotion& pin, const Vec3& x) {
  if (pin.body >= 0) {
    const Body& body = m.bodies[static_cast<std::size_t>(pin.body)];
    return fastest_centre(body) + fastest_spin(body) * pin.reach;
  }
  const double across = to_eigen(pin.axis).cross(to_eigen(x) - to_eigen(pin.center)).norm();
  return pin.velocity.largest() + pin.path.largest_derivative() + pin.rate.largest() * across;
}

}  // namespace

double driven_speed(const Model& m) {
  double fastest = 0;
  for (const ClothScene& cloth : m.scene.cloths) fastest = std::max(fastest, to_eigen(cloth.velocity).norm());
  for (const Body& body : m.bodies)
    fastest = std::max(fastest, fastest_centre(body) + fastest_spin(body) * body.reach + fastest_point(body.shape));
  for (const Joint& joint : m.joints)
    for (const Index of : {joint.body, joint.other}) {
      if (of < 0 || !(joint.torque > 0)) continue;
      const Body& body = m.bodies[static_cast<std::size_t>(of)];
      fastest = std::max(fastest,
                         joint.speed.largest() * (body.reach + (to_eigen(joint.point) - to_eigen(body.center)).norm()));
    }
  for (std::size_t n = 0; n < m.mesh.pin_motion.size(); ++n) {
    const Index own = m.mesh.pin_motion[n];
    if (own >= 0)
      fastest =
          std::max(fastest, fastest_of_pin(m, m.pin_motions[static_cast<std::size_t>(own)], m.mesh.rest_position[n]));
  }
  return fastest;
}

}  // namespace drench
