#include "setup/cloth_regions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <type_traits>
#include <utility>

#include "base/eigen_vec.hpp"
#include "setup/cloth_material.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/mesh_io.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

std::string names_of(const SurfaceMesh& mesh) {
  constexpr std::size_t most = 20;
  std::string all;
  std::size_t count = 0;
  for (const auto& group : mesh.groups)
    if (group.first.find('\n') == group.first.npos && ++count <= most) all += (all.empty() ? "" : ", ") + group.first;
  if (count > most) all += fmt::format(", … ({} in all)", count);
  return all.empty() ? "none: the file has no named groups" : all;
}

std::vector<Index> triangles_in_box(const SurfaceMesh& mesh, const Box& box) {
  std::vector<Index> inside;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Vec3 middle{0, 0, 0};
    for (const Index n : mesh.triangles[t])
      for (std::size_t a = 0; a < 3; ++a) middle[a] += mesh.points[static_cast<std::size_t>(n)][a] / 3;
    if (contains(box.min, box.max, middle)) inside.push_back(static_cast<Index>(t));
  }
  return inside;
}

/// `level`: of a painted region.
std::vector<Index> triangles_of(const RegionScene& region, int level, const SurfaceMesh& mesh, const std::string& label,
                                const std::string& key) {
  if (region.kind == RegionScene::Kind::box) return triangles_in_box(mesh, region.box);
  if (region.kind == RegionScene::Kind::attribute) {
    if (mesh.groups.count(painted_group(region.attribute, 0)) == 0)
      throw SetupError(fmt::format("{}: the vertices of its mesh have no attribute '{}'; allowed: the name of one of "
                                   "their numbers, which lie between 0 and 1",
                                   label, region.attribute),
                       key + ".attribute");
    const auto painted = mesh.groups.find(painted_group(region.attribute, level));
    return painted == mesh.groups.end() ? std::vector<Index>{} : painted->second;
  }
  const auto found = mesh.groups.find(region.group);
  if (found == mesh.groups.end())
    throw SetupError(fmt::format("{}: its mesh has no group '{}'; allowed: {}", label, region.group, names_of(mesh)),
                     key + ".group");
  return found->second;
}

/// The mean of two numbers that need not be given, `share` of the second.
void blend(std::optional<double>& to, const std::optional<double>& other, double share, double own, double others) {
  if (!to && !other) return;
  const double from = to.value_or(own);
  to = from + share * (other.value_or(others) - from);
}

/// A fabric with `share` of another. What only one of them has, stays as the cloth has it.
MaterialScene blended(const MaterialScene& cloth, const MaterialScene& region, double share) {
  MaterialScene m = cloth;
  const auto mix = [share](double& to, double other) {
    if (to != other) to += share * (other - to);
  };
  blend(m.friction_wet, region.friction_wet, share, cloth.friction, region.friction);
  blend(m.damping_wet, region.damping_wet, share, cloth.damping, region.damping);
  blend(m.weft_diffusivity, region.weft_diffusivity, share, cloth.diffusivity, region.diffusivity);
  ResolvedMaterial<double> numbers, others;  // for visit_members, the one list of them
  static_cast<BasicMaterial<double>&>(numbers) = cloth;
  static_cast<BasicMaterial<double>&>(others) = region;
  visit_members(numbers, others, [&]<class T>(T& to, const T& other) {
    if constexpr (std::is_same_v<T, double>) mix(to, other);
  });
  static_cast<BasicMaterial<double>&>(m) = numbers;
  for (double MaterialScene::*number :
       {&MaterialScene::areal_density, &MaterialScene::stretch, &MaterialScene::bend, &MaterialScene::emission_angle})
    mix(m.*number, region.*number);
  if (!(m.diffusivity > 0)) m.weft_diffusivity.reset();
  // An absorption of 0 blocks the liquid, and takes no other.
  if (cloth.uptake_velocity > 0 && region.uptake_velocity == 0 && region.absorption == 0)
    m.uptake_velocity = (1 - share) * cloth.uptake_velocity;
  else
    mix(m.uptake_velocity, region.uptake_velocity);
  if (m.membrane && region.membrane) {
    mix(m.membrane->warp, region.membrane->warp);
    mix(m.membrane->weft, region.membrane->weft);
    mix(m.membrane->shear, region.membrane->shear);
    mix(m.membrane->wet, region.membrane->wet);
    const auto mix_locking = [share](double& to, double other) {  // 0: never
      const double sum = (to > 0 ? (1 - share) / to : 0) + (other > 0 ? share / other : 0);
      to = sum > 0 ? std::min(10.0, 1 / sum) : 0;
    };
    mix_locking(m.membrane->warp_locking, region.membrane->warp_locking);
    mix_locking(m.membrane->weft_locking, region.membrane->weft_locking);
  }
  if (m.bending && region.bending) {
    mix(m.bending->warp, region.bending->warp);
    mix(m.bending->weft, region.bending->weft);
    mix(m.bending->twist, region.bending->twist);
  }
  return m;
}

/// Materials of a node's triangles, each with its part of the node's area, in 2^-30.
using Mixture = std::vector<std::pair<Index, std::int64_t>>;

/// Means of materials, one after the other.
class Mean {
 public:
  explicit Mean(const ClothMaterial& first, double weight) : mean_(first), sum_(weight) {}

  void add(const ClothMaterial& other, double weight) {
    if (!(weight > 0)) return;
    sum_ += weight;
    const double part = weight / sum_;
    visit_members(mean_, other, [part]<class T>(T& to, const T& from) {
      if constexpr (std::is_same_v<T, double>)
        if (to != from && !std::isinf(to)) to += part * (from - to);
    });
    if (mean_.areal_density != other.areal_density)
      mean_.areal_density += part * (other.areal_density - mean_.areal_density);
  }
  const ClothMaterial& mean() const { return mean_; }

 private:
  ClothMaterial mean_;
  double sum_;
};

double pores(const ClothMaterial& m) { return (1 - m.solid_fraction) * m.thickness; }

/// The mean of a mixture by area · weight(material).
template <class Weight>
ClothMaterial mean_of(const Model& model, const Mixture& mixture, Weight weight) {
  const auto part = [&](std::size_t k) {
    return static_cast<double>(mixture[k].second) * weight(model.material(mixture[k].first));
  };
  std::size_t first = 0;
  while (first + 1 < mixture.size() && !(part(first) > 0)) ++first;
  Mean mean(model.material(mixture[first].first), part(first));
  for (std::size_t k = first + 1; k < mixture.size(); ++k) mean.add(model.material(mixture[k].first), part(k));
  return mean.mean();
}

/// Between regions: liquid and mass of a node are those of its parts.
ClothMaterial mixed(const Model& model, const Mixture& mixture) {
  ClothMaterial m = mean_of(model, mixture, [](const ClothMaterial&) { return 1; });
  const ClothMaterial by_mass = mean_of(model, mixture, [](const ClothMaterial& c) { return c.areal_density; });
  const ClothMaterial by_pores = mean_of(model, mixture, pores);
  m.damping = by_mass.damping;
  m.damping_wet = by_mass.damping_wet;
  m.max_saturation = by_pores.max_saturation;
  m.critical_saturation = by_pores.critical_saturation;
  double all = 0, filled = 0;
  for (const auto& [number, area] : mixture) {
    all += static_cast<double>(area);
    filled += static_cast<double>(area) * pores(model.material(number));
  }
  m.solid_fraction = 1 - filled / (all * m.thickness);
  m.region = -1;
  return m;
}

/// What a node has without a material of its own: that of its triangles, or within a painted region and beside it that
/// of the level nearest to their mean; −1: there is none.
Index single_material(const Model& model, const Mixture& mixture) {
  if (mixture.size() == 1) return mixture[0].first;
  const auto cloths = static_cast<Index>(model.cloths.size());
  Index painted = -1;  // one of the region's
  double all = 0, levels = 0;
  for (const auto& [number, area] : mixture) {
    const ClothMaterial& m = model.material(number);
    all += static_cast<double>(area);
    if (number < cloths) continue;
    if (m.level == 0 || (painted >= 0 && m.region != model.material(painted).region)) return -1;
    painted = number;
    levels += static_cast<double>(area) * m.level;
  }
  const auto level = static_cast<int>(std::lround(levels / all));
  const ClothMaterial& m = model.material(painted);
  return level > 0 ? painted + static_cast<Index>(level - m.level) : m.of_cloth;
}

std::vector<Mixture> mixtures_of_nodes(const Model& model) {
  const ClothMesh& mesh = model.mesh;
  std::vector<std::map<Index, double>> area(mesh.rest_position.size());
  for (std::size_t t = 0; t < mesh.triangle.size(); ++t) {
    const auto at = [&](std::size_t c) { return mesh.rest_position[static_cast<std::size_t>(mesh.triangle[t][c])]; };
    const double own = triangle_area(at(0), at(1), at(2));
    for (const Index n : mesh.triangle[t]) area[static_cast<std::size_t>(n)][mesh.triangle_material[t]] += own;
  }
  std::vector<Mixture> mixtures;
  for (const auto& parts : area) {
    double sum = 0;
    for (const auto& part : parts) sum += part.second;
    mixtures.emplace_back();
    for (const auto& [number, own] : parts) mixtures.back().emplace_back(number, std::llround(own / sum * 0x1p30));
  }
  return mixtures;
}

}  // namespace

std::string region_label(const RegionScene& region, int number) {
  switch (region.kind) {
    case RegionScene::Kind::group:
      return "region " + region.group;
    case RegionScene::Kind::attribute:
      return "region " + region.attribute + " (painted)";
    default:
      return fmt::format("region {} (box)", number);
  }
}

std::set<std::string> painted_attributes(const ClothScene& cloth) {
  std::set<std::string> names;
  for (const RegionScene& r : cloth.regions)
    if (r.kind == RegionScene::Kind::attribute) names.insert(r.attribute);
  return names;
}

bool needs_groups(const ClothScene& cloth) {
  return std::any_of(cloth.regions.begin(), cloth.regions.end(),
                     [](const RegionScene& r) { return r.kind == RegionScene::Kind::group; }) ||
         std::any_of(cloth.sew.begin(), cloth.sew.end(),
                     [](const SewScene& s) { return s.kind == SewScene::Kind::groups; });
}

Patchwork::Patchwork(const ClothScene& cloth, const SurfaceMesh& own, const std::string& key)
    : cloth_(cloth), triangles_(own.triangles.size()) {
  if (cloth.regions.empty()) return;
  patch_.assign(own.triangles.size(), -1);
  std::vector<std::size_t> count(cloth.regions.size(), 0);
  const auto label = [&](std::size_t r) {
    return cloth_label(cloth.name) + ": " + region_label(cloth.regions[r], static_cast<int>(r));
  };
  const auto key_of = [&](std::size_t r) { return fmt::format("{}.regions.{}", key, r); };
  for (std::size_t r = 0; r < cloth.regions.size(); ++r) {
    const RegionScene& region = cloth.regions[r];
    const bool painted = region.kind == RegionScene::Kind::attribute;
    for (int level = painted ? 1 : 0; level <= (painted ? paint_levels : 0); ++level) {
      for (const Index t : triangles_of(region, level, own, label(r), key_of(r)))
        patch_[static_cast<std::size_t>(t)] = static_cast<Index>(patches_.size());
      patches_.push_back(
          {static_cast<Index>(r), level,
           painted ? blended(cloth.material, region.material, double(level) / paint_levels) : region.material});
    }
  }
  for (const Index p : patch_)
    if (p >= 0) ++count[static_cast<std::size_t>(patches_[static_cast<std::size_t>(p)].region)];
  for (std::size_t r = 0; r < count.size(); ++r)
    if (count[r] == 0)
      throw SetupError(label(r) + " has no triangles; allowed: a place with triangles that no later region covers",
                       key_of(r));
}

void append_patches(Model& model, const ClothScene& cloth, const Patchwork& fabric) {
  const std::vector<ClothScene>& all = model.scene.cloths;
  if (std::all_of(all.begin(), all.end(), [](const ClothScene& c) { return c.regions.empty(); })) return;
  const auto number = static_cast<Index>(model.cloths.size());
  const auto first = static_cast<Index>(all.size() + model.patches.size());
  for (std::size_t t = 0; t < fabric.triangles(); ++t) {
    const Index patch = fabric.patch_of(static_cast<Index>(t));
    model.mesh.triangle_material.push_back(patch < 0 ? number : first + patch);
  }
  for (const Patchwork::Patch& patch : fabric.patches()) {
    model.patches.push_back(resolve_material(cloth, patch.fabric, model.scene.processes));
    model.patches.back().of_cloth = number;
    model.patches.back().region = patch.region;
    model.patches.back().level = patch.level;
    model.patch_fabrics.push_back(patch.fabric);
  }
}

void set_node_materials(Model& model) {
  if (!model.has_regions()) return;
  std::map<Mixture, Index> numbers;
  for (const Mixture& mixture : mixtures_of_nodes(model)) {
    if (const Index one = single_material(model, mixture); one >= 0) {
      model.mesh.node_material.push_back(one);
      continue;
    }
    const auto next = static_cast<Index>(model.cloths.size() + model.patches.size());
    const auto [known, is_new] = numbers.try_emplace(mixture, next);
    if (is_new) model.patches.push_back(mixed(model, mixture));
    model.mesh.node_material.push_back(known->second);
  }
}

}  // namespace drench
