// drench-view: what `drench view` becomes. A program of its own, so that drench itself needs no display libraries.

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>
#include <vtkAutoInit.h>
#include <vtkObject.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string_view>
#include <thread>

#include "base/exit_codes.hpp"
#include "view/display.hpp"
#include "view/options.hpp"
#include "view/png_files.hpp"
#include "view/run_frames.hpp"
#include "view/window.hpp"

VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkRenderingFreeType)
VTK_MODULE_INIT(vtkInteractionStyle)

namespace {

constexpr const char* no_display = "no display: set DISPLAY; drench view --screenshot FILE needs none";

int fail(const std::string& text) {
  fmt::print(stderr, "drench: {}\n", text);
  return drench::exit_usage;
}

/// The run that is followed has the processor first: the viewer takes what is left, and one core of it.
void step_back() {
  setpriority(PRIO_PROCESS, 0, 19);
  setenv("LP_NUM_THREADS", "1", 0);  // Mesa's, where no graphics card draws
}

/// Until the run that is followed has written its first frame. False where it ended before.
bool wait_for_frames(const std::string& folder) {
  const pid_t parent = getppid();
  while (drench::RunFrames(folder).times().empty()) {
    if (getppid() != parent) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return true;
}

int view(const drench::ViewOptions& options) {
  if (!std::filesystem::is_directory(options.folder)) return fail(options.folder + ": no such folder");
  const bool window = options.screenshot.empty() && options.pictures.empty();
  if (window && !drench::has_display()) return fail(no_display);
  std::optional<drench::VirtualDisplay> display;
  if (!drench::has_display()) display.emplace();
  if (options.follow) {
    step_back();
    if (!wait_for_frames(options.folder)) return fail(options.folder + ": the run ended before its first frame");
  }
  if (window)
    drench::open_window(options);
  else
    drench::write_pictures(options);
  return drench::exit_done;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  vtkObject::GlobalWarningDisplayOff();
  if (argc == 2 && std::string_view(argv[1]) == "--probe")  // asked before a run begins
    return drench::has_display() ? drench::exit_done : fail(no_display);
  CLI::App app("drench view: show a run in a window");
  drench::ViewOptions options;
  drench::add_view_options(app, options);
  try {
    app.parse(argc, argv);
    return view(options);
  } catch (const CLI::ParseError& e) {
    return e.get_exit_code() == 0 ? app.exit(e) : fail(std::string(e.what()) + "; see drench view --help");
  } catch (const std::exception& e) {
    return fail(e.what());
  }
}
