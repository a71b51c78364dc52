#pragma once
// Looks at a run from outside after every step: what must hold whatever the scene is. It knows the laws and none of the
// solver's code: geometry and energies are computed here again, in double.

#include <array>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "validation.hpp"

namespace drench::test {

/// What a scene allows; the rest always holds.
struct Rules {
  /// No particle passes through a cloth. One excuse: it lies on a sheet of which the point under it passes that cloth,
  /// in one step, as cloth without self_collision may: between the two there is no place left.
  bool passage = true;
  /// May there be as many as the run itself tells of? `tunnelled`, and `clamped`: what a solid puts back goes no
  /// straight way.
  bool told_passages = false;
  /// May the run end with a failure that it explains?
  bool may_stop = false;
  bool bounded_saturation = true;  ///< false where `saturation_control: off` gives the bound up
  /// How far the energy may lie above what there was at the start and what came in since, in units of a tenth of
  /// lifting all that is there by a spacing and a thousandth of the motion at the start and from jets, and by what a
  /// symplectic step's energy sways in a field. Infinite: not watched, for what solids that move put in is not known
  /// from outside.
  double energy = 1;
  double capped_energy =
      1;  ///< the same from the step on in which a pressure solve ends at its cap, if more than `energy`
  /// Do springs count as energy? Contacts of cloth with itself act after the cloth's solve and stretch springs, which
  /// the next solves relax (docs/limitations.md): then the rest may not rise.
  bool springs = true;
  double fastest = std::numeric_limits<double>::infinity();  ///< m/s, of particles and nodes
};

/// Kinetic, potential and elastic energy, J: particles, wet nodes, springs, hinges, strain limits, floating bodies.
double mechanical_energy(const Model& m, const HostState& s);

/// How often the point that goes straight from `from` to `to` passes through the triangle, whose corners meanwhile go
/// straight from `a` to `b`; its boundary does not count.
int crossings(const Vec3& from, const Vec3& to, const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

class Watch {
 public:
  Watch(const Model& model, const HostState& start, const Rules& rules);
  /// What is wrong with a state that follows the last one by a step of `dt` s.
  std::vector<std::string> look(const HostState& now, double dt, const StepReport& report = {});

  double initial_energy() const { return initial_energy_; }
  double energy() const { return energy_; }           ///< J, at the last look
  double energy_excess() const { return excess_; }    ///< largest of energy over what it may be, in units of the slack
  double pin_work() const { return pin_work_; }       ///< J so far
  double largest_speed() const { return speed_; }     ///< m/s so far
  double largest_saturation() const { return wet_; }  ///< so far
  const Rules& rules() const { return rules_; }
  bool capped() const { return capped_; }              ///< did a pressure solve end at its cap?
  std::int64_t told() const { return told_; }          ///< passages that the run told of (Rules::passage)
  std::int64_t pinched() const { return pinched_; }    ///< passages that are excused (Rules::passage)
  std::int64_t absorbed() const { return absorbed_; }  ///< particles that went into cloth whole
  const HostState& last() const { return last_; }

 private:
  using Complaints = std::vector<std::string>;
  void look_at_numbers(const HostState& now, Complaints& wrong);
  void look_at_masses(const HostState& now, Complaints& wrong);
  void look_at_passage(const HostState& now, const StepReport& report, Complaints& wrong);
  void look_at_energy(const HostState& now, double dt, const StepReport& report, Complaints& wrong);

  const Model& model_;
  Rules rules_;
  HostState last_;
  std::vector<Quanta> most_liquid_;  // per node
  Quanta total_ = 0, solute_ = 0;
  double motion_ = 0, weight_ = 0, first_sway_ = -1;  // J, N and J of the slack; the last not known before a step
  double correction_ = 0;                             // J: motion that takes back what a solve may leave
  double initial_energy_ = 0, energy_ = 0, excess_ = 0, input_ = 0, pin_work_ = 0, speed_ = 0, wet_ = 0;
  std::int64_t absorbed_ = 0, pinched_ = 0, told_ = 0;
  bool capped_ = false;
};

/// A scene that is watched. `edit` changes the state that it starts from.
class WatchedRun {
 public:
  explicit WatchedRun(const std::string& yaml, const Rules& rules = {},
                      const std::function<void(const Model&, HostState&)>& edit = {});
  /// Steps, with a test failure for what is wrong and the end of the stepping with it. `each` is called after each
  /// step.
  void steps(int count, const std::function<void(const HostState&, const StepReport&)>& each = {});
  const HostState& state() const { return watch_->last(); }
  const Model& model() const { return run_.model(); }
  const Watch& watch() const { return *watch_; }
  SceneRun& run() { return run_; }
  const StepReport& report() const { return report_; }
  const std::string& stopped() const { return stopped_; }  ///< why it ended with a failure (Rules::may_stop)
  /// One line of what happened, for the tests' output.
  void print(const char* name) const;

 private:
  void go(int count, const std::function<void(const HostState&, const StepReport&)>& each);

  SceneRun run_;
  std::unique_ptr<Watch> watch_;
  StepReport report_;
  std::int64_t steps_ = 0, collisions_ = 0, clamped_ = 0;
  std::size_t most_particles_ = 0;
  std::string stopped_;
};

/// Leaves the first `count` particles.
void keep_particles(HostState& s, std::size_t count);
/// Fills all porous nodes to saturation × capacity.
void soak(const Model& m, HostState& s, double saturation);

}  // namespace drench::test
