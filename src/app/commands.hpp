#pragma once
// The commands of `drench`. Each returns the exit code: 0 done, 1 the run failed or a field is over its tolerance, 130
// interrupted. A bad scene or folder is thrown (SceneError, SetupError, DeviceError, FolderError) and becomes exit code
// 2 in main.

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/exit_codes.hpp"

namespace drench {

class Communicator;

struct RunOptions {
  std::string scene;
  std::optional<std::string> output;   // a folder
  std::string resume;                  // a checkpoint, or a folder of them; "": from the scene's beginning
  std::string backend = "kokkos";      // or "reference"
  std::optional<double> until;         // s; replaces time.end
  std::optional<std::int64_t> steps;   // stop after so many steps
  std::vector<std::string> overrides;  // key.path=value
  int threads = 0;                     // 0: the runtime chooses
  bool quiet = false, profile = false, no_output = false, overwrite = false;
  bool view = false;  // only where drench-view is built
};

/// `ranks`: those that run it together, each of which calls this; null: one alone. Throws RanksError: it cannot be
/// spread.
int run_command(const RunOptions& options, const Communicator* ranks = nullptr);

struct CompareOptions {
  std::string scene;
  std::int64_t steps = 3;
  std::int64_t after = 0;  // steps that the backend runs first, alone
  double tolerance_scale = 1;
  std::int64_t seed = 1;  // of the particles' way off the lattice
  std::vector<std::string> overrides;
  int threads = 0;
};

/// Runs every stage on the backend and on the reference from identical input and prints how far their results are
/// apart. Returns 1 if a field is over its tolerance (compare/field_difference.hpp).
int compare_command(const CompareOptions& options);

struct CheckOptions {
  std::string scene;
  std::vector<std::string> overrides;
  int ranks = 1;    // above 1: also what each of so many has and takes
  int threads = 0;  // 0: as many as there are cores
};

/// Loads and sets up a scene and prints what a run of it would be; runs nothing.
int check_command(const CheckOptions& options);

/// What cannot be exported or imported as it was asked for. One line.
struct ExportError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct ExportOptions {
  std::string folder;                 // of a run
  std::string to;                     // usd, bgeo or ply
  std::optional<std::string> output;  // usd: a file; else a folder
  std::optional<double> fps;          // pictures a second; else as the frames come
  bool wet_maps = false;              // of bodies, in usd
  std::optional<int> wet_textures;    // pixels along an edge; with wet_maps
};

/// Writes a run's frames in the format of another tool. Throws ExportError: nothing there to export, or damaged. For
/// usd the process becomes Python with tools/export/write_usd.py.
int export_command(const ExportOptions& options);

struct ImportOptions {
  std::string file;                   // .usd, .usda, .usdc, .usdz; .fbx, .gltf, .glb, .abc, .blend; .xml, .json
  std::optional<std::string> prim;    // the mesh; else the only one
  std::optional<std::string> output;  // a folder; else the file's name without its ending
  std::optional<double> fps;          // files a second; else the stage's time codes
};

/// Writes a mesh of another tool's file as PLY files for a scene's `sequence`, and prints what the scene says to use
/// them; or writes a scene of libWetCloth (.xml) or SPlisHSPlasH (.json) as a scene. Throws ExportError: no such file,
/// unknown ending. The process becomes Python with a script of tools/export.
int import_command(const ImportOptions& options);

struct ReportOptions {
  std::string folder;                 // of a run
  std::optional<std::string> other;   // of a second run, beside it
  std::optional<std::string> output;  // a file; else report.html in the folder
};

/// Writes a run, or two beside each other, as a page. Throws FolderError: no run there, or no folder for the page.
int report_command(const ReportOptions& options);

struct NewOptions {
  std::string mesh;    // a garment; "": a square cloth. A file that `import` reads is imported first
  std::string body;    // that wears it; "": none
  std::string fabric;  // its name or file; "": round numbers
  std::string output;  // file for the scene; "": standard output
  std::optional<std::string> prim, body_prim;  // the meshes in files that are imported
  int threads = 0;                             // 0: the runtime chooses
};

/// Prints or writes a first scene for a garment's mesh, whose first steps it has tried. Throws SetupError, ExportError.
int new_command(const NewOptions& options);

/// A test that there is not. One line.
struct TestError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct TestOptions {
  std::string name;                         // of a standard test; "": lists them
  std::string fabric = "cotton_interlock";  // of the specimens
  std::vector<std::string> overrides;       // key.path=value, of the specimens' scenes
  std::optional<int> repeats;               // specimens, per direction; else the test's own
  std::optional<std::string> output;        // a folder, new or empty
  bool list = false, json = false, quiet = false;
  int threads = 0;  // 0: the runtime chooses
};

/// Runs a standard test on a fabric (src/laboratory), prints its result and writes it with scenes and curve to a
/// folder. Throws TestError, FolderError and what run_test() throws.
int test_command(const TestOptions& options);

/// Prints version, precision, device and libraries.
int info_command(int threads);

}  // namespace drench
