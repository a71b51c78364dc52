#pragma once
// Vocabulary that the reference's stages share: vectors, the kernel, cloth samples, masses in kg, and the response to
// pressure that both DFSPH solves use. SI units throughout.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "reference.hpp"

namespace drench::reference {

using Vectors = std::vector<Eigen::Vector3d>;

inline Eigen::Vector3d vec(const Vec3& a) { return {a[0], a[1], a[2]}; }
inline Vec3 arr(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// The rotation by the angle between two directions, about the axis across both; about any, if they are opposite.
inline Eigen::Quaterniond turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d across = from.cross(to);
  const bool alike = across.norm() <= 1e-12 * from.norm() * to.norm();
  const Eigen::Vector3d axis = alike ? from.unitOrthogonal() : across.normalized();
  return Eigen::Quaterniond(Eigen::AngleAxisd(std::atan2(across.norm(), from.dot(to)), axis));
}

/// The eigenvalues of a symmetric matrix, the smaller one first.
inline Eigen::Vector2d eigenvalues(const Eigen::Matrix2d& a) {
  const double mean = 0.5 * a.trace(), apart = std::hypot(0.5 * (a(0, 0) - a(1, 1)), a(0, 1));
  return {mean - apart, mean + apart};
}

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

/// Cloth node: m_s + m_f in kg, and 1/(m_s + m_f) in 1/kg, 0 for a fixed node
/// (ClothMesh::is_fixed).
double node_mass(const ReferenceState& state, Index n);
double inverse_node_mass(const ReferenceState& state, Index n);
/// The latter where nothing moves pins: 0 for every pinned node.
double inverse_free_mass(const ReferenceState& state, Index n);

/// T of the ramp of fresh particles: the largest emission_ramp of the cloths, s; 0 without cloth.
double emission_ramp(const Model& model);
/// β_i: how much of a fresh particle's compression counts yet.
double source_ramp(const HostState& s, Index i, double ramp);

/// The node that carries corner k (0..2) of sample p.
Index sample_node(const ReferenceState& state, Index p, int k);
/// Σ_n w_pn a_n of a quantity of the nodes, one value a node.
Eigen::Vector3d sample_value(const ReferenceState& state, Index p, const std::vector<Vec3>& nodes);
Eigen::Vector3d sample_value(const ReferenceState& state, Index p, const Vectors& nodes);
Eigen::Vector3d sample_position(const ReferenceState& state, Index p);
Eigen::Vector3d sample_velocity(const ReferenceState& state, Index p);
/// C_n of the node's pores as they are pressed, kg, and the most that the node ever holds, kg.
double pore_capacity(const ReferenceState& state, Index n);
double most_liquid(const ReferenceState& state, Index n);
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
/// With the pressures λ at the sheets besides (src/stages/pressure.hpp).
PressureResponse pressure_response(const ReferenceState& state, const std::vector<double>& kappa,
                                   const std::vector<double>& push);

/// How the cloth's nodes move under the pressure.
class ClothResponse {
 public:
  virtual ~ClothResponse() = default;
  /// Velocities of all nodes at the end of the step, m/s.
  virtual Vectors velocities(const Vectors& node_force) = 0;
  /// Whether the last velocities are good enough to be kept.
  virtual bool converged() { return true; }
  /// Of an iteration in which the liquid has converged: would more of them not help (stages/pressure.hpp)?
  virtual bool stalls() { return false; }
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
std::vector<double> density_rate(const ReferenceState& state, const Vectors& fluid, const Vectors& node);
/// R'_i, the part of it that the cloth's samples give.
std::vector<double> approach_rate(const ReferenceState& state, const Vectors& fluid, const Vectors& node);

// The answer of the dynamic bodies (rigid_bodies.hpp).
void respond_bodies(ReferenceState& state, const std::vector<double>& kappa, const StepInfo& info);
void accept_bodies(ReferenceState& state, const std::vector<double>& kappa, double dt);

/// What a DFSPH solve reports.
struct SolveResult {
  int iterations = 0;
  double error = 0;
  bool converged = true;
  double start = 0;  // residual and complementarity over the tolerance that it began with
};

/// A wall stands for the mirrored liquid (src/stages/divergence.hpp).
inline constexpr double wall_share = 2;
/// γ of a particle before a cloth, of its density ratio: how dense the mirrored liquid is.
inline double image_density(double ratio) { return std::max(1.0, ratio - 0.1); }

/// One kind of pressure in a solve and its iterates, m²/s².
struct Iterates {
  std::vector<double> pressure, last, next;      // where the iteration is; the last Jacobi update and this one
  double residual_sum = 0, complementarity = 0;  // Σ max(0, residual); pressure that one update can still remove
  double restart = 0;                            // > 0: the update goes against the momentum

  explicit Iterates(std::vector<double> start)
      : pressure(std::move(start)), last(pressure), next(pressure.size(), 0.0) {}

  void begin() { residual_sum = complementarity = restart = 0; }
  /// The Jacobi update of pressure i for its residual; `gain` = ω α/Δt².
  void update(Index i, double residual, double gain, double alpha) {
    residual_sum += std::max(residual, 0.0);
    if (residual < 0) complementarity += std::min(-residual, pressure[i] / gain);
    next[i] = std::max(0.0, pressure[i] + gain * residual);
    restart += (pressure[i] - next[i]) * (next[i] - last[i]) / alpha;
  }
  void extrapolate(double momentum) {
    for (std::size_t i = 0; i < pressure.size(); ++i)
      pressure[i] = std::max(0.0, next[i] + momentum * (next[i] - last[i]));
    last = next;
  }
};

/// What is left of a particle's compression and of its approach to the sheet that it touches, for R_i and R'_i (1/s),
/// in the unit of the tolerance (1).
struct Residuals {
  std::function<double(Index, double)> compression;
  std::function<double(Index, double)> approach;  // none: sheets are not touched
};

/// The loop that both solves share. A Jacobi update raises κ_i by ω α_i residual/Δt², λ_i likewise. Particles without
/// `active` keep κ = 0 and do not count in the error. `last_start` is the SolveResult::start of the step before.
SolveResult solve_pressure(ReferenceState& state, std::vector<double>& kappa, const std::vector<bool>& active,
                           double tolerance, const StepInfo& info, ClothResponse& cloth, const Residuals& residuals,
                           double last_start);

}  // namespace drench::reference
