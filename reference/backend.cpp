// The serial reference behind the Backend interface.

#include <algorithm>
#include <stdexcept>

#include "reference.hpp"

namespace drench {
namespace reference {
namespace {

class ReferenceBackend : public Backend {
 public:
  explicit ReferenceBackend(const Model& model) : state_(model) {}

  std::string name() const override { return "reference"; }
  std::string description() const override { return "serial reference, one CPU thread, double precision"; }

  void upload(const HostState& state) override { state_.s = state; }

  void run(Stage stage, const StepInfo& info, StepReport& report) override {
    switch (stage) {
#define DRENCH_REFERENCE_RUN(name, when)   \
  case Stage::name:                        \
    reference::name(state_, info, report); \
    return;
      DRENCH_STAGES(DRENCH_REFERENCE_RUN)
#undef DRENCH_REFERENCE_RUN
    }
    throw std::runtime_error("reference: no such stage");
  }

  void fence() override {}
  HostState download() const override { return state_.s; }
  void keep() override { kept_ = state_.s; }
  void go_back() override { state_.s = kept_; }

  std::vector<std::pair<Index, Index>> neighbor_pairs(const std::string& list) const override {
    const NeighborLists& rows = list_named(list);
    std::vector<std::pair<Index, Index>> pairs;
    for (std::size_t a = 0; a < rows.size(); ++a) {
      for (const Index b : rows[a]) pairs.emplace_back(static_cast<Index>(a), b);
    }
    std::ranges::sort(pairs);
    return pairs;
  }

 private:
  const NeighborLists& list_named(const std::string& list) const {
    if (list == "fluid_fluid") return state_.fluid_fluid;
    if (list == "fluid_boundary") return state_.fluid_boundary;
    if (list == "fluid_sample") return state_.fluid_sample;
    if (list == "sample_fluid") return state_.sample_fluid;
    if (list == "sample_sample") return state_.sample_sample;
    if (list == "sample_boundary") return state_.sample_boundary;
    throw std::runtime_error("neighbor_pairs: no list is called '" + list + "'");
  }

  ReferenceState state_;
  HostState kept_;
};

}  // namespace
}  // namespace reference

std::unique_ptr<Backend> make_reference_backend(const Model& model) {
  return std::make_unique<reference::ReferenceBackend>(model);
}

}  // namespace drench
