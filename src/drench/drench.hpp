#pragma once
// drench in other programs: a scene, from a file or made in code, and its run, step by step. This header and those that
// it includes are all that `cmake --install` puts into include/. examples/embed shows them in use; docs/api describes
// them.

#include <array>
#include <cstdint>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/types.hpp"
#include "parallel/communicator.hpp"
#include "pipeline/runtime.hpp"
#include "pipeline/step_report.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "setup/setup_error.hpp"
#include "state/field_view.hpp"
#include "state/host_state.hpp"

/// Water meeting porous cloth. All quantities are in SI units.
namespace drench {

/// A run of a scene on the backend of this build. A BackendRuntime must outlive it. Calls to one run come from one
/// thread at a time; different runs may compute in different threads at the same time.
class Simulation {
 public:
  /// Sets the scene up: its geometry, its samples, its arrays on the device. The scene is checked as a file would be.
  /// @throws SceneError for a value that a scene file may not have either
  /// @throws SetupError for a scene that cannot be set up, or does not fit in memory
  /// @throws DeviceError without a device
  /// @throws RanksError for ranks that were given different scenes
  /// @param ranks those that run the scene together, of join_ranks(), which must outlive it; null: one alone. Each of
  ///   them calls everything here, in the same order. state() has all of the liquid on rank 0, and the rank's own
  ///   elsewhere; fields() has the rank's own and, behind it, what it sees of others; save_checkpoint() writes on rank
  ///   0
  explicit Simulation(const Scene& scene, const Communicator* ranks = nullptr);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// One step.
  /// @param longest the step is not longer than this, s
  /// @returns what the step did: its length, iterations and errors of its solves, masses, speeds. Each is one number
  ///   for all of the scene; reading them costs nothing
  /// @throws std::invalid_argument unless `longest` is above 0
  /// @throws std::runtime_error when the run cannot go on; its text says why. The state is then that of half a step
  StepReport step(double longest = std::numeric_limits<double>::infinity());
  /// Steps until the run's time is `time`, s; none if it is there already, or past it. Throws as step() does.
  void run_until(double time);

  double time() const;         ///< s, simulated since the start
  std::int64_t steps() const;  ///< number of steps since the start

  /// Everything that changes, as it is now: arrays with an entry for each particle, cloth node, sample and body, in SI
  /// units but for masses (quanta). Particles are in the order of their ids. Each call copies it from the device.
  HostState state() const;
  /// The backend's own arrays, without a copy: each field that this scene needs. Waits until they are computed. Each
  /// step makes the views before it stale.
  std::vector<FieldView> fields() const;
  /// One of them.
  /// @throws std::out_of_range for a name that this scene has no field of
  FieldView field(std::string_view name) const;
  /// Rises with each step(), and with each call that replaces the state.
  std::uint64_t generation() const;
  /// Does the view show the run as it is now?
  bool is_current(const FieldView& view) const { return view.generation == generation(); }

  /// From now on the pins of an entry of `cloth.N.pin` move at this velocity, from where they are, and do not turn.
  /// @param cloth N, from 0
  /// @param pin the entry, from 0
  /// @param velocity m/s
  /// @throws std::invalid_argument for a cloth or an entry that there is not, an entry that holds no node, a number
  ///   that is not finite
  void set_pin_velocity(Index cloth, Index pin, const Vec3& velocity);
  /// The nodes that an entry of `cloth.N.pin` holds, as rows of the node fields. Throws as set_pin_velocity() does.
  std::vector<Index> pin_nodes(Index cloth, Index pin) const;
  /// A cloth's rows of the node fields: the first, and how many.
  /// @throws std::invalid_argument for a cloth that there is not
  std::pair<Index, Index> cloth_nodes(Index cloth) const;
  /// From now on a jet flows like this, and goes on from what it has let go.
  /// @param jet its number among the scene's jets, from 0
  /// @param velocity m/s; 0 closes the jet until another velocity opens it
  /// @param center m; without one it stays where it is
  /// @throws std::invalid_argument for a jet that there is not, one that moves (it can only be closed), or a number
  ///   that is not finite
  /// @throws SetupError for a centre outside the domain
  void set_jet(Index jet, const Vec3& velocity, const std::optional<Vec3>& center = std::nullopt);
  /// The number of a body of this name, from 0.
  /// @throws std::invalid_argument for a name that no body has
  Index body_named(std::string_view name) const;
  /// Where a body is and how it moves. Waits.
  /// @throws std::invalid_argument for a body that there is not
  BodyMotion body_motion(Index body) const;
  /// From now on a body with `commanded: true` moves at this velocity, m/s, and turns about its centre at this angular
  /// velocity, rad/s.
  /// @param body its number in the scene, from 0
  /// @throws std::invalid_argument for a body that there is not or that is not commanded, or a number that is not
  /// finite
  void set_body_velocity(Index body, const Vec3& velocity, const Vec3& angular_velocity = {0, 0, 0});
  /// From now on a body with `commanded: true` moves and turns steadily to a pose, and stays there.
  /// @param body its number in the scene, from 0
  /// @param position of its centre, m
  /// @param orientation a quaternion w x y z: how it is turned since the start
  /// @param duration after which it is there, s
  /// @throws std::invalid_argument for a body that there is not or that is not commanded, a number that is not finite,
  /// a
  ///   quaternion of length 0, or a duration that is not above 0
  void set_body_pose(Index body, const Vec3& position, const std::array<double, 4>& orientation, double duration);
  /// From now on a force, N, and a torque about the centre, N m, act on a dynamic body, until the next call.
  /// @throws std::invalid_argument for a body that there is not or that is not dynamic, or a number that is not finite
  void apply_wrench(Index body, const Vec3& force, const Vec3& torque = {0, 0, 0});
  /// From now on the motor of a hinge holds this speed, rad/s, with at most the torque that the scene gives it.
  /// @param joint its number in the scene, from 0
  /// @throws std::invalid_argument for a joint that there is not or that has no motor, or a number that is not finite
  void set_motor(Index joint, double speed);
  /// From now on nodes of a cloth move and turn with a body, starting from their current positions. Nodes that were
  /// attached to another body follow this one instead. Sets up the backend again, without reading the meshes.
  /// @param cloth N, from 0
  /// @param nodes numbered within the cloth, from 0
  /// @param body its number in the scene, from 0; one that the scene or commands move
  /// @throws std::invalid_argument for a cloth, node or body that there is not, a cloth that does not move, a body that
  ///   is dynamic or deforms, a node that a pin of the scene holds
  /// @throws std::logic_error for a run over ranks
  void attach(Index cloth, const std::vector<Index>& nodes, Index body);
  /// Frees nodes that are attached to a body by attach() or by `cloth.N.pin` with `body`.
  /// @throws as attach(), also for a node that is not attached
  void detach(Index cloth, const std::vector<Index>& nodes);
  /// The nodes that are attached to a body, as rows of the node fields.
  /// @throws std::invalid_argument for a body that there is not
  std::vector<Index> attached(Index body) const;
  /// What liquid, cloth and other bodies did to a body in the last step, as means over the step: without gravity, what
  /// apply_wrench() does, and what `self_collision` adds to the contact of cloth. 0 before the first step, and
  /// after one that failed. Waits.
  /// @param body its number in the scene, from 0; a body with `commanded: true`, or a dynamic one
  /// @throws std::invalid_argument for any other body
  BodyLoad body_load(Index body) const;
  /// From now on the air moves at this velocity, m/s, without gusts. Its density and the drags are the scene's.
  /// @throws std::invalid_argument for a number that is not finite
  void set_wind(const Vec3& velocity);

  /// Replaces the state. Added liquid and solute count as supplied, and removed liquid and solute as drained, so that
  /// the mass budget continues. Particles must be in the order of their ids, as in state(). New particles take their
  /// ids from HostState::next_id, which must then be increased. Arrays that this scene does not need are ignored.
  /// Bodies, pins, jets and wind still follow the scene and earlier commands.
  /// @throws std::invalid_argument naming the field, the row and what is allowed; the run is then as before
  /// @throws std::logic_error for a run over ranks
  void set_state(const HostState& state);
  /// The changes that programs made to bodies, pins, jets and wind, as numbers; empty without changes. Together with
  /// state(), this is all that a run of the same scene needs to continue bit for bit.
  std::vector<double> changes() const;
  /// Continues from the state() and changes() of a run of the same scene, as from a checkpoint: bit for bit.
  /// @throws std::invalid_argument as set_state() does; std::logic_error for a run over ranks or one being recorded
  void restore(const HostState& state, const std::vector<double>& changes = {});
  /// Returns to the start of the scene. The first call sets up the scene again and keeps the initial state; later calls
  /// only copy it.
  /// @throws std::logic_error for a run over ranks or one being recorded
  void reset();

  /// Writes what it takes to go on, bit for bit; with changed bodies, pins, jets and wind.
  /// @throws std::runtime_error when the disk refuses
  void save_checkpoint(const std::string& path) const;
  /// From now on writes the files of `drench run` to a folder, without checkpoints: scene.yaml, run.log, a row of
  /// stats.csv per step, and a frame of the current state. end_record() completes them.
  /// @param folder new or empty
  /// @param overwrite the folder may also contain a run, whose files are removed
  /// @throws std::runtime_error for another folder, and when a file cannot be written (here, in step() and below)
  /// @throws std::logic_error for a run that is being recorded already, or runs over ranks
  void record(const std::string& folder, bool overwrite = false);
  /// Adds a frame of the current state; does nothing if the run is not being recorded.
  void record_frame();
  /// Adds the last frame and writes the report.
  /// @returns the path of the report
  /// @throws std::logic_error if the run is not being recorded
  std::string end_record();
  /// Goes on from a checkpoint of the same scene, in place of where the run is.
  /// @param path a checkpoint, or a folder: its newest one that is whole
  /// @returns warnings, a line each
  /// @throws std::runtime_error for one that cannot be read, or is of another scene, precision, backend or version
  /// @throws std::logic_error while the run is being recorded
  std::vector<std::string> resume(const std::string& path);

  /// The scene, checked, as it was at the start.
  const Scene& scene() const;
  /// The pairs (name of the stage, milliseconds) of the last step, in order.
  std::vector<std::pair<std::string_view, double>> stage_milliseconds() const;

  /// Saturation of each cloth node of `state`, 1: liquid over what the node's pores hold, and 0 where the cloth is not
  /// porous. As long as HostState::node_position.
  std::vector<double> saturation(const HostState& state) const;
  /// What each cloth node's pores hold at saturation 1, kg; 0 where the cloth is not porous. As long as
  /// HostState::node_position.
  std::vector<double> node_capacity() const;
  /// Triangles of all cloths, each as the indices of its three nodes in HostState::node_position. The triangles of one
  /// cloth follow each other, and so do its nodes. They stay the same during a run.
  const std::vector<std::array<Index, 3>>& triangles() const;
  double quantum() const;         ///< kg; masses in HostState are multiples of it
  double solute_quantum() const;  ///< kg; of the solute in HostState; 0 in a scene without one
  /// The warnings that `drench check` prints for this scene, a line each.
  const std::vector<std::string>& warnings() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// What became of a step of one of several runs.
struct Stepped {
  StepReport report;         ///< of its step; empty if the run could not go on
  std::exception_ptr error;  ///< what Simulation::step() threw; null if it threw nothing
};
/// One step of each of several independent runs, side by side: each has the bits that it has alone. Every thread takes
/// the next run that waits, so that n runs on n cores take as long as one run on one core. On a GPU each run has a
/// stream of its own.
/// @param runs each of them once, none over ranks
/// @param longest for each run: its step is not longer than this, s
/// @param threads the number of runs that compute at a time; 0: runs_at_a_time()
/// @returns what became of each. Those that fail do not keep the others from their step
/// @throws std::invalid_argument for another number of `longest`, a length that is not above 0, or a run that is named
///   twice
std::vector<Stepped> step_together(const std::vector<Simulation*>& runs, const std::vector<double>& longest,
                                   int threads = 0);

}  // namespace drench
