#pragma once
// The parts of the module drench._core, a file each.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drench/drench.hpp"

namespace drench::python {

namespace nb = nanobind;

/// A scene with the text that it was read from, so that errors of the set-up name a line too.
struct LoadedScene {
  Scene scene;
  std::string text, path;
  std::vector<std::string> overrides;
  /// `file:line:column: key`, or less of it.
  std::string place_of(const std::string& key) const;
};

/// The runtime of the whole process, started by the first call. Python ends it when it exits.
/// DeviceError.
void start_runtime(int threads = 0);
/// Has it ended? Arrays of the backend that live on then must not be freed any more: the process takes them along.
bool runtime_has_ended();
/// Never frees it. It stays reachable, so that a search for leaks does not take it for one.
void keep_for_ever(std::shared_ptr<const void> memory);
/// Throws std::runtime_error if it has.
void require_runtime();
/// As long as it lives, its thread computes for `runs` runs. All that compute share the threads of loops. To be made
/// without Python's lock.
class Computing {
 public:
  explicit Computing(int runs = 1);
  ~Computing();
  Computing(const Computing&) = delete;
  Computing& operator=(const Computing&) = delete;

 private:
  int runs_;
  std::optional<OwnLoops> loops_;
};

/// A NumPy array that owns the values.
template <class T>
nb::object owned(std::vector<T>&& values) {
  auto* kept = new std::vector<T>(std::move(values));
  nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  if constexpr (std::is_arithmetic_v<T>) {
    return nb::cast(nb::ndarray<nb::numpy, T>(kept->data(), {kept->size()}, owner));
  } else {
    using Number = typename T::value_type;
    return nb::cast(nb::ndarray<nb::numpy, Number>(reinterpret_cast<Number*>(kept->data()),
                                                   {kept->size(), std::tuple_size_v<T>}, owner));
  }
}

/// The numbers of a step: a dict with the names of StepReport's members.
nb::dict to_dict(const StepReport& report);

/// The state of a run by the names of HostState's members: arrays of float64, int64 and uint8, and numbers.
nb::dict to_dict(HostState&& state);
/// Back. ValueError: an array of another type or shape, or a number that is missing. Arrays may be missing: empty.
HostState to_state(const nb::dict& state);

/// What was thrown, as the exception that a call would raise.
nb::object to_python(const std::exception_ptr& thrown);

void bind_errors(nb::module_& m);
void bind_runtime(nb::module_& m);
void bind_scene(nb::module_& m);
void bind_fields(nb::module_& m);
void bind_run(nb::module_& m);

/// A FieldView for Python. `now` is the generation that its run has come to, and outlives the run.
nb::object to_python(FieldView view, std::shared_ptr<const std::uint64_t> now);

}  // namespace drench::python
