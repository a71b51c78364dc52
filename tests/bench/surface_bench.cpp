// drench_bench_surface RUN FRAME isotropic|anisotropic THREADS REPEATS FOLDER: makes the liquid's surface of one frame
// of a run again, in the best of some times. tools/measure/surface_quality measures the files that it leaves in FOLDER,
// raw numbers: points (double, 3 each), triangles (int32, 3 each), particles (double: x y z and m/ρ). Prints the time
// in s.

#include <fmt/format.h>
#include <vtkCell.h>
#include <vtkDataArray.h>
#include <vtkPointData.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "output/liquid_surface.hpp"
#include "output/recorded_frames.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"

namespace drench {
namespace {

namespace fs = std::filesystem;

template <class T>
void write(const fs::path& path, const std::vector<T>& values) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(T)));
  if (!out) throw std::runtime_error(path.string() + ": cannot be written");
}

std::vector<Vec3> points_of(vtkUnstructuredGrid* grid) {
  std::vector<Vec3> points(static_cast<std::size_t>(grid->GetNumberOfPoints()));
  for (std::size_t i = 0; i < points.size(); ++i) grid->GetPoint(static_cast<vtkIdType>(i), points[i].data());
  return points;
}

/// The liquid and the cloth of a frame; bodies stay where they begin.
HostState state_of(const Setup& setup, const fs::path& run, std::size_t frame) {
  HostState state = setup.state;
  auto grid = read_vtu(recorded_frames(run, "fluid").at(frame).files.front());
  state.fluid_position = points_of(grid);
  state.fluid_velocity.assign(state.fluid_position.size(), Vec3{0, 0, 0});
  state.fluid_mass.clear();
  vtkDataArray* mass = grid->GetPointData()->GetArray("mass");
  for (vtkIdType i = 0; i < mass->GetNumberOfTuples(); ++i)
    state.fluid_mass.push_back(static_cast<Quanta>(mass->GetTuple1(i) / setup.model.quantum));
  if (setup.model.has_cloth())
    state.node_position = points_of(read_vtu(recorded_frames(run, "cloth").at(frame).files.front()));
  return state;
}

void write_mesh(const fs::path& folder, const Model& model, const HostState& state, const Grid& grid) {
  std::vector<double> points, particles;
  std::vector<std::int32_t> triangles;
  for (const Vec3& x : points_of(grid)) points.insert(points.end(), x.begin(), x.end());
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c)
    for (int k = 0; k < 3; ++k) triangles.push_back(static_cast<std::int32_t>(grid->GetCell(c)->GetPointId(k)));
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    particles.insert(particles.end(), state.fluid_position[i].begin(), state.fluid_position[i].end());
    particles.push_back(static_cast<double>(state.fluid_mass[i]) * model.quantum / model.rest_density);
  }
  write(folder / "points", points);
  write(folder / "triangles", triangles);
  write(folder / "particles", particles);
}

int run(const std::vector<std::string>& words) {
  const fs::path folder = words[0];
  Setup setup =
      build(load_scene((folder / "scene.yaml").string(), {"output.surface=true", "output.surface_kernel=" + words[2]}));
  const HostState state = state_of(setup, folder, std::stoul(words[1]));
  double best = 1e9;
  Grid grid;
  for (int k = 0; k < std::stoi(words[4]); ++k) {
    const auto begin = std::chrono::steady_clock::now();
    grid = surface_grid(setup.model, state, std::stoi(words[3]));
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  write_mesh(words[5], setup.model, state, grid);
  fmt::print("{:.4f}\n", best);
  return 0;
}

}  // namespace
}  // namespace drench

int main(int count, char** words) {
  if (count != 7) {
    fmt::print(stderr, "usage: drench_bench_surface RUN FRAME isotropic|anisotropic THREADS REPEATS FOLDER\n");
    return 2;
  }
  try {
    return drench::run({words + 1, words + count});
  } catch (const std::exception& e) {
    fmt::print(stderr, "drench_bench_surface: {}\n", e.what());
    return 2;
  }
}
