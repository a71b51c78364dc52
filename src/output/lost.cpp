#include "output/lost.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>

#include "base/eigen_vec.hpp"
#include "setup/body_geometry.hpp"
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

}  // namespace

std::vector<Index> inside_solids(const Model& model, const HostState& state, double step) {
  std::vector<Index> inside;
  std::vector<std::function<double(const Vec3&)>> shapes(model.bodies.size());
  for (std::size_t b = 0; b < shapes.size(); ++b)
    if (model.bodies[b].deforms()) shapes[b] = exact_distance(shape_at(model.bodies[b], state.time));
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    if (state.fluid_age[i] < step) continue;
    for (std::size_t b = 0; b < model.bodies.size(); ++b) {
      const Body& body = model.bodies[b];
      Vec3 x = state.fluid_position[i], normal;
      if (body.deforms()) {
        if (!near_lattice(body, state.time, x) || !(shapes[b](x) < -model.spacing)) continue;
        inside.push_back(static_cast<Index>(i));
        break;
      }
      if (body.moves()) {  // to where the material point that is here now was at t = 0
        const Quaternion& q = state.body_orientation[b];
        const Eigen::Vector3d arm = to_eigen(x) - to_eigen(state.body_position[b]);
        x = to_vec3(to_eigen(body.center) + Eigen::Quaterniond(q[0], q[1], q[2], q[3]).conjugate() * arm);
      }
      if (!(signed_distance(body, x, normal) < -model.spacing)) continue;
      inside.push_back(static_cast<Index>(i));
      break;
    }
  }
  return inside;
}

std::string describe_lost(const Model& model, const HostState& state, double step) {
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
