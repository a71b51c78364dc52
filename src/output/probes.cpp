#include "output/probes.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/eigen_vec.hpp"
#include "output/grid_tools.hpp"
#include "output/text_file.hpp"
#include "setup/point_grid.hpp"
#include "setup/smoothing_kernel.hpp"
#include "state/saturation.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;
using Kind = ProbeScene::Kind;
namespace fs = std::filesystem;

constexpr double full = 0.5;  // of Σ V W: at the surface of the liquid
constexpr double line_steps = 4;  // per spacing

std::string number(double value) { return fmt::format(",{:.9g}", value); }
std::string numbers(const Vec3& v) { return number(v[0]) + number(v[1]) + number(v[2]); }

}  // namespace

struct LiquidProbe::Points {
  PointGrid liquid, walls;
  std::vector<std::size_t> particle;  // of the grid's points
  explicit Points(double edge) : liquid(edge), walls(edge) {}
};

LiquidProbe::LiquidProbe(const Model& model, const HostState& state, double largest_radius)
    : model_(model), state_(state), points_(std::make_unique<Points>(std::max(model.support, largest_radius))) {
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    const Vec3& x = state.fluid_position[i];
    if (!std::isfinite(x[0] + x[1] + x[2])) continue;
    points_->liquid.add(x);
    points_->particle.push_back(i);
  }
  for (const Vec3& x : state.boundary_position)
    if (std::isfinite(x[0] + x[1] + x[2])) points_->walls.add(x);
}
LiquidProbe::~LiquidProbe() = default;

LiquidAt LiquidProbe::at(const Vec3& x, double radius) const {
  const double h = model_.support, reach = std::max(h, radius);
  const Vector3d here = to_eigen(x);
  const auto around = [&](double r) {
    return std::pair<Vec3, Vec3>{{x[0] - r, x[1] - r, x[2] - r}, {x[0] + r, x[1] + r, x[2] + r}};
  };
  LiquidAt found;
  double filled = 0, solid = 0;
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d values = Eigen::Matrix4d::Zero();  // a column each: pressure and velocity
  double weight = 0;
  const auto [low, high] = around(reach);
  points_->liquid.for_box(low, high, [&](Index g) {
    const std::size_t i = points_->particle[static_cast<std::size_t>(g)];
    const Vector3d r = to_eigen(state_.fluid_position[i]) - here;
    const double volume = static_cast<double>(state_.fluid_mass[i]) * model_.quantum / model_.rest_density;
    if (r.norm() < h) filled += volume * kernel_value(model_.scene.fluid.kernel, r.norm(), h);
    const double t = 1 - r.squaredNorm() / (reach * reach);
    if (t <= 0) return;
    const double w = t * t * volume;
    const Eigen::Vector4d basis(1, r[0] / reach, r[1] / reach, r[2] / reach);
    const double p = model_.rest_density * (value_or_zero(state_.fluid_kappa_density, i) + value_or_zero(state_.fluid_kappa_divergence, i));
    const Vec3& v = state_.fluid_velocity[i];
    weight += w;
    moments += w * basis * basis.transpose();
    values += w * basis * Eigen::RowVector4d(p, v[0], v[1], v[2]);
  });
  if (weight == 0) return found;
  // Where particles are few or in a plane, the fit bends towards their mean.
  moments.diagonal().tail<3>().array() += 1e-3 * weight;
  const Eigen::Matrix4d fit = moments.ldlt().solve(values);
  found.pressure = std::max(0.0, fit(0, 0));
  for (int a = 0; a < 3; ++a) found.velocity[static_cast<std::size_t>(a)] = fit(0, a + 1);
  const auto [near_low, near_high] = around(h);
  points_->walls.for_box(near_low, near_high, [&](Index b) {
    const double r = (to_eigen(points_->walls.points()[static_cast<std::size_t>(b)]) - here).norm();
    if (r < h) solid += state_.boundary_volume[static_cast<std::size_t>(b)] * kernel_value(model_.scene.fluid.kernel, r, h);
  });
  found.filling = filled / std::max(0.4, 1 - solid);
  return found;
}

namespace {

/// Where a line leaves the liquid for the last time, and how much of it is in liquid, m from its first end.
std::array<double, 2> height_and_depth(const LiquidProbe& liquid, const ProbeScene& probe, double spacing) {
  const Vector3d from = to_eigen(probe.position), way = to_eigen(probe.end) - from;
  const double length = way.norm();
  const auto steps = static_cast<std::int64_t>(std::ceil(line_steps * length / spacing));
  const double step = length / static_cast<double>(steps);
  double height = 0, depth = 0, before = 0;
  for (std::int64_t k = 0; k <= steps; ++k) {
    const double s = static_cast<double>(k) * step;
    const double filling = liquid.at(to_vec3(from + s / length * way)).filling;
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
  impulse_.resize(probes.size());
  last_place_.resize(probes.size());
  passed_.resize(probes.size());
  for (const ProbeScene& p : probes) has_bodies_ = has_bodies_ || p.kind == Kind::body;
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
      case Kind::point: add({"pressure", "velocity_x", "velocity_y", "velocity_z", "filling"}); break;
      case Kind::line: add({"height", "depth"}); break;
      case Kind::disc: add({"flux", "passed"}); break;
      case Kind::body: add({"force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"}); break;
      case Kind::cloth:
        add({"liquid", "saturation", "pin_force_x", "pin_force_y", "pin_force_z", "contact_force_x",
             "contact_force_y", "contact_force_z"});
        break;
    }
  }
  return text + '\n';
}

void ProbeCsv::step(const StepReport& report, const std::function<std::vector<std::optional<BodyLoad>>()>& loads,
                    const std::function<HostState()>& state) {
  const std::vector<ProbeScene>& probes = model_.scene.output.probes;
  elapsed_ += report.dt;
  if (has_bodies_) {
    const std::vector<std::optional<BodyLoad>> all = loads();
    for (std::size_t k = 0; k < probes.size(); ++k) {
      if (probes[k].kind != Kind::body) continue;
      for (std::size_t b = 0; b < model_.bodies.size() && b < all.size(); ++b) {
        if (model_.bodies[b].name != probes[k].of || !all[b]) continue;
        const BodyLoad& l = *all[b];
        for (std::size_t a = 0; a < 3; ++a) {
          impulse_[k][a] += report.dt * (l.liquid_force[a] + l.cloth_force[a] + l.attached_force[a] + l.contact_force[a]);
          impulse_[k][3 + a] +=
              report.dt * (l.liquid_torque[a] + l.cloth_torque[a] + l.attached_torque[a] + l.contact_torque[a]);
        }
      }
    }
  }
  if (report.time < next_ * (1 - 1e-12)) return;
  next_ = (std::floor(report.time / every_ * (1 + 1e-12)) + 1) * every_;
  write(state());
  elapsed_ = 0;
  for (auto& impulse : impulse_) impulse.fill(0);
}

void ProbeCsv::write(const HostState& state) {
  const std::vector<ProbeScene>& probes = model_.scene.output.probes;
  if (path_.empty()) return;
  double largest = 0;
  bool liquid_wanted = false;
  for (const ProbeScene& p : probes) {
    if (p.kind == Kind::point) largest = std::max(largest, p.radius);
    liquid_wanted = liquid_wanted || p.kind == Kind::point || p.kind == Kind::line;
  }
  std::optional<LiquidProbe> liquid;
  if (liquid_wanted) liquid.emplace(model_, state, largest);
  std::string row = fmt::format("{:.10g}", state.time);
  for (std::size_t k = 0; k < probes.size(); ++k) {
    const ProbeScene& p = probes[k];
    switch (p.kind) {
      case Kind::point: {
        const LiquidAt at = liquid->at(p.position, p.radius);
        row += number(at.pressure) + numbers(at.velocity) + number(at.filling);
        break;
      }
      case Kind::line: {
        const auto [height, depth] = height_and_depth(*liquid, p, model_.spacing);
        row += number(height) + number(depth);
        break;
      }
      case Kind::disc: {
        const Vector3d center = to_eigen(p.position), n = to_eigen(p.normal).normalized();
        std::unordered_map<std::int64_t, Vec3> places;
        double passed = 0;
        for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
          const Vector3d now = to_eigen(state.fluid_position[i]) - center;
          const std::int64_t id = state.fluid_id[i];
          if (const auto found = last_place_[k].find(id); found != last_place_[k].end()) {
            const Vector3d before = to_eigen(found->second) - center;
            const double a = before.dot(n), b = now.dot(n);
            if ((a < 0) != (b < 0)) {
              const Vector3d at = before + a / (a - b) * (now - before);
              if ((at - at.dot(n) * n).norm() <= p.radius)
                passed += (b >= 0 ? 1 : -1) * static_cast<double>(state.fluid_mass[i]) * model_.quantum;
            }
          }
          if (now.squaredNorm() < 1e30) places.emplace(id, state.fluid_position[i]);
        }
        last_place_[k] = std::move(places);
        passed_[k] += passed;
        row += number(elapsed_ > 0 ? passed / elapsed_ : 0) + number(passed_[k]);
        break;
      }
      case Kind::body:
        for (const double j : impulse_[k]) row += number(elapsed_ > 0 ? j / elapsed_ : 0);
        break;
      case Kind::cloth: {
        double mass = 0, capacity = 0;
        Vec3 pins{0, 0, 0}, contact{0, 0, 0};
        for (std::size_t n = 0; n < state.node_position.size(); ++n) {
          if (model_.scene.cloths[static_cast<std::size_t>(model_.mesh.node_cloth[n])].name != p.of) continue;
          if (n < state.node_liquid.size()) mass += static_cast<double>(state.node_liquid[n]) * model_.quantum;
          if (n < model_.samples.node_capacity.size()) capacity += model_.samples.node_capacity[n];
          for (std::size_t a = 0; a < 3; ++a) {
            if (n < state.node_pin_force.size()) pins[a] += state.node_pin_force[n][a];
            if (n < state.node_contact_force.size()) contact[a] += state.node_contact_force[n][a];
            if (n < state.node_friction_force.size()) contact[a] += state.node_friction_force[n][a];
          }
        }
        row += number(mass) + number(capacity > 0 ? mass / capacity : 0) + numbers(pins) + numbers(contact);
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
