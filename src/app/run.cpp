#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>

#include "app/commands.hpp"
#include "app/set_up.hpp"
#include "drench_version.hpp"
#include "output/frame_queue.hpp"
#include "output/progress.hpp"
#include "output/run_folder.hpp"
#include "output/run_log.hpp"
#include "output/stats_csv.hpp"
#include "pipeline/pipeline.hpp"
#include "pipeline/runtime.hpp"
#include "scene/build.hpp"
#include "scene/load.hpp"

namespace drench {
namespace {

volatile std::sig_atomic_t interrupted = 0;

/// The first Ctrl-C asks for an orderly end; a second one ends the program at once.
void on_interrupt(int) {
  interrupted = 1;
  std::signal(SIGINT, SIG_DFL);
}

struct InterruptGuard {
  InterruptGuard() : before_(std::signal(SIGINT, on_interrupt)) { interrupted = 0; }
  ~InterruptGuard() { std::signal(SIGINT, before_); }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  void (*before_)(int);
};

/// Bytes of the backend with so many particles more than the scene begins with.
double estimate(const Setup& setup, int real_bytes, double more) {
  SetupSize size = size_of(setup);
  size.fluid += more;
  return estimate_memory(size, real_bytes).backend();
}

/// A run from its first frame to its last line.
class Run {
 public:
  Run(const RunOptions& options, const Setup& setup, Backend& backend, int real_bytes)
      : options_(options),
        model_(setup.model),
        backend_(backend),
        pipeline_(setup.model, backend, setup.state),
        end_(model_.scene.time.end),
        last_state_step_(-1),
        estimate_(estimate(setup, real_bytes, 0)),
        with_jets_(estimate(setup, real_bytes, jet_particles(setup.model))) {
    pipeline_.set_profiling(options.profile);
    if (!options.no_output) open_folder();
    for (const std::string& w : setup.warnings) warn(w);
  }

  int execute() {
    const auto begin = std::chrono::steady_clock::now();
    Progress progress(options_.quiet, pipeline_.time(), end_, options_.steps.value_or(-1));
    bool stopped = false;
    try {
      frame();
      while (!finished() && !interrupted) {
        if (frames_) frames_->check();
        const StepReport report = pipeline_.step(next_stop() - pipeline_.time());
        log_.write(totals_.add(pipeline_.step_index(), pipeline_.time(), report, pipeline_.milliseconds()));
        if (stats_)
          stats_->write(pipeline_.step_index(), pipeline_.time(), pipeline_.last_dt(), report, pipeline_.milliseconds(),
                        pipeline_.step_milliseconds());
        mass_error_ = static_cast<double>(report.mass_total() - pipeline_.initial_total()) * model_.quantum;
        progress.update(pipeline_.time(), pipeline_.step_index(), totals_.steps(), report, mass_error_);
        if (every() > 0 && pipeline_.time() >= next_frame_time() - rounding()) frame();
      }
      stopped = interrupted && !finished();
      if (frames_wanted() && last_state_step_ != pipeline_.step_index()) frame();
      if (frames_) frames_->finish();
    } catch (const RunFailure& failure) {
      progress.finish();
      return fail(failure);
    } catch (const std::exception& e) {
      progress.finish();
      log_.write(fmt::format("stopped at step {}: {}", pipeline_.step_index(), e.what()));
      throw;
    }
    progress.finish();
    summary(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), stopped);
    return stopped ? exit_interrupted : exit_done;
  }

 private:
  double every() const { return model_.scene.output.every; }
  bool frames_wanted() const { return frames_ && every() > 0; }
  double rounding() const { return 1e-6 * model_.scene.time.step; }
  /// Counted, not summed, so that a thousand frames do not drift.
  double next_frame_time() const { return static_cast<double>(frame_count_) * every(); }
  double next_stop() const { return every() > 0 ? std::min(next_frame_time(), end_) : end_; }
  bool finished() const {
    return pipeline_.time() >= end_ - rounding() || (options_.steps && totals_.steps() >= *options_.steps);
  }

  void open_folder() {
    const RunFolder folder = make_run_folder(options_.output, options_.scene, options_.overwrite);
    folder_ = folder.path;
    write_resolved_scene(folder_, model_.scene, backend_.name(), backend_.description());
    log_ = RunLog(folder_ / "run.log");
    log_.write(fmt::format("drench {} ({}, {} precision), backend {}: {}", version_string, git_commit, precision_name,
                           backend_.name(), backend_.description()));
    log_.write(fmt::format("scene {}", options_.scene));
    stats_.emplace(folder_ / "stats.csv", pipeline_.stages(), model_.quantum, pipeline_.initial_total());
    if (every() > 0) frames_.emplace(folder_, model_);
    if (!folder.note.empty()) say(folder.note);
  }

  /// Steps are clipped to the frames' times with --no-output too: whether files are written must not change the result.
  void frame() {
    if (every() > 0 && next_frame_time() <= pipeline_.time() + rounding()) ++frame_count_;
    if (!frames_wanted()) return;
    frames_->wait();
    frames_->write(download());
    last_state_step_ = pipeline_.step_index();
  }

  HostState download() const {
    HostState state = backend_.download();
    state.time = pipeline_.time();
    state.step = pipeline_.step_index();
    return state;
  }

  void say(const std::string& text) {
    if (!options_.quiet) {
      fmt::print("{}\n", text);
      std::fflush(stdout);
    }
    log_.write(text);
  }

  void warn(const std::string& text) {
    if (!options_.quiet) fmt::print(stderr, "warning: {}\n", text);
    log_.write("warning: " + text);
  }

  int fail(const RunFailure& failure) {
    try {
      if (frames_) frames_->finish();
    } catch (const std::exception& e) {  // the failure is what matters, and the frame is not why
      warn(e.what());
    }
    const HostState state = download();
    const Offenders offenders = find_offenders(state);
    std::string text = fmt::format("drench: the run failed in stage {} at step {} (t = {:.6g} s): {}",
                                   name_of(failure.stage), failure.step, pipeline_.time(), failure.what());
    if (!offenders.empty()) {
      text += "; " + describe(offenders, state);
      if (!folder_.empty()) {
        write_vtu(folder_ / "failure.vtu", offender_grid(model_, state, offenders));
        text += "; see " + (folder_ / "failure.vtu").string();
      }
    }
    log_.write(text);
    log_.write(totals_.warnings());
    fmt::print(stderr, "{}\n", text);
    return exit_failed;
  }

  void summary(double seconds, bool stopped) {
    const std::string warnings = totals_.warnings();
    if (!warnings.empty()) say(warnings.substr(0, warnings.size() - 1));
    if (stopped) say(fmt::format("interrupted at step {}", pipeline_.step_index()));
    say(fmt::format("{} steps to t = {:.6g} s in {:.1f} s, mass error {:.3g} kg", totals_.steps(), pipeline_.time(),
                    seconds, mass_error_));
    if (options_.backend != "reference")
      say(fmt::format(
          "peak memory of the backend's arrays {}, {} estimated at the start{}",
          mebibytes(static_cast<double>(array_memory().peak)), mebibytes(estimate_),
          with_jets_ > estimate_ ? fmt::format(", {} with all particles from jets", mebibytes(with_jets_)) : ""));
    if (frames_ && frames_->waited() >= 0.05)
      say(fmt::format("waited {:.1f} s for frames to be written", frames_->waited()));
    const std::string table = totals_.stage_table(pipeline_.stages());
    log_.write(table);
    if (options_.profile) fmt::print("{}", table);
    if (folder_.empty() || options_.quiet) return;
    std::string files;
    if (frames_)
      for (const std::string& name : frames_->collections()) files += (files.empty() ? "" : ", ") + name;
    const std::string pictures =
        frames_ ? fmt::format("; {} frames, open in ParaView: {}", frames_->frames(), files) : std::string();
    fmt::print("output in {}{}\n", folder_.string(), pictures);
  }

  const RunOptions& options_;
  const Model& model_;
  Backend& backend_;
  Pipeline pipeline_;
  double end_;
  std::int64_t last_state_step_;
  double estimate_, with_jets_;  // bytes: of the backend
  std::int64_t frame_count_ = 0;
  double mass_error_ = 0;
  std::filesystem::path folder_;  // empty with --no-output
  RunLog log_;
  RunTotals totals_;
  std::optional<StatsCsv> stats_;
  std::optional<FrameQueue> frames_;
};

}  // namespace

int run_command(const RunOptions& options) {
  const InterruptGuard guard;
  Scene scene = load_scene(options.scene, options.overrides);
  if (options.until) scene.time.end = *options.until;
  const bool reference = options.backend == "reference";
  const MemoryBudget budget = memory_budget(reference);
  const Setup setup = build(scene, budget);
  refuse_too_large(size_of(setup), budget);  // now that lists are known to be as wide as they are
  std::optional<BackendRuntime> runtime;     // outlives the backend
  if (!reference) runtime.emplace(options.threads, options.quiet);
  const std::unique_ptr<Backend> backend =
      reference ? make_reference_backend(setup.model) : make_kokkos_backend(setup.model);
  return Run(options, setup, *backend, budget.real_bytes).execute();
}

}  // namespace drench
