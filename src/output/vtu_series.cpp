#include "output/vtu_series.hpp"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkErrorCode.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <algorithm>
#include <fstream>
#include <regex>
#include <stdexcept>
#include <utility>

#include "output/liquid_surface.hpp"
#include "output/text_file.hpp"

namespace drench {

namespace fs = std::filesystem;

namespace {

/// A grid without points as other readers take it: meshio requires a cell and splashsurf cells of a known type, so it
/// has one poly-vertex of no points. Fields of cells have a value of 0 for it.
Grid with_empty_cell(const Grid& grid) {
  auto other = Grid::New();
  other->ShallowCopy(grid);
  vtkNew<vtkCellArray> cells;
  cells->InsertNextCell(vtkIdType{0}, static_cast<const vtkIdType*>(nullptr));
  other->SetCells(VTK_POLY_VERTEX, cells);
  vtkCellData* fields = other->GetCellData();
  for (int a = 0; a < grid->GetCellData()->GetNumberOfArrays(); ++a) {
    vtkDataArray* before = grid->GetCellData()->GetArray(a);
    vtkSmartPointer<vtkDataArray> array = vtkSmartPointer<vtkDataArray>::Take(before->NewInstance());
    array->SetName(before->GetName());
    array->SetNumberOfComponents(before->GetNumberOfComponents());
    array->SetNumberOfTuples(1);
    array->Fill(0);
    fields->AddArray(array);  // in place of the one of that name
  }
  return other;
}

}  // namespace

void write_vtu(const fs::path& path, const Grid& grid) {
  const bool empty = grid->GetNumberOfPoints() == 0;
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->WriteToOutputStringOn();  // VTK 9.1 frees what it never had when the disk refuses a part of its file
  writer->SetInputData(empty ? with_empty_cell(grid) : grid);
  // Inline, not appended: VTK before 9.4 with expat's fix of 2024 (reparse deferral) cannot read appended data, not
  // even its own; Debian 12's ParaView is such a one.
  writer->SetDataModeToBinary();
  if (empty) {  // meshio and splashsurf cannot read compressed arrays of no values
    writer->SetCompressorTypeToNone();
  } else {
    writer->SetCompressorTypeToZLib();
    writer->SetCompressionLevel(1);  // nearly as small as the highest level, several times faster
  }
  if (writer->Write() != 1 || writer->GetErrorCode() != vtkErrorCode::NoError)
    throw std::runtime_error(fmt::format("{}: cannot be written: {}", path.string(),
                                         vtkErrorCode::GetStringFromErrorCode(writer->GetErrorCode())));
  write_atomically(path, writer->GetOutputString());
}

VtuSeries::VtuSeries(fs::path folder, std::string name) : folder_(std::move(folder)), name_(std::move(name)) {}

void VtuSeries::set_static_part(const Grid& grid) {
  static_file_ = fmt::format("frames/{}_static.vtu", name_);
  fs::create_directories(folder_ / "frames");
  write_vtu(folder_ / static_file_, grid);
  unsynced_.push_back(static_file_);
}

void VtuSeries::resume(int frames) {
  frame_ = frames;
  std::ifstream in(folder_ / (name_ + ".pvd"));
  const std::regex frame(fmt::format(R"(.*"frames/{}_(\d+)\.vtu".*)", name_));
  std::smatch match;
  std::string static_line;  // stands before the frame of its time
  for (std::string line; std::getline(in, line);) {
    if (line.find("<DataSet ") == std::string::npos) continue;
    if (!std::regex_match(line, match, frame)) {
      static_line = line + '\n';
    } else if (std::stoll(match[1].str()) < frames) {
      entries_ += static_line + line + '\n';
      static_line.clear();
    } else {
      static_line.clear();
    }
  }
  entries_ += static_line;  // of a series without frames
  if (in.is_open()) write_collection();
  const std::regex ours(fmt::format(R"({}_(\d{{6,9}})\.vtu)", name_));
  std::vector<fs::path> later;
  if (fs::is_directory(folder_ / "frames"))
    for (const auto& entry : fs::directory_iterator(folder_ / "frames")) {
      const std::string name = entry.path().filename().string();
      if (std::regex_match(name, match, ours) && std::stoll(match[1].str()) >= frames) later.push_back(entry.path());
    }
  for (const fs::path& path : later) fs::remove(path);
}

void VtuSeries::write(double time, const Grid& grid) {
  const std::string file = fmt::format("frames/{}_{:06}.vtu", name_, frame_++);
  fs::create_directories(folder_ / "frames");
  write_vtu(folder_ / file, grid);
  unsynced_.push_back(file);
  int part = 0;
  if (!static_file_.empty()) list(time, part++, static_file_);
  list(time, part, file);
  write_collection();
}

void VtuSeries::write_static(double time) {
  if (!entries_.empty()) return;
  list(time, 0, static_file_);
  write_collection();
}

void VtuSeries::sync() {
  if (unsynced_.empty()) return;
  for (const std::string& file : unsynced_) sync_to_disk(folder_ / file);
  unsynced_.clear();
  sync_to_disk(folder_ / "frames");
  if (const fs::path collection = folder_ / (name_ + ".pvd"); fs::exists(collection)) sync_to_disk(collection);
}

void VtuSeries::list(double time, int part, const std::string& file) {
  entries_ += fmt::format("    <DataSet timestep=\"{:.10g}\" part=\"{}\" file=\"{}\"/>\n", time, part, file);
}

void VtuSeries::write_collection() const {
  write_atomically(folder_ / (name_ + ".pvd"),
                   "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n  <Collection>\n" +
                       entries_ + "  </Collection>\n</VTKFile>\n");
}

FrameWriter::FrameWriter(const fs::path& folder, const Model& model, int frames, int threads)
    : model_(model),
      fluid_(folder, "fluid"),
      surface_(folder, "surface"),
      cloth_(folder, "cloth"),
      bodies_(folder, "bodies"),
      energy_(folder, model, frames),
      threads_(threads),
      frames_(frames) {
  if (frames > 0)
    for (VtuSeries* series : {&fluid_, &surface_, &cloth_, &bodies_}) series->resume(frames);
  const bool any_static = std::any_of(model.bodies.begin(), model.bodies.end(), [](auto& b) { return !b.moves(); });
  if (any_static) bodies_.set_static_part(bodies_grid(model, nullptr));
}

void FrameWriter::write(const HostState& state) {
  energy_.write(state);
  if (model_.has_fluid()) fluid_.write(state.time, fluid_grid(model_, state, threads_));
  if (model_.has_surface()) surface_.write(state.time, surface_grid(model_, state, threads_));
  if (model_.has_cloth()) cloth_.write(state.time, cloth_grid(model_, state));
  if (model_.has_moving_body())
    bodies_.write(state.time, bodies_grid(model_, &state));
  else if (!model_.bodies.empty())
    bodies_.write_static(state.time);  // one entry: ParaView shows it at every time
  ++frames_;
}

void FrameWriter::sync() {
  for (VtuSeries* series : {&fluid_, &surface_, &cloth_, &bodies_}) series->sync();
  energy_.sync();
}

std::vector<std::string> FrameWriter::collections() const {
  std::vector<std::string> names;
  if (model_.has_fluid()) names.push_back("fluid.pvd");
  if (model_.has_surface()) names.push_back("surface.pvd");
  if (model_.has_cloth()) names.push_back("cloth.pvd");
  if (!model_.bodies.empty()) names.push_back("bodies.pvd");
  return names;
}

}  // namespace drench
