#pragma once
// The fields of the state, each named once: FIELD(owner, name, type, unit, needed), `needed` by the Model `m`.
// HostState, the backends' arrays, their exchange, checkpoints and comparisons are made from these lists.

// clang-format off

/// Liquid particles. A new particle starts with 0 in all fields that its maker does not give.
#define DRENCH_PARTICLE_FIELDS(FIELD)                                                                                 \
  FIELD(fluid,    position,         Vec3,         "m",      true)                                                     \
  FIELD(fluid,    velocity,         Vec3,         "m/s",    true)                                                     \
  FIELD(fluid,    mass,             Quanta,       "quanta", true)                                                     \
  FIELD(fluid,    id,               std::int64_t, "1",      true)        /* persistent; not reused, except by files */\
  FIELD(fluid,    age,              double,       "s",      true)        /* since creation */                         \
  FIELD(fluid,    origin,           std::uint8_t, "1",      true)        /* Origin */                                 \
  FIELD(fluid,    density_ratio,    double,       "1",      true)        /* δ */                                      \
  FIELD(fluid,    kappa_density,    double,       "m²/s²",  true)        /* κ of the density solve */                 \
  FIELD(fluid,    kappa_divergence, double,       "m²/s²",  true)        /* κ of the divergence solve */              \
  FIELD(fluid,    spin,             Vec3,         "1/s",    m.has_micropolar())/* ω */                                \
  FIELD(fluid,    solute,           Quanta,       "quanta", m.has_solute())    /* of its own quantum */

/// Samples of solid bodies.
#define DRENCH_BOUNDARY_FIELDS(FIELD)                                                                                 \
  FIELD(boundary, position,         Vec3,         "m",      true)                                                     \
  FIELD(boundary, velocity,         Vec3,         "m/s",    true)                                                     \
  FIELD(boundary, volume,           double,       "m³",     true)        /* V_b */

/// The solid bodies themselves.
#define DRENCH_BODY_FIELDS(FIELD)                                                                                     \
  FIELD(body,     position,         Vec3,         "m",      true)        /* the centre */                             \
  FIELD(body,     orientation,      Quaternion,   "1",      true)        /* since t = 0 */                            \
  FIELD(body,     velocity,         Vec3,         "m/s",    true)        /* of the centre */                          \
  FIELD(body,     angular_velocity, Vec3,         "rad/s",  true)        /* in the world's axes */

/// Cloth nodes.
#define DRENCH_NODE_FIELDS(FIELD)                                                                                     \
  FIELD(node,     position,         Vec3,         "m",      true)                                                     \
  FIELD(node,     velocity,         Vec3,         "m/s",    true)                                                     \
  FIELD(node,     liquid,           Quanta,       "quanta", true)        /* m_f */                                    \
  FIELD(node,     buffered,         Quanta,       "quanta", true)        /* the excess that is ready to leave */      \
  FIELD(node,     contact_force,    Vec3,         "N",      true)        /* of the touching body, along its normal */ \
  FIELD(node,     friction_force,   Vec3,         "N",      true)        /* the same, along its surface */            \
  FIELD(node,     pin_force,        Vec3,         "N",      true)        /* reaction of its pin, 0 without one   */   \
  FIELD(node,     solute,           Quanta,       "quanta", m.has_solute())    /* dissolved or dried on */             \
  FIELD(node,     contact_pressure, double,       "Pa",     m.has_squeezing()) /* on the fabric, over some steps */   \
  FIELD(node,     scanning,         double,       "1",      m.has_hysteresis())/* γ while wetted, −φ while draining */ \
  FIELD(node,     extreme,          double,       "1",      m.has_hysteresis())/* s farthest since it turned */

/// Samples of the cloths.
#define DRENCH_SAMPLE_FIELDS(FIELD)                                                                                   \
  FIELD(sample,   volume,           double,       "m³",     m.has_fluid())/* Akinci V_b, while there is liquid */     \
  FIELD(sample,   flow_direction,   Vec3,         "1",      m.has_porous())/* v_p of Eqs. 4–6, |v_p| < 1, or 0 */     \
  FIELD(sample,   flux,             double,       "m/s",    m.has_permeation())/* u_p, along its normal */            \
  FIELD(sample,   taken_front,      Quanta,       "quanta", m.counts_faces())/* from liquid where its normal points */\
  FIELD(sample,   taken_back,       Quanta,       "quanta", m.counts_faces())/* from liquid on the other face */      \
  FIELD(sample,   given_front,      Quanta,       "quanta", m.counts_faces())/* to liquid where its normal points */  \
  FIELD(sample,   given_back,       Quanta,       "quanta", m.counts_faces())/* to liquid on the other face */

#define DRENCH_STATE_FIELDS(FIELD)                                                                                    \
  DRENCH_PARTICLE_FIELDS(FIELD)                                                                                       \
  DRENCH_BOUNDARY_FIELDS(FIELD)                                                                                       \
  DRENCH_BODY_FIELDS(FIELD)                                                                                           \
  DRENCH_NODE_FIELDS(FIELD)                                                                                           \
  DRENCH_SAMPLE_FIELDS(FIELD)

// clang-format on
