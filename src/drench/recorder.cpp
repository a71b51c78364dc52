#include "drench/recorder.hpp"

#include <fmt/format.h>

#include <utility>

#include "report/report.hpp"

namespace drench {

Recorder::Recorder(const std::string& folder, bool overwrite, const Model& model, const Backend& backend,
                   const Pipeline& pipeline, const std::vector<std::string>& warnings)
    : model_(model),
      backend_(&backend),
      pipeline_(&pipeline),
      folder_(make_run_folder(folder, model.scene.path, overwrite, {"choose another folder", "overwrite"}).path),
      lock_(folder_),
      log_(folder_ / "run.log"),
      totals_(model.most_stretch()) {
  write_resolved_scene(folder_, model_.scene, backend_->name(), backend_->description());
  log_.write(run_heading(backend_->name(), backend_->description(), model_.scene.path));
  for (const std::string& line : warnings) log_.write("warning: " + line);
  stats_.emplace(folder_ / "stats.csv", pipeline_->stages(), model_.quantum, pipeline_->initial_total(), -1,
                 StatsKinds{model_.scene.time.mode == TimeMode::error,
                            false,
                            {model_.solute_quantum(), pipeline_->initial_solute()},
                            model_.porous_cloths()});
  if (!model_.scene.output.probes.empty()) probes_.emplace(folder_ / "probes.csv", model_, state());
  frames_.emplace(folder_, model_);
  frame();
}

void Recorder::step(const StepReport& report) {
  frames_->check();
  log_.write(totals_.add(pipeline_->step_index(), pipeline_->time(), report, pipeline_->milliseconds()));
  stats_->write({report, pipeline_->milliseconds(), pipeline_->step_milliseconds()});
  if (probes_)
    probes_->step(
        report, [&] { return backend_->body_loads(report.dt); }, [&] { return state(); });
  mass_error_ = static_cast<double>(report.mass_total() - pipeline_->initial_total()) * model_.quantum;
}

void Recorder::failed(const RunFailure& failure) {
  failed_ = true;
  log_.write(fmt::format("drench: the run failed in stage {} at step {} (t = {:.6g} s): {}", name_of(failure.stage),
                         failure.info.step, failure.info.time, failure.what()));
}

HostState Recorder::state() const {
  HostState state = backend_->download();
  pipeline_->mark(state);
  return state;
}

void Recorder::frame() {
  if (last_frame_step_ == pipeline_->step_index()) return;
  frames_->wait();
  frames_->write(state());
  last_frame_step_ = pipeline_->step_index();
}

std::filesystem::path Recorder::finish() {
  if (!failed_) frame();  // the state of half a step is none to show
  frames_->finish();
  log_.write(totals_.warnings());
  if (!failed_) {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    log_.write(totals_.end(pipeline_->time(), seconds, mass_error_));
    log_.write(totals_.errors(model_));
  }
  log_.write(totals_.stage_table(pipeline_->stages()));
  const std::filesystem::path file = folder_ / report_name;
  write_report(folder_, std::nullopt, file);
  return file;
}

}  // namespace drench
