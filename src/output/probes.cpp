#include "output/probes.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/eigen_vec.hpp"
#include "output/grid_tools.hpp"
#include "output/text_file.hpp"
#include "setup/point_grid.hpp"
#include "setup/smoothing_kernel.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;
using ProbeKind = ProbeScene::Kind;
namespace fs = std::filesystem;

constexpr double full = 0.5;      // of Σ V W: at the surface of the liquid
constexpr double line_steps = 4;  // per spacing

std::string number(double value) { return fmt::format(",{:.9g}", value); }

/// The number of the part with this name; −1 if there is none.
template <class Part>
Index numbered(const std::vector<Part>& parts, const std::string& name) {
  const auto found = std::find_if(parts.begin(), parts.end(), [&](const Part& part) { return part.name == name; });
  return found == parts.end() ? -1 : static_cast<Index>(found - parts.begin());
}

/// The liquid near a point, from particles within a radius of it.
struct LiquidAt {
  double pressure = 0;     // Pa: a linear fit's value there; 0 where no liquid is near
  Vec3 velocity{0, 0, 0};  // m/s: the same
  double filling = 0;      // 1: Σ V W, over what solids leave of it
};

/// The particles of a state around some places, for many questions.
class LiquidNear {
 public:
  /// `reach` (m): the largest radius of a question, at least the support radius.
  LiquidNear(const Model& model, const HostState& state, const std::vector<Vec3>& places, double reach)
      : model_(model), state_(state), liquid_(reach), walls_(reach) {
    Eigen::AlignedBox3d region;
    for (const Vec3& x : places) region.extend(to_eigen(x));
    const Vector3d margin = Vector3d::Constant(reach);
    region = {region.min() - margin, region.max() + margin};
    const auto keep = [&](const std::vector<Vec3>& all, PointGrid& grid, std::vector<std::size_t>& kept) {
      for (std::size_t i = 0; i < all.size(); ++i) {
        if (!region.contains(to_eigen(all[i]))) continue;
        grid.add(all[i]);
        kept.push_back(i);
      }
    };
    keep(state.fluid_position, liquid_, particle_);
    keep(state.boundary_position, walls_, sample_);
  }

  LiquidAt at(const Vec3& x, double radius) const {
    const KernelKind kernel = model_.scene.fluid.kernel;
    const double h = model_.support, reach = std::max(h, radius);
    const Vector3d here = to_eigen(x), margin = Vector3d::Constant(reach);
    const Vec3 low = to_vec3(here - margin), high = to_vec3(here + margin);
    double filled = 0, weight = 0, solid = 0;
    Eigen::Matrix4d moments = Eigen::Matrix4d::Zero(), values = moments;  // values: a column for p and each of v
    liquid_.for_box(low, high, [&](Index g) {
      const std::size_t i = particle_[static_cast<std::size_t>(g)];
      const Vector3d r = to_eigen(state_.fluid_position[i]) - here;
      const double volume = static_cast<double>(state_.fluid_mass[i]) * model_.quantum / model_.rest_density;
      if (r.norm() < h) filled += volume * kernel_value(kernel, r.norm(), h);
      const double t = 1 - r.squaredNorm() / (reach * reach);
      if (t <= 0) return;
      const double w = t * t * volume;
      const Eigen::Vector4d basis(1, r[0] / reach, r[1] / reach, r[2] / reach);
      const Vec3& v = state_.fluid_velocity[i];
      weight += w;
      moments += w * basis * basis.transpose();
      values += w * basis * Eigen::RowVector4d(particle_pressure(model_, state_, i), v[0], v[1], v[2]);
    });
    LiquidAt found;
    if (weight == 0) return found;
    // Where particles are few or in a plane, the fit bends towards their mean.
    moments.diagonal().tail<3>().array() += 1e-3 * weight;
    const Eigen::RowVector4d here_fit = moments.inverse().row(0) * values;
    found.pressure = std::max(0.0, here_fit[0]);
    for (int a = 0; a < 3; ++a) found.velocity[static_cast<std::size_t>(a)] = here_fit[a + 1];
    walls_.for_box(low, high, [&](Index g) {
      const std::size_t b = sample_[static_cast<std::size_t>(g)];
      const double r = (to_eigen(state_.boundary_position[b]) - here).norm();
      if (r < h) solid += state_.boundary_volume[b] * kernel_value(kernel, r, h);
    });
    found.filling = filled / std::max(0.4, 1 - solid);
    return found;
  }

 private:
  const Model& model_;
  const HostState& state_;
  PointGrid liquid_, walls_;
  std::vector<std::size_t> particle_, sample_;  // of the grids' points
};

/// Where a line leaves the liquid for the last time, and how much of it is in liquid, m from its first end.
std::array<double, 2> height_and_depth(const Model& model, const HostState& state, const ProbeScene& probe) {
  const LiquidNear liquid(model, state, {probe.position, probe.end}, model.support);
  const Vector3d from = to_eigen(probe.position), way = to_eigen(probe.end) - from;
  const double length = way.norm();
  const auto steps = static_cast<std::int64_t>(std::ceil(line_steps * length / model.spacing));
  const double step = length / static_cast<double>(steps);
  double height = 0, depth = 0, before = 0;
  for (std::int64_t k = 0; k <= steps; ++k) {
    const double s = static_cast<double>(k) * step;
    const double filling = liquid.at(to_vec3(from + s / length * way), 0).filling;
    if (k > 0 && (filling >= full || before >= full)) {
      const double crossing = filling == before ? 0 : std::clamp((full - before) / (filling - before), 0.0, 1.0);
      const double wet = filling >= full ? (before >= full ? 1 : 1 - crossing) : crossing;
      depth += wet * step;
      height = filling >= full ? s : s - step + crossing * step;
    }
    before = filling;
  }
  return {height, depth};
}

}  // namespace

ProbeCsv::ProbeCsv(const fs::path& file, const Model& model, double after)
    : model_(model), path_(file), every_(model.scene.output.probe_every.value_or(model.scene.output.every)) {
  const std::vector<ProbeScene>& probes = model.scene.output.probes;
  sum_.resize(probes.size());
  last_place_.resize(probes.size());
  passed_.resize(probes.size());
  for (const ProbeScene& p : probes) {
    target_.push_back(p.kind == ProbeKind::body ? numbered(model.bodies, p.of) : numbered(model.scene.cloths, p.of));
    has_bodies_ = has_bodies_ || p.kind == ProbeKind::body;
    has_states_ = has_states_ || p.kind == ProbeKind::point || p.kind == ProbeKind::cloth;
  }
  next_ = after >= 0 ? (std::floor(after / every_ * (1 + 1e-12)) + 1) * every_ : every_;
  if (path_.empty()) return;
  std::string kept = header();
  if (after >= 0 && fs::exists(path_)) {
    std::ifstream in(path_);
    std::string line, last;
    std::getline(in, line);
    while (std::getline(in, line))
      if (std::strtod(line.c_str(), nullptr) <= after * (1 + 1e-12)) kept += (last = line) + '\n';
    take_up(last);
  }
  write_atomically(path_, kept);
  out_.open(path_, std::ios::app);
  if (!out_) throw std::runtime_error(fmt::format("{}: cannot be written", path_.string()));
}

/// The masses that have passed discs, from the last row that stays.
void ProbeCsv::take_up(const std::string& row) {
  std::istringstream names(header()), values(row);
  std::string name, value;
  while (std::getline(names, name, ',') && std::getline(values, value, ','))
    for (std::size_t k = 0; k < passed_.size(); ++k)
      if (name.rfind(model_.scene.output.probes[k].name + "_passed", 0) == 0)
        passed_[k] = std::strtod(value.c_str(), nullptr);
}

std::string ProbeCsv::header() const {
  std::string text = "time";
  for (const ProbeScene& p : model_.scene.output.probes) {
    const auto add = [&](std::initializer_list<const char*> columns) {
      for (const char* column : columns) text += fmt::format(",{}_{}", p.name, column);
    };
    switch (p.kind) {
      case ProbeKind::point:
        add({"pressure", "velocity_x", "velocity_y", "velocity_z", "filling"});
        break;
      case ProbeKind::line:
        add({"height", "depth"});
        break;
      case ProbeKind::disc:
        add({"flux", "passed"});
        break;
      case ProbeKind::body:
        add({"force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"});
        break;
      case ProbeKind::cloth:
        add({"liquid", "saturation", "pin_force_x", "pin_force_y", "pin_force_z", "contact_force_x", "contact_force_y",
             "contact_force_z"});
        break;
    }
  }
  return text + '\n';
}

void ProbeCsv::step(const StepReport& report, const std::function<std::vector<std::optional<BodyLoad>>()>& loads,
                    const std::function<HostState()>& state) {
  elapsed_ += report.dt;
  if (has_bodies_) add_loads(report.dt, loads());
  const bool due = report.time >= next_ * (1 - 1e-12);
  if (!due && !has_states_) return;
  const HostState now = state();
  if (has_states_ && !path_.empty()) add_state(report.dt, now);
  if (!due) return;
  next_ = (std::floor(report.time / every_ * (1 + 1e-12)) + 1) * every_;
  if (!path_.empty()) write(now);
  elapsed_ = 0;
  for (auto& sum : sum_) sum.fill(0);
}

void ProbeCsv::add_loads(double dt, const std::vector<std::optional<BodyLoad>>& loads) {
  const std::vector<ProbeScene>& probes = model_.scene.output.probes;
  for (std::size_t k = 0; k < probes.size(); ++k) {
    if (probes[k].kind != ProbeKind::body) continue;
    const BodyLoad& l = loads.at(static_cast<std::size_t>(target_[k])).value();
    for (std::size_t a = 0; a < 3; ++a) {
      sum_[k][a] += dt * (l.liquid_force[a] + l.cloth_force[a] + l.attached_force[a] + l.contact_force[a]);
      sum_[k][3 + a] += dt * (l.liquid_torque[a] + l.cloth_torque[a] + l.attached_torque[a] + l.contact_torque[a]);
    }
  }
}

/// Pressures of single steps scatter, because two solves share them: their mean over time does not.
void ProbeCsv::add_state(double dt, const HostState& state) {
  const std::vector<ProbeScene>& probes = model_.scene.output.probes;
  std::vector<Vec3> places;
  double reach = model_.support;
  for (const ProbeScene& p : probes) {
    if (p.kind != ProbeKind::point) continue;
    places.push_back(p.position);
    reach = std::max(reach, p.radius);
  }
  const LiquidNear liquid(model_, state, places, reach);
  for (std::size_t k = 0; k < probes.size(); ++k) {
    const ProbeScene& p = probes[k];
    std::array<double, 6>& sum = sum_[k];
    if (p.kind == ProbeKind::point) {
      const LiquidAt at = liquid.at(p.position, p.radius);
      sum[0] += dt * at.pressure;
      for (std::size_t a = 0; a < 3; ++a) sum[1 + a] += dt * at.velocity[a];
      sum[4] += dt * at.filling;
    }
    if (p.kind != ProbeKind::cloth) continue;
    for (std::size_t n = 0; n < state.node_position.size(); ++n) {
      if (model_.mesh.node_cloth[n] != target_[k]) continue;
      for (std::size_t a = 0; a < 3; ++a) {
        sum[a] += dt * value_or_zero(state.node_pin_force, n)[a];
        sum[3 + a] +=
            dt * (value_or_zero(state.node_contact_force, n)[a] + value_or_zero(state.node_friction_force, n)[a]);
      }
    }
  }
}

/// The mass (kg) that has passed a disc since the last row.
double ProbeCsv::passed_since(std::size_t k, const HostState& state) {
  const ProbeScene& p = model_.scene.output.probes[k];
  const Vector3d center = to_eigen(p.position), n = to_eigen(p.normal).normalized();
  std::unordered_map<std::int64_t, Vec3> places;
  double passed = 0;
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    const Vector3d now = to_eigen(state.fluid_position[i]) - center;
    const std::int64_t id = state.fluid_id[i];
    if (const auto found = last_place_[k].find(id); found != last_place_[k].end()) {
      const Vector3d before = to_eigen(found->second) - center;
      const double a = before.dot(n), b = now.dot(n);
      const Vector3d at = before + a / (a - b) * (now - before);
      if ((a < 0) != (b < 0) && (at - at.dot(n) * n).norm() <= p.radius)
        passed += (b >= 0 ? 1 : -1) * static_cast<double>(state.fluid_mass[i]) * model_.quantum;
    }
    places.emplace(id, state.fluid_position[i]);
  }
  last_place_[k] = std::move(places);
  return passed;
}

void ProbeCsv::write(const HostState& state) {
  const std::vector<ProbeScene>& probes = model_.scene.output.probes;
  std::string row = fmt::format("{:.10g}", state.time);
  for (std::size_t k = 0; k < probes.size(); ++k) {
    const ProbeScene& p = probes[k];
    const auto means = [&](std::size_t count) {
      for (std::size_t a = 0; a < count; ++a) row += number(elapsed_ > 0 ? sum_[k][a] / elapsed_ : 0);
    };
    switch (p.kind) {
      case ProbeKind::point:
        means(5);
        break;
      case ProbeKind::body:
        means(6);
        break;
      case ProbeKind::line: {
        const auto [height, depth] = height_and_depth(model_, state, p);
        row += number(height) + number(depth);
        break;
      }
      case ProbeKind::disc: {
        const double passed = passed_since(k, state);
        passed_[k] += passed;
        row += number(elapsed_ > 0 ? passed / elapsed_ : 0) + number(passed_[k]);
        break;
      }
      case ProbeKind::cloth: {
        double mass = 0, capacity = 0;
        for (std::size_t n = 0; n < state.node_position.size(); ++n) {
          if (model_.mesh.node_cloth[n] != target_[k]) continue;
          mass += static_cast<double>(value_or_zero(state.node_liquid, n)) * model_.quantum;
          capacity += value_or_zero(model_.samples.node_capacity, n);
        }
        row += number(mass) + number(capacity > 0 ? mass / capacity : 0);
        means(6);
        break;
      }
    }
  }
  out_ << row << '\n' << std::flush;
  if (!out_) throw std::runtime_error(fmt::format("{}: cannot be written", path_.string()));
}

void ProbeCsv::sync() const {
  if (!path_.empty()) sync_to_disk(path_);
}

}  // namespace drench
