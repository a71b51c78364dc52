#include "setup/baked_liquid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string_view>
#include <utility>

#include "base/eigen_vec.hpp"
#include "setup/liquid_shapes.hpp"
#include "setup/setup_error.hpp"
#include "state/mass_budget.hpp"
#include "state/needed_fields.hpp"

namespace drench {
namespace {

constexpr double same_time = 1e-6;  // of the time between two files
constexpr std::size_t most_frames = 3;

/// The row of an id among ascending ones; −1: none.
std::int64_t row_of(std::int64_t id, const std::vector<std::int64_t>& ids) {
  const auto found = std::lower_bound(ids.begin(), ids.end(), id);
  return found != ids.end() && *found == id ? found - ids.begin() : -1;
}

template <class T>
void reorder(std::vector<T>& values, const std::vector<std::size_t>& order) {
  std::vector<T> sorted;
  for (const std::size_t i : order) sorted.push_back(values[i]);
  values = std::move(sorted);
}

}  // namespace

BakedLiquid::BakedLiquid(const Model& model)
    : model_(model),
      source_(model.scene.fluid.blocks.front()),
      count_(static_cast<std::int64_t>(source_.sequence.files.size())) {
  std::int64_t first = 0;  // with particles
  while (first + 1 < count_ && frame(first).position.empty()) ++first;
  has_ids_ = !frame(first).id.empty();
  knows_ids_ = true;
}

bool BakedLiquid::begins(double time) const {
  const double at = time * source_.sequence.fps, nearest = std::round(at);
  return nearest >= 1 && nearest < static_cast<double>(count_) && std::abs(at - nearest) < same_time;
}

double BakedLiquid::time_left(double time) const {
  const double next = std::floor(time * source_.sequence.fps + same_time) + 1;
  if (next >= static_cast<double>(count_)) return std::numeric_limits<double>::infinity();
  return next / source_.sequence.fps - time;
}

bool BakedLiquid::in_domain(const Vec3& x) const {
  // Not where rounding to the backend's precision would bring it beyond the border.
  const Box& domain = model_.scene.domain;
  for (std::size_t a = 0; a < 3; ++a) {
    const double margin = 1e-6 * std::max(std::abs(domain.min[a]), std::abs(domain.max[a]));
    if (x[a] < domain.min[a] + margin || x[a] > domain.max[a] - margin) return false;
  }
  return true;
}

BakedLiquid::Frame BakedLiquid::read(std::int64_t number) const {
  try {
    return read_file(number);
  } catch (const SetupError& e) {  // also in the middle of a run, where nobody else knows of the file
    const std::string &file = source_.sequence.files[static_cast<std::size_t>(number)], what = e.what();
    throw SetupError(what.find(file) == std::string::npos ? fmt::format("file '{}': {}", file, what) : what,
                     source_.shape == BlockScene::Shape::mesh ? "fluid.sources.0.mesh.sequence"
                                                              : "fluid.sources.0.particles.sequence");
  }
}

BakedLiquid::Frame BakedLiquid::read_file(std::int64_t number) const {
  BlockScene source = source_;
  source.placed.file = source_.sequence.files[static_cast<std::size_t>(number)];
  std::vector<std::string> warnings, hints;  // those of the first file are reported at set-up
  SourceFile file = read_source_file(model_.scene.path, source, 0, warnings, hints);
  Frame frame;
  frame.number = number;
  frame.id = std::move(file.particles.id);
  const auto fail = [&](const std::string& what) {
    throw SetupError(fmt::format("particle file '{}': {}", source.placed.file, what));
  };
  if (file.particles.position.empty() && file.mesh.mesh_triangles.empty()) return frame;
  if (knows_ids_ && has_ids_ != !frame.id.empty())
    fail(fmt::format("it has {}ids, unlike the first file with particles; allowed: ids (`id`) in all files or in none",
                     has_ids_ ? "no " : ""));
  for (const StartParticle& p : start_particles(model_, source, std::move(file), block_label(source, 0))) {
    frame.position.push_back(p.position);
    frame.velocity.push_back(p.velocity);
    frame.mass.push_back(p.mass);
  }
  if (frame.id.empty()) return frame;
  std::vector<std::size_t> order(frame.id.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return frame.id[a] < frame.id[b]; });
  reorder(frame.id, order);
  reorder(frame.position, order);
  reorder(frame.velocity, order);
  reorder(frame.mass, order);
  if (frame.id.front() < 0) fail(fmt::format("id {}; allowed: 0 or more", frame.id.front()));
  const auto twice = std::adjacent_find(frame.id.begin(), frame.id.end());
  if (twice != frame.id.end()) fail(fmt::format("two particles have the id {}; allowed: one of each", *twice));
  return frame;
}

const BakedLiquid::Frame& BakedLiquid::frame(std::int64_t number) {
  for (const Frame& f : frames_)
    if (f.number == number) return f;
  if (frames_.size() == most_frames)
    frames_.erase(std::min_element(frames_.begin(), frames_.end(),
                                   [](const Frame& a, const Frame& b) { return a.number < b.number; }));
  frames_.reserve(most_frames);  // references to the others stay valid
  return frames_.emplace_back(read(number));
}

BakedLiquid::Frame BakedLiquid::particles_from(std::int64_t number) {
  Frame now = frame(number);
  if (number + 1 == count_) {
    std::fill(now.velocity.begin(), now.velocity.end(), Vec3{0, 0, 0});
    return now;
  }
  if (!has_ids_) return now;
  const Frame& next = frame(number + 1);
  for (std::size_t i = 0; i < now.id.size(); ++i) {
    const std::int64_t row = row_of(now.id[i], next.id);
    if (row < 0) continue;
    const Eigen::Vector3d way = to_eigen(next.position[static_cast<std::size_t>(row)]) - to_eigen(now.position[i]);
    now.velocity[i] = to_vec3(source_.sequence.fps * way);
  }
  return now;
}

void BakedLiquid::start(HostState& state, std::vector<std::string>& warnings) {
  const Frame now = particles_from(0);
  if (source_.shape == BlockScene::Shape::particles) {
    std::vector<StartParticle> particles;
    for (std::size_t i = 0; i < now.position.size(); ++i)
      particles.push_back({now.position[i], now.velocity[i], now.mass[i]});
    warn_of_distances(model_, particles, block_label(source_, 0), false, warnings);
  }
  std::int64_t next_id = 0;
  for (std::size_t i = 0; i < now.position.size(); ++i) {
    if (!in_domain(now.position[i])) continue;
    if (has_ids_) state.next_id = now.id[i];
    append_particle(state, model_, {now.position[i], now.velocity[i], now.mass[i]});
    next_id = state.next_id;
  }
  state.next_id = next_id;
  if (state.fluid_count() == 0 && !now.position.empty())
    throw SetupError(fmt::format("file '{}': none of its {} particles is inside the domain",
                                 source_.sequence.files.front(), now.position.size()),
                     "fluid.sources.0");
}

bool BakedLiquid::is_absorbed(std::int64_t number, std::int64_t id) {
  const Frame& before = frame(number - 1);
  const std::int64_t row = row_of(id, before.id);
  return row >= 0 && in_domain(before.position[static_cast<std::size_t>(row)]);  // and not in the state any more
}

std::vector<BakedLiquid::Match> BakedLiquid::matches(std::int64_t number, const Frame& now, const HostState& state) {
  std::vector<Match> matches;
  for (std::size_t i = 0; i < now.position.size(); ++i) {
    if (!in_domain(now.position[i])) continue;
    const std::int64_t row = has_ids_ ? row_of(now.id[i], state.fluid_id) : -1;
    if (row >= 0 || !has_ids_ || !is_absorbed(number, now.id[i])) matches.push_back({i, row});
  }
  return matches;
}

void BakedLiquid::replace(HostState& state, double time) {
  const std::int64_t number = std::llround(time * source_.sequence.fps);
  const Frame now = particles_from(number);
  const std::vector<Match> particles = matches(number, now, state);
  const Quanta liquid = sum_of(state.fluid_mass), solute = sum_of(state.fluid_solute);
  visit_fields(state, [&](std::string_view field, auto& values) {
    if (!field.starts_with("fluid_") || !needs_field(model_, field)) return;
    std::remove_reference_t<decltype(values)> next(particles.size());
    for (std::size_t k = 0; k < particles.size(); ++k)
      if (particles[k].of_state >= 0) next[k] = values[static_cast<std::size_t>(particles[k].of_state)];
    values = std::move(next);
  });
  state.drained += liquid - sum_of(state.fluid_mass);
  state.solute_drained += solute - sum_of(state.fluid_solute);
  for (std::size_t k = 0; k < particles.size(); ++k) {
    const auto [i, row] = particles[k];
    state.fluid_position[k] = now.position[i];
    state.fluid_velocity[k] = now.velocity[i];
    if (row >= 0) continue;
    state.fluid_mass[k] = now.mass[i];
    state.supplied += now.mass[i];
    state.fluid_density_ratio[k] = 1;
    state.fluid_id[k] = has_ids_ ? now.id[i] : state.next_id;
    state.fluid_origin[k] = static_cast<std::uint8_t>(Origin::block);
    state.next_id = std::max(state.next_id, state.fluid_id[k] + 1);
  }
}

}  // namespace drench
