#include "setup/plate.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>

#include "base/eigen_vec.hpp"

namespace drench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Singular values below this share of the largest are left alone: nodes that all but lie on a conic tell nothing of a
/// curvature.
constexpr double least_curvature = 1e-3;

/// A linear function of the nodes' positions with values in the plane: of each node a vector, 1/m.
using PlanarWeights = std::map<Index, Vector2d>;

class Plate {
 public:
  Plate(const SurfaceMesh& mesh, const std::vector<MeshEdge>& edges) : mesh_(mesh), edges_(edges) {
    edge_of_.assign(mesh.triangles.size(), {-1, -1, -1});
    for (std::size_t e = 0; e < edges.size(); ++e)
      for (int s = 0; s < edges[e].triangles; ++s) {
        const Index t = edges[e].triangle[at(s)];
        edge_of_[at(t)][corner(t, edges[e].opposite[at(s)])] = static_cast<Index>(e);
      }
    for (std::size_t e = 0; e < edges.size(); ++e) slope_.push_back(slope(static_cast<Index>(e)));
  }

  /// Of a triangle: the rows of H = Σ_e ∇ψ_e ⊗ g_e (xx, yy, xy) along its axes, of which the first is along its first
  /// edge.
  std::map<Index, Vector3d> curvature(Index t) const {
    const auto& n = mesh_.triangles[at(t)];
    const Vector3d x0 = position(n[0]), along = (position(n[1]) - x0).normalized();
    const Vector3d rest = position(n[2]) - x0, across = (rest - along * along.dot(rest)).normalized();
    const auto in_plane = [&](const Vector3d& v) { return Vector2d(along.dot(v), across.dot(v)); };
    std::map<Index, Vector3d> rows;
    for (std::size_t c = 0; c < 3; ++c) {
      const MeshEdge& e = edges_[at(edge_of_[at(t)][c])];
      const Vector2d a = in_plane(position(e.a) - x0), b = in_plane(position(e.b) - x0),
                     o = in_plane(position(n[c]) - x0);
      const Vector2d tangent = (b - a).normalized();
      Vector2d normal(-tangent.y(), tangent.x());  // towards the first triangle of the edge
      const double height = normal.dot(o - a);     // of this one's third corner
      if ((height > 0) != (e.triangle[0] == t)) normal = -normal;
      // ψ_e is 1 on the edge and −1 at the corner opposite
      const Vector2d gradient = (e.triangle[0] == t ? -2.0 : 2.0) / std::abs(height) * normal;
      for (const auto& [node, weight] : slope_[at(edge_of_[at(t)][c])]) {
        const Vector2d g = weight.x() * tangent + weight.y() * normal;
        Vector3d& row = rows.try_emplace(node, Vector3d::Zero()).first->second;
        row +=
            Vector3d(gradient.x() * g.x(), gradient.y() * g.y(), 0.5 * (gradient.x() * g.y() + gradient.y() * g.x()));
      }
    }
    return rows;
  }

 private:
  Vector3d position(Index n) const { return to_eigen(mesh_.points[at(n)]); }
  std::size_t corner(Index t, Index n) const {
    const auto& nodes = mesh_.triangles[at(t)];
    return static_cast<std::size_t>(std::find(nodes.begin(), nodes.end(), n) - nodes.begin());
  }

  /// Nodes around an edge, unfolded into its plane: x along the edge from its middle, y towards its first triangle.
  struct Unfolded {
    std::vector<Index> node;
    std::vector<Vector2d> place;

    Vector2d of(Index n) const {
      return place[static_cast<std::size_t>(std::find(node.begin(), node.end(), n) - node.begin())];
    }
    bool has(Index n) const { return std::find(node.begin(), node.end(), n) != node.end(); }
    void add(Index n, const Vector2d& x) {
      node.push_back(n);
      place.push_back(x);
    }
  };
  /// Where node n lies beyond the edge p q that is unfolded already, on the side of it where `inner` is not.
  Vector2d beyond(const Unfolded& u, Index p, Index q, Index inner, Index n) const {
    const Vector3d edge = position(q) - position(p), to = position(n) - position(p);
    const Vector2d tangent = (u.of(q) - u.of(p)).normalized();
    Vector2d normal(-tangent.y(), tangent.x());
    if (normal.dot(u.of(inner) - u.of(p)) > 0) normal = -normal;
    return u.of(p) + edge.normalized().dot(to) * tangent + edge.normalized().cross(to).norm() * normal;
  }

  Unfolded unfold(const MeshEdge& e) const {
    Unfolded u;
    const double half = 0.5 * (position(e.b) - position(e.a)).norm();
    u.add(e.a, {-half, 0});
    u.add(e.b, {half, 0});
    for (int s = 0; s < std::min(2, e.triangles); ++s) {
      const Vector3d along = (position(e.b) - position(e.a)).normalized(),
                     to = position(e.opposite[at(s)]) - position(e.a);
      u.add(e.opposite[at(s)], {along.dot(to) - half, (s == 0 ? 1 : -1) * along.cross(to).norm()});
    }
    if (e.triangles != 2) return u;
    for (int s = 0; s < 2; ++s)
      for (const Index end : {e.a, e.b}) {
        const Index t = e.triangle[at(s)], inner = end == e.a ? e.b : e.a;
        const MeshEdge& side = edges_[at(edge_of_[at(t)][corner(t, inner)])];
        if (side.triangles != 2) continue;
        const Index far = side.opposite[side.triangle[0] == t ? 1 : 0];
        if (!u.has(far)) u.add(far, beyond(u, side.a, side.b, inner, far));
      }
    return u;
  }

  using Columns = std::array<Eigen::VectorXd, 3>;

  /// Takes from a column what lies along others of unit length, twice: what rounding leaves after once may be large.
  static void remove(const Columns& from, std::size_t count, Eigen::VectorXd& column) {
    for (int round = 0; round < 2; ++round)
      for (std::size_t i = 0; i < count; ++i) column -= from[i].dot(column) * from[i];
  }

  /// The least change of the weights across an edge with which they are exact for quadratic functions too. It leaves
  /// linear functions alone: it is a sum of the quadratic functions' values at the nodes, less their linear parts.
  static void correct_quadratics(const Unfolded& u, double length, Eigen::MatrixX2d& weight) {
    Columns linear, bent;
    for (Columns* columns : {&linear, &bent}) columns->fill(Eigen::VectorXd(weight.rows()));
    for (Eigen::Index k = 0; k < weight.rows(); ++k) {
      const Vector2d x = u.place[at(static_cast<Index>(k))] / length;
      linear[0][k] = 1;
      linear[1][k] = x.x();
      linear[2][k] = x.y();
      bent[0][k] = 0.5 * x.x() * x.x();
      bent[1][k] = x.x() * x.y();
      bent[2][k] = 0.5 * x.y() * x.y();
    }
    Vector3d wrong;
    Eigen::Matrix3d gram;
    for (std::size_t i = 0; i < 3; ++i) {
      remove(linear, i, linear[i]);
      linear[i] /= linear[i].norm();
      wrong[static_cast<Eigen::Index>(i)] = -bent[i].dot(weight.col(1));
    }
    for (Eigen::VectorXd& column : bent) remove(linear, 3, column);
    for (Eigen::Index i = 0; i < 3; ++i)
      for (Eigen::Index j = 0; j < 3; ++j)
        gram(i, j) = bent[static_cast<std::size_t>(i)].dot(bent[static_cast<std::size_t>(j)]);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> modes(gram);  // squares of singular values, increasing
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double square = modes.eigenvalues()[k];
      if (!(square > least_curvature * least_curvature * modes.eigenvalues()[2])) continue;
      const Vector3d mode = modes.eigenvectors().col(k);
      const double amount = mode.dot(wrong) / square;
      for (Eigen::Index i = 0; i < 3; ++i) weight.col(1) += amount * mode[i] * bent[static_cast<std::size_t>(i)];
    }
  }

  /// g_e: the gradient at the middle of an edge along its axes. It is the same for both triangles, and exact for
  /// quadratic functions: from the mean of both triangles' gradients by the least change of weights.
  PlanarWeights slope(Index edge) const {
    const MeshEdge& e = edges_[at(edge)];
    const Unfolded u = unfold(e);
    const double length = (position(e.b) - position(e.a)).norm();
    const auto count = static_cast<Eigen::Index>(u.node.size());
    Eigen::MatrixX2d weight = Eigen::MatrixX2d::Zero(count, 2);
    weight(0, 0) = -1 / length;
    weight(1, 0) = 1 / length;
    // across: of a triangle (w_c − w at its foot)/h_c; means with 1/h, which leaves out the curvature across
    const double h0 = u.place[2].y(), h1 = e.triangles == 2 ? -u.place[3].y() : 0;
    for (int s = 0; s < std::min(2, e.triangles); ++s) {
      const Vector2d c = u.place[at(2 + s)];
      const double share = e.triangles == 2 ? (s == 0 ? h1 : h0) / (h0 + h1) : 1.0, foot = 0.5 + c.x() / length;
      weight(2 + s, 1) += share / c.y();
      weight(0, 1) -= (1 - foot) * share / c.y();
      weight(1, 1) -= foot * share / c.y();
    }
    if (e.triangles == 2 && count > 4) correct_quadratics(u, length, weight);
    PlanarWeights out;
    for (Eigen::Index k = 0; k < count; ++k) out[u.node[at(static_cast<Index>(k))]] = weight.row(k).transpose();
    return out;
  }

  const SurfaceMesh& mesh_;
  const std::vector<MeshEdge>& edges_;
  std::vector<std::array<Index, 3>> edge_of_;  // of each triangle, opposite to its corners
  std::vector<PlanarWeights> slope_;           // of each edge
};

}  // namespace

std::vector<PlatePair> plate_pairs(const SurfaceMesh& mesh, const std::vector<MeshEdge>& edges,
                                   const std::function<PlateScene(Index)>& plate,
                                   const std::vector<std::array<double, 2>>& warp) {
  const Plate curvatures(mesh, edges);
  std::map<std::array<Index, 2>, double> weights;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& n = mesh.triangles[t];
    const auto point = [&](std::size_t c) { return mesh.points[static_cast<std::size_t>(n[c])]; };
    const double area = triangle_area(point(0), point(1), point(2)), c = warp[t][0], s = warp[t][1];
    Eigen::Matrix3d turn;  // (xx, yy, xy) → along warp, along weft, between them
    turn << c * c, s * s, 2 * c * s, s * s, c * c, -2 * c * s, -c * s, c * s, c * c - s * s;
    const PlateScene own = plate(static_cast<Index>(t));
    const Vector3d rigidity(own.warp, own.weft, 2 * own.twist);
    const Eigen::Matrix3d law = area * turn.transpose() * rigidity.asDiagonal() * turn;
    const std::map<Index, Vector3d> rows = curvatures.curvature(static_cast<Index>(t));
    for (auto a = rows.begin(); a != rows.end(); ++a)
      for (auto b = std::next(a); b != rows.end(); ++b) weights[{a->first, b->first}] += a->second.dot(law * b->second);
  }
  std::vector<PlatePair> pairs;
  for (const auto& [nodes, weight] : weights)
    if (weight != 0) pairs.push_back({nodes[0], nodes[1], weight});
  return pairs;
}

}  // namespace drench
