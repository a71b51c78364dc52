#include "state/driven_speed.hpp"

#include <algorithm>
#include <cmath>

#include "state/deforming_body.hpp"

namespace drench {
namespace {

double norm(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }
Vec3 between(const Vec3& a, const Vec3& b) { return {b[0] - a[0], b[1] - a[1], b[2] - a[2]}; }

/// Of the centre, m/s.
double fastest_centre(const Body& body) {
  return body.velocity.largest() + body.path.largest_derivative() + norm(body.command.velocity);
}
/// rad/s
double fastest_spin(const Body& body) {
  return std::max(body.spin_rate.largest(), body.turn_rate) + norm(body.command.spin);
}

double fastest_of_pin(const Model& m, const PinMotion& pin, const Vec3& x) {
  if (pin.body >= 0) {
    const Body& body = m.bodies[static_cast<std::size_t>(pin.body)];
    return fastest_centre(body) + fastest_spin(body) * pin.reach;
  }
  const Vec3 arm = between(pin.center, x), &k = pin.axis;
  const Vec3 across{k[1] * arm[2] - k[2] * arm[1], k[2] * arm[0] - k[0] * arm[2], k[0] * arm[1] - k[1] * arm[0]};
  return pin.velocity.largest() + pin.path.largest_derivative() + pin.rate.largest() * norm(across);
}

}  // namespace

double driven_speed(const Model& m) {
  double fastest = 0;
  for (const ClothScene& cloth : m.scene.cloths) fastest = std::max(fastest, norm(cloth.velocity));
  for (const Body& body : m.bodies)
    fastest = std::max(fastest, fastest_centre(body) + fastest_spin(body) * body.reach + fastest_point(body.shape));
  for (const Joint& joint : m.joints)
    for (const Index of : {joint.body, joint.other}) {
      if (of < 0 || !(joint.torque > 0)) continue;
      const Body& body = m.bodies[static_cast<std::size_t>(of)];
      fastest = std::max(fastest, joint.speed.largest() * (body.reach + norm(between(joint.point, body.center))));
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
