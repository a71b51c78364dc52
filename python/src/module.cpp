// drench._core: the library of src/drench for Python. python/drench/__init__.py makes it pleasant.

#include "module.hpp"

NB_MODULE(_core, m) {
  nanobind::set_leak_warnings(false);  // a run that a notebook still has when Python ends is no leak
  m.doc() = "The compiled part of drench. Use the package drench.";
  drench::python::bind_errors(m);
  drench::python::bind_runtime(m);
  drench::python::bind_scene(m);
  drench::python::bind_fields(m);
  drench::python::bind_run(m);
}
