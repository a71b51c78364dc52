// The counts of a set-up, for the estimate of its memory.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "setup/build.hpp"
#include "setup/deforming_body.hpp"
#include "setup/point_grid.hpp"
#include "state/nozzle.hpp"

namespace drench {
namespace {

/// Cells of edge h of a table over the points (CellTable::make_keys of the Kokkos backend).
double cells_over(const std::vector<Vec3>& points, double h) {
  if (points.empty()) return 0;
  double cells = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto [low, high] =
        std::minmax_element(points.begin(), points.end(), [a](const Vec3& p, const Vec3& q) { return p[a] < q[a]; });
    cells *= std::floor(((*high)[a] - (*low)[a]) / h) + 2;
  }
  const double count = static_cast<double>(points.size());
  if (cells <= std::max(65536.0, 8 * count)) return cells;
  return std::max(1024.0, std::exp2(std::ceil(std::log2(2 * count))));
}

/// Some 32 points of `grid` that lie together when they are ordered by cell, x fastest: those of the cell of point i
/// and of the next ones.
std::vector<Vec3> bundle_by_cell(const PointGrid& grid, std::size_t i, double h) {
  constexpr int farthest = 32;  // cells
  std::vector<Vec3> bundle;
  Vec3 cell = grid.points()[i];
  for (int k = 0; k < farthest && bundle.size() < list_bundle; ++k, cell[0] += h)
    grid.for_box(cell, cell, [&](Index p) {
      if (bundle.size() < list_bundle) bundle.push_back(grid.points()[static_cast<std::size_t>(p)]);
    });
  return bundle;
}

/// Points of `grid` within h of each row of some bundles all over the list, until so many points were looked at that a
/// cloth far finer than h would take minutes. The rows lie in memory as they are, or else ordered by cell.
RowEntries entries_of_bundles(const PointGrid& rows, bool by_cell, const PointGrid& grid, double h, bool same_set) {
  constexpr std::size_t enough = 640;
  constexpr double patience = 1.5e7, golden = 0.61803398874989485;
  const std::vector<Vec3>& points = rows.points();
  const std::size_t bundles = (points.size() + list_bundle - 1) / list_bundle;
  double own = 0, bundled = 0, seen = 0, looked_at = 0;
  for (std::size_t b = 0; b < std::min(bundles, enough) && looked_at < patience; ++b) {
    double whole = 0;
    const double place = std::modf(static_cast<double>(b) * golden, &whole) * static_cast<double>(bundles);
    const std::size_t first = list_bundle * (bundles <= enough ? b : static_cast<std::size_t>(place));
    std::vector<Vec3> bundle;
    if (by_cell)
      bundle = bundle_by_cell(rows, first, h);
    else
      bundle.assign(points.begin() + static_cast<std::ptrdiff_t>(first),
                    points.begin() + static_cast<std::ptrdiff_t>(std::min(points.size(), first + list_bundle)));
    double widest = 0;
    for (const Vec3& row : bundle) {
      Vec3 low = row, high = row;
      for (std::size_t a = 0; a < 3; ++a) low[a] -= h, high[a] += h;
      double count = same_set ? -1 : 0;
      grid.for_box(low, high, [&](Index p) {
        const Vec3& x = grid.points()[static_cast<std::size_t>(p)];
        double square = 0;
        for (std::size_t a = 0; a < 3; ++a) square += (x[a] - row[a]) * (x[a] - row[a]);
        count += square < h * h ? 1 : 0;
        looked_at += 1;
      });
      own += count;
      widest = std::max(widest, count);
    }
    bundled += widest * static_cast<double>(bundle.size());
    seen += static_cast<double>(bundle.size());
  }
  return {own / seen, bundled / seen};
}

/// `rows` are of liquid, which lies in memory by cell, or of samples.
RowEntries count_entries(const PointGrid& rows, bool liquid, const PointGrid& grid, double h, bool same_set) {
  if (rows.points().empty() || grid.points().empty()) return {0, 0};
  RowEntries found = entries_of_bundles(rows, false, grid, h, same_set);
  if (!liquid) return found;
  const RowEntries by_cell = entries_of_bundles(rows, true, grid, h, same_set);
  found.bundled = by_cell.own > 0 ? found.own * by_cell.bundled / by_cell.own : found.own;
  return found;
}

PointGrid grid_of(const std::vector<Vec3>& points, double h) {
  PointGrid grid(h);
  for (const Vec3& x : points) grid.add(x);
  return grid;
}

/// Pairs of nodes that share an edge or a hinge, each twice.
double count_links(const ClothMesh& mesh) {
  std::vector<std::pair<Index, Index>> pairs;
  for (const auto& e : mesh.edge) pairs.push_back(std::minmax(e[0], e[1]));
  for (const auto& s : mesh.stitch) pairs.push_back(std::minmax(s[0], s[1]));
  for (const auto& hinge : mesh.hinge)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = a + 1; b < 4; ++b) pairs.push_back(std::minmax(hinge[a], hinge[b]));
  for (const auto& p : mesh.plate_pair) pairs.emplace_back(p[0], p[1]);
  std::sort(pairs.begin(), pairs.end());
  return 2 * static_cast<double>(std::unique(pairs.begin(), pairs.end()) - pairs.begin());
}

std::vector<Vec3> sample_places(const Model& m, const HostState& s) {
  std::vector<Vec3> places;
  for (std::size_t p = 0; p < m.samples.triangle.size(); ++p) {
    Vec3 x{0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      const Index n = m.mesh.triangle[static_cast<std::size_t>(m.samples.triangle[p])][k];
      for (std::size_t a = 0; a < 3; ++a)
        x[a] += m.samples.weight[p][k] * s.node_position[static_cast<std::size_t>(n)][a];
    }
    places.push_back(x);
  }
  return places;
}

}  // namespace

SetupSize kinds_of(const Model& m) {
  SetupSize size;
  size.scene = m.scene;
  for (const Body& b : m.bodies) {
    size.field += static_cast<double>(b.field.points[0]) * b.field.points[1] * b.field.points[2];
    size.part_field += static_cast<double>(b.parts[1].value.size());  // not known before the set-up
  }
  for (const Body& b : m.bodies) {
    if (!b.deforms()) continue;
    const auto points = static_cast<double>(b.mesh_points.size());
    size.deforming_field += static_cast<double>(b.field.points[0]) * b.field.points[1] * b.field.points[2];
    size.deforming_points += points;
    size.deforming_files += points * static_cast<double>(b.shape.points.size());
    size.deforming_triangles += static_cast<double>(b.mesh_triangles.size());
    size.deforming_pairs += near_pairs(b);
  }
  size.support = m.support / m.spacing;
  size.patches = static_cast<double>(m.patches.size());
  size.searches_samples = m.has_fluid() || m.has_contact_wicking();
  size.moving_cloth = m.has_moving_cloth();
  size.porous = m.has_porous();
  size.liquid = m.has_fluid();
  size.absorption = m.has_absorption();
  size.emission = m.has_emission();
  size.adds_particles = m.adds_particles();
  size.permeation = m.has_permeation();
  size.evaporation = m.evaporation_flux > 0;
  size.solute = m.has_solute();
  size.direction = m.has_direction();
  size.diffusion = m.has_diffusion();
  size.contact_wicking = m.has_contact_wicking();
  size.films = m.has_films();
  size.squeezing = m.has_squeezing();
  size.hysteresis = m.has_hysteresis();
  size.suction = m.has_suction();
  size.narrowing = m.has_narrowing();
  size.expands = m.expands_when_wet();
  size.self_collision = m.has_self_collision();
  size.xpbd = m.has_moving_cloth() && m.scene.cloth_solver.method == ClothMethod::xpbd;
  size.strain_limit = m.has_strain_limit();
  size.membrane = m.has_membrane();
  size.softens = m.softens_when_wet();
  size.plate = !m.mesh.plate_pair.empty();
  size.wet_adhesion = m.has_wet_adhesion();
  size.measures = m.has_measures();
  size.fabric = m.has_fabric();
  size.micropolar = m.has_micropolar();
  if (m.has_slipping_body()) size.wall_planes = m.has_moving_body() ? 2 : 1;
  size.frames = m.scene.output.every > 0;
  size.surface = size.frames && m.has_surface();
  return size;
}

double jet_particles(const Model& model) {
  double count = 0;
  for (const Jet& jet : model.jets) {
    if (jet.mouth) {
      count += volume_out(jet, model.scene.time.end) / std::pow(model.spacing, 3);
      continue;
    }
    if (jet.has_keys()) {
      count += jet.out(model.scene.time.end) / jet.advance;
      continue;
    }
    count += std::max(0.0, std::min(jet.scene.end, model.scene.time.end) - jet.scene.start) / jet.interval;
  }
  return count;
}

double dripping_particles(const Setup& setup) {
  const Model& m = setup.model;
  if (!m.has_emission()) return 0;
  double excess = 0;  // kg
  for (std::size_t n = 0; n < setup.state.node_liquid.size(); ++n)
    excess += std::max(0.0, static_cast<double>(setup.state.node_liquid[n]) * m.quantum - m.samples.node_capacity[n]);
  return excess / m.particle_mass;
}

SetupSize with_sources(const Setup& setup, SetupSize size) {
  // Room that has grown has half as much to spare, 1.125, as what is made at the start.
  const double before = size.fluid, added = 0.9 * (jet_particles(setup.model) + dripping_particles(setup));
  size.fluid += added;
  // Liquid of jets and drops spreads: it has half the neighbours of full surroundings.
  const double neighbors = 0.5 * 4.0 / 3 * std::numbers::pi * std::pow(size.support, 3);
  RowEntries& row = size.entries.fluid_fluid;
  if (added > 0 && row.own >= 0)
    row = {(before * row.own + added * neighbors) / size.fluid,
           (before * row.bundled + added * neighbors) / size.fluid};
  return size;
}

SetupSize at_work(SetupSize size) {
  size.crowding = 1.2;
  size.contact = true;
  return size;
}

SetupSize in_folds(SetupSize size) {
  size.fold_pairs = 100;
  return size;
}

SetupSize size_of(const Setup& setup) {
  const Model& m = setup.model;
  SetupSize size = kinds_of(m);
  const auto count = [](const auto& v) { return static_cast<double>(v.size()); };
  size.fluid = static_cast<double>(setup.state.fluid_count());
  size.boundary = static_cast<double>(m.boundary.count());
  size.nodes = static_cast<double>(m.mesh.nodes());
  size.samples = static_cast<double>(m.samples.count());
  size.triangles = count(m.mesh.triangle);
  size.edges = count(m.mesh.edge);
  size.stitches = count(m.mesh.stitch);
  size.hinges = count(m.mesh.hinge);
  size.links = count_links(m.mesh);
  size.fabric_pairs = count(m.fabric.weight);
  for (const double area : m.samples.area) size.area += area / (m.spacing * m.spacing);
  for (const Body& b : m.bodies) size.dynamic_samples += b.is_measured() ? b.sample_count : 0;

  for (const ClothMaterial& cloth : m.cloths) {
    const auto first = m.mesh.pinned.begin() + cloth.first_node;
    if (cloth.dynamics && std::count(first, first + cloth.node_count, 1) == 0) size.wet_sides = 2;
  }

  const double h = m.support;
  const std::vector<Vec3>&fluid = setup.state.fluid_position, &walls = m.boundary.position;
  const std::vector<Vec3> samples = size.searches_samples ? sample_places(m, setup.state) : std::vector<Vec3>();
  size.fluid_cells = cells_over(fluid, h);
  size.boundary_cells = cells_over(walls, h);
  size.sample_cells = cells_over(samples, h);
  const PointGrid of_fluid = grid_of(fluid, h), of_walls = grid_of(walls, h), of_samples = grid_of(samples, h);
  size.entries = {
      count_entries(of_fluid, true, of_fluid, h, true),      count_entries(of_fluid, true, of_walls, h, false),
      count_entries(of_fluid, true, of_samples, h, false),   count_entries(of_samples, false, of_fluid, h, false),
      count_entries(of_samples, false, of_samples, h, true), count_entries(of_samples, false, of_walls, h, false)};
  return size;
}

}  // namespace drench
