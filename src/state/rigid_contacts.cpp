#include "state/rigid_contacts.hpp"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <LinearMath/btConvexHullComputer.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "base/eigen_vec.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

// Bullet's tolerances suit bodies of a unit's size and mass, so lengths are divided by the reach of the smallest
// dynamic body, masses by the least.
constexpr double grip = 0.02;        // of that reach: overlaps up to this press, deeper ones are removed without force
constexpr double margin = 1e-3;      // of that reach: how far surfaces stay apart
constexpr double removed = 0.2;      // of an overlap, per step
constexpr double of_one_step = 0.5;  // of an overlap: where that much comes or goes in the step it presses nothing
constexpr double at_rest = 4;        // × what gravity gives in a step: slower bodies rest
constexpr int iterations = 50;       // without the last step's impulses, which a checkpoint would have to keep
constexpr int most_corners = 256;    // of a hull whose faces are clipped against others
constexpr double convex_excess = 0.01;  // of the volume, between a mesh and its hull

btVector3 bullet(const Vector3d& v) { return {v[0], v[1], v[2]}; }
Vector3d eigen(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Quaterniond eigen(const Quaternion& q) { return {q[0], q[1], q[2], q[3]}; }

double volume_of(const std::vector<Vector3d>& points, const std::vector<std::array<Index, 3>>& triangles) {
  double volume = 0;
  for (const auto& t : triangles) {
    const auto at = [&](int k) -> const Vector3d& {
      return points[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
    };
    volume += at(0).dot(at(1).cross(at(2))) / 6;
  }
  return volume;
}

/// The corners of the convex hull, and its volume.
std::vector<Vector3d> hull_of(const std::vector<Vector3d>& points, double& volume) {
  btConvexHullComputer hull;
  hull.compute(points.front().data(), sizeof(Vector3d), static_cast<int>(points.size()), 0, 0);
  std::vector<Vector3d> corners;
  for (int i = 0; i < hull.vertices.size(); ++i) corners.push_back(eigen(hull.vertices[i]));
  volume = 0;
  for (int f = 0; f < hull.faces.size(); ++f) {
    const btConvexHullComputer::Edge* const first = &hull.edges[hull.faces[f]];
    const Vector3d& a = corners[static_cast<std::size_t>(first->getSourceVertex())];
    for (auto* e = first->getNextEdgeOfFace(); e != first; e = e->getNextEdgeOfFace()) {
      const Vector3d &b = corners[static_cast<std::size_t>(e->getSourceVertex())],
                     &c = corners[static_cast<std::size_t>(e->getTargetVertex())];
      volume += a.dot(b.cross(c)) / 6;
    }
  }
  volume = std::abs(volume);
  return corners;
}

btDefaultCollisionConstructionInfo small_pools() {
  btDefaultCollisionConstructionInfo info;
  info.m_defaultMaxPersistentManifoldPoolSize = info.m_defaultMaxCollisionAlgorithmPoolSize = 64;
  return info;
}

}  // namespace

struct RigidContacts::World {
  /// Bullet's world, which lets its contacts be changed once they are found.
  class FoundWorld : public btDiscreteDynamicsWorld {
   public:
    using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;
    std::function<void()> found;

   private:
    void solveConstraints(btContactSolverInfo& info) override {
      if (found) found();
      btDiscreteDynamicsWorld::solveConstraints(info);
    }
  };

  /// What a shape needs beside itself.
  struct Mesh {
    std::vector<Vector3d> points;
    std::vector<std::array<Index, 3>> triangles;
    std::unique_ptr<btTriangleIndexVertexArray> arrays;
  };

  explicit World(const Model& model)
      : extent_((to_eigen(model.scene.domain.max) - to_eigen(model.scene.domain.min)).norm()),
        gravity_(to_eigen(model.scene.gravity).norm()) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
    double reach = 1e300, mass = 1e300;
    for (const Body& b : model.bodies) {
      if (!b.dynamic) continue;
      reach = std::min(reach, b.reach);
      mass = std::min(mass, b.mass);
    }
    per_m_ = 1 / reach;
    per_kg_ = 1 / mass;
    world_.setGravity({0, 0, 0});
    world_.getDispatchInfo().m_deterministicOverlappingPairs = true;
    btContactSolverInfo& solver = world_.getSolverInfo();
    solver.m_numIterations = iterations;
    solver.m_splitImpulse = 1;
    solver.m_splitImpulsePenetrationThreshold = -grip;
    solver.m_restitutionVelocityThreshold = 0;
    solver.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
    for (const Body& b : model.bodies) add(b);
    for (const Joint& j : model.joints) add(j);
  }

  std::vector<ContactImpulse> advance(std::vector<RigidMotion>& motion, double dt, double end, double share) {
    leave();
    world_.getSolverInfo().m_erp = world_.getSolverInfo().m_erp2 = removed * share;
    enter(motion, dt, end);
    world_.found = [&] { release_impacts(motion, dt); };
    world_.stepSimulation(dt, 0);
    world_.found = nullptr;
    std::vector<ContactImpulse> contacts(bodies_.size());
    for (Hinge& h : hinges_) unfasten(h, dt, contacts);
    for (int k = 0; k < dispatcher_.getNumManifolds(); ++k)
      add_impulses(*dispatcher_.getManifoldByIndexInternal(k), motion, contacts);
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (bodies_[b] && constant_[b]->dynamic && contacts[b].touched) motion[b] = motion_of(b);
    part_impacts(motion, dt);
    leave();
    return contacts;
  }

  bool touches(const std::vector<RigidMotion>& motion, double dt, double end) {
    detect(motion, dt, end);
    return std::find(held_.begin(), held_.end(), true) != held_.end();
  }

  void hold(std::vector<RigidMotion>& motion, double dt, double end, double share) {
    if (!touches(motion, dt, end)) return;
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (bodies_[b]) set_motion(b, motion[b]);
    std::vector<btTypedConstraint*> joints;
    for (Hinge& h : hinges_) {
      make(h, dt, end);
      joints.push_back(h.constraint.get());
    }
    release_impacts(motion, dt);
    btContactSolverInfo info = world_.getSolverInfo();
    info.m_timeStep = dt;
    info.m_solverMode &= ~SOLVER_USE_WARMSTARTING;  // it would begin with the impulses of the last call
    info.m_erp = info.m_erp2 = removed * share;
    solver_.solveGroup(all_.data(), static_cast<int>(all_.size()), dispatcher_.getInternalManifoldPointer(),
                       dispatcher_.getNumManifolds(), joints.data(), static_cast<int>(joints.size()), info, nullptr,
                       &dispatcher_);
    for (Hinge& h : hinges_) h.constraint.reset();
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (!held_[b]) continue;
      motion[b].velocity = to_vec3(eigen(bodies_[b]->getLinearVelocity()) / per_m_);
      motion[b].spin = to_vec3(eigen(bodies_[b]->getAngularVelocity()));
    }
  }

 private:
  struct Hinge {
    const Joint* joint;
    btTransform own, others;  // of the hinge in the bodies, z along the axis
    std::unique_ptr<btHingeConstraint> constraint;
    btJointFeedback feedback;
  };

  /// A contact point between two bodies, in m and m/s: the normal points from the second to the first.
  struct Point {
    std::size_t first, second;
    Vector3d at, normal;
    double overlap;
    /// At which the bodies approach, below 0 if they part.
    double approach(const std::vector<RigidMotion>& motion) const {
      const auto velocity = [&](std::size_t b) {
        const RigidMotion& m = motion[b];
        return Vector3d(to_eigen(m.velocity) + to_eigen(m.spin).cross(at - to_eigen(m.position)));
      };
      return (velocity(second) - velocity(first)).dot(normal);
    }
  };
  /// Calls each(point of Bullet, the same in SI).
  void for_each_point(const std::function<void(btManifoldPoint&, const Point&)>& each) {
    for (int k = 0; k < dispatcher_.getNumManifolds(); ++k) {
      btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(k);
      for (int c = 0; c < manifold.getNumContacts(); ++c) {
        btManifoldPoint& p = manifold.getContactPoint(c);
        each(p, {static_cast<std::size_t>(manifold.getBody0()->getUserIndex()),
                 static_cast<std::size_t>(manifold.getBody1()->getUserIndex()), eigen(p.getPositionWorldOnB()) / per_m_,
                 eigen(p.m_normalWorldOnB), -p.getDistance() / per_m_});
      }
    }
  }
  /// What presses is an overlap that lasts, of jaws for example. One that bodies bring along in this step, or leave by
  /// themselves, would become velocity that nothing has given them.
  void release_impacts(const std::vector<RigidMotion>& motion, double dt) {
    for_each_point([&](btManifoldPoint& p, const Point& point) {
      const double speed = std::abs(point.approach(motion));
      const bool comes_or_goes =
          point.overlap > 0 && speed * dt > of_one_step * point.overlap && speed > at_rest * gravity_ * dt;
      p.m_contactERP = 0;
      if (comes_or_goes)
        p.m_contactPointFlags |= BT_CONTACT_FLAG_HAS_CONTACT_ERP;
      else
        p.m_contactPointFlags &= ~BT_CONTACT_FLAG_HAS_CONTACT_ERP;
    });
  }
  /// Of those overlaps the rest that the bodies do not leave in the step is removed, without force.
  void part_impacts(std::vector<RigidMotion>& motion, double dt) {
    std::vector<Vector3d> shift(bodies_.size(), Vector3d::Zero());
    for_each_point([&](btManifoldPoint& p, const Point& point) {
      if ((p.m_contactPointFlags & BT_CONTACT_FLAG_HAS_CONTACT_ERP) == 0) return;
      const auto [first, second] = std::pair(point.first, point.second);
      const auto lightness = [&](std::size_t b) { return constant_[b]->dynamic ? 1 / constant_[b]->mass : 0; };
      const double rest =
          point.overlap + dt * std::min(0.0, point.approach(motion)) - (shift[first] - shift[second]).dot(point.normal);
      const double sum = lightness(first) + lightness(second);
      if (!(rest > 0 && sum > 0)) return;
      shift[first] += lightness(first) / sum * rest * point.normal;
      shift[second] -= lightness(second) / sum * rest * point.normal;
    });
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (!shift[b].isZero(0)) motion[b].position = to_vec3(to_eigen(motion[b].position) + shift[b]);
  }

  void enter(const std::vector<RigidMotion>& motion, double dt, double end) {
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (bodies_[b]) place(b, motion[b], dt);
    for (Hinge& h : hinges_) {
      make(h, dt, end);
      h.constraint->setJointFeedback(&h.feedback);
      world_.addConstraint(h.constraint.get(), true);  // the two do not collide
    }
  }
  void leave() {
    detected_.clear();
    for (const auto& body : bodies_)
      if (body && body->isInWorld()) world_.removeRigidBody(body.get());
    broadphase_.resetPool(&dispatcher_);
    solver_.reset();
  }

  /// Finds the contacts, unless those found last are of the same poses, and which dynamic bodies these and hinges hold.
  void detect(const std::vector<RigidMotion>& motion, double dt, double end) {
    const auto at_same_place = [](const RigidMotion& a, const RigidMotion& b) {
      return a.position == b.position && a.orientation == b.orientation;
    };
    if (std::equal(motion.begin(), motion.end(), detected_.begin(), detected_.end(), at_same_place)) return;
    leave();
    enter(motion, dt, end);
    world_.performDiscreteCollisionDetection();
    held_.assign(bodies_.size(), false);
    const auto hold = [&](Index b) {
      if (b >= 0 && constant_[static_cast<std::size_t>(b)]->dynamic) held_[static_cast<std::size_t>(b)] = true;
    };
    for (Hinge& h : hinges_) {
      world_.removeConstraint(h.constraint.get());
      h.constraint.reset();
      hold(h.joint->body);
      hold(h.joint->other);
    }
    for (int k = 0; k < dispatcher_.getNumManifolds(); ++k) {
      btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(k);
      for (int c = 0; c < manifold.getNumContacts(); ++c) manifold.getContactPoint(c).m_combinedRestitution = 0;
      if (manifold.getNumContacts() == 0) continue;
      hold(manifold.getBody0()->getUserIndex());
      hold(manifold.getBody1()->getUserIndex());
    }
    detected_ = motion;
  }
  void add(const Joint& j) {
    const auto turn = shortest_turn(Vector3d::UnitZ(), to_eigen(j.axis));
    const auto place_in = [&](const Body& b) {
      const Eigen::Quaterniond back = eigen(b.principal).conjugate(), own = back * turn;
      const Vector3d arm = back * (to_eigen(j.point) - to_eigen(b.center));
      return btTransform({own.x(), own.y(), own.z(), own.w()}, bullet(per_m_ * arm));
    };
    const btTransform in_world({turn.x(), turn.y(), turn.z(), turn.w()}, bullet(per_m_ * to_eigen(j.point)));
    hinges_.push_back({&j,
                       place_in(*constant_[static_cast<std::size_t>(j.body)]),
                       j.other < 0 ? in_world : place_in(*constant_[static_cast<std::size_t>(j.other)]),
                       nullptr,
                       {}});
  }
  /// A hinge is made anew for each step, so that nothing is kept.
  void make(Hinge& h, double dt, double end) {
    const Joint& j = *h.joint;
    btRigidBody& other = j.other < 0 ? anchor_ : *bodies_[static_cast<std::size_t>(j.other)];
    h.constraint =
        std::make_unique<btHingeConstraint>(*bodies_[static_cast<std::size_t>(j.body)], other, h.own, h.others);
    h.constraint->setUseFrameOffset(false);  // with it the joint to a body that turns is not exact
    const double speed = j.speed.at(end), most = j.torque * dt * per_kg_ * per_m_ * per_m_;  // impulse of the motor
    const bool stopped = j.limited && set_stops(h, speed, most, dt);
    // A motor and a stop share one row in Bullet, where the motor's torque would have no limit.
    if (j.torque > 0 && !stopped) h.constraint->enableAngularMotor(true, speed, most);
  }
  /// Bullet stops a body that is beyond a limit, which a light one under a great load would be by far: a body that
  /// would pass its limit in this step, against its motor, stops where it is. Returns whether it does.
  bool set_stops(Hinge& h, double speed, double most, double dt) const {
    constexpr double beyond = 1e-9;  // rad
    const Joint& j = *h.joint;
    const double middle = 0.5 * (j.low + j.high);
    const double angle = middle + std::remainder(h.constraint->getHingeAngle() - middle, 2 * std::numbers::pi);
    const double next = angle + dt * rate_of(h, speed, most);
    double low = j.low, high = j.high;
    if (next < low) low = std::max(low, angle + beyond);
    if (next > high) high = std::min(high, angle - beyond);
    h.constraint->setLimit(std::min(low, high), high, 0.9, 0.3, 0);  // without bounce
    return next < j.low || next > j.high;
  }
  /// The rate, rad/s, at which the hinge and its motor would leave the body turning relative to the other: (5b) of
  /// docs/theory/bodies.md.
  double rate_of(const Hinge& h, double speed, double most) const {
    const Joint& j = *h.joint;
    const btRigidBody& body = *bodies_[static_cast<std::size_t>(j.body)];
    const btTransform& at = body.getWorldTransform();
    const btVector3 axis = at.getBasis() * h.own.getBasis().getColumn(2), arm = at.getBasis() * h.own.getOrigin();
    const btVector3 lever = arm.cross(axis);
    btVector3 carried(0, 0, 0), turned(0, 0, 0);
    if (j.other >= 0) {
      const btRigidBody& other = *bodies_[static_cast<std::size_t>(j.other)];
      turned = other.getInterpolationAngularVelocity();
      carried =
          other.getInterpolationLinearVelocity() + turned.cross(at.getOrigin() - other.getWorldTransform().getOrigin());
    }
    const btMatrix3x3 tensor = body.getInvInertiaTensorWorld().inverse();
    const double mass = 1 / body.getInvMass(), inertia = axis.dot(tensor * axis) + mass * lever.dot(lever);
    const double rate = (axis.dot(tensor * (body.getAngularVelocity() - turned)) +
                         mass * lever.dot(body.getLinearVelocity() - carried)) /
                        inertia;
    return rate + std::clamp(speed - rate, -most / inertia, most / inertia);
  }
  void unfasten(Hinge& h, double dt, std::vector<ContactImpulse>& contacts) {
    const Joint& j = *h.joint;
    const auto add = [&](Index body, const btVector3& force, const btVector3& torque) {
      if (body < 0) return;
      ContactImpulse& c = contacts[static_cast<std::size_t>(body)];
      c.touched = true;
      c.impulse = to_vec3(to_eigen(c.impulse) + dt / (per_m_ * per_kg_) * eigen(force));
      c.turning = to_vec3(to_eigen(c.turning) + dt / (per_m_ * per_m_ * per_kg_) * eigen(torque));
    };
    add(j.body, h.feedback.m_appliedForceBodyA, h.feedback.m_appliedTorqueBodyA);
    add(j.other, h.feedback.m_appliedForceBodyB, h.feedback.m_appliedTorqueBodyB);
    world_.removeConstraint(h.constraint.get());
    h.constraint.reset();
  }

  void add(const Body& b) {
    constant_.push_back(&b);
    btCollisionShape* const shape = b.deforms() ? nullptr : shape_of(b);
    bodies_.emplace_back();
    if (shape == nullptr) return;
    btVector3 inertia(0, 0, 0);
    if (b.dynamic) inertia = bullet(per_kg_ * per_m_ * per_m_ * to_eigen(b.inertia));
    btRigidBody::btRigidBodyConstructionInfo info(b.dynamic ? per_kg_ * b.mass : 0, nullptr, shape, inertia);
    info.m_friction = std::sqrt(b.friction);  // Bullet multiplies those of two bodies
    info.m_restitution = std::sqrt(b.restitution);
    info.m_linearDamping = info.m_angularDamping = 0;
    auto body = std::make_unique<btRigidBody>(info);
    if (!b.dynamic) body->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    body->setActivationState(DISABLE_DEACTIVATION);
    body->setFlags(0);  // the gyroscopic term is (4) of docs/theory/bodies.md
    body->setUserIndex(static_cast<int>(bodies_.size()) - 1);
    if (b.dynamic && shape->isConvex()) {  // fast ones do not pass through thin ones
      btVector3 low, high;
      shape->getAabb(btTransform::getIdentity(), low, high);
      const double inner = 0.25 * std::min({high.x() - low.x(), high.y() - low.y(), high.z() - low.z()});
      body->setCcdMotionThreshold(inner);
      body->setCcdSweptSphereRadius(inner);
    }
    all_.push_back(body.get());
    bodies_.back() = std::move(body);
  }

  btCollisionShape* keep(std::unique_ptr<btCollisionShape> shape) {
    shape->setMargin(margin);
    shapes_.push_back(std::move(shape));
    return shapes_.back().get();
  }
  btCollisionShape* box(const Vector3d& half) {
    auto shape = std::make_unique<btBoxShape>(bullet(half));
    shape->initializePolyhedralFeatures();
    return keep(std::move(shape));
  }

  /// About the body's centre, along its principal axes.
  btCollisionShape* shape_of(const Body& b) {
    const double far = per_m_ * extent_;
    const auto from_center = [&](const Vec3& x) -> Vector3d { return per_m_ * (to_eigen(x) - to_eigen(b.center)); };
    switch (b.kind) {
      case BodyScene::Kind::sphere:
        return keep(std::make_unique<btSphereShape>(per_m_ * b.radius));
      case BodyScene::Kind::box: {
        const Vector3d half = 0.5 * per_m_ * (to_eigen(b.box.max) - to_eigen(b.box.min));
        if (!b.inside) return box(half);
        auto walls = std::make_unique<btCompoundShape>();
        for (int axis = 0; axis < 3; ++axis)
          for (const double side : {-1.0, 1.0}) {
            Vector3d size = half + Vector3d::Constant(far), at = Vector3d::Zero();
            size[axis] = far;
            at[axis] = side * (half[axis] + far);
            walls->addChildShape(btTransform(btQuaternion::getIdentity(), bullet(at)), box(size));
          }
        return keep(std::move(walls));
      }
      case BodyScene::Kind::plane: {
        auto half_space = std::make_unique<btCompoundShape>();
        const auto turn = shortest_turn(Vector3d::UnitY(), to_eigen(b.normal));
        half_space->addChildShape(
            btTransform(btQuaternion(turn.x(), turn.y(), turn.z(), turn.w()), bullet(-far * to_eigen(b.normal))),
            box(Vector3d::Constant(far)));
        return keep(std::move(half_space));
      }
      case BodyScene::Kind::mesh:
        break;
    }
    auto& mesh = *meshes_.emplace_back(std::make_unique<Mesh>());
    const Eigen::Quaterniond own = eigen(b.principal).conjugate();
    for (const Vec3& x : b.mesh_points) mesh.points.push_back(own * from_center(x));
    mesh.triangles = b.mesh_triangles;
    if (mesh.triangles.empty()) return nullptr;
    if (!b.field.empty() || b.dynamic) {  // closed
      double hull_volume = 0;
      const std::vector<Vector3d> hull = hull_of(mesh.points, hull_volume);
      if (hull_volume <= (1 + convex_excess) * volume_of(mesh.points, mesh.triangles)) {
        auto shape =
            std::make_unique<btConvexHullShape>(hull.front().data(), static_cast<int>(hull.size()), sizeof(Vector3d));
        if (hull.size() <= most_corners) shape->initializePolyhedralFeatures();
        return keep(std::move(shape));
      }
    }
    mesh.arrays = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(mesh.triangles.size()), mesh.triangles.front().data(),
        static_cast<int>(sizeof(mesh.triangles[0])), static_cast<int>(mesh.points.size()), mesh.points.front().data(),
        static_cast<int>(sizeof(Vector3d)));
    if (!b.dynamic) return keep(std::make_unique<btBvhTriangleMeshShape>(mesh.arrays.get(), true));
    auto shape = std::make_unique<btGImpactMeshShape>(mesh.arrays.get());
    shape->setMargin(margin);
    shape->updateBound();
    return keep(std::move(shape));
  }

  void set_motion(std::size_t b, const RigidMotion& m) {
    btRigidBody& body = *bodies_[b];
    const Eigen::Quaterniond turn = eigen(m.orientation) * eigen(constant_[b]->principal);
    body.setCenterOfMassTransform(btTransform(btQuaternion(turn.x(), turn.y(), turn.z(), turn.w()).normalized(),
                                              bullet(per_m_ * to_eigen(m.position))));
    const btVector3 velocity = bullet(per_m_ * to_eigen(m.velocity)), spin = bullet(to_eigen(m.spin));
    body.setLinearVelocity(velocity);
    body.setAngularVelocity(spin);
    body.setInterpolationLinearVelocity(velocity);
    body.setInterpolationAngularVelocity(spin);
  }
  void place(std::size_t b, const RigidMotion& m, double dt) {
    set_motion(b, m);
    btRigidBody& body = *bodies_[b];
    btTransform before = body.getWorldTransform();
    if (!constant_[b]->dynamic)  // Bullet takes its velocity from where it was
      btTransformUtil::integrateTransform(body.getWorldTransform(), -body.getLinearVelocity(),
                                          -body.getAngularVelocity(), dt, before);
    body.setInterpolationWorldTransform(before);
    body.clearForces();
    world_.addRigidBody(&body);
  }

  RigidMotion motion_of(std::size_t b) const {
    const btTransform& at = bodies_[b]->getWorldTransform();
    const btQuaternion turn = at.getRotation();
    const Eigen::Quaterniond own =
        (Eigen::Quaterniond(turn.w(), turn.x(), turn.y(), turn.z()) * eigen(constant_[b]->principal).conjugate())
            .normalized();
    return {to_vec3(eigen(at.getOrigin()) / per_m_),
            to_vec3(eigen(bodies_[b]->getLinearVelocity()) / per_m_),
            to_vec3(eigen(bodies_[b]->getAngularVelocity())),
            {own.w(), own.x(), own.y(), own.z()}};
  }

  void add_impulses(const btPersistentManifold& manifold, const std::vector<RigidMotion>& motion,
                    std::vector<ContactImpulse>& contacts) const {
    const auto first = static_cast<std::size_t>(manifold.getBody0()->getUserIndex()),
               second = static_cast<std::size_t>(manifold.getBody1()->getUserIndex());
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& p = manifold.getContactPoint(k);
      if (p.m_appliedImpulse == 0 && p.getDistance() >= 0) continue;
      const Vector3d at = eigen(p.getPositionWorldOnB()) / per_m_,
                     impulse = eigen(p.m_appliedImpulse * p.m_normalWorldOnB +
                                     p.m_appliedImpulseLateral1 * p.m_lateralFrictionDir1 +
                                     p.m_appliedImpulseLateral2 * p.m_lateralFrictionDir2) /
                               (per_m_ * per_kg_);
      for (const auto& [b, sign] : {std::pair{first, 1.0}, std::pair{second, -1.0}}) {
        ContactImpulse& c = contacts[b];
        c.touched = true;
        c.impulse = to_vec3(to_eigen(c.impulse) + sign * impulse);
        c.turning = to_vec3(to_eigen(c.turning) + sign * (at - to_eigen(motion[b].position)).cross(impulse));
      }
    }
  }

  double extent_, gravity_, per_m_ = 1, per_kg_ = 1;  // m, m/s²
  btDefaultCollisionConfiguration configuration_{small_pools()};
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  FoundWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<Mesh>> meshes_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;  // null: changes its shape, and has no contacts
  std::vector<const Body*> constant_;
  btRigidBody anchor_{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, nullptr)};  // the world, of hinges
  std::vector<Hinge> hinges_;
  std::vector<btCollisionObject*> all_;  // of bodies_
  std::vector<RigidMotion> detected_;    // where bodies are whose contacts the dispatcher has
  std::vector<bool> held_;               // by those contacts or hinges
};

RigidContacts::RigidContacts(const Model& model) : world_(std::make_unique<World>(model)) {}
RigidContacts::~RigidContacts() = default;

std::vector<ContactImpulse> RigidContacts::advance(std::vector<RigidMotion>& motion, double dt, double end,
                                                   double share) {
  return world_->advance(motion, dt, end, share);
}

bool RigidContacts::touches(const std::vector<RigidMotion>& motion, double dt, double end) {
  return world_->touches(motion, dt, end);
}

void RigidContacts::hold(std::vector<RigidMotion>& motion, double dt, double end, double share) {
  world_->hold(motion, dt, end, share);
}

}  // namespace drench
