// Neighbour lists as sets.

#include <algorithm>
#include <cmath>
#include <iterator>

#include "compare/decisions.hpp"

namespace drench {
namespace {

using Pairs = std::vector<std::pair<Index, Index>>;

/// The two sets of points that a list pairs.
struct Sides {
  std::vector<Vec3> from, to;
};

Sides sides_of(const std::string& list, const Model& model, const HostState& s) {
  const auto named = [&](const std::string& name) {
    if (name == "fluid") return s.fluid_position;
    if (name == "boundary") return s.boundary_position;
    std::vector<Vec3> samples;
    for (std::size_t p = 0; p < model.samples.triangle.size(); ++p) {
      const auto& nodes = model.mesh.triangle[static_cast<std::size_t>(model.samples.triangle[p])];
      Vec3 x{0, 0, 0};
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t c = 0; c < 3; ++c)
          x[c] += model.samples.weight[p][k] * s.node_position[static_cast<std::size_t>(nodes[k])][c];
      samples.push_back(x);
    }
    return samples;
  };
  const auto at = list.find('_');
  return {named(list.substr(0, at)), named(list.substr(at + 1))};
}

double distance(const Vec3& a, const Vec3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

double largest(const Vec3& a, const Vec3& b) {
  double x = 0;
  for (std::size_t c = 0; c < 3; ++c) x = std::max({x, std::fabs(a[c]), std::fabs(b[c])});
  return x;
}

/// Those that the stage makes in this scene (stages/neighbors.hpp, stages/porous_neighbors.hpp).
std::vector<std::string> lists_of(Stage stage, const Model& m) {
  const bool samples = m.samples.count() > 0, boundary = m.has_boundary();
  std::vector<std::string> names;
  if (stage == Stage::neighbors) {
    names.push_back("fluid_fluid");
    if (boundary) names.push_back("fluid_boundary");
    if (samples) names.insert(names.end(), {"fluid_sample", "sample_fluid", "sample_sample"});
  }
  if (stage == Stage::porous_neighbors && samples) {
    if (m.has_exchange()) names.insert(names.end(), {"fluid_sample", "sample_sample"});
    if (m.porous_meets_solids() && boundary) names.push_back("sample_boundary");
  }
  return names;
}

}  // namespace

std::vector<std::string> neighbor_list_names() {
  return {"fluid_fluid", "fluid_boundary", "fluid_sample", "sample_fluid", "sample_sample", "sample_boundary"};
}

ListDifference compare_list(const std::string& name, const Model& model, const HostState& state,
                            const Backend& expected, const Backend& actual, const Precision& precision) {
  Pairs a = expected.neighbor_pairs(name), b = actual.neighbor_pairs(name);
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  ListDifference out;
  const auto unique = std::unique(b.begin(), b.end());
  out.repeated = static_cast<std::size_t>(b.end() - unique);
  b.erase(unique, b.end());
  Pairs only_one;
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(only_one));
  // The lists may differ only in pairs whose distance rounds across h; the blocks' lattice (h = 2 d) has many.
  const Sides sides = sides_of(name, model, state);
  const double h = model.support;
  const auto lies_at_h = [&](const std::pair<Index, Index>& p) {
    const Vec3 &from = sides.from.at(static_cast<std::size_t>(p.first)),
               &to = sides.to.at(static_cast<std::size_t>(p.second));
    return std::fabs(distance(from, to) - h) <= separation_rounding(model, precision, largest(from, to));
  };
  for (const auto& p : only_one) (lies_at_h(p) ? out.at_support : out.wrong).push_back(p);
  out.pairs = a.size();
  out.clear_pairs =
      static_cast<std::size_t>(std::count_if(a.begin(), a.end(), [&](const auto& p) { return !lies_at_h(p); }));
  return out;
}

std::vector<FieldDifference> compare_lists(const Model& model, Stage stage, const HostState& state,
                                           const Backend& expected, const Backend& actual, const Precision& precision) {
  std::vector<FieldDifference> rows;
  for (const std::string& name : lists_of(stage, model)) {
    const ListDifference d = compare_list(name, model, state, expected, actual, precision);
    rows.push_back({"list." + name, "pairs", static_cast<double>(d.wrong.size() + d.repeated),
                    static_cast<double>(d.pairs), 0,
                    d.wrong.empty() ? 0 : static_cast<std::size_t>(d.wrong.front().first), d.pairs, d.pairs});
  }
  return rows;
}

}  // namespace drench
