#include "setup/body_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/eigen_vec.hpp"
#include "base/free_cores.hpp"
#include "setup/body_geometry.hpp"
#include "setup/deforming_body.hpp"
#include "setup/distance_field.hpp"
#include "setup/facing_parts.hpp"
#include "setup/mesh_guess.hpp"
#include "setup/setup_error.hpp"
#include "setup/solid_mesh.hpp"

namespace drench {
namespace {

/// The lattice of a body's field where liquid can be: only cloth and moving bodies meet others beyond the domain.
DistanceField field_in_domain(const Model& m, const Body& body, const Box& region, double margin) {
  Box box = bounds_of(body.mesh_points);
  for (std::size_t a = 0; a < 3; ++a) {
    const double low = box.min[a], high = box.max[a], beyond = 2 * m.spacing;
    box.min[a] = std::clamp(region.min[a] - beyond, low, high);
    box.max[a] = std::clamp(region.max[a] + beyond, low, high);
  }
  return lay_field(box.min, box.max, m.spacing, margin);
}

/// Twice the steps of a body's lattice of distances: the spacing of the liquid. Where cloth moves, coarse liquid must
/// not blur details of the body: steps are at most as long as most edges of its mesh.
double field_spacing(const Model& m, const Body& body, double margin) {
  constexpr double of_an_edge = 0.75, most_steps = 170;  // the latter along the longest side of the lattice
  if (!m.has_moving_cloth()) return m.spacing;
  const auto point = [&](Index i) { return to_eigen(body.mesh_points[static_cast<std::size_t>(i)]); };
  double length = 0;
  for (const auto& t : body.mesh_triangles)
    for (std::size_t c = 0; c < 3; ++c) length += (point(t[c]) - point(t[(c + 1) % 3])).norm();
  const Box box = bounds_of(body.mesh_points);
  const double edge = length / (3 * static_cast<double>(body.mesh_triangles.size())),
               longest = (to_eigen(box.max) - to_eigen(box.min)).maxCoeff() + 2 * margin;
  return std::min(m.spacing, 2 * std::max(of_an_edge * edge, longest / most_steps));
}

}  // namespace

void lay_body_fields(Model& m, const Box& wetted, std::vector<std::string>& warnings) {
  const std::vector<double>& edges = m.mesh.edge_length;
  const double mean_edge =
      edges.empty() ? 0 : std::accumulate(edges.begin(), edges.end(), 0.0) / static_cast<double>(edges.size());
  double margin = m.spacing;
  m.for_materials([&](const ClothMaterial& c) {
    margin = std::max(margin, 1.1 * c.thickness + m.spacing);
    if (c.dynamics && c.wet_adhesion > 0)  // law 1 of docs/theory/wet_adhesion.md
      margin = std::max(margin, c.thickness + std::max(2 * c.thickness, mean_edge) + m.spacing);
  });
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    Body& body = m.bodies[b];
    if (body.kind != BodyScene::Kind::mesh) continue;
    double spacing = m.spacing;
    if (body.deforms()) {
      const TimeScene& time = m.scene.time;
      blaming(fmt::format("bodies.{}.mesh", b), [&] {
        lay_deforming_field(body, m.spacing, margin, time.step,
                            time.mode == TimeMode::cfl ? time.cfl * m.spacing : INFINITY);
      });
    } else if (!m.scene.bodies[b].inside && bounds_solid(body.mesh_triangles)) {
      const bool met_in_domain = !m.has_moving_cloth() && std::none_of(m.bodies.begin(), m.bodies.end(),
                                                                       [](const Body& other) { return other.moves(); });
      spacing = field_spacing(m, body, margin);
      body.field = met_in_domain ? field_in_domain(m, body, wetted, margin) : lay_field(body, spacing, margin);
    }
    if (const std::string line = coarse_field(body.field, spacing); !line.empty())
      warnings.push_back(fmt::format("{}: {}", body_label(body.name, b), line));
  }
}

bool FilledBodies::fill(Body& body, double thickness) const {
  const DistanceField& lattice = body.field;
  for (const Filled& f : filled_) {
    if (f.thickness != thickness || f.field.origin != lattice.origin || f.field.spacing != lattice.spacing ||
        f.field.points != lattice.points || f.points != body.mesh_points || f.triangles != body.mesh_triangles)
      continue;
    body.field = f.field;
    body.parts = f.parts;
    return true;
  }
  return false;
}

void FilledBodies::keep(const Body& body, double thickness) {
  constexpr std::size_t most = 2;  // some 100 MB each
  if (filled_.size() == most) filled_.erase(filled_.begin());
  filled_.push_back({thickness, body.mesh_points, body.mesh_triangles, body.field, body.parts});
}

void fill_body_fields(Model& m, FilledBodies* filled) {
  double thickness = 0;  // m: of the thickest cloth that moves
  m.for_materials([&](const ClothMaterial& c) {
    if (c.dynamics) thickness = std::max(thickness, c.thickness);
  });
  for (Body& body : m.bodies) {
    if (!(body.field.spacing > 0)) continue;
    FilledBodies* const known = body.deforms() ? nullptr : filled;
    if (known != nullptr && known->fill(body, thickness)) continue;
    fill_field(body, body.field, host_threads());
    if (m.has_moving_cloth() && !body.deforms()) find_facing_parts(body, thickness, host_threads());
    if (known != nullptr) known->keep(body, thickness);
  }
}

}  // namespace drench
