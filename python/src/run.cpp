// A run of a scene. Python's lock is free while it computes; a second thread that calls it meanwhile gets an error.
// Runs of several threads compute at the same time.

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>
#include <vtkObject.h>

#include <atomic>
#include <filesystem>
#include <limits>

#include "module.hpp"
#include "report/report.hpp"

namespace drench::python {
namespace {

/// VTK's warnings come back as error codes, which the set-up reports in a line.
class QuietVtk {
 public:
  QuietVtk() { vtkObject::GlobalWarningDisplayOff(); }
  ~QuietVtk() { vtkObject::SetGlobalWarningDisplay(before_); }
  QuietVtk(const QuietVtk&) = delete;
  QuietVtk& operator=(const QuietVtk&) = delete;

 private:
  int before_ = vtkObject::GetGlobalWarningDisplay();
};

class Run {
  void note() {
    *generation_ = run_->generation();
    time_ = run_->time();
    steps_ = run_->steps();
  }

  /// Calls `work` without Python's lock, while no other thread is at this run.
  template <class Work>
  auto alone(Work&& work) {
    require_runtime();
    const Busy busy(*this);
    const nb::gil_scoped_release free;
    const Computing computing;
    return work();
  }
  /// The same for what makes views of the state stale.
  template <class Work>
  void replace(Work&& work) {
    if (!busy_) ++*generation_;
    alone(work);
  }
  /// No other thread is at this run.
  class Busy {
   public:
    explicit Busy(Run& run) : run_(run) {
      bool idle = false;
      if (!run_.busy_.compare_exchange_strong(idle, true))
        throw std::runtime_error("the run computes a step in another thread");
    }
    ~Busy() {
      run_.note();
      run_.busy_ = false;
    }
    Busy(const Busy&) = delete;
    Busy& operator=(const Busy&) = delete;

   private:
    Run& run_;
  };

 public:
  ~Run() {
    if (runtime_has_ended()) {
      keep_for_ever(std::move(run_));
      return;
    }
    const nb::gil_scoped_release free;
    const Computing computing;
    run_.reset();
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;
  explicit Run(const LoadedScene& scene) {
    start_runtime();
    const QuietVtk quiet;
    try {
      const nb::gil_scoped_release free;
      const Computing computing;
      run_ = std::make_unique<Simulation>(scene.scene);
    } catch (const SetupError& e) {
      throw SetupError(scene.place_of(e.key) + ": " + e.what(), e.key);
    }
    note();
  }

  nb::dict step(double longest) {
    if (!busy_) ++*generation_;  // whoever looks while it computes sees that the views are stale
    return to_dict(alone([&] { return run_->step(longest); }));
  }
  /// A step of each: its report, or the error that its step() would raise.
  static nb::list step_together(const std::vector<Run*>& runs, const std::vector<double>& longest) {
    require_runtime();
    std::vector<Stepped> results;
    {
      std::vector<std::unique_ptr<Busy>> busy;
      std::vector<Simulation*> simulations;
      for (Run* run : runs) {
        busy.push_back(std::make_unique<Busy>(*run));
        ++*run->generation_;
        simulations.push_back(run->run_.get());
      }
      const nb::gil_scoped_release free;
      const Computing computing(static_cast<int>(runs.size()));
      results = drench::step_together(simulations, longest);
    }
    nb::list list;
    for (const Stepped& result : results)
      list.append(result.error ? to_python(result.error) : nb::object(to_dict(result.report)));
    return list;
  }
  nb::object field(const std::string& name) {
    try {
      return to_python(alone([&] { return run_->field(name); }), generation_);
    } catch (const std::out_of_range& e) {
      PyErr_SetString(PyExc_KeyError, e.what());
      throw nb::python_error();
    }
  }
  nb::list fields() {
    nb::list list;
    for (FieldView& view : alone([&] { return run_->fields(); })) list.append(to_python(std::move(view), generation_));
    return list;
  }
  nb::dict state() {
    return to_dict(alone([&] { return run_->state(); }));
  }
  void set_state(const nb::dict& state) {
    const HostState given = to_state(state);
    replace([&] { run_->set_state(given); });
  }
  void restore(const nb::dict& state, const std::vector<double>& changes) {
    const HostState given = to_state(state);
    replace([&] { run_->restore(given, changes); });
  }
  void reset() {
    replace([&] { run_->reset(); });
  }
  std::vector<double> changes() {
    return alone([&] { return run_->changes(); });
  }
  nb::object node_capacity() { return owned(std::vector<double>(run_->node_capacity())); }
  std::pair<Index, Index> cloth_nodes(Index cloth) {
    return alone([&] { return run_->cloth_nodes(cloth); });
  }
  nb::object pin_nodes(Index cloth, Index pin) {
    return owned(alone([&] { return run_->pin_nodes(cloth, pin); }));
  }
  nb::object saturation() {
    return owned(alone([&] { return run_->saturation(run_->state()); }));
  }
  nb::object triangles() { return owned(std::vector<std::array<Index, 3>>(run_->triangles())); }
  void set_pin_velocity(Index cloth, Index pin, const Vec3& velocity) {
    alone([&] { run_->set_pin_velocity(cloth, pin, velocity); });
  }
  std::vector<std::string> body_names() const {
    std::vector<std::string> names;
    for (const BodyScene& body : run_->scene().bodies) names.push_back(body.name);
    return names;
  }
  /// Position, velocity and angular velocity; orientation.
  std::pair<std::array<Vec3, 3>, std::array<double, 4>> body_motion(Index body) {
    const BodyMotion m = alone([&] { return run_->body_motion(body); });
    return {{m.position, m.velocity, m.angular_velocity}, m.orientation};
  }
  void set_body_velocity(Index body, const Vec3& velocity, const Vec3& angular_velocity) {
    alone([&] { run_->set_body_velocity(body, velocity, angular_velocity); });
  }
  void set_body_pose(Index body, const Vec3& position, const std::array<double, 4>& orientation, double duration) {
    alone([&] { run_->set_body_pose(body, position, orientation, duration); });
  }
  void apply_wrench(Index body, const Vec3& force, const Vec3& torque) {
    alone([&] { run_->apply_wrench(body, force, torque); });
  }
  /// Forces and torques of the liquid, of cloth, of attached nodes, and of other bodies.
  std::array<Vec3, 8> body_load(Index body) {
    const BodyLoad load = alone([&] { return run_->body_load(body); });
    return {load.liquid_force,   load.liquid_torque,   load.cloth_force,   load.cloth_torque,
            load.attached_force, load.attached_torque, load.contact_force, load.contact_torque};
  }
  void attach(Index cloth, const std::vector<Index>& nodes, Index body) {
    replace([&] { run_->attach(cloth, nodes, body); });
  }
  void detach(Index cloth, const std::vector<Index>& nodes) {
    replace([&] { run_->detach(cloth, nodes); });
  }
  nb::object attached(Index body) {
    return owned(alone([&] { return run_->attached(body); }));
  }
  void set_jet(Index jet, const Vec3& velocity, const std::optional<Vec3>& center) {
    alone([&] { run_->set_jet(jet, velocity, center); });
  }
  void set_motor(Index joint, double speed) {
    alone([&] { run_->set_motor(joint, speed); });
  }
  void set_wind(const Vec3& velocity) {
    alone([&] { run_->set_wind(velocity); });
  }
  void save_checkpoint(const std::string& path) {
    alone([&] { run_->save_checkpoint(path); });
  }
  void record(const std::string& folder, bool overwrite) {
    alone([&] { run_->record(folder, overwrite); });
  }
  void record_frame() {
    alone([&] { run_->record_frame(); });
  }
  std::string end_record() {
    return alone([&] { return run_->end_record(); });
  }
  std::vector<std::string> resume(const std::string& path) {
    return alone([&] { return run_->resume(path); });
  }
  double time() const { return time_; }
  std::int64_t steps() const { return steps_; }
  double quantum() const { return run_->quantum(); }
  double solute_quantum() const { return run_->solute_quantum(); }
  std::uint64_t generation() const { return *generation_; }
  std::vector<std::string> warnings() const { return run_->warnings(); }
  nb::dict stage_milliseconds() {
    nb::dict d;
    for (const auto& [name, ms] : run_->stage_milliseconds()) d[nb::str(name.data(), name.size())] = ms;
    return d;
  }

 private:
  std::unique_ptr<Simulation> run_;
  std::shared_ptr<std::uint64_t> generation_ = std::make_shared<std::uint64_t>(0);
  std::atomic<bool> busy_{false};
  // as the last call left them: other threads may ask meanwhile
  double time_ = 0;
  std::int64_t steps_ = 0;
};

void report_of(const std::string& folder, const std::string& file, const std::optional<std::string>& other) {
  const nb::gil_scoped_release free;
  const QuietVtk quiet;
  write_report(folder, other ? std::optional<std::filesystem::path>(*other) : std::nullopt, file);
}

void picture_of(const std::string& folder, const std::string& file, int width, int height) {
  const nb::gil_scoped_release free;
  const QuietVtk quiet;
  write_picture(folder, file, width, height);
}

}  // namespace

void bind_run(nb::module_& m) {
  nb::class_<Run>(m, "Run", "A run of a scene, step by step.")
      .def(nb::init<const LoadedScene&>(), nb::arg("scene"))
      .def("step", &Run::step, nb::arg("longest") = std::numeric_limits<double>::infinity())
      .def("field", &Run::field, nb::arg("name"), nb::sig("def field(self, name: str) -> Field"))
      .def("fields", &Run::fields, nb::sig("def fields(self) -> list[Field]"))
      .def("state", &Run::state, nb::sig("def state(self) -> dict[str, typing.Any]"))
      .def("set_state", &Run::set_state, nb::arg("state"),
           nb::sig("def set_state(self, state: dict[str, typing.Any]) -> None"))
      .def("restore", &Run::restore, nb::arg("state"), nb::arg("changes"),
           nb::sig("def restore(self, state: dict[str, typing.Any], changes: typing.Sequence[float]) -> None"))
      .def("reset", &Run::reset)
      .def("changes", &Run::changes)
      .def("node_capacity", &Run::node_capacity,
           nb::sig("def node_capacity(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def("saturation", &Run::saturation, nb::sig("def saturation(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def("triangles", &Run::triangles, nb::sig("def triangles(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def("cloth_nodes", &Run::cloth_nodes, nb::arg("cloth"))
      .def("pin_nodes", &Run::pin_nodes, nb::arg("cloth"), nb::arg("pin"),
           nb::sig("def pin_nodes(self, cloth: int, pin: int) -> numpy.typing.NDArray[numpy.int32]"))
      .def("set_pin_velocity", &Run::set_pin_velocity, nb::arg("cloth"), nb::arg("pin"), nb::arg("velocity"))
      .def_prop_ro("body_names", &Run::body_names)
      .def("body_motion", &Run::body_motion, nb::arg("body"))
      .def("set_body_velocity", &Run::set_body_velocity, nb::arg("body"), nb::arg("velocity"),
           nb::arg("angular_velocity"))
      .def("set_body_pose", &Run::set_body_pose, nb::arg("body"), nb::arg("position"), nb::arg("orientation"),
           nb::arg("duration"))
      .def("apply_wrench", &Run::apply_wrench, nb::arg("body"), nb::arg("force"), nb::arg("torque"))
      .def("body_load", &Run::body_load, nb::arg("body"))
      .def("attach", &Run::attach, nb::arg("cloth"), nb::arg("nodes"), nb::arg("body"))
      .def("detach", &Run::detach, nb::arg("cloth"), nb::arg("nodes"))
      .def("attached", &Run::attached, nb::arg("body"),
           nb::sig("def attached(self, body: int) -> numpy.typing.NDArray[numpy.int32]"))
      .def("set_jet", &Run::set_jet, nb::arg("jet"), nb::arg("velocity"), nb::arg("center") = nb::none())
      .def("set_motor", &Run::set_motor, nb::arg("joint"), nb::arg("speed"))
      .def("set_wind", &Run::set_wind, nb::arg("velocity"))
      .def("save_checkpoint", &Run::save_checkpoint, nb::arg("path"))
      .def("record", &Run::record, nb::arg("folder"), nb::arg("overwrite"))
      .def("record_frame", &Run::record_frame)
      .def("end_record", &Run::end_record)
      .def("resume", &Run::resume, nb::arg("path"))
      .def("stage_milliseconds", &Run::stage_milliseconds)
      .def_prop_ro("time", &Run::time)
      .def_prop_ro("steps", &Run::steps)
      .def_prop_ro("quantum", &Run::quantum)
      .def_prop_ro("solute_quantum", &Run::solute_quantum)
      .def_prop_ro("generation", &Run::generation)
      .def_prop_ro("warnings", &Run::warnings);
  m.def("step_together", &Run::step_together, nb::arg("runs"), nb::arg("longest"),
        nb::sig("def step_together(runs: typing.Sequence[Run], longest: typing.Sequence[float]) -> list[typing.Any]"));
  m.def("write_report", &report_of, nb::arg("folder"), nb::arg("file"), nb::arg("other") = nb::none());
  m.def("write_picture", &picture_of, nb::arg("folder"), nb::arg("file"), nb::arg("width"), nb::arg("height"));
}

}  // namespace drench::python
