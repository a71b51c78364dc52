// The library's errors as Python's, with the library's own text.

#include "module.hpp"
#include "output/checkpoint.hpp"
#include "output/run_folder.hpp"
#include "pipeline/failure.hpp"

namespace drench::python {
namespace {

/// The classes live as long as the process.
PyObject *base, *scene_error, *setup_error, *device_error, *run_failure, *checkpoint_error;

PyObject* new_class(nb::module_& m, const char* name, const char* doc, nb::handle bases) {
  PyObject* made = PyErr_NewExceptionWithDoc((std::string("drench._core.") + name).c_str(), doc, bases.ptr(), nullptr);
  if (made == nullptr) throw nb::python_error();
  m.attr(name) = nb::handle(made);
  return made;
}

const char* name_of(FailureKind kind) {
  switch (kind) {
    case FailureKind::not_finite:
      return "not_finite";
    case FailureKind::time_step:
      return "time_step";
    case FailureKind::sub_steps:
      return "sub_steps";
    case FailureKind::mass:
      return "mass";
    case FailureKind::solute:
      return "solute";
    case FailureKind::fluid_speed:
      return "fluid_speed";
    case FailureKind::cloth_speed:
      return "cloth_speed";
    case FailureKind::cloth_stretch:
      return "cloth_stretch";
    case FailureKind::density:
      return "density";
  }
  return "";
}

void raise(const RunFailure& failure) {
  const std::string_view stage = drench::name_of(failure.stage);
  nb::object error = nb::handle(run_failure)(nb::str(failure.what()));
  error.attr("kind") = name_of(failure.kind);
  error.attr("stage") = nb::str(stage.data(), stage.size());
  error.attr("step") = failure.info.step;
  error.attr("time") = failure.info.time;
  error.attr("limit") = failure.limit;
  error.attr("report") = to_dict(failure.report);
  PyErr_SetObject(run_failure, error.ptr());
}

void translate(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const SceneError& e) {
    PyErr_SetString(scene_error, e.what());
  } catch (const SetupError& e) {
    PyErr_SetString(setup_error, e.what());
  } catch (const DeviceError& e) {
    PyErr_SetString(device_error, e.what());
  } catch (const CheckpointError& e) {
    PyErr_SetString(checkpoint_error, e.what());
  } catch (const FolderError& e) {
    PyErr_SetString(base, e.what());
  } catch (const RunFailure& e) {
    raise(e);
  }
}

}  // namespace

nb::object to_python(const std::exception_ptr& thrown) {
  try {
    translate(thrown, nullptr);
  } catch (const std::invalid_argument& e) {
    PyErr_SetString(PyExc_ValueError, e.what());
  } catch (const std::exception& e) {
    PyErr_SetString(PyExc_RuntimeError, e.what());
  }
  const nb::python_error error;  // takes what was set
  return nb::borrow(error.value());
}

void bind_errors(nb::module_& m) {
  base = new_class(m, "Error", "Base of all errors of drench.", PyExc_RuntimeError);
  const nb::tuple of_value = nb::make_tuple(nb::handle(base), nb::handle(PyExc_ValueError));
  scene_error = new_class(m, "SceneError", "A scene that cannot be used: its file, line, column and key.", of_value);
  setup_error =
      new_class(m, "SetupError", "A scene that reads well but cannot be set up, or does not fit in memory.", of_value);
  device_error = new_class(m, "DeviceError", "There is no device for this build.", base);
  checkpoint_error = new_class(m, "CheckpointError", "A checkpoint that this run cannot go on from.", base);
  run_failure =
      new_class(m, "RunFailure",
                "A run that cannot go on. It has the attributes kind, stage, step, time (s), limit, and report: the "
                "numbers of the stages up to that one.",
                base);
  nb::register_exception_translator(translate);
}

}  // namespace drench::python
