// Views of the backend's arrays: NumPy arrays on a host, DLPack on a GPU, both without a copy.

#include <nanobind/ndarray.h>
#include <nanobind/stl/string_view.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "module.hpp"

namespace drench::python {
namespace {

/// A view, and how far its run has come since.
struct Field {
  FieldView view;
  std::shared_ptr<const std::uint64_t> now;
  bool current() const { return view.generation == *now; }
};

PyObject* stale_view;

void require_current(const Field& field) {
  if (field.current()) return;
  const std::string text = "the view of " + std::string(field.view.name) +
                           " is stale: the run has gone on since; take fields[\"" + std::string(field.view.name) +
                           "\"] again";
  PyErr_SetString(stale_view, text.c_str());
  throw nb::python_error();
}

/// Keeps the array alive for as long as somebody has a view, a NumPy array or a capsule of it.
struct Keep {
  explicit Keep(std::shared_ptr<const void> array) : memory(std::move(array)) {}
  ~Keep() {
    if (runtime_has_ended()) keep_for_ever(std::move(memory));
  }
  Keep(const Keep&) = delete;
  Keep& operator=(const Keep&) = delete;
  std::shared_ptr<const void> memory;
};

nb::dlpack::dtype type_of(const FieldView& view) {
  switch (view.type) {
    case FieldView::Type::float32:
      return nb::dtype<float>();
    case FieldView::Type::float64:
      return nb::dtype<double>();
    case FieldView::Type::int64:
      return nb::dtype<std::int64_t>();
    case FieldView::Type::uint8:
      return nb::dtype<std::uint8_t>();
  }
  std::abort();
}

const char* type_name(const FieldView& view) {
  switch (view.type) {
    case FieldView::Type::float32:
      return "float32";
    case FieldView::Type::float64:
      return "float64";
    case FieldView::Type::int64:
      return "int64";
    case FieldView::Type::uint8:
      return "uint8";
  }
  std::abort();
}

nb::tuple shape_of(const FieldView& view) {
  return view.columns == 1 ? nb::make_tuple(view.rows) : nb::make_tuple(view.rows, view.columns);
}

template <class Array>
Array array_of(const FieldView& view) {
  const nb::dlpack::dtype type = type_of(view);
  const std::size_t shape[2] = {static_cast<std::size_t>(view.rows), static_cast<std::size_t>(view.columns)};
  const std::int64_t strides[2] = {view.row_bytes / (type.bits / 8), 1};
  using Memory = std::shared_ptr<const void>;
  nb::capsule owner(new Memory(view.memory), [](void* memory) noexcept { delete static_cast<Memory*>(memory); });
  const bool host = view.where == FieldView::Memory::host;
  return Array(const_cast<void*>(view.data), view.columns == 1 ? 1 : 2, shape, owner, strides, type,
               host ? nb::device::cpu::value : nb::device::cuda::value, 0);
}

/// The array itself, as NumPy's; only of one on a host.
nb::object array(const Field& field) {
  require_current(field);
  return nb::cast(array_of<nb::ndarray<nb::numpy, nb::ro>>(field.view));
}

/// A NumPy array of its own.
nb::object copy(const Field& field) {
  require_runtime();
  require_current(field);
  const FieldView& view = field.view;
  const nb::dlpack::dtype type = type_of(view);
  const std::size_t shape[2] = {static_cast<std::size_t>(view.rows), static_cast<std::size_t>(view.columns)};
  auto* bytes = new std::byte[std::max<std::size_t>(shape[0] * shape[1] * (type.bits / 8), 1)];
  nb::capsule owner(bytes, [](void* p) noexcept { delete[] static_cast<std::byte*>(p); });
  copy_to_host(view, bytes);
  return nb::cast(nb::ndarray<nb::numpy>(bytes, view.columns == 1 ? 1 : 2, shape, owner, nullptr, type));
}

/// An object with __dlpack__. The first version of DLPack, which all libraries read, knows no read-only memory.
nb::object exchange(const Field& field, bool read_only) {
  require_current(field);
  if (read_only) return nb::cast(array_of<nb::ndarray<nb::array_api, nb::ro>>(field.view));
  return nb::cast(array_of<nb::ndarray<nb::array_api>>(field.view));
}

}  // namespace

nb::object to_python(FieldView view, std::shared_ptr<const std::uint64_t> now) {
  const auto keep = std::make_shared<const Keep>(std::move(view.memory));
  view.memory = std::shared_ptr<const void>(keep, keep->memory.get());
  return nb::cast(Field{std::move(view), std::move(now)});
}

void bind_fields(nb::module_& m) {
  stale_view = PyErr_NewExceptionWithDoc("drench._core.StaleView", "A view of a field from before the run's last step.",
                                         m.attr("Error").ptr(), nullptr);
  if (stale_view == nullptr) throw nb::python_error();
  m.attr("StaleView") = nb::handle(stale_view);
  nb::class_<Field>(m, "Field", "A field of the backend as it lies in memory.")
      .def_prop_ro("name", [](const Field& f) { return f.view.name; })
      .def_prop_ro("unit", [](const Field& f) { return f.view.unit; })
      .def_prop_ro("shape", [](const Field& f) { return shape_of(f.view); })
      .def_prop_ro("dtype_name", [](const Field& f) { return type_name(f.view); })
      .def_prop_ro("memory", [](const Field& f) { return f.view.where == FieldView::Memory::host ? "host" : "cuda"; })
      .def_prop_ro("address", [](const Field& f) { return reinterpret_cast<std::uintptr_t>(f.view.data); })
      .def_prop_ro("generation", [](const Field& f) { return f.view.generation; })
      .def_prop_ro("current", &Field::current)
      .def("array", &array, nb::sig("def array(self) -> numpy.typing.NDArray[typing.Any]"))
      .def("copy", &copy, nb::sig("def copy(self) -> numpy.typing.NDArray[typing.Any]"))
      .def("exchange", &exchange, nb::arg("read_only"), nb::sig("def exchange(self, read_only: bool) -> typing.Any"))
      .def("require_current", &require_current);
}

}  // namespace drench::python
