#include "setup/solid_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "base/eigen_vec.hpp"
#include "base/sets.hpp"
#include "setup/close_gaps.hpp"
#include "setup/mesh_joins.hpp"
#include "setup/triangulation.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;
using Triangles = std::vector<std::array<Index, 3>>;

constexpr double of_a_sheet = 0.75;  // area of its covers over its own, at least

/// Without triangles whose three corners are those of an earlier one, whichever way they are turned: sides of a surface
/// that a file has twice. `name` gives the number of a corner.
template <class Name>
Triangles without_copies(const Triangles& triangles, const Name& name) {
  std::set<std::array<Index, 3>> seen;
  Triangles once;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    std::array<Index, 3> corners{name(t, 0), name(t, 1), name(t, 2)};
    std::sort(corners.begin(), corners.end());
    if (seen.insert(corners).second) once.push_back(triangles[t]);
  }
  return once;
}

class Closing {
 public:
  Closing(const std::vector<Vec3>& points, const Triangles& triangles, const std::vector<Index>& place) : x_(points) {
    triangles_ = without_copies(triangles, [&](std::size_t t, std::size_t c) { return triangles[t][c]; });
    separate_pieces(place);
  }

  SolidMesh close(Sheets sheets) {
    turn_alike();
    turn_patches();
    const std::size_t own = triangles_.size();
    cover_holes();
    turn_outwards();
    measure(own);
    if (sheets == Sheets::leave_out) leave_sheets_out(own);
    JoinedMesh joined = join(triangles_, place_, partners(x_, triangles_, place_, Branches::pair));
    for (const Index i : joined.source) solid_.source.push_back(source_[at(i)]);
    solid_.triangles = std::move(joined.triangles);
    return std::move(solid_);
  }

 private:
  Vector3d point(Index i) const { return to_eigen(x_[at(i)]); }
  Vector3d across(std::size_t t) const {
    const auto& n = triangles_[t];
    return (point(n[1]) - point(n[0])).cross(point(n[2]) - point(n[0]));
  }
  int direction(std::size_t h) const {
    const HalfEdges sides{triangles_};
    return sides.from(h) < sides.to(h) ? 1 : -1;
  }

  /// Pieces are connected by partners, and by edges where more triangles meet that have none. Each gets points of its
  /// own, one a place, in the old order.
  void separate_pieces(const std::vector<Index>& place) {
    partner_ = partners(x_, triangles_, place, Branches::leave);
    const auto is_loose = [&](std::size_t t) {
      return partner_[3 * t] < 0 && partner_[3 * t + 1] < 0 && partner_[3 * t + 2] < 0;
    };
    const auto by_place = [&](std::size_t t, std::size_t c) {
      return is_loose(t) ? place[at(triangles_[t][c])] : triangles_[t][c];
    };
    if (Triangles once = without_copies(triangles_, by_place); once.size() < triangles_.size()) {
      triangles_ = std::move(once);
      partner_ = partners(x_, triangles_, place, Branches::leave);
    }
    Sets sets(triangles_.size());
    for (std::size_t h = 0; h < partner_.size(); ++h)
      if (partner_[h] >= 0) sets.unite(static_cast<Index>(h / 3), partner_[h] / 3);
    const HalfEdges sides{triangles_};
    for (const std::vector<Index>& edge : edges_by_place(sides, place)) {
      Index first = -1;
      for (const Index h : edge) {
        if (partner_[at(h)] >= 0) continue;
        if (first >= 0) sets.unite(first / 3, h / 3);
        first = first < 0 ? h : first;
      }
    }
    std::map<std::array<Index, 2>, Index> source;  // of a piece's place: its first point
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      piece_.push_back(sets.root(static_cast<Index>(t)));
      for (const Index i : triangles_[t]) {
        const auto found = source.try_emplace({piece_[t], place[at(i)]}, i).first;
        found->second = std::min(found->second, i);
      }
    }
    std::vector<std::array<Index, 3>> order;  // source, piece, place
    for (const auto& [key, first] : source) order.push_back({first, key[0], key[1]});
    std::sort(order.begin(), order.end());
    std::map<std::array<Index, 2>, Index> number;
    std::vector<Vec3> points;
    for (const auto& [first, piece, where] : order) {
      number[{piece, where}] = static_cast<Index>(points.size());
      points.push_back(x_[at(first)]);
      source_.push_back(first);
    }
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (Index& i : triangles_[t]) i = number.at({piece_[t], place[at(i)]});
    x_ = std::move(points);
    place_.resize(x_.size());
    std::iota(place_.begin(), place_.end(), Index{0});
  }

  void turn(std::size_t t) { std::swap(triangles_[t][1], triangles_[t][2]); }
  /// The half-edges 0→1, 1→2, 2→0 become 0→2, 2→1, 1→0: the first and the last change places.
  void turn_with_partners(std::size_t t) {
    turn(t);
    std::swap(partner_[3 * t], partner_[3 * t + 2]);
    for (std::size_t h = 3 * t; h < 3 * t + 3; ++h)
      if (partner_[h] >= 0) partner_[at(partner_[h])] = static_cast<Index>(h);
  }
  /// Neighbours across partners, from the first triangle of each patch on. A surface with one side only keeps some that
  /// disagree.
  void turn_alike() {
    patch_.assign(triangles_.size(), -1);
    for (std::size_t first = 0; first < triangles_.size(); ++first) {
      if (patch_[first] >= 0) continue;
      std::vector<std::size_t> open{first};
      patch_[first] = static_cast<Index>(patches_.size());
      patches_.emplace_back();
      while (!open.empty()) {
        const std::size_t t = open.back();
        open.pop_back();
        patches_.back().push_back(t);
        for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
          if (partner_[h] < 0 || patch_[at(partner_[h]) / 3] >= 0) continue;
          const std::size_t other = at(partner_[h]) / 3;
          patch_[other] = patch_[first];
          if (direction(h) == direction(at(partner_[h]))) turn_with_partners(other);
          open.push_back(other);
        }
      }
    }
  }

  /// Turns whole patches so that where several meet in an edge, half-edges go to and fro as far as can be: the largest
  /// first.
  void turn_patches() {
    std::vector<double> area(patches_.size(), 0.0);
    std::vector<std::vector<std::array<std::size_t, 2>>> sides_of(patches_.size());  // edge, half-edge
    std::vector<int> surplus;                                                        // of an edge
    const HalfEdges sides{triangles_};
    for (const std::vector<Index>& edge : edges_by_place(sides, place_)) {
      if (edge.size() <= 2) continue;
      if (solid_.branches++ == 0)
        solid_.branch = to_vec3(0.5 * (point(sides.from(at(edge[0]))) + point(sides.to(at(edge[0])))));
      for (const Index h : edge) sides_of[at(patch_[at(h) / 3])].push_back({surplus.size(), at(h)});
      surplus.push_back(0);
    }
    if (surplus.empty()) return;
    for (std::size_t t = 0; t < triangles_.size(); ++t) area[at(patch_[t])] += across(t).norm();
    std::vector<std::size_t> order(patches_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t l, std::size_t r) { return area[l] > area[r]; });
    for (const std::size_t p : order) {
      int agreement = 0;
      for (const auto& [e, h] : sides_of[p]) agreement -= direction(h) * surplus[e];
      const int sign = agreement < 0 ? -1 : 1;
      for (const auto& [e, h] : sides_of[p]) surplus[e] += sign * direction(h);
      if (sign < 0)
        for (const std::size_t t : patches_[p]) turn(t);
    }
  }

  /// Where half-edges do not cancel, others go back: they bound the covers.
  void cover_holes() {
    const HalfEdges sides{triangles_};
    std::vector<Index> piece_of(x_.size(), -1);
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (const Index i : triangles_[t]) piece_of[at(i)] = piece_[t];
    std::vector<std::array<Index, 2>> open;  // from, to
    for (const std::vector<Index>& edge : edges_by_place(sides, place_)) {
      int surplus = 0;
      for (const Index h : edge) surplus += direction(at(h));
      const Index a = sides.from(at(edge[0])), b = sides.to(at(edge[0])), low = std::min(a, b), high = std::max(a, b);
      if (surplus != 0 && edge.size() > 2) closed_.insert({low, high});
      for (int k = 0; k < std::abs(surplus); ++k)
        open.push_back(surplus > 0 ? std::array{high, low} : std::array{low, high});
    }
    std::sort(open.begin(), open.end());
    std::vector<std::uint8_t> at_hole(x_.size(), 0);
    for (const auto& e : open) at_hole[at(e[0])] = at_hole[at(e[1])] = 1;
    if (!open.empty())
      for (const auto& t : triangles_)
        if (at_hole[at(t[0])] + at_hole[at(t[1])] + at_hole[at(t[2])] > 1) add_edges(t);
    for_loops(open, [&](const std::vector<Index>& loop) { cover(piece_of[at(loop[0])], loop); });
    edges_.clear();
    std::stable_sort(solid_.holes.begin(), solid_.holes.end(),
                     [](const MeshHole& l, const MeshHole& r) { return l.width > r.width; });
  }
  /// Follows the half-edges, of which as many end in each point as begin there. A way that comes back to one of its
  /// points has closed a loop.
  template <class Visit>
  void for_loops(const std::vector<std::array<Index, 2>>& open, const Visit& visit) const {
    std::vector<std::size_t> next(x_.size(), open.size());  // of each point: its first half-edge that is left
    for (std::size_t k = open.size(); k-- > 0;) next[at(open[k][0])] = k;
    std::vector<Index> met(x_.size(), -1);  // where on the way
    for (const auto& [start, unused] : open) {
      std::vector<Index> way{start};
      met[at(start)] = 0;
      for (std::size_t k = next[at(start)]; k < open.size() && open[k][0] == way.back(); k = next[at(way.back())]) {
        ++next[at(way.back())];
        const Index to = open[k][1];
        if (met[at(to)] < 0) {
          met[at(to)] = static_cast<Index>(way.size());
          way.push_back(to);
          continue;
        }
        const auto begin = way.begin() + met[at(to)];
        visit(std::vector<Index>(begin, way.end()));
        for (auto p = begin + 1; p != way.end(); ++p) met[at(*p)] = -1;
        way.erase(begin + 1, way.end());
      }
      for (const Index p : way) met[at(p)] = -1;
    }
  }
  void cover(Index piece, const std::vector<Index>& loop) {
    std::vector<Vec3> corners;
    Eigen::AlignedBox3d bounds;
    for (const Index p : loop) {
      corners.push_back(x_[at(p)]);
      bounds.extend(point(p));
    }
    Triangles covers;
    for (const auto& t : triangulate(corners)) covers.push_back({loop[at(t[0])], loop[at(t[1])], loop[at(t[2])]});
    avoid_edges(covers);
    double area = 0;
    for (const auto& t : covers) {
      triangles_.push_back(t);
      add_edges(t);
      piece_.push_back(piece);
      area += across(triangles_.size() - 1).norm();
    }
    const double width = bounds.sizes().maxCoeff();
    bool is_wall = true;  // the cover of a wall within the solid is its other side
    for (std::size_t k = 0; k < loop.size(); ++k)
      is_wall = is_wall && closed_.count(edge(loop[k], loop[(k + 1) % loop.size()])) > 0;
    if (!is_wall && area > 1e-9 * width * width) solid_.holes.push_back({to_vec3(bounds.center()), width});
  }

  static std::array<Index, 2> edge(Index a, Index b) { return {std::min(a, b), std::max(a, b)}; }
  void add_edges(const std::array<Index, 3>& t) {
    for (std::size_t c = 0; c < 3; ++c) edges_.insert(edge(t[c], t[(c + 1) % 3]));
  }
  /// Flips diagonals of a cover that lie along edges of the mesh, on which four triangles would meet.
  void avoid_edges(Triangles& covers) const {
    for (std::size_t flips = 0; flips < covers.size() && flip_one(covers); ++flips) {
    }
  }
  bool flip_one(Triangles& covers) const {
    std::map<std::array<Index, 2>, std::size_t> first;  // of each edge within the cover: a triangle
    for (std::size_t t = 0; t < covers.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c) {
        const auto [found, is_new] = first.try_emplace(edge(covers[t][c], covers[t][(c + 1) % 3]), t);
        if (!is_new && edges_.count(found->first) > 0 && flip(covers[found->second], covers[t], found->first))
          return true;
      }
    return false;
  }
  /// Two triangles on both sides of an edge get the other diagonal, unless the mesh has that one, too.
  bool flip(std::array<Index, 3>& a, std::array<Index, 3>& b, const std::array<Index, 2>& shared) const {
    const auto apex = [&](const std::array<Index, 3>& t) {
      return *std::find_if(t.begin(), t.end(), [&](Index i) { return i != shared[0] && i != shared[1]; });
    };
    const Index p = apex(a), q = apex(b);
    if (edges_.count(edge(p, q)) > 0) return false;
    // `a` goes from u to v along the shared edge.
    const auto at_p = static_cast<std::size_t>(std::find(a.begin(), a.end(), p) - a.begin());
    const Index u = a[(at_p + 1) % 3], v = a[(at_p + 2) % 3];
    a = {p, u, q};
    b = {q, v, p};
    return true;
  }

  void turn_outwards() {
    Eigen::AlignedBox3d bounds;
    for (const auto& t : triangles_)
      for (const Index i : t) bounds.extend(point(i));
    std::vector<double> volume(triangles_.size(), 0.0);  // of each piece, by its first triangle
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      volume[at(piece_[t])] += across(t).dot(point(triangles_[t][0]) - bounds.center()) / 6;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      if (volume[at(piece_[t])] < 0) turn(t);
    for (const double of_piece : volume) solid_.volume += std::abs(of_piece);
  }
  /// `own`: how many triangles are no covers.
  void measure(std::size_t own) {
    double covers = 0;
    for (std::size_t t = 0; t < triangles_.size(); ++t) (t < own ? solid_.area : covers) += 0.5 * across(t).norm();
    solid_.cover_share = solid_.area > 0 ? covers / solid_.area : 1;
    solid_.area += covers;
  }
  void leave_sheets_out(std::size_t own) {
    std::vector<double> area(own, 0.0), covers(own, 0.0);
    for (std::size_t t = 0; t < triangles_.size(); ++t) (t < own ? area : covers)[at(piece_[t])] += across(t).norm();
    const auto is_sheet = [&](std::size_t t) { return !(covers[at(piece_[t])] < of_a_sheet * area[at(piece_[t])]); };
    Triangles kept;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (!is_sheet(t))
        kept.push_back(triangles_[t]);
      else if (t < own)
        ++solid_.left_out;
    }
    if (kept.empty())
      solid_.left_out = 0;
    else
      triangles_ = std::move(kept);
  }

  std::vector<Vec3> x_;
  std::vector<Index> source_, place_;  // of each point: the given one, itself
  Triangles triangles_;
  std::vector<Index> partner_, piece_, patch_;
  std::set<std::array<Index, 2>> closed_;  // edges where a wall within the solid meets its surface
  std::set<std::array<Index, 2>> edges_;   // while holes are covered: of triangles at them, and of the covers
  std::vector<std::vector<std::size_t>> patches_;
  SolidMesh solid_;
};

}  // namespace

bool SolidMesh::has_inside() const { return cover_share < of_a_sheet && volume > 1e-9 * std::pow(area, 1.5); }

bool bounds_solid(const std::vector<std::array<Index, 3>>& triangles) {
  std::vector<std::array<Index, 3>> sides;  // lower point, higher point, direction
  for (const auto& t : triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const Index a = t[c], b = t[(c + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
    }
  std::sort(sides.begin(), sides.end());
  Index sum = 0;
  for (std::size_t k = 0; k < sides.size(); ++k) {
    sum += sides[k][2];
    const bool last = k + 1 == sides.size() || sides[k + 1][0] != sides[k][0] || sides[k + 1][1] != sides[k][1];
    if (last && sum != 0) return false;
    if (last) sum = 0;
  }
  return !sides.empty();
}

SolidMesh close_mesh(const SurfaceMesh& mesh, Sheets sheets) {
  const ClosedGaps same = close_rounding(mesh);
  SolidMesh solid = Closing(mesh.points, same.triangles, same.place).close(sheets);
  if (solid.has_inside()) return solid;
  const ClosedGaps gaps = close_gaps(mesh);
  if (gaps.joined == 0) return solid;
  SolidMesh joined = Closing(mesh.points, gaps.triangles, gaps.place).close(sheets);
  joined.gap = gaps.widest;
  joined.joined = gaps.joined;
  return joined.has_inside() ? joined : solid;
}

}  // namespace drench
