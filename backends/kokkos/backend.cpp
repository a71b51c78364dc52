// The Kokkos backend behind the pipeline's interface.

#include <Kokkos_Profiling_ScopedRegion.hpp>
#include <algorithm>
#include <stdexcept>

#include "device.hpp"
#include "device_copy.hpp"
#include "pipeline/runtime.hpp"
#include "primitives/neighbor_list.hpp"

namespace drench {
namespace kokkos_backend {
namespace {

class KokkosBackend final : public Backend {
 public:
  explicit KokkosBackend(const Model& model) : device_(model) {}
  std::string name() const override { return "kokkos"; }
  std::string description() const override { return runtime_description(); }
  void upload(const HostState& state) override { device_.upload(state); }
  void fence() override { Kokkos::fence("drench::pipeline::timer"); }
  HostState download() const override { return device_.download(); }

  void run(Stage stage, const StepInfo& info, StepReport& report) override {
    Kokkos::Profiling::ScopedRegion region(std::string("drench::") + std::string(name_of(stage)));
    switch (stage) {
#define DRENCH_RUN_STAGE(stage_name, when)             \
  case Stage::stage_name:                              \
    kokkos_backend::stage_name(device_, info, report); \
    break;
      DRENCH_STAGES(DRENCH_RUN_STAGE)
#undef DRENCH_RUN_STAGE
    }
  }

  std::vector<std::pair<Index, Index>> neighbor_pairs(const std::string& list) const override {
    const NeighborList& l = list == "fluid_fluid"       ? device_.fluid_fluid
                            : list == "fluid_boundary"  ? device_.fluid_boundary
                            : list == "fluid_sample"    ? device_.fluid_sample
                            : list == "sample_fluid"    ? device_.sample_fluid
                            : list == "sample_sample"   ? device_.sample_sample
                            : list == "sample_boundary" ? device_.sample_boundary
                                                        : throw std::runtime_error("no neighbour list " + list);
    std::vector<std::pair<Index, Index>> pairs;
    const bool from_liquid = list.starts_with("fluid_"), to_liquid = list.ends_with("_fluid");
    const std::vector<Index> rank = liquid_ranks();
    const auto named = [&](Index i, bool liquid) { return liquid ? rank[static_cast<std::size_t>(i)] : i; };
    const std::vector<std::vector<Index>> rows = rows_on_host(l);
    for (Index i = 0; i < l.rows; ++i)
      for (const Index j : rows[static_cast<std::size_t>(i)])
        pairs.emplace_back(named(i, from_liquid), named(j, to_liquid));
    return pairs;
  }

 private:
  /// The place of each liquid particle in a HostState.
  std::vector<Index> liquid_ranks() const {
    const std::vector<Index> place = by_id(to_host<std::int64_t>(device_.fluid.id, device_.fluid.count));
    std::vector<Index> rank(place.size());
    for (std::size_t k = 0; k < place.size(); ++k) rank[static_cast<std::size_t>(place[k])] = static_cast<Index>(k);
    return rank;
  }

  Device device_;
};

}  // namespace
}  // namespace kokkos_backend

std::unique_ptr<Backend> make_kokkos_backend(const Model& model) {
  return std::make_unique<kokkos_backend::KokkosBackend>(model);
}

}  // namespace drench
