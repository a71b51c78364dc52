#pragma once
// How far two states that one stage made from identical input may be apart, and how far they are: for `drench compare`
// and for the tests of the stages alike.

#include <string>
#include <string_view>
#include <vector>

#include "pipeline/backend.hpp"

namespace drench {

/// What the backend's precision lets one expect.
struct Precision {
  double tolerance;  // 1: of a field's largest magnitude
  double rounding;   // 1: half the distance of neighbouring numbers at 1
  // Roundings of δ − 1 that the density solve may pass on to κ, and a quarter of them to velocities
  // (docs/manual/compare.md); 0: none.
  double solve_roundings = 0;
  double pair_rounding = 0;  // Backend::pair_rounding()
};

/// 1e-4 and 6e-8 for "float", 1e-10 and 1.1e-16 for "double" (base/version.hpp's precision_name).
Precision precision_named(std::string_view name);

/// Quanta of rounding that masses may differ by.
inline constexpr double mass_slack = 64;

/// The worst entry of one field or number.
struct FieldDifference {
  std::string field, unit;
  double absolute = 0;    // in `unit`; infinite where the sizes differ
  double largest = 0;     // the reference's largest magnitude
  double tolerance = 0;   // of `absolute`, in `unit`
  std::size_t index = 0;  // where it is
  std::size_t size = 0;   // the reference's
  std::size_t actual_size = 0;
  bool over() const { return !(absolute <= tolerance); }
  double relative() const { return largest > 0 ? absolute / largest : absolute; }
};

/// Every field of the state after `stage` with Δt = `dt` (s), by the tolerances of docs/manual/compare.md. What a
/// rounding may decide is to be left before (compare/decisions.hpp).
std::vector<FieldDifference> compare_fields(const Model& model, Stage stage, double dt, const HostState& expected,
                                            const HostState& actual, const Precision& precision);

/// What `stage` reports: Δt, errors of the solves (not their iterations), stages and sub-steps, ledger, measures.
/// Quanta and counts must be equal.
std::vector<FieldDifference> compare_reports(Stage stage, const StepReport& expected, const StepReport& actual,
                                             const Precision& precision);

/// Takes out of both states the particles that only one of them has and whose mass is within the tolerance of masses: a
/// particle that cloth has absorbed to the last quantum is gone, one with a quantum left is not.
void drop_unmatched_remainders(HostState& expected, HostState& actual, const Precision& precision);

/// The names of the fields that differ.
std::vector<std::string> changed_fields(const HostState& before, const HostState& after);

/// The lists that `stage` makes, as sets: one row a list, `absolute` is the number of pairs that only one of the two
/// has and that do not lie within rounding of the support radius; no tolerance. `state` is what both searched.
std::vector<FieldDifference> compare_lists(const Model& model, Stage stage, const HostState& state,
                                           const Backend& expected, const Backend& actual, const Precision& precision);

/// The names of all lists of Backend::neighbor_pairs.
std::vector<std::string> neighbor_list_names();

/// Pairs of list `name` that only one of the two has, each once.
struct ListDifference {
  std::vector<std::pair<Index, Index>> at_support;  // at the support radius to within rounding: either may be right
  std::vector<std::pair<Index, Index>> wrong;
  std::size_t pairs = 0;        // the reference's
  std::size_t clear_pairs = 0;  // of these not at the support radius
  std::size_t repeated = 0;     // that the backend names more than once
};
ListDifference compare_list(const std::string& name, const Model& model, const HostState& state,
                            const Backend& expected, const Backend& actual, const Precision& precision);

/// Uploads `before`, makes what earlier stages hand on beside the state (neighbour lists, α) and runs the stage.
void run_stage_from(Backend& backend, const Model& model, Stage stage, const HostState& before, const StepInfo& info,
                    StepReport& report);

}  // namespace drench
