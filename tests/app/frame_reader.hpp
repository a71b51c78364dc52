#pragma once
// Reads what the program wrote for ParaView back through VTK's own readers.

#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <filesystem>
#include <regex>
#include <stdexcept>
#include <string>
#include <vector>

#include "run_program.hpp"

namespace drench::test {

struct CollectionEntry {
  double time = 0;
  int part = 0;
  std::string file;  // as it stands in the .pvd
};

inline std::vector<CollectionEntry> read_collection(const fs::path& pvd) {
  const std::string text = read_text(pvd);
  static const std::regex entry("<DataSet timestep=\"([^\"]*)\" part=\"([^\"]*)\" file=\"([^\"]*)\"/>");
  std::vector<CollectionEntry> entries;
  for (std::sregex_iterator it(text.begin(), text.end(), entry), end; it != end; ++it)
    entries.push_back({std::stod((*it)[1]), std::stoi((*it)[2]), (*it)[3]});
  if (text.find("</VTKFile>") == std::string::npos) throw std::runtime_error(pvd.string() + " is not complete");
  return entries;
}

inline vtkSmartPointer<vtkUnstructuredGrid> read_frame(const fs::path& vtu) {
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  if (!reader->CanReadFile(vtu.c_str())) throw std::runtime_error(vtu.string() + " cannot be read");
  reader->SetFileName(vtu.c_str());
  reader->Update();
  if (reader->GetErrorCode() != 0) throw std::runtime_error(vtu.string() + " is damaged");
  return reader->GetOutput();
}

/// Value of a point field; throws when it is not there.
inline double field(vtkUnstructuredGrid* grid, const char* name, vtkIdType point, int component = 0) {
  vtkDataArray* array = grid->GetPointData()->GetArray(name);
  if (array == nullptr) throw std::runtime_error(std::string("no field ") + name);
  if (point >= array->GetNumberOfTuples() || component >= array->GetNumberOfComponents())
    throw std::runtime_error(std::string("too few values in ") + name);
  return array->GetComponent(point, component);
}

inline std::vector<std::string> point_fields(vtkUnstructuredGrid* grid) {
  const int arrays = grid->GetPointData()->GetNumberOfArrays();
  std::vector<std::string> names;
  names.reserve(static_cast<std::size_t>(arrays));
  for (int i = 0; i < arrays; ++i) names.emplace_back(grid->GetPointData()->GetArrayName(i));
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace drench::test
