#include <fmt/format.h>
#include <fmt/ranges.h>
#include <vtkObject.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/commands.hpp"
#include "app/fit.hpp"
#include "app/threads.hpp"
#include "app/unexpected_word.hpp"
#include "app/view.hpp"
#include "base/version.hpp"
#include "output/checkpoint.hpp"
#include "output/run_folder.hpp"
#include "parallel/communicator.hpp"
#include "pipeline/runtime.hpp"
#include "scene/load.hpp"
#include "scene/schema.hpp"
#include "setup/setup_error.hpp"
#ifdef DRENCH_HAS_VIEW
#include "view/options.hpp"
#endif

namespace {

int fail(int code, std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  fmt::print(stderr, "{}\n", text);
  return code;
}

/// The place of a key in a scene that could be read a moment ago.
std::string where(const std::string& scene, const std::vector<std::string>& overrides, const std::string& key) {
  try {
    return drench::locate(scene, overrides, key);
  } catch (const drench::SceneError&) {
    return scene;
  }
}

/// A check for CLI11: a whole number in a range. (Its own range checks print their bounds in 600 digits.)
std::function<std::string(const std::string&)> at_least(std::int64_t least, std::int64_t most = 2147483647) {
  return [=](const std::string& text) {
    std::int64_t value = 0;
    if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) return std::string();
    return fmt::format("{} is not allowed; allowed: a whole number from {} to {}", text, least, most);
  };
}

void add_run_options(CLI::App& run, drench::RunOptions& options) {
  run.add_option("SCENE", options.scene, "the scene file")->required();
  run.add_option("-o,--output", options.output, "output folder, new or empty (default: out/<scene>)");
  run.add_option("--backend", options.backend, "kokkos, or the slow serial reference in double precision")
      ->check(CLI::IsMember({"kokkos", "reference"}));
  run.add_option("--until", options.until, "simulated time at which the run ends, s; replaces time.end")
      ->check([](const std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value > 0 && value <= 1e6;
        return good ? std::string() : fmt::format("{} is not a time; allowed: above 0 and at most 1e6, in s", text);
      });
  run.add_option("--steps", options.steps, "end after this many steps")->check(at_least(0));
  run.add_option("--set", options.overrides,
                 "KEY=VALUE: change a key of the scene, such as fluid.spacing=0.02; repeatable")
      ->allow_extra_args(false);
  run.add_option("--resume", options.resume,
                 "continue from this checkpoint, or from the newest one in this output folder");
  run.add_option("--threads", options.threads, "number of threads")->check(at_least(1, drench::most_threads));
  run.add_flag("--quiet", options.quiet, "print only errors");
  run.add_flag("--profile", options.profile, "print the time of each stage and the memory of each array at the end");
  run.add_flag("--no-output", options.no_output, "write no files");
  run.add_flag("--overwrite", options.overwrite, "replace the files of an earlier run in the output folder");
#ifdef DRENCH_HAS_VIEW
  run.add_flag("--view", options.view, "open a window that shows each frame as it is written");
#endif
  run.footer(
      "Examples:\n"
      "  drench run scene.yaml\n"
      "  drench run scene.yaml -o coarse --set fluid.spacing=0.025 --set time.end=0.02\n"
      "  drench run scene.yaml --steps 10 --no-output --profile\n"
      "  drench run scene.yaml -o exact --backend reference --until 0.01");
}

void add_compare_options(CLI::App& compare, drench::CompareOptions& options) {
  compare.add_option("SCENE", options.scene, "the scene file")->required();
  compare.add_option("--steps", options.steps, "number of steps to compare (default: 3)")->check(at_least(1));
  compare.add_option("--after", options.after, "run the solver alone for this many steps first")->check(at_least(0));
  compare
      .add_option("--tolerance-scale", options.tolerance_scale, "factor for every tolerance; 0 shows all differences")
      ->check([](const std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= 0;
        return good ? std::string() : fmt::format("{} is not a factor; allowed: 0 or more", text);
      });
  compare
      .add_option("--seed", options.seed,
                  "seed of the random particle offsets, up to a thousandth of a spacing (default: 1)")
      ->check(at_least(0));
  compare.add_option("--set", options.overrides, "KEY=VALUE: change a key of the scene; repeatable")
      ->allow_extra_args(false);
  compare.add_option("--threads", options.threads, "number of threads")->check(at_least(1, drench::most_threads));
  compare.footer(
      "Examples:\n"
      "  drench compare scene.yaml\n"
      "  drench compare scene.yaml --after 10 --steps 1 --seed 2\n"
      "The exit code is 1 if a field exceeds its tolerance.");
}

void add_check_options(CLI::App& check, drench::CheckOptions& options) {
  check.add_option("SCENE", options.scene, "the scene file")->required();
  check.add_option("--set", options.overrides, "KEY=VALUE: change a key of the scene; repeatable")
      ->allow_extra_args(false);
  check.add_option("--threads", options.threads, "number of threads (default: as many as there are cores)")
      ->check(at_least(1, drench::most_threads));
  check.add_option("--ranks", options.ranks, "print particles and memory per rank for this many MPI ranks")
      ->check(at_least(1, 65536));
  check.footer(
      "Examples:\n"
      "  drench check scene.yaml\n"
      "  drench check scene.yaml --set fluid.spacing=0.01\n"
      "  drench check scene.yaml --ranks 4");
}

void add_export_options(CLI::App& command, drench::ExportOptions& options) {
  command.add_option("OUT", options.folder, "output folder of a run")->required();
  command.add_option("--to", options.to, "usd: one file with everything; bgeo, ply: one file of particles per frame")
      ->required()
      ->check(CLI::IsMember({"usd", "bgeo", "ply"}));
  command.add_option("-o,--output", options.output,
                     "file for usd (default: OUT/<name of OUT>.usdc), otherwise folder (default: OUT/bgeo, OUT/ply)");
  command.add_option("--fps", options.fps, "pictures per second (default: rate of the frames)")
      ->check([](const std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && value >= 0.1 && value <= 10000;
        return good ? std::string() : fmt::format("{} is not a rate; allowed: 0.1 to 10000 pictures per second", text);
      });
  command.add_flag("--wet-maps", options.wet_maps,
                   "with usd: how long liquid has touched each point of the bodies, and how thick it is there");
  command
      .add_option("--wet-textures", options.wet_textures,
                  "the same as images of so many pixels along an edge, for bodies whose mesh has texture coordinates")
      ->check(CLI::Range(16, 8192));
  command.footer(
      "Examples:\n"
      "  drench export out/scene --to usd\n"
      "  drench export out/scene --to bgeo --fps 50\n"
      "  drench export out/scene --to ply -o particles");
}

void add_import_options(CLI::App& command, drench::ImportOptions& options) {
  command
      .add_option("FILE", options.file,
                  "a USD file (.usd, .usda, .usdc, .usdz), one that Blender reads (.fbx, .gltf, .glb, .abc, .blend), a "
                  "scene of libWetCloth (.xml) or SPlisHSPlasH (.json), or a material of ARCSim (.json)")
      ->required();
  command.add_option("--prim", options.prim,
                     "the mesh, or an object that contains only this mesh (default: the only mesh)");
  command.add_option("-o,--output", options.output, "output folder (default: FILE without its extension)");
  command.add_option("--fps", options.fps, "files per second (default: one per time code of the file)")
      ->check([](const std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && value >= 0.001 && value <= 1e5;
        return good ? std::string() : fmt::format("{} is not a rate; allowed: 0.001 to 1e5 files per second", text);
      });
  command.footer(
      "Examples:\n"
      "  drench import ladle.usdc\n"
      "  drench import walk.fbx --prim Body\n"
      "  drench import shot.usda --prim /World/flag --fps 48 -o flag\n"
      "  drench import splash_cloth_small.xml -o splash");
}

void add_report_options(CLI::App& command, drench::ReportOptions& options) {
  command.add_option("OUT", options.folder, "output folder of a run")->required();
  command.add_option("OTHER", options.other, "output folder of a second run, for a comparison");
  command.add_option("-o,--output", options.output, "output file (default: OUT/report.html)");
  command.footer(
      "Examples:\n"
      "  drench report out/scene\n"
      "  drench report out/scene out/scene-2 -o both.html");
}

void add_new_options(CLI::App& command, drench::NewOptions& options) {
  const auto named = [](const std::string& name) { return name.empty() ? "it has no name" : ""; };
  command
      .add_option("MESH", options.mesh,
                  "mesh of a garment: .obj, .ply, .stl, or a file that drench import reads (default: a square cloth)")
      ->check(named);
  command
      .add_option("--body", options.body,
                  "mesh of the body that wears it; a pattern such as \"body_*.obj\" for an animated one")
      ->check(named);
  command
      .add_option("--fabric", options.fabric,
                  "a named fabric, or a .yaml file with one (default: round numbers for a light fabric)")
      ->check(named);
  command.add_option("-o,--output", options.output, "new file for the scene (default: standard output)");
  command.add_option("--prim", options.prim, "mesh of the garment in an imported file (default: the only one)");
  command.add_option("--body-prim", options.body_prim, "mesh of the body in an imported file (default: the only one)");
  command.add_option("--threads", options.threads, "number of threads")->check(at_least(1, drench::most_threads));
  command.footer(
      "Examples:\n"
      "  drench new\n"
      "  drench new garment.obj | tee scene.yaml\n"
      "  drench new garment.obj --body figure.obj -o worn.yaml\n"
      "  drench new garment.obj --body figure.obj --fabric denim_11oz -o denim.yaml");
}

void add_test_options(CLI::App& command, drench::TestOptions& options) {
  command.add_option("NAME", options.name, "name of a test (default: list the tests)");
  command.add_option("--fabric", options.fabric,
                     "a named fabric, or a .yaml file with one (default: cotton_interlock)");
  command
      .add_option("--set", options.overrides,
                  "KEY=VALUE: change a key of the scenes, such as cloth.0.porous.diffusivity=2e-4; cloth.0 is the "
                  "specimen; repeatable")
      ->allow_extra_args(false);
  command
      .add_option("--repeats", options.repeats,
                  "number of specimens, per direction of the fabric (default: by the test)")
      ->check(at_least(1, 1000));
  command.add_option("-o,--output", options.output, "output folder, new or empty (default: out/<name>-<fabric>)");
  command.add_flag("--list", options.list, "list the tests");
  command.add_flag("--json", options.json, "print result.json instead of a table");
  command.add_flag("--quiet", options.quiet, "print no line per specimen");
  command.add_option("--threads", options.threads, "number of threads")->check(at_least(1, drench::most_threads));
  command.footer(
      "Examples:\n"
      "  drench test\n"
      "  drench test aatcc197 --fabric denim_11oz\n"
      "  drench test iso811 --set cloth.0.porous.breakthrough_pressure=3000 --repeats 2 -o head\n"
      "  drench test aatcc79 --fabric sock_nylon --json");
}

/// The commands and what is given to them.
class CommandLine {
 public:
  CommandLine();
  /// Reads the program's arguments. Returns an exit code where they end the program: --help, --version, wrong words.
  std::optional<int> parse(int argc, char** argv);
  /// Runs the command that was given and returns the exit code.
  int run(char** argv);
  /// The ranks that run the command together; null: one alone.
  const drench::Communicator* ranks() const { return ranks_.get(); }
  /// Where a key of the command's scene stands; the scene could be read a moment ago.
  std::string place_of(const std::string& key) const;

 private:
  CLI::App app_{"drench simulates water interacting with absorbent cloth"};
  CLI::App *run_, *check_, *compare_, *export_, *import_, *report_, *new_, *test_, *fit_, *info_, *schema_;
  drench::RunOptions run_options_;
  drench::CompareOptions compare_options_;
  drench::ExportOptions export_options_;
  drench::ImportOptions import_options_;
  drench::ReportOptions report_options_;
  drench::NewOptions new_options_;
  drench::TestOptions test_options_;
  drench::FitOptions fit_options_;
  drench::CheckOptions check_options_;
  int info_threads_ = 0;
  std::unique_ptr<drench::Communicator> ranks_;
#ifdef DRENCH_HAS_VIEW
  CLI::App* view_ = nullptr;
  drench::ViewOptions view_options_;
#endif
};

CommandLine::CommandLine() {
  app_.footer(
      "Examples:\n"
      "  drench check scene.yaml\n"
      "  drench run scene.yaml\n"
      "  drench run --help\n"
      "Exit codes: 0 done; 1 the run failed or a comparison exceeds its tolerance; 2 invalid command line or scene;\n"
      "130 interrupted by Ctrl-C.");
  app_.set_version_flag("--version", fmt::format("drench {}", drench::version_string));
  app_.require_subcommand(1);
  run_ = app_.add_subcommand("run", "run a scene");
  check_ = app_.add_subcommand("check", "check a scene; print its size, memory, steps and warnings");
  compare_ = app_.add_subcommand("compare", "compare the solver with the reference, stage by stage");
  export_ = app_.add_subcommand("export", "convert a run for other programs: USD, BGEO or PLY");
  import_ = app_.add_subcommand(
      "import", "convert a mesh of a USD, FBX, glTF, Alembic or Blender file, or another program's scene");
  report_ = app_.add_subcommand("report", "write an HTML report of a run, or of two runs in comparison");
#ifdef DRENCH_HAS_VIEW
  view_ = app_.add_subcommand("view", "show a run in a window, or write pictures of it");
  drench::add_view_options(*view_, view_options_);
#endif
  new_ = app_.add_subcommand("new", "print a first scene for the mesh of a garment, ready to run");
  test_ =
      app_.add_subcommand("test", "run a standard textile test on a fabric: wicking, absorbency, penetration, drape");
  fit_ = app_.add_subcommand("fit", "find the values of a fabric with which tests give measured curves");
  info_ = app_.add_subcommand("info", "print version, precision, device and libraries");
  schema_ =
      app_.add_subcommand("schema", "print every key of a scene with range, unit, default and description (Markdown)");
  add_run_options(*run_, run_options_);
  add_check_options(*check_, check_options_);
  add_compare_options(*compare_, compare_options_);
  add_export_options(*export_, export_options_);
  add_import_options(*import_, import_options_);
  add_report_options(*report_, report_options_);
  add_new_options(*new_, new_options_);
  add_test_options(*test_, test_options_);
  drench::add_fit_options(*fit_, fit_options_);
  info_->add_option("--threads", info_threads_, "number of threads")->check(at_least(1, drench::most_threads));
  info_->footer("Examples:\n  drench info\n  drench info --threads 2");
  schema_->footer("Examples:\n  drench schema\n  drench schema | grep spacing");
}

std::optional<int> CommandLine::parse(int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  std::vector<std::string> names;
  for (const CLI::App* command : app_.get_subcommands([](CLI::App*) { return true; }))
    names.push_back(command->get_name());
  const bool known = std::find(names.begin(), names.end(), first) != names.end();
  if (!first.empty() && first[0] != '-' && !known)
    return fail(drench::exit_usage,
                fmt::format("drench: unknown command {}; allowed: {}", first, fmt::join(names, ", ")));
  try {
    app_.parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    return fail(drench::exit_usage, drench::unexpected_word(known ? *app_.get_subcommand(first) : app_));
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app_.exit(e);  // --help, --version
    return fail(drench::exit_usage, fmt::format("drench: {}; see drench --help", e.what()));
  }
  return std::nullopt;
}

int CommandLine::run(char** argv) {
  if (*schema_) {
    fmt::print("{}", drench::scene_reference());
    return drench::exit_done;
  }
  if (*check_) return drench::check_command(check_options_);
  if (*export_) return drench::export_command(export_options_);
  if (*import_) return drench::import_command(import_options_);
  if (*report_) return drench::report_command(report_options_);
  if (*fit_) drench::fit_command(fit_options_);
#ifdef DRENCH_HAS_VIEW
  if (*view_) drench::become_viewer(argv + 2);
#endif
  if (drench::computes_on_host()) {
    const bool runs = run_->parsed();
    drench::settle_threads(argv, runs        ? run_options_.threads
                                 : *compare_ ? compare_options_.threads
                                 : *new_     ? new_options_.threads
                                 : *test_    ? test_options_.threads
                                             : info_threads_);
  }
  if (*new_) return drench::new_command(new_options_);
  if (*test_) return drench::test_command(test_options_);
  if (*info_) return drench::info_command(info_threads_);
  if (*compare_) return drench::compare_command(compare_options_);
  ranks_ = drench::join_ranks();
  return drench::run_command(run_options_, ranks_.get());
}

std::string CommandLine::place_of(const std::string& key) const {
  if (*new_) return "drench";
  if (*test_) return "drench test";
  if (*check_) return where(check_options_.scene, check_options_.overrides, key);
  if (*compare_) return where(compare_options_.scene, compare_options_.overrides, key);
  return where(run_options_.scene, run_options_.overrides, key);
}

/// A message that begins with the first two parts of the key that stands before it, such as bodies.1, without them.
std::string without_key(const std::string& message, const std::string& key) {
  const std::string part = key.substr(0, key.find('.', key.find('.') + 1));
  if (part.empty() || !message.starts_with(part)) return message;
  if (message.substr(part.size(), 2) == ": ") return message.substr(part.size() + 2);
  if (message.substr(part.size(), 4) == " is ") return message.substr(part.size() + 1);
  // "bodies.1 (mug.obj): …"
  const auto end = message.find("): ");
  if (message.substr(part.size(), 2) != " (" || end == std::string::npos) return message;
  return message.substr(part.size() + 2, end - part.size() - 2) + message.substr(end + 1);
}

/// Runs the command; an exception becomes a line of text and an exit code.
int run_safely(CommandLine& command, char** argv, std::string& text) {
  const auto says = [&text](int code, const std::string& what) {
    text = what;
    return code;
  };
  try {
    return command.run(argv);
  } catch (const drench::SceneError& e) {
    return says(drench::exit_usage, e.what());
  } catch (const drench::SetupError& e) {
    const std::string place = command.place_of(e.key);
    const std::string what = place.ends_with(e.key) ? without_key(e.what(), e.key) : e.what();
    return says(drench::exit_usage, fmt::format("{}: {}", place, what));
  } catch (const drench::RanksError& e) {
    return says(drench::exit_usage, fmt::format("drench: {}", e.what()));
  } catch (const drench::ExportError& e) {  // without a text where another program has printed why
    return says(drench::exit_usage, *e.what() ? fmt::format("drench: {}", e.what()) : "");
  } catch (const drench::TestError& e) {
    return says(drench::exit_usage, fmt::format("drench: {}", e.what()));
  } catch (const drench::ViewError& e) {
    return says(drench::exit_usage, fmt::format("drench: {}", e.what()));
  } catch (const drench::DeviceError& e) {
    return says(drench::exit_usage, fmt::format("drench: {}", e.what()));
  } catch (const drench::FolderError& e) {
    return says(drench::exit_usage, fmt::format("drench: {}", e.what()));
  } catch (const drench::CheckpointError& e) {
    return says(drench::exit_usage, fmt::format("drench: {}", e.what()));
  } catch (const std::bad_alloc&) {
    return says(drench::exit_failed, "drench: out of memory");
  } catch (const std::exception& e) {
    return says(drench::exit_failed, fmt::format("drench: {}", e.what()));
  }
}

/// One rank's exception ends all. What all of them have met, the first tells.
[[noreturn]] void end_ranks(const drench::Communicator& ranks, int code, const std::string& text) {
  if (ranks.rank() > 0) {
    std::this_thread::sleep_for(std::chrono::seconds(2));
    fail(code, fmt::format("rank {}: {}", ranks.rank(), text));
  } else {
    fail(code, text);
  }
  std::fflush(nullptr);
  ranks.abort(code);
  std::abort();
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);         // a file at its limit is an error of the write, reported like a full disk
  vtkObject::GlobalWarningDisplayOff();  // its warnings come back as error codes, which are reported in one line
  CommandLine command;
  if (const auto code = command.parse(argc, argv)) return *code;
  std::string text;
  const int code = run_safely(command, argv, text);
  if (text.empty()) return code;
  if (command.ranks()) end_ranks(*command.ranks(), code, text);
  return fail(code, text);
}
