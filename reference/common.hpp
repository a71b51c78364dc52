#pragma once
// Vocabulary that the reference's stages share: vectors, the kernel, cloth samples, masses in kg, and the response to
// pressure that both DFSPH solves use. SI units throughout.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "reference.hpp"

namespace drench::reference {

using Vectors = std::vector<Eigen::Vector3d>;

inline Eigen::Vector3d vec(const Vec3& a) { return {a[0], a[1], a[2]}; }
inline Vec3 arr(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// The scene's smoothing kernel (src/stages/kernel.hpp) with its support h.
class Smoothing {
 public:
  explicit Smoothing(const Model& model) : kind_(model.scene.fluid.kernel), h_(model.support) {}
  /// W(r) in 1/m³, r in m.
  double value(double r) const;
  /// Its gradient in x_i for xij = x_i − x_j (m): points toward j, 0 for |xij| ≤ 1e-9 h; in 1/m⁴.
  Eigen::Vector3d gradient(const Eigen::Vector3d& xij) const;
  /// The same between two liquid particles: its length is held at its largest below the distance of that.
  Eigen::Vector3d pair_gradient(const Eigen::Vector3d& xij) const;

 private:
  KernelKind kind_;
  double h_;
};

/// Liquid particle: mass in kg and volume m_i/ρ0 in m³.
double fluid_mass(const ReferenceState& state, Index i);
double fluid_volume(const ReferenceState& state, Index i);

/// Cloth node: m_s + m_f in kg, and 1/(m_s + m_f) in 1/kg, 0 for a pinned node.
double node_mass(const ReferenceState& state, Index n);
double inverse_node_mass(const ReferenceState& state, Index n);

/// T of the ramp of fresh particles: the largest emission_ramp of the cloths, s; 0 without cloth.
double emission_ramp(const Model& model);

/// The node that carries corner k (0..2) of sample p.
Index sample_node(const ReferenceState& state, Index p, int k);
/// Σ_n w_pn a_n of a quantity of the nodes, one value a node.
Eigen::Vector3d sample_value(const ReferenceState& state, Index p, const std::vector<Vec3>& nodes);
Eigen::Vector3d sample_value(const ReferenceState& state, Index p, const Vectors& nodes);
Eigen::Vector3d sample_position(const ReferenceState& state, Index p);
Eigen::Vector3d sample_velocity(const ReferenceState& state, Index p);
/// s_p = Σ_n w_pn m_n/C_n before any rounding; a node with C_n = 0 counts 0.
double sample_saturation(const ReferenceState& state, Index p);
/// Positions of all samples.
Vectors sample_positions(const ReferenceState& state);
/// Node forces f_n = Σ_b w_bn F_b from forces on the samples, N.
Vectors spread_to_nodes(const ReferenceState& state, const Vectors& sample_force);

/// Vector from sample b, half a spacing behind the sheet as seen from liquid particle i, to the particle
/// (src/stages/density.hpp).
Eigen::Vector3d from_behind(const ReferenceState& state, Index i, Index b);

/// κ of the density solve := 0 where α = 0.
void clear_inactive(ReferenceState& state);

/// What the pressures κ do (src/stages/divergence.hpp): accelerations of the liquid in m/s², node forces in N.
struct PressureResponse {
  Vectors fluid;
  Vectors node_force;
};
PressureResponse pressure_response(const ReferenceState& state, const std::vector<double>& kappa);

/// How the cloth's nodes move under the pressure.
class ClothResponse {
 public:
  virtual ~ClothResponse() = default;
  /// Velocities of all nodes at the end of the step, m/s.
  virtual Vectors velocities(const Vectors& node_force) = 0;
  /// Whether the last velocities are good enough to be kept.
  virtual bool converged() { return true; }
  /// Writes the last velocities and the pins' reaction.
  virtual void accept(ReferenceState& state, const Vectors& node_force) = 0;
};

/// Nodes that answer with their inertia alone.
class FreeCloth : public ClothResponse {
 public:
  FreeCloth(const ReferenceState& state, double dt) : state_(state), dt_(dt) {}
  Vectors velocities(const Vectors& node_force) override;
  void accept(ReferenceState& state, const Vectors& node_force) override;

 private:
  const ReferenceState& state_;
  double dt_;
};

/// R_i of every liquid particle for velocities after the pressure, in 1/s.
std::vector<double> compression_rate(const ReferenceState& state, const Vectors& fluid, const Vectors& node);

// The answer of the dynamic bodies (rigid_bodies.hpp).
void respond_bodies(ReferenceState& state, const std::vector<double>& kappa, double dt);
void accept_bodies(ReferenceState& state, const std::vector<double>& kappa, double dt);

/// What a DFSPH solve reports.
struct SolveResult {
  int iterations = 0;
  double error = 0;
  bool converged = true;
};

/// A wall stands for the mirrored liquid (src/stages/divergence.hpp).
inline constexpr double wall_share = 2;
/// γ of a particle before a cloth, of its density ratio: how dense the mirrored liquid is.
inline double image_density(double ratio) { return std::max(1.0, ratio - 0.1); }

/// The loop that both solves share. `residual(i, R_i)` is what is left of particle i's compression, in the unit of the
/// tolerance (1); a Jacobi update raises κ_i by ω α_i residual/Δt². Particles without `active` keep κ = 0 and do not count
/// in the error.
template <class Residual>
SolveResult solve_pressure(ReferenceState& state, std::vector<double>& kappa, const std::vector<bool>& active,
                           double tolerance, double dt, ClothResponse& cloth, Residual residual) {
  const auto& solver = state.model.scene.fluid.solver;
  const Index count = state.s.fluid_count();
  SolveResult result;
  if (count == 0) return result;
  for (Index i = 0; i < count; ++i) {
    if (!active[i]) kappa[i] = 0;
  }
  double relaxation = state.model.relaxation, theta = 1, best = 1e300, before = 1e300;
  std::vector<double> last = kappa;  // the Jacobi updates without momentum
  while (true) {
    ++result.iterations;
    const PressureResponse response = pressure_response(state, kappa);
    Vectors fluid;
    for (Index i = 0; i < count; ++i) fluid.push_back(vec(state.s.fluid_velocity[i]) + dt * response.fluid[i]);
    respond_bodies(state, kappa, dt);
    const std::vector<double> rate = compression_rate(state, fluid, cloth.velocities(response.node_force));
    std::vector<double> jacobi(count, 0.0);
    double sum = 0, excess = 0;  // excess: pressure above what is needed that one update can still take back
    double turned = 0;           // > 0: the update goes against the momentum
    for (Index i = 0; i < count; ++i) {
      if (!active[i]) continue;
      const double yielded = dt * state.compliance[i] * kappa[i];
      const double left = residual(i, rate[i] - yielded), gain = relaxation * state.alpha[i] / (dt * dt);
      const double compressed = std::max(left, 0.0);
      sum += compressed;
      if (left < 0) excess += std::min(-left, kappa[i] / gain);
      jacobi[i] = std::max(0.0, kappa[i] + gain * left);
      turned += (kappa[i] - jacobi[i]) * (jacobi[i] - last[i]) / state.alpha[i];
    }
    result.error = sum / count;
    result.converged = result.error <= tolerance && excess / count <= tolerance && cloth.converged();
    if ((result.converged && result.iterations >= solver.min_iterations) ||
        result.iterations >= solver.max_iterations) {
      for (Index i = 0; i < count; ++i) state.s.fluid_velocity[i] = arr(fluid[i]);
      cloth.accept(state, response.node_force);
      accept_bodies(state, kappa, dt);
      return result;
    }
    const double size = (sum + excess) / count;
    if (size > 4 * best) relaxation /= 2;
    if (turned > 0 || size > before) theta = 1;
    best = size > 4 * best ? size : std::min(best, size);
    before = size;
    const double next_theta = (1 + std::sqrt(1 + 4 * theta * theta)) / 2;
    for (Index i = 0; i < count; ++i) {
      kappa[i] = std::max(0.0, jacobi[i] + (theta - 1) / next_theta * (jacobi[i] - last[i]));
    }
    theta = next_theta;
    last = jacobi;
  }
}

}  // namespace drench::reference
