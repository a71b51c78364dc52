#include "setup/mesh_sequence.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "base/eigen_vec.hpp"
#include "setup/deforming_body.hpp"
#include "setup/mesh_io.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

using PointColumns = Eigen::Matrix3Xd;

PointColumns columns(const std::vector<Vec3>& points) {
  PointColumns columns(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) columns.col(static_cast<Eigen::Index>(i)) = to_eigen(points[i]);
  return columns;
}

double size_of(const PointColumns& points) {
  return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
}

/// The rotation about the origin with which points, seen from their means, come nearest to others in least squares
/// (Horn 1987, Closed-form solution of absolute orientation using unit quaternions, section 4).
Eigen::Quaterniond nearest_rotation(const PointColumns& from, const PointColumns& to) {
  const Eigen::Vector3d middle_from = from.rowwise().mean(), middle_to = to.rowwise().mean();
  Eigen::Matrix3d s = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < from.cols(); ++i)
    s += Eigen::Vector3d(from.col(i) - middle_from) * Eigen::Vector3d(to.col(i) - middle_to).transpose();
  const Eigen::Vector3d skew(s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0));
  Eigen::Matrix4d form = Eigen::Matrix4d::Zero();
  form(0, 0) = s.trace();
  form.block<3, 1>(1, 0) = skew;
  form.block<1, 3>(0, 1) = skew.transpose();
  form.bottomRightCorner<3, 3>() = s + s.transpose() - s.trace() * Eigen::Matrix3d::Identity();
  // The eigenvector of the largest eigenvalue, by squaring, which leaves it alone in the end. Eigen's solver for 4 × 4
  // takes 12 s to compile.
  form += form.norm() * Eigen::Matrix4d::Identity();
  for (int round = 0; round < 50; ++round) {
    form /= form.trace();
    form = (form * form).eval();
  }
  Eigen::Index largest = 0;
  form.diagonal().maxCoeff(&largest);
  const Eigen::Vector4d best = form.col(largest).normalized();
  return {best[0], best[1], best[2], best[3]};
}

}  // namespace

void follow_sequence(Body& body, const BodyScene& scene, const std::string& scene_path, const std::string& name,
                     const std::vector<Index>& source) {
  const PointColumns first = columns(body.mesh_points);
  const double size = size_of(first);
  const Eigen::Vector3d center = to_eigen(body.center);
  std::vector<Key<Vec3>> path;
  std::vector<Key<Quaternion>> turns;
  bool turned = false, rigid = true;
  std::vector<std::vector<Vec3>> files;
  std::vector<std::string> labels;
  Eigen::Quaterniond before = Eigen::Quaterniond::Identity();
  const MeshSequenceReader reader(scene.sequence, scene.file, scene_path);
  const std::vector<double>& times = reader.times();
  for (std::size_t k = 0; k < times.size(); ++k) {
    const std::string label = fmt::format("{} ({})", name, reader.label(k));
    const SurfaceMesh mesh = reader.read(k);
    if (mesh.triangles != reader.first().triangles || mesh.points.size() != reader.first().points.size())
      throw SetupError(label +
                       ": its triangles differ from those of the first file; allowed: files that differ only in the "
                       "positions of their points");
    std::vector<Vec3> points;
    for (const Index i : source) points.push_back(mesh.points[static_cast<std::size_t>(i)]);
    file_place(scene)(points);
    const PointColumns now = columns(points);
    if (!now.allFinite()) throw SetupError(label + ": a point of the mesh is not a finite number");
    Eigen::Quaterniond turn = nearest_rotation(first, now);
    const Eigen::Matrix3d rotation = turn.toRotationMatrix();
    const Eigen::Vector3d shift = now.rowwise().mean() - rotation * first.rowwise().mean();
    const double off = ((rotation * first).colwise() + shift - now).colwise().norm().maxCoeff();
    rigid = rigid && off <= rigid_tolerance * size;
    files.push_back(std::move(points));
    labels.push_back(label);
    if (turn.dot(before) < 0) turn.coeffs() *= -1;
    if (k > 0) body.turn_rate = std::max(body.turn_rate, before.angularDistance(turn) / (times[k] - times[k - 1]));
    turned = turned || turn.angularDistance(Eigen::Quaterniond::Identity()) > 1e-7;
    path.push_back({times[k], k == 0 ? Vec3{0, 0, 0} : to_vec3(rotation * center + shift - center)});
    if (k == 0) turn = Eigen::Quaterniond::Identity();
    turns.push_back({times[k], {turn.w(), turn.x(), turn.y(), turn.z()}});
    before = turn;
  }
  if (!rigid) {
    body.turn_rate = 0;
    return deform(body, std::move(files), times, labels);
  }
  Keyed<Vec3> way(std::move(path), Interpolation::linear);
  if (!way.is_zero()) body.path = std::move(way);  // a body has keys only if it moves
  if (turned)
    body.turns = std::move(turns);
  else
    body.turn_rate = 0;
}

std::vector<Keyed<Vec3>> node_paths(const SequenceScene& sequence, const std::string& file,
                                    const std::string& scene_path, const std::vector<Vec3>& rest, const Weld& weld,
                                    const FilePlace& place, const std::string& name) {
  const double size = size_of(columns(rest));
  const MeshSequenceReader reader(sequence, file, scene_path);
  std::vector<std::vector<Key<Vec3>>> keys(rest.size());
  std::vector<Vec3> first;
  for (std::size_t k = 0; k < reader.size(); ++k) {
    const std::string label = fmt::format("{}: pin ({})", name, reader.label(k));
    std::vector<Vec3> points = reader.read(k).points;
    if (points.size() != weld.file_points())
      throw SetupError(fmt::format("{}: it has {} points and the cloth has {}; allowed: the same number", label,
                                   points.size(), weld.file_points()));
    std::vector<Vec3> of_nodes;
    for (const Index p : weld.place_of) of_nodes.push_back(points[at(p)]);
    points = std::move(of_nodes);
    place(points);
    if (k == 0) {
      first = points;
      const double off = (columns(first) - columns(rest)).colwise().norm().maxCoeff();
      if (!(off <= 1e-4 * size))
        throw SetupError(
            fmt::format("{}: its points are up to {:.2g} m from the cloth's; allowed: a first file that is the "
                        "cloth's mesh, to 1e-4 of its size",
                        label, off));
    }
    for (std::size_t n = 0; n < rest.size(); ++n)
      keys[n].push_back({reader.times()[k], to_vec3(to_eigen(points[n]) - to_eigen(first[n]))});
  }
  std::vector<Keyed<Vec3>> paths;
  for (auto& of_node : keys) paths.emplace_back(std::move(of_node), Interpolation::linear);
  return paths;
}

}  // namespace drench
