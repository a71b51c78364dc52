#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "app/commands.hpp"
#include "app/set_up.hpp"
#include "base/version.hpp"
#include "compare/decisions.hpp"
#include "pipeline/pipeline.hpp"
#include "pipeline/runtime.hpp"
#include "scene/load.hpp"

namespace drench {
namespace {

constexpr int solver_iterations = 6;
constexpr int most_cloth_iterations = 100'000;  // of the reference's Jacobi method, which converges slowly

/// Two iterates are only comparable at the same iteration: both solve the liquid with as many, whatever their errors.
void fix_iterations(Scene& scene) {
  FluidSolverScene& fluid = scene.fluid.solver;
  fluid.min_iterations = fluid.max_iterations = std::min(fluid.max_iterations, solver_iterations);
}

/// A lattice has pairs at the support radius to the last bit, and counts of neighbours that rounding decides: every
/// particle starts a thousandth of a spacing from where it was, for the same seed always to the same side.
void leave_the_lattice(const Model& model, std::int64_t seed, HostState& state) {
  std::mt19937 random(static_cast<std::uint32_t>(seed));  // the same numbers everywhere
  for (Vec3& x : state.fluid_position)
    for (double& axis : x) axis += 1e-3 * model.spacing * (2.0 * random() / 4294967295.0 - 1);
}

/// A field's worst difference after one stage, over all steps.
struct Row {
  FieldDifference worst;
  std::int64_t step = 0;
};

class Comparison {
 public:
  Comparison(const CompareOptions& options, Model& model, Backend& backend, Backend& reference)
      : options_(options),
        model_(model),
        cloth_solver_(model.scene.cloth_solver),
        backend_(backend),
        reference_(reference),
        precision_(precision_named(precision_name)) {
    precision_.solve_roundings = 64;
    precision_.pair_rounding = backend.pair_rounding();
  }

  void step(HostState& state) {
    StepInfo info{state.step, state.time, model_.scene.time.step};
    StepReport expected_report, actual_report;
    for (const Stage stage : stages_for(model_)) {
      moved_ += leave_decisions(reference_, model_, stage, info, precision_, state);
      // To the last bit: both start from numbers that the backend can hold.
      backend_.upload(state);
      HostState rounded = backend_.download();
      rounded.step = state.step;
      rounded.time = state.time;
      state = std::move(rounded);
      // Within the density solve the cloth's iteration ends where rounding lets it, in float many lots before double,
      // and the liquid's next iteration begins from there: there the first lot satisfies it on both sides. Its law is
      // the same in each lot; where it comes to is stage cloth's, which keeps its tolerance.
      // Iterates of two methods differ; where they converge to do not, except in contact, which has many states within
      // a tolerance. Without bodies, both sides of stage cloth therefore converge to the tolerance of the comparison.
      model_.cloth_engine =
          stage == Stage::pressure || !model_.bodies.empty() ? ClothEngine::reference : ClothEngine::own;
      ClothSolverScene& solver = model_.scene.cloth_solver;
      solver = cloth_solver_;
      if (stage == Stage::pressure) {
        solver.tolerance = 1e9;
      } else if (model_.cloth_engine == ClothEngine::own) {
        solver.tolerance = std::min(solver.tolerance, precision_.tolerance);
        solver.max_iterations = std::max(solver.max_iterations, most_cloth_iterations);
      }
      run_stage_from(reference_, model_, stage, state, info, expected_report);
      run_stage_from(backend_, model_, stage, state, info, actual_report);
      HostState expected = reference_.download(), actual = backend_.download();
      // Rows for what the stage changes, and for whatever is over.
      const auto changed = changed_fields(state, expected);
      const std::set<std::string> names(changed.begin(), changed.end());
      const HostState next = expected;
      drop_unmatched_remainders(expected, actual, precision_);
      for (const auto& d : compare_fields(model_, stage, info.dt, expected, actual, precision_))
        add(stage, d, info.step, names.count(d.field) > 0);
      for (const auto& d : compare_reports(stage, expected_report, actual_report, precision_))
        add(stage, d, info.step, true);
      for (const auto& d : compare_lists(model_, stage, state, reference_, backend_, precision_))
        add(stage, d, info.step, true);
      if (stage == Stage::time_step) info.dt = expected_report.dt_wanted;
      const auto [step, time] = std::pair(state.step, state.time);
      state = next;
      state.step = step;
      state.time = time;
    }
    state.time += info.dt;
    ++state.step;
  }

  /// Returns how many fields are over their tolerance.
  int print() const {
    fmt::print("{:<17} {:<28} {:>12} {:>11} {:>12} {:>7} {:>9} {:>6}\n", "stage", "field", "absolute", "relative",
               "tolerance", "unit", "at", "step");
    int over = 0;
    for (const Stage stage : stages_for(model_)) {
      const auto rows = rows_.find(stage);
      if (rows == rows_.end()) continue;
      for (const auto& [name, row] : rows->second) {
        const FieldDifference& d = row.worst;
        std::string end = d.over() ? "  over" : "";
        if (d.size != d.actual_size) end += fmt::format(": {} entries, the reference has {}", d.actual_size, d.size);
        over += d.over() ? 1 : 0;
        fmt::print("{:<17} {:<28} {:>12.3g} {:>11.2g} {:>12.3g} {:>7} {:>9} {:>6}{}\n", name_of(stage), name,
                   d.absolute, d.relative(), d.tolerance, d.unit, d.index, row.step, end);
      }
    }
    return over;
  }

  /// How many particles and nodes lay where a rounding decides (compare/decisions.hpp).
  std::size_t moved() const { return moved_; }

  std::size_t fields() const {
    std::size_t n = 0;
    for (const auto& [stage, rows] : rows_) n += rows.size();
    return n;
  }

 private:
  void add(Stage stage, FieldDifference d, std::int64_t step, bool shown) {
    d.tolerance *= options_.tolerance_scale;
    // What a stage leaves alone differs by the rounding of the upload; that is not the stage's, and no row.
    if (!shown && !(d.absolute > d.tolerance && options_.tolerance_scale > 0)) return;
    auto& rows = rows_[stage];
    const auto at = rows.find(d.field);
    if (at == rows.end()) {
      rows.emplace(d.field, Row{d, step});
      return;
    }
    // The tolerance depends on the field's size in that step: the worst is the largest share of it.
    const auto share = [](const FieldDifference& f) {
      return f.tolerance > 0 ? f.absolute / f.tolerance : f.absolute > 0 ? INFINITY : 0.0;
    };
    const double now = share(d), before = share(at->second.worst);
    if (now > before || (now == before && d.absolute > at->second.worst.absolute)) at->second = Row{d, step};
  }

  const CompareOptions& options_;
  Model& model_;  // both backends refer to it
  ClothSolverScene cloth_solver_;
  Backend &backend_, &reference_;
  Precision precision_;
  std::size_t moved_ = 0;
  std::map<Stage, std::map<std::string, Row>> rows_;
};

}  // namespace

int compare_command(const CompareOptions& options) {
  const Scene scene = load_scene(options.scene, options.overrides);
  const Setup asked = build(scene, memory_budget());
  const BackendRuntime runtime(options.threads, true);
  HostState state = asked.state;
  if (options.after > 0) {
    const auto backend = make_kokkos_backend(asked.model);
    Pipeline pipeline(asked.model, *backend, asked.state);
    while (pipeline.step_index() < options.after) pipeline.step(INFINITY);
    state = backend->download();
    state.time = pipeline.time();
    state.step = pipeline.step_index();
  }
  Setup setup = asked;
  fix_iterations(setup.model.scene);
  leave_the_lattice(setup.model, options.seed, state);
  const auto backend = make_kokkos_backend(setup.model), reference = make_reference_backend(setup.model);
  fmt::print(
      "{}: backend ({} precision) against reference, {} steps from step {}, t = {:.6g} s\n"
      "Each stage starts from the reference's result of the previous stage, rounded to the precision of the backend; "
      "particles start up to 0.001 spacings off their lattice.\nPressure solves take {} iterations{}.\n",
      options.scene, precision_name, options.steps, state.step, state.time,
      setup.model.scene.fluid.solver.max_iterations,
      setup.model.has_fluid() && setup.model.has_moving_cloth()
          ? ", with 10 cloth iterations in each (stage cloth compares the whole cloth solve)"
          : "");
  Comparison comparison(options, setup.model, *backend, *reference);
  for (std::int64_t s = 0; s < options.steps; ++s) comparison.step(state);
  const int over = comparison.print();
  if (comparison.moved() > 0)
    fmt::print("particles or nodes were moved off discontinuities by a few rounding errors {} times\n",
               comparison.moved());
  if (over > 0)
    fmt::print("{} of {} fields exceed their tolerance\n", over, comparison.fields());
  else
    fmt::print("all {} fields are within their tolerance\n", comparison.fields());
  return over > 0 ? exit_failed : exit_done;
}

}  // namespace drench
