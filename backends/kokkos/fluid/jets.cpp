// Stage jets (src/stages/jets.hpp). The host decides how many particles leave; their particles are written on the
// device.

#include <algorithm>
#include <array>
#include <cmath>

#include "core/host_copy.hpp"
#include "fluid/stages.hpp"

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

}  // namespace

void jets(const Constants& constants, Fluid& fluid, Jets& jets, Accounts& accounts, const StepInfo& info) {
  ParticleSet& particles = fluid.particles;
  const double end = info.time + info.dt;
  for (std::size_t j = 0; j < constants.model.jets.size(); ++j) {
    const Jet& jet = constants.model.jets[j];
    const std::int64_t gone = jets.particles[j];
    const Outflow out = jet.has_keys() ? by_keys(jet, gone, end) : steady(jet, gone, end);
    jets.particles[j] = out.count;
    const auto count = static_cast<Index>(out.count - gone), size = static_cast<Index>(jet.offsets.size());
    if (count == 0) continue;
    const Array<Real3> offsets = jets.offsets[j];
    const Real3 center = to_real(jet.scene.center), unit = to_real(out.unit), velocity = to_real(out.velocity);
    const Real3 turn[3] = {to_real(out.turn[0]), to_real(out.turn[1]), to_real(out.turn[2])};
    const bool turns = jet.has_keys();
    const Index first = particles.count, first_offset = static_cast<Index>(gone % size);
    const std::int64_t id = particles.next_id;
    particles.next_id += count;
    particles.total += count;
    accounts.supplied += static_cast<Quanta>(count) * jet.mass;
    accounts.solute_supplied += static_cast<Quanta>(count) * jet.solute;
    if (constants.ranks && constants.ranks->rank() > 0)
      continue;  // the first has them; they go home with the next search
    particles.reserve(first + count);
    const ParticleView all = particles.view();
    const Quanta mass = jet.mass, solute = jet.solute;
    const double ahead = out.first, between = out.between;
    parallel(
        "drench::jets::particles", count, KOKKOS_LAMBDA(const Index k) {
          Real3 o = offsets((first_offset + k) % size);
          if (turns) o = {dot(turn[0], o), dot(turn[1], o), dot(turn[2], o)};
          Particle p;
          p.position = center + o + Real(ahead - k * between) * unit;
          p.velocity = velocity;
          p.mass = mass;
          p.solute = solute;
          p.id = id + k;
          p.origin = static_cast<std::uint8_t>(Origin::jet);
          all.store(first + k, p);
        });
    particles.count = first + count;
  }
}

}  // namespace drench::kokkos_backend
