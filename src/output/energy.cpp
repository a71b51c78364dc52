#include "output/energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <vector>

#include "base/eigen_vec.hpp"
#include "output/text_file.hpp"
#include "state/stitch.hpp"

namespace drench {

namespace fs = std::filesystem;

namespace {

using Eigen::Vector3d;

/// Of gravity, J/kg; 0 at the corner of the domain that lies lowest.
class Gravity {
 public:
  explicit Gravity(const Model& model) : g_(to_eigen(model.scene.gravity)) {
    const Box& box = model.scene.domain;
    for (std::size_t a = 0; a < 3; ++a)
      lowest_[static_cast<Eigen::Index>(a)] = g_[static_cast<Eigen::Index>(a)] > 0 ? box.max[a] : box.min[a];
  }
  double operator()(const Vec3& x) const { return -g_.dot(to_eigen(x) - lowest_); }

 private:
  Vector3d g_, lowest_;
};

/// Of the field that draws the liquid, J/kg.
double field_potential(const FieldScene& field, const Vec3& x) {
  double sum = 0;
  for (std::size_t a = 0; field.present && a < 3; ++a)
    sum += 0.5 * std::pow(field.rate[a] * (x[a] - field.center[a]), 2);
  return sum;
}

double half_square(double mass, const Vec3& v) { return 0.5 * mass * to_eigen(v).squaredNorm(); }

void add_liquid(const Model& model, const HostState& state, const Gravity& gravity, Energies& e) {
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    const double mass = static_cast<double>(state.fluid_mass[i]) * model.quantum;
    const Vec3& x = state.fluid_position[i];
    e.liquid_kinetic += half_square(mass, state.fluid_velocity[i]);
    e.liquid_potential += mass * (gravity(x) + field_potential(model.scene.field, x));
  }
}

void add_nodes(const Model& model, const HostState& state, const Gravity& gravity, Energies& e) {
  for (std::size_t n = 0; n < state.node_position.size(); ++n) {
    const double liquid = static_cast<double>(state.node_liquid[n]) * model.quantum;
    const double mass = model.mesh.solid_mass[n] + liquid;
    e.cloth_kinetic += half_square(mass, state.node_velocity[n]);
    e.cloth_potential += mass * gravity(state.node_position[n]);
  }
}

void add_bodies(const Model& model, const HostState& state, const Gravity& gravity, Energies& e) {
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    if (!body.dynamic) continue;
    const Quaternion &q = state.body_orientation[b], &p = body.principal;
    const Vector3d spin =
        (Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * Eigen::Quaterniond(p[0], p[1], p[2], p[3])).conjugate() *
        to_eigen(state.body_angular_velocity[b]);
    e.body_kinetic +=
        half_square(body.mass, state.body_velocity[b]) + 0.5 * spin.cwiseProduct(spin).dot(to_eigen(body.inertia));
    e.body_potential += body.mass * gravity(state.body_position[b]);
  }
}

double saturation_of_node(const Model& model, const HostState& state, Index n) {
  const auto k = static_cast<std::size_t>(n);
  const double capacity = model.samples.node_capacity.empty() ? 0 : model.samples.node_capacity[k];
  return capacity > 0 ? std::min(1.0, static_cast<double>(state.node_liquid[k]) * model.quantum / capacity) : 0.0;
}

/// By what lengths of the fabric at some nodes have grown, as wet as it is (Eq. 11b of docs/theory/cloth.md).
template <std::size_t count>
double growth(const Model& model, const HostState& state, const std::array<Index, count>& nodes) {
  double sum = 0;
  for (const Index n : nodes) sum += model.material_of_node(n).hygral_expansion * saturation_of_node(model, state, n);
  return 1 + sum / count;
}

/// Eqs. 3 and 5 of docs/theory/cloth.md.
void add_springs_and_hinges(const Model& model, const HostState& state, double time, Energies& e) {
  const ClothMesh& mesh = model.mesh;
  const std::vector<Vec3>& x = state.node_position;
  const auto at = [&](Index n) { return to_eigen(x[static_cast<std::size_t>(n)]); };
  for (std::size_t k = 0; k < mesh.edge.size(); ++k) {
    const double longer =
        (at(mesh.edge[k][1]) - at(mesh.edge[k][0])).norm() - growth(model, state, mesh.edge[k]) * mesh.edge_length[k];
    e.stretch += 0.5 * mesh.edge_stiffness[k] * longer * longer;
  }
  for (std::size_t k = 0; k < mesh.stitch.size(); ++k) {
    const double longer = (at(mesh.stitch[k][1]) - at(mesh.stitch[k][0])).norm() -
                          stitch_rest_length(mesh.stitch_length[k], mesh.stitch_time[k], time);
    if (longer <= 0) continue;  // it never pushes
    e.stretch += 0.5 * mesh.stitch_stiffness[k] * longer * longer;
  }
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t a = 0; a < 4; ++a) sum += mesh.hinge_weight[h][a] * at(mesh.hinge[h][a]);
    e.bend += 0.5 * mesh.hinge_stiffness[h] * sum.squaredNorm();
  }
}

/// Eqs. 4a and 7a of docs/theory/cloth.md.
void add_membranes_and_plates(const Model& model, const HostState& state, Energies& e) {
  const ClothMesh& mesh = model.mesh;
  const auto at = [&](Index n) { return to_eigen(state.node_position[static_cast<std::size_t>(n)]); };
  for (std::size_t t = 0; t < mesh.membrane.size(); ++t) {
    const Membrane<double>& m = mesh.membrane[t];
    const auto& [a, b, c] = mesh.triangle[t];
    const auto& [xx, xy, yy] = mesh.triangle_shape[t];
    const double grown = growth(model, state, mesh.triangle[t]);
    const Vector3d first = (at(b) - at(a)) / grown, second = (at(c) - at(a)) / grown;
    const Vector3d f = first * xx, g = first * xy + second * yy;
    const Vector3d u = m.cosine * f + m.sine * g, v = m.cosine * g - m.sine * f;
    const double shear = std::numbers::sqrt2 / 2 * ((u + v).norm() - (u - v).norm());
    const double wet = 1 + (m.wet - 1) *
                               (saturation_of_node(model, state, a) + saturation_of_node(model, state, b) +
                                saturation_of_node(model, state, c)) /
                               3;
    const auto yarn = [](double strain, double lock) {  // over k/2; Eq. 4c
      if (!(lock > 0 && strain > 0)) return strain * strain;
      const double bent = std::min(strain, locking_part * lock), beyond = strain - bent;
      const double part = bent * bent / (lock * lock);
      return -lock * lock * std::log(1 - part) + 2 * bent / (1 - part) * beyond +
             (1 + part) / ((1 - part) * (1 - part)) * beyond * beyond;
    };
    e.stretch += 0.5 * wet *
                 (m.warp * yarn(u.norm() - 1, m.warp_locking) + m.weft * yarn(v.norm() - 1, m.weft_locking) +
                  m.shear * shear * shear);
  }
  for (std::size_t k = 0; k < mesh.plate_pair.size(); ++k)
    e.bend -= 0.5 * mesh.plate_weight[k] * (at(mesh.plate_pair[k][0]) - at(mesh.plate_pair[k][1])).squaredNorm();
}

/// Eq. 9 of docs/theory/cloth.md.
void add_strain_limits(const Model& model, const HostState& state, Energies& e) {
  const ClothMesh& mesh = model.mesh;
  const auto at = [&](Index n) { return to_eigen(state.node_position[static_cast<std::size_t>(n)]); };
  for (std::size_t t = 0; t < mesh.limit_stiffness.size(); ++t) {
    if (mesh.limit_stiffness[t] <= 0) continue;
    const auto& [a, b, c] = mesh.triangle[t];
    const auto& [xx, xy, yy] = mesh.triangle_shape[t];
    const double grown = growth(model, state, mesh.triangle[t]);
    const Vector3d first = (at(b) - at(a)) / grown, second = (at(c) - at(a)) / grown;
    const Vector3d u = first * xx, v = first * xy + second * yy;
    const double mean = 0.5 * (u.squaredNorm() + v.squaredNorm());
    const double half = std::hypot(0.5 * (u.squaredNorm() - v.squaredNorm()), u.dot(v));
    const double limit = model.cloths[static_cast<std::size_t>(mesh.triangle_cloth[t])].strain_limit;
    for (const double square : {mean + half, mean - half}) {
      const double stretch = std::sqrt(std::max(0.0, square));
      if (stretch == 0) continue;
      const double beyond = stretch - std::clamp(stretch, 1 - limit, 1 + limit);
      e.stretch += 0.5 * mesh.limit_stiffness[t] * beyond * beyond;
    }
  }
}

bool floats(const Model& model) {
  return model.any_body([](const Body& b) { return b.dynamic; });
}

struct Column {
  const char* name;
  double (*of)(const Energies&);
  bool (*wanted)(const Model&);  // has the scene something for it?
};
constexpr auto liquid = [](const Model& m) { return m.has_fluid(); };
constexpr auto cloth = [](const Model& m) { return m.has_cloth(); };
constexpr auto moving_cloth = [](const Model& m) { return m.has_moving_cloth(); };
constexpr Column all_columns[] = {
    {"liquid_kinetic", [](const Energies& e) { return e.liquid_kinetic; }, liquid},
    {"liquid_potential", [](const Energies& e) { return e.liquid_potential; }, liquid},
    {"cloth_kinetic", [](const Energies& e) { return e.cloth_kinetic; }, cloth},
    {"cloth_potential", [](const Energies& e) { return e.cloth_potential; }, cloth},
    {"stretch", [](const Energies& e) { return e.stretch; }, moving_cloth},
    {"bend", [](const Energies& e) { return e.bend; }, moving_cloth},
    {"body_kinetic", [](const Energies& e) { return e.body_kinetic; }, floats},
    {"body_potential", [](const Energies& e) { return e.body_potential; }, floats},
    {"total", [](const Energies& e) { return e.total(); }, [](const Model&) { return true; }},
};

/// The header and so many rows of a file that is there; "" if it has not got that far.
std::string rows_of(const fs::path& path, int rows) {
  std::ifstream in(path);
  std::string text, line;
  int lines = 0;
  while (lines <= rows && std::getline(in, line)) text += line + '\n', ++lines;
  return lines == rows + 1 ? text : "";
}

}  // namespace

Energies energies_of(const Model& model, const HostState& state) {
  Energies e;
  const Gravity gravity(model);
  add_liquid(model, state, gravity, e);
  add_nodes(model, state, gravity, e);
  add_bodies(model, state, gravity, e);
  if (!model.has_moving_cloth()) return e;
  add_springs_and_hinges(model, state, state.time, e);
  add_membranes_and_plates(model, state, e);
  add_strain_limits(model, state, e);
  return e;
}

EnergyCsv::EnergyCsv(const fs::path& folder, const Model& model, int frames)
    : model_(model), path_(folder / "energy.csv") {
  if (frames > 0) text_ = rows_of(path_, frames);
  if (!text_.empty() && frames > 0) write_atomically(path_, text_);
  if (!text_.empty()) return;
  text_ = "time";
  for (const Column& column : all_columns)
    if (column.wanted(model)) text_ += fmt::format(",{}", column.name);
  text_ += '\n';
}

void EnergyCsv::write(const HostState& state) {
  const Energies e = energies_of(model_, state);
  text_ += fmt::format("{:.10g}", state.time);
  for (const Column& column : all_columns)
    if (column.wanted(model_)) text_ += fmt::format(",{:.9g}", column.of(e));
  text_ += '\n';
  write_atomically(path_, text_);
}

void EnergyCsv::sync() const {
  if (fs::exists(path_)) sync_to_disk(path_);
}

}  // namespace drench
