#pragma once
// Cloth that does not move, without liquid particles, in which liquid spreads: runs that are looked at after every
// step.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "validation.hpp"

namespace drench::test {

/// The accounts of several runs: quanta lost or out of nothing, nodes outside [0, s_max] at any step.
struct Books {
  Quanta lost = 0, unsupplied = 0;
  std::int64_t outside = 0;
  void print(const std::string& runs) const {
    report({runs + ": mass budget error", "0", static_cast<double>(lost), 0, "quanta"});
    report({runs + ": liquid gained minus liquid supplied", "0", static_cast<double>(unsupplied), 0, "quanta"});
    report({runs + ": nodes outside [0, s_max], all steps", "0", static_cast<double>(outside), 0});
  }
};

/// A run that is looked at after every step: is anything lost, and does any node leave [0, s_max]?
class Watched {
 public:
  Watched(const std::string& yaml, Books& books) : run_(yaml), books_(books) { begin(run_.initial()); }
  const Model& model() const { return run_.model(); }
  const Vec3& place(std::size_t n) const { return model().mesh.rest_position[n]; }
  std::size_t nodes() const { return model().mesh.rest_position.size(); }
  double capacity(std::size_t n) const { return model().samples.node_capacity[n]; }
  double saturation(std::size_t n) const { return kilograms(model(), state_.node_liquid[n]) / capacity(n); }
  void start_from(const std::function<double(const Vec3&)>& saturation) {
    HostState s = run_.initial();
    for (std::size_t n = 0; n < nodes(); ++n)
      s.node_liquid[n] = std::llround(saturation(place(n)) * capacity(n) / model().quantum);
    run_.restart(s);
    begin(s);
  }
  void steps(int count) {
    for (int k = 0; k < count; ++k) {
      const StepReport r = run_.step();
      state_ = run_.state();
      books_.lost = std::max(books_.lost, std::abs(r.mass_total() - total_));
      Quanta on_cloth = 0;
      for (std::size_t n = 0; n < nodes(); ++n) {
        const auto& cloth = model().material_of_node(static_cast<Index>(n));
        const double most = std::floor(cloth.max_saturation * capacity(n) / model().quantum);
        const Quanta m = state_.node_liquid[n];
        books_.outside += m < 0 || static_cast<double>(m) > most ? 1 : 0;
        on_cloth += m;
      }
      books_.unsupplied =
          std::max(books_.unsupplied, std::abs((on_cloth - at_start_) - (state_.supplied - supplied_at_start_)));
      substeps_ = std::max(substeps_, r.diffusion_substeps);
    }
  }
  double supplied() const { return kilograms(model(), state_.supplied); }
  int substeps() const { return substeps_; }

 private:
  SceneRun run_;
  HostState state_;
  Books& books_;
  Quanta total_ = 0, at_start_ = 0, supplied_at_start_ = 0;
  int substeps_ = 0;

  void begin(const HostState& s) {
    state_ = s;
    at_start_ = 0;
    for (const Quanta m : s.node_liquid) at_start_ += m;
    supplied_at_start_ = s.supplied;
    total_ = at_start_ + s.drained - s.supplied;
  }
};

inline std::string still_cloth(const std::string& mesh, double step, const std::string& porous,
                               const std::string& more = "", const std::string& top = "gravity: [0, 0, 0]") {
  return fmt::format(
      "drench: 1\ntime: {{step: {}, end: 1000}}\n{}\ncloth:\n  - mesh: {}\n    dynamics: false\n{}    porous: {{{}}}\n",
      step, top, mesh, more, porous);
}

}  // namespace drench::test
