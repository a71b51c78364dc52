#include "setup/cloth_sampling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/eigen_vec.hpp"
#include "scene/saturation_limit.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/setup_error.hpp"
#include "setup/solute.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

struct Corners {
  Vector3d a, b, c;
  Corners(const ClothMesh& mesh, Index triangle) {
    const auto& n = mesh.triangle[static_cast<std::size_t>(triangle)];
    a = to_eigen(mesh.rest_position[static_cast<std::size_t>(n[0])]);
    b = to_eigen(mesh.rest_position[static_cast<std::size_t>(n[1])]);
    c = to_eigen(mesh.rest_position[static_cast<std::size_t>(n[2])]);
  }
  double area() const { return 0.5 * (b - a).cross(c - a).norm(); }
  double division(double spacing) const { return std::max(1.0, std::ceil(std::sqrt(area()) / spacing)); }
};

/// m: the samples' largest distance at rest.
double sample_spacing(const Model& model, std::size_t cloth) {
  return model.scene.cloths[cloth].sample_spacing.value_or(model.spacing);
}

void sample_triangle(Model& model, Index triangle, Index cloth) {
  SampleSet& s = model.samples;
  const ClothMaterial& m = model.material_of_triangle(triangle);
  const Corners x(model.mesh, triangle);
  const int k = static_cast<int>(x.division(sample_spacing(model, static_cast<std::size_t>(cloth))));
  const double area = x.area() / k / k;
  s.spacing = std::max(s.spacing, std::sqrt(area));
  const double capacity = m.porous ? (1 - m.solid_fraction) * area * m.thickness * model.rest_density : 0.0;
  // Barycentric coordinates in thirds of a sub-triangle: (i, j) of an upright one's centroid is (3i+1, 3j+1), of one
  // that stands on its head (3i+2, 3j+2).
  const auto add = [&](int u, int v) {
    const double whole = 3.0 * k;
    const std::array<double, 3> w{(3 * k - u - v) / whole, u / whole, v / whole};
    s.triangle.push_back(triangle);
    s.weight.push_back(w);
    s.cloth.push_back(cloth);
    if (model.has_regions()) s.material.push_back(model.mesh.triangle_material[static_cast<std::size_t>(triangle)]);
    s.area.push_back(area);
    s.capacity.push_back(capacity);
    s.rest_position.push_back(to_vec3(w[0] * x.a + w[1] * x.b + w[2] * x.c));
  };
  for (int i = 0; i < k; ++i) {
    for (int j = 0; i + j < k; ++j) {
      add(3 * i + 1, 3 * j + 1);
      if (i + j < k - 1) add(3 * i + 2, 3 * j + 2);
    }
  }
  const Vector3d centre = (x.a + x.b + x.c) / 3;
  for (const Vector3d& corner : {x.a, x.b, x.c})
    s.cover_radius = std::max(s.cover_radius, (corner - centre).norm() / k);
}

/// Calls f(node, quanta) for the nodes of the cloth in the box.
template <class F>
void for_filled(const Model& model, const ClothMaterial& m, const SaturationScene& fill, const char* key,
                std::vector<std::string>& warnings, F&& f) {
  if (!m.porous) throw SetupError(fmt::format("{}: {}: the cloth is not porous", cloth_label(m.name), key));
  if (!(fill.value >= 0 && !exceeds(fill.value, m.most_saturation))) {
    throw SetupError(fmt::format("{}: {}: value {} is out of range; allowed: 0 to max_saturation = {}",
                                 cloth_label(m.name), key, fill.value, m.most_saturation));
  }
  bool any = false, cut = false;
  for (Index n = m.first_node; n < m.first_node + m.node_count; ++n) {
    if (!contains(fill.box.min, fill.box.max, model.mesh.rest_position[static_cast<std::size_t>(n)])) continue;
    const double full = model.samples.node_capacity[static_cast<std::size_t>(n)] / model.quantum;
    const double most = model.material_of_node(n).max_saturation;
    // Rounding must not lift a node above s_max.
    f(n, static_cast<Quanta>(std::min(std::round(fill.value * full), std::floor(most * full))));
    any = true;
    cut = cut || exceeds(fill.value, most);
  }
  if (cut)
    warnings.push_back(
        fmt::format("{}: {}: value {} exceeds the max_saturation of a region, whose nodes start at that limit",
                    cloth_label(m.name), key, fill.value));
  if (!any) warnings.push_back(fmt::format("{}: {}: a box contains no node of the cloth", cloth_label(m.name), key));
}

}  // namespace

double expected_cloth_samples(const Model& model) {
  double count = 0;
  for (std::size_t c = 0; c < model.cloths.size(); ++c) {
    const ClothMaterial& m = model.cloths[c];
    for (Index t = m.first_triangle; t < m.first_triangle + m.triangle_count; ++t)
      count += std::pow(Corners(model.mesh, t).division(sample_spacing(model, c)), 2);
  }
  return count;
}

double cloth_area(const Model& model) {
  double area = 0;
  for (Index t = 0; t < model.mesh.triangles(); ++t) area += Corners(model.mesh, t).area();
  return area;
}

void build_samples(Model& model) {
  SampleSet& s = model.samples;
  for (std::size_t c = 0; c < model.cloths.size(); ++c) {
    ClothMaterial& m = model.cloths[c];
    m.first_sample = s.count();
    for (Index t = m.first_triangle; t < m.first_triangle + m.triangle_count; ++t) {
      sample_triangle(model, t, static_cast<Index>(c));
    }
    m.sample_count = s.count() - m.first_sample;
  }
  const auto nodes = static_cast<std::size_t>(model.mesh.nodes());
  s.node_capacity.assign(nodes, 0.0);
  s.node_weight_sum.assign(nodes, 0.0);
  std::vector<std::array<Index, 2>> entries;
  for (Index p = 0; p < s.count(); ++p) {
    const auto at = static_cast<std::size_t>(p);
    for (int k = 0; k < 3; ++k) {
      const Index n = model.mesh.triangle[static_cast<std::size_t>(s.triangle[at])][k];
      entries.push_back({n, 4 * p + k});
      s.node_capacity[static_cast<std::size_t>(n)] += s.weight[at][k] * s.capacity[at];
      s.node_weight_sum[static_cast<std::size_t>(n)] += s.weight[at][k];
    }
  }
  s.node_samples = rows_of(model.mesh.nodes(), entries);
}

void fill_cloths(Model& model, HostState& state, std::vector<std::string>& warnings) {
  for (std::size_t c = 0; c < model.cloths.size(); ++c) {
    const ClothScene& scene = model.scene.cloths[c];
    const ClothMaterial& m = model.cloths[c];
    const auto hold = [&](Index n, Quanta q, double concentration) {
      state.node_liquid[static_cast<std::size_t>(n)] = q;
      if (model.has_solute()) state.node_solute[static_cast<std::size_t>(n)] = solute_quanta(model, concentration, q);
    };
    for (const SaturationScene& fill : scene.initial_saturation) {
      for_filled(model, m, fill, "initial_saturation", warnings,
                 [&](Index n, Quanta q) { hold(n, q, fill.concentration); });
    }
    // A node belongs to the last box that holds it, or two reservoirs would pull at it.
    std::vector<Index> owner(static_cast<std::size_t>(m.node_count), -1);
    for (std::size_t r = 0; r < scene.hold_saturation.size(); ++r) {
      for_filled(model, m, scene.hold_saturation[r], "hold_saturation", warnings, [&](Index n, Quanta q) {
        owner[static_cast<std::size_t>(n - m.first_node)] = static_cast<Index>(r);
        hold(n, q, scene.hold_saturation[r].concentration);
      });
    }
    for (std::size_t r = 0; r < scene.hold_saturation.size(); ++r) {
      Reservoir reservoir;
      if (model.has_solute()) reservoir.solute = scene.hold_saturation[r].concentration / model.concentration_unit;
      for (Index i = 0; i < m.node_count; ++i) {
        if (owner[static_cast<std::size_t>(i)] != static_cast<Index>(r)) continue;
        reservoir.nodes.push_back(m.first_node + i);
        reservoir.target.push_back(state.node_liquid[static_cast<std::size_t>(m.first_node + i)]);
      }
      if (!reservoir.nodes.empty()) model.reservoirs.push_back(std::move(reservoir));
    }
  }
  add_stains(model, state, warnings);
}

}  // namespace drench
