#include "states.hpp"

#include <cmath>
#include <cstring>
#include <utility>

#include "base/eigen_vec.hpp"

namespace drench::test {

std::string different_bits(const HostState& a, const HostState& b) {
  std::string names;
  std::vector<std::pair<const void*, std::size_t>> bytes;
  visit_fields(a, [&](std::string_view, const auto& v) { bytes.emplace_back(v.data(), v.size() * sizeof(v[0])); });
  std::size_t k = 0;
  visit_fields(b, [&](std::string_view name, const auto& v) {
    const auto [data, size] = bytes[k++];
    if (size != v.size() * sizeof(v[0]) || (size > 0 && std::memcmp(data, v.data(), size) != 0))
      names += " " + std::string(name);
  });
  if (a.drained != b.drained || a.supplied != b.supplied || a.evaporated != b.evaporated) names += " ledger";
  if (a.solute_drained != b.solute_drained || a.solute_supplied != b.solute_supplied ||
      a.solute_deposited != b.solute_deposited)
    names += " solute_ledger";
  if (a.next_id != b.next_id || a.jet_particles != b.jet_particles) names += " counters";
  if (a.step != b.step || a.time != b.time) names += " time";
  return names;
}

double noise(std::size_t n, int a) { return std::sin(12.9898 * double(n) + 78.233 * a + 1); }

int close_pairs(const HostState& s, double near) {
  int close = 0;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3 &a = s.fluid_position[i], &b = s.fluid_position[j];
      close += std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) < near;
    }
  return close;
}

void keep_liquid(HostState& s, const std::vector<std::size_t>& which) {
  visit_fields(s, [&](std::string_view name, auto& array) {
    if (!name.starts_with("fluid_") || array.empty()) return;
    const auto old = array;
    array.clear();
    for (const std::size_t i : which) array.push_back(old[i]);
  });
}

NearestSample nearest_sample(const Model& model, const HostState& s, const Vec3& x, double reach) {
  using Eigen::Vector3d;
  NearestSample nearest;
  double least = reach;
  for (std::size_t p = 0; p < model.samples.triangle.size(); ++p) {
    Vector3d corner[3], position = Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto n = static_cast<std::size_t>(model.mesh.triangle[std::size_t(model.samples.triangle[p])][k]);
      corner[k] = to_eigen(s.node_position[n]);
      position += model.samples.weight[p][k] * corner[k];
    }
    const double distance = (to_eigen(x) - position).norm();
    if (distance >= least) continue;
    least = distance;
    nearest = {to_vec3(position), to_vec3((corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized()), true};
  }
  return nearest;
}

}  // namespace drench::test
