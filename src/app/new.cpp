#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "app/commands.hpp"
#include "app/import_formats.hpp"
#include "app/set_up.hpp"
#include "pipeline/backend.hpp"
#include "pipeline/pipeline.hpp"
#include "pipeline/runtime.hpp"
#include "setup/first_scene.hpp"

namespace drench {
namespace {

constexpr int tried_steps = 10;
// Of the cloth in a step, by Newton's method: usual are 5 to 30, and more than this take seconds and soon fail.
constexpr int easy_iterations = 100;

/// A step that fails, or that takes too many iterations on a host, counts as one that does not converge. Ends with the
/// first such step: it takes the longest.
bool first_steps_converge(const Scene& scene, FilledBodies& filled) {
  const Setup setup = build(scene, memory_budget(), &filled);
  const std::unique_ptr<Backend> backend = make_kokkos_backend_on(nullptr, setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  try {
    for (int k = 0; k < tried_steps; ++k) {
      const StepReport report = pipeline.step(std::numeric_limits<double>::infinity());
      const bool easy = !computes_on_host() || report.cloth_iterations <= easy_iterations;
      if (!report.cloth_converged || !easy) return false;
    }
  } catch (const std::runtime_error&) {
    return false;
  }
  return true;
}

/// Is the scene's file in another folder than the working one? Then relative paths would not hold in it. `output`: ""
/// for standard output, which may be a file too.
bool writes_elsewhere(const std::string& output) {
  namespace fs = std::filesystem;
  struct stat state {};
  std::error_code unknown;
  if (!output.empty())
    return fs::weakly_canonical(fs::absolute(output), unknown).parent_path() != fs::current_path(unknown);
  if (fstat(STDOUT_FILENO, &state) != 0 || !S_ISREG(state.st_mode)) return false;
  const fs::path written = fs::read_symlink("/proc/self/fd/1", unknown);
  return !unknown && written.parent_path() != fs::current_path(unknown);
}

/// Before anything is computed. `output`: "" for standard output.
void check_output(const std::string& output) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  if (output.empty()) return;
  if (fs::exists(output, unknown)) throw ExportError(fmt::format("{}: exists; choose another file with -o", output));
  if (const fs::path folder = fs::absolute(output, unknown).parent_path(); !fs::is_directory(folder, unknown))
    throw ExportError(fmt::format("{}: no such folder", folder.string()));
}

/// The file itself, or what it is imported as; nothing of "". SetupError: a format that cannot be read.
ImportedMesh mesh_of(const std::string& file, const std::optional<std::string>& prim) {
  namespace fs = std::filesystem;
  if (file.empty()) return {};
  std::string ending = fs::path(file).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  constexpr std::array read{".obj", ".ply", ".stl"};
  std::error_code unknown;
  if (file.find('*') == std::string::npos && !ending.empty() && !is_imported(file) &&
      std::find(read.begin(), read.end(), ending) == read.end() && !fs::is_directory(file, unknown))
    throw SetupError(fmt::format("mesh file '{}': unknown extension; allowed: {}, {}", file, fmt::join(read, ", "),
                                 imported_endings()));
  if (is_imported(file)) return imported_mesh(file, prim);
  if (prim)
    throw SetupError(fmt::format("mesh file '{}': it holds one mesh; --prim and --body-prim name one of {}", file,
                                 imported_endings()));
  return ImportedMesh{file};
}

}  // namespace

int new_command(const NewOptions& options) {
  check_output(options.output);
  if (options.body_prim && options.body.empty())
    throw ExportError("--body-prim: applies only with --body FILE; add it");
  if (std::error_code unknown; !options.mesh.empty() && !options.body.empty() && !options.prim && !options.body_prim &&
                               std::filesystem::equivalent(options.mesh, options.body, unknown))
    throw ExportError(fmt::format("--body {}: it is the garment's file too; name the file of the body", options.body));
  const ImportedMesh mesh = mesh_of(options.mesh, options.prim), body = mesh_of(options.body, options.body_prim);
  if (!mesh.sequence.empty())
    fmt::print(stderr,
               "warning: {}: the garment is animated in this file; it starts as in its first frame and then moves "
               "freely\n",
               options.mesh);
  std::optional<BackendRuntime> runtime;
  TrySteps trial;  // none without a device: then the steps are only estimated
  try {
    require_device();
    runtime.emplace(options.threads, true);
    trial = [trials = 0, named = !options.fabric.empty()](const Scene& scene, FilledBodies& filled) mutable {
      if (++trials > 1)
        fmt::print(stderr, "trying the first steps with a time.step of {:g} s{}\n", scene.time.step,
                   named ? "" : fmt::format(" and bend {:g} N m", scene.cloths.front().material.bend));
      return first_steps_converge(scene, filled);
    };
  } catch (const DeviceError&) {
  }
  const MeshPaths paths = writes_elsewhere(options.output) ? MeshPaths::absolute : MeshPaths::as_given;
  const FirstScene scene = first_scene({.mesh = mesh.first,
                                        .body = body.sequence.empty() ? body.first : body.sequence,
                                        .fabric = options.fabric,
                                        .paths = paths,
                                        .body_rate = body.per_second},
                                       trial);
  for (const std::string& line : scene.warnings) fmt::print(stderr, "warning: {}\n", line);
  if (options.output.empty()) {
    fmt::print("{}", scene.yaml);
    return exit_done;
  }
  std::ofstream file(options.output);
  if (!(file << scene.yaml).flush())
    throw ExportError(fmt::format("{}: {}", options.output, std::generic_category().message(errno)));
  return exit_done;
}

}  // namespace drench
