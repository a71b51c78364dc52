#include "setup/sewing.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numeric>
#include <set>
#include <sstream>

#include "base/eigen_vec.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

using Pairs = std::vector<std::array<Index, 2>>;

/// Where each node of a chain lies along it, 0 to 1.
std::vector<double> shares(const std::vector<Index>& nodes, bool closed, const std::vector<Vec3>& points) {
  std::vector<double> share{0};
  for (std::size_t k = 1; k < nodes.size() + (closed ? 1 : 0); ++k)
    share.push_back(share.back() +
                    (to_eigen(points[at(nodes[k % nodes.size()])]) - to_eigen(points[at(nodes[k - 1])])).norm());
  const double length = share.back();
  for (double& s : share) s = length > 0 ? s / length : 0;
  share.resize(nodes.size());
  return share;
}

/// Both chains walked at once, in proportion to their lengths: every node is in one pair at least.
Pairs matched(const std::vector<Index>& a, const std::vector<Index>& b, bool closed, const std::vector<Vec3>& points) {
  const std::vector<double> s = shares(a, closed, points), t = shares(b, closed, points);
  Pairs pairs{{a[0], b[0]}};
  for (std::size_t i = 0, j = 0; i + 1 < a.size() || j + 1 < b.size();) {
    const bool more_a = i + 1 < a.size(), more_b = j + 1 < b.size();
    const auto off = [&](bool step_a, bool step_b) {
      if ((step_a && !more_a) || (step_b && !more_b)) return std::numeric_limits<double>::infinity();
      return std::abs(s[i + step_a] - t[j + step_b]);
    };
    const double both = off(true, true), first = off(true, false), second = off(false, true);
    if (both <= first && both <= second) {
      ++i;
      ++j;
    } else if (first < second) {
      ++i;
    } else {
      ++j;
    }
    pairs.push_back({a[i], b[j]});
  }
  return pairs;
}

double apart(const Pairs& pairs, const std::vector<Vec3>& points) {
  double sum = 0;
  for (const auto& [a, b] : pairs) sum += (to_eigen(points[at(a)]) - to_eigen(points[at(b)])).squaredNorm();
  return sum / static_cast<double>(pairs.size());
}

/// Without the ends of a strip of faces along an edge: they go round a corner and lie on the neighbouring edges, and
/// are no longer than the strip is wide. `area`: of the strip, m².
Chain without_ends(Chain chain, double area, const std::vector<Vec3>& points) {
  constexpr double least_cosine = 0.5;  // of a turn that is no corner
  constexpr double widths = 1.5;        // of area over length, which is less than the width
  constexpr double longest_end = 0.25;  // of the chain
  constexpr double tiny = 1e-3;         // of the chain: edges without a direction
  const double length = length_of(chain, points);
  if (chain.closed || !(length > 0)) return chain;
  const std::vector<double> share = shares(chain.nodes, false, points);
  const double end = std::min(longest_end, widths * area / (length * length));
  std::size_t first = 0, last = chain.nodes.size() - 1;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k + 1 < chain.nodes.size(); ++k) {
    const Eigen::Vector3d edge = to_eigen(points[at(chain.nodes[k + 1])]) - to_eigen(points[at(chain.nodes[k])]);
    if (edge.norm() < tiny * length) continue;
    const Eigen::Vector3d direction = edge.normalized();
    if (k > 0 && !before.isZero() && before.dot(direction) < least_cosine) {
      if (share[k] <= end) first = k;
      if (share[k] >= 1 - end) last = std::min(last, k);
    }
    before = direction;
  }
  chain.nodes = {chain.nodes.begin() + static_cast<std::ptrdiff_t>(first),
                 chain.nodes.begin() + static_cast<std::ptrdiff_t>(last) + 1};
  return chain;
}

/// The boundary of a group of faces, where it is the mesh's.
Chain boundary_of(const std::string& group, const ClothScene& cloth, const SurfaceMesh& own) {
  const auto found = own.groups.find(group);
  if (found == own.groups.end())
    throw SetupError(fmt::format("{}: sew: the mesh file has no group '{}'", cloth_label(cloth.name), group));
  const std::set<Index> members(found->second.begin(), found->second.end());
  Pairs edges;
  for (const MeshEdge& e : mesh_edges(own.triangles))
    if (e.triangles == 1 && members.count(e.triangle[0]) > 0) edges.push_back({e.a, e.b});
  const std::vector<Chain> chains = chains_of(edges);
  if (chains.size() != 1)
    throw SetupError(fmt::format("{}: sew: the boundary of group '{}' has {} parts; allowed: one, or pairs of points",
                                 cloth_label(cloth.name), group, chains.size()));
  double area = 0;
  for (const Index t : members) {
    const auto& n = own.triangles[at(t)];
    const Eigen::Vector3d corner = to_eigen(own.points[at(n[0])]);
    area += 0.5 * (to_eigen(own.points[at(n[1])]) - corner).cross(to_eigen(own.points[at(n[2])]) - corner).norm();
  }
  return without_ends(chains.front(), area, own.points);
}

Pairs read_pairs(const std::string& path, const std::string& label) {
  std::ifstream file(path);
  if (!file) throw SetupError(fmt::format("{}: sew: '{}' cannot be opened", label, path));
  Pairs pairs;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    line.erase(std::find(line.begin(), line.end(), '#'), line.end());
    std::replace(line.begin(), line.end(), ',', ' ');
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    std::istringstream words(line);
    std::int64_t a = -1, b = -1;
    std::string rest;
    if (!(words >> a >> b) || words >> rest || a < 0 || b < 0 || std::max(a, b) > std::numeric_limits<Index>::max())
      throw SetupError(
          fmt::format("{}: sew: '{}', line {}: allowed: two numbers of points, from 0", label, path, number));
    pairs.push_back({static_cast<Index>(a), static_cast<Index>(b)});
  }
  if (pairs.empty()) throw SetupError(fmt::format("{}: sew: '{}' has no pairs", label, path));
  return pairs;
}

/// From the file's points to nodes.
Pairs nodes_of(Pairs pairs, const Weld& weld, const std::string& label) {
  for (auto& pair : pairs)
    for (Index& n : pair) {
      if (n < 0 || at(n) >= weld.file_points())
        throw SetupError(
            fmt::format("{}: sew: there is no point {}; allowed: 0 to {}", label, n, weld.file_points() - 1));
      n = weld.node[at(n)];
    }
  return pairs;
}

Pairs pairs_of_loops(const SewScene& sew, const SurfaceMesh& own, const std::string& label) {
  const std::vector<Chain> loops = boundary_loops(own.triangles);
  Pairs pairs;
  for (const auto& [a, b] : sew.loops) {
    for (const Index k : {a, b})
      if (at(k) >= loops.size())
        throw SetupError(fmt::format("{}: sew: there is no boundary loop {}; it has {}, which drench check lists",
                                     label, k, loops.size()));
    if (a == b) throw SetupError(fmt::format("{}: sew: loop {} cannot be sewn to itself", label, a));
    const Pairs more = along_each_other(loops[at(a)], loops[at(b)], own.points);
    pairs.insert(pairs.end(), more.begin(), more.end());
  }
  return pairs;
}

/// N/m: of the fabric at each node, as springs have it.
std::vector<double> stiffness_of_nodes(const SurfaceMesh& own, const Patchwork& fabric) {
  std::vector<double> stiffness(own.points.size(), 0);
  for (std::size_t t = 0; t < own.triangles.size(); ++t) {
    const MaterialScene& here = fabric(static_cast<Index>(t));
    const double of_fabric = here.membrane ? std::max(here.membrane->warp, here.membrane->weft) : here.stretch;
    for (const Index n : own.triangles[t]) stiffness[at(n)] = std::max(stiffness[at(n)], of_fabric);
  }
  return stiffness;
}

}  // namespace

Pairs along_each_other(const Chain& a, const Chain& b, const std::vector<Vec3>& points) {
  const bool closed = a.closed && b.closed;
  Pairs best;
  double least = std::numeric_limits<double>::infinity();
  const std::size_t turns = b.closed ? b.nodes.size() : 1;
  for (std::size_t turn = 0; turn < turns; ++turn)
    for (const bool backward : {false, true}) {
      std::vector<Index> nodes = b.nodes;
      std::rotate(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(turn), nodes.end());
      if (backward) std::reverse(nodes.begin() + (closed ? 1 : 0), nodes.end());
      Pairs pairs = matched(a.nodes, nodes, closed, points);
      if (const double far = apart(pairs, points); far < least) {
        least = far;
        best = std::move(pairs);
      }
    }
  return best;
}

Pairs sewn_pairs(const ClothScene& cloth, const SurfaceMesh& own, const Weld& weld, const std::string& key,
                 std::size_t& unneeded) {
  const std::string label = cloth_label(cloth.name);
  Pairs all;
  for (std::size_t k = 0; k < cloth.sew.size(); ++k) {
    const SewScene& sew = cloth.sew[k];
    const Pairs pairs = blaming(fmt::format("{}.sew.{}", key, k), [&]() -> Pairs {
      switch (sew.kind) {
        case SewScene::Kind::loops:
          return pairs_of_loops(sew, own, label);
        case SewScene::Kind::groups: {
          const Chain first = boundary_of(sew.groups[0], cloth, own);
          return along_each_other(first, boundary_of(sew.groups[1], cloth, own), own.points);
        }
        case SewScene::Kind::pairs:
          return nodes_of(sew.pairs, weld, label);
        case SewScene::Kind::file:
          return nodes_of(read_pairs(sew.file, label), weld, label);
      }
      return {};
    });
    all.insert(all.end(), pairs.begin(), pairs.end());
  }
  std::set<std::array<Index, 2>> edges;
  if (!all.empty())
    for (const MeshEdge& e : mesh_edges(own.triangles)) edges.insert({e.a, e.b});
  Pairs kept;
  for (const auto& [a, b] : all)
    if (a != b && edges.count({std::min(a, b), std::max(a, b)}) == 0)
      kept.push_back({std::min(a, b), std::max(a, b)});
    else
      ++unneeded;
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  return kept;
}

void append_stitches(ClothMesh& mesh, const ClothScene& cloth, const SurfaceMesh& own, const Patchwork& fabric,
                     const Pairs& sewn, const Weld& weld, Index first_node) {
  if (sewn.empty() && weld.held.empty()) return;
  const std::vector<double> stiffness = stiffness_of_nodes(own, fabric);
  const auto add = [&](const std::array<Index, 2>& pair, double length, double time) {
    mesh.stitch.push_back({first_node + pair[0], first_node + pair[1]});
    mesh.stitch_length.push_back(length);
    mesh.stitch_stiffness.push_back(std::max(stiffness[at(pair[0])], stiffness[at(pair[1])]));
    mesh.stitch_time.push_back(time);
  };
  for (const auto& pair : sewn)
    add(pair, (to_eigen(own.points[at(pair[0])]) - to_eigen(own.points[at(pair[1])])).norm(), cloth.sew_time);
  for (const auto& pair : weld.held)
    if (!std::binary_search(sewn.begin(), sewn.end(), pair)) add(pair, 0, 0);
}

void join_nodes(ClothMesh& mesh) {
  if (mesh.stitch.empty()) return;
  mesh.joint.resize(mesh.rest_position.size());
  std::iota(mesh.joint.begin(), mesh.joint.end(), 0);
  const auto root = [&](Index n) {
    while (mesh.joint[at(n)] != n) n = mesh.joint[at(n)];
    return n;
  };
  for (const auto& [a, b] : mesh.stitch) {
    const Index one = root(a), other = root(b);
    mesh.joint[at(std::max(one, other))] = std::min(one, other);
  }
  for (std::size_t n = 0; n < mesh.joint.size(); ++n) mesh.joint[n] = root(static_cast<Index>(n));
}

}  // namespace drench
