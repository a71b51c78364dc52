// Stage jets (src/stages/jets.hpp). The host decides how many particles leave; their particles are written on the
// device.

#include <algorithm>
#include <array>
#include <cmath>

#include "core/host_copy.hpp"
#include "fluid/stages.hpp"
#include "state/nozzle.hpp"

namespace drench::kokkos_backend {

namespace {

using Matrix = std::array<Vec3, 3>;  // rows

/// What leaves a nozzle in a step: a particle is `first` − k · `between` of `unit` ahead of its point of the mouth.
struct Outflow {
  std::int64_t count = 0;  // that have left by the step's end
  double first = 0, between = 0;
  Vec3 unit{}, velocity{};  // m/s · s or m · 1, as `first` is; m/s
  Matrix turn{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
};

/// The shortest rotation from one unit vector to another: 1 + [w]× + [w]×²/(1 + c), w = a × b, c = a·b.
Matrix shortest_turn(const Vec3& a, const Vec3& b) {
  const Vec3 w{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  const double c = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  Matrix m;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) m[i][j] = (i == j ? c : 0) + w[i] * w[j] / (1 + c);
  m[0][1] -= w[2];
  m[0][2] += w[1];
  m[1][0] += w[2];
  m[1][2] -= w[0];
  m[2][0] -= w[1];
  m[2][1] += w[0];
  return m;
}

/// Eqs. 28, 29.
Outflow steady(const Jet& jet, std::int64_t gone, double end) {
  Outflow out;
  for (out.count = gone;; ++out.count) {
    const double leaves = jet.scene.start + (double(out.count) + 0.5) * jet.interval;
    if (leaves > end || leaves >= jet.scene.end) break;
  }
  out.first = end - (jet.scene.start + (double(gone) + 0.5) * jet.interval);
  out.between = jet.interval;
  out.unit = out.velocity = jet.scene.velocity.plain();
  return out;
}

/// Eqs. 30, 31.
Outflow by_keys(const Jet& jet, std::int64_t gone, double end) {
  Outflow out;
  const double column = jet.out(end);
  out.count = std::max(gone, static_cast<std::int64_t>(std::floor(column / jet.advance + 0.5)));
  while (out.count > gone && (double(out.count - 1) + 0.5) * jet.advance > column) --out.count;
  while ((double(out.count) + 0.5) * jet.advance <= column && column > 0) ++out.count;
  out.first = column - (double(gone) + 0.5) * jet.advance;
  out.between = jet.advance;
  const Vec3 aim = jet.aim.at(end);
  const double length = std::sqrt(aim[0] * aim[0] + aim[1] * aim[1] + aim[2] * aim[2]), speed = jet.speed.at(end);
  for (std::size_t a = 0; a < 3; ++a) {
    out.unit[a] = aim[a] / length;
    out.velocity[a] = speed * out.unit[a];
  }
  out.turn = shortest_turn(jet.aim.plain(), out.unit);
  return out;
}

/// Eqs. 29b to 29f: particles that leave each at a time of its own, at the step's end; a position and a velocity each.
std::vector<Vec3> leave_mouth(const Jet& jet, double particle_volume, std::int64_t gone, double begin, double end) {
  std::vector<Vec3> particles;
  const double volume = volume_out(jet, end);
  double time = std::max(begin, jet.scene.start);
  for (std::int64_t k = gone; (double(k) + 0.5) * particle_volume <= volume; ++k) {
    time = time_of_volume(jet, (double(k) + 0.5) * particle_volume, time, end);
    const Leaving p = leaving_particle(jet, k, time);
    Vec3 x = p.position;
    for (std::size_t a = 0; a < 3; ++a) x[a] += (end - time) * p.velocity[a];
    particles.push_back(x);
    particles.push_back(p.velocity);
  }
  return particles;
}

/// Ids, and what the accounts say, of particles that leave a jet; false on a rank that does not have them.
bool enter(const Constants& constants, const Jet& jet, Index count, ParticleSet& particles, Accounts& accounts) {
  particles.next_id += count;
  particles.total += count;
  accounts.supplied += static_cast<Quanta>(count) * jet.mass;
  accounts.solute_supplied += static_cast<Quanta>(count) * jet.solute;
  // The first rank has them; they go home with the next search.
  if (constants.ranks && constants.ranks->rank() > 0) return false;
  particles.reserve(particles.count + count);
  return true;
}

KOKKOS_INLINE_FUNCTION Particle new_particle(const Real3& position, const Real3& velocity, Quanta mass, Quanta solute,
                                             std::int64_t id, Origin origin) {
  Particle p;
  p.position = position;
  p.velocity = velocity;
  p.mass = mass;
  p.solute = solute;
  p.id = id;
  p.origin = static_cast<std::uint8_t>(origin);
  return p;
}

void from_lattice(const Constants& constants, const Jet& jet, const Array<Real3>& mouth, std::int64_t& gone,
                  ParticleSet& particles, Accounts& accounts, double end) {
  const Outflow out = jet.has_keys() ? by_keys(jet, gone, end) : steady(jet, gone, end);
  const auto count = static_cast<Index>(out.count - gone), size = static_cast<Index>(jet.offsets.size());
  const Index first = particles.count, first_offset = static_cast<Index>(gone % size);
  const std::int64_t id = particles.next_id;
  gone = out.count;
  if (count == 0 || !enter(constants, jet, count, particles, accounts)) return;
  const Array<Real3> offsets = mouth;
  const Real3 center = to_real(jet.scene.center), unit = to_real(out.unit), velocity = to_real(out.velocity);
  const Real3 turn[3] = {to_real(out.turn[0]), to_real(out.turn[1]), to_real(out.turn[2])};
  const bool turns = jet.has_keys();
  const ParticleView all = particles.view();
  const Quanta mass = jet.mass, solute = jet.solute;
  const double ahead = out.first, between = out.between;
  parallel(
      "drench::jets::particles", count, KOKKOS_LAMBDA(const Index k) {
        Real3 o = offsets((first_offset + k) % size);
        if (turns) o = {dot(turn[0], o), dot(turn[1], o), dot(turn[2], o)};
        all.store(first + k, new_particle(center + o + Real(ahead - k * between) * unit, velocity, mass, solute, id + k,
                                          Origin::jet));
      });
  particles.count = first + count;
}

void from_mouth(const Constants& constants, const Jet& jet, Array<Real3>& leaving, std::int64_t& gone,
                ParticleSet& particles, Accounts& accounts, const StepInfo& info) {
  const double d = constants.model.spacing;
  const std::vector<Vec3> host = leave_mouth(jet, d * d * d, gone, info.time, info.time + info.dt);
  const auto count = static_cast<Index>(host.size() / 2);
  const Index first = particles.count;
  const std::int64_t id = particles.next_id;
  gone += count;
  if (count == 0 || !enter(constants, jet, count, particles, accounts)) return;
  make_ample_room(leaving, "drench::jets::leaving", host.size());
  copy_to_device(leaving, host);
  const Array<Real3> from = leaving;
  const ParticleView all = particles.view();
  const Quanta mass = jet.mass, solute = jet.solute;
  parallel(
      "drench::jets::leaving", count, KOKKOS_LAMBDA(const Index k) {
        all.store(first + k, new_particle(from(2 * k), from(2 * k + 1), mass, solute, id + k, Origin::mouth));
      });
  particles.count = first + count;
}

}  // namespace

void jets(const Constants& constants, Fluid& fluid, Jets& jets, Accounts& accounts, const StepInfo& info) {
  for (std::size_t j = 0; j < constants.model.jets.size(); ++j) {
    const Jet& jet = constants.model.jets[j];
    if (jet.mouth)
      from_mouth(constants, jet, jets.leaving, jets.particles[j], fluid.particles, accounts, info);
    else
      from_lattice(constants, jet, jets.offsets[j], jets.particles[j], fluid.particles, accounts, info.time + info.dt);
  }
}

}  // namespace drench::kokkos_backend
