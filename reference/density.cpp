// Stage density (src/stages/density.hpp).

#include <cmath>

#include "rigid_bodies.hpp"
#include "sheets.hpp"

namespace drench::reference {

using Eigen::Vector3d;

namespace {

/// What the samples of a plane square lattice sum up to, times d³.
double plane_sum(const Model& model) {
  const Smoothing w(model);
  const double d = model.spacing;
  double sum = 0;
  for (double a = -8; a <= 8; ++a) {
    for (double b = -8; b <= 8; ++b) sum += d * d * d * w.value(d * std::sqrt(a * a + b * b));
  }
  return sum;
}

/// Volumes of the cloth samples, m³.
std::vector<double> sample_volumes(const ReferenceState& state, const Vectors& sample) {
  const Smoothing w(state.model);
  const double layer = plane_sum(state.model);
  std::vector<double> volume(sample.size());
  for (std::size_t b = 0; b < sample.size(); ++b) {
    double sum = w.value(0);
    for (const Index k : state.sample_sample[b]) sum += w.value((sample[b] - sample[k]).norm());
    volume[b] = layer / sum;
  }
  return volume;
}

/// c_b: bounds how far all particles together move sample b, through the nodes that they share.
std::vector<double> row_bounds(const ReferenceState& state, const Vectors& sample) {
  const Smoothing w(state.model);
  const HostState& s = state.s;
  const auto& weight = state.model.samples.weight;
  std::vector<double> node_load(s.node_position.size(), 0.0);  // G_n
  for (Index b = 0; b < s.sample_count(); ++b) {
    double load = 0;  // g_b
    for (const Index i : state.sample_fluid[b]) {
      const Vector3d gradient = w.gradient(from_behind(state, i, b));
      load += s.sample_volume[b] * fluid_mass(state, i) * gradient.norm();
    }
    for (int k = 0; k < 3; ++k) node_load[sample_node(state, b, k)] += weight[b][k] * load;
  }
  std::vector<double> bound(sample.size(), 0.0);
  for (Index b = 0; b < s.sample_count(); ++b) {
    for (int k = 0; k < 3; ++k) {
      const Index n = sample_node(state, b, k);
      bound[b] += weight[b][k] * inverse_node_mass(state, n) * node_load[n];
    }
  }
  return bound;
}

/// L_i: by how much the liquid's gradient along solids adds to its acceleration, 1.
Eigen::Matrix3d wall_gain(const ReferenceState& state, Index i) {
  const Smoothing w(state.model);
  Vector3d sum = Vector3d::Zero();
  double lengths = 0;
  Eigen::Matrix3d wall = Eigen::Matrix3d::Zero();  // M
  for (const Index b : state.fluid_boundary[i]) {
    const Vector3d r = vec(state.s.fluid_position[i]) - vec(state.s.boundary_position[b]);
    const Vector3d term = state.s.boundary_volume[b] * w.gradient(r);
    sum += wall_share * term;
    lengths += wall_share * term.norm();
    wall -= term * r.transpose();
  }
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  if (sum.squaredNorm() == 0) return one;
  const Eigen::Matrix3d along = one - sum * sum.transpose() / sum.squaredNorm();
  const double weight = std::min(1.0, sum.squaredNorm() / (0.1 * lengths * lengths));
  const Eigen::Matrix3d m = weight * along * wall * along;
  return one + m * (one + m * (one + m * (one + m)));
}

/// Mean of β_i max(0, δ_i − 1) over the liquid.
double mean_compression(const ReferenceState& state) {
  const double ramp = emission_ramp(state.model);
  double sum = 0;
  for (Index i = 0; i < state.s.fluid_count(); ++i)
    if (state.alpha[i] > 0) sum += source_ramp(state.s, i, ramp) * std::max(0.0, state.s.fluid_density_ratio[i] - 1);
  return state.s.fluid_count() > 0 ? sum / state.s.fluid_count() : 0;
}

}  // namespace

void density(ReferenceState& state, const StepInfo&, StepReport& report) {
  HostState& s = state.s;
  const Smoothing w(state.model);
  const double spacing = state.model.spacing;
  const Vectors sample = sample_positions(state);
  if (s.fluid_count() > 0) s.sample_volume = sample_volumes(state, sample);
  const std::vector<double> bound = row_bounds(state, sample);
  state.wall_gain.clear();
  state.alpha.assign(s.fluid_position.size(), 0.0);
  state.compliance.assign(s.fluid_position.size(), 0.0);
  state.contact_alpha.assign(s.fluid_position.size(), 0.0);
  state.contact_compliance.assign(s.fluid_position.size(), 0.0);
  const auto inverse = [&](double diagonal, double volume) {
    return diagonal < 1e-6 / (spacing * spacing) || volume == 0 ? 0.0 : 1 / diagonal;
  };
  s.fluid_density_ratio.assign(s.fluid_position.size(), 0.0);

  for (Index i = 0; i < s.fluid_count(); ++i) {
    const Vector3d xi = vec(s.fluid_position[i]);
    const double volume = fluid_volume(state, i);
    double ratio = volume * w.value(0), squares = 0, cloth = 0, lengths = 0;
    Vector3d sum = Vector3d::Zero(), sheet = Vector3d::Zero();
    for (const Index j : state.fluid_fluid[i]) {
      const Vector3d xij = xi - vec(s.fluid_position[j]);
      const Vector3d gradient = w.pair_gradient(xij);
      ratio += fluid_volume(state, j) * w.value(xij.norm());
      sum += fluid_volume(state, j) * gradient;
      squares += volume * fluid_volume(state, j) * gradient.squaredNorm();
      const double heavier = std::max(0.0, fluid_volume(state, j) - volume);
      state.compliance[i] += heavier * fluid_volume(state, j) * gradient.squaredNorm();
    }
    for (const Index b : state.fluid_boundary[i]) {
      const Vector3d xib = xi - vec(s.boundary_position[b]);
      ratio += s.boundary_volume[b] * w.value(xib.norm());
      sum += wall_share * s.boundary_volume[b] * w.gradient(xib);
    }
    for (const Index b : state.fluid_sample[i]) {
      const Vector3d xib = from_behind(state, i, b);
      const Vector3d gradient = w.gradient(xib);
      ratio += s.sample_volume[b] * w.value(xib.norm());
      sheet += wall_share * s.sample_volume[b] * gradient;
      lengths += wall_share * s.sample_volume[b] * gradient.norm();
      cloth += wall_share * wall_share * s.sample_volume[b] * gradient.norm() * bound[b];
    }
    const double image = image_density(ratio);
    sheet *= image;
    sum += sheet;
    cloth *= state.model.row_share() * image * image;
    s.fluid_density_ratio[i] = ratio;
    double stiffer = 1;
    if (state.model.extrapolates_walls()) {
      state.wall_gain.push_back(wall_gain(state, i));
      stiffer = std::sqrt(std::max(1.0, state.wall_gain.back().squaredNorm() - 2));
    }
    state.alpha[i] = inverse(stiffer * (sum.squaredNorm() + squares) + state.compliance[i] + cloth, volume);
    if (ratio > 2 && state.model.samples.count() == 0) state.alpha[i] *= 2 / ratio;  // a crowd
    if (!state.model.scene.through_cloth && touches_sheet(state, i)) {
      state.contact_compliance[i] = std::max(0.0, 0.1 * std::pow(image * lengths, 2) - sheet.squaredNorm());
      state.contact_alpha[i] = inverse(stiffer * sheet.squaredNorm() + state.contact_compliance[i] + cloth, volume);
    }
  }
  add_body_rows(state);
  if (state.model.scene.time.mode == TimeMode::error) report.density_found = mean_compression(state);
}

}  // namespace drench::reference
