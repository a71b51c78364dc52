#include "setup/read_particles.hpp"

#include <fmt/format.h>
#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/eigen_vec.hpp"
#include "setup/mesh_files.hpp"
#include "setup/particle_files.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

ParticleFile read_ply(const std::string& path) {
  PolygonFile file;
  try {
    file = read_ply_file(path, /*particles=*/true);
  } catch (const SetupError& e) {  // of the reader that meshes have in common with particles
    const std::string what = e.what(), mesh = "mesh file";
    throw SetupError(what.starts_with(mesh) ? "particle file" + what.substr(mesh.size()) : what);
  }
  return {std::move(file.points), std::move(file.velocity), std::move(file.mass), std::move(file.id)};
}

Vec3 row(vtkDataArray* values, vtkIdType i) {
  Vec3 x;
  for (std::size_t a = 0; a < 3; ++a) x[a] = values->GetComponent(i, static_cast<int>(a));
  return x;
}

/// VTK reads a file that is cut off as one without points, or says nothing of it.
bool ends_with_vtk(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file ? std::streamoff(file.tellg()) : 0, length = std::min<std::streamoff>(size, 200);
  std::string end(static_cast<std::size_t>(length), '\0');
  file.seekg(size - length);
  file.read(end.data(), length);
  return end.find("</VTKFile>") != std::string::npos;
}

template <class Reader>
ParticleFile read_vtk(const std::string& path) {
  if (!ends_with_vtk(path)) unreadable_particles(path, "cannot be read: it is cut off, without </VTKFile> at its end");
  vtkNew<Reader> reader;
  if (!reader->CanReadFile(path.c_str())) unreadable_particles(path, "it is not a file of this kind");
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkPointSet* set = reader->GetOutput();
  if (reader->GetErrorCode() != 0 || !set) unreadable_particles(path, "it cannot be read");
  ParticleFile file;
  const vtkIdType count = set->GetNumberOfPoints();
  vtkPointData* data = set->GetPointData();
  vtkDataArray* velocity = data->GetArray("velocity");
  if (!velocity) velocity = data->GetArray("v");
  vtkDataArray* mass = data->GetArray("mass");
  if (velocity && velocity->GetNumberOfComponents() != 3)
    unreadable_particles(path, "its velocities do not have three components");
  if (mass && mass->GetNumberOfComponents() != 1) unreadable_particles(path, "its masses are not one number each");
  vtkDataArray* id = data->GetArray("id");
  if (id && id->GetNumberOfComponents() != 1) id = nullptr;
  for (vtkIdType i = 0; i < count; ++i) {
    file.position.push_back(row(set->GetPoints()->GetData(), i));
    if (velocity) file.velocity.push_back(row(velocity, i));
    if (mass) file.mass.push_back(mass->GetComponent(i, 0));
    if (id) file.id.push_back(id_of(id->GetComponent(i, 0)));
  }
  return file;
}

}  // namespace

void unreadable_particles(const std::string& path, const std::string& why) {
  throw SetupError(fmt::format("particle file '{}': {}", path, why));
}

ParticleFile read_particle_file(const std::string& path, bool may_be_empty) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending == ".gz") ending = std::filesystem::path(path).stem().extension().string();
  ParticleFile file;
  if (ending == ".ply")
    file = read_ply(path);
  else if (ending == ".vtu")
    file = read_vtk<vtkXMLUnstructuredGridReader>(path);
  else if (ending == ".vtp")
    file = read_vtk<vtkXMLPolyDataReader>(path);
  else if (ending == ".bgeo" || ending == ".bhclassic")
    file = read_bgeo_file(path);
  else if (ending == ".npz")
    file = read_npz_file(path);
  else
    unreadable_particles(
        path, fmt::format("the ending '{}' is not supported; allowed: .ply, .vtu, .vtp, .bgeo, .npz", ending));
  if (file.position.empty() && !may_be_empty) unreadable_particles(path, "it contains no particles");
  for (std::size_t i = 0; i < file.position.size(); ++i) {
    const bool fine = to_eigen(file.position[i]).allFinite() &&
                      (file.velocity.empty() || to_eigen(file.velocity[i]).allFinite()) &&
                      (file.mass.empty() || std::isfinite(file.mass[i]));
    if (!fine) unreadable_particles(path, fmt::format("numbers of particle {} are not finite", i));
  }
  return file;
}

}  // namespace drench
