#include "output/lost.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>

#include "base/eigen_vec.hpp"
#include "setup/body_geometry.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/deforming_body.hpp"
#include "setup/distance_field.hpp"
#include "state/deforming_body.hpp"

namespace drench {
namespace {

/// Is x where the lattice of a body that changes its shape is?
bool near_lattice(const Body& body, double time, const Vec3& x) {
  const Vec3 origin = lattice_origin(body, time);
  for (std::size_t a = 0; a < 3; ++a)
    if (!(x[a] >= origin[a] && x[a] <= origin[a] + (body.field.points[a] - 1) * body.field.spacing)) return false;
  return true;
}

/// Signed distances to the solids where they are in a state.
class SolidsNow {
 public:
  SolidsNow(const Model& model, const HostState& state) : model_(model), state_(state), shapes_(model.bodies.size()) {
    for (std::size_t b = 0; b < shapes_.size(); ++b)
      if (model.bodies[b].deforms()) shapes_[b] = exact_distance(shape_at(model.bodies[b], state.time));
  }
  /// The least of them, m.
  double least_distance(Vec3 x) const { return nearest_two(x)[0].distance; }

  struct Near {
    double distance = 1e30;
    std::size_t body = 0;
  };
  /// The nearest solid and the next one.
  std::array<Near, 2> nearest_two(Vec3 x) const {
    std::array<Near, 2> least;
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      const Near here{distance(b, x), b};
      if (here.distance < least[0].distance)
        least = {here, least[0]};
      else if (here.distance < least[1].distance)
        least[1] = here;
    }
    return least;
  }
  std::string name(std::size_t b) const { return body_label(model_.bodies[b].name, b); }
  /// Two solids that overlap where a node of cloth is, and what to do about it.
  std::string describe_overlap(const std::array<Near, 2>& near, const Vec3& x) const {
    const double depth = -near[0].distance - near[1].distance;
    return fmt::format(
        "; {} and {} overlap by {:.2g} m at ({:.4f}, {:.4f}, {:.4f}): leave room for the cloth between them",
        name(std::min(near[0].body, near[1].body)), name(std::max(near[0].body, near[1].body)), depth, x[0], x[1],
        x[2]);
  }

 private:
  double distance(std::size_t b, Vec3 x) const {
    const Body& body = model_.bodies[b];
    if (body.deforms()) return near_lattice(body, state_.time, x) ? shapes_[b](x) : 1e30;
    if (body.moves()) {  // to where the material point that is here now was at t = 0
      const Quaternion& q = state_.body_orientation[b];
      const Eigen::Vector3d arm = to_eigen(x) - to_eigen(state_.body_position[b]);
      x = to_vec3(to_eigen(body.center) + Eigen::Quaterniond(q[0], q[1], q[2], q[3]).conjugate() * arm);
    }
    Vec3 normal;
    return signed_distance(body, x, normal);
  }

  const Model& model_;
  const HostState& state_;
  std::vector<std::function<double(const Vec3&)>> shapes_;
};

}  // namespace

std::vector<Index> inside_solids(const Model& model, const HostState& state, double step) {
  std::vector<Index> inside;
  const SolidsNow solids(model, state);
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i)
    if (!(state.fluid_age[i] < step) && solids.least_distance(state.fluid_position[i]) < -model.spacing)
      inside.push_back(static_cast<Index>(i));
  return inside;
}

std::string describe_nodes_inside(const Model& model, const HostState& state) {
  if (model.bodies.empty() || !model.has_moving_cloth()) return "";
  const SolidsNow solids(model, state);
  std::string text;
  for (const ClothMaterial& cloth : model.cloths) {
    std::size_t inside = 0;
    double deepest = 0, most_overlap = 0;
    std::string overlap;
    for (Index n = cloth.first_node; n < cloth.first_node + cloth.node_count; ++n) {
      if (model.mesh.pinned[static_cast<std::size_t>(n)]) continue;
      const Vec3& x = state.node_position[static_cast<std::size_t>(n)];
      const auto near = solids.nearest_two(x);
      const double distance = near[0].distance;
      // The solver's distance to a mesh is interpolated: what is less deep than a tenth of the thickness is not told
      // apart.
      if (!(distance < -0.1 * cloth.thickness)) continue;
      ++inside;
      deepest = std::max(deepest, -distance);
      if (-near[1].distance <= most_overlap) continue;
      most_overlap = -near[1].distance;
      overlap = solids.describe_overlap(near, x);
    }
    if (inside > 0)
      text += fmt::format("{}t = {:.6g} s: {}: {} nodes are inside solids, up to {:.2g} m deep{}",
                          text.empty() ? "" : "; ", state.time, cloth_label(cloth.name), inside, deepest, overlap);
  }
  return text;
}

std::string describe_lost(const Model& model, const HostState& state, double step) {
  if (model.has_baked_liquid()) return "";  // it goes through bodies
  const std::vector<Index> inside = inside_solids(model, state, step);
  if (inside.empty()) return "";
  std::vector<std::int64_t> ids;
  ids.reserve(inside.size());
  for (const Index i : inside) ids.push_back(state.fluid_id[static_cast<std::size_t>(i)]);
  std::sort(ids.begin(), ids.end());
  const std::size_t named = std::min<std::size_t>(ids.size(), 8);
  return fmt::format("t = {:.6g} s: {} particles are inside solids or outside of containers: ids {}{}", state.time,
                     ids.size(), fmt::join(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(named), " "),
                     ids.size() > named ? " …" : "");
}

}  // namespace drench
