// Start and end of the backend's runtime within Python.

#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/version.hpp"
#include "module.hpp"

namespace drench::python {
namespace {

BackendRuntime* runtime = nullptr;
std::atomic<bool> ended{false};
std::atomic<int> runs_computing{0};
pid_t owner = 0;

/// A process that was forked has no threads of the runtime, which it would wait for.
void end_runtime() {
  ended = true;
  if (getpid() != owner) return;
  delete runtime;
  runtime = nullptr;
}

int started_threads(int threads) {
  if (threads < 1) throw nb::value_error("threads: allowed: 1 or more");
  start_runtime(threads);
  share_loops(threads);
  return loop_threads();
}

nb::dict info() {
  start_runtime();
  nb::dict d;
  d["version"] = std::string(version_string);
  d["commit"] = std::string(git_commit);
  d["precision"] = std::string(precision_name);
  const std::string text = runtime_description();
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size()), colon = text.find(": ", at);
    if (colon < end) d[text.substr(at, colon - at).c_str()] = text.substr(colon + 2, end - colon - 2);
    at = end + 1;
  }
  return d;
}

}  // namespace

void start_runtime(int threads) {
  require_runtime();
  if (runtime != nullptr) return;
  runtime = new BackendRuntime(threads, true);
  owner = getpid();
}

bool runtime_has_ended() { return ended; }

void keep_for_ever(std::shared_ptr<const void> memory) {
  static auto& kept = *new std::vector<std::shared_ptr<const void>>;  // no destructor: it would free them
  kept.push_back(std::move(memory));
}

Computing::Computing(int runs) : runs_(runs) {
  const int before = runs_computing.fetch_add(runs_);
  if (before > 0) loops_.emplace(std::max(1, shared_loops() * runs_ / (before + runs_)));
}

Computing::~Computing() { runs_computing -= runs_; }

void require_runtime() {
  if (ended) throw std::runtime_error("Python is exiting: drench computes no more");
}

void bind_runtime(nb::module_& m) {
  m.attr("__version__") = std::string(version_string);
  m.attr("quanta_per_particle") = quanta_per_particle;
  m.attr("precision") = std::string(precision_name);
  m.def("info", &info, "Version, commit, precision, backend, device, memory, threads and Kokkos' version, as strings.");
  m.def("set_threads", &started_threads, nb::arg("threads"),
        "How many threads share the loops from now on: at most as many as the first call, or the first run, started. "
        "Returns "
        "that number. Results do not depend on it.");
  nb::module_::import_("atexit").attr("register")(nb::cpp_function(&end_runtime));
}

}  // namespace drench::python
