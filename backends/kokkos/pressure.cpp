// Stage pressure (src/stages/pressure.hpp).

#include "stages/pressure.hpp"

#include <optional>

#include "cloth_solver.hpp"
#include "pressure_system.hpp"
#include "primitives/reduce.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {
namespace {

/// t(o): what a step takes back of a compression (src/stages/pressure.hpp); of what is less dense than at rest, all.
KOKKOS_INLINE_FUNCTION Real taken_back(Real over, Real share) {
  constexpr Real most = Real(0.1);
  return Kokkos::fmin(over, Kokkos::fmax(Real(0.5) * over, Kokkos::fmin(share * over, most)));
}

/// The sums that steer the iteration (pressure_system.hpp), and what is left of the compression: its sum and maximum.
struct PressureSums {
  ThreeSums steering;
  double error = 0, error_max = 0;
  KOKKOS_INLINE_FUNCTION PressureSums& operator+=(const PressureSums& o) {
    steering += o.steering;
    error += o.error;
    if (o.error_max > error_max) error_max = o.error_max;
    return *this;
  }
};

/// The cloth inside the solve: its implicit step goes on while the pressure changes.
class ElasticCloth {
 public:
  ElasticCloth(Device& d, Real dt)
      : device_(d),
        dt_(dt),
        most_iterations_(cloth_iterations_per_pressure(d.model.scene.cloth_solver)),
        iteration_(d, dt) {
    start();
  }

  /// The shift of the velocity as it is, and the target without the pressure's part. Not in the constructor: nvcc wants
  /// kernels in functions that have an address.
  void start() {
    Device& d = device_;
    const Real dt = dt_;
    const ClothSystem s = iteration_.system();
    const auto v = d.nodes.velocity, f = d.nodes.force, pin = d.nodes.pin_force;
    const auto contact = d.nodes.contact_force, friction = d.nodes.friction_force;
    const auto base = d.cloth_work.base, shift = d.cloth_work.shift, last = d.cloth_work.last_shift;
    parallel(
        "drench::pressure::cloth_start", d.nodes.count, KOKKOS_LAMBDA(const Index n) { shift(n) = dt * v(n); });
    parallel(
        "drench::pressure::cloth_base", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
          last(n) = shift(n);
          const Real3 elastic = s.elastic_force(n, shift);
          if (s.pinned(n)) {
            pin(n) += elastic + f(n);
            return;
          }
          base(n) = shift(n) - (dt * dt / s.mass(n)) * (elastic + f(n) + contact(n) + friction(n));
        });
  }

  /// Node forces → target → some iterations → samples.predicted.
  void respond() {
    Device& d = device_;
    const ClothSystem s = iteration_.system();
    const Real dt = dt_;
    const auto base = d.cloth_work.base, f = d.nodes.force;
    parallel(
        "drench::pressure::cloth_target", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
          if (!s.pinned(n)) s.target(n) = base(n) + (dt * dt / s.mass(n)) * f(n);
        });
    iteration_.run(most_iterations_);
    const auto shift = d.cloth_work.shift;
    const auto predicted = d.samples.predicted;
    const auto node = d.samples.node;
    const auto weight = d.samples.weight;
    parallel(
        "drench::pressure::sample_velocity", d.samples.count, KOKKOS_LAMBDA(const Index b) {
          Real3 p;
          for (int k = 0; k < 3; ++k) p += weight(3 * b + k) * shift(node(3 * b + k));
          predicted(b) = {(1 / dt) * p, Real(0)};
        });
  }

  const ClothProgress& progress() { return iteration_.progress(); }

  void accept() {
    iteration_.line_search();
    Device& d = device_;
    const ClothSystem s = iteration_.system();
    const Real dt = dt_;
    const auto v = d.nodes.velocity, f = d.nodes.force, pin = d.nodes.pin_force, shift = d.cloth_work.shift;
    parallel(
        "drench::pressure::accept_cloth", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
          if (s.pinned(n))
            pin(n) -= s.elastic_force(n, shift) + f(n);
          else
            v(n) = (1 / dt) * shift(n);
        });
  }

 private:
  Device& device_;
  Real dt_;
  int most_iterations_;
  ClothIteration iteration_;
};

}  // namespace

void pressure(Device& d, const StepInfo& info, StepReport& report) {
  const FluidSolverScene& solver = d.model.scene.fluid.solver;
  const Index n = d.fluid.count;
  if (n == 0) return;
  const double tolerance = solver.density_correction * solver.density_error;
  const Real dt = Real(info.dt), ramp = d.emission_ramp, share = Real(solver.density_correction);
  const auto kappa = d.fluid.kappa_density, alpha = d.work.alpha, rate = d.work.rate, ratio = d.fluid.density_ratio;
  const auto age = d.fluid.age;
  const auto origin = d.fluid.origin;
  const bool samples = d.samples.count > 0, touching = has_contact(d);
  const SheetContact contact = d.work.contact;
  place_solids(d, info.dt);
  clear_inactive(d);
  std::optional<ElasticCloth> cloth;
  if (samples) {
    refresh_inverse_mass(d);
    if (d.model.has_moving_cloth()) {
      cloth_forces(d);
      cloth.emplace(d, dt);
    }
  }
  PressureIteration iterate(d, kappa, touching);
  iterate.start();
  const auto next = d.work.kappa_next, last = d.work.kappa_last;
  const auto residual = [&](const ThreeSums& sums) { return (sums.first + sums.second) / n; };
  SumUnderWay<PressureSums> first;
  for (int iteration = 1;; ++iteration) {
    predict_liquid(d, dt, touching);
    if (samples) cloth_forces(d);
    if (cloth)
      cloth->respond();
    else if (samples)
      free_cloth_response(d, dt);
    body_response(d, kappa, info.dt);
    compression_rate(d, kappa, dt, touching);
    report.density_iterations = iteration;
    const Real factor = iterate.relaxation() / (dt * dt);
    const auto under_way = begin_ordered<PressureSums>(
        "drench::pressure::residual", n,
        KOKKOS_LAMBDA(const Index i) {
          const bool fresh = origin(i) == static_cast<std::uint8_t>(Origin::cloth) && age(i) < ramp;
          const Real beta = alpha(i) == 0 ? Real(0) : fresh ? age(i) / ramp : Real(1);
          const Real push_alpha = touching ? contact.alpha(i) : Real(0);
          const Real over = push_alpha > 0 ? Kokkos::fmax(ratio(i) - 1, Real(0)) : ratio(i) - 1, change = dt * rate(i);
          const Real left = beta * (taken_back(over, share) + change);
          const double error = Kokkos::fmax(double(beta * (ratio(i) - 1 + change)), 0.0);
          const Real gain = factor * alpha(i), k = updated(kappa(i), gain, left);
          next(i) = k;
          ThreeSums steering{left > 0 ? double(left) : 0.0,
                             excess_pressure(double(left), double(kappa(i)), double(gain)),
                             alpha(i) > 0 ? double(kappa(i) - k) * double(k - last(i)) / double(alpha(i)) : 0.0};
          if (touching) {
            const Real push = contact.push(i), push_gain = factor * push_alpha;
            const Real nearer = beta * dt * (contact.rate(i) - dt * contact.compliance(i) * push);
            const Real p = updated(push, push_gain, nearer);
            contact.next(i) = p;
            if (push_alpha > 0)
              steering += ThreeSums{nearer > 0 ? double(nearer) : 0.0,
                                    excess_pressure(double(nearer), double(push), double(push_gain)),
                                    double(push - p) * double(p - contact.last(i)) / double(push_alpha)};
          }
          return PressureSums{steering, error, error};
        },
        iteration % 2);
    if (PressureIteration::goes_on_unseen(iteration, solver)) {
      first = under_way;
      iterate.advance_first();
      continue;
    }
    const PressureSums all = under_way.wait();
    const ThreeSums& sums = all.steering;
    if (iteration == 2 && PressureIteration::goes_on_unseen(1, solver))
      iterate.saw_first(residual(first.arrived().steering));
    report.density_error = all.error / n;
    report.density_error_max = all.error_max;
    report.density_converged = sums.first / n <= tolerance && sums.second / n <= tolerance;
    if (cloth && report.density_converged) report.density_converged = cloth->progress().residual <= 1;
    if ((report.density_converged && iteration >= solver.min_iterations) || iteration >= solver.max_iterations) break;
    iterate.advance(residual(sums), sums.third);
  }
  accept_liquid(d);
  accept_bodies(d, info.dt);
  if (cloth) {
    cloth->accept();
    const ClothProgress& progress = cloth->progress();
    report.cloth_iterations += progress.iterations;
    report.note_cloth_residual(progress.residual);
  } else if (samples) {
    accept_free_cloth(d, dt);
  }
}

}  // namespace drench::kokkos_backend
