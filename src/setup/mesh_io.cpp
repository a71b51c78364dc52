#include "setup/mesh_io.hpp"

#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkExecutive.h>
#include <vtkIdList.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkSelectEnclosedPoints.h>
#include <vtkTriangleFilter.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <utility>

#include "base/eigen_vec.hpp"
#include "setup/mesh_files.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

std::string find_file(const std::string& file, const std::string& scene_path) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (!fs::path(file).is_absolute() && !scene_path.empty()) {
    const fs::path beside = fs::path(scene_path).parent_path() / file;
    if (fs::is_regular_file(beside, ignored)) return beside.string();
  }
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

vtkSmartPointer<vtkPolyData> polygons_of_stl(const std::string& path) {
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
  reader->Update();
  if (!messages.error.empty()) unreadable_mesh(path, messages.warning.empty() ? messages.error : messages.warning);
  return reader->GetOutput();
}

/// Points in the order of the file, and copies of those that have several texture coordinates behind them. Without
/// coordinates where a corner has none.
vtkSmartPointer<vtkPolyData> polygons_of(const PolygonFile& file) {
  const bool textured = !file.corner_texture.empty() &&
                        std::find(file.corner_texture.begin(), file.corner_texture.end(), -1) == file.corner_texture.end();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& x : file.points) points->InsertNextPoint(x.data());
  vtkNew<vtkDoubleArray> coordinates;
  coordinates->SetNumberOfComponents(2);
  std::vector<Index> texture(file.points.size(), -1);  // of each point so far
  std::map<std::pair<Index, Index>, vtkIdType> copies;
  const auto point_of = [&](std::size_t c) {
    const Index point = file.corner[c], wanted = textured ? file.corner_texture[c] : -1;
    Index& first = texture[static_cast<std::size_t>(point)];
    if (first < 0) first = wanted;
    if (first == wanted) return vtkIdType{point};
    const auto [copy, fresh] = copies.try_emplace({point, wanted}, points->GetNumberOfPoints());
    if (fresh) {
      points->InsertNextPoint(file.points[static_cast<std::size_t>(point)].data());
      texture.push_back(wanted);
    }
    return copy->second;
  };
  vtkNew<vtkCellArray> faces;
  std::size_t corner = 0;
  for (const std::size_t end : file.face_end) {
    faces->InsertNextCell(static_cast<int>(end - corner));
    for (; corner < end; ++corner) faces->InsertCellPoint(point_of(corner));
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(faces);
  if (!textured) return data;
  constexpr std::array<double, 2> unused{};
  for (const Index uv : texture)
    coordinates->InsertNextTuple(uv < 0 ? unused.data() : file.texture[static_cast<std::size_t>(uv)].data());
  data->GetPointData()->SetTCoords(coordinates);
  return data;
}

vtkSmartPointer<vtkPolyData> triangles_of(vtkPolyData* polygons) {
  vtkNew<vtkTriangleFilter> triangles;
  triangles->PassLinesOff();
  triangles->PassVertsOff();
  triangles->SetInputData(polygons);
  triangles->Update();
  return triangles->GetOutput();
}

/// Merges exact copies if asked to, keeps the used points in their order. `kept`, if given, gets their numbers in `data`.
SurfaceMesh compact(vtkPolyData* data, bool merge, std::vector<vtkIdType>* kept = nullptr) {
  SurfaceMesh mesh;
  const vtkIdType points = data->GetNumberOfPoints();
  std::vector<vtkIdType> first(static_cast<std::size_t>(points));  // the first copy of each point
  std::map<Vec3, vtkIdType> seen;
  const auto point = [&](vtkIdType p) {
    Vec3 x;
    data->GetPoint(p, x.data());
    return x;
  };
  for (vtkIdType p = 0; p < points; ++p) {
    const Vec3 x = point(p);
    const bool finite = std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]);  // others have no order
    first[static_cast<std::size_t>(p)] = merge && finite ? seen.try_emplace(x, p).first->second : p;
  }
  std::vector<std::array<vtkIdType, 3>> corners;
  std::vector<std::uint8_t> used(first.size(), 0);
  vtkNew<vtkIdList> ids;
  vtkCellArray* polys = data->GetPolys();
  for (vtkIdType c = 0; c < polys->GetNumberOfCells(); ++c) {
    polys->GetCellAtId(c, ids);
    std::array<vtkIdType, 3> t{};
    for (int k = 0; k < 3; ++k) t[k] = first[static_cast<std::size_t>(ids->GetId(k))];
    for (const vtkIdType p : t) used[static_cast<std::size_t>(p)] = 1;
    corners.push_back(t);
  }
  std::vector<Index> number(first.size(), -1);
  for (vtkIdType p = 0; p < points; ++p) {
    if (!used[static_cast<std::size_t>(p)]) continue;
    number[static_cast<std::size_t>(p)] = static_cast<Index>(mesh.points.size());
    if (kept) kept->push_back(p);
    mesh.points.push_back(point(p));
  }
  for (const auto& t : corners) {
    mesh.triangles.push_back({number[static_cast<std::size_t>(t[0])], number[static_cast<std::size_t>(t[1])],
                              number[static_cast<std::size_t>(t[2])]});
  }
  return mesh;
}

/// A file as it is, and whether exact copies of its points are one point.
struct RawMesh {
  vtkSmartPointer<vtkPolyData> polygons;
  bool merge = false;
  std::vector<std::vector<std::string>> names{};  // of faces
};

RawMesh raw_mesh(PolygonFile file) { return {polygons_of(file), file.cut, std::move(file.names)}; }

RawMesh read_raw(const std::string& file, const std::string& scene_path, bool names = false) {
  const std::string path = find_file(file, scene_path);
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending == ".obj") return raw_mesh(read_obj_file(path, names));
  if (ending == ".ply") return raw_mesh(read_ply_file(path));
  if (ending == ".stl") {
    check_stl_file(path);
    return {polygons_of_stl(path), true};
  }
  throw SetupError("mesh file '" + file + "': unknown ending, known are .obj, .ply and .stl");
}

SurfaceMesh mesh_of(const RawMesh& raw, const std::string& file, std::vector<vtkIdType>* kept = nullptr) {
  SurfaceMesh mesh = compact(triangles_of(raw.polygons), raw.merge, kept);
  if (mesh.triangles.empty()) throw SetupError("mesh file '" + file + "': it holds no triangles");
  return mesh;
}

/// u, v of the corners of all triangles; empty where the file has none.
std::vector<std::array<std::array<double, 2>, 3>> texture_of(vtkPolyData* triangles) {
  std::vector<std::array<std::array<double, 2>, 3>> texture;
  vtkDataArray* coordinates = triangles->GetPointData()->GetTCoords();
  if (!coordinates || coordinates->GetNumberOfComponents() < 2) return texture;
  vtkNew<vtkIdList> ids;
  for (vtkIdType c = 0; c < triangles->GetPolys()->GetNumberOfCells(); ++c) {
    triangles->GetPolys()->GetCellAtId(c, ids);
    texture.emplace_back();
    for (int k = 0; k < 3; ++k)
      texture.back()[k] = {coordinates->GetComponent(ids->GetId(k), 0), coordinates->GetComponent(ids->GetId(k), 1)};
  }
  return texture;
}

constexpr const char* face_array = "drench_face";

/// Cell data that triangles keep of the face that they are cut from.
void number_faces(vtkPolyData* polygons) {
  vtkNew<vtkIdTypeArray> number;
  number->SetName(face_array);
  for (vtkIdType c = 0; c < polygons->GetNumberOfPolys(); ++c) number->InsertNextValue(c);
  polygons->GetCellData()->AddArray(number);
}

/// Triangles by the names of their faces. `names`: of each face.
std::map<std::string, std::vector<Index>> groups_of(vtkPolyData* triangles,
                                                    const std::vector<std::vector<std::string>>& names) {
  std::map<std::string, std::vector<Index>> groups;
  vtkDataArray* number = triangles->GetCellData()->GetArray(face_array);
  for (vtkIdType t = 0; number && t < triangles->GetNumberOfPolys(); ++t) {
    const auto face = static_cast<std::size_t>(number->GetTuple1(t));
    if (face >= names.size()) continue;
    for (const std::string& name : names[face]) {
      std::vector<Index>& group = groups[name];
      if (group.empty() || group.back() != static_cast<Index>(t)) group.push_back(static_cast<Index>(t));
    }
  }
  return groups;
}

/// The corners of all polygons, each polygon after their number.
std::vector<vtkIdType> corners_of(vtkPolyData* data) {
  std::vector<vtkIdType> corners;
  vtkNew<vtkIdList> ids;
  for (vtkIdType c = 0; c < data->GetNumberOfPolys(); ++c) {
    data->GetPolys()->GetCellAtId(c, ids);
    corners.push_back(ids->GetNumberOfIds());
    for (vtkIdType k = 0; k < ids->GetNumberOfIds(); ++k) corners.push_back(ids->GetId(k));
  }
  return corners;
}

}  // namespace

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
  return mesh_of(read_raw(file, scene_path), file);
}

SurfaceMesh read_mesh(const std::string& file, const std::string& scene_path, MeshExtras extras) {
  const RawMesh raw = read_raw(file, scene_path, extras.groups);
  if (extras.groups) number_faces(raw.polygons);
  SurfaceMesh mesh = mesh_of(raw, file);
  if (!extras.texture && !extras.groups) return mesh;
  const auto triangles = triangles_of(raw.polygons);
  if (extras.texture) mesh.texture = texture_of(triangles);
  for (std::size_t t = 0; t < mesh.texture.size(); ++t)
    for (const auto& [u, v] : mesh.texture[t])
      if (!std::isfinite(u + v))
        throw SetupError(fmt::format("mesh file '{}': triangle {} has a texture coordinate that is not finite", file, t));
  if (extras.groups) mesh.groups = groups_of(triangles, raw.names);
  return mesh;
}

struct MeshSequenceReader::First {
  std::vector<vtkIdType> corners, kept;
  vtkIdType points = 0;
};

MeshSequenceReader::MeshSequenceReader(const std::string& file, const std::string& scene_path)
    : path_(scene_path), first_(std::make_unique<First>()) {
  const RawMesh raw = read_raw(file, scene_path);
  mesh_ = mesh_of(raw, file, &first_->kept);
  first_->corners = corners_of(raw.polygons);
  first_->points = raw.polygons->GetNumberOfPoints();
}

MeshSequenceReader::~MeshSequenceReader() = default;

SurfaceMesh MeshSequenceReader::read(const std::string& file) const {
  const RawMesh raw = read_raw(file, path_);
  if (raw.polygons->GetNumberOfPoints() != first_->points || corners_of(raw.polygons) != first_->corners)
    return mesh_of(raw, file);  // copies of points may be others
  SurfaceMesh mesh = mesh_;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) raw.polygons->GetPoint(first_->kept[i], mesh.points[i].data());
  return mesh;
}

std::vector<std::uint8_t> points_inside(const SurfaceMesh& mesh, const std::vector<Vec3>& points) {
  vtkNew<vtkPoints> nodes;
  nodes->SetDataTypeToDouble();
  Eigen::AlignedBox3d bounds;
  for (const Vec3& x : mesh.points) {
    nodes->InsertNextPoint(x.data());
    bounds.extend(to_eigen(x));
  }
  vtkNew<vtkCellArray> cells;
  for (const auto& t : mesh.triangles) cells->InsertNextCell({t[0], t[1], t[2]});
  vtkNew<vtkPolyData> surface;
  surface->SetPoints(nodes);
  surface->SetPolys(cells);
  vtkNew<vtkSelectEnclosedPoints> test;
  test->Initialize(surface);
  std::vector<std::uint8_t> inside(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!bounds.contains(to_eigen(points[i]))) continue;
    inside[i] = test->IsInsideSurface(points[i][0], points[i][1], points[i][2]) != 0;
  }
  test->Complete();
  return inside;
}

}  // namespace drench
