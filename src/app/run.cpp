#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>

#include "app/commands.hpp"
#include "app/failure_report.hpp"
#include "app/interrupt.hpp"
#include "app/rank_table.hpp"
#include "app/resume.hpp"
#include "app/set_up.hpp"
#include "app/threads.hpp"
#include "app/view.hpp"
#include "base/free_cores.hpp"
#include "base/stop_request.hpp"
#include "output/fabric_summary.hpp"
#include "output/frame_queue.hpp"
#include "output/lost.hpp"
#include "output/probes.hpp"
#include "output/progress.hpp"
#include "output/run_folder.hpp"
#include "output/run_log.hpp"
#include "output/run_schedule.hpp"
#include "output/stats_csv.hpp"
#include "output/text_file.hpp"
#include "parallel/communicator.hpp"
#include "pipeline/pipeline.hpp"
#include "pipeline/runtime.hpp"
#include "report/report.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"

namespace drench {
namespace {

/// No exception where the terminal has gone: the run goes on, or saves its checkpoint.
void print_line(std::FILE* to, const std::string& text) {
  std::fputs((text + "\n").c_str(), to);
  std::fflush(to);
}

/// What the user reads of an exception that is not a RunFailure.
std::string cause_of(const std::exception& e) {
  const std::string what = e.what();
  // Some versions of Kokkos throw a std::runtime_error, of which this is a part.
  const bool of_kokkos = what.find("failed to allocate") != std::string::npos;
  if (dynamic_cast<const std::bad_alloc*>(&e) == nullptr && !of_kokkos) return what;
  return "out of memory: use a larger fluid.spacing, or emitters with less liquid";
}

/// A run from its first frame to its last line.
class Run {
 public:
  Run(const RunOptions& options, const Setup& setup, Backend& backend, const ForeseenMemory& memory,
      const Resume* resume, const Communicator* ranks)
      : options_(options),
        resume_(resume),
        ranks_(ranks),
        model_(setup.model),
        start_(setup.state),
        backend_(backend),
        pipeline_(setup.model, backend, setup.state),
        schedule_(model_.scene),
        memory_(memory) {
    pipeline_.set_profiling(options.profile);
    if (!ranks_) pipeline_.set_stoppable(setup.state);  // ranks would have to agree within the step
    if (ranks_) ranks_->traffic().fenced = options.profile;
    if (resume_) go_on();
    if (!options.no_output && first()) open_folder();
    if (!options.no_output && !first() && !model_.scene.output.probes.empty()) start_probes(std::filesystem::path());
    if (!options.no_output) schedule_.plan_checkpoint(pipeline_.time());
    if (ranks_) say(fmt::format("{} ranks, {}", ranks_->size(), ranks_->description()));
    for (const std::string& line : setup.notes) say(line);
    for (const std::string& w : setup.warnings) warn(w);
    if (const std::string waiting = threads_.waiting(); !waiting.empty()) say(waiting);
    if (!resume_) return;
    for (const std::string& w : resume_->warnings) warn(w);
    say(fmt::format("continuing from {} at step {}, t = {:.6g} s", resume_->path.string(), pipeline_.step_index(),
                    pipeline_.time()));
  }

  int execute() {
    const auto begin = std::chrono::steady_clock::now();
    Progress progress(options_.quiet || !first(), pipeline_.time(), model_.scene.time.end, options_.steps.value_or(-1));
    bool stopped = false;
    try {
      if (!resume_) frame();
      while (!finished() && !stops()) {
        if (frames_) frames_->check();
        threads_.look();
        const Traffic before = ranks_ ? ranks_->traffic() : Traffic{};
        const std::optional<StepReport> done = step();
        if (!done) break;
        const StepReport& report = *done;
        const Traffic after = ranks_ ? ranks_->traffic() : Traffic{};
        balance_.add(report);
        log_.write(totals_.add(pipeline_.step_index(), pipeline_.time(), report, pipeline_.milliseconds()));
        hear_frames();
        fabrics_.add(pipeline_.time(), report.fabrics);
        if (stats_)
          stats_->write({report, pipeline_.milliseconds(), pipeline_.step_milliseconds(),
                         1000 * (after.exchanging - before.exchanging), 1000 * (after.summing - before.summing)});
        if (probes_)
          probes_->step(
              report, [&] { return backend_.body_loads(report.dt); }, [&] { return download(); });
        mass_error_ = static_cast<double>(report.mass_total() - pipeline_.initial_total()) * model_.quantum;
        progress.update(pipeline_.time(), pipeline_.step_index(), totals_.steps(), report, mass_error_);
        if (schedule_.frame_due(pipeline_.time())) frame();
        if (checkpoints() && schedule_.checkpoint_due(pipeline_.time())) checkpoint();
      }
      stopped = stops_ && !finished();
      if (stopped || checkpoints()) checkpoint();
      if (frames_wanted() && last_state_step_ != pipeline_.step_index()) frame();
      if (frames_) frames_->finish();
      hear_frames();
    } catch (const RunFailure& failure) {
      progress.finish();
      return fail(failure);
    } catch (const std::exception& e) {
      progress.finish();
      const std::string kept = last_checkpoint(), what = cause_of(e);
      log_.write(fmt::format("stopped at step {}: {}{}", pipeline_.step_index(), what, kept));
      report();
      if (kept.empty() && what == e.what()) throw;  // what is wrong in a file of the scene keeps its kind
      throw std::runtime_error(what + kept);
    }
    progress.finish();
    summary(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), stopped);
    report();
    return stopped ? exit_interrupted : exit_done;
  }

 private:
  /// Does this rank write files and speak?
  bool first() const { return !ranks_ || ranks_->rank() == 0; }
  /// Has somebody asked this rank, or another one, to end?
  bool stops() {
    double asked = InterruptGuard::asked();
    if (ranks_) ranks_->all_reduce({}, {&asked, 1});
    stops_ = asked > 0;
    return stops_;
  }
  bool frames_wanted() const { return !options_.no_output && schedule_.has_frames(); }
  bool checkpoints() const { return !options_.no_output && model_.scene.output.checkpoint_every > 0; }
  bool finished() const {
    return schedule_.ended(pipeline_.time()) || (options_.steps && totals_.steps() >= *options_.steps);
  }

  /// To the next frame or the end. None if somebody asks for an end before the step is done: it is taken back.
  std::optional<StepReport> step() {
    const double before = pipeline_.time();
    StepReport report;
    try {
      report = pipeline_.step(schedule_.time_left(before));
    } catch (const StepStopped&) {
      stops_ = true;
      return std::nullopt;
    }
    if (schedule_.clipped_by_end(before, report.dt)) shortened_ = true;
    return report;
  }

  /// Takes up the counts of the run that wrote the checkpoint.
  void go_on() {
    const Checkpoint& c = resume_->checkpoint;
    frames_written_ = c.frames;
    shortened_ = c.shortened != 0;
    last_checkpoint_step_ = pipeline_.step_index();
    if (schedule_.go_on(pipeline_.time())) last_state_step_ = pipeline_.step_index();  // its frame is one of those
  }

  /// Goes on in the folder of the checkpoint's run: what it wrote after the checkpoint goes. The checkpoints after it
  /// first, so that whatever happens meanwhile, this one can be gone on from again.
  void cut_off() {
    for (const auto& path : checkpoints_in(folder_))
      if (checkpoint_step(path) > pipeline_.step_index()) std::filesystem::remove(path);
    std::filesystem::remove(folder_ / "failure.vtu");
    std::filesystem::remove(folder_ / report_name);
    remove_unfinished(folder_);
    keep_two();
    if (!schedule_.has_frames() && frames_written_ > 0) FrameWriter(folder_, model_, static_cast<int>(frames_written_));
  }

  void open_folder() {
    std::error_code ignored;
    const bool same = resume_ && !resume_->folder.empty() &&
                      (!options_.output || std::filesystem::equivalent(*options_.output, resume_->folder, ignored));
    RunFolder folder{same ? resume_->folder : std::filesystem::path(), ""};
    if (!same) folder = make_run_folder(options_.output, options_.scene, options_.overwrite);
    lock_.emplace(folder.path);
    folder_ = folder.path;
    if (!same) frames_elsewhere_ = frames_written_;
    if (same) cut_off();
    write_resolved_scene(folder_, model_.scene, backend_.name(), backend_.description());
    log_ = RunLog(folder_ / "run.log", same);
    log_.write(run_heading(backend_.name(), backend_.description(), options_.scene));
    stats_.emplace(folder_ / "stats.csv", pipeline_.stages(), model_.quantum, pipeline_.initial_total(),
                   same ? pipeline_.step_index() : -1,
                   StatsKinds{model_.scene.time.mode == TimeMode::error,
                              ranks_ != nullptr,
                              {model_.solute_quantum(), pipeline_.initial_solute()},
                              model_.porous_cloths()});
    if (!model_.scene.output.probes.empty()) start_probes(folder_ / "probes.csv");
    if (schedule_.has_frames())
      frames_.emplace(
          folder_, model_, static_cast<int>(frames_written_),
          [this](const HostState& state) {
            return describe_lost(model_, state, model_.scene.time.step) + '\n' + describe_nodes_inside(model_, state);
          },
          std::max(1, allowed_cores() - loop_threads()));
    if (!folder.note.empty()) say(folder.note);
#ifdef DRENCH_HAS_VIEW
    if (options_.view) start_viewer(folder_);
#endif
  }

  void start_probes(const std::filesystem::path& file) {
    probes_.emplace(file, model_, start_, resume_ ? pipeline_.time() : -1);
    if (resume_) probes_->take_up(resume_->checkpoint.probe_sums);
  }

  void checkpoint() {
    if (options_.no_output || last_checkpoint_step_ == pipeline_.step_index()) return;
    // A checkpoint is only as good as the output before it: a power cut must not leave it newer than that.
    if (frames_) {
      frames_->wait();
      frames_->sync();
    }
    if (stats_) stats_->sync();
    if (probes_) probes_->sync();
    if (first() && last_checkpoint_step_ < 0) sync_to_disk(folder_ / "scene.yaml");
    HostState state = download();
    if (first()) write(std::move(state));
    last_checkpoint_step_ = pipeline_.step_index();
    schedule_.plan_checkpoint(pipeline_.time());
    if (first()) keep_two();
  }

  void write(HostState&& state) const {
    Checkpoint c = checkpoint_header(model_, backend_);
    c.frames = frames_written_;
    c.shortened = shortened_ ? 1 : 0;
    if (probes_) c.probe_sums = probes_->sums();
    c.state = std::move(state);
    write_checkpoint(folder_ / checkpoint_name(c.state.step), c);
  }

  void keep_two() const {
    const auto all = checkpoints_in(folder_);
    for (std::size_t k = 2; k < all.size(); ++k) std::filesystem::remove(all[k]);
  }

  /// Steps are clipped to the frames' times with --no-output too: whether files are written must not change the result.
  void frame() {
    const bool on_schedule = schedule_.frame_due(pipeline_.time());
    if (on_schedule) schedule_.frame_taken();
    if (!frames_wanted()) return;
    if (on_schedule) ++frames_written_;
    if (frames_) frames_->wait();
    HostState state = download();
    if (frames_) frames_->write(std::move(state));
    last_state_step_ = pipeline_.step_index();
  }

  /// Logs what the frames' thread has noticed: the first of each kind in full, then only how many frames.
  void hear_frames() {
    if (!frames_) return;
    for (const std::string& text : frames_->said()) {
      const std::size_t end = text.find('\n');
      const std::string lost = text.substr(0, end), nodes = text.substr(end + 1);
      if (!lost.empty() && frames_with_lost_++ == 0) log_.write("warning: " + lost);
      if (!nodes.empty() && frames_with_nodes_inside_++ == 0) log_.write("warning: " + nodes);
      last_nodes_inside_ = nodes;
    }
  }

  /// For messages.
  std::string last_checkpoint() const {
    const auto kept = folder_.empty() ? std::vector<std::filesystem::path>() : checkpoints_in(folder_);
    return kept.empty() ? "" : fmt::format("; the last checkpoint is {}", kept.front().string());
  }

  HostState download() const {
    HostState state = backend_.download();
    pipeline_.mark(state);
    return state;
  }

  void say(const std::string& text) {
    if (!options_.quiet && first()) {
      print_line(stdout, text);
    }
    log_.write(text);
  }

  void warn(const std::string& text) {
    if (!options_.quiet && first()) print_line(stderr, "warning: " + text);
    log_.write("warning: " + text);
  }

  int fail(const RunFailure& failure) {
    try {
      if (frames_) frames_->finish();
    } catch (const std::exception& e) {  // the failure is what matters, and the frame is not why
      warn(e.what());
    }
    hear_frames();
    const HostState state = download();
    const Offenders offenders = offenders_of(failure, model_, state);
    std::string text = fmt::format("drench: the run failed in stage {} at step {} (t = {:.6g} s): {}",
                                   name_of(failure.stage), failure.info.step, failure.info.time, failure.what());
    if (!offenders.empty()) text += "; " + describe(offenders, state);
    const std::string remedy = advice(failure, model_, state);
    text += "; " + remedy;
    if (!offenders.empty() && !folder_.empty()) {
      try {
        write_vtu(folder_ / "failure.vtu", offender_grid(model_, state, offenders));
        text += "; see " + (folder_ / "failure.vtu").string();
      } catch (const std::exception& e) {
        text += fmt::format("; {}", e.what());
      }
    }
    text += last_checkpoint();  // the state of half a step is nothing to go on from
    log_.write(text);
    log_.write("remedy: " + remedy);
    log_.write(warnings());
    write_memory();
    if (first()) print_line(stderr, text);
    report();
    return exit_failed;
  }

  std::string memory_line() const {
    return fmt::format("peak memory of the backend's arrays {}, {} estimated at the start{}",
                       mebibytes(static_cast<double>(array_memory().peak)), mebibytes(memory_.start.backend()),
                       memory_.later());
  }

  void write_memory() {
    if (options_.backend != "reference") log_.write(memory_line());
  }

  /// The run is over: a report that cannot be written is a warning, and the exit code stays.
  void report() {
    if (folder_.empty() || !model_.scene.output.report) return;
    try {
      write_report(folder_, std::nullopt, folder_ / report_name);
      if (!options_.quiet) print_line(stdout, "report in " + (folder_ / report_name).string());
    } catch (const std::exception& e) {
      warn(fmt::format("the report was not written: {}", e.what()));
    }
  }

  /// Lines; "" for none.
  std::string warnings() const {
    std::string text = totals_.warnings();
    if (frames_with_lost_ > 0)
      text += fmt::format("particles were inside solids or outside of containers in {} frames\n", frames_with_lost_);
    if (frames_with_nodes_inside_ > 0)
      text += fmt::format("cloth nodes were inside solids in {} frames; in the last one {}\n",
                          frames_with_nodes_inside_, last_nodes_inside_.empty() ? "none" : last_nodes_inside_);
    return text;
  }

  void summary(double seconds, bool stopped) {
    const std::string lines = warnings();
    if (!lines.empty()) say(lines.substr(0, lines.size() - 1));
    if (stopped) say(fmt::format("interrupted at step {}", pipeline_.step_index()));
    if (stopped && !folder_.empty())
      say(fmt::format("to continue: drench run {} --resume {}", options_.scene, folder_.string()));
    if (resume_ && totals_.steps() == 0 && !stopped)
      say(fmt::format("the run had already ended at {:.6g} s; to continue it: --until T", pipeline_.time()));
    say(totals_.end(pipeline_.time(), seconds, mass_error_));
    if (const std::string errors = totals_.errors(model_); !errors.empty()) say(errors);
    if (const std::string fabrics = fabrics_.lines(model_); !fabrics.empty())
      say(fabrics.substr(0, fabrics.size() - 1));
    if (options_.backend != "reference") say(memory_line());
    if (frames_ && frames_->waited() >= 0.05) say(fmt::format("waited {:.1f} s for writing frames", frames_->waited()));
    std::string table = totals_.stage_table(pipeline_.stages());
    if (ranks_) table += rank_table(*ranks_, totals_, balance_);
    if (options_.profile && !ranks_ && options_.backend != "reference") table += totals_.array_table(named_arrays());
    log_.write(table);
    if (options_.profile && first()) std::fputs(table.c_str(), stdout);
    if (folder_.empty() || options_.quiet) return;
    std::string files;
    if (frames_)
      for (const std::string& name : frames_->collections()) files += (files.empty() ? "" : ", ") + name;
    const std::int64_t here = frames_ ? frames_->frames() - frames_elsewhere_ : 0;
    const std::string pictures =
        here > 0 ? fmt::format("; {} frame{}, open in ParaView: {}", here, here == 1 ? "" : "s", files) : std::string();
    print_line(stdout, fmt::format("output in {}{}", folder_.string(), pictures));
  }

  const RunOptions& options_;
  const Resume* resume_;       // null: from the scene's beginning
  const Communicator* ranks_;  // null: one alone
  bool stops_ = false;
  RankBalance balance_;
  const Model& model_;
  const HostState& start_;
  Backend& backend_;
  Pipeline pipeline_;
  ThreadWatch threads_;
  RunSchedule schedule_;
  std::int64_t last_state_step_ = -1;
  const ForeseenMemory& memory_;
  std::int64_t frames_written_ = 0;    // on schedule, those of the run before included
  std::int64_t frames_elsewhere_ = 0;  // of these, in the folder of the run before
  std::int64_t last_checkpoint_step_ = -1;
  bool shortened_ = false;  // the last step ended at time.end and not where it would have ended otherwise
  double mass_error_ = 0;
  std::int64_t frames_with_lost_ = 0, frames_with_nodes_inside_ = 0;
  std::string last_nodes_inside_;
  std::filesystem::path folder_;  // empty with --no-output
  std::optional<FolderLock> lock_;
  RunLog log_;
  RunTotals totals_{model_.most_stretch()};
  FabricSummary fabrics_;
  std::optional<StatsCsv> stats_;
  std::optional<ProbeCsv> probes_;
  std::optional<FrameQueue> frames_;
};

}  // namespace

int run_command(const RunOptions& options, const Communicator* ranks) {
  if (ranks && options.backend == "reference")
    throw RanksError("the reference runs on one rank: start it without mpirun");
  Scene scene = load_scene(options.scene, options.overrides);
  if (ranks && scene.fluid.is_baked())
    throw RanksError("liquid of a sequence of files runs on one rank: start drench without mpirun");
  if ((ranks || options.backend == "reference") &&
      std::any_of(scene.output.probes.begin(), scene.output.probes.end(),
                  [](const ProbeScene& p) { return p.kind == ProbeScene::Kind::body; }))
    throw RanksError(
        "probes of bodies are not available over several ranks and with the reference: remove them, or run the solver "
        "without mpirun");
  if (options.until) {
    scene.time.end = *options.until;
    if (const auto often = too_often(scene))
      throw SceneError(fmt::format("--until {}", scene.time.end), often->first + ": " + often->second);
  }
#ifdef DRENCH_HAS_VIEW
  if (options.view && (options.no_output || scene.output.every <= 0))
    throw ViewError("--view shows the frames of a run: it requires output.every above 0 and excludes --no-output");
  if (options.view && !viewer_can_open()) return exit_usage;
#endif
  const bool reference = options.backend == "reference";
  const int rank_count = ranks ? ranks->size() : 1;
  const MemoryBudget whole = memory_budget(reference);
  Setup setup = build(scene, memory_budget_of_rank(whole, share_of_rank(scene, rank_count)));
  const MemoryBudget budget = memory_budget_of_rank(whole, share_of_rank(setup, rank_count));
  ForeseenMemory memory = foresee_memory(setup, budget);
  refuse_too_large(memory.size, budget);  // now that the lists' entries are counted
  if (std::string late = memory.too_large_later(budget); !late.empty()) setup.warnings.push_back(std::move(late));
  std::optional<BackendRuntime> runtime;  // outlives the backend
  if (!reference)
    runtime.emplace(ranks && options.threads == 0 && allowed_cores() == 1 ? 1 : options.threads, options.quiet);
  const std::unique_ptr<Backend> backend =
      reference ? make_reference_backend(setup.model) : make_kokkos_backend_on(ranks, setup.model);
  if (ranks) {
    const Checkpoint own = checkpoint_header(setup.model, *backend);
    require_agreement(*ranks, {{"version", own.version + own.commit},
                               {"precision", own.precision},
                               {"backend", own.backend},
                               {"scene", own.scene},
                               {"mesh", fmt::format("{}", own.geometry)},
                               {"number of steps", fmt::format("{}", options.steps.value_or(-1))},
                               {"checkpoint", options.resume},
                               {"output", options.no_output ? "none" : options.output.value_or("")}});
  }
  std::optional<Resume> resume;
  if (!options.resume.empty()) {
    resume = find_checkpoint(options.resume, setup.model, *backend);
    if (const double time = resume->checkpoint.state.time; options.until && *options.until < time * (1 - 1e-9))
      throw SceneError(
          fmt::format("--until {}", *options.until),
          fmt::format("the run is already at {:.6g} s in {}; use a later time, or --resume with an earlier "
                      "checkpoint",
                      time, resume->path.string()));
    setup.state = std::move(resume->checkpoint.state);
    memory = foresee_memory(setup, budget);
  }
  // Before, nothing would be lost: a signal ends the program at once.
  const InterruptGuard guard(!options.quiet && (!ranks || ranks->rank() == 0));
  return Run(options, setup, *backend, memory, resume ? &*resume : nullptr, ranks).execute();
}

}  // namespace drench
