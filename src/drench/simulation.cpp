#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <tuple>

#include "app/resume.hpp"
#include "app/set_up.hpp"
#include "base/eigen_vec.hpp"
#include "base/version.hpp"
#include "drench/drench.hpp"
#include "drench/given_state.hpp"
#include "drench/prescribed.hpp"
#include "drench/recorder.hpp"
#include "pipeline/pipeline.hpp"
#include "state/saturation.hpp"

namespace drench {

namespace {

/// A scene that was made in code, checked as if it had come from a file. Its resolved form says all of it.
Scene checked(const Scene& scene) {
  Scene same = parse_scene(to_yaml(scene), scene.path.empty() ? "scene" : scene.path);
  same.path = scene.path;
  return same;
}

/// Whatever happens, the recorder is gone afterwards.
struct Ended {
  std::optional<Recorder>& recorder;
  ~Ended() { recorder.reset(); }
};

/// A field of vectors on the host.
std::vector<Vec3> vectors_of(const FieldView& view) {
  std::vector<Vec3> vectors(static_cast<std::size_t>(view.rows));
  if (view.type == FieldView::Type::float64) {
    copy_to_host(view, vectors.data());
    return vectors;
  }
  std::vector<std::array<float, 3>> rows(vectors.size());
  copy_to_host(view, rows.data());
  for (std::size_t i = 0; i < rows.size(); ++i) std::copy(rows[i].begin(), rows[i].end(), vectors[i].begin());
  return vectors;
}

MemoryBudget budget_of(const Scene& scene, const Communicator* ranks) {
  if (!ranks) return memory_budget();
  if (scene.fluid.is_baked()) throw RanksError("liquid of a sequence of files runs on one rank");
  return memory_budget_of_rank(memory_budget(), share_of_rank(scene, ranks->size()));
}

/// VTK's readers and the libraries behind them are not known to be safe in several threads.
Setup set_up_alone(const Scene& scene, const Communicator* ranks) {
  static std::mutex one;
  const std::scoped_lock alone(one);
  return build(scene, budget_of(scene, ranks));
}

}  // namespace

struct Simulation::Parts {
  Parts(const Scene& given, const Communicator* communicator)
      : ranks(communicator),
        scene(checked(given)),
        setup(set_up_alone(scene, communicator)),
        at_start(prescribed_of(setup.model)),
        backend(make_kokkos_backend_on(ranks, setup.model)),
        pipeline(std::make_unique<Pipeline>(setup.model, *backend, setup.state)),
        geometry(geometry_of(setup.model)),
        pinned(setup.model.mesh.pinned) {
    setup.state = HostState();  // the backend has it
    if (ranks)
      require_agreement(*ranks,
                        {{"version", fmt::format("{} {}", version_string, git_commit)}, {"scene", to_yaml(scene)}});
  }
  /// Changes the model by `change`, and tells those that it concerns; all or nothing.
  template <class Change>
  void change_model(Change&& change) {
    const Prescribed before = prescribed_of(setup.model);
    try {
      change(setup.model);
    } catch (...) {
      prescribe(setup.model, before);
      throw;
    }
    changed = true;
    pipeline->model_changed();
  }

  /// Continues from `changes` and `state`, which `find` brings while the model is as the scene prescribes it; all or
  /// nothing.
  template <class Find>
  void go_on_from(Find&& find) {
    Model& model = setup.model;
    const Prescribed before = prescribed_of(model);
    try {
      prescribe(model, at_start);
      const auto& [state, changes] = find();
      if (!changes.empty()) take_numbers(model, changes);
      ++generation;
      last_dt = 0;
      upload(state);
      changed = !changes.empty();
    } catch (...) {
      prescribe(model, before);
      throw;
    }
  }
  /// Continues from a state of the model as it is now. Which nodes are pinned is built into a backend: another one
  /// takes its place if they have changed.
  void upload(const HostState& state) {
    if (setup.model.mesh.pinned == pinned) return pipeline->go_on_from(state);
    std::unique_ptr<Backend> next = make_kokkos_backend_on(ranks, setup.model);
    pipeline = std::make_unique<Pipeline>(setup.model, *next, state);
    backend = std::move(next);
    if (recorder) recorder->use(*backend, *pipeline);
    pinned = setup.model.mesh.pinned;
  }
  /// Attaches or detaches nodes by `change`, which gets the state; all or nothing.
  template <class Change>
  void change_attachments(Change&& change) {
    HostState state = backend->download();
    pipeline->mark(state);
    change_model([&](Model& model) {
      change(model, state);
      upload(state);
    });
    ++generation;
    last_dt = 0;
  }
  /// States are replaced as a whole, which a rank does not have.
  void require_one_rank(std::string_view call) const {
    if (ranks) throw std::logic_error(fmt::format("Simulation::{}: not possible in a run over ranks", call));
  }
  void require_no_recorder(std::string_view call) const {
    if (recorder)
      throw std::logic_error(fmt::format("Simulation::{}: the run is being recorded; end_record() first", call));
  }

  const Communicator* ranks;
  Scene scene;
  Setup setup;
  Prescribed at_start;
  std::unique_ptr<Backend> backend;
  std::unique_ptr<Pipeline> pipeline;
  std::uint64_t geometry;            // as the scene has it
  std::vector<std::uint8_t> pinned;  // that the backend was made with
  std::uint64_t generation = 1;
  double last_dt = 0;                // s
  bool changed = false;              // from what the scene prescribes
  std::optional<HostState> initial;  // once a program has asked for it
  std::optional<Recorder> recorder;
};

Simulation::Simulation(const Scene& scene, const Communicator* ranks) : parts_(std::make_unique<Parts>(scene, ranks)) {}
Simulation::~Simulation() = default;

StepReport Simulation::step(double longest) {
  if (!(longest > 0)) throw std::invalid_argument("Simulation::step: a step has to be longer than 0 s");
  ++parts_->generation;  // also of a step that fails
  parts_->last_dt = 0;
  try {
    const StepReport report = parts_->pipeline->step(longest);
    parts_->last_dt = report.dt;
    if (parts_->recorder) parts_->recorder->step(report);
    return report;
  } catch (const RunFailure& failure) {
    if (parts_->recorder) parts_->recorder->failed(failure);
    throw;
  }
}

void Simulation::run_until(double time) {
  const double rounding = 1e-6 * parts_->setup.model.scene.time.step;
  while (this->time() < time - rounding) step(time - this->time());
}

double Simulation::time() const { return parts_->pipeline->time(); }
std::int64_t Simulation::steps() const { return parts_->pipeline->step_index(); }

HostState Simulation::state() const {
  HostState state = parts_->backend->download();
  parts_->pipeline->mark(state);
  return state;
}

std::vector<FieldView> Simulation::fields() const {
  std::vector<FieldView> views = parts_->backend->fields();
  for (FieldView& view : views) view.generation = parts_->generation;
  return views;
}

FieldView Simulation::field(std::string_view name) const {
  std::string names;
  for (FieldView& view : fields()) {
    if (view.name == name) return view;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", view.name);
  }
  throw std::out_of_range(fmt::format("this scene has no field {}; it has {}", name, names));
}

std::uint64_t Simulation::generation() const { return parts_->generation; }

void Simulation::set_pin_velocity(Index cloth, Index pin, const Vec3& velocity) {
  parts_->change_model([&](Model& model) { change_pin_velocity(model, cloth, pin, velocity, time()); });
}

std::vector<Index> Simulation::pin_nodes(Index cloth, Index pin) const {
  return nodes_of_pin(parts_->setup.model, cloth, pin);
}

std::pair<Index, Index> Simulation::cloth_nodes(Index cloth) const {
  const ClothMaterial& range = cloth_numbered(parts_->setup.model, cloth);
  return {range.first_node, range.node_count};
}

Index Simulation::body_named(std::string_view name) const {
  const std::vector<Body>& bodies = parts_->setup.model.bodies;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (!name.empty() && bodies[b].name == name) return static_cast<Index>(b);
  std::string names;
  for (const Body& b : bodies)
    if (!b.name.empty()) names += (names.empty() ? "" : ", ") + b.name;
  throw std::invalid_argument(fmt::format("there is no body named '{}'; the names are: {}", name,
                                          names.empty() ? "none (bodies.N.name)" : names));
}

BodyMotion Simulation::body_motion(Index body) const {
  body_numbered(parts_->setup.model, body);
  const HostState s = parts_->backend->body_states();
  const auto b = static_cast<std::size_t>(body);
  return {s.body_position[b], s.body_orientation[b], s.body_velocity[b], s.body_angular_velocity[b]};
}

void Simulation::set_body_velocity(Index body, const Vec3& velocity, const Vec3& angular_velocity) {
  parts_->change_model([&](Model& model) { change_body_velocity(model, body, velocity, angular_velocity, time()); });
}

void Simulation::set_body_pose(Index body, const Vec3& position, const std::array<double, 4>& orientation,
                               double duration) {
  parts_->change_model([&](Model& model) { change_body_pose(model, body, position, orientation, duration, time()); });
}

void Simulation::apply_wrench(Index body, const Vec3& force, const Vec3& torque) {
  parts_->change_model([&](Model& model) { change_wrench(model, body, force, torque); });
}

void Simulation::attach(Index cloth, const std::vector<Index>& nodes, Index body) {
  parts_->require_one_rank("attach");
  parts_->change_attachments([&](Model& model, const HostState& state) {
    attach_nodes(model, cloth, nodes, body, state.node_position, time());
  });
}

void Simulation::detach(Index cloth, const std::vector<Index>& nodes) {
  parts_->require_one_rank("detach");
  parts_->change_attachments([&](Model& model, const HostState&) { detach_nodes(model, cloth, nodes); });
}

std::vector<Index> Simulation::attached(Index body) const {
  body_numbered(parts_->setup.model, body);
  return attached_nodes(parts_->setup.model, body);
}

BodyLoad Simulation::body_load(Index body) const {
  if (!body_numbered(parts_->setup.model, body).is_measured())
    throw std::invalid_argument(fmt::format(
        "what acts on body {} is not measured; allowed: bodies with commanded: true, dynamic: true or a probe", body));
  BodyLoad load = parts_->backend->body_loads(parts_->last_dt)[static_cast<std::size_t>(body)].value();
  const std::vector<Index> nodes = attached_nodes(parts_->setup.model, body);
  if (nodes.empty() || !(parts_->last_dt > 0)) return load;
  const std::vector<Vec3> pin_force = vectors_of(field("node_pin_force")),
                          position = vectors_of(field("node_position"));
  const Eigen::Vector3d center = to_eigen(body_motion(body).position);
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  for (const Index n : nodes) {
    const Eigen::Vector3d f = -to_eigen(pin_force[static_cast<std::size_t>(n)]);
    force += f;
    torque += (to_eigen(position[static_cast<std::size_t>(n)]) - center).cross(f);
  }
  load.attached_force = to_vec3(force);
  load.attached_torque = to_vec3(torque);
  return load;
}

void Simulation::set_jet(Index jet, const Vec3& velocity, const std::optional<Vec3>& center) {
  parts_->change_model([&](Model& model) { change_jet(model, jet, velocity, center, time()); });
}

void Simulation::set_motor(Index joint, double speed) {
  parts_->change_model([&](Model& model) { change_motor(model, joint, speed); });
}

void Simulation::set_wind(const Vec3& velocity) {
  parts_->change_model([&](Model& model) { change_wind(model, velocity); });
}

void Simulation::save_checkpoint(const std::string& path) const {
  Checkpoint checkpoint = checkpoint_header(parts_->setup.model, *parts_->backend);
  checkpoint.scene = to_yaml(parts_->scene);
  checkpoint.geometry = parts_->geometry;
  checkpoint.changes = changes();
  checkpoint.state = state();
  if (!parts_->ranks || parts_->ranks->rank() == 0) write_checkpoint(path, checkpoint);
}

void Simulation::record(const std::string& folder, bool overwrite) {
  if (parts_->ranks) throw std::logic_error("Simulation::record: a run over ranks cannot be recorded");
  if (parts_->recorder) throw std::logic_error("Simulation::record: the run is being recorded already");
  parts_->recorder.emplace(folder, overwrite, parts_->setup.model, *parts_->backend, *parts_->pipeline,
                           parts_->setup.warnings);
}

void Simulation::record_frame() {
  if (parts_->recorder) parts_->recorder->frame();
}

std::string Simulation::end_record() {
  if (!parts_->recorder) throw std::logic_error("Simulation::end_record: the run is not being recorded");
  const Ended at_the_end{parts_->recorder};
  return parts_->recorder->finish().string();
}

void Simulation::set_state(const HostState& state) {
  parts_->require_one_rank("set_state");
  const HostState before = this->state();
  HostState next = checked_state(parts_->setup.model, state);
  parts_->pipeline->mark(next);
  require_prescribed_motion(parts_->setup.model, next, before);
  require_possible(parts_->setup.model, next, before);
  continue_budget(next, before);
  double& fastest = parts_->setup.model.fastest_before;
  if (const double given = fastest_of(next); given > fastest) {  // what a program wants is not a run that diverges
    fastest = given;
    parts_->changed = true;
  }
  ++parts_->generation;
  parts_->pipeline->go_on_from(next);
}

std::vector<double> Simulation::changes() const {
  return parts_->changed ? to_numbers(parts_->setup.model) : std::vector<double>();
}

void Simulation::restore(const HostState& state, const std::vector<double>& changes) {
  parts_->require_one_rank("restore");
  parts_->require_no_recorder("restore");
  const HostState next = checked_state(parts_->setup.model, state);
  parts_->go_on_from([&] { return std::tie(next, changes); });
}

void Simulation::reset() {
  parts_->require_one_rank("reset");
  parts_->require_no_recorder("reset");
  if (!parts_->initial) parts_->initial = set_up_alone(parts_->scene, nullptr).state;
  const std::vector<double> no_changes;
  parts_->go_on_from([&] { return std::tie(*parts_->initial, no_changes); });
}

std::vector<std::string> Simulation::resume(const std::string& path) {
  parts_->require_no_recorder("resume");
  Resume found;
  try {
    parts_->go_on_from([&] {
      found = find_checkpoint(path, parts_->setup.model, *parts_->backend, For::library);
      return std::tie(found.checkpoint.state, found.checkpoint.changes);
    });
  } catch (const std::invalid_argument& e) {
    throw CheckpointError(fmt::format("{}: {}", path, e.what()));
  }
  return found.warnings;
}

const Scene& Simulation::scene() const { return parts_->scene; }

std::vector<std::pair<std::string_view, double>> Simulation::stage_milliseconds() const {
  std::vector<std::pair<std::string_view, double>> times;
  for (const Stage stage : parts_->pipeline->stages())
    times.emplace_back(name_of(stage), parts_->pipeline->milliseconds()[static_cast<std::size_t>(stage)]);
  return times;
}

std::vector<double> Simulation::saturation(const HostState& state) const {
  return node_saturation(parts_->setup.model, state);
}

std::vector<double> Simulation::node_capacity() const {
  std::vector<double> capacity = parts_->setup.model.samples.node_capacity;
  capacity.resize(parts_->setup.model.mesh.rest_position.size(), 0.0);
  return capacity;
}

const std::vector<std::array<Index, 3>>& Simulation::triangles() const { return parts_->setup.model.mesh.triangle; }
double Simulation::solute_quantum() const { return parts_->setup.model.solute_quantum(); }
double Simulation::quantum() const { return parts_->setup.model.quantum; }
const std::vector<std::string>& Simulation::warnings() const { return parts_->setup.warnings; }

}  // namespace drench
