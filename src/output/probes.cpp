#include "output/probes.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

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

/// Is a place outside of the domain, or in a drain that is open at a time?
bool has_left(const Scene& scene, const Vec3& x, double time) {
  const auto contains = [&x](const Box& box) {
    for (std::size_t a = 0; a < 3; ++a)
      if (x[a] < box.min[a] || x[a] > box.max[a]) return false;
    return true;
  };
  const Vector3d at = to_eigen(x);
  return !contains(scene.domain) || std::ranges::any_of(scene.fluid.drains, [&](const DrainScene& drain) {
    if (time < drain.start || time >= drain.end) return false;
    if (drain.shape == DrainScene::Shape::box) return contains(drain.box);
    if (drain.shape == DrainScene::Shape::sphere) return (at - to_eigen(drain.center)).norm() <= drain.radius;
    return (at - to_eigen(drain.point)).dot(to_eigen(drain.normal)) <= 0;
  });
}

/// Where a particle from a nozzle at rest began the step in which it appeared: on the nozzle's face, from which it has
/// come straight. Elsewhere it has no such place, and counts from where it stands.
Vec3 start_of_new(const Model& model, const HostState& state, std::size_t i, double dt) {
  const Vector3d x = to_eigen(state.fluid_position[i]), v = to_eigen(state.fluid_velocity[i]);
  if (static_cast<Origin>(state.fluid_origin[i]) != Origin::jet || !(v.norm() > 0)) return to_vec3(x);
  const Vector3d axis = v.normalized();
  double ahead = dt * v.norm();
  bool found = false;
  for (const Jet& jet : model.jets) {
    const Vector3d from = x - to_eigen(jet.scene.center);
    const double along = from.dot(axis);
    const bool is_disc = jet.scene.shape == JetScene::Shape::disc;
    const double farthest = is_disc ? jet.scene.radius : 0.5 * std::hypot(jet.scene.size[0], jet.scene.size[1]);
    if (jet.mouth || along < 0 || along > ahead || (from - along * axis).norm() > farthest) continue;
    ahead = along;
    found = true;
  }
  return found ? to_vec3(x - ahead * axis) : to_vec3(x);
}

}  // namespace

ProbeCsv::ProbeCsv(const fs::path& file, const Model& model, HostState start, double after)
    : model_(model), path_(file), every_(model.scene.output.probe_every.value_or(model.scene.output.every)) {
  const std::vector<ProbeScene>& probes = model.scene.output.probes;
  sum_.resize(probes.size());
  passed_.resize(probes.size());
  passed_before_.resize(probes.size());
  for (const ProbeScene& p : probes) {
    target_.push_back(p.kind == ProbeKind::body ? numbered(model.bodies, p.of) : numbered(model.scene.cloths, p.of));
    has_bodies_ = has_bodies_ || p.kind == ProbeKind::body;
    has_means_ = has_means_ || p.kind == ProbeKind::point || p.kind == ProbeKind::cloth;
  }
  for (std::size_t k = 0; k < probes.size(); ++k)
    if (probes[k].kind == ProbeKind::disc)
      discs_.push_back({k, probes[k].position, to_vec3(to_eigen(probes[k].normal).normalized()), probes[k].radius});
  next_ = after >= 0 ? (std::floor(after / every_ * (1 + 1e-12)) + 1) * every_ : every_;
  if (path_.empty()) return;
  if (!discs_.empty()) add_passed(0, start);
  std::string kept = header();
  if (after >= 0 && fs::exists(path_)) {
    std::ifstream in(path_);
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line))
      if (std::strtod(line.c_str(), nullptr) <= after * (1 + 1e-12)) kept += line + '\n';
  }
  write_atomically(path_, kept);
  out_.open(path_, std::ios::app);
  if (!out_) throw std::runtime_error(fmt::format("{}: cannot be written", path_.string()));
}

std::vector<double> ProbeCsv::sums() const {
  std::vector<double> all{elapsed_};
  for (std::size_t k = 0; k < sum_.size(); ++k) {
    all.insert(all.end(), sum_[k].begin(), sum_[k].end());
    all.insert(all.end(), {passed_[k], passed_before_[k]});
  }
  return all;
}

void ProbeCsv::take_up(const std::vector<double>& sums) {
  constexpr std::size_t each = 8;
  if (sums.size() != 1 + each * sum_.size()) return;
  elapsed_ = sums[0];
  for (std::size_t k = 0; k < sum_.size(); ++k) {
    const double* of_probe = sums.data() + 1 + each * k;
    std::copy_n(of_probe, 6, sum_[k].begin());
    passed_[k] = of_probe[6];
    passed_before_[k] = of_probe[7];
  }
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
  if (!due && !has_means_ && discs_.empty()) return;
  const HostState now = state();
  if (has_means_ && !path_.empty()) add_state(report.dt, now);
  if (!discs_.empty() && !path_.empty()) add_passed(report.dt, now);
  if (!due) return;
  next_ = (std::floor(report.time / every_ * (1 + 1e-12)) + 1) * every_;
  if (!path_.empty()) write(now);
  elapsed_ = 0;
  passed_before_ = passed_;
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

/// Counts what has passed discs in a step of `dt` (s), and keeps where particles are now.
void ProbeCsv::add_passed(double dt, const HostState& state) {
  std::vector<Place> now;
  now.reserve(state.fluid_position.size());
  std::vector<std::size_t> order;  // by id; empty: as they are
  if (!std::ranges::is_sorted(state.fluid_id)) {
    order.resize(state.fluid_position.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, [&](std::size_t i) { return state.fluid_id[i]; });
  }
  auto before = last_.begin();
  const Vector3d fall = dt * to_eigen(model_.scene.gravity);
  // Cloth may have absorbed it instead, and then its path is unknown.
  const auto pass_if_left = [&](const Place& p) {
    const Vec3 to = to_vec3(to_eigen(p.position) + dt * (to_eigen(p.velocity) + fall));
    if (has_left(model_.scene, to, state.time)) pass(p.position, to, p.mass);
  };
  for (std::size_t k = 0; k < state.fluid_position.size(); ++k) {
    const std::size_t i = order.empty() ? k : order[k];
    now.push_back({state.fluid_id[i], state.fluid_mass[i], state.fluid_position[i], state.fluid_velocity[i]});
    for (; before != last_.end() && before->id < now.back().id; ++before) pass_if_left(*before);
    const bool is_new = before == last_.end() || before->id != now.back().id;
    if (dt > 0)
      pass(is_new ? start_of_new(model_, state, i, dt) : before->position, now.back().position, now.back().mass);
    if (!is_new) ++before;
  }
  for (; before != last_.end(); ++before) pass_if_left(*before);
  last_ = std::move(now);
}

/// Counts a straight path of a particle.
void ProbeCsv::pass(const Vec3& from, const Vec3& to, Quanta mass) {
  for (const Disc& disc : discs_) {
    const Vector3d n = to_eigen(disc.normal), center = to_eigen(disc.center);
    const double a = (to_eigen(from) - center).dot(n), b = (to_eigen(to) - center).dot(n);
    if ((a < 0) == (b < 0)) continue;
    const Vector3d at = to_eigen(from) + a / (a - b) * (to_eigen(to) - to_eigen(from)) - center;
    if ((at - at.dot(n) * n).norm() <= disc.radius)
      passed_[disc.probe] += (b >= 0 ? 1 : -1) * static_cast<double>(mass) * model_.quantum;
  }
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
        row += number(elapsed_ > 0 ? (passed_[k] - passed_before_[k]) / elapsed_ : 0) + number(passed_[k]);
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
