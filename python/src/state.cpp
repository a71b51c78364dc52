// The state of a run as a dict of arrays, and back.

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstring>
#include <stdexcept>
#include <type_traits>

#include "module.hpp"

namespace drench::python {
namespace {

/// Calls visit(name, number) for what a state has beside its arrays.
template <class State, class Visitor>
void visit_numbers(State& s, Visitor&& visit) {
  visit("drained", s.drained);
  visit("supplied", s.supplied);
  visit("evaporated", s.evaporated);
  visit("solute_drained", s.solute_drained);
  visit("solute_supplied", s.solute_supplied);
  visit("solute_deposited", s.solute_deposited);
  visit("next_id", s.next_id);
  visit("step", s.step);
  visit("time", s.time);
  visit("collapsing", s.collapsing);
  visit("uptake_rate", s.uptake_rate);
  visit("divergence_start", s.divergence_start);
  visit("density_start", s.density_start);
  visit("next_step", s.next_step);
}

template <class T>
struct Entry {
  using Number = T;
  static constexpr std::size_t columns = 1;
};
template <class T, std::size_t n>
struct Entry<std::array<T, n>> {
  using Number = T;
  static constexpr std::size_t columns = n;
};

template <class T>
void take_array(const nb::dict& from, const char* name, std::vector<T>& to) {
  using Number = typename Entry<T>::Number;
  constexpr std::size_t columns = Entry<T>::columns;
  if (!from.contains(name)) {
    to.clear();
    return;
  }
  nb::ndarray<const Number, nb::c_contig, nb::device::cpu> array;
  const bool fits = nb::try_cast(from[name], array, false) && array.ndim() == (columns == 1 ? 1 : 2) &&
                    (columns == 1 || array.shape(1) == columns);
  if (!fits)
    throw nb::value_error((std::string(name) + ": needs a contiguous NumPy array like that of state()").c_str());
  to.resize(array.shape(0));
  if (!to.empty()) std::memcpy(to.data(), array.data(), to.size() * sizeof(T));
}

}  // namespace

nb::dict to_dict(HostState&& state) {
  nb::dict d;
  visit_fields(state, [&](std::string_view name, auto& values) {
    d[nb::str(name.data(), name.size())] = owned(std::move(values));
  });
  visit_numbers(state, [&](const char* name, auto number) { d[name] = number; });
  d["jet_particles"] = owned(std::move(state.jet_particles));
  return d;
}

HostState to_state(const nb::dict& from) {
  HostState state;
  visit_fields(state,
               [&](std::string_view name, auto& values) { take_array(from, std::string(name).c_str(), values); });
  visit_numbers(state, [&](const char* name, auto& number) {
    if (!from.contains(name)) throw nb::value_error((std::string(name) + ": is missing in the state").c_str());
    number = nb::cast<std::remove_reference_t<decltype(number)>>(from[name]);
  });
  take_array(from, "jet_particles", state.jet_particles);
  return state;
}

}  // namespace drench::python
