#include "setup/mesh_io.hpp"

#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCommand.h>
#include <vtkExecutive.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <span>
#include <utility>

#include "base/eigen_vec.hpp"
#include "setup/mesh_files.hpp"
#include "setup/mesh_joins.hpp"
#include "setup/point_cache.hpp"
#include "setup/setup_error.hpp"
#include "setup/surface_distance.hpp"
#include "setup/triangulation.hpp"

namespace drench {
namespace {

std::string find_file(const std::string& file, const std::string& scene_path) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (!fs::path(file).is_absolute() && !scene_path.empty()) {
    const fs::path beside = fs::path(scene_path).parent_path() / file;
    if (fs::is_regular_file(beside, ignored)) return beside.string();
  }
  if (fs::is_directory(file, ignored))
    throw SetupError("mesh file '" + file + "': it is a folder; allowed: a file .obj, .ply or .stl");
  if (!fs::is_regular_file(file, ignored)) throw SetupError("mesh file '" + file + "': no such file");
  return file;
}

/// VTK's readers print their messages and return an empty mesh: collect the text instead.
struct Messages {
  std::string warning, error;
  static void collect(vtkObject*, unsigned long event, void* self, void* text) {
    auto& messages = *static_cast<Messages*>(self);
    std::string& out = event == vtkCommand::ErrorEvent ? messages.error : messages.warning;
    if (out.empty() && text) out = static_cast<const char*>(text);
  }
};

/// Three points a facet: VTK's own merging would drop facets.
PolygonFile read_stl_file(const std::string& path, const std::string& bytes) {
  if (is_stl_text(bytes)) return read_stl_text(path, bytes);
  std::string note = check_stl_file(path, bytes);
  Messages messages;
  vtkNew<vtkCallbackCommand> observer;
  observer->SetCallback(Messages::collect);
  observer->SetClientData(&messages);
  vtkNew<vtkSTLReader> reader;
  for (vtkObject* source : std::initializer_list<vtkObject*>{reader, reader->GetExecutive()}) {
    source->AddObserver(vtkCommand::ErrorEvent, observer);
    source->AddObserver(vtkCommand::WarningEvent, observer);
  }
  reader->SetFileName(path.c_str());
  reader->MergingOff();
  reader->Update();
  if (!messages.error.empty()) unreadable_mesh(path, messages.warning.empty() ? messages.error : messages.warning);
  PolygonFile file;
  file.note = std::move(note);
  file.facets = true;
  vtkPolyData* data = reader->GetOutput();
  for (vtkIdType p = 0; p < data->GetNumberOfPoints(); ++p) {
    file.points.emplace_back();
    data->GetPoint(p, file.points.back().data());
  }
  vtkNew<vtkIdList> ids;
  for (vtkIdType c = 0; c < data->GetNumberOfPolys(); ++c) {
    data->GetPolys()->GetCellAtId(c, ids);
    for (vtkIdType k = 0; k < ids->GetNumberOfIds(); ++k) file.corner.push_back(static_cast<Index>(ids->GetId(k)));
    file.face_end.push_back(file.corner.size());
  }
  file.corner_texture.assign(file.corner.size(), -1);
  return file;
}

PolygonFile read_file(const std::string& file, const std::string& scene_path, bool names = false,
                      const std::set<std::string>& attributes = {}) {
  const std::string path = find_file(file, scene_path);
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending == ".obj" || ending == ".ply" || ending == ".stl") {
    check_mesh_content(path, ending);
    if (ending == ".obj") return read_obj_file(path, names);
    if (ending == ".ply") return read_ply_file(path, false, attributes);
    return read_stl_file(path, bytes_of_mesh(path));
  }
  throw SetupError("mesh file '" + file + "': unknown extension; allowed: .obj, .ply, .stl");
}

/// How a file's polygons are divided.
struct Division {
  std::vector<std::array<Index, 3>> triangles;      // of the file's points
  std::vector<std::array<std::size_t, 3>> corners;  // the same as numbers of PolygonFile::corner
  std::vector<std::size_t> face;                    // of each triangle
  std::size_t wanted = 0, first_face = 0;           // n − 2 summed over the faces; the first face with one left out
  std::string left_out(const PolygonFile& file, const std::string& name) const {
    if (wanted == triangles.size()) return "";
    const bool one = wanted == triangles.size() + 1;
    return fmt::format("mesh file '{}': {} of {} triangles {} and {} to face {}{}", name, wanted - triangles.size(),
                       wanted, one ? "has no area or names a point twice" : "have no area or name a point twice",
                       one ? "is omitted; it belongs" : "are omitted; the first belongs", first_face,
                       file.face_line.empty() ? "" : fmt::format(" (line {})", file.face_line[first_face]));
  }
};

/// Has it three points and, as far as they are finite, an area?
bool is_triangle(const PolygonFile& file, const std::array<Index, 3>& t) {
  constexpr double least = 1e-12;  // of the longest side's square
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return false;
  const auto point = [&](std::size_t c) { return to_eigen(file.points[static_cast<std::size_t>(t[c])]); };
  const Eigen::Vector3d ab = point(1) - point(0), ac = point(2) - point(0), bc = point(2) - point(1);
  return !(0.5 * ab.cross(ac).norm() <= least * std::max({ab.squaredNorm(), ac.squaredNorm(), bc.squaredNorm()}));
}

/// Of each face the first one with more than three corners at the same places, whichever way it is turned; else itself.
std::vector<std::size_t> first_alike(const PolygonFile& file) {
  std::vector<std::size_t> first(file.face_end.size()), order;
  std::iota(first.begin(), first.end(), std::size_t{0});
  const auto begin_of = [&](std::size_t f) { return f > 0 ? file.face_end[f - 1] : 0; };
  for (const std::size_t f : first)
    if (file.face_end[f] - begin_of(f) > 3) order.push_back(f);
  const auto is_finite = [](const Vec3& x) { return to_eigen(x).allFinite(); };
  if (order.empty() || !std::all_of(file.points.begin(), file.points.end(), is_finite)) return first;
  const std::vector<Index> place = first_copies(file.points);
  std::vector<Index> corners;
  for (const Index i : file.corner) corners.push_back(place[static_cast<std::size_t>(i)]);
  const auto range = [&](std::size_t f) {
    return std::span(corners).subspan(begin_of(f), file.face_end[f] - begin_of(f));
  };
  std::erase_if(order, [&](std::size_t f) {  // a place that it has twice cannot be found in the other face
    std::sort(range(f).begin(), range(f).end());
    return std::adjacent_find(range(f).begin(), range(f).end()) != range(f).end();
  });
  const auto compare = [&](std::size_t l, std::size_t r) {
    return std::lexicographical_compare_three_way(range(l).begin(), range(l).end(), range(r).begin(), range(r).end());
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t l, std::size_t r) { return compare(l, r) < 0; });
  for (std::size_t k = 1; k < order.size(); ++k)
    if (compare(order[k - 1], order[k]) == 0) first[order[k]] = first[order[k - 1]];
  return first;
}

/// Triangles by the corners of a face that lies on an earlier one, which has the given ones.
std::vector<std::array<int, 3>> same_triangles(const PolygonFile& file, std::span<const std::array<Index, 3>> earlier,
                                               const std::vector<Vec3>& places) {
  std::vector<std::array<int, 3>> triangles;
  for (const auto& t : earlier) {
    std::array<int, 3> n{};
    for (std::size_t c = 0; c < 3; ++c)
      n[c] = static_cast<int>(std::find(places.begin(), places.end(), file.points[static_cast<std::size_t>(t[c])]) -
                              places.begin());
    if ((n[0] < n[1]) + (n[1] < n[2]) + (n[2] < n[0]) != 2) std::swap(n[1], n[2]);
    triangles.push_back(n);
  }
  return triangles;
}

/// `first`: of each point of the file the one that it is taken for. Faces that lie on each other are cut alike, so that
/// their triangles are the same.
Division divide(const PolygonFile& file, const std::vector<Index>& first) {
  Division division;
  const std::vector<std::size_t> alike = first_alike(file);
  std::vector<std::size_t> start;  // of each face: its first triangle
  std::size_t begin = 0;
  for (std::size_t f = 0; f < file.face_end.size(); ++f) {
    const std::size_t end = file.face_end[f], whole = end - begin < 3 ? 0 : end - begin - 2,
                      before = division.triangles.size();
    std::vector<std::size_t> corners;  // without a point that follows itself
    const auto point = [&](std::size_t c) { return first[static_cast<std::size_t>(file.corner[c])]; };
    for (std::size_t c = begin; c < end; ++c)
      if (corners.empty() || point(c) != point(corners.back())) corners.push_back(c);
    while (corners.size() > 1 && point(corners.back()) == point(corners.front())) corners.pop_back();
    std::vector<Vec3> places;
    for (const std::size_t c : corners) places.push_back(file.points[static_cast<std::size_t>(point(c))]);
    start.push_back(before);
    const std::size_t earlier = alike[f];
    const auto triangles =
        earlier == f
            ? triangulate(places)
            : same_triangles(file, {division.triangles.data() + start[earlier], start[earlier + 1] - start[earlier]},
                             places);
    for (const auto& t : triangles) {
      const auto corner = [&](std::size_t k) { return corners[static_cast<std::size_t>(t[k])]; };
      const std::array<Index, 3> points{point(corner(0)), point(corner(1)), point(corner(2))};
      if (!is_triangle(file, points)) continue;
      division.triangles.push_back(points);
      division.corners.push_back({corner(0), corner(1), corner(2)});
      division.face.push_back(f);
    }
    if (division.wanted == before) division.first_face = f;  // none is missing so far
    division.wanted += whole;
    begin = end;
  }
  return division;
}

/// Of an .stl file whose pieces touch: which point each corner has, so that no edge has more than two triangles.
std::vector<Index> separate_facets(const std::vector<Vec3>& points, std::vector<std::array<Index, 3>>& triangles) {
  std::vector<Index> place(points.size());
  std::iota(place.begin(), place.end(), Index{0});
  JoinedMesh joined = join(triangles, place, partners(points, triangles, place, Branches::pair));
  triangles = std::move(joined.triangles);
  return std::move(joined.source);
}

/// The mesh of a file, and which of the file's points its points are.
struct FileMesh {
  SurfaceMesh mesh;
  std::vector<Index> source;
  Division division;
};

FileMesh mesh_of(const PolygonFile& file, const std::string& name) {
  std::vector<Index> first(file.points.size());
  std::iota(first.begin(), first.end(), Index{0});
  if (file.facets) first = first_copies(file.points);
  FileMesh result;
  result.division = divide(file, first);
  SurfaceMesh& mesh = result.mesh;
  mesh.triangles = result.division.triangles;
  mesh.left_out = result.division.left_out(file, name);
  if (mesh.triangles.empty())
    throw SetupError(
        "mesh file '" + name + "': it holds no triangles: " +
        (!mesh.left_out.empty() ? "all its faces have no area or name a point twice" +
                                      mesh.left_out.substr(std::min(mesh.left_out.size(), mesh.left_out.rfind("; ")))
         : file.points.empty()   ? "no points or faces were found in it"
         : file.face_end.empty() ? fmt::format("{} points, but no faces; is the file complete?", file.points.size())
                                 : "its faces have fewer than three corners"));
  if (!file.note.empty()) mesh.left_out += (mesh.left_out.empty() ? "" : "; ") + file.note;
  const auto edges = file.facets ? mesh_edges(mesh.triangles) : std::vector<MeshEdge>{};
  if (std::any_of(edges.begin(), edges.end(), [](const MeshEdge& e) { return e.triangles > 2; })) {
    result.source = separate_facets(file.points, mesh.triangles);
  } else {
    std::vector<Index> number(file.points.size(), -1);
    for (const auto& t : mesh.triangles)
      for (const Index i : t) number[static_cast<std::size_t>(i)] = 0;
    for (std::size_t i = 0; i < number.size(); ++i) {
      if (number[i] < 0) continue;
      number[i] = static_cast<Index>(result.source.size());
      result.source.push_back(static_cast<Index>(i));
    }
    for (auto& t : mesh.triangles)
      for (Index& i : t) i = number[static_cast<std::size_t>(i)];
  }
  for (const Index i : result.source) mesh.points.push_back(file.points[static_cast<std::size_t>(i)]);
  return result;
}

/// The point cache that moves a mesh file.
PointCache cache_of(const SequenceScene& sequence, const PolygonFile& polygons, const std::string& name) {
  const std::string& file = sequence.files.front();
  PointCache cache(file, sequence.fps);
  if (polygons.facets)
    throw SetupError(fmt::format(
        "point cache '{}': the .stl file '{}' does not number its points; allowed: an .obj or .ply file", file, name));
  if (cache.points() != polygons.points.size())
    throw SetupError(fmt::format(
        "point cache '{}': it has {} points, but mesh file '{}' has {}; allowed: the cache and the mesh of one object",
        file, cache.points(), name, polygons.points.size()));
  return cache;
}

/// u, v of the corners of all triangles, whose corners all have them.
TextureCorners texture_of(const PolygonFile& file, const Division& division, const std::string& name) {
  TextureCorners texture;
  for (const auto& t : division.corners) {
    texture.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& [u, v] = texture.back()[k] = file.texture[static_cast<std::size_t>(file.corner_texture[t[k]])];
      if (!std::isfinite(u + v))
        throw SetupError(fmt::format("mesh file '{}': triangle {} has a texture coordinate that is not finite", name,
                                     texture.size() - 1));
    }
  }
  return texture;
}

/// Triangles by the names of their faces.
std::map<std::string, std::vector<Index>> groups_of(const PolygonFile& file, const Division& division) {
  std::map<std::string, std::vector<Index>> groups;
  for (std::size_t t = 0; t < division.face.size(); ++t) {
    if (division.face[t] >= file.names.size()) continue;
    for (const std::string& name : file.names[division.face[t]]) {
      std::vector<Index>& group = groups[name];
      if (group.empty() || group.back() != static_cast<Index>(t)) group.push_back(static_cast<Index>(t));
    }
  }
  return groups;
}

/// A file without the attribute has no group of it. Adds to `note` where values are not 0 to 1.
void add_painted_groups(const PolygonFile& file, const Division& division,
                        std::map<std::string, std::vector<Index>>& groups, std::string& note) {
  for (const auto& [name, values] : file.attributes) {
    groups[painted_group(name, 0)];  // there is such an attribute
    const auto beyond = std::count_if(values.begin(), values.end(), [](double x) { return !(x >= 0 && x <= 1); });
    if (beyond > 0)
      note += fmt::format("{}the attribute '{}' of {} points is not 0 to 1 and is taken as the nearest of these",
                          note.empty() ? "" : "; ", name, beyond);
    for (std::size_t t = 0; t < division.triangles.size(); ++t) {
      double sum = 0;
      for (const Index p : division.triangles[t]) sum += std::clamp(values[static_cast<std::size_t>(p)], 0.0, 1.0);
      const int level = std::isfinite(sum) ? static_cast<int>(std::lround(sum / 3 * paint_levels)) : 0;
      groups[painted_group(name, level)].push_back(static_cast<Index>(t));
    }
  }
}

}  // namespace

std::string painted_group(const std::string& attribute, int level) { return fmt::format("{}\n{}", attribute, level); }

std::string bytes_of_mesh(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) unreadable_mesh(path, "it cannot be opened");
  return {std::istreambuf_iterator<char>(file), {}};
}

void unreadable_mesh(const std::string& path, const std::string& text) {
  std::string why = text;
  // VTK begins with its own file, line, class and address.
  if (const auto prefix = why.find("): "); why.starts_with("ERROR: In ") || why.starts_with("Warning: In ")) {
    if (prefix != std::string::npos) why.erase(0, prefix + 3);
  }
  why = why.substr(0, why.find_last_not_of(" \n") + 1);
  std::replace(why.begin(), why.end(), '\n', ' ');
  throw SetupError(fmt::format("mesh file '{}': cannot be read: {}", path, why.empty() ? "bad contents" : why));
}

SurfaceMesh read_mesh(const std::string& file, const std::string& scene_path) {
  return mesh_of(read_file(file, scene_path), file).mesh;
}

SurfaceMesh read_mesh(const std::string& file, const std::string& scene_path, MeshExtras extras,
                      const SequenceScene& sequence) {
  PolygonFile polygons = read_file(file, scene_path, extras.groups, extras.attributes);
  if (sequence.is_cache()) polygons.points = cache_of(sequence, polygons, file).sample(0);
  FileMesh result = mesh_of(polygons, file);
  const auto without = std::count(polygons.corner_texture.begin(), polygons.corner_texture.end(), -1);
  if (extras.texture && without == 0) result.mesh.texture = texture_of(polygons, result.division, file);
  if (extras.texture && without < std::ssize(polygons.corner))
    result.mesh.untextured = static_cast<std::size_t>(without);
  if (extras.groups) result.mesh.groups = groups_of(polygons, result.division);
  add_painted_groups(polygons, result.division, result.mesh.groups, result.mesh.left_out);
  return std::move(result.mesh);
}

struct MeshSequenceReader::First {
  PolygonFile polygons;
  std::vector<Index> source, copy_of;  // of the mesh's points; of the file's: the point that it is taken for
};

MeshSequenceReader::MeshSequenceReader(const SequenceScene& sequence, const std::string& file,
                                       const std::string& scene_path)
    : path_(scene_path), files_(sequence.files), first_(std::make_unique<First>()) {
  const bool is_cache = sequence.is_cache();
  if (files_.empty()) files_.push_back(file);
  const std::string& polygons = is_cache ? file : files_.front();
  first_->polygons = read_file(polygons, scene_path);
  if (is_cache) {
    cache_ = std::make_unique<PointCache>(cache_of(sequence, first_->polygons, file));
    times_ = cache_->times();
    first_->polygons.points = cache_->sample(0);
  } else {
    for (std::size_t k = 0; k < files_.size(); ++k) times_.push_back(static_cast<double>(k) / sequence.fps);
  }
  FileMesh result = mesh_of(first_->polygons, polygons);
  mesh_ = std::move(result.mesh);
  first_->source = std::move(result.source);
  if (first_->polygons.facets) first_->copy_of = first_copies(first_->polygons.points);
}

MeshSequenceReader::~MeshSequenceReader() = default;

std::string MeshSequenceReader::label(std::size_t k) const {
  return cache_ ? cache_->label(k) : std::filesystem::path(files_[k]).filename().string();
}

SurfaceMesh MeshSequenceReader::with_points_of(const std::vector<Vec3>& points) const {
  SurfaceMesh mesh = mesh_;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    mesh.points[i] = points[static_cast<std::size_t>(first_->source[i])];
  return mesh;
}

SurfaceMesh MeshSequenceReader::read(std::size_t k) const {
  if (k == 0) return mesh_;
  if (cache_) return with_points_of(cache_->sample(k));
  const std::string& file = files_[k];
  const PolygonFile polygons = read_file(file, path_);
  const PolygonFile& first = first_->polygons;
  bool same = polygons.points.size() == first.points.size() && polygons.face_end == first.face_end &&
              polygons.corner == first.corner;
  // Facets name no points: they are the same ones where copies are still copies.
  for (std::size_t i = 0; same && i < first_->copy_of.size(); ++i)
    same = polygons.points[i] == polygons.points[static_cast<std::size_t>(first_->copy_of[i])];
  return same ? with_points_of(polygons.points) : mesh_of(polygons, file).mesh;
}

std::vector<std::uint8_t> points_inside(const SurfaceMesh& mesh, const std::vector<Vec3>& points) {
  const WindingNumber winding(mesh.points, mesh.triangles);
  Eigen::AlignedBox3d bounds;
  for (const Vec3& x : mesh.points) bounds.extend(to_eigen(x));
  std::vector<std::uint8_t> inside(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i)
    inside[i] = bounds.contains(to_eigen(points[i])) && winding.around(points[i]) >= 1;
  return inside;
}

}  // namespace drench
