#include "pipeline/pipeline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/stop_request.hpp"
#include "state/fastest.hpp"
#include "state/mass_budget.hpp"

namespace drench {
namespace {

/// The step that is taken when the stages allow `wanted` and the next output is `left` away.
double clip_step(double wanted, double left, TimeMode mode) {
  constexpr double rounding = 1e-9;  // a remainder below this share of a step is rounding, not time
  if (left <= wanted * (1 + rounding)) return left;
  // Two even steps instead of a sliver, in which the correction of a density error would become a great velocity.
  if (left < (mode == TimeMode::fixed ? 1.1 : 1.5) * wanted) return 0.5 * left;
  return wanted;
}

// time.mode error, in units of time.tolerance: what steps leave aims at the first, and none adds more than the second,
// or ends with more of which most is its own. What the solve cannot correct at once, as in a crowd, no shorter step
// would.
constexpr double aim_of_error = 0.6, worst_of_error = 2.5;

/// Would a shorter step leave less?
bool is_too_long(const StepReport& report, double tolerance) {
  const double own = report.density_found - report.density_error, worst = worst_of_error * tolerance;
  return own > worst || (report.density_found > worst && own > 0.5 * report.density_found);
}

/// How long the next step may be, s, after one of `tried` that might have been as long as `longest`. What the solve
/// left lies within its own tolerance; the rest is the step's own error and goes with its square, or more steeply. Of
/// that a part `corrected` goes in each step.
double step_after(double tried, double longest, const StepReport& r, double tolerance, double corrected) {
  const double own = std::max(r.density_found - r.density_error, 1e-3 * tolerance);
  const double fits = tried * std::sqrt(aim_of_error * corrected * tolerance / own);
  return std::clamp(fits, 0.5 * tried,
                    std::max(tried, 1.2 * longest));  // one that ends at a frame says little of a longer one
}

/// Names the first of the report's numbers that is not finite, "" if all are.
std::string_view nonfinite_number(const StepReport& r) {
  const std::pair<std::string_view, double> numbers[] = {
      {"the divergence error", r.divergence_error},   {"the density error", r.density_error},
      {"the remaining compression", r.density_found}, {"the largest density error", r.density_error_max},
      {"the cloth residual", r.cloth_residual},       {"the largest saturation", r.saturation_max}};
  for (const auto& [name, value] : numbers)
    if (!std::isfinite(value)) return name;
  return {};
}

}  // namespace

std::vector<Stage> stages_for(const Model& m) {
  std::vector<Stage> stages;
#define DRENCH_STAGE_ADD(name, when) \
  if (when) stages.push_back(Stage::name);
  DRENCH_STAGES(DRENCH_STAGE_ADD)
#undef DRENCH_STAGE_ADD
  return stages;
}

Pipeline::Pipeline(const Model& model, Backend& backend, const HostState& initial)
    : model_(model),
      backend_(backend),
      stages_(stages_for(model)),
      time_(initial.time),
      step_(initial.step),
      initial_total_(liquid_budget(initial)),
      initial_solute_(solute_budget(initial)),
      limits_(model, static_cast<double>(initial_total_) * model.quantum),
      carried_(initial),
      in_cloth_(sum_of(initial.node_liquid)),
      capacity_(std::accumulate(model.samples.node_capacity.begin(), model.samples.node_capacity.end(), 0.0)) {
  if (model.has_baked_liquid()) {
    baked_.emplace(model);
    fastest_file_ = fastest_of(initial.fluid_velocity);
    limits_.expect(fastest_file_);
  }
  backend_.upload(initial);
}

void Pipeline::take_file() {
  HostState state = backend_.download();
  mark(state);
  baked_->replace(state, time_);
  fastest_file_ = std::max(fastest_file_, fastest_of(state.fluid_velocity));
  limits_.expect(fastest_file_);
  backend_.upload(state);
}

void Pipeline::model_changed() {
  looked_ = false;
  stages_ = stages_for(model_);
  limits_ = Limits(model_, static_cast<double>(initial_total_) * model_.quantum);
  limits_.expect(fastest_file_);
  backend_.model_changed();
}

void Pipeline::go_on_from(const HostState& state) {
  time_ = state.time;
  step_ = state.step;
  carried_ = state;
  in_cloth_ = sum_of(state.node_liquid);
  initial_total_ = liquid_budget(state);
  initial_solute_ = solute_budget(state);
  model_changed();
  backend_.upload(state);
}

void Pipeline::mark(HostState& state) const {
  state.time = time_;
  state.step = step_;
  static_cast<Carried&>(state) = carried_;
}

StepReport Pipeline::step(double time_left) {
  using Clock = std::chrono::steady_clock;
  const auto step_begin = Clock::now();
  milliseconds_.fill(0);
  const bool by_error = model_.scene.time.mode == TimeMode::error && model_.has_moving_liquid();
  const StoppableStep stoppable((by_error && stoppable_) || keep_for_stop());
  StepReport report;
  try {
    if (baked_) time_left = std::min(time_left, baked_->time_left(time_));
    report = by_error ? step_by_error(time_left) : attempt(time_left, std::numeric_limits<double>::infinity());
  } catch (const StepStopped&) {
    take_back();
    throw;
  }
  first_state_ = nullptr;
  std::int64_t& collapsing = carried_.collapsing;
  collapsing = report.density_error > collapse && !report.density_converged ? collapsing + 1 : 0;
  carried_.divergence_start = report.divergence_start;
  carried_.density_start = report.density_start;
  report.saturation_error = saturation_error(report);
  time_ += report.dt;
  ++step_;
  report.step = step_;
  report.time = time_;
  if (baked_ && baked_->begins(time_)) take_file();
  step_milliseconds_ = std::chrono::duration<double, std::milli>(Clock::now() - step_begin).count();
  return report;
}

bool Pipeline::keep_for_stop() {
  // A copy of the state costs less than a hundredth of such a step; after shorter ones an end is soon reached anyway.
  constexpr double long_step = 500;  // ms
  if (first_state_) return true;
  if (!stoppable_ || step_milliseconds_ < long_step) return false;
  try {
    backend_.keep();
  } catch (const std::exception&) {  // no memory: the step has to be waited for
    stoppable_ = false;
  }
  return stoppable_;
}

void Pipeline::take_back() {
  if (first_state_)
    backend_.upload(*first_state_);
  else
    backend_.go_back();
  looked_ = false;
}

StepReport Pipeline::step_by_error(double time_left) {
  const TimeScene& time = model_.scene.time;
  const double shortest = time.step / 100;
  double longest = carried_.next_step > 0 ? carried_.next_step : time.step;
  backend_.keep();
  for (int rejected = 0;; ++rejected) {
    double tried = 0;
    try {
      StepReport report = attempt(time_left, longest);
      tried = report.dt;
      const StepInfo after{step_ + 1, time_ + report.dt, report.dt};
      run(Stage::neighbors, after, report);
      run(Stage::density, after, report);
      looked_ = true;
      report.rejected = rejected;
      if (!is_too_long(report, time.tolerance) || tried <= shortest) {
        carried_.next_step =
            std::clamp(step_after(tried, longest, report, time.tolerance, model_.scene.fluid.solver.density_correction),
                       shortest, time.step);
        return report;
      }
    } catch (const RunFailure& failure) {  // a shorter step may not fail
      tried = failure.info.dt;
      if (failure.kind == FailureKind::mass || failure.kind == FailureKind::solute || tried <= shortest) throw;
    }
    backend_.go_back();
    looked_ = false;
    longest = std::max(shortest, 0.5 * tried);
  }
}

double Pipeline::saturation_error(const StepReport& r) {
  const double rate = static_cast<double>(r.mass_cloth - in_cloth_) / r.dt,
               change = std::abs(rate - carried_.uptake_rate);
  in_cloth_ = r.mass_cloth;
  carried_.uptake_rate = rate;
  return capacity_ > 0 && step_ > 0 ? 0.5 * r.dt * change * model_.quantum / capacity_ : 0;
}

bool Pipeline::have_looked(Stage stage) const {
  return looked_ && (stage == Stage::neighbors || stage == Stage::density);
}

void Pipeline::run(Stage stage, const StepInfo& info, StepReport& report) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  stop_if_requested();
  backend_.run(stage, info, report);
  if (profiling_) backend_.fence();
  milliseconds_[static_cast<std::size_t>(stage)] +=
      std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  // Caught here, the failure still has the name of its stage; the ledger alone would only say that it happened.
  if (const auto bad = nonfinite_number(report); !bad.empty())
    throw RunFailure(FailureKind::not_finite, stage, info, report, fmt::format("{} is not a finite number", bad));
}

StepReport Pipeline::attempt(double time_left, double longest) {
  StepReport report;
  StepInfo info{step_, time_, model_.scene.time.step};
  info.divergence_start = carried_.divergence_start;
  info.density_start = carried_.density_start;
  for (const Stage stage : stages_) {
    if (!have_looked(stage)) run(stage, info, report);
    if (stage == Stage::time_step) {
      if (!(report.dt_wanted > 0) || !std::isfinite(report.dt_wanted))
        throw RunFailure(FailureKind::time_step, stage, info, report,
                         fmt::format("the time step would be {} s", report.dt_wanted));
      const double wanted = std::min(report.dt_wanted, longest);
      info.dt = clip_step(wanted, time_left, model_.scene.time.mode);
      info.correction_share = std::min(1.0, 2 * info.dt / wanted);
      info.fluid_speed_limit = limits_.fluid_speed(time_ + info.dt);
    }
  }
  looked_ = false;
  report.dt = info.dt;
  check(info, report);
  return report;
}

void Pipeline::check(const StepInfo& info, const StepReport& r) {
  const auto fail = [&](FailureKind kind, Stage stage, const std::string& what, double limit = 0) {
    throw RunFailure(kind, stage, info, r, what, limit);
  };
  if (r.nonfinite > 0)
    fail(FailureKind::not_finite, Stage::ledger,
         fmt::format("{} particles, nodes or bodies are not finite numbers", r.nonfinite));
  if (const Quanta off = r.mass_total() - initial_total_; off != 0)
    fail(FailureKind::mass, Stage::ledger,
         fmt::format("the mass budget is off by {} mass units ({:.3e} kg)", off,
                     static_cast<double>(off) * model_.quantum));
  if (const Quanta off = r.solute_total() - initial_solute_; off != 0)
    fail(FailureKind::solute, Stage::ledger,
         fmt::format("the solute budget is off by {} mass units ({:.3e} kg)", off,
                     static_cast<double>(off) * model_.solute_quantum()));
  const double time = info.time + info.dt, fluid_limit = info.fluid_speed_limit;
  constexpr const char* too_fast = "{} at {:.3g} m/s; in this scene nothing can make it faster than {:.3g} m/s";
  if (r.fluid_speed > fluid_limit)
    fail(FailureKind::fluid_speed, Stage::ledger,
         fmt::format(fmt::runtime(too_fast), "the liquid moves", r.fluid_speed, fluid_limit), fluid_limit);
  if (r.escaped_speed > fluid_limit)
    fail(FailureKind::fluid_speed, Stage::advection,
         fmt::format(fmt::runtime(too_fast), "liquid left the domain", r.escaped_speed, fluid_limit) +
             fmt::format("; {} particles, ids {}", r.escaped.count, r.escaped.names()),
         fluid_limit);
  if (const double limit = limits_.cloth_stretch(time); r.cloth_stretch > limit)
    fail(FailureKind::cloth_stretch, Stage::ledger,
         fmt::format(
             "the cloth is stretched to {:.3g} times its length; in this scene nothing can stretch it beyond {:.3g}",
             r.cloth_stretch, limit),
         limit);
  if (const double limit = limits_.cloth_speed(time); r.cloth_speed > limit)
    fail(FailureKind::cloth_speed, Stage::ledger,
         fmt::format(fmt::runtime(too_fast), "the cloth moves", r.cloth_speed, limit), limit);
  if (carried_.collapsing + 1 >= collapse_steps && r.density_error > collapse && !r.density_converged)
    fail(FailureKind::density, Stage::pressure,
         fmt::format("the liquid collapses: its density is {:.0f} % too high on average, for {} steps in a row",
                     100 * r.density_error, carried_.collapsing + 1),
         collapse);
}

}  // namespace drench
